"""`rodwnl hopf`: the forces at which the straight rod starts or stops to flutter."""

from typing import TYPE_CHECKING, Annotated, Any

import typer

from rodwnl.errors import InputError
from rodwnl.options import Certified, Complete, Digits, Json, MaxForce, read_digits, read_max_force, takes_rod
from rodwnl.output import print_json, print_table
from rodwnl.parameters import RodParameters
from rodwnl.report import cell, document, heading, sentences, threshold_entry

if TYPE_CHECKING:
    from rodwnl.spectrum import HopfThreshold


@takes_rod
def command(
    rod: RodParameters,
    max_force: MaxForce = None,
    json: Json = False,
    digits: Digits = None,
    certified: Certified = False,
    complete: Complete = False,
    every: Annotated[
        bool, typer.Option("--all", help="Also list where further eigenvalues cross the imaginary axis.")
    ] = False,
) -> None:
    """Forces at which the straight rod loses or regains stability, with the frequency there."""
    if every and (digits is not None or certified or complete):
        raise InputError(
            "--all lists crossings in double precision: leave out --digits, --certified, --complete"
        )
    if digits is not None or certified or complete:
        from rodwnl.precise import NUMBERS_OF_HOPF, print_precise

        names, wanted = NUMBERS_OF_HOPF, read_digits(digits)
        force = read_max_force(rod, max_force)
        print_precise(rod, force, wanted, names, certified=certified, json=json, complete=complete)
        return
    from rodwnl.spectrum import hopf_thresholds

    search = hopf_thresholds(rod, read_max_force(rod, max_force), all_crossings=every)
    later = search.later or ()
    if json:
        found = document(search, [threshold_entry(t) for t in search])
        print_json(found | ({"later": [_later_entry(t) for t in later]} if every else {}))
        return
    print("\n".join(sentences(search)))
    if search.thresholds:
        print_table(
            ["#", heading(rod, "force"), heading(rod, "omega"), "crossing", "residual"],
            [[str(i), *_cells(rod, t), f"{t.residual:.0e}"] for i, t in enumerate(search, 1)],
        )
    if later:
        print("Further eigenvalues, while others are unstable:")
        print_table(
            [heading(rod, "force"), heading(rod, "omega"), "crossing", "unstable below", "unstable above"],
            [[*_cells(rod, t), str(t.unstable_below), str(t.unstable_above)] for t in later],
        )
    elif every:
        print("No further eigenvalue crosses the imaginary axis.")


def _cells(rod: RodParameters, t: "HopfThreshold") -> list[str]:
    return [
        cell(rod, "force", t.force, t.force_error),
        cell(rod, "omega", t.omega, t.omega_error),
        t.crossing,
    ]


def _later_entry(t: "HopfThreshold") -> dict[str, Any]:
    counts = {"unstable_below": t.unstable_below, "unstable_above": t.unstable_above}
    return threshold_entry(t) | counts
