"""`rodwnl plot`: a picture of a simulation that was written to a file."""

from pathlib import Path
from typing import Annotated

import typer

from rodwnl.errors import InputError

FORMATS = (".png", ".svg", ".pdf")


def command(
    run: Annotated[Path, typer.Argument(metavar="RUN.nc", help="A file written by simulate --out.")],
    out: Annotated[
        Path | None, typer.Option(metavar="PICTURE", help="png, svg or pdf. Default: RUN.png.")
    ] = None,
) -> None:
    """Draw a simulation: its tip over time, and the shapes of its last beat with the follower force."""
    from rodwnl.drawings import one_run, style
    from rodwnl.storage import load, replacing, require_apart, require_writable

    picture = out or run.with_suffix(".png")
    if picture.suffix.lower() not in FORMATS:
        raise InputError(f"cannot draw to {picture.name!r}: its name must end in {', '.join(FORMATS)}")
    require_apart(picture, run)
    require_writable(picture)
    drawing = one_run(load(run))
    with style(), replacing(picture) as temporary:
        drawing.figure.savefig(temporary)
    print(f"wrote {picture}: {drawing.caption}")
