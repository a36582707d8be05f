"""`rodwnl predict`: what the amplitude equation says at one force."""

from typing import TYPE_CHECKING, Annotated, Any

import typer

from rodwnl.options import Json, Order, read_force, takes_rod
from rodwnl.order_report import read_order
from rodwnl.output import print_json, print_table
from rodwnl.parameters import RodParameters, decimal_text
from rodwnl.report import cell, heading, rod_document, rod_sentence, with_unit

if TYPE_CHECKING:
    from rodwnl.predictions import Prediction


@takes_rod
def command(
    rod: RodParameters,
    force: Annotated[str, typer.Option(metavar="F", help="The follower force, 0 <= F < k1.")],
    json: Json = False,
    order: Order = 3,
) -> None:
    """Amplitude and frequency of the tip at one force, from each threshold.

    A branch exists on one side of its threshold only; where the threshold is subcritical it is unstable.
    """
    from rodwnl.predictions import predict

    exact = read_force(rod, "force", force)
    predictions = predict(rod, exact, read_order(order))
    if json:
        entries = [_entry(p) for p in predictions]
        print_json(rod_document(rod) | {"force": decimal_text(exact), "order": order, "predictions": entries})
        return
    print(rod_sentence(rod))
    if not predictions:
        print("The rod has no Hopf threshold, so there is nothing to predict.")
        return
    print(f"Predictions at force = {with_unit(rod, 'force', exact)}, one for each threshold:")
    print_table(
        ["#", f"threshold: {heading(rod, 'force')}", "branch", heading(rod, "A_tip"), heading(rod, "omega")],
        [
            [
                str(i),
                cell(rod, "force", p.coefficients.force, p.coefficients.threshold.force_error),
                _branch(p),
                cell(rod, "A_tip", p.A_tip, p.A_tip_error),
                cell(rod, "omega", p.omega, p.omega_error),
            ]
            for i, p in enumerate(predictions, 1)
        ],
    )


def _branch(p: "Prediction") -> str:
    if p.exists:
        return "stable" if p.stable else "unstable"
    return "undecided at third order" if p.side is None else f"none here: it lies {p.side} the threshold"


def _entry(p: "Prediction") -> dict[str, Any]:
    optional = {
        "A_tip": p.A_tip,
        "omega": p.omega,
        "A_tip_error": p.A_tip_error,
        "omega_error": p.omega_error,
    }
    return {
        "threshold": repr(p.coefficients.force),
        "criticality": p.coefficients.criticality,
        "side": p.side,
        "exists": p.exists,
        "stable": p.stable,
    } | {name: None if value is None else repr(value) for name, value in optional.items()}
