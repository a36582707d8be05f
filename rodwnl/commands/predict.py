"""`rodwnl predict`: what the amplitude equation says at one force, oscillating or buckled."""

from typing import TYPE_CHECKING, Annotated, Any

import typer

from rodwnl.options import Json, Order, read_force, takes_rod
from rodwnl.order_report import STEADY_IS_CUBIC, read_order
from rodwnl.output import print_json, print_table
from rodwnl.parameters import RodParameters, decimal_text
from rodwnl.report import cell, heading, rod_document, rod_sentence, with_unit

if TYPE_CHECKING:
    from rodwnl.predictions import Buckled, Prediction


@takes_rod
def command(
    rod: RodParameters,
    force: Annotated[str, typer.Option(metavar="F", help="The follower force, 0 <= F < k1.")],
    json: Json = False,
    order: Order = 3,
) -> None:
    """Amplitude and frequency of the tip at one force, from each threshold; where it rests if buckled.

    A branch exists on one side of its threshold only; where the threshold is subcritical it is unstable.
    """
    from rodwnl.predictions import predictions

    exact = read_force(rod, "force", force)
    found = predictions(rod, exact, read_order(order))
    if json:
        entries = [_entry(p) for p in found.oscillating]
        steady = {"steady": [_buckled_entry(p) for p in found.buckled]} if found.buckled else {}
        whole = {"force": decimal_text(exact), "order": order, "predictions": entries} | steady
        print_json(rod_document(rod) | whole)
        return
    print(rod_sentence(rod))
    at = f"at force = {with_unit(rod, 'force', exact)}, one for each"
    if found.oscillating:
        print(f"Predictions {at} threshold:")
        _print_oscillating(rod, found.oscillating)
    if found.buckled:
        print(f"Predictions of the buckled rod {at} steady crossing:")
        _print_buckled(rod, found.buckled)
        if order > 3:
            print(STEADY_IS_CUBIC)
    if not (found.oscillating or found.buckled):
        print("The rod has no Hopf threshold and does not buckle, so there is nothing to predict.")


def _print_oscillating(rod: RodParameters, predictions: "tuple[Prediction, ...]") -> None:
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


def _print_buckled(rod: RodParameters, predictions: "tuple[Buckled, ...]") -> None:
    print_table(
        ["#", f"crossing: {heading(rod, 'force')}", "equilibrium", heading(rod, "y_tip")],
        [
            [
                str(i),
                cell(rod, "force", p.threshold.force, p.threshold.force_error),
                _branch(p),
                cell(rod, "y_tip", p.y_tip, p.y_tip_error),
            ]
            for i, p in enumerate(predictions, 1)
        ],
    )


def _branch(p: "Prediction | Buckled") -> str:
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
    } | _texts(optional)


def _buckled_entry(p: "Buckled") -> dict[str, Any]:
    return {
        "threshold": repr(p.threshold.force),
        "criticality": p.pitchfork.criticality,
        "side": p.side,
        "exists": p.exists,
        "stable": p.stable,
    } | _texts({"y_tip": p.y_tip, "y_tip_error": p.y_tip_error})


def _texts(numbers: dict[str, float | None]) -> dict[str, str | None]:
    return {name: None if value is None else repr(value) for name, value in numbers.items()}
