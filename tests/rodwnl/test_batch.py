import numpy as np
import pytest

from rodwnl import RodParameters, batch, landau, landau_batch
from rodwnl import batch_characteristic as closed
from rodwnl import batch_coefficients as coefficients
from rodwnl import batch_spectrum as spectrum
from rodwnl.batch import MOST, Status
from rodwnl.batch_problem import problem
from rodwnl.batch_rods import Rods
from rodwnl.characteristic import characteristic
from rodwnl.errors import InputError
from rodwnl.inverse import leading_eigenvalues, unstable_count
from rodwnl.quadrature import gauss_legendre

from .agreement import NUMBERS, assert_same_numbers


def rods(count, seed, top=6.0):
    """Rods over many decades: k1, k2, gamma3, gamma1, each (count,)."""
    rng = np.random.default_rng(seed)
    low = np.log10([20, 5, 10.0**-top, 0.05])
    high = np.array([top, top, 0, np.log10(2)])
    return tuple(10 ** (low + (high - low) * rng.random((count, 4))).T)


def batch_of(k1, k2, gamma3, gamma1=0.5, model="follower", **own):
    """Rods as the stages of the batch take them."""
    given = {"k1": k1, "k2": k2, "gamma3": gamma3, "gamma1": gamma1} | own
    arrays = np.broadcast_arrays(*map(np.atleast_1d, given.values()))
    return Rods(model, dict(zip(given, arrays, strict=True)))


def windows(count, seed):
    """Rods near and in the reentrant windows."""
    rng = np.random.default_rng(seed)
    k1, k2, gamma3 = (
        rng.uniform(80, 230, count),
        10 ** rng.uniform(2.5, 5, count),
        10 ** rng.uniform(-6, 0, count),
    )
    return k1, k2, gamma3, np.full(count, 0.5)


@pytest.mark.parametrize("sample", [rods(60, 1), rods(40, 2, top=8.0), windows(60, 3)])
def test_agrees_with_the_single_rod_route(sample):
    found = landau_batch(*sample)
    for i, parameters in enumerate(zip(*sample, strict=True)):
        expected = landau(RodParameters(*parameters))
        assert found.count[i] == len(expected), parameters
        assert found.status[i] == (Status.FOUND if len(expected) else Status.NONE) or found.status[i] == 2
        assert_same_numbers(found, i, expected, parameters)


def test_paper_rods():
    found = landau_batch([1e4, 1e4, 200], [1e4, 1e2, 1e4], [1e-4, 1e-2, 1e-4])
    assert found.count.tolist() == [1, 1, 2]
    assert found.force[:, 0] == pytest.approx([37.66, 27.43, 49.76], abs=0.006)
    assert found.force[2, 1] == pytest.approx(155.60, abs=0.006)
    assert found.omega[:, 0] == pytest.approx([191.21, 113.55, 334.32], abs=0.006)
    assert found.crossing[2].tolist() == [1, -1, 0, 0]


def test_broadcasting_and_padding():
    found = landau_batch(np.array([50, 200, 1e4])[:, None], np.array([1e3, 1e4]), 1e-4)
    assert found.status.shape == found.count.shape == (3, 2)
    assert found.force.shape == found.alpha.shape == (3, 2, MOST)
    assert found.count[:, 1].tolist() == [0, 2, 1]
    given = np.arange(MOST) < found.count[..., None]
    for name in (*NUMBERS, "residual", "error"):
        assert np.array_equal(np.isfinite(getattr(found, name)), given)
    assert np.array_equal(found.crossing != 0, given)
    one = landau_batch(200, 1e4, 1e-4)
    assert (one.status.shape, one.force.shape, int(one.count)) == ((), (MOST,), 2)
    assert landau_batch([], 1.0, 1.0).force.shape == (0, MOST)


def test_a_rod_does_not_depend_on_its_neighbours():
    sample = rods(40, 4)
    together, order = landau_batch(*sample), np.random.default_rng(0).permutation(40)
    shuffled = landau_batch(*(p[order] for p in sample))
    assert np.array_equal(together.count[order], shuffled.count)
    for name in NUMBERS:
        np.testing.assert_allclose(getattr(together, name)[order], getattr(shuffled, name), rtol=1e-12)


def test_bad_rods_fail_alone():
    found = landau_batch([1e4, -1, np.nan, 1e4], 1e4, 1e-4, [0.5, 0.5, 0.5, np.inf])
    assert found.status.tolist() == [Status.FOUND, Status.FAILED, Status.FAILED, Status.FAILED]
    assert sorted(found.reasons) == [1, 2, 3]
    assert all("finite and positive" in why for why in found.reasons.values())
    assert found.force[0, 0] == pytest.approx(37.656, abs=1e-3)


@pytest.mark.parametrize(
    "extreme", [(1e300, 1e300, 1e-300), (1e-300, 1.0, 1.0), (1e12, 1e12, 1e12), (1.0, 1e-8, 1.0)]
)
def test_extreme_rods_end_with_a_status(extreme):
    found = landau_batch(*extreme)
    if found.status == Status.FAILED:
        assert found.reasons[0]
    assert np.array_equal(np.isfinite(found.force), np.arange(MOST) < found.count)


def test_bad_arguments():
    with pytest.raises(InputError, match="must be arrays of real numbers that broadcast"):
        landau_batch([1, 2], [1, 2, 3], 1)
    with pytest.raises(InputError, match="must be arrays of real numbers"):
        landau_batch("a", 1, 1)
    for bad in (0, -1, np.inf, np.nan):
        with pytest.raises(InputError, match="max_force is"):
            landau_batch(1, 1, 1, max_force=bad)


def test_rods_that_float64_cannot_settle_are_escalated(monkeypatch):
    plain = landau_batch(200, 1e4, 1e-4)
    monkeypatch.setattr(batch, "ACCURACY", 1e-17)
    found = landau_batch([200, 50], 1e4, 1e-4)
    assert found.status.tolist() == [Status.ESCALATED, Status.NONE]
    for name in (*NUMBERS, "crossing"):
        np.testing.assert_allclose(getattr(found, name)[0], getattr(plain, name), rtol=1e-10)


@pytest.mark.parametrize("accuracy", [1e-9, 1e-17])  # together, or by itself
def test_of_many_thresholds_the_first_are_given(monkeypatch, accuracy):
    both = landau_batch(200, 1e4, 1e-4)
    monkeypatch.setattr(batch, "MOST", 1)
    monkeypatch.setattr(batch, "ACCURACY", accuracy)
    found = landau_batch([200, 1e4], 1e4, 1e-4)
    assert found.status[0] == Status.MORE
    assert found.status[1] != Status.MORE
    assert found.count.tolist() == [1, 1]
    for name in NUMBERS:
        np.testing.assert_allclose(getattr(found, name)[0], getattr(both, name)[:1], rtol=1e-10)


def test_coefficients_that_cancel_are_made_exact_one_by_one():
    """Of both thresholds of this rod only the first one's coefficients cancel so far."""
    from rodwnl.exact import exact_threshold

    rod = (108.6898559, 429919.23948148, 0.35419229)
    found = landau_batch(*rod)
    assert found.status == Status.ESCALATED
    assert found.count == 2
    for i in range(2):
        exact = exact_threshold(RodParameters(*rod), found.force[i], found.omega[i], 15)
        for name in ("alpha", "beta"):
            assert getattr(found, name)[i] == pytest.approx(complex(getattr(exact, name)), rel=1e-9)
    assert (found.error < 1e-15).tolist()[:2] == [True, False]


def test_refusals_of_the_exact_route_are_reasons(monkeypatch):
    from rodwnl import spectrum as single

    def refuse(*_):
        raise batch.ComputationError("it is beyond me")

    monkeypatch.setattr(batch, "ACCURACY", 1e-17)
    monkeypatch.setattr(single, "hopf_thresholds", refuse)
    found = landau_batch([200, 1e4], 1e4, 1e-4)
    assert found.reasons == {0: "it is beyond me", 1: "it is beyond me"}
    assert not found.count.any()
    assert np.isnan(found.force).all()


def test_chunks_are_put_together(monkeypatch):
    sample = rods(50, 5)
    sample[0][[7, 33]] = -1
    whole = landau_batch(*sample)
    monkeypatch.setattr(batch, "CHUNK", 8)
    parts = landau_batch(*sample)
    assert np.array_equal(whole.status, parts.status)
    assert parts.reasons.keys() == {7, 33}
    for name in NUMBERS:
        np.testing.assert_allclose(getattr(whole, name), getattr(parts, name), rtol=1e-12)


def test_max_force_bounds_the_search():
    assert landau_batch(200, 1e4, 1e-4, max_force=100).count == 1
    assert landau_batch(200, 1e4, 1e-4, max_force=40).count == 0
    assert landau_batch(1e4, 1e4, 1e-4, max_force=37.6).status == Status.NONE


# ---- the window that closes, k2 = 1e4, gamma3 = 1e-4

CLOSING = 147.9215196831997


def test_narrow_windows_are_found():
    distance = np.array([1e-3, 1e-5, 1e-7, 1e-9])
    inside = landau_batch(CLOSING * (1 + distance), 1e4, 1e-4)
    outside = landau_batch(CLOSING * (1 - distance), 1e4, 1e-4)
    assert inside.count.tolist() == [2] * 4
    assert outside.count.tolist() == [0] * 4
    # two thresholds that meet at a turning point: their distance goes with the square root
    width = (inside.force[:, 1] - inside.force[:, 0]) / np.sqrt(distance)
    assert width == pytest.approx(np.full(4, width[1]), rel=2e-3)


# ---- the characteristic function


def test_closed_form_is_the_determinant():
    k1, k2, gamma3, _ = rods(30, 6)
    rng = np.random.default_rng(6)
    force = np.minimum(k1, 400) * rng.random(30)
    straight = batch_of(k1, k2, gamma3).at(force)
    lam = force * (rng.normal(size=(2, 30)) + 1j * rng.uniform(1, 10, (2, 30)))
    ratios = []
    for z in lam:
        D = closed.characteristic(problem(straight), z)
        value, growth, _ = np.array(
            [
                characteristic((a, b, c, 0.5), f, x)
                for a, b, c, f, x in zip(k1, k2, gamma3, force, z, strict=True)
            ]
        ).T
        r = closed.exponents(straight, z / 1j)
        ratios.append(D.scaled * np.exp(r.sum(axis=1) - growth) / value)
    # equal up to a factor that does not depend on λ, and is real
    np.testing.assert_allclose(ratios[0], ratios[1], rtol=1e-7)
    np.testing.assert_allclose(ratios[0].imag, 0, atol=1e-7 * np.abs(ratios[0]).max())


def test_jets_are_derivatives():
    k1, k2, gamma3, _ = rods(20, 7)
    force, lam = np.minimum(k1, 400) / 3, 50 + 300j * np.ones(20)
    names = ("k1", "k2", "gamma3")
    D, D_F, D_lam = closed.jet(closed.problem_with_slopes(batch_of(k1, k2, gamma3), force), lam)
    same, slopes = closed.gradient(batch_of(k1, k2, gamma3), names, force, lam)
    np.testing.assert_allclose(D, same, rtol=1e-12)
    np.testing.assert_allclose([D_F, D_lam], slopes[3:], rtol=1e-12)
    arguments = [k1, k2, gamma3, force, lam]
    for i, slope in enumerate(slopes):
        h = 1e-5 * arguments[i]
        ahead, back = ([a + s * h if j == i else a for j, a in enumerate(arguments)] for s in (1, -1))
        values = [
            closed.characteristic(problem(batch_of(*a[:3]).at(a[3])), a[4]).scaled for a in (ahead, back)
        ]
        np.testing.assert_allclose(
            slope * h, (values[0] - values[1]) / 2, atol=1e-7 * np.abs(D).max(), rtol=1e-5
        )


def test_eigenvalues_are_zeros():
    parameters = (200.0, 1e4, 1e-4, 0.5)
    forces = np.array([30.0, 60.0, 140.0])
    eigenvalues, slopes = leading_eigenvalues(parameters, forces)
    for force, lams, by_force in zip(forces, eigenvalues, slopes, strict=True):
        at = int(np.argmax(np.where(lams.imag > 0, lams.real, -np.inf)))
        one = batch_of(*parameters)
        D, D_F, D_lam = closed.jet(closed.problem_with_slopes(one, np.array([force])), lams[[at]])
        assert abs(D / D_lam) < 1e-9 * abs(lams[at])
        assert -D_F / D_lam == pytest.approx(by_force[at], rel=1e-6)
        guess = lams[[at]] * (1 + 1e-2)
        lam, slope = spectrum.follow(one, np.array([force]), guess)
        assert abs(lam - lams[at]) < spectrum.ROUGHLY * abs(lams[at].real)
        assert slope == pytest.approx(by_force[at], rel=0.1)


@pytest.mark.parametrize("top", [6.0, 8.0])
def test_unstable_pairs_are_counted(top):
    k1, k2, gamma3, gamma1 = rods(150, 8, top)
    force = np.minimum(k1, 400) * np.random.default_rng(8).random(150) ** 2
    found = spectrum.lines(batch_of(k1, k2, gamma3), np.arange(150), force)
    expected = [
        unstable_count((a, b, c, d), f) for a, b, c, d, f in zip(k1, k2, gamma3, gamma1, force, strict=True)
    ]
    few = np.array(expected) < 16  # the operator of the single-rod route resolves no more
    assert np.array_equal(found.unstable[few], np.array(expected)[few])
    assert np.all(found.unstable[~few] > 0)


# ---- the coefficients


def test_basis_diagonalises_the_double_integral():
    nodes, basis = gauss_legendre(28), coefficients.basis(28)
    T = nodes.from_clamp @ nodes.to_tip
    f = np.random.default_rng(0).normal(size=(3, 28))
    np.testing.assert_allclose(((f @ basis.forth) * basis.values) @ basis.back, f @ T.T, atol=1e-13)
    np.testing.assert_allclose(basis.forth @ basis.back, np.eye(28), atol=1e-12)
    np.testing.assert_allclose(f @ basis.to_tip, f @ nodes.to_tip.T, atol=1e-14)
    # the operator −d²/du² with f(0) = f'(1) = 0 has the eigenvalues ((n + 1/2) π)²
    assert 1 / basis.values[::-1][:5] == pytest.approx(((np.arange(5) + 0.5) * np.pi) ** 2, rel=1e-10)


def test_more_nodes_change_nothing(monkeypatch):
    sample = windows(30, 9)
    found = landau_batch(*sample)
    monkeypatch.setattr(coefficients, "FEWEST", coefficients.FEWEST + 24)
    finer = landau_batch(*sample)
    np.testing.assert_allclose(found.alpha, finer.alpha, rtol=1e-10)
    np.testing.assert_allclose(found.beta, finer.beta, rtol=1e-10)


def test_residuals_betray_what_is_not_a_threshold():
    """At a force that is not a threshold the conditions that were not used do not hold."""
    found = landau_batch(1e4, 1e4, 1e-4)
    parameters = batch_of(1e4, 1e4, 1e-4)
    force, omega = found.force[:1], found.omega[:1]
    assert coefficients.coefficients(parameters, force, omega).residual < 1e-12
    for off in ((1 + 1e-6, 1), (1, 1 + 1e-6)):
        assert coefficients.coefficients(parameters, off[0] * force, off[1] * omega).residual > 1e-9


def test_error_estimate_is_honest():
    """Against the exact route, on rods that cancel."""
    from rodwnl.exact import exact_threshold

    k1, k2, gamma3 = (115.0, 101.0, 6.4e3), (5.75e6, 3.84e6, 3.6e6), (0.87, 0.22, 0.0035)
    found = landau_batch(k1, k2, gamma3)
    for i, rod in enumerate(zip(k1, k2, gamma3, strict=True)):
        exact = exact_threshold(RodParameters(*rod), found.force[i, 0], found.omega[i, 0], 15)
        for name in ("alpha", "beta"):
            assert abs(getattr(found, name)[i, 0] / complex(getattr(exact, name)) - 1) <= found.error[i, 0]


def test_gaps_and_windows_close_to_k1():
    """Rods whose stable gap, or second window, is narrow and near the force k1 at which the rod is flat."""
    k1 = [165.34951550748093, 182.8583431295873, 309.3943027069801, 397.11815098511056]
    k2 = [1680.9567552055605, 1467.8135009911332, 4272.8994755357935, 9813.726525061104]
    gamma3 = [0.0010234584422398963, 1.529000673776797e-05, 4.094983114667667e-06, 0.0001281097434365363]
    found = landau_batch(k1, k2, gamma3)
    assert found.count.tolist() == [3, 3, 3, 4]
    for i, rod in enumerate(zip(k1, k2, gamma3, strict=True)):
        expected = [c.force for c in landau(RodParameters(*rod))]
        assert found.force[i, : len(expected)] == pytest.approx(expected, rel=1e-9)


def test_few_lines_see_what_many_see(monkeypatch):
    rng = np.random.default_rng(12)
    k1, gamma3 = rng.uniform(40, 420, 2000), 10 ** rng.uniform(-6, 0, 2000)
    k2 = k1**2 / 20 * 10 ** rng.uniform(-0.3, 0.3, 2000)
    few = landau_batch(k1, k2, gamma3)
    monkeypatch.setattr(spectrum, "FIRST_LINES", 33)
    many = landau_batch(k1, k2, gamma3)
    assert np.array_equal(few.count, many.count)
    np.testing.assert_allclose(few.force, many.force, rtol=1e-9)


def test_the_last_force_may_be_a_text():
    assert landau_batch(1e4, 1e4, 1e-4, max_force="40").count == 1
    with pytest.raises(InputError, match="max_force is 'x'"):
        landau_batch(1e4, 1e4, 1e-4, max_force="x")
