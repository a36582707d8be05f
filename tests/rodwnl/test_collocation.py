"""The discretised full rod: the grid, the tip conditions, the right-hand side and its derivatives."""

import numpy as np
import pytest

from rodwnl.collocation import DiscreteRod, chebyshev, discretise
from rodwnl.strainform import follower, integrals, strains, velocities

RODS = [(1e4, 1e4, 1e-4, 37.66), (1e4, 1e2, 1e-2, 27.43), (200.0, 1e4, 1e-4, 155.6)]


def bent(rod: DiscreteRod, seed: int = 0) -> np.ndarray:
    """Three smooth states far from straight."""
    rng = np.random.default_rng(seed)
    a, b, c = 0.3 * rng.standard_normal((3, 3, 1))
    u = rod.nodes
    return rod.state(rod.nu * u + 0.1 * a * np.sin(2 * u), b * np.sin(1.3 * u), c * np.sin(1.1 * u))


@pytest.mark.parametrize("degree", [8, 24, 33])
def test_the_grid_differentiates_and_integrates_polynomials_exactly(degree):
    grid, k = chebyshev(degree), degree - 1
    u = grid.nodes
    assert u[0] == 0
    assert u[-1] == 1
    np.testing.assert_allclose(grid.first @ u**k, k * u ** (k - 1), atol=1e-15 * k**4)
    np.testing.assert_allclose(grid.second @ u**k, k * (k - 1) * u ** (k - 2), atol=1e-15 * k**5)
    np.testing.assert_allclose(grid.weights @ u**k, 1 / (k + 1), rtol=1e-13)
    np.testing.assert_allclose(grid.first @ np.ones(degree + 1), 0, atol=1e-16 * degree**3)


def test_derivatives_converge_like_the_smooth_function_they_act_on():
    def error(degree: int) -> float:
        grid = chebyshev(degree)
        return np.abs(grid.second @ np.sin(3 * grid.nodes) + 9 * np.sin(3 * grid.nodes)).max()

    errors = [error(degree) for degree in (8, 12, 16)]
    assert errors[0] > 1e3 * errors[1] > 1e6 * errors[2]


def test_a_grid_that_is_too_coarse_is_refused():
    with pytest.raises(ValueError, match="degree is 3; a Chebyshev grid"):
        chebyshev(3)


@pytest.mark.parametrize(("k1", "k2", "gamma3", "force"), RODS)
def test_the_straight_rod_rests_without_roundoff(k1, k2, gamma3, force):
    rod = discretise(k1, k2, gamma3, 0.5, force, 64)
    assert not rod.rhs(rod.straight()).any()
    x, y, theta = rod.tip(rod.straight())
    assert x == pytest.approx(1 - force / k1, rel=1e-14)
    assert y == theta == 0


@pytest.mark.parametrize(("k1", "k2", "gamma3", "force"), RODS)
def test_every_state_satisfies_the_conditions_at_clamp_and_tip(k1, k2, gamma3, force):
    rod = discretise(k1, k2, gamma3, 0.5, force, 24)
    x, y, theta = rod.fields(bent(rod))
    slope = chebyshev(24).first[-1]
    assert not x[:, 0].any()
    assert not y[:, 0].any()
    assert not theta[:, 0].any()
    np.testing.assert_allclose(x @ slope, rod.nu * np.cos(theta[:, -1]), atol=1e-12)
    np.testing.assert_allclose(y @ slope, rod.nu * np.sin(theta[:, -1]), atol=1e-12)
    np.testing.assert_allclose(theta @ slope, 0, atol=1e-12)


@pytest.mark.parametrize(("k1", "k2", "gamma3", "force"), RODS)
def test_the_jacobian_is_the_derivative(k1, k2, gamma3, force):
    """Central differences, whose error falls fourfold when the step is halved."""
    rod = discretise(k1, k2, gamma3, 0.5, force, 16)
    q = bent(rod)
    u = rod.nodes
    d = rod.state(np.sin(u), np.cos(2 * u) - 1, u * u)
    exact = rod.jacobian(q) @ d

    def error(step: float) -> float:
        difference = (rod.rhs(q + step * d) - rod.rhs(q - step * d)) / (2 * step)
        return np.abs(difference - exact).max() / np.abs(exact).max()

    assert error(1e-3) < 1e-3
    assert error(2e-2) / error(1e-2) == pytest.approx(4, rel=0.02)


@pytest.mark.parametrize(("k1", "k2", "gamma3", "force"), RODS)
def test_the_force_derivative_is_the_derivative(k1, k2, gamma3, force):
    """f is a polynomial of second degree in ν at fixed q: a central difference is exact at any step."""
    rod = discretise(k1, k2, gamma3, 0.5, force, 16)
    q = bent(rod)
    step = 0.2 * force
    difference = (rod.at_force(force + step).rhs(q) - rod.at_force(force - step).rhs(q)) / (2 * step)
    scale = np.abs(difference).max()
    np.testing.assert_allclose(rod.force_derivative(q), difference, atol=1e-9 * scale)


def test_many_states_at_once_give_what_each_gives():
    rod = discretise(1e4, 1e2, 1e-2, 0.5, 30.0, 16)
    q = bent(rod)
    for each in range(3):
        np.testing.assert_allclose(rod.rhs(q)[each], rod.rhs(q[each]), rtol=1e-12)
        np.testing.assert_allclose(rod.jacobian(q)[each], rod.jacobian(q[each]), rtol=1e-12, atol=1e-9)
        np.testing.assert_allclose(rod.tip(q)[1][each], rod.tip(q[each])[1], rtol=1e-14)


@pytest.mark.parametrize(("k1", "k2", "gamma3", "force"), RODS)
def test_two_formulations_of_the_exact_rod_agree(k1, k2, gamma3, force):
    """The velocities of a strongly bent shape, once from x, y, θ and once from its strains."""
    degree, gamma1 = 28, 0.3
    rod, matrices = discretise(k1, k2, gamma3, gamma1, force, degree), integrals(degree)
    u = matrices.nodes
    law = follower(k1, k2, gamma3, gamma1)
    slopes = (0.2 * np.sin(2 * u), 0.1 * np.cos(3 * u), 1.5 * np.sin(1 + 2 * u))
    h1, h2, pi = z = strains(law, slopes, force, degree)
    theta = matrices.up @ pi.part()
    c, s = np.cos(theta), np.sin(theta)
    x = matrices.up @ (h1.part() * c - h2.part() * s)
    y = matrices.up @ (h1.part() * s + h2.part() * c)
    v1, v2, omega = (v.part() for v in velocities(law, z, slopes))
    expected = np.array([c * v1 - s * v2, s * v1 + c * v2, omega])[:, 1:-1]
    found = rod.rhs(rod.state(x[1:-1], y[1:-1], theta[1:-1])).reshape(3, -1)
    for row in range(3):
        np.testing.assert_allclose(found[row], expected[row], atol=3e-8 * np.abs(expected[row]).max())
    tips = rod.tip(rod.state(x[1:-1], y[1:-1], theta[1:-1]))
    np.testing.assert_allclose(tips, [x[-1], y[-1], theta[-1]], rtol=1e-12)
