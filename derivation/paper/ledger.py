"""The ledger: one row for each equation, decided in the exact algebra.

An equation is lowered to left minus right and reduced by what holds where it stands: kinematic expansions
by nothing (they are identities for generic fields), an equation of order n by the solutions of lower orders
and by the balance laws, a condition by those of its end. It holds iff nothing is left.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from fractions import Fraction
from typing import Literal

from derivation.errors import ModelError
from derivation.paper.algebra import (
    Atom,
    I,
    Poly,
    cleared,
    constant,
    exp,
    harmonic,
    poly,
    rational,
)  # fmt: skip
from derivation.paper.lower import Lowering, UndecidedError, UnfitError
from derivation.paper.notation import Notation
from derivation.paper.syntax import Apply, Equation, Node, Prime, Relation, Sym, Tuple, rebuild, walk
from derivation.paper.theory import FIELDS, LOADS, STRAINS, STRESSES, VELOCITIES, Theory, normal_integrals

Status = Literal["premise", "verified", "differs", "not decided"]

#: The paper's step of the centred difference in the force.
STEP = Fraction(1, 100)


@dataclass(frozen=True)
class Row:
    """One equation decided.

    Attributes:
        reason: in words, what the status rests on.
        difference: left minus right after reduction; zero when the equation holds.
    """

    equation: Equation
    status: Status
    reason: str
    difference: Poly


def ledger(equations: Iterable[Equation], notation: Notation, theory: Theory) -> list[Row]:
    """Decide every equation, and see that the conditions of a display are complete."""
    return list(_complete([decide(e, notation, theory) for e in equations], notation))


#: Letters that occur side by side, in the order in which a list of conditions runs through them.
FAMILIES = (
    FIELDS, STRESSES, ("y_hat", "theta_hat"), ("Y", "Theta"), ("Psi_Y", "Psi_Theta"), ("X0", "X2"),
    ("e1", "e2"), ("e1_free", "e2_free"),
)  # fmt: skip


def _complete(rows: list[Row], notation: Notation) -> Iterator[Row]:
    """A list that says one thing twice leaves another out, and its conditions are of one order."""
    displays: dict[tuple[str, int], list[Row]] = {}
    for row in rows:
        displays.setdefault((row.equation.label.rpartition(".")[0], row.equation.line), []).append(row)
    for display in displays.values():
        for k, row in enumerate(display):
            fault = _repeats(k, display, notation) or _of_other_order(row, display)
            if fault and row.status in ("premise", "verified"):
                yield Row(row.equation, "differs", fault, poly(0))
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


def counts(rows: Iterable[Row]) -> dict[str, int]:
    """Rows by status."""
    found = Counter(r.status for r in rows)
    return {s: found[s] for s in ("premise", "verified", "differs", "not decided")}


def decide(equation: Equation, notation: Notation, theory: Theory) -> Row:
    """One equation: lowered, reduced, judged."""
    if isinstance(equation.body, Tuple):
        return Row(equation, "premise", "names quantities and states nothing about them", poly(0))
    low = Lowering(equation, notation, theory)
    try:
        for p in low.differences():
            if left := reduced(low, p):
                return Row(equation, "differs", "left minus right does not vanish", _shortest(low, p, left))
    except (UndecidedError, ModelError) as why:
        return Row(equation, "not decided", str(why), poly(0))
    except (UnfitError, ZeroDivisionError) as why:
        return Row(equation, "differs", str(why), poly(0))
    premise = premise_of(low)
    if premise:
        return Row(equation, "premise", premise, poly(0))
    return Row(equation, "verified", grounds(low), poly(0))


def _shortest(low: Lowering, p: Poly, left: Poly) -> Poly:
    """The difference in the fewest terms: as printed, or reduced, with nu and mu or without."""
    letters = reduced(low, p, keep=frozenset({"nu", "mu"}))
    plain = not any(a.kind in ("inverse", "sqrt", "integral") for a in p.atoms)
    forms = [*([p] if plain else []), letters, left]
    forms += [low.theory.restored(q) for q in forms]
    return min((q for q in forms if q), key=lambda q: len(q.terms))


def reduced(low: Lowering, p: Poly, *, keep: frozenset[str] = frozenset()) -> Poly:
    """What is left of a difference modulo what holds where the equation stands."""
    theory = low.theory
    if is_identity(low):
        return theory.canonical(p, keep=keep)
    if _has(p, "exact"):
        p = theory.by_exact_laws(p)
    n = order_of(low)
    waves = _has(p, "shape") or _has(p, "amplitude") or states_solution(low) or low._leading

    def known(p: Poly) -> Poly:
        return theory.insert_waves(p) if waves else theory.vanishing(p, n)

    p = known(theory.by_equations(known(p)))
    p = theory.by_equations(p)
    if low._leading:
        p = _saturated(p)
    if low.names & {"alpha", "beta"} or any(a.kind == "integral" for a in p.atoms):
        p = theory.slow_equation(p)
    p = _eigenvalue(low, p)
    p = _unsaid(low, theory.canonical(p, keep=keep))
    return _coefficients(low, p)


def is_identity(low: Lowering) -> bool:
    """A strain or velocity of some order alone on the left: a kinematic expansion, for generic fields."""
    body = low.equation.body
    if not (isinstance(body, Relation) and isinstance(body.left, Sym) and body.left.order):
        return False
    if low.names & set(STRESSES):  # a balance law whose drag coefficient is 1
        return False
    return low.notation.quantity(body.left.name) in (*STRAINS, *VELOCITIES)


def states_solution(low: Lowering) -> bool:
    """A field of some order on its own on the left, everywhere: the solution at that order."""
    body = low.equation.body
    if not isinstance(body, Relation) or low.place is not None:
        return False
    head = body.left.fn if isinstance(body.left, Apply) else body.left
    right = {low.notation.quantity(s.name) for s in walk(body.right) if isinstance(s, Sym)}
    return (
        isinstance(head, Sym)
        and bool(head.order)
        and low.notation.quantity(head.name) in FIELDS
        and not right & set(FIELDS)
    )


def order_of(low: Lowering) -> int:
    """The highest order that occurs."""
    orders = [int(o) if o.isdigit() else low.indices.get(o, 0) for _, o in low.quantities if o]
    return max(orders, default=0)


def _has(p: Poly, kind: str) -> bool:
    return any(a.kind == kind for a in p.atoms)


def _saturated(p: Poly) -> Poly:
    """The amplitude on the branch: A = R* e^{i (sigma T + phi)}, T = epsilon^2 t."""
    phase = constant("sigma") * constant("epsilon") ** 2 * constant("t") + constant("phase_0")
    wave = constant("R_star") * exp(I * phase)
    return p.map(lambda a: (wave.conjugate() if a.bar else wave) if a.kind == "amplitude" else None)


def _eigenvalue(low: Lowering, p: Poly) -> Poly:
    """d lambda/dF is beta; a centred difference holds up to powers of its step."""
    step = Atom("constant", "step")
    if step in p.atoms:
        if any(a.name.startswith("lambda") for a in p.atoms):
            p = p.keep(lambda m: dict(m).get(step, 0) <= 0)
        else:
            p = p - constant("step") + rational(STEP.numerator, STEP.denominator)
    if Atom("constant", "lambda_F") in p.atoms:
        slope = constant(low.theory.eigenvalue_slope)
        p = p.map(lambda a: slope if a.name == "lambda_F" else None)
    return p


def _unsaid(low: Lowering, p: Poly) -> Poly:
    """Drop what the equation leaves out: non-secular terms, or high powers of the detuning."""
    if "nst" in low.left_out:
        p = p.keep(lambda m: abs(harmonic(m)) == 1)
    powers = [int(text.split()[1]) for text in low.left_out if text.startswith("from ")]
    if "dots" in low.left_out:
        powers.append(2)
    if powers:
        delta = Atom("constant", "Delta")
        body = low.equation.body
        if isinstance(body, Relation) and low.scalar(body.right).degree(delta) >= min(powers):
            raise UnfitError("terms are printed that the remainder already holds")
        p = p.keep(lambda m: dict(m).get(delta, 0) < min(powers))
    return p


def _coefficients(low: Lowering, p: Poly) -> Poly:
    """alpha and beta: as quotients of integrals where integrals stand, by their parts in polar equations."""
    theory = low.theory
    if any(a.kind == "integral" for a in p.atoms):
        p = p.map(lambda a: _conjugated(theory.landau.get(a.name), a) if a.kind == "constant" else None)
        return cleared(normal_integrals(theory.canonical(theory.by_equations(p))))
    parts = {s: constant(f"{s}_re") + I * constant(f"{s}_im") for s in ("alpha", "beta")}
    return cleared(p.map(lambda a: _conjugated(parts.get(a.name), a) if a.kind == "constant" else None))


def _conjugated(p: Poly | None, a: Atom) -> Poly | None:
    return p.conjugate() if p is not None and a.bar else p


# Status ---------------------------------------------------------------------------------------------------

_STARTS = {
    **dict.fromkeys(("r", "e1", "e2"), "configuration of the rod"),
    **dict.fromkeys(("r_free", "e1_free", "e2_free"), "stress-free configuration"),
    **dict.fromkeys(("h1", "h2", "Pi", "v1", "v2", "Omega"), "definition of strains and velocities"),
    **dict.fromkeys(LOADS, "drag law of the rod"),
    "energy": "stored energy of the rod",
    "mu": "a name",
    "Gamma": "a name",
    "H": "a name",
    "any": "the expansion",
    "tau": "the two times",
    "T": "the two times",
    "A": "polar form of the amplitude",
}


def premise_of(low: Lowering) -> str:
    """Why an equation that holds is a premise; empty when it follows from others."""
    body = low.equation.body
    if not isinstance(body, Relation):
        return ""
    names = low.names
    head = body.left.fn if isinstance(body.left, Apply) else body.left
    while isinstance(head, Prime):
        head = head.arg
    quantity = low.notation.quantity(head.name) if isinstance(head, Sym) else None
    ordered = isinstance(head, Sym) and bool(head.order)
    if isinstance(body.left, Tuple):
        return "the inner product" if body.left.weight is not None and "Phi" in names else ""
    if quantity in ("force", "force_dim") and "Delta" in names:
        return "the scaling of the force"
    if quantity in ("k1", "k2", "gamma1", "gamma3", "force"):
        return "" if low.equation.label.startswith("tab:") else "a dimensionless parameter"
    if quantity in FIELDS and ordered and isinstance(head, Sym) and head.order == "1" and low.place is None:
        ends = isinstance(body.left, Apply) and any(_is_number(a) for a in body.left.args)
        return "" if ends else "the ansatz"
    if quantity in _STARTS and not ordered:
        return _STARTS[quantity]
    if not any(order for _, order in low.quantities):
        if quantity in (*FIELDS, *STRESSES) and isinstance(body.left, Apply) and "R_star" not in names:
            return "condition at an end of the rod"
        if names & set(LOADS):
            return "balance law"
    if "delta" in names and "lambda" not in names:
        return "the step of the centred difference"
    return ""


def _is_number(node: object) -> bool:
    return not isinstance(node, Sym)


def grounds(low: Lowering) -> str:
    """What an equation that follows was reduced by."""
    n = order_of(low)
    if is_identity(low):
        return "identity for generic fields"
    if low.place is not None:
        return f"by the conditions at u = {low.place}"
    if n:
        return f"by the equations up to order {n}"
    return "by the equations it stands on"


GROUPS = ("exact rod", "order 1", "order 2", "order 3", "modes and adjoint", "amplitude")


def grouped(equation: Equation, notation: Notation, theory: Theory) -> str:
    """The part of the theory that an equation belongs to, one of :data:`GROUPS`."""
    low = Lowering(equation, notation, theory)
    order = max((int(o) for _, o in low.quantities if o.isdigit()), default=0)
    if low.names & {"R", "R_star", "sigma", "A_tip", "alpha", "beta", "lambda", "phase", "delta"}:
        return "amplitude"
    if order:
        return f"order {order}"
    if low.names & {"X0", "X2", "P0", "P2"}:
        return "order 2"
    if low.names & {"g1", "g2", "g3", "g4"}:
        return "order 3"
    if low.names & {"Y", "Theta", "H", "Psi", "Psi_Y", "Psi_Theta", "L", "weighted_L", "Gamma", "G"}:
        return "modes and adjoint"
    return "exact rod"


def stage_of(equation: Equation, notation: Notation, theory: Theory) -> str:
    """The module of the derivation that an equation's content comes from."""
    low = Lowering(equation, notation, theory)
    names, group = low.names, grouped(equation, notation, theory)
    if names & {"g1", "g2", "g3", "g4"} and names & {"alpha", "beta"}:
        return "derivation/solvability.py"
    if group == "amplitude":
        return "derivation/amplitude.py"
    if is_identity(low) or (group == "exact rod" and names & {"r", "e1", "e2"}):
        return "derivation/kinematics.py"
    if names & {"X0", "X2", "P0", "P2"} and not names & {"g1", "g3"}:
        return "derivation/corrections.py"
    if names & {"g1", "g2", "g3", "g4", "y_hat", "theta_hat"} or (
        order_of(low) == 3 and names & {"f2", "f3"}
    ):
        return "derivation/resonance.py"
    if names & {"Psi", "Psi_Y", "Psi_Theta"}:
        return "derivation/adjoint.py"
    if group.startswith("order"):
        return "derivation/hierarchy.py"
    return "derivation/harmonics.py" if group == "modes and adjoint" else "derivation/model.py"
