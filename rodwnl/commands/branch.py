"""`rodwnl branch`: the orbits of the full nonlinear rod along the force, from one of its thresholds."""

from fractions import Fraction
from typing import Annotated

import typer

from rodwnl.errors import InputError
from rodwnl.options import Json, MaxForce, read_force, read_max_force, takes_rod
from rodwnl.orbit_report import at_work, branch_entry, print_branch
from rodwnl.output import print_json
from rodwnl.parameters import PLAIN, RodParameters, decimal_text
from rodwnl.report import rod_document, rod_sentence, sentences, with_unit


@takes_rod
def command(
    rod: RodParameters,
    threshold: Annotated[int, typer.Option(metavar="N", help="Which threshold, by increasing force.")] = 1,
    until: Annotated[str | None, typer.Option(metavar="F", help="Stop at this force.")] = None,
    max_points: Annotated[int, typer.Option(metavar="N", help="Stop after so many orbits.")] = 60,
    max_force: MaxForce = None,
    json: Json = False,
) -> None:
    """Follow periodic orbits from a threshold through folds, with their stability.

    The branch goes on to the next Hopf point, the end of 0 < force < k1, the force given by --until or the
    number of points. Folds and other changes of stability are located to 1e-6 in the force. The branch of
    another rod than the plain one, which may bear any force, ends at --max-force too.
    """
    from rodwnl.branches import branch
    from rodwnl.spectrum import hopf_thresholds, searched_range

    if max_points < 1:
        raise InputError(f"max_points is {max_points}, but a branch has at least one point")
    stop = None if until is None else _checked(rod, until)
    search = hopf_thresholds(rod, read_max_force(rod, max_force))
    if not 1 <= threshold <= len(search):
        known = ", ".join(f"{i} at {with_unit(rod, 'force', t.force)}" for i, t in enumerate(search, 1))
        raise InputError(
            f"threshold is {threshold}, but up to force {with_unit(rod, 'force', search.max_force)} the rod "
            + (f"has these: {known}" if known else f"has none. {sentences(search)[-1]}")
        )
    start = search[threshold - 1]
    end = None if stop is None else float(stop)
    farthest = rod.k1 if rod.model == PLAIN else max(search.max_force, stop or 0)
    with at_work(rod) as watch:
        found = branch(
            rod,
            start.force,
            start.omega,
            end,
            (0.0, float(searched_range(rod, farthest)[0])),
            max_points,
            watch,
        )
    if json:
        print_json(
            rod_document(rod)
            | {"threshold": threshold, "until": None if stop is None else decimal_text(stop)}
            | branch_entry(found)
        )
        return
    print(rod_sentence(rod))
    print(f"Orbits from threshold {threshold}, force = {with_unit(rod, 'force', start.force)}:")
    print_branch(rod, found)


def _checked(rod: RodParameters, until: str) -> Fraction:
    return rod.checked_force(read_force(rod, "until", until), "until")
