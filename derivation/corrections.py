r"""The order-2 problem: mean and second-harmonic longitudinal corrections X0, X2 and tensions P0, P2.

Quadratic products of the critical mode force x only. With

    x^(2) = A^2 X2 e^{2 i omega tau} + |A|^2 X0 - Delta u/(2 k1) + c.c.

the harmonics of  gamma1 d_tau x = k1 x'' + f1^(2),  x(0) = 0,  x'(1) = b1^(2)  give a boundary-value problem
for each shape.
"""

from __future__ import annotations

from dataclasses import dataclass

from sympy.polys.rings import PolyElement

from derivation.harmonics import Modes, split_real
from derivation.hierarchy import Hierarchy
from derivation.symbols import BAR


@dataclass(frozen=True)
class Correction:
    """k1 X'' = c X + forcing,  X(0) = 0,  X'(1) = tip_slope;  tension P = k1 (X' + ...), P' by force balance.

    Attributes:
        harmonic: 0 or 2.
        shape: the symbol of X (``X0`` or ``X2``).
        drag: c, that is 0 or 2 i omega gamma1.
        forcing: in Theta, Y, H, their derivatives and conjugates (eq:longitudinalODE).
        tip_slope: in the tip value of Theta (eq:ODEBCs).
        tension: P in terms of X' (unnumbered display after eq:pdefinitions).
        tension_slope: P' in terms of X and the mode; together with P(1) = 0 it gives P without the
            cancellation that k1 (X' + ...) suffers for a stiff rod.
    """

    harmonic: int
    shape: PolyElement
    drag: PolyElement
    forcing: PolyElement
    tip_slope: PolyElement
    tension: PolyElement
    tension_slope: PolyElement


@dataclass(frozen=True)
class SecondOrder:
    """Everything of order 2.

    Attributes:
        modes: the ring of modes, now with x^(2), y^(2), theta^(2) known and X'' and X' reducible.
        forcing: f1^(2) with the ansatz substituted (eq:longitudinalforcing).
        tip_forcing: b1^(2) likewise (eq:longitudinalforcingBC), Theta at the tip.
        mean, harmonic: the two corrections.
        static: the part of x^(2) due to the detuning alone, -Delta u/k1.
    """

    modes: Modes
    forcing: PolyElement
    tip_forcing: PolyElement
    mean: Correction
    harmonic: Correction
    static: PolyElement


def second_order(hierarchy: Hierarchy, modes: Modes) -> SecondOrder:
    """Solve the structure of order 2: which fields are forced, at which harmonics, by what."""
    ring, order = modes.ring, hierarchy[2]
    shear = {ring["Y_u"]: ring["H"] + ring["nu"] * ring["Theta"]}
    shear |= {ring.conjugate(g): ring.conjugate(v) for g, v in shear.items()}
    f1, f2, f3 = (ring.rewrite(modes.image(f), shear) for f in order.forcing)
    b1, b2, b3 = (modes.at_tip(modes.image(b)) for b in order.tip_forcing)
    if any((f2, f3, b2, b3)):
        # The first-order mode is odd under reflection, quadratic products are even: only x is forced.
        raise ArithmeticError(f"{hierarchy.model.name}: y and theta are forced at order 2")

    # Detuning alone: k1 x'' = 0, x(0) = 0, x'(1) = its part of b1.
    static = ring["u"] * ring["Delta"] * b1.diff(ring["Delta"])
    a, a_bar = ring["A"], ring["A" + BAR]
    known = {
        ("x", 2): a**2 * ring["X2"] + a_bar**2 * ring["X2" + BAR]
        + a * a_bar * (ring["X0"] + ring["X0" + BAR]) + static,
        ("y", 2): ring.zero,
        ("theta", 2): ring.zero,
    }  # fmt: skip
    with_x = modes.with_rules(known, {})

    def insert(p: PolyElement) -> PolyElement:
        return ring.rewrite(with_x.image(p), shear)

    law = insert(order.linear[0])
    tension = insert(order.stresses[0])
    # balance = drag - F1' + Pi F2 vanishes identically, so F1' = balance + F1' in terms of drag and shear.
    tension_slope = insert(order.balance[0]) + ring.rewrite(ring.derive(tension, "u"), shear)
    corrections = []
    for harmonic, monomial in ((0, a * a_bar), (2, a**2)):
        x = ring[f"X{harmonic}"]

        def shape_of(
            p: PolyElement, harmonic: int = harmonic, monomial: PolyElement = monomial
        ) -> PolyElement:
            """What multiplies the harmonic; of the real mean, the half that is written before "+ c.c."."""
            part = modes.component(p, monomial)
            return part if harmonic else split_real(ring, part)

        corrections.append(
            Correction(
                harmonic,
                x,
                # law = drag X - k1 X'' equals f1, so k1 X'' = drag X - f1.
                drag=shape_of(law).diff(x),
                forcing=-shape_of(f1),
                tip_slope=shape_of(b1),
                tension=shape_of(tension),
                tension_slope=shape_of(tension_slope),
            )
        )
    mean, second = corrections
    rules = {}
    for c in corrections:
        x_u, x_uu, p = (ring[f"X{c.harmonic}_u"], ring[f"X{c.harmonic}_uu"], ring[f"P{c.harmonic}"])
        rules[x_uu] = ring.reduce(ring["k1_inv"] * (c.drag * c.shape + c.forcing))
        # The tension stands for the slope of X: P = k1 X' + rest.
        rules[x_u] = ring.reduce(ring["k1_inv"] * (p - (c.tension - ring["k1"] * x_u)))
    return SecondOrder(modes.with_rules(known, rules), f1, b1, mean, second, static)
