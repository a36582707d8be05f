"""Formulas that a user writes, read into SymPy by a grammar of our own: nothing in them is ever evaluated.

Plain infix arithmetic: numbers, declared names, + - * / ^ and parentheses, and cos, sin, sqrt, exp, log.
Size, nesting and exponents are bounded, so that a small text cannot ask for much work.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable
from functools import cache
from pathlib import Path

import sympy
from lark import Lark, Token, Transformer
from lark.exceptions import UnexpectedCharacters, UnexpectedEOF, UnexpectedInput, UnexpectedToken, VisitError
from sympy import Expr, Rational

from derivation.symbols import symbol

LONGEST = 2000  # characters of one formula
DEEPEST = 30  # parentheses inside one another
LARGEST_EXPONENT = 12
HIGHEST_DEGREE = 24  # of the whole formula, counted without cancellation
MOST_DIGITS = 40

FUNCTIONS: dict[str, Callable[[Expr], Expr]] = {
    "cos": sympy.cos,
    "sin": sympy.sin,
    "sqrt": sympy.sqrt,
    "exp": sympy.exp,
    "log": sympy.log,
}


class FormulaError(ValueError):
    """A formula cannot be read; ``line`` and ``column``, both from 1, are where in its text."""

    def __init__(self, problem: str, line: int = 1, column: int = 1) -> None:
        super().__init__(problem)
        self.line, self.column = line, column


def read_formula(text: str, names: Iterable[str]) -> Expr:
    """The expression that a text spells, in the symbols of :mod:`derivation.symbols`.

    Args:
        text: the formula.
        names: the names that it may hold.

    Raises:
        FormulaError: where it is not one; the message says what was expected.
    """
    _require_bounded(text)
    try:
        tree = _parser().parse(text)
    except UnexpectedInput as error:
        raise _syntax_error(text, error) from None
    try:
        found: Expr = _Reader(tuple(names)).transform(tree)
    except VisitError as error:
        if isinstance(error.orig_exc, FormulaError):
            raise error.orig_exc from None
        raise
    if (degree := _degree(found)) > HIGHEST_DEGREE:
        raise FormulaError(f"it is of degree {degree}, higher than {HIGHEST_DEGREE}")
    if found.has(sympy.zoo, sympy.nan, sympy.oo, -sympy.oo):
        raise FormulaError("it divides by zero")
    if found.has(sympy.I):
        raise FormulaError("it is not real: a root or a logarithm of a negative number")
    return found


def _degree(e: Expr) -> int:
    """The degree in all names that multiplying out could reach; of a function, that of its argument."""
    if e.is_Add:
        return max(map(_degree, e.args))
    if e.is_Mul:
        return sum(map(_degree, e.args))
    if e.is_Pow and e.exp.is_Rational:
        return _degree(e.base) * int(sympy.ceiling(abs(e.exp)))
    return max(map(_degree, e.args), default=int(e.is_Symbol))


@cache
def _parser() -> Lark:
    grammar = Path(__file__).with_name("modelfile.lark").read_text(encoding="utf-8")
    return Lark(grammar, parser="lalr", propagate_positions=True)


def _require_bounded(text: str) -> None:
    if len(text) > LONGEST:
        raise FormulaError(f"it has {len(text)} characters, more than {LONGEST}")
    depth = 0
    for at, char in enumerate(text):
        depth += (char == "(") - (char == ")")
        if depth > DEEPEST:
            raise FormulaError(f"more than {DEEPEST} parentheses inside one another", *_place(text, at))


def _place(text: str, at: int) -> tuple[int, int]:
    """Line and column, both from 1, of a position."""
    before = text[:at]
    return before.count("\n") + 1, at - (before.rfind("\n") + 1) + 1


_EXPECTED = {
    "NUMBER": "a number",
    "NAME": "a name",
    "LPAR": "'('",
    "RPAR": "')'",
    "PLUS": "'+'",
    "MINUS": "'-'",
    "STAR": "'*'",
    "SLASH": "'/'",
    "CIRCUMFLEX": "'^'",
    "$END": "the end",
}


def _syntax_error(text: str, error: UnexpectedInput) -> FormulaError:
    if isinstance(error, UnexpectedCharacters):
        allowed, found = error.allowed or set(), repr(text[error.pos_in_stream or 0])
    else:
        assert isinstance(error, UnexpectedToken | UnexpectedEOF)
        allowed = set(error.accepts or error.expected) if isinstance(error, UnexpectedToken) else set()
        token = getattr(error, "token", None)
        found = "the end" if token is None or token.type == "$END" else repr(str(token))
    expected = sorted(_EXPECTED[name] for name in allowed if name in _EXPECTED)
    listed = f"{', '.join(expected[:-1])} or {expected[-1]}" if len(expected) > 1 else "".join(expected)
    where = getattr(error, "pos_in_stream", None)
    at = len(text.rstrip()) if found == "the end" or where is None else where
    return FormulaError(f"expected {listed}, found {found}", *_place(text, at))


class _Reader(Transformer[Token, Expr]):
    """From the tree of a formula to SymPy."""

    def __init__(self, names: tuple[str, ...]) -> None:
        super().__init__()
        self._names = names

    def start(self, items: list[Expr]) -> Expr:
        return items[0]

    def number(self, items: list[Token]) -> Expr:
        (token,) = items
        mantissa, _, exponent = token.lower().partition("e")
        if len(mantissa) > MOST_DIGITS or abs(int(exponent or 0)) > MOST_DIGITS:
            raise _at(token, f"a number with more than {MOST_DIGITS} digits")
        return Rational(str(token))

    def name(self, items: list[Token]) -> Expr:
        (token,) = items
        if token in FUNCTIONS:
            raise _at(token, f"the function {token} needs its argument in parentheses")
        if token not in self._names:
            raise _at(token, f"unknown name {str(token)[:40]!r}; allowed are {', '.join(self._names)}")
        return symbol(str(token))

    def call(self, items: list[Token | Expr]) -> Expr:
        token, argument = items
        if token not in FUNCTIONS:
            product = ": write a product as name*(...)" if token in self._names else ""
            raise _at(token, f"{str(token)[:40]!r} is no function; there are {', '.join(FUNCTIONS)}{product}")
        return FUNCTIONS[str(token)](argument)

    def add(self, items: list[Expr]) -> Expr:
        return items[0] + items[1]

    def subtract(self, items: list[Expr]) -> Expr:
        return items[0] - items[1]

    def multiply(self, items: list[Expr]) -> Expr:
        return items[0] * items[1]

    def divide(self, items: list[Expr]) -> Expr:
        return items[0] / items[1]

    def negate(self, items: list[Expr]) -> Expr:
        return -items[0]

    def signed(self, items: list[Expr]) -> Expr:
        return items[0]

    def raise_to(self, items: list[Expr]) -> Expr:
        base, exponent = items
        if not (exponent.is_Rational and (2 * exponent).is_integer and abs(exponent) <= LARGEST_EXPONENT):
            raise FormulaError(
                f"an exponent must be a whole or half number up to {LARGEST_EXPONENT}, not {exponent}; "
                "write other powers as exp(p*log(a))"
            )
        if base.is_Rational and len(str(base)) * abs(exponent) > MOST_DIGITS * LARGEST_EXPONENT:
            raise FormulaError(f"a number with more than {MOST_DIGITS * LARGEST_EXPONENT} digits")
        return base**exponent


def _at(token: Token, problem: str) -> FormulaError:
    return FormulaError(problem, token.line or 1, token.column or 1)
