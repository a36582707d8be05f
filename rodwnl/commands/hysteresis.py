"""`rodwnl hysteresis`: where the straight rod and a beating one are both stable."""

from rodwnl.options import Json, MaxForce, read_max_force, takes_rod
from rodwnl.orbit_report import at_work, branch_entry, ending
from rodwnl.output import print_json, print_table
from rodwnl.parameters import RodParameters
from rodwnl.report import cell, document, heading, sentences, threshold_entry, with_unit


@takes_rod
def command(rod: RodParameters, max_force: MaxForce = None, json: Json = False) -> None:
    """Intervals of force in which the straight rod and a periodic orbit are both stable.

    All branches of orbits that begin at a threshold are followed, through their folds, to where they end.
    """
    from rodwnl.coexistence import bistability

    with at_work(rod) as watch:
        found = bistability(rod, read_max_force(rod, max_force), watch)
    if json:
        print_json(
            document(found.search, [threshold_entry(threshold) for threshold in found.search])
            | {"intervals": [{"low": repr(low), "high": repr(high)} for low, high in found.intervals]}
            | {"branches": [branch_entry(branch) for branch in found.branches]}
        )
        return
    print("\n".join(sentences(found.search)))
    for branch in found.branches:
        start = cell(rod, "force", branch.start.force, 1e-9 * branch.start.force)
        print(f"Orbits from {heading(rod, 'force')} = {start}: {ending(rod, branch)}.")
        if branch.events:
            print_table(
                ["change of stability", heading(rod, "force"), heading(rod, "A_tip"), heading(rod, "omega")],
                [
                    [
                        event.kind,
                        cell(rod, "force", event.force, event.error),
                        cell(rod, "A_tip", event.at.cycle.tip_amplitude, 1e-6 * event.at.cycle.tip_amplitude),
                        cell(rod, "omega", event.at.cycle.omega, 1e-6 * event.at.cycle.omega),
                    ]
                    for event in branch.events
                ],
            )
    if not found.intervals:
        reach = with_unit(rod, "force", found.search.max_force)
        print(
            f"Up to {heading(rod, 'force')} = {reach} the straight rod and a periodic orbit are nowhere both "
            "stable: no hysteresis there."
        )
    for low, high in found.intervals:
        ends = " and ".join(cell(rod, "force", end, 1e-7) for end in (low, high))
        print(f"Both are stable between {heading(rod, 'force')} = {ends}.")
