"""The paper's figures and the mode shapes: computed (`figuredata`), drawn (`drawings`), written.

Each is written as SVG and PNG, with its data (CSV) and its caption (text) beside it.
"""

from __future__ import annotations

import csv
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import Executor, Future
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
    coexisting,
    eigenvalue_path,
    orbits,
    paper_columns,
    simulated,
    starts,
    theory,
)
from rodwnl.progress import Watch, silent
from rodwnl.reduced import reduced_model
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
) -> tuple[Written, ...]:
    """Compute and write every figure on so many processes (default: one a core), in the order of NAMES.

    quick: fewer simulations in the comparison. each: called with a figure as soon as it is written. Raises
    OSError where the folder cannot be written, ComputationError where something could not be computed. A
    script that calls this needs the guard `if __name__ == "__main__":`.
    """
    finished = []
    with processes(workers) as pool:
        for drawing in computed(pool, watch, quick):
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


def computed(pool: Executor, watch: Watch = silent, quick: bool = False) -> Iterator[Drawing]:
    """The figures one after the other, so that none is lost when a later one fails."""
    columns, jobs = paper_columns(), Jobs(pool, watch)
    spectra = [jobs.submit("eigenvalues", eigenvalue_path, c, *_range(c)) for c in columns[:3]]
    # The longest first: the branch through the fold
    followed = [
        jobs.submit(f"orbits from force {c.coefficients.force:.6g}", orbits, c) for c in reversed(columns)
    ][::-1]
    beat = jobs.submit("beating rod", beating, columns[0])
    points = [jobs.simulations(column, starts(column, quick)) for column in columns]

    paths = [path.result() for path in spectra]
    yield drawings.hopf(columns[2:], paths[2])
    yield drawings.beta_check(columns, paths)
    yield drawings.modes([reduced_model(c.rod, repr(c.coefficients.force), c.coefficients) for c in columns])
    yield drawings.nonlinear(beat.result())
    if not quick:
        for column, branch, some in zip(columns, followed, points, strict=True):
            some += jobs.simulations(column, coexisting(column, branch.result()[1]))
    yield drawings.compared(
        [
            Comparison(column, theory(column), tuple(point.result() for point in some), *branch.result())
            for column, branch, some in zip(columns, followed, points, strict=True)
        ]
    )


def _range(column: Column) -> tuple[float, float]:
    """Forces over which eigenvalues are drawn: around the threshold, or all of a rod that restabilises."""
    k1, force = float(column.rod.k1), column.coefficients.force
    return (0.01 * k1, 0.86 * k1) if k1 < 1000 else (0.3 * force, 1.5 * force)


def write(drawing: Drawing, folder: Path) -> Written:
    """Put name.svg, name.png, name.csv and name.txt (the caption) into the folder, each in one piece."""
    folder.mkdir(parents=True, exist_ok=True)
    written = Written(folder, drawing.name, drawing.caption)

    def place(suffix: str, save: Callable[[Path], Any]) -> None:
        with replacing(written.path(suffix)) as temporary:
            save(temporary)

    def table(path: Path) -> None:
        with path.open("w", newline="", encoding="utf-8") as file:
            csv.writer(file, lineterminator="\n").writerows([drawing.header, *drawing.rows])

    with drawings.style():
        place(".svg", lambda path: drawing.figure.savefig(path, metadata={"Date": None}))
        place(".png", lambda path: drawing.figure.savefig(path))
    place(".csv", table)
    place(".txt", lambda path: path.write_text(drawing.caption + "\n", encoding="utf-8"))
    return written
