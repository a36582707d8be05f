"""Single edits of a printed equation, of the kinds that people make.

They serve twice: the ledger is tested by edits that must make true equations false, and an equation that does
not hold is repaired by the edit that makes it true.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, fields, replace
from fractions import Fraction
from typing import Any, NamedTuple

from derivation.paper.notation import Notation
from derivation.paper.parse import expression
from derivation.paper.syntax import (
    Abs,
    Apply,
    Conj,
    Dagger,
    Diff,
    Equation,
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
    walk,
)

#: Quantities whose letters are taken for one another.
CONFUSED = (
    ("k1", "k2"), ("k1_dim", "k2_dim"), ("gamma1", "gamma3"), ("gamma1_dim", "gamma3_dim"), ("nu", "mu"),
    ("h1", "h2"), ("v1", "v2"), ("F1", "F2"), ("f1", "f2"), ("f2", "f3"), ("e1", "e2"), ("x", "y"),
    ("y", "theta"), ("Y", "Theta"), ("X0", "X2"), ("P0", "P2"), ("g1", "g2"), ("g3", "g4"), ("g1", "g3"),
    ("g2", "g4"), ("Psi_Y", "Psi_Theta"), ("alpha", "beta"), ("y_hat", "theta_hat"),
    ("e1_free", "e2_free"), ("tau", "T"), ("Psi", "xi"),
)  # fmt: skip
COMPLEX = {
    "Y", "Theta", "H", "X0", "X2", "P0", "P2", "g1", "g2", "g3", "g4", "Psi_Y", "Psi_Theta", "A", "alpha",
    "beta",
}  # fmt: skip
TWO, ONE, ZERO = Num(Fraction(2)), Num(Fraction(1)), Num(Fraction(0))
HALF = Quot(ONE, TWO)
#: Numbers that occur in expansions to third order.
NUMBERS = tuple(Fraction(a, b) for a, b in ((1, 6), (1, 4), (1, 3), (1, 2), (2, 1), (3, 1), (4, 1), (6, 1)))


@dataclass(frozen=True)
class Edit:
    """``old`` is replaced by ``new`` somewhere in an equation, which gives ``equation``.

    An empty ``old`` (``new``) is written as None: something is put in (left out).
    """

    kind: str
    old: Node | None
    new: Node | None
    equation: Equation


class _Change(NamedTuple):
    kind: str
    old: Node | None
    new: Node | None
    node: Any  # the node with the change in it


@dataclass(frozen=True)
class _Letters:
    """What an edit may put in the place of a letter."""

    confused: dict[str, tuple[Sym, ...]]
    complex: frozenset[Sym]
    factors: tuple[Node, ...]


def errors(equation: Equation, notation: Notation) -> Iterator[Edit]:
    """Every single error that people make in an equation, each once."""
    yield from _edits(equation, _letters(notation), _erroneous)


def repairs(equation: Equation, notation: Notation) -> Iterator[Edit]:
    """Every single edit that undoes such an error (most errors undo themselves), each once."""
    letters = _letters(notation)
    own = {n: None for n in walk(equation.body) if isinstance(n, Sym)}  # in the order of their occurrence
    factors = dict.fromkeys((*letters.factors, *own))
    yield from _edits(equation, replace(letters, factors=tuple(factors)), _erroneous, _restoring)


def _edits(equation: Equation, letters: _Letters, *kinds: Any) -> Iterator[Edit]:
    seen = {(equation.body, equation.place)}
    changes = [c for kind in kinds for c in _changed(equation.body, letters, kind)]
    for c in changes:
        if (c.node, equation.place) not in seen:
            seen.add((c.node, equation.place))
            yield Edit(c.kind, c.old, c.new, replace(equation, body=c.node))
    place = equation.place
    if place is not None and (other := _other_end(place)) is not None:
        yield Edit("end point", place, other, replace(equation, place=other))


def _letters(notation: Notation) -> _Letters:
    spelled: dict[str, str] = {}
    for letter, quantity in notation.symbols.items():
        spelled.setdefault(quantity, letter)
    confused: dict[str, tuple[Sym, ...]] = {}
    for a, b in CONFUSED:
        for one, two in ((a, b), (b, a)):
            if two in spelled:
                for letter in (k for k, q in notation.symbols.items() if q == one):
                    confused[letter] = (*confused.get(letter, ()), _symbol(spelled[two]))
    starred = frozenset(_symbol(k) for k, q in notation.symbols.items() if q in COMPLEX)
    scaled = ("k1", "k2", "gamma1", "gamma3", "nu", "mu", "gamma2_dim", "k3_dim", "gamma1_dim", "gamma3_dim")
    named = (_symbol(spelled[q]) for q in scaled if q in spelled)
    return _Letters(confused, starred, (TWO, HALF, *named, Sym("i")))


def _symbol(letter: str) -> Sym:
    node = expression(letter)
    assert isinstance(node, Sym)
    return node


def _changed(node: Node, letters: _Letters, kind: Any, starred: bool = False) -> Iterator[_Change]:
    """The node with one edit in it, or in one of its descendants."""
    yield from kind(node, letters, starred)
    starred = starred or isinstance(node, (Conj, Abs, Dagger))
    for name, value in _open_fields(node):
        if not isinstance(value, tuple):
            for c in _changed(value, letters, kind, starred):
                yield c._replace(node=_with(node, name, c.node))
            continue
        for k, item in enumerate(value):
            for c in _in_item(item, letters, kind, starred):
                yield c._replace(node=_with(node, name, (*value[:k], c.node, *value[k + 1 :])))


def _with(node: Any, name: str, value: Any) -> Any:
    return replace(node, **{name: value})


def _open_fields(node: Node) -> Iterator[tuple[str, Any]]:
    """The fields in which edits are made: not what a derivative is along, nor where a value is taken."""
    closed = {"place", "var", "index", "weight", "lower", "upper", "op"}
    for f in fields(node):
        value = getattr(node, f.name)
        fixed = (f.name == "args" and isinstance(node, Apply)) or (
            f.name == "exponent" and isinstance(value, Num)
        )
        if (
            f.name not in closed
            and not fixed
            and (isinstance(value, tuple) or hasattr(value, "__dataclass_fields__"))
        ):
            yield f.name, value


def _in_item(item: Any, letters: _Letters, kind: Any, starred: bool) -> Iterator[_Change]:
    """An entry of a tuple field: a node, or a row of a matrix."""
    if not isinstance(item, tuple):
        yield from _changed(item, letters, kind, starred)
        return
    for j, cell in enumerate(item):
        for c in _changed(cell, letters, kind, starred):
            yield c._replace(node=(*item[:j], c.node, *item[j + 1 :]))


def _erroneous(node: Node, letters: _Letters, starred: bool) -> Iterator[_Change]:
    """Errors in the node itself."""
    match node:
        case Relation(op, left, right):
            for kind, new in _scaled(right):
                yield _Change(kind, right, new, Relation(op, left, new))
        case Sum(terms):
            yield from _in_sum(terms)
        case Prod(factors):
            for k, f in enumerate(factors):
                yield _Change("dropped factor", f, None, _product(factors[:k] + factors[k + 1 :]))
        case Quot(num, den):
            yield _Change("dropped factor", Quot(ONE, den), None, num)
        case Matrix(rows):
            for i, row in enumerate(rows):
                for j, entry in enumerate(row):
                    for kind, new in _scaled(entry):
                        changed = (*row[:j], new, *row[j + 1 :])
                        yield _Change(kind, entry, new, Matrix((*rows[:i], changed, *rows[i + 1 :])))
        case Tuple(items, None):
            for k, item in enumerate(items):
                for kind, new in _scaled(item):
                    yield _Change(kind, item, new, Tuple((*items[:k], new, *items[k + 1 :])))
        case Apply(fn, args):
            for k, a in enumerate(args):
                if (other := _other_end(a)) is not None:
                    new = Apply(fn, (*args[:k], other, *args[k + 1 :]))
                    yield _Change("end point", node, new, new)
        case _:
            for kind, new in _alone(node, letters, starred):
                yield _Change(kind, node, new, new)


def _alone(node: Node, letters: _Letters, starred: bool) -> Iterator[tuple[str, Any]]:
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


def _restoring(node: Node, letters: _Letters, starred: bool) -> Iterator[_Change]:
    """What puts back a lost factor, prime, derivative, power, modulus, real part, or the right number."""
    if (value := _value(node)) is not None:
        for other in NUMBERS:
            if other != value:
                yield _Change("number", node, _number(other), _number(other))
    match node:
        case Relation(op, left, right):
            for f in letters.factors:
                if right != ZERO:
                    yield _Change(
                        "missing factor", right, _times(f, right), Relation(op, left, _times(f, right))
                    )
                    yield _Change(
                        "missing factor", left, _times(f, left), Relation(op, _times(f, left), right)
                    )
        case Func("exp", arg):
            for f in letters.factors:
                yield _Change("missing factor", arg, _times(f, arg), Func("exp", _times(f, arg)))
        case Quot(num, den):
            for f in letters.factors:
                yield _Change("missing factor", node, Quot(_times(f, num), den), Quot(_times(f, num), den))
                yield _Change("missing factor", node, Quot(num, _times(f, den)), Quot(num, _times(f, den)))
        case Sum(terms):
            for k, t in enumerate(terms):
                for f in letters.factors if not isinstance(t, Rest) else ():
                    new = Neg(_times(f, t.arg)) if isinstance(t, Neg) else _times(f, t)
                    yield _Change("missing factor", t, new, Sum((*terms[:k], new, *terms[k + 1 :])))
        case Power(base, Num(value)) if value is not None:
            yield _Change("power", node, Power(base, Num(value + 1)), Power(base, Num(value + 1)))
            if not isinstance(base, Abs):
                yield _Change("modulus", node, Power(Abs(base), Num(value)), Power(Abs(base), Num(value)))
        case Abs():
            yield _Change("power", node, Power(node, TWO), Power(node, TWO))
        case Sym():
            for kind, new in (("lost prime", Prime(node, 1)), ("power", Power(node, TWO))):
                yield _Change(kind, node, new, new)
            if node.order:
                new = Diff(node, Sym("u"), 1, True)
                yield _Change("lost derivative", node, new, new)
            if node in letters.complex:
                yield _Change("real part", node, Func("Re", node), Func("Re", node))
        case Prime(arg, n):
            yield _Change("lost prime", node, Prime(arg, n + 1), Prime(arg, n + 1))
        case Diff(arg, var, n, True) if arg is not None:
            yield _Change("lost derivative", node, Diff(arg, var, n + 1, True), Diff(arg, var, n + 1, True))


def _in_sum(terms: tuple[Any, ...]) -> Iterator[_Change]:
    for k, t in enumerate(terms):
        rest = terms[:k] + terms[k + 1 :]
        if rest:
            yield _Change("dropped term", t, None, rest[0] if len(rest) == 1 else Sum(rest))
        for kind, new in _scaled(t):
            yield _Change(kind, t, new, Sum((*terms[:k], new, *terms[k + 1 :])))


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


def _other_end(arg: Any) -> Any:
    """0 for 1 and 1 for 0, also in ``u = 1``; None for anything else."""
    if isinstance(arg, Relation):
        right = _other_end(arg.right)
        return None if right is None else replace(arg, right=right)
    return ONE if arg == ZERO else ZERO if arg == ONE else None
