r"""The adjoint of the linear operator under the Gamma inner product, by integration by parts.

For generic functions (Y, Theta) and (Psi_Y, Psi_Theta) of u,

    Psi^dagger M phi = (M^dagger Psi)^dagger phi + dQ/du,

is an identity in the ring of jets (Lagrange's identity); Q is the bilinear concomitant. With S phi the
linearised stresses minus load at the tip (S phi = 0 there), Q - Psi^dagger S phi holds no derivative of phi
at u = 1, and phi itself vanishes at u = 0. The adjoint conditions are what makes Q(1) - Psi^dagger S phi (1)
and Q(0) vanish for every phi; no tip condition of phi has to be used.
"""

from __future__ import annotations

from dataclasses import dataclass

from sympy.polys.rings import PolyElement

from derivation.harmonics import Modes, conjugate_rules
from derivation.hierarchy import Hierarchy
from derivation.jets import JetRing, homomorphism
from derivation.symbols import BAR

_PRIMAL = ("Y", "Theta")
_DUAL = ("Psi_Y", "Psi_Theta")


@dataclass(frozen=True)
class Adjoint:
    """The adjoint problem.

    Attributes:
        modes: the ring of modes with the adjoint equations among its rules.
        primal: the rows of M (Y, Theta), drag not divided out, for generic functions.
        tip_stress: S (Y, Theta), for generic functions.
        operator: the rows of M^dagger (Psi_Y, Psi_Theta), starred.
        concomitant: Q for generic functions.
        clamp, tip: expressions in Psi (unstarred) that vanish at u = 0 and u = 1.
    """

    modes: Modes
    primal: tuple[PolyElement, PolyElement]
    tip_stress: tuple[PolyElement, PolyElement]
    operator: tuple[PolyElement, PolyElement]
    concomitant: PolyElement
    clamp: tuple[PolyElement, ...]
    tip: tuple[PolyElement, ...]


def adjoint_problem(hierarchy: Hierarchy, modes: Modes) -> Adjoint:
    """Integrate Psi^dagger M phi by parts.

    Raises:
        ArithmeticError: if Lagrange's identity or the conditions found fail.
    """
    ring = modes.ring
    primal = modes.eigenoperator(hierarchy[1].linear)
    y, theta = (modes.component(modes.image(row), ring["A"]) for row in hierarchy[1].tip_linear[1:])
    tip_stress = (y, theta)
    psi = [ring[s + BAR] for s in _DUAL]
    bilinear = sum((p * row for p, row in zip(psi, primal, strict=True)), ring.zero)
    remainder, concomitant = integrate_by_parts(ring, bilinear, _PRIMAL)
    if bilinear != remainder + ring.derive(concomitant, "u"):
        raise ArithmeticError("Lagrange's identity fails")
    operator = (remainder.diff(ring["Y"]), remainder.diff(ring["Theta"]))
    clamp = _natural_conditions(
        hierarchy, ring, concomitant, {ring["Y"]: ring.zero, ring["Theta"]: ring.zero}
    )
    loaded = concomitant - sum((p * s for p, s in zip(psi, tip_stress, strict=True)), ring.zero)
    if any(ring[s + "_u"] in ring.generators_of(loaded) for s in _PRIMAL):
        raise ArithmeticError(f"the tip stresses are not the natural ones: {loaded}")
    tip = _natural_conditions(hierarchy, ring, loaded, {})
    with_rules = _with_adjoint_rules(hierarchy, modes, operator, clamp, tip)
    return Adjoint(with_rules, primal, tip_stress, operator, concomitant, clamp, tip)


def integrate_by_parts(
    ring: JetRing, p: PolyElement, shapes: tuple[str, ...]
) -> tuple[PolyElement, PolyElement]:
    """Write p, linear in the jets of ``shapes``, as R + dQ/du with R free of derivatives of ``shapes``."""
    concomitant = ring.zero
    for depth in range(3, 0, -1):
        for s in shapes:
            name = f"{s}_{'u' * depth}"
            if name not in ring:
                continue
            top, lower = ring[name], ring[f"{s}_{'u' * (depth - 1)}" if depth > 1 else s]
            coefficient = p.diff(top)
            # c phi^(m) = (c phi^(m-1))' - c' phi^(m-1)
            concomitant += coefficient * lower
            p = p - coefficient * top - ring.derive(coefficient, "u") * lower
    return p, concomitant


def _natural_conditions(
    hierarchy: Hierarchy, ring: JetRing, concomitant: PolyElement, primal: dict[PolyElement, PolyElement]
) -> tuple[PolyElement, ...]:
    """Coefficients of what the primal conditions leave free in Q, unstarred; k2 nu - mu is -load."""
    free = ring.apply(concomitant, primal)
    jets = [ring[s + d] for s in _PRIMAL for d in ("", "_u")]
    conditions = (ring.conjugate(c) for c in ring.parts(free, jets).values())
    letters = {ring["mu"]: homomorphism(hierarchy.straight.mu, {}, ring)}
    found = []
    for c in conditions:
        with_load = ring.apply(c, letters)
        shorter = with_load if len(with_load) < len(c) else c
        found.append(_without_constant_factor(ring, shorter))
    return tuple(sorted(found, key=str))


def _without_constant_factor(ring: JetRing, p: PolyElement) -> PolyElement:
    """A condition p = 0 up to a constant: c Psi = 0 becomes Psi = 0; the highest derivative is positive."""
    jets = [g for g in ring.generators_of(p) if str(g).startswith("Psi")]
    split = ring.parts(p, jets)
    if len(split) == 1:
        return next(iter(split))
    highest = max(split, key=lambda m: str(m).count("u"))
    return p if split[highest].LC.x > 0 else -p


def _with_adjoint_rules(
    hierarchy: Hierarchy,
    modes: Modes,
    operator: tuple[PolyElement, PolyElement],
    clamp: tuple[PolyElement, ...],
    tip: tuple[PolyElement, ...],
) -> Modes:
    """M^dagger Psi = -i omega Gamma Psi at the threshold gives the highest derivatives of Psi."""
    ring, straight = modes.ring, hierarchy.straight
    minus_i_omega = -ring.i * ring["omega"]
    rules, at_tip = {}, {}
    for k, (s, row) in enumerate(zip(_DUAL, map(ring.conjugate, operator), strict=True), start=1):
        weight, inverse = (homomorphism(v[k], {}, ring) for v in (straight.weights, straight.inverse))
        top, slope = ring[f"{s}_uu"], ring[f"{s}_u"]
        rules[top] = ring.reduce(inverse * (minus_i_omega * weight * ring[s] - (row - row.diff(top) * top)))
        condition = next(c for c in tip if slope in ring.generators_of(c))
        solved = condition * _sign(ring, condition, slope)
        if solved.diff(slope) != ring.one:  # it still carries the stiffness
            solved = inverse * solved
        at_tip[slope] = ring.reduce(slope - solved)
    with_rules = modes.with_rules({}, rules)
    at_clamp = {ring[s]: ring.zero for s in _DUAL}
    for c in tip:
        if ring.reduce(ring.apply(c, at_tip)):
            raise ArithmeticError(f"the adjoint tip condition {c} = 0 is not solved by {at_tip}")
    for c in clamp:
        if ring.apply(c, at_clamp):
            raise ArithmeticError(f"the adjoint clamp condition {c} = 0 is not solved by {at_clamp}")
    at_clamp |= conjugate_rules(ring, at_clamp)
    at_tip |= conjugate_rules(ring, at_tip)
    return Modes(
        ring, with_rules.fields, with_rules.interior, {**modes.tip, **at_tip}, {**modes.clamp, **at_clamp}
    )


def _sign(ring: JetRing, condition: PolyElement, slope: PolyElement) -> int:
    return 1 if condition.diff(slope).LC.x > 0 else -1
