"""`rodwnl figures`: the paper's figures from computed data."""

from pathlib import Path
from typing import Annotated, Any

import typer

from rodwnl.errors import InputError
from rodwnl.options import Model, Parameter, read_model
from rodwnl.parameters import RodParameters

Value = Annotated[str | None, typer.Option(metavar="X", help="Of a rod to draw instead of the paper's.")]


def command(
    out: Annotated[Path, typer.Option(metavar="FOLDER", help="Where to put them.")] = Path("figures"),
    quick: Annotated[bool, typer.Option("--quick", help="Fewer simulations in the comparison.")] = False,
    model: Model = None,
    parameter: Parameter = None,
    k1: Value = None,
    k2: Value = None,
    gamma3: Value = None,
    gamma1: Value = None,
) -> None:
    """Compute and draw the paper's figures and the mode shapes.

    Each is written as SVG and PNG, with its data as CSV and its caption as text beside it. With --model they
    show the paper's three rods made of that one, with --k1, --k2 and --gamma3 the rod that these describe.
    """
    from rodwnl.figuredata import columns_of
    from rodwnl.figures import draw_all
    from rodwnl.progress import progress
    from rodwnl.storage import require, require_apart, require_writable

    require("matplotlib", "figures")
    require("sksundae", "simulate")
    basic = {
        name: value
        for name, value in (("k1", k1), ("k2", k2), ("gamma3", gamma3), ("gamma1", gamma1))
        if value is not None
    }
    rods = _rods(basic, read_model(model, parameter or []))
    columns = columns_of(rods) if rods else None
    require_apart(out, model)
    out.mkdir(parents=True, exist_ok=True)
    require_writable(out / "figure.png")
    with progress() as watch:
        written = draw_all(out, watch, quick, columns=columns)
    for figure in written:
        print(f"wrote {figure.path('.png')} (and .svg, .csv, .txt)")


def _rods(basic: dict[str, str], model: dict[str, Any]) -> list[RodParameters]:
    """The rod that was described, or the paper's rods of another model; none: the paper's own."""
    if basic:
        if missing := [f"--{name}" for name in ("k1", "k2", "gamma3") if name not in basic]:
            raise InputError(f"a rod for the figures also needs {' and '.join(missing)}")
        given: dict[str, Any] = basic | model
        return [RodParameters(**given)]
    if not model:
        return []
    from rodwnl.tables import printed_rows

    papers = dict.fromkeys(row.rod for row in printed_rows() if row.table == "tab:parameters")
    return [RodParameters(rod.k1, rod.k2, rod.gamma3, rod.gamma1, **model) for rod in papers]
