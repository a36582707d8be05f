"""Pseudo-arclength continuation on curves that are known in closed form."""

import numpy as np
import pytest

from rodwnl.continuation import ConvergenceError, advance, correct, locate, solve_at


class Circle:
    """x² + y² = 1, X = (x, y)."""

    scales = np.ones(2)
    metric = np.ones(2)

    def linearised(self, X):
        return np.array([X @ X - 1]), 2 * X[None]


class Subcritical:
    """Steady amplitudes of ṙ = r (μ + r² − r⁴), r > 0: a fold at μ = −1/4, r² = 1/2. X = (r, μ)."""

    scales = np.ones(2)
    metric = np.array([0.0, 1.0]) + np.array([1.0, 0.0])

    def linearised(self, X):
        r, mu = X
        return np.array([mu + r**2 - r**4]), np.array([[2 * r - 4 * r**3, 1.0]])


def test_a_closed_curve_is_followed_once_around():
    system, turned, step = Circle(), 0.0, 0.1
    point = correct(system, np.array([1.0, 0.1]), np.array([0.0, 1.0]))
    while turned < 2 * np.pi:
        new, length, step = advance(system, point, min(step, 0.5), 1e-6)
        assert pytest.approx(1, abs=1e-12) == new.X @ new.X
        assert new.tangent @ new.X == pytest.approx(0, abs=1e-7)  # of the last Newton matrix
        angle = np.arctan2(point.X[0] * new.X[1] - point.X[1] * new.X[0], point.X @ new.X)
        assert angle > 0
        assert point.tangent @ (new.X - point.X - length**2 / 2 * point.curvature) == pytest.approx(length)
        turned, point = turned + angle, new


def test_steps_grow_on_a_straight_part_and_the_curvature_shortens_newton():
    system = Circle()
    point = correct(system, np.array([1.0, 0.01]), np.array([0.0, 1.0]))
    first, _, _ = advance(system, point, 0.2, 1e-6)
    second, _, _ = advance(system, first, 0.2, 1e-6)
    np.testing.assert_allclose(first.curvature, -first.X, atol=0.25)
    assert second.iterations <= first.iterations


def test_the_fold_of_a_subcritical_branch_is_located():
    system = Subcritical()
    point = solve_at(system, np.array([0.3, -0.03]), 0, 0.2)
    assert pytest.approx([0.2, 0.2**4 - 0.2**2], abs=1e-14) == point.X
    assert point.tangent[0] > 0
    step = 0.05
    while True:
        new, length, step = advance(system, point, step, 1e-6)
        if new.tangent[1] * point.tangent[1] < 0:
            break
        point = new
    fold, distance = locate(system, point, lambda at: float(at.tangent[1]), length / 2, 1e-10)
    assert fold.X[1] == pytest.approx(-0.25, abs=1e-13)
    assert fold.X[0] ** 2 == pytest.approx(0.5, abs=1e-8)
    assert distance > 0
    assert distance < length
    # and behind it the branch goes on to larger r
    for _ in range(5):
        point, _, step = advance(system, point, step, 1e-6)
    assert point.X[0] ** 2 > 0.5


def test_a_steep_event_is_located_between_two_signs():
    system = Subcritical()
    point = solve_at(system, np.array([0.3, -0.03]), 0, 0.2)

    def event(at):
        return float(np.tanh(1e3 * (at.X[0] - 0.23)))

    with pytest.raises(ConvergenceError):
        locate(system, point, event, 0.02, 1e-6)
    found, distance = locate(system, point, event, 0.02, 1e-6, 0.1)
    assert found.X[0] == pytest.approx(0.23, abs=1e-6)
    assert 0 < distance < 0.1


def test_no_solution_is_said_so():
    with pytest.raises(ConvergenceError, match="Newton's iteration"):
        solve_at(Circle(), np.array([0.5, 0.5]), 0, 2.0)


def test_a_curve_that_ends_is_said_so():
    class HalfLine(Circle):
        """y = √(1 − x), which is no longer real beyond x = 1."""

        def linearised(self, X):
            with np.errstate(invalid="ignore", divide="ignore"):
                root = np.sqrt(1 - X[0])
                return np.array([X[1] - root]), np.array([[0.5 / root, 1.0]])

    def walk(point):
        while True:
            point, _, _ = advance(HalfLine(), point, 0.1, 1e-3)

    start = correct(HalfLine(), np.array([0.0, 1.0]), np.array([1.0, 0.0]))
    with pytest.raises(ConvergenceError, match="no point further along the curve"):
        walk(start)
