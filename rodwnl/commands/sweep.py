"""`rodwnl sweep`: thresholds and coefficients of all rods of a grid, in one file."""

import sys
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from rodwnl.errors import InputError
from rodwnl.options import Model, Parameter, read_assignments

if TYPE_CHECKING:
    from rodwnl.sweep import Progress

QUIET = 10.0  # seconds between two lines of progress where there is no terminal


def command(
    grid: Annotated[Path, typer.Argument(metavar="GRID.toml", help="The rods: a grid or a sampling.")],
    out: Annotated[
        Path | None, typer.Option(metavar="FILE.nc|DIR.zarr", help="Default: beside the grid, GRID.nc.")
    ] = None,
    workers: Annotated[
        str | None, typer.Option(metavar="N", help="Processes on this machine. Default: one a core.")
    ] = None,
    scheduler: Annotated[
        str | None, typer.Option(metavar="tcp://HOST:PORT", help="Compute on this Dask cluster instead.")
    ] = None,
    resume: Annotated[bool, typer.Option("--resume", help="Go on with what an earlier run left.")] = False,
    overwrite: Annotated[bool, typer.Option("--overwrite", help="Remove an earlier output first.")] = False,
    model: Model = None,
    parameter: Parameter = None,
) -> None:
    r"""Compute every rod of a grid: all thresholds, alpha, beta, and a status per rod, as netCDF or zarr.

    The grid is a TOML file: a table \[k1] with log = [20, 1e6] and points = 100 (or linear, values, value),
    the same for k2, gamma3, gamma1. With model = "NAME|FILE" it is about another rod, whose own parameters
    are tables too. With a table \[sampling] (method sobol or latin-hypercube, points, seed) rods are drawn
    from these ranges. A run that was interrupted, even killed, goes on with --resume.
    """
    from rodwnl.grids import read_grid
    from rodwnl.sweep import sweep

    if workers is not None and scheduler is not None:
        raise InputError("--workers is for this machine and --scheduler for another: give one of them")
    number = None if workers is None else _count(workers)
    rods = read_grid(grid, model, read_assignments(parameter or []))
    path = out or grid.with_suffix(".nc")
    with _progress() as progress:
        sweep(
            rods,
            path,
            workers=number,
            scheduler=scheduler,
            resume=resume,
            overwrite=overwrite,
            progress=progress,
        )
    dimensions = " x ".join(f"{name} {n}" for name, n in zip(rods.dims, rods.shape, strict=True))
    print(f"{path}: {rods.size} rods, {dimensions}")


def _count(text: str) -> int:
    if not text.isascii() or not text.isdigit() or not 1 <= int(text) <= 1024:
        raise InputError(f"--workers is {text!r}, but it must be a whole number from 1 to 1024")
    return int(text)


@contextmanager
def _progress() -> "Iterator[Progress]":
    """Rods done, rate and time left: a bar on a terminal's stderr, now and then a line elsewhere."""
    if sys.stderr.isatty():
        from rich.console import Console
        from rich.progress import BarColumn, MofNCompleteColumn, TextColumn, TimeRemainingColumn
        from rich.progress import Progress as Bar

        columns = BarColumn(), MofNCompleteColumn(), TextColumn("{task.fields[rate]}"), TimeRemainingColumn()
        with Bar(*columns, console=Console(stderr=True)) as bar:
            task = bar.add_task("", total=None, rate="")
            meter = _Meter()
            yield lambda done, total: bar.update(task, completed=done, total=total, rate=meter.rate(done))
        return
    meter = _Meter()

    def line(done: int, total: int) -> None:
        rate = meter.rate(done)
        if meter.due() or (done == total and rate):
            print(f"{done} of {total} rods{rate}{meter.remaining(done, total)}", file=sys.stderr)

    yield line


class _Meter:
    """Rate and remaining time from the first report on."""

    def __init__(self) -> None:
        self.start: tuple[float, int] | None = None
        self.last = time.monotonic()
        self.speed = 0.0

    def rate(self, done: int) -> str:
        now = time.monotonic()
        self.start = self.start or (now, done)
        elapsed = now - self.start[0]
        self.speed = (done - self.start[1]) / elapsed if elapsed > 0 else 0.0
        return f", {self.speed:.0f} rods/s" if self.speed else ""

    def remaining(self, done: int, total: int) -> str:
        return f", {(total - done) / self.speed:.0f} s left" if self.speed else ""

    def due(self) -> bool:
        now = time.monotonic()
        if now - self.last < QUIET:
            return False
        self.last = now
        return True
