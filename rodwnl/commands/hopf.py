"""`rodwnl hopf`: the forces at which the straight rod starts or stops to flutter."""

from rodwnl.options import Certified, Complete, Digits, Json, MaxForce, read_digits, read_max_force, takes_rod
from rodwnl.output import print_json, print_table
from rodwnl.parameters import RodParameters
from rodwnl.report import cell, document, heading, sentences, threshold_entry


@takes_rod
def command(
    rod: RodParameters,
    max_force: MaxForce = None,
    json: Json = False,
    digits: Digits = None,
    certified: Certified = False,
    complete: Complete = False,
) -> None:
    """Forces at which the straight rod loses or regains stability, with the frequency there."""
    if digits is not None or certified or complete:
        from rodwnl.precise import NUMBERS_OF_HOPF, print_precise

        names, wanted = NUMBERS_OF_HOPF, read_digits(digits)
        force = read_max_force(rod, max_force)
        print_precise(rod, force, wanted, names, certified=certified, json=json, complete=complete)
        return
    from rodwnl.spectrum import hopf_thresholds

    search = hopf_thresholds(rod, read_max_force(rod, max_force))
    if json:
        print_json(document(search, [threshold_entry(t) for t in search]))
        return
    print("\n".join(sentences(search)))
    if search.thresholds:
        print_table(
            ["#", heading(rod, "force"), heading(rod, "omega"), "crossing", "residual"],
            [
                [
                    str(i),
                    cell(rod, "force", t.force, t.force_error),
                    cell(rod, "omega", t.omega, t.omega_error),
                    t.crossing,
                    f"{t.residual:.0e}",
                ]
                for i, t in enumerate(search, 1)
            ],
        )
