"""Single edits of a printed equation, of the kinds that people make.

They serve twice: the ledger is tested by edits that must make true equations false, and an equation that does
not hold is repaired by the edit that makes it true.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, fields, replace
from typing import Any

from derivation.paper.mistakes import HALF, TWO, Change, Letters, erroneous, other_end, restoring
from derivation.paper.notation import Notation
from derivation.paper.parse import expression
from derivation.paper.syntax import (
    Abs,
    Apply,
    Conj,
    Dagger,
    Equation,
    Node,
    Num,
    Sym,
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


@dataclass(frozen=True)
class Edit:
    """``old`` is replaced by ``new`` somewhere in an equation, which gives ``equation``.

    An empty ``old`` (``new``) is written as None: something is put in (left out).
    """

    kind: str
    old: Node | None
    new: Node | None
    equation: Equation


def errors(equation: Equation, notation: Notation) -> Iterator[Edit]:
    """Every single error that people make in an equation, each once."""
    yield from _edits(equation, _letters(notation), erroneous)


def repairs(equation: Equation, notation: Notation) -> Iterator[Edit]:
    """Every single edit that undoes such an error (most errors undo themselves), each once."""
    letters = _letters(notation)
    own = {n: None for n in walk(equation.body) if isinstance(n, Sym)}  # in the order of their occurrence
    factors = dict.fromkeys((*letters.factors, *own))
    yield from _edits(equation, replace(letters, factors=tuple(factors)), erroneous, restoring)


def _edits(equation: Equation, letters: Letters, *kinds: Any) -> Iterator[Edit]:
    seen = {(equation.body, equation.place)}
    changes = [c for kind in kinds for c in _changed(equation.body, letters, kind)]
    for c in changes:
        if (c.node, equation.place) not in seen:
            seen.add((c.node, equation.place))
            yield Edit(c.kind, c.old, c.new, replace(equation, body=c.node))
    place = equation.place
    if place is not None and (other := other_end(place)) is not None:
        yield Edit("end point", place, other, replace(equation, place=other))


def _letters(notation: Notation) -> Letters:
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
    return Letters(confused, starred, (TWO, HALF, *named, Sym("i")))


def _symbol(letter: str) -> Sym:
    node = expression(letter)
    assert isinstance(node, Sym)
    return node


def _changed(node: Node, letters: Letters, kind: Any, starred: bool = False) -> Iterator[Change]:
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


def _in_item(item: Any, letters: Letters, kind: Any, starred: bool) -> Iterator[Change]:
    """An entry of a tuple field: a node, or a row of a matrix."""
    if not isinstance(item, tuple):
        yield from _changed(item, letters, kind, starred)
        return
    for j, cell in enumerate(item):
        for c in _changed(cell, letters, kind, starred):
            yield c._replace(node=(*item[:j], c.node, *item[j + 1 :]))
