r"""The adjoint of the linear operator under the Gamma inner product, by integration by parts.

For generic functions (Y, Theta) and (Psi_Y, Psi_Theta) of u,

    Psi^dagger M phi = (M^dagger Psi)^dagger phi + dQ/du,

is an identity in the ring of jets (Lagrange's identity); Q is the bilinear concomitant. The adjoint
conditions are what makes Q vanish at both ends for every phi that satisfies the primal ones.
"""

from __future__ import annotations

from dataclasses import dataclass

from sympy.polys.rings import PolyElement

from derivation.harmonics import Modes, conjugate_rules
from derivation.jets import JetRing
from derivation.symbols import BAR

_PRIMAL = ("Y", "Theta")
_DUAL = ("Psi_Y", "Psi_Theta")


@dataclass(frozen=True)
class Adjoint:
    """The adjoint problem.

    Attributes:
        modes: the ring of modes with the adjoint equations among its rules.
        primal: the rows of M (Y, Theta), drag not divided out, for generic functions.
        operator: the rows of M^dagger (Psi_Y, Psi_Theta), starred.
        concomitant: Q for generic functions.
        clamp, tip: expressions in Psi (unstarred) that vanish at u = 0 and u = 1.
    """

    modes: Modes
    primal: tuple[PolyElement, PolyElement]
    operator: tuple[PolyElement, PolyElement]
    concomitant: PolyElement
    clamp: tuple[PolyElement, ...]
    tip: tuple[PolyElement, ...]


def adjoint_problem(modes: Modes, primal: tuple[PolyElement, PolyElement]) -> Adjoint:
    """Integrate Psi^dagger M phi by parts; ``primal`` are the rows of M applied to (Y, Theta)."""
    ring = modes.ring
    psi = [ring[s + BAR] for s in _DUAL]
    bilinear = sum((p * row for p, row in zip(psi, primal, strict=True)), ring.zero)
    remainder, concomitant = integrate_by_parts(ring, bilinear, _PRIMAL)
    operator = tuple(remainder.diff(ring[s]) for s in _PRIMAL)
    if bilinear != remainder + ring.derive(concomitant, "u"):
        raise ArithmeticError("Lagrange's identity fails")
    clamp = _natural_conditions(ring, concomitant, {ring["Y"]: ring.zero, ring["Theta"]: ring.zero})
    tip = _natural_conditions(
        ring, concomitant, {ring["Y_u"]: ring["nu"] * ring["Theta"], ring["Theta_u"]: ring.zero}
    )
    return Adjoint(
        _with_adjoint_rules(modes, operator, clamp, tip),
        primal,
        operator,
        concomitant,
        clamp,
        tip,
    )


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
    ring: JetRing, concomitant: PolyElement, primal: dict[PolyElement, PolyElement]
) -> tuple[PolyElement, ...]:
    """Coefficients of what the primal conditions leave free in Q, unstarred; k2 nu - mu is -force."""
    free = ring.apply(concomitant, primal)
    jets = [ring[s + d] for s in _PRIMAL for d in ("", "_u")]
    conditions = (ring.conjugate(c) for c in ring.parts(free, jets).values())
    letters = {ring["mu"]: ring["k2"] * ring["nu"] + ring["force"]}
    found = []
    for c in conditions:
        with_force = ring.apply(c, letters)
        shorter = with_force if len(with_force) < len(c) else c
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
    modes: Modes,
    operator: tuple[PolyElement, PolyElement],
    clamp: tuple[PolyElement, ...],
    tip: tuple[PolyElement, ...],
) -> Modes:
    """M^dagger Psi = -i omega Gamma Psi at the threshold gives the highest derivatives of Psi."""
    ring = modes.ring
    minus_i_omega = -ring.i * ring["omega"]
    rows = [ring.conjugate(row) for row in operator]
    weights = (ring.one, ring["gamma3"])
    inverse = (ring["k2_inv"], ring.one)
    rules = {}
    for s, row, weight, inv in zip(_DUAL, rows, weights, inverse, strict=True):
        top = ring[f"{s}_uu"]
        rest = row - row.diff(top) * top
        rules[top] = ring.reduce(inv * (minus_i_omega * weight * ring[s] - rest))
    with_rules = modes.with_rules({}, rules)
    at_clamp = {ring[s]: ring.zero for s in _DUAL}
    at_tip = {
        ring["Psi_Y_u"]: ring.reduce(ring["k2_inv"] * ring["mu"] * ring["Psi_Theta"]),
        ring["Psi_Theta_u"]: -ring["force"] * ring["Psi_Y"],
    }
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
