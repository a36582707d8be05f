"""`rodwnl figures`: the paper's figures from computed data."""

import sys
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
    from rodwnl.storage import require_writable

    out.mkdir(parents=True, exist_ok=True)
    require_writable(out / "figure.png")
    for picture in draw_all(out, _watch, quick):
        print(f"wrote {picture} (and .svg, .csv, .txt)")


def _watch(text: str) -> None:
    """What is being done, on stderr; one line that is overwritten where that is a terminal."""
    if sys.stderr.isatty():
        print(f"\r\033[K{text}", end="", file=sys.stderr, flush=True)
