"""Curves of solutions of G(X) = 0 with one unknown more than equations, followed by pseudo-arclength.

Keller (1977); Doedel, Keller & Kernevez (1991, doi:10.1142/S0218127491000397). A curve is followed by
`advance`, from point to point; `locate` finds the point between two of them where something changes sign: a
fold, where the tangent's component in the parameter does, or a change of stability.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from rodwnl.errors import ComputationError

Array = NDArray[np.float64]

MAX_ITERATIONS = 10
SETTLED = 1e-7  # a Newton step below this, relative to the scales, leaves an error of its square
SHARPEST_TURN, GENTLE_TURN = 0.9, 0.97  # cosines between the tangents at neighbouring points
MOST_SECANTS = 20


class Jacobian(Protocol):
    """∂G/∂X of a system that has a way of its own to solve with it."""

    def bordered(self, row: Array) -> Callable[[Array], Array]:
        """b -> the x with (∂G/∂X; row) x = b. Raises ConvergenceError."""


class System(Protocol):
    """n equations for n + 1 unknowns."""

    @property
    def scales(self) -> Array:
        """(n + 1,): typical sizes of the unknowns, by which Newton's steps are measured."""

    @property
    def metric(self) -> Array:
        """(n + 1,): weights ≥ 0 of the squares in the length of a step along the curve."""

    def linearised(self, X: Array) -> tuple[Array, Array | Jacobian]:
        """G(X), (n,), and ∂G/∂X, (n, n + 1)."""


class ConvergenceError(ComputationError):
    """Newton's iteration did not settle."""


@dataclass(frozen=True)
class Point:
    """A solution, the curve's unit tangent and its change per distance, 0 where not yet known.

    iterations: what Newton's method took.
    """

    X: Array
    tangent: Array
    curvature: Array
    iterations: int


def correct(system: System, guess: Array, row: Array) -> Point:
    """The solution in the plane row·(X − guess) = 0, by Newton's method. Raises ConvergenceError.

    The tangent points where row·tangent > 0.
    """
    X, solve, iterations = _newton(system, guess, row)
    tangent = solve(np.append(np.zeros(X.size - 1), 1.0))
    tangent = tangent / np.sqrt(system.metric @ tangent**2)
    return Point(X, tangent, np.zeros_like(X), iterations)


def _newton(system: System, guess: Array, row: Array) -> tuple[Array, Callable[[Array], Array], int]:
    """The solution in that plane, what solves with the last Jacobian, and the number of steps."""
    X, last = guess.copy(), np.inf
    for iteration in range(1, MAX_ITERATIONS + 1):
        G, J = system.linearised(X)
        solve = _solver(J, row)
        step = solve(np.append(-G, -row @ (X - guess)))
        size = float(np.max(np.abs(step) / system.scales))
        if not np.isfinite(size) or (iteration > 2 and size > 2 * last):
            raise ConvergenceError(f"Newton's iteration diverged (step {size:.1e} after {last:.1e})")
        X, last = X + step, size
        if size < SETTLED:
            return X, solve, iteration
    raise ConvergenceError(
        f"Newton's iteration did not settle in {MAX_ITERATIONS} steps (last step {last:.1e})"
    )


def _solver(J: Array | Jacobian, row: Array) -> Callable[[Array], Array]:
    """b -> the x with (J; row) x = b."""
    from scipy.linalg import lu_factor, lu_solve

    if not isinstance(J, np.ndarray):
        return J.bordered(row)
    factors = lu_factor(np.vstack([J, row]), overwrite_a=True, check_finite=False)
    return lambda b: np.asarray(lu_solve(factors, b, check_finite=False))


def solve_at(system: System, guess: Array, index: int, value: float) -> Point:
    """The solution whose unknown X[index] has this value; the tangent points towards larger ones."""
    return correct(system, *_held(guess, index, value))


def root_at(system: System, guess: Array, index: int, value: float) -> Array:
    """That solution alone, without the curve's tangent."""
    return _newton(system, *_held(guess, index, value))[0]


def _held(guess: Array, index: int, value: float) -> tuple[Array, Array]:
    """The guess with this value, and the row that keeps it."""
    row, start = np.zeros_like(guess), guess.copy()
    row[index], start[index] = 1.0, value
    return start, row


def step_from(system: System, point: Point, length: float) -> Point:
    """The point at this (signed) distance along the tangent. Raises ConvergenceError."""
    guess = point.X + length * point.tangent + length**2 / 2 * point.curvature
    return correct(system, guess, system.metric * point.tangent)


def advance(system: System, point: Point, step: float, shortest: float) -> tuple[Point, float, float]:
    """The next point along the tangent, its distance, and the distance that suits the point after it.

    The step is halved until Newton's method settles on a point where the curve has not turned sharply. Raises
    ConvergenceError below the shortest step.
    """
    while abs(step) >= shortest:
        try:
            new = step_from(system, point, step)
            turn = (system.metric * point.tangent) @ new.tangent
            if turn >= SHARPEST_TURN:
                ease = 2.0 ** ((4 - new.iterations) / 2)
                curved = replace(new, curvature=(new.tangent - point.tangent) / step)
                return curved, step, step * min(ease, 2.0 if turn > GENTLE_TURN else 1.0)
            reason = "the curve turns too sharply"
        except ConvergenceError as error:
            reason = str(error)
        step /= 2
    raise ConvergenceError(f"no point further along the curve was found: {reason}")


def locate(
    system: System, point: Point, event: Callable[[Point], float], trial: float, tolerance: float,
    within: float | None = None,
) -> tuple[Point, float]:  # fmt: skip
    """The point near this one where the event is 0, and its distance along the tangent.

    The secant method from distances 0 and `trial`, to this tolerance in it; within: a distance at which the
    event has the other sign, so that a step out of what is left between is replaced by a bisection. Raises
    ConvergenceError.
    """
    far, value = 0.0, event(point)
    near, first, low, high = trial, value, 0.0, within
    for _ in range(MOST_SECANTS):
        found = step_from(system, point, near)
        new = event(found)
        if new == value and high is None:
            break
        secant = near - new * (near - far) / (new - value) if new != value else np.inf
        if high is not None:
            low, high = (near, high) if new * first > 0 else (low, near)
            if not min(low, high) <= secant <= max(low, high):
                secant = (low + high) / 2
        far, near, value = near, secant, new
        if abs(near - far) <= tolerance:
            return step_from(system, point, near), near
    raise ConvergenceError("the secant method did not find where the curve changes")
