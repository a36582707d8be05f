"""A paper against the theory: equations, which `derivation.paper` decides, and table cells, computed here."""

from __future__ import annotations

from dataclasses import dataclass, replace
from fractions import Fraction
from functools import cache
from importlib.resources import files
from pathlib import Path
from typing import TYPE_CHECKING, Any

from rodwnl.errors import InputError
from rodwnl.output import full_texts
from rodwnl.parameters import RodParameters
from rodwnl.spectrum import hopf_thresholds
from rodwnl.tables import Cell, PrintedRow, compare_rows, compared_rows, printed_rows

if TYPE_CHECKING:
    from derivation.model import RodModel
    from derivation.paper.notation import Notation
    from derivation.paper.numbers import NumericRow
    from derivation.paper.verify import Finding, Verification
    from derivation.pipeline import Derivation

STATUSES = ("premise", "verified", "differs", "not decided")
CELLS = ("numeric", "erratum", "differs")


@dataclass(frozen=True)
class Report:
    """What was found: equations and table cells, in the order of the source. `source` is its name."""

    source: str
    findings: tuple[Finding, ...]
    cells: tuple[Cell, ...]
    effects: dict[str, Any]
    notation: Notation

    @property
    def counts(self) -> dict[str, int]:
        """Equations by status."""
        return {s: sum(f.row.status == s for f in self.findings) for s in STATUSES}

    @property
    def cell_counts(self) -> dict[str, int]:
        """Table cells by status."""
        return {s: sum(c.status == s for c in self.cells) for s in CELLS}

    @property
    def differs(self) -> bool:
        return bool(self.counts["differs"] or self.cell_counts["differs"])


def check(
    tex: Path | None = None, notation: Path | None = None, only: str | None = None, model: str | None = None
) -> Report:
    """Read a LaTeX source (the bundled equations by default) and decide everything in it.

    only: the label of an equation (`eq:follower.2`), of a display (`eq:follower`) or of a table. model: the
    rod, by name or file; tables and effects are computed for the default rod, `follower`, alone.

    Raises InputError where a file cannot be understood, with the line, or where nothing bears the label.
    """
    from derivation.errors import ReadError
    from derivation.paper import notation as letters

    known = _reading(notation, lambda: letters.load(notation or letters.DEFAULT), ReadError)
    report: Report = _reading(tex, lambda: _check(_text(tex), tex, known, only, model), ReadError)
    return report


def _reading(path: Path | None, action: Any, error: type[Exception]) -> Any:
    try:
        return action()
    except error as problem:
        raise InputError(f"{path.name if path else 'bundled equations'}, {problem}") from None


def _check(text: str, tex: Path | None, notation: Notation, only: str | None, model: str | None) -> Report:
    from derivation.model import FOLLOWER
    from derivation.paper.scan import DISPLAYS
    from derivation.paper.verify import verify
    from rodwnl.models import find_model, refusals

    rod = FOLLOWER if model is None else find_model(model)
    with refusals(model or rod.name):
        derived = _derived(rod)
    law = derived.law
    plain = (
        derived.hierarchy.straight.nu is not None
        and not any(law.slopes.values())
        and "nu" not in law.inverses
    )
    if not (law.uniform or plain):
        raise InputError(
            f"rod {model or rod.name!r}: along it more than its stretch varies, or that is implicit in the "
            "force, so no equations can be held against it: beside a distributed load they need "
            "W = k1 (h1 - 1)^2/2 + …, and other stiffnesses and drag that do not depend on h1"
        )
    result = verify(text, notation, derived, only)
    if not result.labels and not result.tables:
        raise InputError(
            f"{tex.name if tex else 'bundled equations'}: no displayed equation found; looked for "
            + ", ".join(rf"\begin{{{name}}}" for name in DISPLAYS)
            + r", \[...\] and $$...$$, and for tables of numbers"
        )
    rows = [row for row in result.tables if only in (None, row.table) and rod is FOLLOWER]
    if only is not None and not result.findings and not rows:
        raise InputError(f"nothing bears the label {only!r}; {_nearby(only, result.labels)}")
    printed = _printed(rows)
    compared = compared_rows() if printed == printed_rows() else compare_rows(tuple(map(_nearest, printed)))
    cells = [cell for _, row_cells in compared for cell in row_cells]
    return Report(
        tex.name if tex else "bundled equations",
        result.findings,
        tuple(map(_corrected, cells)),
        _effects(result) if rod is FOLLOWER else {},
        notation,
    )


@cache
def _derived(rod: RodModel) -> Derivation:
    from derivation.pipeline import derive

    return derive(rod)


def _text(path: Path | None) -> str:
    if path is None:
        return files("derivation.paper").joinpath("equations.tex").read_text(encoding="utf-8")
    content = path.read_bytes()
    try:
        return content.decode("utf-8")
    except UnicodeDecodeError:
        return content.decode("latin-1")


def _nearby(only: str, labels: tuple[str, ...]) -> str:
    from difflib import get_close_matches

    near = get_close_matches(only, labels, n=3, cutoff=0.4)
    return f"near it are {', '.join(near)}" if near else f"the first are {', '.join(labels[:3])}"


def _printed(rows: list[NumericRow]) -> tuple[PrintedRow, ...]:
    return tuple(PrintedRow(row.table, row.name, _rod(row), row.threshold, row.cells) for row in rows)


def _rod(row: NumericRow) -> RodParameters:
    values = row.rod
    return RodParameters(values["k1"], values["k2"], values["gamma3"], values.get("gamma1", Fraction(1, 2)))


def _nearest(row: PrintedRow) -> PrintedRow:
    """The row with the threshold that its printed force is nearest to, rather than by counting rows."""
    found = hopf_thresholds(row.rod).thresholds
    if not found or "force" not in row.cells:
        return row
    gaps = [abs(t.force - float(row.cells["force"])) for t in found]
    return replace(row, threshold=1 + gaps.index(min(gaps)))


def _corrected(cell: Cell) -> Cell:
    """A cell that holds is numeric, also where an erratum speaks of what another printing says there."""
    return replace(cell, status="numeric", remark="") if cell.printed == cell.computed else cell


def _effects(result: Verification) -> dict[str, Any]:
    """Label -> what the printed error would do to α and β, for the equations that differ."""
    wrong = [f for f in result.findings if f.row.status == "differs"]
    if not wrong:
        return {}
    from rodwnl.effects import effect

    return {f.label: effect(f.row, result.notation, result.theory) for f in wrong}


def effect_sentence(effect: dict[str, Any] | None) -> str:
    """An effect in one line."""
    if effect is None:
        return ""
    rods = (f"{row['row']} α {row['alpha']}, β {row['beta']}" for row in effect["rods"])
    return str(effect["note"]) or "relative change of " + "; ".join(rods)


def document(report: Report) -> dict[str, Any]:
    """The JSON document."""
    return {
        "source": report.source,
        "equations": [_equation(f, report) for f in report.findings],
        "tables": [_cell(c) for c in report.cells],
        "counts": {**report.counts, "tables": report.cell_counts},
    }


def _equation(f: Finding, report: Report) -> dict[str, Any]:
    e = f.row.equation
    return {
        "label": e.label,
        "line": e.line,
        "status": f.row.status,
        "reason": f.row.reason,
        "latex": e.latex,
        "read": f.theirs,
        "difference": f.difference or None,
        "edit": f.repair.text if f.repair else None,
        "corrected": f.repair.latex if f.repair else None,
        "effect": report.effects.get(e.label),
    }


def _cell(c: Cell) -> dict[str, Any]:
    return {
        "label": c.table,
        "row": c.row,
        "column": c.column,
        "method": c.method,
        "printed": c.printed,
        "computed": c.computed,
        "value": full_texts(c.value),
        "independent": full_texts(c.independent),
        "agreement": c.agreement,
        "status": c.status,
        "remark": c.remark,
    }
