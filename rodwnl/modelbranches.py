"""Branches of periodic orbits of any rod, from a threshold through folds to where they end.

As `branches` does for the plain rod, with the equations of `modelorbits`. Their amplitude a, unlike a², makes
the threshold itself a crossing with the straight rod: a branch is begun at a small a, and has come back to a
Hopf point where a falls to about 0.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray

from rodwnl.branches import (
    EVENT_ACCURACY,
    EVENT_DISTANCE,
    LONGEST_STEP,
    MOST_POINTS,
    SHORTEST_STEP,
    TAILS,
    WORST_TAIL,
    End,
)
from rodwnl.coefficients import LandauCoefficients
from rodwnl.continuation import ConvergenceError, Point, advance, correct, locate, solve_at
from rodwnl.errors import ComputationError
from rodwnl.modelorbits import LawCycle, LawSystem, _begun, law_multipliers
from rodwnl.normalform import normal_form
from rodwnl.orbits import FINEST, Resolution, finer, suited
from rodwnl.predictions import Prediction
from rodwnl.strainform import RodLaw

FIRST_TIP = 0.02  # tip amplitude about twice that of the first orbit
MOST_STARTS = 6  # halvings of it, where the branch has already turned there
RETURNED = 1e-3  # a relative to the point before, below which the branch has met the straight rod


@dataclass(frozen=True)
class HopfPoint:
    force: float
    omega: float


@dataclass(frozen=True)
class LawBranchPoint:
    """An orbit on a branch; the fields are those of `branches.BranchPoint`."""

    system: LawSystem
    point: Point
    rho: NDArray[np.complex128]

    @property
    def cycle(self) -> LawCycle:
        return LawCycle(self.system, self.point.X)

    @property
    def unstable(self) -> int:
        """Number of Floquet multipliers outside the unit circle."""
        return int((np.abs(self.rho) > 1).sum())

    @property
    def stable(self) -> bool:
        return self.unstable == 0


@dataclass(frozen=True)
class LawFold:
    """A fold between points[index − 1] and points[index]; error: what the last finer grid changed in F."""

    at: LawBranchPoint
    error: float
    index: int
    kind: Literal["fold"] = "fold"

    @property
    def force(self) -> float:
        return self.at.cycle.force


@dataclass(frozen=True)
class LawBranch:
    """Orbits along a branch, in their order; the fields are those of `branches.Branch`.

    Of the changes of stability only folds are located.
    """

    window: tuple[float, float]
    start: HopfPoint
    A_tip2_slope: float
    omega_slope: float
    points: tuple[LawBranchPoint, ...]
    events: tuple[LawFold, ...]
    end: End
    last: LawCycle | HopfPoint

    @property
    def folds(self) -> tuple[LawFold, ...]:
        return self.events


def model_branch(
    law: RodLaw, threshold: LandauCoefficients, window: tuple[float, float], until: float | None = None,
    most_points: int = MOST_POINTS, watch: Callable[[Any], None] = lambda point: None,
) -> LawBranch:  # fmt: skip
    """The branch from this threshold to another Hopf point, or to where something else ends it.

    That is where it first reaches the force `until`, leaves the window of forces, or has so many points.
    Raises ComputationError where it cannot be begun.
    """
    stops: list[tuple[End, float]] = [("edge of the range", edge) for edge in window]
    if until is not None:
        stops.insert(0, ("force asked for", until))
    system, point, step = _first(law, threshold)
    previous = threshold.force
    points: list[LawBranchPoint] = []
    folds: list[LawFold] = []
    end: End = "number of points"
    last: LawCycle | HopfPoint = HopfPoint(threshold.force, threshold.omega)
    stop = _stopped(system, previous, point, point, stops)  # between the threshold and the first orbit
    while True:
        if stop is not None:
            end, point = stop
        points.append(LawBranchPoint(system, point, law_multipliers(LawCycle(system, point.X)).half))
        watch(points[-1])
        last = LawCycle(system, point.X)
        if stop is not None or len(points) == most_points:
            break
        try:
            system, point = _on_suitable_grid(system, point)
            system = replace(system, angle=float(point.X[-1]))
            new, length, step = advance(system, point, step, SHORTEST_STEP)
        except ConvergenceError:
            end = "not resolved"
            break
        step = min(step, LONGEST_STEP)
        if new.X[-1] <= RETURNED * point.X[-1]:
            end, last = "Hopf point", _arrived(law, system, point)
            break
        stop = _stopped(system, float(point.X[-2]), point, new, stops)
        if point.tangent[-2] * (new if stop is None else stop[1]).tangent[-2] < 0:
            folds.append(_fold(system, point, length, new, len(points)))
        point = new
    return LawBranch(
        window=window,
        start=HopfPoint(threshold.force, threshold.omega),
        A_tip2_slope=threshold.A_tip2_slope,
        omega_slope=threshold.omega_slope,
        points=tuple(points),
        events=tuple(folds),
        end=end,
        last=last,
    )


def _first(law: RodLaw, threshold: LandauCoefficients) -> tuple[LawSystem, Point, float]:
    """The first orbit, between the threshold and the first fold."""
    for halvings in range(MOST_STARTS):
        wanted = Prediction(
            threshold, threshold.force, None, True, None, FIRST_TIP / 2**halvings, None, None, None
        )
        try:
            system, point, step = _begun(law, wanted)
        except ConvergenceError:
            continue
        away = (point.X[-2] - threshold.force) * threshold.A_tip2_slope
        if point.X[-1] > 0 and away > 0 and point.tangent[-2] * threshold.A_tip2_slope > 0:
            return system, point, step
    raise ComputationError(f"no orbit was found beside the threshold at force {threshold.force:.10g}")


def _stopped(
    system: LawSystem, before: float, point: Point, new: Point, stops: list[tuple[End, float]]
) -> tuple[End, Point] | None:
    """The end of the branch between the force before and the new point, if it is there."""
    for end, stop in stops:
        far, near = before - stop, new.X[-2] - stop
        if far * near < 0 or near == 0:
            weight = far / (far - near)
            edge = solve_at(system, point.X + weight * (new.X - point.X), -2, stop)
            if edge.X[-1] <= RETURNED * new.X[-1]:
                raise ComputationError(f"Newton's method fell back to the straight rod at force {stop:.10g}")
            return end, replace(edge, tangent=np.sign(new.X[-2] - before) * edge.tangent)
    return None


def _arrived(law: RodLaw, system: LawSystem, point: Point) -> HopfPoint:
    """The Hopf point next to the last orbit, near where force and frequency, even in a, lead."""
    to_zero = -point.X[-1] / (2 * point.tangent[-1])
    omega, force, _ = point.X[-3:] + to_zero * point.tangent[-3:]
    form = normal_form(law, float(force), float(omega), system.degree)
    return HopfPoint(float(form.force), float(form.omega))


def _on_suitable_grid(system: LawSystem, point: Point) -> tuple[LawSystem, Point]:
    """The same point on a grid whose tails lie in the range of TAILS, within FINEST."""
    cycle = LawCycle(system, point.X)
    least, aim, most = TAILS
    now, wanted = (system.count, system.degree), suited(cycle, aim)
    if max(cycle.tails) > WORST_TAIL and now == FINEST:
        raise ConvergenceError(f"the finest grid does not resolve the orbit at force {cycle.force:.6g}")
    count, degree = (
        want if tail < least or tail > most else have
        for want, have, tail in zip(wanted, now, cycle.tails, strict=True)
    )
    return (system, point) if (count, degree) == now else _moved(system, point, (count, degree))


def _moved(system: LawSystem, point: Point, resolution: Resolution) -> tuple[LawSystem, Point]:
    """The same point on another grid, with its tangent's direction kept."""
    new, guess = system.resampled(point.X, resolution)
    tangent, curvature = (system.resampled(v, resolution)[1] for v in (point.tangent, point.curvature))
    return new, replace(correct(new, guess, new.metric * tangent), curvature=curvature)


def _fold(system: LawSystem, before: Point, length: float, after: Point, index: int) -> LawFold:
    """The fold between two points, on finer grids until its force has settled."""

    def forward(at: Point) -> float:
        return float(at.tangent[-2])

    trial = length * forward(before) / (forward(before) - forward(after))
    point, _ = locate(system, before, forward, trial, 1e3 * EVENT_DISTANCE)
    while True:
        rough = float(point.X[-2])
        system, point = _moved(system, point, finer(LawCycle(system, point.X)))
        point, _ = locate(system, point, forward, 1e-4, EVENT_DISTANCE)
        error = abs(float(point.X[-2]) - rough)
        if error < EVENT_ACCURACY or (system.count, system.degree) == FINEST:
            rho = law_multipliers(LawCycle(system, point.X)).half
            return LawFold(LawBranchPoint(system, point, rho), error, index)
