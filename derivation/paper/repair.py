"""An equation that does not hold: the difference in short, and the smallest edit that makes it hold."""

from __future__ import annotations

from dataclasses import dataclass, replace
from itertools import islice

from derivation.paper.edits import Edit, repairs
from derivation.paper.ledger import holds
from derivation.paper.lower import Lowering
from derivation.paper.mistakes import ZERO
from derivation.paper.notation import Notation
from derivation.paper.reasons import UndecidedError, UnfitError
from derivation.paper.rows import Row
from derivation.paper.syntax import Equation, Expr, Int, Node, Quot, Relation, Rest, Sum, Sym, walk
from derivation.paper.theory import Theory
from derivation.paper.typeset import latex, tree

#: A difference of at most so many terms is named as a missing (or surplus) term.
SHORT = 3
#: At most so many edits are tried for one equation, and for one with integrals, where each takes far longer;
#: of every single error in alpha or beta the edit that undoes it is among the first 160.
TRIALS, TRIALS_OF_INTEGRALS = 300, 200


@dataclass(frozen=True)
class Repair:
    """What would make an equation true.

    Attributes:
        kind: what was wrong: "sign", "factor", "symbol", "missing term", ...
        text: the edit in words, mathematics as LaTeX.
        latex: the equation after it, ``body`` its tree.
    """

    kind: str
    text: str
    latex: str
    body: Node


def repair(row: Row, notation: Notation, theory: Theory) -> Repair | None:
    """The smallest single edit of the printed equation after which it holds; None if there is none."""
    integrals = any(isinstance(n, Int) for n in walk(row.equation.body))
    trials = TRIALS_OF_INTEGRALS if integrals else TRIALS
    for edit in islice(sorted(repairs(row.equation, notation), key=_size), trials):
        if _empty(edit.equation, notation, theory):
            continue
        if holds(edit.equation, notation, theory) and not _vacuous(edit.equation, notation, theory):
            return Repair(edit.kind, _words(edit), _printed(edit.equation), edit.equation.body)
    return _missing_term(row, notation, theory)


def _empty(equation: Equation, notation: Notation, theory: Theory) -> bool:
    """It says of its letters no more than that each is itself: no rule of the theory is needed."""
    body = equation.body
    if not isinstance(body, Relation):
        return True
    left, right = ({n for n in walk(side) if isinstance(n, Sym)} for side in (body.left, body.right))
    if not left <= right:
        return False
    try:
        return not any(Lowering(equation, notation, theory).differences())
    except (UndecidedError, UnfitError, ZeroDivisionError):
        return False


def _vacuous(equation: Equation, notation: Notation, theory: Theory) -> bool:
    """It holds only because each of its terms vanishes."""
    body = equation.body
    if not isinstance(body, Relation):
        return True
    sides = (body.left, body.right)
    terms = [t for s in sides for t in (s.terms if isinstance(s, Sum) else (s,))]
    terms = [t for t in terms if t != ZERO and not isinstance(t, Rest)]
    nothing = Rest("nst") if Rest("nst") in walk(body) else ZERO
    single = (replace(equation, body=Relation(body.op, t, nothing)) for t in terms)
    return len(terms) > 1 and all(holds(e, notation, theory) for e in single)


def _size(edit: Edit) -> tuple[bool, int]:
    """Edits of small pieces before edits of large ones; something put in comes last."""
    sizes = [sum(1 for _ in walk(n)) for n in (edit.old, edit.new) if n is not None]
    return edit.kind == "missing factor", max(sizes)


def _words(edit: Edit) -> str:
    if edit.new is None and edit.old is not None:
        return f"leave out {latex(edit.old)}"
    assert edit.old is not None
    assert edit.new is not None
    return f"write {latex(edit.new)} for {latex(edit.old)}"


def _missing_term(row: Row, notation: Notation, theory: Theory) -> Repair | None:
    """Left minus right is what the right side lacks, or its numerator, where it is short."""
    body = row.equation.body
    if not isinstance(body, Relation) or not row.difference or len(row.difference.terms) > SHORT:
        return None
    lacking = tree(row.difference, notation)
    terms = lacking.terms if isinstance(lacking, Sum) else (lacking,)
    wholes: list[tuple[str, Expr]] = [("on the right", _with_terms(body.right, terms))]
    if isinstance(body.right, Quot):
        wholes.append(("in the numerator", replace(body.right, num=_with_terms(body.right.num, terms))))
    for where, right in wholes:
        whole = Relation(body.op, body.left, right)
        mended = replace(row.equation, body=whole)
        if not _empty(mended, notation, theory) and holds(mended, notation, theory):
            return Repair("missing term", f"add {latex(lacking)} {where}", latex(whole), whole)
    return None


def _with_terms(side: Expr, terms: tuple[Expr, ...]) -> Sum:
    return Sum((*(side.terms if isinstance(side, Sum) else (side,)), *terms))


def _printed(equation: Equation) -> str:
    place = equation.place
    at = rf" \quad \mathrm{{at}}\ {latex(place)}" if place is not None else ""
    return latex(equation.body) + at
