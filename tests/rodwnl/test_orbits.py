"""Periodic orbits of the full rod against the equations in x, y, θ, the theory at onset, and finer grids."""

from dataclasses import replace

import numpy as np
import pytest

from rodwnl import harmonicsolve
from rodwnl.collocation import discretise
from rodwnl.continuation import ConvergenceError, solve_at
from rodwnl.cycles import OrbitSystem
from rodwnl.errors import ComputationError
from rodwnl.floquet import half_period_map, multipliers
from rodwnl.halfperiod import half_period
from rodwnl.harmonicsolve import solved
from rodwnl.laws import metric_drag
from rodwnl.orbits import Cycle, Orbit, onset, orbit_at, suited
from rodwnl.strainform import RodLaw, follower

STIFF_VALUES = (1e4, 1e4, 1e-4, 0.5)
STIFF, SHEARED, SOFT = follower(*STIFF_VALUES), follower(1e4, 1e2, 1e-2), follower(200.0, 1e4, 1e-4)
# Near a Hopf point (F, ω), and α, β there from the closed-form theory with fifty digits.
HOPF = {
    "stiff": (STIFF, 37.66, 191.21,
        -971.75838247754807 + 29.070793841884010j, 7.3473106429252645 + 5.3618056412782266j),
    "sheared": (SHEARED, 27.43, 113.55,
        -466.06795099003089 + 57.450368575353185j, 6.9268355639690713 + 4.1293081891661242j),
    "lower": (SOFT, 49.76, 334.32,
        -2183.5610531835637 + 252.07427671518823j, 6.5967475565675327 + 9.1561669213649004j),
    "upper": (SOFT, 155.6, 3367.28,
        328900.63038756558 - 307479.08049950981j, -64.594629859758264 + 88.257513010602105j),
}  # fmt: skip


def guess(rod: RodLaw, hopf_force: float, omega: float, force: float) -> Cycle:
    """The branch's tangent at its Hopf point, taken to another force."""
    begin = onset(rod, hopf_force, omega)
    X = begin.point.X
    return Cycle(begin.system, X + begin.point.tangent * (force - X[-2]) / begin.point.tangent[-2])


@pytest.fixture(scope="module")
def orbit() -> Orbit:
    return orbit_at(guess(STIFF, 37.66, 191.21, 40.0), 40.0)


@pytest.mark.parametrize("count", [4, 10])
def test_time_derivatives_are_exact_for_the_harmonics_kept(count):
    time = half_period(count)
    elsewhere = np.linspace(0, 3, 7)
    for parity, k in (("odd", count - 1), ("even", count - 2), ("even", 0)):
        f = np.cos(k * time.phases + 0.3)
        np.testing.assert_allclose(
            time.derivative[parity] @ f, -k * np.sin(k * time.phases + 0.3), atol=1e-12
        )
        np.testing.assert_allclose(time.at(parity, elsewhere) @ f, np.cos(k * elsewhere + 0.3), atol=1e-13)
    with pytest.raises(ValueError, match="an even number of phases, not 5"):
        half_period(5)


@pytest.mark.parametrize("law", [STIFF, SHEARED, metric_drag(200.0, 1e4, 1e-4)])
@pytest.mark.parametrize("s", [0.3, 1e-5, -0.02])
def test_the_jacobian_is_the_derivative(law, s):
    """Also next to the Hopf point, where ∂s of the odd equations is another formula, and beyond it."""
    system = OrbitSystem(law, 4, 10, 40.0, 200.0)
    rng, step = np.random.default_rng(5), 1e-3

    def smooth(size: float, *last: float) -> np.ndarray:
        states = size * rng.standard_normal((4, system.rod.size))
        return np.append(states.ravel(), last)

    X, d = smooth(0.01, 200.0, 40.0, s), smooth(0.01, 20.0, 4.0, 0.1 * s)
    X[:-3].reshape(4, -1)[:, -3] += 0.8  # the stretch

    def difference(step: float, d: np.ndarray) -> np.ndarray:
        return (system.linearised(X + step * d)[0] - system.linearised(X - step * d)[0]) / (2 * step)

    def along(direction: np.ndarray) -> np.ndarray:
        return (4 * difference(step, direction) - difference(2 * step, direction)) / 3

    J = system.linearised(X)[1]
    np.testing.assert_allclose(along(d), J @ d, atol=1e-8 * np.abs(J @ d).max())
    last = np.eye(X.size)[-1]
    by_square = J @ last
    np.testing.assert_allclose(along(last), by_square, atol=1e-4 * np.abs(by_square).max())


@pytest.mark.parametrize("at_onset", [True, False])
def test_solving_by_harmonics_solves_the_whole_matrix(orbit, at_onset):
    """At the Hopf point, where iωE − L̄ is singular, and at an orbit with a tip angle of half a radian."""
    begin = onset(STIFF, 37.66, 191.21)
    system, X = (begin.system, begin.point.X) if at_onset else (orbit.cycle.system, orbit.cycle.X)
    row = np.eye(X.size)[-1 if at_onset else -2]
    J = system.linearised(X)[1]
    right = np.random.default_rng(3).standard_normal(X.size)
    whole = np.vstack([np.stack([J @ e for e in np.eye(X.size)], axis=1), row])
    x = J.bordered(row)(right)
    expected = np.linalg.solve(whole, right)
    np.testing.assert_allclose(x, expected, atol=1e-7 * np.abs(expected).max())


def test_linear_equations_that_gmres_cannot_solve_are_said_so(monkeypatch):
    monkeypatch.setattr(harmonicsolve, "MOST_STEPS", 8)
    A = np.diag(np.arange(1.0, 9.0)) + np.triu(np.ones((8, 8)), 1)
    b = np.ones(8)
    np.testing.assert_allclose(solved(lambda x: A @ x, lambda x: x, b), np.linalg.solve(A, b), rtol=1e-10)
    np.testing.assert_array_equal(solved(lambda x: A @ x, lambda x: x, 0 * b), 0 * b)
    cyclic = np.roll(np.eye(16), 1, axis=0)  # no progress before the last of 16 steps
    for right, said in ((np.eye(16)[0], "not solved in 8 steps"), (np.full(16, np.nan), "are singular")):
        with pytest.raises(ConvergenceError, match=said):
            solved(lambda x: cyclic @ x, lambda x: x, right)


@pytest.mark.parametrize("name", HOPF)
def test_the_branch_leaves_the_hopf_point_as_the_theory_says(name):
    """dA_tip²/dF = −4 Re β/Re α and dω/dF = Im β − Im α Re β/Re α, on either side of the threshold."""
    rod, force, omega, alpha, beta = HOPF[name]
    begin = onset(rod, force, omega, (6, 28))
    slope = begin.point.tangent / begin.point.tangent[-2]
    ratio = beta.real / alpha.real
    assert slope[-1] * begin.tip_per_angle**2 == pytest.approx(-4 * ratio, rel=1e-10)
    assert slope[-3] == pytest.approx(beta.imag - alpha.imag * ratio, rel=1e-10)


def test_theory_and_orbit_part_with_the_power_three_halves():
    rod, force, omega, alpha, beta = HOPF["stiff"]
    begin = onset(rod, force, omega)
    distances = np.array([0.05, 0.1, 0.2])
    gaps = []
    for distance in distances:
        at = begin.system.force_scale + distance
        theory = 2 * np.sqrt(-beta.real / alpha.real * distance)
        gaps.append(abs(orbit_at(guess(rod, force, omega, at), at).A_tip - theory))
    slope = np.polyfit(np.log(distances), np.log(gaps), 1)[0]
    assert slope == pytest.approx(1.5, abs=0.1)


def test_the_orbit_solves_the_equations_in_x_y_and_theta(orbit):
    """ω ∂q/∂τ = f(q) with the other formulation of the full rod, written without strains."""
    cycle, degree, step = orbit.cycle, 32, 1e-3
    rod = discretise(*STIFF_VALUES, 40.0, degree)
    phases = np.array([0.1, 0.9, 2.0])

    def state(shift: float) -> np.ndarray:
        return rod.state(*cycle.shape(phases + shift, rod.nodes))

    # fourth-order difference in the phase
    rate = (8 * (state(step) - state(-step)) - (state(2 * step) - state(-2 * step))) / (12 * step)
    f = rod.rhs(state(0.0)).reshape(3, 3, -1)
    found = (orbit.omega * rate).reshape(3, 3, -1)
    for field in range(3):
        scale = np.abs(f[:, field]).max()
        # the round-off of second derivatives of x, y, θ, times the stiffness
        np.testing.assert_allclose(found[:, field], f[:, field], atol=1e-5 * scale)


def test_half_a_period_later_the_shape_is_mirrored(orbit):
    phases = np.linspace(0, 3, 5)
    x, y, theta = orbit.cycle.shape(phases)
    x2, y2, theta2 = orbit.cycle.shape(phases + np.pi)
    np.testing.assert_allclose(x2, x, atol=1e-12)
    np.testing.assert_allclose(y2, -y, atol=1e-12)
    np.testing.assert_allclose(theta2, -theta, atol=1e-12)


def test_amplitude_and_harmonics_describe_the_tip(orbit):
    phases = 2 * np.pi * np.arange(2000) / 2000
    tip = orbit.cycle.shape(phases)[1][:, -1]
    assert (tip.max() - tip.min()) / 2 == pytest.approx(orbit.A_tip, rel=1e-5)
    for i, k in enumerate((1, 3, 5)):
        assert abs(np.exp(-1j * k * phases) @ tip) / 1000 == pytest.approx(orbit.harmonics[i], rel=1e-8)
    assert orbit.harmonics[0] > orbit.harmonics[1] > orbit.harmonics[2] > 0


def test_the_stated_error_holds_against_a_finer_grid(orbit):
    count, degree = orbit.cycle.system.count, orbit.cycle.system.degree
    finer = replace(orbit.cycle.system, count=count + 8, degree=degree + 8)
    fine = Cycle(finer, solve_at(finer, orbit.cycle.system.resampled(orbit.cycle.X, finer), -2, 40.0).X)
    assert orbit.error < 1e-9
    assert fine.tip_amplitude == pytest.approx(orbit.A_tip, rel=1e-9)
    assert fine.omega == pytest.approx(orbit.omega, rel=1e-9)
    assert orbit.residual < 1e-8
    assert max(suited(orbit.cycle)) <= max(count, degree)


def test_an_orbit_is_not_made_up_on_the_wrong_side():
    """Below a supercritical threshold the continued solution has a² < 0; it is not reported as an orbit."""
    with pytest.raises(ComputationError, match=r"no orbit of this branch at force 37.5.*a² = -0\.02"):
        orbit_at(guess(STIFF, 37.66, 191.21, 37.5), 37.5)


def test_the_radial_multiplier_starts_as_the_theory_says():
    """ρ² ≈ exp(−2 Re β ΔF · 2π/ω) on either kind of branch."""
    for name, distance in (("stiff", 0.01), ("upper", 0.02)):
        rod, force, omega, _, beta = HOPF[name]
        begin = onset(rod, force, omega)
        at = begin.system.force_scale + distance
        orbit = orbit_at(guess(rod, force, omega, at), at)
        expected = -2 * beta.real * distance * 2 * np.pi / orbit.omega
        assert np.log(orbit.multipliers[0].real) == pytest.approx(expected, rel=0.03)
        assert orbit.stable == (name == "stiff")


def test_multipliers_converge_with_order_five(orbit):
    errors = [multipliers(orbit.cycle, steps).error for steps in (12, 24)]
    assert np.log2(errors[0] / errors[1]) == pytest.approx(5, abs=0.3)


def test_multipliers_agree_with_the_other_formulation(orbit):
    """The same variational problem in x, y, θ by the implicit midpoint rule, whose error falls fourfold."""
    rod = discretise(*STIFF_VALUES, 40.0, 28)
    eye, mirror = np.eye(rod.size), np.repeat([1.0, -1.0, -1.0], rod.size // 3)[:, None]
    leading = multipliers(orbit.cycle, 48).half[0]

    def distance(steps: int) -> float:
        h = np.pi / steps
        middles = rod.state(*orbit.cycle.shape(h * (np.arange(steps) + 0.5), rod.nodes))
        carried = eye
        for A in rod.jacobian(middles) * (h / orbit.omega / 2):
            carried = np.linalg.solve(eye - A, carried + A @ carried)
        return float(np.min(np.abs(np.linalg.eigvals(mirror * carried) - leading)))

    assert distance(200) < 3e-5
    assert distance(100) / distance(200) == pytest.approx(4, rel=0.05)


def test_the_flow_is_what_the_map_carries(orbit):
    """The velocity along the orbit is the eigenvector of the half-period map with eigenvalue 1."""
    system, s = orbit.cycle.system, orbit.cycle.square
    states, *_ = system.unpack(orbit.cycle.X)
    time = half_period(system.count)
    velocity = np.where(
        system.odd, np.sqrt(s) * time.derivative["odd"][0] @ states, time.derivative["even"][0] @ states
    )
    carried = half_period_map(orbit.cycle, 32) @ velocity
    np.testing.assert_allclose(carried, velocity, atol=1e-6 * np.abs(velocity).max())
