"""α and β from the discretised full rod, against the theory with fifty digits and its own spectrum."""

from dataclasses import replace

import numpy as np
import pytest

from rodwnl.coefficients import landau
from rodwnl.errors import ComputationError
from rodwnl.normalform import DiscreteRod, NormalForm, normal_form
from rodwnl.parameters import RodParameters
from rodwnl.strainform import follower, integrals, mass

# The closed-form theory (modes, corrections and g1…g4 as sums of exponentials) evaluated with 50 digits for
# γ1 = 1/2: k1, k2, γ3 -> F_c, ω_c, α, β. The rods are those of tab:parameters.
THEORY = {
    (1e4, 1e4, 1e-4): (37.655980545271067, 191.20920923124324,
        -971.75838247754807 + 29.070793841884010j, 7.3473106429252645 + 5.3618056412782266j),
    (1e4, 1e2, 1e-2): (27.427194126759281, 113.54760786498526,
        -466.06795099003089 + 57.450368575353185j, 6.9268355639690713 + 4.1293081891661242j),
    (200.0, 1e4, 1e-4): (49.758004916191500, 334.32146573770339,
        -2183.5610531835637 + 252.07427671518823j, 6.5967475565675327 + 9.1561669213649004j),
}  # fmt: skip
UPPER = (200.0, 1e4, 1e-4), (155.60015929879067, 3367.2809575968312,
    328900.63038756558 - 307479.08049950981j, -64.594629859758264 + 88.257513010602105j)  # fmt: skip
POINTS = [*THEORY.items(), UPPER]
TOLERANCE = 1e-10  # what is found is below 1e-12; a wrong factor anywhere is of order one


def find(rod, point, degree=32) -> NormalForm:
    return normal_form(follower(*rod), round(point[0], 2), round(point[1], 2), degree)


@pytest.mark.parametrize(("rod", "point"), POINTS)
@pytest.mark.parametrize("degree", [22, 32, 48])
def test_the_expansion_is_confirmed(rod, point, degree):
    found = find(rod, point, degree)
    assert found.force == pytest.approx(point[0], rel=TOLERANCE)
    assert found.omega == pytest.approx(point[1], rel=TOLERANCE)
    assert abs(found.alpha / point[2] - 1) < TOLERANCE
    assert abs(found.beta / point[3] - 1) < TOLERANCE
    assert found.residual < 1e-14
    assert found.tail < 1e-12


@pytest.mark.parametrize("seed", range(4))
def test_rods_that_are_in_no_table(seed):
    """Random stiffnesses up to 2e5 and drags: the expansion against the discretised rod."""
    rng = np.random.default_rng(seed)
    k1, k2 = 10 ** rng.uniform(2.0, 5.3, 2)
    rod = RodParameters(float(k1), float(k2), float(10 ** rng.uniform(-5, -0.5)), float(rng.uniform(0.2, 2)))
    found = landau(rod)
    assert len(found) > 0
    for c in found:
        form = normal_form(follower(*rod.floats()), c.force * 1.001, c.omega * 0.999, 40)
        assert form.force == pytest.approx(c.force, rel=TOLERANCE)
        assert abs(form.alpha / c.alpha - 1) < TOLERANCE
        assert abs(form.beta / c.beta - 1) < TOLERANCE


def test_too_few_points_show_in_the_tail():
    rod, point = POINTS[0]
    coarse, fine = find(rod, point, 10), find(rod, point, 20)
    assert coarse.tail > 1e-6 > 1e-11 > fine.tail
    assert abs(coarse.alpha / point[2] - 1) > 1e-6


@pytest.mark.parametrize(("rod", "point"), POINTS)
def test_beta_is_the_slope_of_the_eigenvalue(rod, point):
    """dλ/dF by a centred difference of the spectrum, whose error falls fourfold with half the step."""
    form = find(rod, point)
    discrete = DiscreteRod(follower(*rod), 32)

    def eigenvalue(force: float) -> complex:
        L = discrete.jacobian(discrete.straight(force), force)
        lam = 1j * form.omega + form.beta * (force - form.force)
        q, p = form.mode, form.adjoint
        for _ in range(8):  # Rayleigh quotient iteration with both eigenvectors: cubic
            q = np.linalg.solve(L - lam * discrete.mass, discrete.mass @ q)
            p = np.linalg.solve((L - lam * discrete.mass).conj().T, discrete.mass.T @ p)
            q, p = q / np.abs(q).max(), p / np.abs(p).max()
            better = (p.conj() @ L @ q) / (p.conj() @ discrete.mass @ q)
            if abs(better - lam) <= 1e-14 * abs(lam):
                break
            lam = better
        return lam

    def error(step: float) -> float:
        slope = (eigenvalue(form.force + step) - eigenvalue(form.force - step)) / (2 * step)
        return abs(slope / form.beta - 1)

    step = 0.005 * form.force
    assert error(step) < 1e-3
    assert error(2 * step) / error(step) == pytest.approx(4, rel=0.05)


def test_the_mode_has_unit_tip_displacement_and_the_adjoint_is_dual():
    form = find(*POINTS[0])
    discrete = DiscreteRod(follower(*POINTS[0][0]), 32)
    assert discrete.tip_row(discrete.straight(form.force), form.force) @ form.mode == pytest.approx(1)
    assert form.adjoint.conj() @ discrete.mass @ form.mode == pytest.approx(1)
    assert max(np.abs(form.mode[:33]).max(), abs(form.mode[-3])) < 1e-30  # no stretch at first order


def test_coefficients_do_not_depend_on_the_phase_of_the_guess():
    rod, point = POINTS[1]
    one, other = find(rod, point), normal_form(follower(*rod), point[0] * 1.02, point[1] * 0.98)
    assert abs(one.alpha / other.alpha - 1) < 1e-11


def test_a_law_that_only_looks_different_gives_the_same_numbers():
    """A drag and an energy written with strain-dependent terms that cancel: the general code path."""
    k1, k2, gamma3 = POINTS[0][0]
    plain = follower(k1, k2, gamma3)
    disguised = replace(
        plain,
        drag=lambda h1, h2, pi: ((h1 * 0.5) / h1, (h1 * h1) ** 0.5 / h1, gamma3 * (1 + h2 - h2)),
        stress=lambda h1, h2, pi: (k1 * (h1**2 - 1) / (h1 + 1), k2 * h2, pi),
    )
    one, other = (normal_form(law, 37.66, 191.2) for law in (plain, disguised))
    assert abs(one.alpha / other.alpha - 1) < 1e-11
    assert abs(one.beta / other.beta - 1) < 1e-11


def test_no_hopf_point_is_said_so():
    with pytest.raises(ComputationError, match=r"no Hopf point found.*closer to the threshold"):
        normal_form(follower(1e4, 1e4, 1e-4), 0.5, 5e5)


@pytest.mark.parametrize("degree", [9, 32])
def test_integrals_are_exact_for_polynomials(degree):
    matrices, k = integrals(degree), degree
    u = matrices.nodes
    np.testing.assert_allclose(matrices.up @ u**k, u ** (k + 1) / (k + 1), atol=1e-15)
    np.testing.assert_allclose(matrices.down @ u**k, (1 - u ** (k + 1)) / (k + 1), atol=1e-15)
    np.testing.assert_allclose(matrices.whole @ u**k, 1 / (k + 1), rtol=1e-13)
    np.testing.assert_allclose(mass(degree) @ np.ones(degree + 1), u**2 / 2 - u, atol=1e-15)
