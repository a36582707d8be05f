r"""Fredholm's condition at order 3, twice: with the transformed variables and with the boundary term kept.

With  L xi = (i omega Gamma - M) xi = f  and  y' - nu theta = b2, theta' = b3  at the tip, Lagrange's identity
gives  int Psi^dagger f du + Q(1) - Q(0) = 0, and Q(1) = k2 Psi_Y^* b2 + Psi_Theta^* b3  by the adjoint
conditions. The transformed variables have b = 0; both ways must give the same alpha and beta.
"""

from __future__ import annotations

from dataclasses import dataclass

from sympy.polys.rings import PolyElement

from derivation.adjoint import Adjoint
from derivation.harmonics import Modes
from derivation.jets import JetRing
from derivation.resonance import Pair, ThirdOrder
from derivation.symbols import BAR, TIP


@dataclass(frozen=True)
class Functional:
    """int_0^1 integrand du + boundary, with boundary a constant made of tip values."""

    integrand: PolyElement
    boundary: PolyElement


@dataclass(frozen=True)
class LandauCoefficients:
    """alpha = cubic/norm and beta = detuning/norm (eq:alphabetaformulas), by both routes.

    Attributes:
        norm: int Psi_Y^* Y + gamma3 Psi_Theta^* Theta du, the weight of dA/dT.
        cubic, detuning: with transformed variables; their boundary part is zero.
        cubic_kept, detuning_kept: with the boundary term kept.
    """

    norm: Functional
    cubic: Functional
    detuning: Functional
    cubic_kept: Functional
    detuning_kept: Functional


def solvability(third: ThirdOrder, adjoint: Adjoint) -> LandauCoefficients:
    """Project the resonant forcing on the adjoint mode; prove that both routes agree.

    Raises:
        ArithmeticError: if they do not.
    """
    modes = adjoint.modes
    ring = modes.ring
    norm = Functional(-_project(modes, third.resonant.slow), ring.zero)
    results = [
        Functional(_project(modes, rows), ring.zero)
        for rows in (third.resonant.cubic, third.resonant.detuning)
    ]
    kept = [
        Functional(_project(modes, rows), _tip_term(modes, b))
        for rows, b in (
            (third.untransformed.cubic, third.boundary.cubic),
            (third.untransformed.detuning, third.boundary.detuning),
        )
    ]
    a, a_bar, delta = ring["A"], ring["A" + BAR], ring["Delta"]
    for one, two, monomial in zip(results, kept, (a**2 * a_bar, delta * a), strict=True):
        shift: Pair = tuple(modes.component(s, monomial) for s in third.shift)
        prove_equal(adjoint, one, two, shift)
    return LandauCoefficients(norm, *results, *kept)


def prove_equal(adjoint: Adjoint, transformed: Functional, kept: Functional, shift: Pair) -> None:
    """transformed - kept is a total derivative whose end terms cancel the boundary term.

    The shift s of the variables changes the bulk forcing by -L s, and Psi^dagger L s = -dQ(Psi, s)/du modulo
    the adjoint equations.

    Raises:
        ArithmeticError: if one of the two steps fails.
    """
    modes = adjoint.modes
    ring = modes.ring
    q = _concomitant_of(adjoint, shift)
    bulk = modes.reduce(transformed.integrand - kept.integrand - ring.derive(q, "u"))
    if canonical(ring, bulk):
        raise ArithmeticError(f"the two integrands do not differ by a total derivative: {bulk}")
    ends = modes.at_tip(q) - modes.at_clamp(q) - kept.boundary
    ends = tip_values(modes, ends)
    if canonical(ring, ends):
        raise ArithmeticError(f"the end terms do not cancel: {ends}")


def canonical(ring: JetRing, p: PolyElement) -> PolyElement:
    """The normal form in which equality is decided: mu and force eliminated, k1 nu, 1/k1, 1/k2 resolved.

    mu = k2 nu + force and force = k1 (1 - nu).
    """
    return ring.reduce(
        ring.apply(
            ring.apply(p, {ring["mu"]: ring["k2"] * ring["nu"] + ring["force"]}),
            {ring["force"]: ring["k1"] * (1 - ring["nu"])},
        )
    )


def tip_values(modes: Modes, p: PolyElement) -> PolyElement:
    """Write the shapes that are left in an expression valid at u = 1 as the constants they are."""
    ring = modes.ring
    images = {ring[s + b]: ring[s + b + TIP] for s in ("Y", "Theta", "Psi_Y", "Psi_Theta") for b in ("", BAR)}
    return ring.apply(p, images)


def _project(modes: Modes, rows: Pair) -> PolyElement:
    ring = modes.ring
    return modes.reduce(ring["Psi_Y" + BAR] * rows[0] + ring["Psi_Theta" + BAR] * rows[1])


def _tip_term(modes: Modes, b: Pair) -> PolyElement:
    ring = modes.ring
    return ring["k2"] * ring["Psi_Y" + BAR + TIP] * b[0] + ring["Psi_Theta" + BAR + TIP] * b[1]


def _concomitant_of(adjoint: Adjoint, shift: Pair) -> PolyElement:
    """Q(Psi, s): the concomitant with s in the place of (Y, Theta)."""
    ring = adjoint.modes.ring
    total = ring.zero
    for s, value in zip(("Y", "Theta"), shift, strict=True):
        for depth in range(2):
            slot = ring[s + ("_u" if depth else "")]
            total += adjoint.concomitant.diff(slot) * (ring.derive(value, "u") if depth else value)
    return total
