"""`rodwnl orbit`: the periodic orbits of the full nonlinear rod at one force."""

from typing import Annotated

import typer

from rodwnl.options import Json, read_force, takes_rod
from rodwnl.orbit_report import at_work, branch_entry, ending, orbit_entry, print_orbits
from rodwnl.output import print_json
from rodwnl.parameters import RodParameters, decimal_text
from rodwnl.report import cell, heading, rod_document, rod_sentence, with_unit


@takes_rod
def command(
    rod: RodParameters,
    force: Annotated[str, typer.Option(metavar="F", help="The force, 0 <= F < k1.")],
    every: Annotated[
        bool, typer.Option("--every", help="All orbits, also where the straight rod leads to a stable one.")
    ] = False,
    json: Json = False,
) -> None:
    """Solve for the periodic orbit itself: amplitude, frequency, harmonics and stability.

    Where the straight rod is stable, and with --every, all branches of orbits are followed and every orbit at
    this force is listed, stable ones first.
    """
    exact = read_force(rod, "force", force)
    from rodwnl.coexistence import periodic_orbits

    with at_work(rod) as watch:
        found = periodic_orbits(rod, exact, every, watch)
    straight = "stable" if found.straight_stable else "unstable"
    if json:
        entries = [orbit_entry(orbit) for orbit in found.orbits]
        searched = [branch_entry(branch) | {"points": len(branch.points)} for branch in found.branches]
        print_json(
            rod_document(rod)
            | {"force": decimal_text(exact), "straight": straight, "orbit": entries[0], "orbits": entries}
            | {"branches_followed": searched}
        )
        return
    print(rod_sentence(rod))
    print(f"At force = {with_unit(rod, 'force', exact)} the straight rod is {straight}.")
    if not found.branches:
        print("The orbit that its instability leads to (--every looks for others):")
    for branch in found.branches:
        start = cell(rod, "force", branch.start.force, 1e-9 * branch.start.force)
        print(f"Followed the orbits from {heading(rod, 'force')} = {start}: {ending(rod, branch)}.")
    print_orbits(rod, found.orbits)
