"""`rodwnl atlas`: where in parameter space rods flutter, up to which force, and how the flutter begins."""

import sys
from pathlib import Path
from typing import Annotated, Any

import typer

from rodwnl.errors import InputError
from rodwnl.options import Model, Parameter, read_model
from rodwnl.parameters import PLAIN, exact


def command(
    out: Annotated[Path, typer.Option(metavar="DIR", help="The folder to write.")] = Path("atlas"),
    points: Annotated[int, typer.Option(metavar="N", help="Rods along each side of a map.")] = 160,
    workers: Annotated[int | None, typer.Option(metavar="N", help="Processes. Default: one a core.")] = None,
    overwrite: Annotated[bool, typer.Option("--overwrite", help="Replace an earlier atlas.")] = False,
    model: Model = None,
    parameter: Parameter = None,
) -> None:
    """Compute and draw the maps of criticality: three planes (k1, k2), and one plane (k1, gamma3).

    Each map shows where there is no flutter, flutter without upper bound, or a window of it; where the lower
    and the upper thresholds are super- or subcritical; and the curves between these regions.
    """
    from rodwnl.atlas import make
    from rodwnl.storage import require_apart

    if points < 2:
        raise InputError(f"--points is {points}, but a map needs at least 2 rods along each side")
    if workers is not None and not 1 <= workers <= 1024:
        raise InputError(f"--workers is {workers}, but it must be a whole number from 1 to 1024")
    if out.is_dir() and any(out.iterdir()) and not overwrite:
        raise InputError(f"{out} is not empty: give --overwrite to replace the atlas in it, or another --out")
    if out.exists() and not out.is_dir():
        raise InputError(f"{out} is not a folder")
    require_apart(out, model)
    other: dict[str, Any] = read_model(model, parameter or [])
    name = other.pop("model", PLAIN)
    own = {n: float(exact(n, text)) for n, text in other.items()}
    make(out, points, workers, lambda text: print(text, file=sys.stderr), name, own)
    print(f"{out}: maps (.svg, .png), data (.nc), special curves (.csv), counts and witnesses (summary.json)")
