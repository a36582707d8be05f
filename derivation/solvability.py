r"""Fredholm's condition at order 3, twice: the tip load of that order kept, and transformed away.

With  (i omega Gamma - M) xi = f  and  S xi = t  at the tip (stresses minus load), Lagrange's identity and the
adjoint conditions give

    int Psi^dagger f du + Psi^dagger t (1) = 0.

That holds for every rod. Where transformed variables exist they have t = 0; both ways must give the same
alpha and beta, and that they do is proved.
"""

from __future__ import annotations

from dataclasses import dataclass

from sympy.polys.rings import PolyElement

from derivation.adjoint import Adjoint
from derivation.constitutive import is_rational
from derivation.harmonics import Modes
from derivation.hierarchy import Hierarchy
from derivation.jets import JetRing, from_expr, homomorphism
from derivation.resonance import Pair, ThirdOrder, at_tip_value
from derivation.symbols import BAR, STRAIGHT, TIP


@dataclass(frozen=True)
class Functional:
    """int_0^1 integrand du + boundary, with boundary a constant made of tip values."""

    integrand: PolyElement
    boundary: PolyElement


@dataclass(frozen=True)
class LandauCoefficients:
    """alpha = cubic/norm and beta = detuning/norm (eq:alphabetaformulas).

    Attributes:
        norm: int Psi^dagger Gamma (Y, Theta) du and what a load with drag adds, the weight of dA/dT.
        cubic_kept, detuning_kept: with the boundary term kept.
        cubic, detuning: with transformed variables, their boundary part being zero; None without them.
    """

    norm: Functional
    cubic_kept: Functional
    detuning_kept: Functional
    cubic: Functional | None
    detuning: Functional | None


def solvability(hierarchy: Hierarchy, third: ThirdOrder, adjoint: Adjoint) -> LandauCoefficients:
    """Project the resonant forcing on the adjoint mode; prove that both routes agree.

    Raises:
        ArithmeticError: if they do not.
    """
    modes = adjoint.modes
    ring = modes.ring
    slow, cubic, detuning = (
        Functional(_project(modes, rows), _tip_term(modes, t))
        for rows, t in (
            (third.bulk.slow, third.traction.slow),
            (third.bulk.cubic, third.traction.cubic),
            (third.bulk.detuning, third.traction.detuning),
        )
    )
    norm = Functional(-slow.integrand, -slow.boundary)
    transformed = third.transformed
    if transformed is None:
        return LandauCoefficients(norm, cubic, detuning, None, None)
    a, a_bar, delta = ring["A"], ring["A" + BAR], ring["Delta"]
    shifted = []
    for kept, rows, monomial in (
        (cubic, transformed.resonant.cubic, a**2 * a_bar),
        (detuning, transformed.resonant.detuning, delta * a),
    ):
        one = Functional(_project(modes, rows), ring.zero)
        s_y, s_theta = (modes.component(s, monomial) for s in transformed.shift)
        prove_equal(hierarchy, adjoint, one, kept, (s_y, s_theta))
        shifted.append(one)
    return LandauCoefficients(norm, cubic, detuning, *shifted)


def prove_equal(
    hierarchy: Hierarchy, adjoint: Adjoint, transformed: Functional, kept: Functional, shift: Pair
) -> None:
    """transformed - kept is a total derivative whose end terms cancel the boundary term.

    The shift s of the variables changes the bulk forcing by -(i omega Gamma - M) s, and
    Psi^dagger (i omega Gamma - M) s = -dQ(Psi, s)/du modulo the adjoint equations.

    Raises:
        ArithmeticError: if one of the two steps fails.
    """
    modes = adjoint.modes
    ring = modes.ring
    q = _concomitant_of(adjoint, shift)
    bulk = modes.reduce(transformed.integrand - kept.integrand - ring.derive(q, "u"))
    if canonical(hierarchy, ring, bulk):
        raise ArithmeticError(f"the two integrands do not differ by a total derivative: {bulk}")
    ends = at_tip_value(modes, modes.at_tip(q) - modes.at_clamp(q) - kept.boundary)
    if canonical(hierarchy, ring, ends):
        raise ArithmeticError(f"the end terms do not cancel: {ends}")


def canonical(hierarchy: Hierarchy, ring: JetRing, p: PolyElement) -> PolyElement:
    """A form that, if it vanishes, shows that ``p`` does: in nu alone, without mu and inverse stiffnesses.

    mu = k2 nu + load, and the load is what F1(nu) balances. Inverses are cleared by multiplying with their
    stiffness, which is not zero, before a stiffness is replaced by its formula in nu.
    """
    straight, law = hierarchy.straight, hierarchy.law
    mu, balance = (homomorphism(q, {}, ring) for q in (straight.mu, straight.balance))
    load = homomorphism(straight.load, {}, ring)
    p = ring.apply(p, {ring["mu"]: mu})
    if law.uniform:
        p = ring.apply(p, {load: load - balance})
    p = ring.reduce(p)
    for letter, inverse in law.inverses.items():
        p = ring.reduce(p * ring[letter] ** ring.degree(p, [ring[inverse]]))
    formulas = {
        ring[name]: from_expr(e, ring)
        for name, e in law.constants.items()
        if name in STRAIGHT and is_rational(e)  # another letter stays: equal for any value
    }
    return ring.reduce(ring.apply(p, formulas))


def _project(modes: Modes, rows: Pair) -> PolyElement:
    ring = modes.ring
    return modes.reduce(ring["Psi_Y" + BAR] * rows[0] + ring["Psi_Theta" + BAR] * rows[1])


def _tip_term(modes: Modes, t: Pair) -> PolyElement:
    ring = modes.ring
    return ring["Psi_Y" + BAR + TIP] * t[0] + ring["Psi_Theta" + BAR + TIP] * t[1]


def _concomitant_of(adjoint: Adjoint, shift: Pair) -> PolyElement:
    """Q(Psi, s): the concomitant with s in the place of (Y, Theta)."""
    ring = adjoint.modes.ring
    total = ring.zero
    for s, value in zip(("Y", "Theta"), shift, strict=True):
        for depth in range(2):
            slot = ring[s + ("_u" if depth else "")]
            total += adjoint.concomitant.diff(slot) * (ring.derive(value, "u") if depth else value)
    return total
