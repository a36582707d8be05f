"""How results are printed: tables for people, one JSON document for programs."""

import json
import sys
from collections.abc import Iterable, Sequence
from decimal import ROUND_CEILING, Context, Decimal
from math import isfinite
from typing import Any

from rodwnl.errors import ComputationError

_PIPED_WIDTH = 100_000  # wide enough for every table: what goes to a file is never folded or cut
_ROUNDING = Context(prec=400)  # quantize needs room for every digit of a double


def print_json(document: Any) -> None:
    """Print exactly one JSON document; a NaN or an infinity in it is a bug and raises ValueError."""
    print(json.dumps(document, indent=2, ensure_ascii=False, allow_nan=False))


def print_table(headings: Sequence[str], rows: Iterable[Sequence[str]], title: str = "") -> None:
    """Print a table, numbers right-aligned; folded only where a terminal is too narrow for it."""
    from rich.box import SIMPLE  # 80 ms that --json does not need
    from rich.console import Console
    from rich.table import Table
    from rich.text import Text

    console = Console(width=None if sys.stdout.isatty() else _PIPED_WIDTH, highlight=False, markup=False)
    table = Table(box=SIMPLE, title=Text(title, style="bold") if title else None, title_justify="left")
    for heading in headings:
        table.add_column(Text(heading), justify="right", overflow="fold")
    for row in rows:
        table.add_row(*(Text(cell) for cell in row))
    with console.capture() as capture:
        console.print(table)
    print("\n".join(line.rstrip() for line in capture.get().splitlines()))


def full_texts(value: complex) -> str | list[str]:
    """A number in JSON: the text that reads back to the same double; of a complex one, both parts' texts."""
    return [repr(value.real), repr(value.imag)] if isinstance(value, complex) else repr(float(value))


def number(value: float, error: float = 0.0, digits: int = 12) -> str:
    """A number rounded to the last place that an absolute error leaves certain, at most `digits` digits.

    number(1 / 3, 1e-5) is 0.3333, number(12345.678, 2) is 1.235e+4, and number(1e-9, 1e-6) is 0.00000.
    """
    exact = Decimal(repr(float(value)))
    if not (exact.is_finite() and isfinite(error)):
        raise ComputationError(f"{value} with the error {error} is not a number to print")
    place = exact.adjusted() - digits + 1
    if error:
        place = max(place, _certain(error))
    rounded = exact.quantize(Decimal(1).scaleb(place), context=_ROUNDING)
    rounded = rounded or rounded.copy_abs()  # no sign before what is zero
    if place > 0 or (rounded and rounded.adjusted() < -5):
        return f"{rounded:e}"
    return f"{rounded:f}"


def _certain(error: float) -> int:
    """The power of ten of the last place that an absolute error leaves certain."""
    return int(Decimal(repr(2 * float(error))).log10().to_integral_value(ROUND_CEILING))


def measured(value: float, error: float) -> str:
    """As `number`, but with the error beside it where this would leave fewer than three digits.

    measured(0.101766, 1e-7) is 0.101766, and measured(0.0305, 0.0055) is 0.030 ± 0.006.
    """
    size, bound = (Decimal(repr(float(abs(x)))) for x in (value, error))
    if not bound or (size and _certain(error) <= size.adjusted() - 2):
        return number(value, error)
    unit = Decimal(1).scaleb(bound.adjusted())
    rounded = Decimal(repr(float(value))).quantize(unit, context=_ROUNDING)
    return f"{rounded:f} ± {bound.quantize(unit, rounding=ROUND_CEILING, context=_ROUNDING):f}"


def complex_number(value: complex, error: float = 0.0, digits: int = 12) -> str:
    """A complex number as the paper prints one, -971.79 + 29.09i; `error` bounds both parts."""
    imaginary = number(abs(value.imag), error, digits)
    return f"{number(value.real, error, digits)} {'-' if value.imag < 0 else '+'} {imaginary}i"
