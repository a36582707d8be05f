"""Everything the paper's numbers rest on, made anew into one folder: tables, ledger of equations, figures.

index.html shows all of it without a network; ledger.html holds every equation; figures/ the figures with
their data; reproduction.json the same for programs. The index is written again after each step, so that an
interrupted run leaves a page that is true of what stands beside it.
"""

from __future__ import annotations

import hashlib
import json
import platform
from dataclasses import dataclass, replace
from html import escape
from importlib.metadata import PackageNotFoundError, version
from importlib.resources import files
from pathlib import Path
from string import Template
from typing import TYPE_CHECKING, Any
from urllib.parse import quote

from rodwnl import __version__
from rodwnl.output import complex_number, full_texts, number
from rodwnl.progress import Watch, silent
from rodwnl.storage import replacing, require, require_writable
from rodwnl.tables import Cell, PrintedRow, compared_rows

if TYPE_CHECKING:
    from rodwnl.figures import Written
    from rodwnl.verification import Report

INDEX, LEDGER, DOCUMENT, FIGURES = "index.html", "ledger.html", "reproduction.json", "figures"
LEFT_OUT = (
    "the figure of theory and simulation shows every other simulation and not the two at one force in the "
    "bistable interval; everything else is complete"
)
SOURCES = (
    ("rodwnl", "data/tables.toml"),
    ("rodwnl", "data/errata.toml"),
    ("derivation", "paper/equations.tex"),
)
PACKAGES = ("numpy", "scipy", "sympy", "lark", "matplotlib", "scikit-sundae")
LABELS = {"force": "F<sub>c</sub>", "omega": "ω<sub>c</sub>", "alpha": "α", "beta": "β",
          "growth_slope": "d Re λ/dF", "frequency_slope": "d Im λ/dF"}  # fmt: skip

Rows = tuple[tuple[PrintedRow, tuple[Cell, ...]], ...]


@dataclass(frozen=True)
class Reproduction:
    """What was made so far. exact: thresholds to the digits asked for. finished: nothing is missing."""

    folder: Path
    quick: bool
    rows: Rows
    exact: list[dict[str, Any]]
    report: Report
    figures: tuple[Written, ...] = ()
    finished: bool = False

    @property
    def cells(self) -> list[Cell]:
        return [cell for _, cells in self.rows for cell in cells]

    @property
    def cell_counts(self) -> dict[str, int]:
        return count_cells(self.cells)

    @property
    def differs(self) -> bool:
        """Whether a table cell or an equation does not hold, reviewed errata aside."""
        return bool(self.cell_counts["differs"]) or self.report.differs


def count_cells(cells: list[Cell]) -> dict[str, int]:
    """Table cells by status."""
    return {status: sum(c.status == status for c in cells) for status in ("numeric", "erratum", "differs")}


def prepare(folder: Path) -> None:
    """Before the work: make the folders. Raises InputError or OSError where nothing could be written."""
    require("matplotlib", "figures")
    require("sksundae", "simulate")
    (folder / FIGURES).mkdir(parents=True, exist_ok=True)
    for name in (INDEX, LEDGER, DOCUMENT, f"{FIGURES}/hopf.svg"):
        require_writable(folder / name)


def reproduce(
    folder: Path,
    exact: list[dict[str, Any]],
    watch: Watch = silent,
    quick: bool = False,
    workers: int | None = None,
) -> Reproduction:
    """Make all of it in a folder that `prepare` has seen; see `figures.draw_all` for what it may raise.

    quick: without LEFT_OUT. workers: processes for the figures (default: one a core).
    """
    from rodwnl.figures import NAMES, draw_all
    from rodwnl.ledgerpage import write_page
    from rodwnl.verification import check

    watch("the ledger of equations", 0, 1)
    made = Reproduction(folder, quick, compared_rows(), exact, check())
    write_page(folder / LEDGER, made.report)
    _write(folder / INDEX, page(made))

    def add(figure: Written) -> None:
        nonlocal made
        figures = sorted([*made.figures, figure], key=lambda one: NAMES.index(one.name))
        made = replace(made, figures=tuple(figures))
        _write(folder / INDEX, page(made))

    draw_all(folder / FIGURES, watch, quick, workers, add)
    made = replace(made, finished=True)
    _write(
        folder / DOCUMENT, json.dumps(document(made), indent=2, ensure_ascii=False, allow_nan=False) + "\n"
    )
    _write(folder / INDEX, page(made))
    return made


def _write(path: Path, text: str) -> None:
    with replacing(path) as temporary:
        temporary.write_text(text, encoding="utf-8")


def tables_document(rows: Rows, exact: list[dict[str, Any]]) -> dict[str, Any]:
    """The part of the JSON document that speaks of the tables."""
    cells = [cell for _, row_cells in rows for cell in row_cells]
    return {"tables": [_entry(cell) for cell in cells], "counts": count_cells(cells), "exact": exact}


def document(made: Reproduction) -> dict[str, Any]:
    """The JSON document; paths are relative to the folder."""
    labels = {
        status: [f.label for f in made.report.findings if f.row.status == status]
        for status in ("differs", "not decided")
    }
    suffixes = (".svg", ".png", ".csv", ".txt")
    figures = [
        {"name": f.name, "caption": f.caption, "files": [f"{FIGURES}/{f.name}{s}" for s in suffixes]}
        for f in made.figures
    ]
    return {
        **tables_document(made.rows, made.exact),
        "equations": {"counts": made.report.counts, **labels, "file": LEDGER},
        "figures": figures,
        "left_out": LEFT_OUT if made.quick else None,
        "made_from": made_from(),
    }


def _entry(cell: Cell) -> dict[str, Any]:
    texts = ("table", "row", "column", "method", "printed", "computed", "status", "remark")
    values = {"value": full_texts(cell.value), "independent": full_texts(cell.independent)}
    return {name: getattr(cell, name) for name in texts} | values | {"agreement": cell.agreement}


def made_from() -> dict[str, str]:
    """Versions of the programs, and SHA-256 sums of what the paper prints and of the derived modules."""
    from rodwnl.kernels import fingerprint

    def of(package: str) -> str:
        try:
            return version(package)
        except PackageNotFoundError:
            return "unknown"

    def digest(package: str, name: str) -> str:
        return hashlib.sha256(files(package).joinpath(name).read_bytes()).hexdigest()

    versions = {"rodwnl": __version__, "Python": platform.python_version()}
    versions |= {package: of(package) for package in PACKAGES}
    versions |= {f"{package}/{name}": f"sha256 {digest(package, name)}" for package, name in SOURCES}
    return versions | {"generated/follower": f"sha256 {fingerprint('follower')}"}


def page(made: Reproduction) -> str:
    """The index page as HTML."""
    template = Template(files("rodwnl").joinpath("data/reproduction.html").read_text(encoding="utf-8"))
    names = dict.fromkeys(row.table for row, _ in made.rows)
    return template.substitute(
        note=_note(made),
        cell_counts=_counts(made.cell_counts, "cells"),
        tables="".join(_table(name, [r for r in made.rows if r[0].table == name]) for name in names),
        exceptions=_exceptions([cell for cell in made.cells if cell.status != "numeric"]),
        exact="".join(map(_exact, made.exact)),
        equation_counts=_counts(made.report.counts, "equations"),
        ledger=LEDGER,
        wrong=_wrong(made.report),
        figures="".join(map(_figure, made.figures)),
        made_from="".join(_line("td", [name, text], "name", "name") for name, text in made_from().items()),
    )


def _note(made: Reproduction) -> str:
    notes = [] if made.finished else ["This run did not finish, or has not yet: figures are missing."]
    if made.quick:
        notes.append(f"Made by <code>rodwnl reproduce --quick</code>: {LEFT_OUT}.")
    return "".join(f'<p class="note">{note}</p>' for note in notes)


def _counts(counts: dict[str, int], what: str) -> str:
    parts = [
        f'{count} <span class="{status.replace(" ", "-") if count else ""}">{status}</span>'
        for status, count in counts.items()
    ]
    return f"{sum(counts.values())} {what}: {', '.join(parts)}"


def _line(tag: str, texts: list[str], *classes: str, row: str = "") -> str:
    """A row of a table from texts that are HTML already; the first ones bear the classes."""
    marks = [f' class="{name}"' for name in classes] + [""] * len(texts)
    inner = "".join(f"<{tag}{mark}>{text}</{tag}>" for mark, text in zip(marks, texts, strict=False))
    return f"<tr{f' class={row!r}' if row else ''}>{inner}</tr>\n"


def _table(name: str, rows: list[tuple[PrintedRow, tuple[Cell, ...]]]) -> str:
    """A line as printed and one for each way of computing it, in the paper's order."""
    columns = list(rows[0][0].cells)
    lines = [
        _line("th", ["row", "rod", "", *(LABELS.get(c, escape(c)) for c in columns)], "name", "name", "name")
    ]
    for row, cells in rows:
        rod = ", ".join(f"{key} = {text}" for key, text in row.rod.texts().items() if key != "gamma1")
        printed = [escape(row.name), escape(rod), "printed", *map(escape, row.cells.values())]
        lines.append(_line("td", printed, "name", "name", "name", row="printed"))
        for method in dict.fromkeys(cell.method for cell in cells):
            by_column = {c.column: _marked(c) for c in cells if c.method == method}
            found = ["", "", escape(method or "computed"), *(by_column.get(c, "") for c in columns)]
            lines.append(_line("td", found, "name", "name", "name", row="computed"))
    return f'<h3>{escape(name)}</h3><div class="scroll"><table>\n{"".join(lines)}</table></div>\n'


def _marked(cell: Cell) -> str:
    word = "" if cell.status == "numeric" else f"<small>{cell.status}</small> "
    return f'<span class="{cell.status}">{word}{escape(cell.computed)}</span>'


def _exceptions(cells: list[Cell]) -> str:
    if not cells:
        return ""
    headings = ["cell", "", "printed", "computed", "independent", "digits that agree"]
    lines, evidence = [_line("th", headings, "name")], ""
    for cell in cells:
        column = LABELS.get(cell.column, escape(cell.column)) + (f" ({cell.method})" if cell.method else "")
        status = f'<span class="{cell.status}">{cell.status}</span>'
        place = f"{escape(cell.table)} {escape(cell.row)} {column}"
        shown = [escape(cell.printed), _digits(cell.value), _digits(cell.independent), str(cell.agreement)]
        lines.append(_line("td", [place, status, *shown], "name", "name"))
        evidence += f"<li>{place}: {escape(cell.remark or 'not a reviewed erratum')}</li>\n"
    title = "<h3>Cells that do not hold to their printed digits</h3>"
    return f'{title}<div class="scroll"><table>\n{"".join(lines)}</table></div>\n<ul>{evidence}</ul>\n'


def _digits(value: complex) -> str:
    return complex_number(value) if isinstance(value, complex) else number(value)


def _exact(entry: dict[str, Any]) -> str:
    values = {LABELS["force"]: entry["force"], LABELS["omega"]: entry["omega"]}
    for name in ("alpha", "beta"):
        values[f"Re {LABELS[name]}"], values[f"Im {LABELS[name]}"] = entry[name]
    lines = "".join(_line("td", [label, escape(text)], "name") for label, text in values.items())
    title = f"<h3>{escape(entry['row'])} to {entry['digits']} digits</h3>"
    return f'{title}<div class="scroll"><table>\n{lines}</table></div>\n'


def _wrong(report: Report) -> str:
    """The equations that do not hold, or could not be decided, each with a link into the ledger."""
    found = [f for f in report.findings if f.row.status in ("differs", "not decided")]
    lines = [
        f'<li><a href="{LEDGER}#{quote(f.label, safe=":.")}">{escape(f.label)}</a> '
        f'<span class="{f.row.status.replace(" ", "-")}">{f.row.status}</span>: {escape(f.row.reason)}</li>'
        for f in found
    ]
    return f"<ul>{''.join(lines)}</ul>" if lines else ""


def _figure(figure: Written) -> str:
    name, caption = figure.name, escape(figure.caption)
    links = " · ".join(
        f'<a href="{FIGURES}/{name}{suffix}">{text}</a>'
        for suffix, text in ((".svg", "SVG"), (".png", "PNG"), (".csv", "data (CSV)"))
    )
    return (
        f'<figure id="{name}"><img src="{FIGURES}/{name}.svg" alt="{name}">'
        f"<figcaption><strong>{name}.</strong> {caption}<br>{links}</figcaption></figure>\n"
    )
