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
from derivation.harmonics import Modes, parse_jet
from derivation.hierarchy import Hierarchy
from derivation.jets import JetRing
from derivation.symbols import BAR, FIELDS, TIP, jet_name

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
class Transformation:
    """Variables whose tip conditions of order 3 are homogeneous.

    Attributes:
        tip_residue: (b2, b3): y' - nu theta = b2, theta' = b3 at the tip, in jets (eq:followercubic_geom).
        local: what is subtracted from theta, in jets: (theta^(1))^3/6.
        rest: what remains of b2 after that, in jets; y is shifted by -rest(1) u (eq:cubic_transform).
        shift: (s_y, s_theta) = (y, theta) - (transformed y, theta), in modes.
        tip: tip residue of the transformed variables, zero.
        forcing: (f2, f3) of the transformed system (eq:cubic_forced_system), all harmonics, in modes.
        resonant: its resonant part (eq:cubicforcing): cubic = (g1, g3), detuning = (g2, g4).
    """

    tip_residue: Pair
    local: PolyElement
    rest: PolyElement
    shift: Pair
    tip: Pair
    forcing: Pair
    resonant: Resonant

    @property
    def g(self) -> tuple[PolyElement, PolyElement, PolyElement, PolyElement]:
        """(g1, g2, g3, g4) of eq:cubicforcing."""
        (g1, g3), (g2, g4) = self.resonant.cubic, self.resonant.detuning
        return g1, g2, g3, g4


@dataclass(frozen=True)
class ThirdOrder:
    """Everything of order 3.

    Attributes:
        forcing: (f2, f3) of the variables as they are, all harmonics, in modes.
        bulk: its resonant part.
        traction: the resonant part of (t2, t3), what loads the tip at this order.
        transformed: the variables that have no such load, where the load's structure allows them.
    """

    forcing: Pair
    bulk: Resonant
    traction: Resonant
    transformed: Transformation | None


def linear_profile(u: PolyElement) -> PolyElement:
    """The profile of the subtraction from y: 0 at the clamp, slope 1 at the tip."""
    return u


def third_order(
    hierarchy: Hierarchy, second: SecondOrder, profile: Callable[[PolyElement], PolyElement] = linear_profile
) -> ThirdOrder:
    """Derive the forcing of order 3, its resonant part, and the transformed system.

    Raises:
        ArithmeticError: if the transformed tip conditions are not homogeneous, for instance because
            ``profile`` is not 0 at u = 0 with slope 1 at u = 1.
    """
    modes, order = second.modes, hierarchy[3]
    f2, f3 = (modes.reduce(modes.image(f)) for f in order.forcing[1:])
    t2, t3 = (modes.at_tip(modes.image(t)) for t in order.traction[1:])
    return ThirdOrder(
        (f2, f3),
        resonant_part(modes, (f2, f3)),
        resonant_part(modes, (t2, t3)),
        _transform(hierarchy, modes, (f2, f3), profile),
    )


def _transform(
    hierarchy: Hierarchy, modes: Modes, forcing: Pair, profile: Callable[[PolyElement], PolyElement]
) -> Transformation | None:
    """Find what has to be subtracted.

    None where the load puts a moment, order-3 fields or rates into the conditions y' - nu theta and theta'.
    """
    jets, order = hierarchy.ring, hierarchy[3]
    theta3 = jets[jet_name("theta", 3, 0)]
    # The fields that vanish at the lower orders (x1, y2, theta2) are dropped from what is shown.
    b2 = _drop_vanishing(jets, modes, order.slopes[1] - jets["nu"] * theta3)
    b3 = _drop_vanishing(jets, modes, order.slopes[2])
    if b3 or any(_is_unknown_or_rate(str(g)) for g in jets.generators_of(b2)):
        return None
    local, rest = _split_residue(jets, b2)
    ring, u = modes.ring, modes.ring["u"]
    s_theta = modes.image(local)
    s_y = profile(u) * at_tip_value(modes, modes.image(rest))
    # linear(xi) = f with xi = transformed + shift, so linear(transformed) = f - linear(shift).
    operator = linear_rows(hierarchy, modes, (s_y, s_theta))
    f2, f3 = (modes.reduce(f - s) for f, s in zip(forcing, operator, strict=True))
    d = ring.derive
    tip = (
        modes.at_tip(modes.image(b2)) - modes.at_tip(d(s_y, "u") - ring["nu"] * s_theta),
        -modes.at_tip(d(s_theta, "u")),
    )
    if any(tip) or any(modes.at_clamp(s) for s in (s_y, s_theta)):
        raise ArithmeticError(f"the transformed conditions are not homogeneous: {tip}")
    return Transformation(
        (b2, b3), local, rest, (s_y, s_theta), tip, (f2, f3), resonant_part(modes, (f2, f3))
    )


def linear_rows(hierarchy: Hierarchy, modes: Modes, shift: Pair) -> Pair:
    """Gamma d_tau s - M s for (y, theta) = s: the order-3 rows without forcing."""
    with_shift = modes.with_rules({("y", 3): shift[0], ("theta", 3): shift[1]}, {})
    y, theta = (with_shift.image(row) for row in hierarchy[3].linear[1:])
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
    """The constant p(1) for an expression in the values of shapes, e.g. Theta -> Theta(1)."""
    ring = modes.ring
    shapes = ("Y", "Theta", "Psi_Y", "Psi_Theta")
    images = {ring[s + b]: ring[s + b + TIP] for s in shapes for b in ("", BAR)}
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
        if power == 1 and not any(_is_derivative(str(g)) for g in jets.generators_of(c)):
            local -= c
        else:
            rest += monomial * c
    return local, rest


def _is_unknown_or_rate(name: str) -> bool:
    """Whether this is a jet of order 3, or one with a derivative in time."""
    jet = parse_jet(name)
    return jet is not None and (jet[1] == 3 or bool(jet[2].strip("u")))


def _is_derivative(name: str) -> bool:
    head, _, derivatives = name.partition("_")
    return bool(derivatives) and head[-1:].isdigit() and head.rstrip("0123456789") in FIELDS
