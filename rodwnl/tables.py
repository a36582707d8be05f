"""The paper's numeric tables, cell by cell: printed beside computed, at the printed precision.

A printed cell holds when the computed value, rounded to the printed number of decimals, is the printed one.
A cell that does not hold is either a reviewed erratum (data/errata.toml) or a difference. Beside every value
stands that of the discretised full rod, which shares neither equations nor code with the expansion.
"""

import math
import re
import tomllib
from collections.abc import Mapping
from dataclasses import dataclass
from decimal import Decimal
from functools import cache
from importlib.resources import files
from typing import Any, Literal

import numpy as np

from rodwnl.coefficients import LandauCoefficients, landau
from rodwnl.errors import ComputationError
from rodwnl.inverse import leading_eigenvalues
from rodwnl.normalform import normal_form
from rodwnl.parameters import RodParameters
from rodwnl.spectrum import HopfThreshold
from rodwnl.strainform import follower

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
    """One cell compared. status: numeric (holds), erratum (listed and confirmed) or differs.

    computed is value at the printed precision; independent is the same quantity of the discretised full rod.
    method says how the value was computed where a table's column is computed in two ways.
    """

    table: str
    row: str
    column: str
    method: str
    printed: str
    computed: str
    value: complex
    independent: complex
    status: Status
    remark: str

    @property
    def agreement(self) -> int:
        """The number of digits to which value and independent agree, at most 15."""
        defect = abs(self.value - self.independent) / abs(self.independent)
        return 15 if defect < 1e-15 else math.floor(-math.log10(defect))


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


@cache
def compared_rows() -> tuple[tuple[PrintedRow, tuple[Cell, ...]], ...]:
    """Both tables evaluated: each row with its cells, the derivative columns of tab:beta_check in two ways.

    Raises ComputationError where a rod does not have the threshold that a row speaks of.
    """
    return compare_rows(printed_rows())


def compare_rows(rows: tuple[PrintedRow, ...]) -> tuple[tuple[PrintedRow, tuple[Cell, ...]], ...]:
    """The same for any rows, those of another printing for instance."""
    theories = {rod: landau(rod) for rod in {row.rod for row in rows}}
    compared = []
    for row in rows:
        theory, number = theories[row.rod], row.threshold
        if len(theory) < number:
            raise ComputationError(
                f"{row.table} {row.name}: found {len(theory)} thresholds, not number {number}"
            )
        compared.append((row, _evaluated(row, theory[number - 1])))
    return tuple(compared)


def _evaluated(row: PrintedRow, theory: LandauCoefficients) -> tuple[Cell, ...]:
    independent = normal_form(follower(*row.rod.floats()), theory.force, theory.omega)
    slope, difference = theory.threshold.slope, centred_slope(row.rod, theory.threshold)
    values = {
        "force": (theory.force, independent.force),
        "omega": (theory.omega, independent.omega),
        "alpha": (theory.alpha, independent.alpha),
        "beta": (theory.beta, independent.beta),
        "growth_slope": (slope.real, independent.beta.real),
        "frequency_slope": (slope.imag, independent.beta.imag),
    }
    differences = {
        "growth_slope": (difference.real, independent.beta.real),
        "frequency_slope": (difference.imag, independent.beta.imag),
    }
    return (*compare(row, values), *compare(row, differences, method="centred difference"))


def centred_slope(rod: RodParameters, threshold: HopfThreshold, step: float = 0.01) -> complex:
    """(λ(F_c + δF) − λ(F_c − δF))/(2δF), the paper's check of β (display before tab:beta_check)."""
    forces = np.array([threshold.force - step, threshold.force + step])
    eigenvalues, _ = leading_eigenvalues(rod.floats(), forces)
    below, above = (row[np.argmin(abs(row - 1j * threshold.omega))] for row in eigenvalues)
    return complex(above - below) / (2 * step)


def compare(
    row: PrintedRow,
    values: Mapping[str, tuple[complex, complex]],
    known: tuple[Erratum, ...] | None = None,
    method: str = "",
) -> tuple[Cell, ...]:
    """The cells of a row for which `values` has the computed and the independent value."""
    by_cell = {(e.label, e.row, e.column): e for e in (errata() if known is None else known)}
    cells = []
    for column, printed in row.cells.items():
        if column in values:
            value, independent = values[column]
            computed = at_printed_precision(value, printed)
            status, remark = _judge(printed, computed, by_cell.get((row.table, row.name, column)))
            where = (row.table, row.name, column, method)
            cells.append(Cell(*where, printed, computed, value, independent, status, remark))
    return tuple(cells)


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
