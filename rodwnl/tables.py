"""The paper's numeric tables, cell by cell: printed beside computed, at the printed precision.

A printed cell holds when the computed value, rounded to the printed number of decimals, is the printed one. A
cell that does not hold is either a reviewed erratum (data/errata.toml) or a difference.
"""

import re
import tomllib
from dataclasses import dataclass
from decimal import Decimal
from functools import cache
from importlib.resources import files
from typing import Any, Literal

from rodwnl.errors import ComputationError
from rodwnl.parameters import RodParameters

Status = Literal["numeric", "erratum", "differs"]
_NUMBER = re.compile(r"(-?\d+(?:\.\d+)?)(?: ([+-]) (\d+(?:\.\d+)?)i)?")


@dataclass(frozen=True)
class PrintedRow:
    """One row of a table: which rod, which of its thresholds (1 is the lowest), the cells by column."""

    table: str
    name: str
    rod: RodParameters
    threshold: int
    cells: dict[str, str]


@dataclass(frozen=True)
class Erratum:
    """A cell known not to hold: as printed, as computed at the same precision, and how that is known."""

    label: str
    row: str
    column: str
    printed: str
    computed: str
    evidence: str


@dataclass(frozen=True)
class Cell:
    """One cell compared. status: numeric (holds), erratum (listed and confirmed) or differs."""

    table: str
    row: str
    column: str
    printed: str
    computed: str
    status: Status
    remark: str = ""


@cache
def printed_rows() -> tuple[PrintedRow, ...]:
    """All rows of tab:parameters and tab:beta_check, in the paper's order."""
    return tuple(
        PrintedRow(**row | {"rod": RodParameters(**row["rod"])}) for row in _read("tables.toml")["row"]
    )


@cache
def errata() -> tuple[Erratum, ...]:
    """The reviewed errata."""
    return tuple(Erratum(**entry) for entry in _read("errata.toml")["erratum"])


def compare(
    row: PrintedRow, values: dict[str, complex], known: tuple[Erratum, ...] | None = None
) -> list[Cell]:
    """Each cell of a row beside its computed value; `values` has a number for every column of the row."""
    by_cell = {(e.label, e.row, e.column): e for e in (errata() if known is None else known)}
    cells = []
    for column, printed in row.cells.items():
        computed = at_printed_precision(values[column], printed)
        status, remark = _judge(printed, computed, by_cell.get((row.table, row.name, column)))
        cells.append(Cell(row.table, row.name, column, printed, computed, status, remark))
    return cells


def at_printed_precision(value: complex, printed: str) -> str:
    """A computed value rounded to the decimals of a printed cell and written the same way."""
    texts = _parts(printed)
    numbers = [Decimal(value.real), Decimal(value.imag)][: len(texts)]
    rounded = [number.quantize(Decimal(text)) for number, text in zip(numbers, texts, strict=True)]
    if len(rounded) == 1:
        return str(rounded[0])
    return f"{rounded[0]} {'-' if rounded[1] < 0 else '+'} {abs(rounded[1])}i"


def _parts(printed: str) -> list[str]:
    """The one real or the two parts of a printed number: '7.35 + 5.36i' -> ['7.35', '+5.36']."""
    match = _NUMBER.fullmatch(printed)
    if match is None:
        raise ComputationError(f"{printed!r} is not a number as a table prints one")
    real, sign, imaginary = match.groups()
    return [real] if sign is None else [real, sign + imaginary]


def _judge(printed: str, computed: str, erratum: Erratum | None) -> tuple[Status, str]:
    if erratum is None:
        return ("numeric" if printed == computed else "differs"), ""
    if (erratum.printed, erratum.computed) == (printed, computed) and printed != computed:
        return "erratum", erratum.evidence
    return "differs", f"the erratum on file ({erratum.printed} should be {erratum.computed}) does not hold"


def _read(name: str) -> Any:
    return tomllib.loads(files("rodwnl").joinpath("data", name).read_text(encoding="utf-8"))
