"""The discretised full rod: the grid, the tip conditions, the right-hand side and its derivatives."""

import numpy as np
import pytest

from rodwnl.collocation import DisplacementRod, chebyshev, discretise
from rodwnl.strainform import follower, integrals, strains, velocities

RODS = [(1e4, 1e4, 1e-4, 37.66), (1e4, 1e2, 1e-2, 27.43), (200.0, 1e4, 1e-4, 155.6)]


def bent(rod: DisplacementRod, seed: int = 0) -> np.ndarray:
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
    """f is linear in the force at fixed q: a difference is exact at any step."""
    rod = discretise(k1, k2, gamma3, 0.5, force, 16)
    q = bent(rod)
    difference = (rod.at_force(1.2 * force).rhs(q) - rod.at_force(0.8 * force).rhs(q)) / (0.4 * force)
    scale = np.abs(difference).max()
    np.testing.assert_allclose(rod.force_derivative(q), difference, atol=1e-9 * scale)


def test_many_states_at_once_give_what_each_gives():
    rod = discretise(1e4, 1e2, 1e-2, 0.5, 30.0, 16)
    q = bent(rod)
    for each in range(3):
        np.testing.assert_allclose(rod.rhs(q)[each], rod.rhs(q[each]), rtol=1e-12)
        np.testing.assert_allclose(rod.jacobian(q)[each], rod.jacobian(q[each]), rtol=1e-12, atol=1e-9)
        np.testing.assert_allclose(rod.tip(q)[1][each], rod.tip(q[each])[1], rtol=1e-14)


def bent_and_sheared(degree: int) -> tuple[np.ndarray, ...]:
    """Slopes of the strains of a strongly bent shape that satisfies the tip conditions."""
    u = integrals(degree).nodes
    return 0.2 * np.sin(2 * u), 0.1 * np.cos(3 * u), 1.5 * np.sin(1 + 2 * u)


def shape(z, degree) -> tuple[np.ndarray, ...]:
    """x, y, θ at all nodes, integrated from the strains."""
    up = integrals(degree).up
    h1, h2, pi = (strain.part() for strain in z)
    theta = up @ pi
    c, s = np.cos(theta), np.sin(theta)
    return up @ (h1 * c - h2 * s), up @ (h1 * s + h2 * c), theta


@pytest.mark.parametrize(("k1", "k2", "gamma3", "force"), RODS)
def test_two_formulations_of_the_exact_rod_agree(k1, k2, gamma3, force):
    """The velocities of one shape, once from x, y, θ and once from its strains."""
    degree, gamma1 = 28, 0.3
    rod, law = discretise(k1, k2, gamma3, gamma1, force, degree), follower(k1, k2, gamma3, gamma1)
    slopes = bent_and_sheared(degree)
    z = strains((1 - force / k1, 0.0, 0.0), slopes, degree)
    x, y, theta = shape(z, degree)
    v1, v2, omega = (v.part() for v in velocities(law, z, slopes, force))
    c, s = np.cos(theta), np.sin(theta)
    expected = np.array([c * v1 - s * v2, s * v1 + c * v2, omega])[:, 1:]
    q = rod.state(x[1:], y[1:], theta[1:])
    found = rod.rhs(q).reshape(3, -1)
    for row in range(3):
        np.testing.assert_allclose(found[row], expected[row], atol=1e-7 * np.abs(expected[row]).max())
    np.testing.assert_allclose(rod.tip(q), [x[-1], y[-1], theta[-1]], rtol=1e-12)
    np.testing.assert_allclose(rod.tip_defect(q), 0, atol=1e-12)


def test_the_tip_conditions_are_approached_with_more_points():
    """A clamped shape that violates them is seen by `tip_defect`."""
    rod = discretise(*RODS[0][:3], 0.5, RODS[0][3], 24)
    u = rod.nodes
    defect = rod.tip_defect(rod.state(rod.nu * u, 0.1 * u, 0 * u))
    np.testing.assert_allclose(defect, [0, 0.1, 0], atol=1e-12)


def test_a_strongly_bent_soft_rod_has_no_spurious_modes():
    """The fastest growth at a fixed shape is the same on 20 and on 48 points, however stiff the rest."""

    def growth(degree: int) -> float:
        matrices = integrals(degree)
        rod, u = discretise(200.0, 1e4, 1e-4, 0.5, 155.0, degree), matrices.nodes
        theta = matrices.up @ (6 * (1 - u) * np.cos(2 * u))
        h1 = rod.nu + 0.4 * np.sin(np.pi * u) ** 2
        q = rod.state(*((matrices.up @ (h1 * f(theta)))[1:] for f in (np.cos, np.sin)), theta[1:])
        return np.linalg.eigvals(rod.jacobian(q)).real.max()

    assert growth(20) == pytest.approx(growth(48), rel=1e-3)
    assert 0 < growth(20) < 1e3
