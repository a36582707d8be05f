"""Branches of periodic orbits: from a Hopf point through folds to where they end, with their stability."""

from __future__ import annotations

from collections.abc import Callable
from contextlib import suppress
from dataclasses import dataclass, replace
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from rodwnl.continuation import ConvergenceError, Point, advance, correct, locate, solve_at
from rodwnl.cycles import OrbitSystem
from rodwnl.emittedlaw import emitted_law
from rodwnl.floquet import multipliers
from rodwnl.orbits import FINEST, Cycle, finer, onset, regridded, suited
from rodwnl.parameters import Number, RodParameters, exact, positive, require_rod
from rodwnl.spectrum import searched_range

START = (8, 28)  # resolution at the Hopf point: there nothing but round-off limits the slopes
FIRST_STEP, LONGEST_STEP, SHORTEST_STEP = 0.01, 0.25, 1e-6  # in (F/F_c, ω/ω_c, s)
MOST_POINTS = 150
FARTHEST = 100  # forces, relative to the threshold's, to which a branch is followed unless told otherwise
TAILS = 1e-8, 3e-6, 3e-5  # of orbits on a branch: coarsen below the first, refine above the last, aim between
WORST_TAIL = 1e-3  # of an orbit on the finest grid
EVENT_ACCURACY = 1e-7  # absolute, in the force
EVENT_DISTANCE = 1e-8  # along the branch

Kind = Literal["fold", "branch point", "symmetry breaking", "torus"]
End = Literal["Hopf point", "force asked for", "edge of the range", "number of points", "not resolved"]


@dataclass(frozen=True)
class BranchPoint:
    """An orbit on a branch. rho: eigenvalues of its half-period map without the trivial 1, largest first."""

    system: OrbitSystem
    point: Point
    rho: NDArray[np.complex128]

    @property
    def cycle(self) -> Cycle:
        return Cycle(self.system, self.point.X)

    @property
    def unstable(self) -> int:
        """Number of Floquet multipliers outside the unit circle."""
        return int((np.abs(self.rho) > 1).sum())

    @property
    def stable(self) -> bool:
        return self.unstable == 0

    @property
    def stable_across_a_fold(self) -> bool:
        """Whether the orbits beyond a fold next to this point are stable: one multiplier crosses there."""
        return self.unstable == 1

    @property
    def forward(self) -> float:
        """Change of the force per distance along the branch; 0 at a fold."""
        return float(self.point.tangent[-2])


@dataclass(frozen=True)
class Event:
    """A fold or another change of stability, between points[index − 1] and points[index] of its branch.

    index 0 and len(points): a fold between the Hopf point at that end and the point next to it.

    error: what the last refinement of the grid changed in the force.
    kind: of the eigenvalue ρ of the half-period map that crosses the unit circle. At a fold ρ = 1, and at a
    branch point without the branch turning; where the orbit loses its reflection symmetry ρ = −1; a complex
    pair starts a torus (Neimark–Sacker; period doubling if ρ = ±i).
    """

    kind: Kind
    at: BranchPoint
    error: float
    index: int

    @property
    def force(self) -> float:
        return self.at.cycle.force


@dataclass(frozen=True)
class Branch:
    """Orbits along a branch, in their order, from a Hopf point on.

    start, last: the Hopf point (s = 0) and where the branch stops, perhaps another one. end: why it stops.
    A_tip2_slope, omega_slope: dA_tip²/dF and dω/dF at the start, from the branch's tangent. window: the
    forces searched.
    """

    rod: RodParameters
    window: tuple[float, float]
    start: Cycle
    A_tip2_slope: float
    omega_slope: float
    points: tuple[BranchPoint, ...]
    events: tuple[Event, ...]
    end: End
    last: Cycle

    @property
    def folds(self) -> tuple[Event, ...]:
        return tuple(event for event in self.events if event.kind == "fold")

    @property
    def path(self) -> tuple[tuple[Cycle, bool], ...]:
        """The whole curve with its events in order: cycles, and whether the stretch after each is stable."""
        if not self.points:
            return ()
        first, final = self.points[0], self.points[-1]
        at_once = [event for event in self.events if event.index == 0]
        path = [(self.start, first.stable_across_a_fold if at_once else first.stable)]
        for i, point in enumerate(self.points):
            path += [(event.at.cycle, point.stable) for event in self.events if event.index == i]
            path.append((point.cycle, point.stable))
        at_last = [event for event in self.events if event.index == len(self.points)]
        path += [(event.at.cycle, final.stable_across_a_fold) for event in at_last]
        return (*path, (self.last, False))


def branch(
    rod: RodParameters, force: Number, omega: Number, until: Number | None = None,
    window: tuple[float, float] | None = None, most_points: int = MOST_POINTS,
    watch: Callable[[BranchPoint], None] = lambda point: None, locate_events: bool = True,
) -> Branch:  # fmt: skip
    """The branch from the Hopf point near (force, omega) to its other end.

    Or to where it first reaches the force `until`, leaves the window of forces (default: those up to FARTHEST
    times this one that the straight rod bears), or has so many points. `watch` is called with each point.
    Raises ComputationError where there is no Hopf point. Without `locate_events` the branch is followed only
    for where it leads. Raises InputError where the force or ω is not a positive number, or `until` not one.
    """
    require_rod(rod)
    force, omega = float(positive("force", force)), float(positive("omega", omega))
    window = window or (0.0, float(searched_range(rod, FARTHEST * force)[0]))
    begin = onset(emitted_law(rod), force, omega, START)
    stops: list[tuple[End, float]] = [("edge of the range", edge) for edge in window]
    if until is not None:
        stops.insert(0, ("force asked for", float(exact("until", until))))
    system, point, step = begin.system, begin.point, FIRST_STEP
    by_force = point.tangent / point.tangent[-2]
    points: list[BranchPoint] = []
    events: list[Event] = []
    end: End = "number of points"
    while len(points) < most_points:
        try:
            system, point = _on_suitable_grid(*_to_scale(system, point))
            new, length, step = advance(system, point, step, SHORTEST_STEP)
            last = _last(system, point, new, stops)
        except ConvergenceError:
            end = "not resolved"
            break
        step = min(step, LONGEST_STEP)
        if last is not None:
            end, new = last
            length = float(system.metric @ (point.tangent * (new.X - point.X)))
        if end != "Hopf point":
            points.append(_judged(system, new))
            watch(points[-1])
            if locate_events and len(points) > 1:
                events += _events(_judged(system, point), length, points[-1], len(points) - 1)
            elif locate_events:
                events += _fold(BranchPoint(system, point, points[0].rho), length, points[0], 0)
        elif locate_events and points:
            # solve_at points towards s > 0, and the branch arrives with s falling
            arrived = BranchPoint(system, replace(new, tangent=-new.tangent), points[-1].rho)
            events += _fold(replace(points[-1], system=system, point=point), length, arrived, len(points))
        point = new
        if last is not None:
            break
    return Branch(
        rod=rod,
        window=window,
        start=Cycle(begin.system, begin.point.X),
        A_tip2_slope=float(by_force[-1] * begin.tip_per_angle**2),
        omega_slope=float(by_force[-3]),
        points=tuple(points),
        events=tuple(events),
        end=end,
        last=Cycle(system, point.X),
    )


def _judged(system: OrbitSystem, point: Point) -> BranchPoint:
    return BranchPoint(system, point, multipliers(Cycle(system, point.X)).half)


def _last(
    system: OrbitSystem, point: Point, new: Point, stops: list[tuple[End, float]]
) -> tuple[End, Point] | None:
    """The end of the branch between two neighbouring points, if it is there."""
    if new.X[-1] <= 0:
        return "Hopf point", solve_at(system, new.X, -1, 0.0)
    for end, stop in stops:
        before, after = point.X[-2] - stop, new.X[-2] - stop
        if before * after < 0 or after == 0:
            weight = before / (before - after)
            edge = solve_at(system, point.X + weight * (new.X - point.X), -2, stop)
            # solve_at points towards larger forces; the branch may come the other way
            return end, replace(edge, tangent=np.sign(new.X[-2] - point.X[-2]) * edge.tangent)
    return None


def _to_scale(system: OrbitSystem, point: Point) -> tuple[OrbitSystem, Point]:
    """The same point, measured by its own force and frequency once they have left those of the Hopf point."""
    omega, force = (max(abs(float(value)), np.finfo(float).tiny) for value in point.X[-3:-1])
    if max(abs(np.log(omega / system.omega_scale)), abs(np.log(force / system.force_scale))) < np.log(2):
        return system, point
    system = replace(system, omega_scale=omega, force_scale=force)
    length = np.sqrt(system.metric @ point.tangent**2)
    return system, replace(point, tangent=point.tangent / length, curvature=point.curvature / length**2)


def _on_suitable_grid(system: OrbitSystem, point: Point) -> tuple[OrbitSystem, Point]:
    """The same point on a grid whose tails lie in the range of TAILS, within FINEST."""
    cycle = Cycle(system, point.X)
    least, aim, most = TAILS
    now, wanted = (system.count, system.degree), suited(cycle, aim)
    if any(
        tail > WORST_TAIL and n == most_n for tail, n, most_n in zip(cycle.tails, now, FINEST, strict=True)
    ):
        raise ConvergenceError(f"the finest grid does not resolve the orbit at force {cycle.force:.6g}")
    chosen = tuple(
        want if tail < least or tail > most else have
        for want, have, tail in zip(wanted, now, cycle.tails, strict=True)
    )
    return (system, point) if chosen == now else _moved(system, point, (chosen[0], chosen[1]))


def _moved(system: OrbitSystem, point: Point, resolution: tuple[int, int]) -> tuple[OrbitSystem, Point]:
    """The same point on another grid, with its tangent's direction kept."""
    new, guess = regridded(Cycle(system, point.X), resolution)
    tangent, curvature = (
        regridded(Cycle(system, vector), resolution)[1] for vector in (point.tangent, point.curvature)
    )
    return new, replace(correct(new, guess, new.metric * tangent), curvature=curvature)


def _events(before: BranchPoint, length: float, after: BranchPoint, index: int) -> list[Event]:
    """What changes between two neighbouring points: a fold, and what a fold does not explain."""
    found = _fold(before, length, after, index)
    change = after.unstable - before.unstable
    if found:
        change -= int(np.sign(change))
    if change:
        k = min(before.unstable, after.unstable)
        rho = min(before.rho[k], after.rho[k], key=lambda value: abs(abs(value) - 1))
        kind: Kind = "branch point" if rho.real > 0 else "symmetry breaking"
        if abs(rho.imag) > 1e-9:
            kind = "torus"
        found.append(_pinned(kind, before, length, after, lambda at: float(np.log(np.abs(at.rho[k]))), index))
    return found


def _fold(before: BranchPoint, length: float, after: BranchPoint, index: int) -> list[Event]:
    """The fold between two points, if the force turns between them."""
    if before.forward * after.forward >= 0:
        return []
    return [_pinned("fold", before, length, after, lambda at: at.forward, index)]


def _pinned(
    kind: Kind, before: BranchPoint, length: float, after: BranchPoint,
    event: Callable[[BranchPoint], float], index: int,
) -> Event:  # fmt: skip
    """The place between two points where the event is 0, on finer grids until the force has settled.

    Where the iteration fails the event stays as well placed as it is by then, which its error says.
    """
    system = before.system

    def value(new: Point) -> float:
        return event(BranchPoint(system, new, before.rho) if kind == "fold" else _judged(system, new))

    start, end = event(before), event(after)
    weight = start / (start - end)
    point = replace(before.point, X=before.point.X + length * weight * before.point.tangent)
    placed, error = (system, point), length * system.force_scale
    with suppress(ConvergenceError):
        point, _ = locate(system, before.point, value, length * weight, 1e3 * EVENT_DISTANCE, length)
        while True:
            rough, placed = float(point.X[-2]), (system, point)
            system, point = _moved(system, point, finer(Cycle(system, point.X)))
            point, _ = locate(system, point, value, 1e-4, EVENT_DISTANCE)
            placed, error = (system, point), abs(float(point.X[-2]) - rough)
            if error < EVENT_ACCURACY or (system.count, system.degree) == FINEST:
                break
    return Event(kind, _judged(*placed), error, index)
