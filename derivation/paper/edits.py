"""Single edits of a printed equation, of the kinds that people make.

They serve twice: an equation that does not hold is repaired by the smallest edit that makes it true, and the
ledger is tested by edits that must make true equations false.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import fields, replace
from fractions import Fraction

from derivation.paper.notation import Notation
from derivation.paper.syntax import (
    Abs, Apply, Conj, Diff, Equation, Func, Int, Matrix, Neg, Node, Num, Power, Prime, Prod, Quot, Relation, Rest,
    Series, Sum, Sym, Tuple,
)  # fmt: skip

#: Letters that are taken for one another, as quantities.
CONFUSED = (
    ("k1", "k2"), ("k1_dim", "k2_dim"), ("gamma1", "gamma3"), ("gamma1_dim", "gamma3_dim"), ("nu", "mu"),
    ("h1", "h2"), ("v1", "v2"), ("F1", "F2"), ("f1", "f2"), ("f2", "f3"), ("e1", "e2"), ("x", "y"), ("y", "theta"),
    ("Y", "Theta"), ("X0", "X2"), ("P0", "P2"), ("g1", "g2"), ("g3", "g4"), ("g1", "g3"), ("g2", "g4"),
    ("Psi_Y", "Psi_Theta"), ("alpha", "beta"), ("y_hat", "theta_hat"), ("e1_free", "e2_free"), ("tau", "T"),
)  # fmt: skip
STARRED = {
    "Y",
    "Theta",
    "H",
    "X0",
    "X2",
    "P0",
    "P2",
    "g1",
    "g2",
    "g3",
    "g4",
    "Psi_Y",
    "Psi_Theta",
    "A",
    "alpha",
    "beta",
}
TWO, ONE, ZERO = Num(Fraction(2)), Num(Fraction(1)), Num(Fraction(0))
HALF = Quot(ONE, TWO)
Edit = tuple[str, Equation]


def edits(equation: Equation, notation: Notation) -> Iterator[Edit]:
    """Every single edit of an equation, each once, with its kind."""
    seen = {(equation.body, equation.place)}
    swaps = _swaps(notation)

    def fresh(kind: str, new: Equation) -> Iterator[Edit]:
        if (new.body, new.place) not in seen:
            seen.add((new.body, new.place))
            yield kind, new

    for kind, body in _edited(equation.body, swaps, top=True):
        yield from fresh(kind, replace(equation, body=body))
    if equation.place is not None and isinstance(equation.place.right, Num):
        other = replace(equation.place, right=ONE if equation.place.right == ZERO else ZERO)
        yield from fresh("end point", replace(equation, place=other))


def _swaps(notation: Notation) -> dict[str, list[Sym]]:
    """Letter -> the letters of the same notation that it may be taken for."""
    from derivation.paper.parse import expression

    spelled: dict[str, str] = {}
    for letter, quantity in notation.symbols.items():
        spelled.setdefault(quantity, letter)
    found: dict[str, list[Sym]] = {}
    for a, b in CONFUSED:
        for one, two in ((a, b), (b, a)):
            if one in spelled and two in spelled:
                other = expression(spelled[two])
                for letter in (k for k, q in notation.symbols.items() if q == one):
                    found.setdefault(letter, []).append(other)  # type: ignore[arg-type]
    found["*"] = [Sym(letter) for letter, q in notation.symbols.items() if q in STARRED]
    return found


def _edited(
    node: Node, swaps: dict[str, list[Sym]], *, top: bool = False, starred: bool = False
) -> Iterator[tuple[str, Node]]:
    """The node with one edit in it."""
    yield from _local(node, swaps, starred)
    skip = {"place", "var", "index", "weight", "lower", "upper", "op"}
    for f in fields(node):
        value = getattr(node, f.name)
        if f.name in skip or (isinstance(node, Apply) and f.name == "args"):
            continue
        if f.name == "exponent" and isinstance(value, Num):
            continue
        inside = starred or isinstance(node, (Conj, Abs))
        if isinstance(value, tuple):
            for k, item in enumerate(value):
                cells = item if isinstance(item, tuple) else (item,)
                for j, cell in enumerate(cells):
                    for kind, new in _edited(cell, swaps, starred=inside):
                        changed = (*cells[:j], new, *cells[j + 1 :])
                        entry = changed if isinstance(item, tuple) else new
                        yield kind, replace(node, **{f.name: (*value[:k], entry, *value[k + 1 :])})
        elif hasattr(value, "__dataclass_fields__"):
            for kind, new in _edited(value, swaps, starred=inside):
                yield kind, replace(node, **{f.name: new})


def _local(node: Node, swaps: dict[str, list[Sym]], starred: bool) -> Iterator[tuple[str, Node]]:
    """Edits of the node itself."""
    match node:
        case Relation(op, left, right):
            yield from (
                ("sign" if k == 0 else "factor", Relation(op, left, s)) for k, s in enumerate(_scaled(right))
            )
        case Sum(terms):
            for k, t in enumerate(terms):
                if len(terms) > 1:
                    rest = terms[:k] + terms[k + 1 :]
                    yield "dropped term", rest[0] if len(rest) == 1 else Sum(rest)
                if not isinstance(t, Rest):
                    for j, s in enumerate(_scaled(t)):
                        yield ("sign", "factor", "factor")[j], Sum((*terms[:k], s, *terms[k + 1 :]))
        case Prod(factors):
            for k in range(len(factors)):
                rest = factors[:k] + factors[k + 1 :]
                yield "dropped factor", rest[0] if len(rest) == 1 else Prod(rest)
        case Quot(num, _):
            yield "dropped factor", num
        case Sym(_, _, order) if order.isdigit():
            for n in (int(order) - 1, int(order) + 1):
                if 1 <= n <= 3:
                    yield "order", Sym(node.base, node.sub, str(n))
            yield from _swapped(node, swaps)
        case Sym():
            yield from _swapped(node, swaps)
            if not starred and node in swaps["*"]:
                yield "added conjugate", Conj(node)
        case Conj(arg):
            yield "dropped conjugate", arg
        case Prime(arg, n):
            yield "lost prime", Prime(arg, n - 1) if n > 1 else arg
        case Diff(arg, var, n, partial) if arg is not None and partial:
            yield "lost derivative", Diff(arg, var, n - 1, partial) if n > 1 else arg
        case Diff(None, var, n, partial) if n > 1:
            yield "lost derivative", Diff(None, var, n - 1, partial)
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
        case Apply(fn, args):
            for k, a in enumerate(args):
                if other := _other_end(a):
                    yield "end point", Apply(fn, (*args[:k], other, *args[k + 1 :]))
        case Int(arg, var, lower, upper):
            yield "end point", Int(arg, var, upper, lower)
        case Matrix(rows):
            for i, row in enumerate(rows):
                for j, entry in enumerate(row):
                    if entry != ZERO:
                        changed = (*row[:j], Neg(entry), *row[j + 1 :])
                        yield "sign", Matrix((*rows[:i], changed, *rows[i + 1 :]))
        case Tuple(items, None):
            for k, item in enumerate(items):
                if item != ZERO:
                    yield "sign", Tuple((*items[:k], Neg(item), *items[k + 1 :]))
        case Series(arg, index, lower, upper):
            yield "lower limit", Series(arg, index, ONE if lower == ZERO else ZERO, upper)


def _swapped(node: Sym, swaps: dict[str, list[Sym]]) -> Iterator[tuple[str, Node]]:
    for other in swaps.get(node.name, []):
        yield "symbol", Sym(other.base, other.sub, node.order)


def _scaled(node: Node) -> tuple[Node, ...]:
    """With the other sign, twice, half; nothing for a zero."""
    if node == ZERO:
        return ()
    flipped = node.arg if isinstance(node, Neg) else Neg(node)
    inner = node.arg if isinstance(node, Neg) else node
    twice, half = _times(TWO, inner), _times(HALF, inner)
    if isinstance(node, Neg):
        return flipped, Neg(twice), Neg(half)
    return flipped, twice, half


def _times(factor: Node, node: Node) -> Node:
    return Prod((factor, *node.factors)) if isinstance(node, Prod) else Prod((factor, node))


def _other_end(arg: Node) -> Node | None:
    if isinstance(arg, Relation) and arg.right in (ZERO, ONE):
        return replace(arg, right=ONE if arg.right == ZERO else ZERO)
    if arg in (ZERO, ONE):
        return ONE if arg == ZERO else ZERO
    return None
