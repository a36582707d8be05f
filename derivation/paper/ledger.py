"""The ledger: one row for each equation, decided in the exact algebra.

An equation is lowered to left minus right and reduced by what holds where it stands: kinematic expansions
by nothing (they are identities for generic fields), an equation of order n by the solutions of lower orders
and by the balance laws, a condition by those of its end. It holds if nothing is left. It differs if what is
left is not zero in the free algebra (:mod:`derivation.paper.free`); else no rule decides it.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable

from derivation.paper.algebra import poly
from derivation.paper.displays import complete
from derivation.paper.free import is_decisive
from derivation.paper.kinds import grounds, is_choice, premise_of
from derivation.paper.lower import Lowering
from derivation.paper.notation import Notation
from derivation.paper.reasons import UndecidedError, UnfitError
from derivation.paper.reduction import reduced, shortest
from derivation.paper.rows import Row
from derivation.paper.syntax import Equation, Tuple
from derivation.paper.theory import Theory


def ledger(equations: Iterable[Equation], notation: Notation, theory: Theory) -> list[Row]:
    """Decide every equation, and see that the conditions of a display are complete."""
    return list(complete([decide(e, notation, theory) for e in equations], notation))


def counts(rows: Iterable[Row]) -> dict[str, int]:
    """Rows by status."""
    found = Counter(r.status for r in rows)
    return {s: found[s] for s in ("premise", "verified", "differs", "not decided")}


def holds(equation: Equation, notation: Notation, theory: Theory) -> bool:
    """Whether an equation is true, by itself or as a premise; no account is given of why."""
    if isinstance(equation.body, Tuple):
        return len(set(equation.body.items)) == len(equation.body.items)
    low = Lowering(equation, notation, theory)
    try:
        return not any(reduced(low, p) for p in low.differences())
    except (UndecidedError, UnfitError, ZeroDivisionError):
        return False


def decide(equation: Equation, notation: Notation, theory: Theory) -> Row:
    """One equation: lowered, reduced, judged."""
    if isinstance(equation.body, Tuple):
        if len(set(equation.body.items)) < len(equation.body.items):
            return Row(equation, "differs", "names one quantity twice", poly(0))
        return Row(equation, "premise", "names quantities and states nothing about them", poly(0))
    low = Lowering(equation, notation, theory)
    try:
        if is_choice(low):
            return Row(equation, "premise", "the step of the difference quotient", poly(0))
        open_ = False
        for p in low.differences():
            if left := reduced(low, p):
                if is_decisive(theory, left):
                    return Row(
                        equation, "differs", "left minus right does not vanish", shortest(low, p, left)
                    )
                open_ = True
        if open_:
            return Row(equation, "not decided", "no rule brings left minus right to zero", poly(0))
    except UndecidedError as why:
        return Row(equation, "not decided", str(why), poly(0))
    except (UnfitError, ZeroDivisionError) as why:
        return Row(equation, "differs", str(why), poly(0))
    premise = premise_of(low)
    if premise:
        return Row(equation, "premise", premise, poly(0))
    return Row(equation, "verified", grounds(low), poly(0))
