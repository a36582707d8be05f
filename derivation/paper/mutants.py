"""Does the ledger see errors? Every decidable equation is edited as people err, and the ledger must notice.

An edit is *equivalent* when it leaves the statement as it was: modulo the conditions of lower orders, the new
left minus right is a constant times the old one or its conjugate. All others change the meaning and must be
reported on the edited row and on no other: it differs, or holds with a remark.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import dataclass

from derivation.paper.algebra import Poly
from derivation.paper.edits import Edit, errors
from derivation.paper.kinds import is_choice, order_of
from derivation.paper.ledger import ledger
from derivation.paper.lower import Lowering
from derivation.paper.notation import Notation
from derivation.paper.reasons import UndecidedError, UnfitError
from derivation.paper.rows import Row
from derivation.paper.syntax import Equation, Tuple
from derivation.paper.theory import Theory


@dataclass(frozen=True)
class Mutant:
    """One edit and what became of it: ``reported``, ``equivalent`` or ``missed``; the row as decided."""

    label: str
    edit: Edit
    outcome: str
    row: Row


def mutants(equations: Iterable[Equation], notation: Notation, theory: Theory) -> Iterator[Mutant]:
    """All edits of all decidable equations, each decided in the display that it stands in."""
    displays: dict[tuple[str, int], list[Equation]] = {}
    for e in equations:
        displays.setdefault((e.label.rpartition(".")[0], e.line), []).append(e)
    for display in displays.values():
        for k, equation in enumerate(display):
            if isinstance(equation.body, Tuple) or is_choice(Lowering(equation, notation, theory)):
                continue  # states nothing that follows or not
            before = statement(equation, notation, theory)
            for edit in errors(equation, notation):
                rows = ledger([*display[:k], edit.equation, *display[k + 1 :]], notation, theory)
                others = [r for j, r in enumerate(rows) if j != k and r.status == "differs"]
                seen = rows[k].status == "differs" or rows[k].remark
                if seen and not others:
                    outcome = "reported"
                elif not others and same(before, statement(edit.equation, notation, theory)):
                    outcome = "equivalent"
                else:
                    outcome = "missed"
                yield Mutant(equation.label, edit, outcome, rows[k])


def statement(equation: Equation, notation: Notation, theory: Theory) -> list[Poly] | None:
    """Left minus right modulo the conditions of lower orders; None when it has no meaning."""
    low = Lowering(equation, notation, theory)
    try:
        return [theory.by_lower_orders(p, order_of(low)) for p in low.differences()]
    except (UndecidedError, UnfitError, ZeroDivisionError):
        return None


def same(one: list[Poly] | None, two: list[Poly] | None) -> bool:
    """Whether two statements are constant multiples of each other, or of each other's conjugate."""
    if one is None or two is None or len(one) != len(two):
        return False
    return all(_proportional(p, q) or _proportional(p, q.conjugate()) for p, q in zip(one, two, strict=True))


def _proportional(p: Poly, q: Poly) -> bool:
    if set(p.terms) != set(q.terms):
        return False
    ratios = {q.terms[m] / c for m, c in p.terms.items()}
    return len(ratios) <= 1


def main() -> int:
    """All edits of the bundled equations; the score, and what was missed."""
    from collections import Counter
    from pathlib import Path

    from derivation.paper.notation import load
    from derivation.paper.read import read
    from derivation.paper.typeset import latex
    from derivation.pipeline import derive

    notation = load()
    text = Path(__file__).with_name("equations.tex").read_text(encoding="utf-8")
    score: Counter[str] = Counter()
    for m in mutants(read(text, notation).equations, notation, Theory(derive())):
        score[m.outcome] += 1
        if m.outcome == "missed":
            print(f"missed: {m.label}, {m.edit.kind}: {latex(m.edit.equation.body)}")
    changing = score["reported"] + score["missed"]
    print(f"{score['reported']} of {changing} edits reported")
    print(f"{score['equivalent']} more leave the meaning as it is")
    return 1 if score["missed"] else 0


if __name__ == "__main__":
    raise SystemExit(main())
