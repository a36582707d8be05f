"""What `orbit`, `branch` and `hysteresis` print, and how they show that they are at work."""

from __future__ import annotations

import sys
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from typing import TYPE_CHECKING, Any

from rodwnl.output import full_texts, print_table
from rodwnl.parameters import RodParameters
from rodwnl.report import cell, heading

if TYPE_CHECKING:
    from rodwnl.branches import Branch, BranchPoint, Event
    from rodwnl.orbits import Orbit

POINT_ERROR = (
    1e-6  # relative: what the grids of points on a branch (`branches.TAILS`) may leave in A_tip and ω
)


@contextmanager
def at_work(rod: RodParameters) -> Iterator[Callable[[BranchPoint], None]]:
    """A watcher of branches that shows the last orbit on a terminal's stderr, and shows nothing elsewhere."""
    if not sys.stderr.isatty():
        yield lambda point: None
        return
    from rich.console import Console

    with Console(stderr=True).status("looking for orbits") as status:

        def show(point: BranchPoint) -> None:
            cycle = point.cycle
            status.update(f"orbit at force {cycle.force:.6g}, A_tip {cycle.tip_amplitude:.4g}")

        yield show


def orbit_entry(orbit: Orbit) -> dict[str, Any]:
    """An orbit in JSON; every number a decimal text that reads back to the same double."""
    return {
        "force": repr(orbit.force),
        "A_tip": repr(orbit.A_tip),
        "omega": repr(orbit.omega),
        "stable": orbit.stable,
        "harmonics": [repr(value) for value in orbit.harmonics],
        "multipliers": [full_texts(value) for value in orbit.multipliers],
        "residual": repr(orbit.residual),
        "error": {"relative": repr(orbit.error), "multipliers": repr(orbit.multiplier_error)},
        "grid": {"phases": orbit.cycle.system.count, "degree": orbit.cycle.system.degree},
    }


def point_entry(point: BranchPoint) -> dict[str, Any]:
    """A point of a branch in JSON."""
    cycle = point.cycle
    return {
        "force": repr(cycle.force),
        "A_tip": repr(cycle.tip_amplitude),
        "omega": repr(cycle.omega),
        "stable": point.stable,
        "unstable_multipliers": point.unstable,
    }


def event_entry(event: Event) -> dict[str, Any]:
    """A fold or another change of stability in JSON."""
    cycle = event.at.cycle
    return {
        "kind": event.kind,
        "force": repr(cycle.force),
        "A_tip": repr(cycle.tip_amplitude),
        "omega": repr(cycle.omega),
        "error": {"force": repr(event.error)},
    }


def branch_entry(branch: Branch) -> dict[str, Any]:
    """A branch in JSON."""
    return {
        "start": {"force": repr(branch.start.force), "omega": repr(branch.start.omega)},
        "A_tip2_slope": repr(branch.A_tip2_slope),
        "omega_slope": repr(branch.omega_slope),
        "points": [point_entry(point) for point in branch.points],
        "folds": [event_entry(event) for event in branch.folds],
        "events": [event_entry(event) for event in branch.events],
        "window": [repr(edge) for edge in branch.window],
        "end": {"reason": branch.end, "force": repr(branch.last.force), "omega": repr(branch.last.omega)},
    }


def print_orbits(rod: RodParameters, orbits: Sequence[Orbit]) -> None:
    """A table with a column for each orbit."""

    def row(quantity: str, values: list[float]) -> list[str]:
        cells = (cell(rod, quantity, v, o.error * v) for v, o in zip(values, orbits, strict=True))
        return [heading(rod, quantity), *cells]

    print_table(
        ["orbit", *(str(i + 1) for i in range(len(orbits)))],
        [
            row("A_tip", [o.A_tip for o in orbits]),
            row("omega", [o.omega for o in orbits]),
            ["stable", *("yes" if o.stable else "no" for o in orbits)],
            ["largest multiplier", *(f"{abs(o.multipliers[0]):.6g}" for o in orbits)],
            ["third harmonic", *(f"{o.harmonics[1] / o.harmonics[0]:.3e}" for o in orbits)],
            ["relative error", *(f"{o.error:.0e}" for o in orbits)],
            ["residual", *(f"{o.residual:.0e}" for o in orbits)],
        ],
    )


def print_branch(rod: RodParameters, branch: Branch) -> None:
    """A branch point by point, with what happens between the points, and where it ends."""
    rows = []
    for i, point in enumerate(branch.points):
        rows += [_row(rod, e.kind, e.at, e.error) for e in branch.events if e.index == i]
        rows.append(
            _row(rod, "stable" if point.stable else "unstable", point, POINT_ERROR * point.cycle.force)
        )
    print_table(["", *(heading(rod, name) for name in ("force", "A_tip", "omega"))], rows)
    print(f"The branch ends: {ending(rod, branch)}.")


def ending(rod: RodParameters, branch: Branch) -> str:
    """Why a branch ends, in words."""
    at = f"{heading(rod, 'force')} = {cell(rod, 'force', branch.last.force, 1e-9 * branch.last.force)}"
    return {
        "Hopf point": f"it joins the straight rod at the Hopf point {at}",
        "force asked for": f"it has reached {at}",
        "edge of the range": f"it leaves the range of forces at {at}",
        "number of points": f"this many points were asked for; the last lies at {at}",
        "not resolved": f"no grid within limits resolves the next orbit; the last lies at {at}",
    }[branch.end]


def _row(rod: RodParameters, what: str, at: BranchPoint, force_error: float) -> list[str]:
    cycle = at.cycle
    A, omega = cycle.tip_amplitude, cycle.omega
    return [
        what,
        cell(rod, "force", cycle.force, force_error),
        cell(rod, "A_tip", A, POINT_ERROR * A),
        cell(rod, "omega", omega, POINT_ERROR * omega),
    ]
