"""The order-3 problem: transformed variables, forcings f2, f3, and their resonant parts g1 ... g4.

The tip conditions of order 3 are not homogeneous. What has to be subtracted from y and theta so that they
become so is found here: of the residue of y' - nu theta at the tip, the terms nu * (a local function of the
fields) are the tip value of that function subtracted from theta at every u, provided it respects the clamp
and theta' = 0; the rest is subtracted from y linearly in u. The subtraction moves into the bulk forcing.
Another profile changes g1 ... g4 but not what the solvability condition makes of them.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

from sympy.polys.rings import PolyElement

from derivation.corrections import SecondOrder
from derivation.harmonics import Modes
from derivation.hierarchy import Hierarchy
from derivation.jets import JetRing
from derivation.symbols import BAR, TIP

Pair = tuple[PolyElement, PolyElement]


@dataclass(frozen=True)
class Resonant:
    """Coefficients of e^{i omega tau} in a pair of expressions (y row, theta row).

    ``cubic`` multiplies |A|^2 A, ``detuning`` Delta A, ``slow`` dA/dT.
    """

    cubic: Pair
    detuning: Pair
    slow: Pair


@dataclass(frozen=True)
class ThirdOrder:
    """Everything of order 3.

    Attributes:
        tip_residue: (b2, b3): y' - nu theta = b2, theta' = b3 at the tip, in jets (eq:followercubic_geom).
        local: what is subtracted from theta, in jets: (theta^(1))^3/6.
        rest: what remains of b2 after that, in jets; y is shifted by -rest(1) u (eq:cubic_transform).
        shift: (s_y, s_theta) = (y, theta) - (transformed y, theta), in modes.
        transformed_tip: tip residue of the transformed variables, zero.
        forcing: (f2, f3) of the transformed system (eq:cubic_forced_system), all harmonics, in modes.
        resonant: its resonant part (eq:cubicforcing): cubic = (g1, g3), detuning = (g2, g4).
        untransformed, boundary: the resonant bulk forcing and the resonant tip residue (b2, b3) when the
            variables are left as they are.
    """

    tip_residue: Pair
    local: PolyElement
    rest: PolyElement
    shift: Pair
    transformed_tip: Pair
    forcing: Pair
    resonant: Resonant
    untransformed: Resonant
    boundary: Resonant

    @property
    def g(self) -> tuple[PolyElement, PolyElement, PolyElement, PolyElement]:
        """(g1, g2, g3, g4) of eq:cubicforcing."""
        (g1, g3), (g2, g4) = self.resonant.cubic, self.resonant.detuning
        return g1, g2, g3, g4


def linear_profile(u: PolyElement) -> PolyElement:
    """The profile of the subtraction from y: 0 at the clamp, slope 1 at the tip."""
    return u


def third_order(
    hierarchy: Hierarchy, second: SecondOrder, profile: Callable[[PolyElement], PolyElement] = linear_profile
) -> ThirdOrder:
    """Derive the transformed system of order 3 and its resonant part.

    Raises:
        ArithmeticError: if the transformed tip conditions are not homogeneous, for instance because
            ``profile`` is not 0 at u = 0 with slope 1 at u = 1.
    """
    modes, order = second.modes, hierarchy[3]
    jets = hierarchy.ring
    # The fields that vanish at the lower orders (x1, y2, theta2) are dropped from what is shown.
    residue: Pair = tuple(_drop_vanishing(jets, modes, b) for b in order.tip_forcing[1:])
    local, rest = _split_residue(jets, residue[0])
    if residue[1]:
        raise ArithmeticError(f"theta' is forced at the tip: {residue[1]}; keep the boundary term instead")

    ring, u = modes.ring, modes.ring["u"]
    s_theta = modes.image(local)
    s_y = profile(u) * at_tip_value(modes, modes.image(rest))
    forcing: Pair = tuple(modes.image(f) for f in order.forcing[1:])
    operator = linear_rows(modes, (s_y, s_theta))
    # linear(xi) = f with xi = transformed + shift, so linear(transformed) = f - linear(shift).
    transformed: Pair = tuple(modes.reduce(f - s) for f, s in zip(forcing, operator, strict=True))
    untransformed: Pair = tuple(modes.reduce(f) for f in forcing)
    boundary: Pair = tuple(modes.at_tip(modes.image(b)) for b in residue)

    d = ring.derive
    left = (
        boundary[0] - modes.at_tip(d(s_y, "u") - ring["nu"] * s_theta),
        boundary[1] - modes.at_tip(d(s_theta, "u")),
    )
    if any(left) or any(modes.at_clamp(s) for s in (s_y, s_theta)):
        raise ArithmeticError(f"the transformed conditions are not homogeneous: {left}")
    return ThirdOrder(
        residue,
        local,
        rest,
        (s_y, s_theta),
        left,
        transformed,
        resonant_part(modes, transformed),
        resonant_part(modes, untransformed),
        resonant_part(modes, boundary),
    )


def linear_rows(modes: Modes, shift: Pair) -> Pair:
    """Gamma d_tau s - M s for (y, theta) = s, the rows of eq:cubic_forced_system without forcing."""
    ring = modes.ring
    (s_y, s_theta), d = shift, ring.derive
    s_y_u, s_theta_u = d(s_y, "u"), d(s_theta, "u")
    y = modes.d_tau(s_y) - ring["k2"] * d(s_y_u, "u") + ring["mu"] * s_theta_u
    theta = (
        ring["gamma3"] * modes.d_tau(s_theta)
        - d(s_theta_u, "u")
        - ring["mu"] * (s_y_u - ring["nu"] * s_theta)
    )
    return y, theta


def resonant_part(modes: Modes, rows: Pair) -> Resonant:
    """The coefficients of |A|^2 A, Delta A and dA/dT: all terms of harmonic 1 at this order.

    Raises:
        ArithmeticError: if a term of harmonic 1 is none of these.
    """
    ring = modes.ring
    a, a_bar = ring["A"], ring["A" + BAR]
    monomials = (a**2 * a_bar, ring["Delta"] * a, ring["A_T"])
    parts = [tuple(modes.component(row, m) for row in rows) for m in monomials]
    for row in rows:
        rest = row - sum((m * modes.component(row, m) for m in monomials), ring.zero)
        for m in ring.parts(rest, modes.amplitudes):
            if modes.harmonic(m) == 1:
                raise ArithmeticError(f"unexpected resonant term {m}")
    return Resonant(*parts)


def at_tip_value(modes: Modes, p: PolyElement) -> PolyElement:
    """The constant p(1) for an expression in the values of Y and Theta, e.g. Theta -> Theta(1)."""
    ring = modes.ring
    images = {ring[s + b]: ring[s + b + TIP] for s in ("Y", "Theta") for b in ("", BAR)}
    return ring.apply(p, images)


def _drop_vanishing(jets: JetRing, modes: Modes, p: PolyElement) -> PolyElement:
    zero = {
        g: jets.zero
        for g in jets.generators_of(p)
        if any(str(g).split("_")[0] == f"{f}{n}" for (f, n), image in modes.fields.items() if not image)
    }
    return jets.apply(p, zero)


def _split_residue(jets: JetRing, residue: PolyElement) -> Pair:
    """residue = -nu * local + rest, with local free of derivatives."""
    nu = jets["nu"]
    local, rest = jets.zero, jets.zero
    for monomial, c in jets.parts(residue, [nu]).items():
        power = jets.degree(monomial, [nu])
        if power == 1 and not any("_" in str(g) for g in jets.generators_of(c)):
            local -= c
        else:
            rest += monomial * c
    return local, rest
