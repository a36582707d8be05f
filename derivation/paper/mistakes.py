"""Errors that people make in one node of an equation, and what undoes those that do not undo themselves."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace
from fractions import Fraction
from typing import Any, NamedTuple

from derivation.paper.syntax import (
    Abs,
    Apply,
    Conj,
    Diff,
    Func,
    Int,
    Matrix,
    Neg,
    Node,
    Num,
    Power,
    Prime,
    Prod,
    Quot,
    Relation,
    Rest,
    Series,
    Sum,
    Sym,
    Tuple,
)

TWO, ONE, ZERO = Num(Fraction(2)), Num(Fraction(1)), Num(Fraction(0))
HALF = Quot(ONE, TWO)
#: Numbers that occur in expansions to third order.
NUMBERS = tuple(Fraction(a, b) for a, b in ((1, 6), (1, 4), (1, 3), (1, 2), (2, 1), (3, 1), (4, 1), (6, 1)))


class Change(NamedTuple):
    kind: str
    old: Node | None
    new: Node | None
    node: Any  # the node with the change in it


@dataclass(frozen=True)
class Letters:
    """What an edit may put in the place of a letter."""

    confused: dict[str, tuple[Sym, ...]]
    complex: frozenset[Sym]
    factors: tuple[Node, ...]


def erroneous(node: Node, letters: Letters, starred: bool) -> Iterator[Change]:
    """Errors in the node itself."""
    match node:
        case Relation(op, left, right):
            for kind, new in _scaled(right):
                yield Change(kind, right, new, Relation(op, left, new))
        case Sum(terms):
            yield from _in_sum(terms)
        case Prod(factors):
            for k, f in enumerate(factors):
                yield Change("dropped factor", f, None, _product(factors[:k] + factors[k + 1 :]))
        case Quot(num, den):
            yield Change("dropped factor", Quot(ONE, den), None, num)
        case Matrix(rows):
            for i, row in enumerate(rows):
                for j, entry in enumerate(row):
                    for kind, new in _scaled(entry):
                        changed = (*row[:j], new, *row[j + 1 :])
                        yield Change(kind, entry, new, Matrix((*rows[:i], changed, *rows[i + 1 :])))
        case Tuple(items, None):
            for k, item in enumerate(items):
                for kind, new in _scaled(item):
                    yield Change(kind, item, new, Tuple((*items[:k], new, *items[k + 1 :])))
        case Apply(fn, args):
            for k, a in enumerate(args):
                if (other := other_end(a)) is not None:
                    new = Apply(fn, (*args[:k], other, *args[k + 1 :]))
                    yield Change("end point", node, new, new)
        case _:
            for kind, new in _alone(node, letters, starred):
                yield Change(kind, node, new, new)


def _alone(node: Node, letters: Letters, starred: bool) -> Iterator[tuple[str, Any]]:
    """Errors that replace a node as a whole."""
    match node:
        case Sym(base, sub, order):
            if order.isdigit():
                yield from (
                    ("order", Sym(base, sub, str(n))) for n in (int(order) - 1, int(order) + 1) if 1 <= n <= 3
                )
            yield from (("symbol", Sym(s.base, s.sub, order)) for s in letters.confused.get(node.name, ()))
            if not starred and node in letters.complex:
                yield "added conjugate", Conj(node)
        case Conj(arg):
            yield "dropped conjugate", arg
        case Prime(arg, n):
            yield "lost prime", Prime(arg, n - 1) if n > 1 else arg
        case Diff(arg, var, n, True):
            if n > 1 or arg is not None:
                yield "lost derivative", Diff(arg, var, n - 1, True) if n > 1 else arg
        case Func("Re" | "Im" as name, arg):
            yield "real part", Func("Im" if name == "Re" else "Re", arg)
            yield "real part", arg
        case Func("exp", arg):
            yield "sign", Func("exp", Neg(arg))
        case Func("cos" | "sin" as name, arg):
            yield "function", Func("sin" if name == "cos" else "cos", arg)
        case Power(base, Num(value)) if value is not None and value > 1:
            yield "power", Power(base, Num(value - 1)) if value > 2 else base
            if isinstance(base, Abs):
                yield "modulus", Power(base.arg, Num(value))
        case Int(arg, var, lower, upper):
            yield "end point", Int(arg, var, upper, lower)
        case Series(arg, index, lower, upper):
            yield "end point", Series(arg, index, ONE if lower == ZERO else ZERO, upper)


def restoring(node: Node, letters: Letters, starred: bool) -> Iterator[Change]:
    """What puts back a lost factor, prime, derivative, power, modulus, real part, or the right number."""
    if (value := _value(node)) is not None:
        for other in NUMBERS:
            if other != value:
                yield Change("number", node, _number(other), _number(other))
    match node:
        case Relation(op, left, right):
            for f in letters.factors:
                if right != ZERO:
                    yield Change(
                        "missing factor", right, _times(f, right), Relation(op, left, _times(f, right))
                    )
                    yield Change(
                        "missing factor", left, _times(f, left), Relation(op, _times(f, left), right)
                    )
        case Func("exp", arg):
            for f in letters.factors:
                yield Change("missing factor", arg, _times(f, arg), Func("exp", _times(f, arg)))
        case Quot(num, den):
            for f in letters.factors:
                yield Change("missing factor", node, Quot(_times(f, num), den), Quot(_times(f, num), den))
                yield Change("missing factor", node, Quot(num, _times(f, den)), Quot(num, _times(f, den)))
        case Sum(terms):
            for k, t in enumerate(terms):
                for f in letters.factors if not isinstance(t, Rest) else ():
                    new = Neg(_times(f, t.arg)) if isinstance(t, Neg) else _times(f, t)
                    yield Change("missing factor", t, new, Sum((*terms[:k], new, *terms[k + 1 :])))
        case Power(base, Num(value)) if value is not None:
            yield Change("power", node, Power(base, Num(value + 1)), Power(base, Num(value + 1)))
            if not isinstance(base, Abs):
                yield Change("modulus", node, Power(Abs(base), Num(value)), Power(Abs(base), Num(value)))
        case Abs():
            yield Change("power", node, Power(node, TWO), Power(node, TWO))
        case Sym():
            for kind, new in (("lost prime", Prime(node, 1)), ("power", Power(node, TWO))):
                yield Change(kind, node, new, new)
            if node.order:
                new = Diff(node, Sym("u"), 1, True)
                yield Change("lost derivative", node, new, new)
            if node in letters.complex:
                yield Change("real part", node, Func("Re", node), Func("Re", node))
        case Prime(arg, n):
            yield Change("lost prime", node, Prime(arg, n + 1), Prime(arg, n + 1))
        case Diff(arg, var, n, True) if arg is not None:
            yield Change("lost derivative", node, Diff(arg, var, n + 1, True), Diff(arg, var, n + 1, True))


def _in_sum(terms: tuple[Any, ...]) -> Iterator[Change]:
    for k, t in enumerate(terms):
        rest = terms[:k] + terms[k + 1 :]
        if rest:
            yield Change("dropped term", t, None, rest[0] if len(rest) == 1 else Sum(rest))
        for kind, new in _scaled(t):
            yield Change(kind, t, new, Sum((*terms[:k], new, *terms[k + 1 :])))


def _scaled(node: Any) -> Iterator[tuple[str, Any]]:
    """With the other sign, twice, half; nothing for a zero or for what is left unsaid."""
    if node == ZERO or isinstance(node, Rest):
        return
    inner = node.arg if isinstance(node, Neg) else node
    yield "sign", inner if isinstance(node, Neg) else Neg(node)
    for f in (TWO, HALF):
        yield "factor", Neg(_times(f, inner)) if isinstance(node, Neg) else _times(f, inner)


def _times(factor: Any, node: Any) -> Any:
    """factor * node; a number joins the number that stands in front, 2 * (1/4) x = (1/2) x."""
    if isinstance(node, Neg):
        return Neg(_times(factor, node.arg))
    factors = node.factors if isinstance(node, Prod) else (node,)
    left, right = _value(factor), _value(factors[0])
    if left is not None and right is not None:
        number = _number(left * right)
        rest = factors[1:]
        return _product((number, *rest)) if number != ONE or not rest else _product(rest)
    return Prod((factor, *factors))


def _value(node: Any) -> Fraction | None:
    """The number that a node is, ``2`` or ``\\frac{1}{2}``."""
    if isinstance(node, Num):
        return node.value
    if isinstance(node, Quot) and isinstance(node.num, Num) and isinstance(node.den, Num):
        return node.num.value / node.den.value if node.num.value is not None and node.den.value else None
    return None


def _number(value: Fraction) -> Any:
    if value.denominator == 1:
        return Num(value)
    return Quot(Num(Fraction(value.numerator)), Num(Fraction(value.denominator)))


def _product(factors: tuple[Any, ...]) -> Any:
    return factors[0] if len(factors) == 1 else Prod(factors)


def other_end(arg: Any) -> Any:
    """0 for 1 and 1 for 0, also in ``u = 1``; None for anything else."""
    if isinstance(arg, Relation):
        right = other_end(arg.right)
        return None if right is None else replace(arg, right=right)
    return ONE if arg == ZERO else ZERO if arg == ONE else None
