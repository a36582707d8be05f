"""Which periodic orbits a rod has at a force, and where a stable one coexists with the stable straight rod.

Everything here is found along branches that begin at a Hopf point of the straight rod; an orbit that no such
branch reaches is not seen. The branches are followed within a window of forces, which is part of each answer.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from fractions import Fraction
from itertools import pairwise

import numpy as np

from rodwnl.branches import Branch, BranchPoint, branch
from rodwnl.emittedlaw import emitted_law
from rodwnl.errors import ComputationError
from rodwnl.orbits import Cycle, Orbit, onset, orbit_at, regridded
from rodwnl.parameters import Number, RodParameters, decimal_text, require_rod
from rodwnl.spectrum import DEFAULT_MAX_FORCE, HopfSearch, HopfThreshold, hopf_thresholds, searched_range

MARGIN = 1.5  # the window reaches so far beyond the last threshold and the force asked for
FARTHEST_GUESS = 0.5  # s up to which the branch's tangent at onset serves as the guess
SAME = 1e-6  # relative difference in ω below which two orbits are one

Watch = Callable[[BranchPoint], None]


@dataclass(frozen=True)
class Orbits:
    """The periodic orbits found at a force, stable ones first, then by falling amplitude.

    straight_stable: whether the straight rod is. branches: those followed to the end to find all; empty where
    only the branch that the straight rod's instability leads to was looked at.
    """

    rod: RodParameters
    force: float
    straight_stable: bool
    orbits: tuple[Orbit, ...]
    branches: tuple[Branch, ...]


@dataclass(frozen=True)
class Bistability:
    """Forces at which the straight rod and a periodic orbit are both stable: intervals (low, high), rising.

    Each end is a Hopf point, a fold or another event of the branches, or the edge of the window.
    """

    rod: RodParameters
    search: HopfSearch
    branches: tuple[Branch, ...]
    intervals: tuple[tuple[float, float], ...]


def periodic_orbits(
    rod: RodParameters, force: Number, every: bool = False, watch: Watch = lambda point: None
) -> Orbits:
    """The orbits at one force.

    Where the straight rod is unstable, the stable orbit that its instability leads to; with `every`, and
    where the straight rod is stable, all orbits of all branches. Raises InputError for a force without
    straight rod and ComputationError where no orbit is found.
    """
    require_rod(rod)
    exact = rod.checked_force(force)
    at = float(exact)
    search = hopf_thresholds(rod, max(2 * exact, Fraction(DEFAULT_MAX_FORCE)))
    stable = straight_is_stable(search, at)
    if not stable and not every:
        for threshold in sorted(search, key=lambda t: abs(t.force - at)):
            orbit = _led_to(rod, threshold, at, watch)
            if orbit is not None:
                return Orbits(rod, at, stable, (orbit,), ())
    branches = all_branches(rod, search, at, watch)
    orbits = [orbit for one in branches for orbit in _crossings(one, at)]
    distinct = [a for i, a in enumerate(orbits) if all(abs(a.omega / b.omega - 1) > SAME for b in orbits[:i])]
    if not distinct:
        raise ComputationError(_none(at, stable, search, branches))
    distinct.sort(key=lambda orbit: (not orbit.stable, -orbit.A_tip))
    return Orbits(rod, at, stable, tuple(distinct), branches)


def bistability(
    rod: RodParameters, max_force: Number | None = None, watch: Watch = lambda point: None
) -> Bistability:
    """All intervals of force in which the straight rod and a periodic orbit are both stable.

    Raises InputError for a negative max_force, ComputationError where a branch cannot be begun.
    """
    search = hopf_thresholds(rod, max_force)
    branches = all_branches(rod, search, 0.0, watch)
    straight = _quiet_ranges(search)
    oscillating = [stretch for one in branches for stretch in _stable_ranges(one)]
    shared = [(max(a[0], b[0]), min(a[1], b[1])) for a in straight for b in oscillating]
    intervals: list[tuple[float, float]] = []
    for low, high in sorted(pair for pair in shared if pair[0] < pair[1]):
        if intervals and low <= intervals[-1][1]:
            intervals[-1] = (intervals[-1][0], max(high, intervals[-1][1]))
        else:
            intervals.append((low, high))
    # rounding alone makes the two sides of a supercritical onset overlap
    kept = tuple((low, high) for low, high in intervals if high - low > 1e-8 * high)
    return Bistability(rod, search, branches, kept)


def straight_is_stable(search: HopfSearch, force: float) -> bool:
    """Whether the straight rod is linearly stable at a force within the range searched."""
    below = [threshold for threshold in _changes(search) if threshold.force < force]
    return (below[-1].unstable_above if below else search.unstable_unloaded) == 0


def _changes(search: HopfSearch) -> list[HopfThreshold]:
    """Where the straight rod loses or regains stability, by oscillating or by buckling."""
    return sorted([*search, *search.steady], key=lambda threshold: threshold.force)


def all_branches(rod: RodParameters, search: HopfSearch, force: float, watch: Watch) -> tuple[Branch, ...]:
    """Every branch from a threshold, each once: not from a Hopf point at which an earlier branch ended."""
    highest = max([force, *(threshold.force for threshold in search)])
    window = (0.0, float(searched_range(rod, MARGIN * highest)[0]))
    found: list[Branch] = []
    for threshold in search:
        ends = [one.last.force for one in found if one.end == "Hopf point"]
        if not any(abs(end / threshold.force - 1) < SAME for end in ends):
            found.append(branch(rod, threshold.force, threshold.omega, window=window, watch=watch))
    return tuple(found)


def _led_to(rod: RodParameters, threshold: HopfThreshold, force: float, watch: Watch) -> Orbit | None:
    """The first orbit at this force on the branch of a threshold, if there is one and it is stable."""
    begin = onset(emitted_law(rod), threshold.force, threshold.omega)
    X, tangent = begin.point.X, begin.point.tangent
    guess = Cycle(begin.system, X + (force - X[-2]) / tangent[-2] * tangent)
    try:
        if not 0 < guess.square < FARTHEST_GUESS:
            followed = branch(
                rod, threshold.force, threshold.omega, until=force, watch=watch, locate_events=False
            )
            if followed.end != "force asked for":
                return None
            guess = followed.last
        orbit = orbit_at(guess, force)
    except ComputationError:
        return None
    return orbit if orbit.stable else None


def _crossings(one: Branch, force: float) -> list[Orbit]:
    """The orbits at which a branch passes this force."""
    folds = [event.at.cycle.force for event in one.folds]
    found = []
    for (a, _), (b, _) in pairwise(one.path):
        if (a.force - force) * (b.force - force) > 0 or a.force == b.force:
            continue
        # Next to a fold the force is a square: interpolate in its root
        if a.force in folds:
            weight = np.sqrt((force - a.force) / (b.force - a.force))
        elif b.force in folds:
            weight = 1 - np.sqrt((b.force - force) / (b.force - a.force))
        else:
            weight = (force - a.force) / (b.force - a.force)
        common = max(a.system.count, b.system.count), max(a.system.degree, b.system.degree)
        system, start = regridded(a, common)
        end = regridded(b, common)[1]
        X = start + weight * (end - start)
        if X[-1] > 0:
            found.append(orbit_at(Cycle(system, X), force))
    return found


def _stable_ranges(one: Branch) -> list[tuple[float, float]]:
    """Forces over which each stable stretch of a branch extends."""
    return [
        (min(a.force, b.force), max(a.force, b.force)) for (a, stable), (b, _) in pairwise(one.path) if stable
    ]


def _quiet_ranges(search: HopfSearch) -> list[tuple[float, float]]:
    """Forces over which the straight rod is stable."""
    edges = [0.0, *(threshold.force for threshold in _changes(search)), float(search.max_force)]
    return [(low, high) for low, high in pairwise(edges) if straight_is_stable(search, (low + high) / 2)]


def _none(force: float, stable: bool, search: HopfSearch, branches: tuple[Branch, ...]) -> str:
    """Why there is no orbit to show."""
    said = [f"no periodic orbit was found at force {force:.10g}, where the straight rod is "]
    said.append("stable" if stable else "unstable")
    if not search.thresholds:
        said.append("; it has no Hopf threshold up to " + decimal_text(search.max_force))
    for one in branches:
        forces = [cycle.force for cycle, _ in one.path]
        said.append(
            f"; orbits born at the threshold {one.start.force:.8g} were found between forces "
            f"{min(forces):.8g} and {max(forces):.8g}"
        )
        folds = sorted((event.force for event in one.folds), key=lambda fold: abs(fold - force))
        said.append(f", nearest fold at {folds[0]:.8g}" if folds else ", without a fold")
    return "".join(said)
