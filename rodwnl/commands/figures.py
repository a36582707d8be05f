"""`rodwnl figures`: the paper's figures from computed data."""

from pathlib import Path
from typing import Annotated

import typer


def command(
    out: Annotated[Path, typer.Option(metavar="FOLDER", help="Where to put them.")] = Path("figures"),
    quick: Annotated[bool, typer.Option("--quick", help="Fewer simulations in the comparison.")] = False,
) -> None:
    """Compute and draw the paper's figures and the mode shapes.

    Each is written as SVG and PNG, with its data as CSV and its caption as text beside it.
    """
    from rodwnl.figures import draw_all
    from rodwnl.progress import progress
    from rodwnl.storage import require, require_writable

    require("matplotlib", "figures")
    require("sksundae", "simulate")
    out.mkdir(parents=True, exist_ok=True)
    require_writable(out / "figure.png")
    with progress() as watch:
        written = draw_all(out, watch, quick)
    for figure in written:
        print(f"wrote {figure.path('.png')} (and .svg, .csv, .txt)")
