"""The numeric tables of a paper: which rod a row is about, and its cells as texts."""

from __future__ import annotations

import re
from dataclasses import dataclass
from fractions import Fraction

from derivation.errors import ReadError
from derivation.paper.notation import Notation
from derivation.paper.parse import expression
from derivation.paper.read import number
from derivation.paper.scan import Cell, Table
from derivation.paper.syntax import Diff, Expr, Func, Neg, Num, Power, Prod, Quot, Sum, Sym

#: Quantities that say which rod a row is about; the other columns are its cells.
ROD = ("k1", "k2", "gamma3", "gamma1")
COLUMNS = {"force_c": "force", "force": "force", "omega_c": "omega", "alpha": "alpha", "beta": "beta"}
#: Powers in cells are of at most so many bits.
MOST_BITS = 400
_PRINTED = re.compile(r"([+-]?)(\d+(?:\.\d+)?)(?:([+-])(\d+(?:\.\d+)?)i)?")


@dataclass(frozen=True)
class NumericRow:
    """A row of a numeric table.

    ``rod``: exact values by name (gamma1 only where the table prints it). ``threshold``: 1 for the lowest
    printed force of that rod in the table. ``cells``: column -> number as printed, ``-971.79 + 29.09i``.
    """

    table: str
    line: int
    name: str
    rod: dict[str, Fraction]
    threshold: int
    cells: dict[str, str]


def numeric_rows(tables: tuple[Table, ...], notation: Notation) -> list[NumericRow]:
    """The rows of every table that has a column for each of k1, k2 and gamma3.

    Raises:
        ReadError: a cell of such a table that is not a number, with its line.
    """
    found = []
    for table in tables:
        header = [_quantity(cell, notation) for cell in table.rows[0]]
        if {"k1", "k2", "gamma3"} <= set(header):
            rows = [_row(table, cells, header) for cells in table.rows[1:]]
            found += [_with_threshold(row, rows) for row in rows]
    return found


def _row(table: Table, cells: tuple[Cell, ...], header: list[str]) -> NumericRow:
    line = cells[0].line
    if len(cells) != len(header):
        raise ReadError(line, f"{len(cells)} cells in a row of {table.label}; its header has {len(header)}")
    rod = {q: _exact(cell) for q, cell in zip(header, cells, strict=True) if q in ROD}
    values = {
        q: _printed(c)
        for q, c in zip(header, cells, strict=True)
        if q in (*COLUMNS.values(), *_SLOPES.values())
    }
    return NumericRow(table.label, line, cells[0].text, rod, 1, values)


def _with_threshold(row: NumericRow, rows: list[NumericRow]) -> NumericRow:
    """Thresholds of a rod are counted by increasing force."""
    lower = [r for r in rows if r.rod == row.rod and _force(r) < _force(row)]
    return NumericRow(row.table, row.line, row.name, row.rod, 1 + len(lower), row.cells)


def _force(row: NumericRow) -> Fraction:
    return Fraction(row.cells.get("force", "0"))


_SLOPES = {"Re": "growth_slope", "Im": "frequency_slope"}


def _quantity(cell: Cell, notation: Notation) -> str:
    """What a column holds; empty for names and remarks."""
    text = re.sub(r"\\[bB]igg?r?\s*\|.*", "", cell.text.replace("$", " "))
    text = re.sub(r"\(.*\)\s*$", "", text)  # a remark in words
    try:
        head = expression(text, notation.functions)
    except ReadError:
        return ""
    if isinstance(head, Diff) and isinstance(head.arg, Func):
        return _SLOPES.get(head.arg.name, "")
    quantity = notation.quantity(head.name) if isinstance(head, Sym) else None
    return quantity if quantity in ROD else COLUMNS.get(quantity or "", "")


def _exact(cell: Cell) -> Fraction:
    return _value(number(cell), cell)


def _value(node: Expr, cell: Cell) -> Fraction:
    match node:
        case Num(value) if value is not None:
            return value
        case Neg(arg):
            return -_value(arg, cell)
        case Sum(terms):
            return sum((_value(t, cell) for t in terms), Fraction(0))
        case Prod(factors):
            total = Fraction(1)
            for f in factors:
                total *= _value(f, cell)
            return total
        case Quot(num, den) if below := _value(den, cell):
            return _value(num, cell) / below
        case Power(base, exponent):
            n, b = _value(exponent, cell), _value(base, cell)
            size = max(abs(b.numerator), b.denominator).bit_length()
            if n.denominator == 1 and abs(n) * size <= MOST_BITS and (b or n > 0):
                return b ** int(n)
    raise ReadError(cell.line, f"expected a number, not {cell.text!r}")


def _printed(cell: Cell) -> str:
    """A real or complex number in one spelling: ``$6.93+4.13 i$`` is ``6.93 + 4.13i``."""
    match = _PRINTED.fullmatch(re.sub(r"[\s$]|\\,|\\mathrm\{(?=i\})", "", cell.text))
    if match is None:
        raise ReadError(cell.line, f"expected a number such as 7.35 or 7.35 + 5.36i, not {cell.text!r}")
    sign, real, middle, imaginary = match.groups()
    text = ("-" if sign == "-" else "") + real
    return text if middle is None else f"{text} {middle} {imaginary}i"
