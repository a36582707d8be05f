"""The paper's figures and the mode shapes, of its rods or of others: computed (`figuredata`), drawn
(`drawings`), written.

Each is written as SVG and PNG, with its data (CSV) and its caption (text) beside it.
"""

from __future__ import annotations

import csv
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import Executor, Future
from contextlib import ExitStack
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from rodwnl import drawings
from rodwnl.drawings import Drawing
from rodwnl.figuredata import (
    Column,
    Comparison,
    SimulatedPoint,
    beating,
    beating_like_the_papers,
    by_rod,
    coexisting,
    eigenvalue_path,
    orbits,
    paper_columns,
    simulated,
    starts,
    theory,
)
from rodwnl.parameters import PLAIN
from rodwnl.progress import Watch, silent
from rodwnl.reduced import reduced_model
from rodwnl.spectrum import searched_range
from rodwnl.storage import replacing
from rodwnl.workers import processes

NAMES = ("hopf", "nonlinear", "comparison", "beta_check", "modes")  # the paper's order, then our own


@dataclass(frozen=True)
class Written:
    """A figure on the disk: `folder`/`name`.svg, .png, .csv and .txt, the last of which is the caption."""

    folder: Path
    name: str
    caption: str

    def path(self, suffix: str) -> Path:
        return self.folder / f"{self.name}{suffix}"


def draw_all(
    folder: Path,
    watch: Watch = silent,
    quick: bool = False,
    workers: int | None = None,
    each: Callable[[Written], None] = lambda written: None,
    columns: Sequence[Column] | None = None,
) -> tuple[Written, ...]:
    """Compute and write every figure on so many processes (default: one a core), in the order of NAMES.

    columns: the rods and thresholds (default: the paper's); those of one rod stand together. quick: fewer
    simulations in the comparison. each: called with a figure as soon as it is written. Raises OSError where
    the folder cannot be written, ComputationError where something could not be computed. A script that calls
    this needs the guard `if __name__ == "__main__":`.
    """
    finished = []
    with processes(workers) as pool:
        for drawing in computed(pool, watch, quick, columns):
            finished.append(write(drawing, folder))
            each(finished[-1])
    return tuple(sorted(finished, key=lambda written: NAMES.index(written.name)))


class Jobs:
    """What an executor computes for the figures; `watch` is told of each result."""

    def __init__(self, pool: Executor, watch: Watch) -> None:
        self.pool, self.watch = pool, watch
        self.done = self.total = 0

    def submit(self, text: str, function: Callable[..., Any], *arguments: Any) -> Future[Any]:
        def tell(future: Future[Any]) -> None:
            if not future.cancelled():
                self.done += 1
                self.watch(text, self.done, self.total)

        self.total += 1
        future = self.pool.submit(function, *arguments)
        future.add_done_callback(tell)
        return future

    def simulations(
        self, column: Column, beginnings: Sequence[tuple[float, float]]
    ) -> list[Future[SimulatedPoint]]:
        k1 = float(column.rod.k1)
        return [
            self.submit(f"simulation, k1 = {k1:g}, force {force:.6g}", simulated, column, force, size)
            for force, size in beginnings
        ]


def computed(
    pool: Executor, watch: Watch = silent, quick: bool = False, columns: Sequence[Column] | None = None
) -> Iterator[Drawing]:
    """The figures one after the other, so that none is lost when a later one fails."""
    jobs = Jobs(pool, watch)
    if columns is None:
        columns = paper_columns()
        runs: list[Any] = [(columns[0],)]
    else:
        runs = beating_like_the_papers(columns)
    rods = by_rod(columns)
    most = max(range(len(rods)), key=lambda i: len(rods[i]))
    spectra = [jobs.submit("eigenvalues", eigenvalue_path, rod[0], *_range(rod)) for rod in rods]
    # The longest first: the branch through the fold
    followed = [
        jobs.submit(f"orbits from force {c.coefficients.force:.6g}", orbits, c) for c in reversed(columns)
    ][::-1]
    beat = [jobs.submit("beating rod", beating, *run) for run in runs]
    points = [jobs.simulations(column, starts(column, quick)) for column in columns]

    paths = [path.result() for path in spectra]
    yield drawings.hopf(rods[most], paths[most])
    yield drawings.beta_check(columns, paths)
    yield drawings.modes([reduced_model(c.rod, repr(c.coefficients.force), c.coefficients) for c in columns])
    for settled in beat:
        yield drawings.nonlinear(settled.result())
    if not quick:
        for column, branch, some in zip(columns, followed, points, strict=True):
            some += jobs.simulations(column, coexisting(column, branch.result()[1]))
    yield drawings.compared(
        [
            Comparison(column, theory(column), tuple(point.result() for point in some), *branch.result())
            for column, branch, some in zip(columns, followed, points, strict=True)
        ]
    )


def _range(rod: Sequence[Column]) -> tuple[float, float]:
    """Forces over which eigenvalues are drawn: around the threshold, or over all that a rod bears."""
    lowest, highest = (float(rod[k].coefficients.force) for k in (0, -1))
    k1 = float(rod[0].rod.k1)
    if rod[0].rod.model == PLAIN:
        return (0.0, 0.86 * k1) if k1 < 1000 else (0.3 * lowest, 1.5 * lowest)
    wanted = (1.5 if rod[-1].side > 0 else 1.1) * highest
    return 0.3 * lowest, min(wanted, 0.98 * float(searched_range(rod[0].rod, wanted)[0]))


def write(drawing: Drawing, folder: Path) -> Written:
    """Put name.svg, name.png, name.csv and name.txt (the caption) into the folder: all of them or none."""
    folder.mkdir(parents=True, exist_ok=True)
    written = Written(folder, drawing.name, drawing.caption)
    with ExitStack() as places, drawings.style():
        svg, png, table, text = (
            places.enter_context(replacing(written.path(suffix)))
            for suffix in (".svg", ".png", ".csv", ".txt")
        )
        drawing.figure.savefig(svg, metadata={"Date": None})
        drawing.figure.savefig(png)
        with table.open("w", newline="", encoding="utf-8") as file:
            csv.writer(file, lineterminator="\n").writerows([drawing.header, *drawing.rows])
        text.write_text(drawing.caption + "\n", encoding="utf-8")
    return written
