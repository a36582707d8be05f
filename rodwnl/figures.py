"""The paper's figures and the mode shapes: computed (`figuredata`), drawn (`drawings`), written.

Each is written as SVG and PNG, with its data (CSV) and its caption (text) beside it.
"""

from __future__ import annotations

import csv
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

from rodwnl import drawings
from rodwnl.drawings import Drawing
from rodwnl.figuredata import Column, Watch, beating, comparison, eigenvalue_path, paper_columns
from rodwnl.reduced import reduced_model
from rodwnl.storage import replacing


def draw_all(folder: Path, watch: Watch = lambda text: None, quick: bool = False) -> tuple[Path, ...]:
    """Compute and write every figure; the bitmap files in the order of the paper.

    quick: fewer simulations. Raises OSError where the folder cannot be written.
    """
    written = []
    for drawing in computed(watch, quick):
        watch(f"writing {drawing.name}")
        written.append(write(drawing, folder))
    return tuple(written)


def computed(watch: Watch, quick: bool = False) -> Iterator[Drawing]:
    """The figures one after the other, so that none is lost when a later one fails."""
    columns = paper_columns()
    watch("eigenvalues")
    paths = [eigenvalue_path(c, *_range(c)) for c in columns[:3]]
    yield drawings.hopf(columns[2:], paths[2])
    yield drawings.beta_check(columns, paths)
    watch("modes")
    yield drawings.modes([reduced_model(c.rod, repr(c.coefficients.force), c.coefficients) for c in columns])
    watch("simulating the beating rod")
    yield drawings.nonlinear(beating(columns[0]))
    yield drawings.compared([comparison(column, watch, quick) for column in columns])


def _range(column: Column) -> tuple[float, float]:
    """Forces over which eigenvalues are drawn: around the threshold, or all of a rod that restabilises."""
    k1, force = float(column.rod.k1), column.coefficients.force
    return (0.01 * k1, 0.86 * k1) if k1 < 1000 else (0.3 * force, 1.5 * force)


def write(drawing: Drawing, folder: Path) -> Path:
    """Put name.svg, name.png, name.csv and name.txt (the caption) into the folder, each in one piece."""
    folder.mkdir(parents=True, exist_ok=True)

    def place(suffix: str, save: Callable[[Path], Any]) -> Path:
        path = folder / f"{drawing.name}{suffix}"
        with replacing(path) as temporary:
            save(temporary)
        return path

    def table(path: Path) -> None:
        with path.open("w", newline="", encoding="utf-8") as file:
            csv.writer(file, lineterminator="\n").writerows([drawing.header, *drawing.rows])

    with drawings.style():
        place(".svg", lambda path: drawing.figure.savefig(path, metadata={"Date": None}))
        picture = place(".png", lambda path: drawing.figure.savefig(path))
    place(".csv", table)
    place(".txt", lambda path: path.write_text(drawing.caption + "\n", encoding="utf-8"))
    return picture
