"""What is left of an equation's difference modulo what holds where the equation stands."""

from __future__ import annotations

from derivation.paper.algebra import (
    Atom,
    I,
    Poly,
    cleared,
    constant,
    exp,
    harmonic,
    poly,
)
from derivation.paper.byparts import by_parts
from derivation.paper.kinds import is_kinematic, order_of, states_solution
from derivation.paper.lower import Lowering
from derivation.paper.meanings import normal_integrals
from derivation.paper.reasons import UnfitError
from derivation.paper.syntax import Relation
from derivation.paper.theory import Theory


def shortest(low: Lowering, p: Poly, left: Poly) -> Poly:
    """The difference in the fewest terms: as printed, or reduced, with nu and mu or without."""
    letters = reduced(low, p, keep=frozenset({"nu", "mu"}))
    plain = not any(a.kind in ("inverse", "sqrt", "integral") for a in p.atoms)
    forms = [*([p] if plain else []), letters, left]
    forms += [low.theory.restored(q) for q in forms]
    return min((q for q in forms if q), key=lambda q: len(q.terms))


def reduced(low: Lowering, p: Poly, *, keep: frozenset[str] = frozenset()) -> Poly:
    """What is left of a difference modulo what holds where the equation stands."""
    theory = low.theory
    if is_kinematic(low):
        return theory.canonical(p, keep=keep)
    if _has(p, "exact"):
        p = theory.canonical(theory.by_exact_laws(p), keep=keep)
        if p and not _has(p, "integral") and not theory.in_fields(p):
            return poly(0)
    n = order_of(low)
    integrals = _has(p, "integral") and _has(p, "field")
    waves = integrals or _has(p, "shape") or _has(p, "amplitude") or states_solution(low) or low.leading
    waves = waves or "omega_c" in low.names  # its frequency

    def known(p: Poly) -> Poly:
        return theory.insert_waves(p) if waves else theory.vanishing(p, n)

    p = known(theory.by_equations(known(p)))
    p = theory.by_equations(p)
    if low.leading:
        p = _saturated(p)
    if low.names & {"alpha", "beta"} or any(a.kind == "integral" for a in p.atoms):
        p = theory.slow_equation(p)
    p = _eigenvalue(low, p)
    p = theory.canonical(p, keep=keep)
    if low.names & {"sigma", "omega"} and "R" not in low.names:  # on the branch
        radius, branch = Atom("constant", "R"), constant("R_star")
        p = theory.canonical(p.map(lambda a: branch if a == radius else None), keep=keep)
    p = _unsaid(low, p)
    return _coefficients(low, p)


def _has(p: Poly, kind: str) -> bool:
    return any(a.kind == kind for a in p.atoms)


def _saturated(p: Poly) -> Poly:
    """The amplitude on the branch: A = R* e^{i (sigma T + phi)}, T = epsilon^2 t."""
    phase = constant("sigma") * constant("epsilon") ** 2 * constant("t") + constant("phase_0")
    wave = constant("R_star") * exp(I * phase)
    return p.map(lambda a: (wave.conjugate() if a.bar else wave) if a.kind == "amplitude" else None)


def _eigenvalue(low: Lowering, p: Poly) -> Poly:
    """d lambda/dF is beta; a difference quotient that is said to be near holds up to powers of its step."""
    step = Atom("constant", "step")
    if step in p.atoms:
        body = low.equation.body
        if isinstance(body, Relation) and body.op == "simeq":
            p = p.keep(lambda m: dict(m).get(step, 0) <= 0)
    if any(a.name == "lambda_F" for a in p.atoms):
        slope = constant(low.theory.eigenvalue_slope)
        p = p.map(lambda a: _conjugated(slope, a) if a.name == "lambda_F" else None)
    return p


def _unsaid(low: Lowering, p: Poly) -> Poly:
    """Drop what the equation leaves out: non-secular terms, or high powers of the detuning."""
    if "nst" in low.left_out:
        if p and not _has(p, "exp"):
            raise UnfitError("n.s.t. in an equation without time")
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
        p = normal_integrals(theory.canonical(theory.by_equations(p)))
        return by_parts(theory, cleared(p.map(lambda a: _norm(theory, a))))
    parts = {s: constant(f"{s}_re") + I * constant(f"{s}_im") for s in ("alpha", "beta")}
    return cleared(p.map(lambda a: _conjugated(parts.get(a.name), a) if a.kind == "constant" else None))


def _norm(theory: Theory, a: Atom) -> Poly | None:
    """A denominator that is the norm after integration by parts, as the norm."""
    norm = theory.norm
    if a.kind != "inverse" or a.arg == norm or by_parts(theory, a.arg - norm):
        return None
    return norm.inverse()


def _conjugated(p: Poly | None, a: Atom) -> Poly | None:
    return p.conjugate() if p is not None and a.bar else p
