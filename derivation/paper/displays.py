"""Equations that stand together: a list of conditions says each once and is of one order."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator
from dataclasses import replace

from derivation.paper.algebra import poly
from derivation.paper.meanings import FIELDS, STRESSES
from derivation.paper.notation import Notation
from derivation.paper.rows import Row
from derivation.paper.syntax import Node, Relation, Sym, rebuild, walk

#: Letters that occur side by side, in the order in which a list of conditions runs through them.
FAMILIES = (
    FIELDS, STRESSES, ("y_hat", "theta_hat"), ("Y", "Theta"), ("Psi_Y", "Psi_Theta"), ("X0", "X2"),
    ("e1", "e2"), ("e1_free", "e2_free"),
)  # fmt: skip


def complete(rows: list[Row], notation: Notation) -> Iterator[Row]:
    """A list that says one thing twice leaves another out; a condition of another order is remarked on."""
    displays: dict[tuple[str, int], list[Row]] = {}
    for row in rows:
        displays.setdefault((row.equation.label.rpartition(".")[0], row.equation.line), []).append(row)
    for display in displays.values():
        for k, row in enumerate(display):
            holds = row.status in ("premise", "verified")
            if holds and (fault := _repeats(k, display, notation)):
                yield Row(row.equation, "differs", fault, poly(0))
            elif holds and (remark := _of_other_order(row, display)):
                yield replace(row, reason=f"{row.reason}; {remark}", remark=remark)
            else:
                yield row


def _said(row: Row) -> tuple[object, object]:
    return row.equation.body, row.equation.place


def _repeats(k: int, display: list[Row], notation: Notation) -> str:
    """Of two equal rows the one is at fault that stands where the missing letter should."""
    twins = [j for j, other in enumerate(display) if j != k and _said(other) == _said(display[k])]
    if not twins:
        return ""
    subject = _subject(display[k], notation)
    family = next((f for f in FAMILIES if subject in f), ())
    masked = _masked(display[k], family, notation)
    alike = [j for j, other in enumerate(display) if _masked(other, family, notation) == masked]
    here = [_subject(display[j], notation) for j in alike]
    anywhere = [_subject(r, notation) for r in display]
    missing = [q for q in family if q not in anywhere] or [q for q in family if q not in here]
    expected = [q for q in family if q in (*here, *missing[: len(twins)])]
    if missing and expected[alike.index(k) % len(expected)] == subject:
        return ""  # this one stands where it should; its twin does not
    lacks = f", and none is there for {missing[0]}" if missing else ""
    return f"says the same as {display[twins[0]].equation.label}{lacks}"


def _masked(row: Row, family: tuple[str, ...], notation: Notation) -> tuple[object, object]:
    """What a row says, the letters of a family not told apart."""

    def mask(node: Node) -> Node:
        if isinstance(node, Sym) and notation.quantity(node.name) in family:
            return Sym("?", "", node.order)
        return rebuild(node, mask)

    return mask(row.equation.body), row.equation.place


def _subject(row: Row, notation: Notation) -> str | None:
    """The quantity of the first letter on the left."""
    body = row.equation.body
    letters = (s for s in walk(body.left) if isinstance(s, Sym)) if isinstance(body, Relation) else iter(())
    return next((q for s in letters if (q := notation.quantity(s.name)) and q != "u"), None)


def _of_other_order(row: Row, display: list[Row]) -> str:
    """Conditions at an end of the rod that stand together are of one order."""
    if row.equation.place is None:
        return ""
    orders = Counter(_highest(r) for r in display if r.equation.place is not None)
    usual, times = orders.most_common(1)[0]
    if _highest(row) != usual and times > orders[_highest(row)]:
        return f"a condition of order {_highest(row)} among those of order {usual}"
    return ""


def _highest(row: Row) -> int:
    return max(
        (int(s.order) for s in walk(row.equation.body) if isinstance(s, Sym) and s.order.isdigit()), default=0
    )
