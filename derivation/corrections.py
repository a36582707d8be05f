r"""The order-2 problem: mean and second-harmonic longitudinal corrections X0, X2 and tensions P0, P2.

Quadratic products of the critical mode force x only. With

    x^(2) = A^2 X2 e^{2 i omega tau} + |A|^2 X0 - Delta u/(2 k1) + c.c.

the harmonics of  gamma1 d_tau x = (K1 x')' + f1^(2),  x(0) = 0,  x'(1) = b1^(2)  give a boundary-value
problem for each shape.
"""

from __future__ import annotations

from dataclasses import dataclass

from sympy.polys.rings import PolyElement

from derivation.errors import ModelError
from derivation.harmonics import Modes, split_real
from derivation.hierarchy import Hierarchy
from derivation.jets import JetRing, homomorphism
from derivation.symbols import BAR


@dataclass(frozen=True)
class Correction:
    """(K1 X')' = c X + forcing,  X(0) = 0,  X'(1) = tip_slope + tip_drag X(1);  P' = tension_slope.

    Attributes:
        harmonic: 0 or 2.
        shape: the symbol of X (``X0`` or ``X2``).
        drag: c, that is 0 or 2 i omega gamma1.
        forcing: in Theta, Y, H, their derivatives and conjugates (eq:longitudinalODE).
        tip_slope, tip_drag: in the tip values of the mode (eq:ODEBCs); tip_drag is 0 for a load without drag.
        tension: P in terms of X' (unnumbered display after eq:pdefinitions).
        tension_slope: P' in terms of X and the mode; together with P(1) it gives P without the
            cancellation that K1 (X' + ...) suffers for a stiff rod.
        tip_tension: P(1), 0 for the plain follower.
    """

    harmonic: int
    shape: PolyElement
    drag: PolyElement
    forcing: PolyElement
    tip_slope: PolyElement
    tip_drag: PolyElement
    tension: PolyElement
    tension_slope: PolyElement
    tip_tension: PolyElement


@dataclass(frozen=True)
class SecondOrder:
    """Everything of order 2.

    Attributes:
        modes: the ring of modes, now with x^(2), y^(2), theta^(2) known and X'' and X' reducible.
        forcing: f1^(2) with the ansatz substituted (eq:longitudinalforcing).
        tip_forcing: x^(2)' at the tip likewise, but for the drag of the load there (b1^(2),
            eq:longitudinalforcingBC).
        mean, harmonic: the two corrections.
        static: the part of x^(2) due to the detuning alone, -Delta u/k1 under a tip load; Delta x_F where K1
            varies along the rod.
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
    stiffness, inverse = (
        homomorphism(k[0], {}, ring) for k in (hierarchy.straight.stiffness, hierarchy.straight.inverse)
    )
    shear = {ring["Y_u"]: ring["H"] + ring["nu"] * ring["Theta"]}
    shear |= {ring.conjugate(g): ring.conjugate(v) for g, v in shear.items()}
    f1, f2, f3 = (ring.rewrite(modes.image(f), shear) for f in order.forcing)
    t1, t2, t3 = (modes.at_tip(modes.image(t)) for t in order.traction)
    if any((f2, f3, t2, t3)):
        # The first-order mode is odd under reflection, quadratic products are even: only x is forced.
        raise ModelError(
            f"{hierarchy.model.name}: not symmetric under reflection: y and theta are forced at order 2"
        )
    b1 = ring.reduce(inverse * t1)

    static = _static(ring, stiffness, inverse, f1, b1)
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

    law, tip_law = insert(order.linear[0]), insert(order.tip_linear[0])
    tension = insert(order.stresses[0])
    # balance = drag - F1' + Pi F2 vanishes identically, so F1' = balance + F1' in terms of drag and shear.
    tension_slope = insert(order.balance[0]) + ring.rewrite(ring.derive(tension, "u"), shear)
    tip_tension = modes.at_tip(insert(order.stresses[0] - order.tip[0]))
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
                # law = drag X - (K1 X')' equals f1, so (K1 X')' = drag X - f1; K1 X' likewise at the tip.
                drag=shape_of(law).diff(x),
                forcing=-shape_of(f1),
                tip_slope=shape_of(b1),
                tip_drag=ring.reduce(-inverse * shape_of(tip_law).diff(x)),
                tension=shape_of(tension),
                tension_slope=ring.reduce(shape_of(tension_slope)),
                tip_tension=shape_of(tip_tension),
            )
        )
    mean, second = corrections
    rules = {}
    for c in corrections:
        x_u, x_uu, p = (ring[f"X{c.harmonic}_u"], ring[f"X{c.harmonic}_uu"], ring[f"P{c.harmonic}"])
        rules[x_uu] = ring.reduce(
            inverse * (c.drag * c.shape + c.forcing - ring.derive(stiffness, "u") * x_u)
        )
        # The tension stands for the slope of X: P = K1 X' + rest.
        rules[x_u] = ring.reduce(inverse * (p - (c.tension - stiffness * x_u)))
    return SecondOrder(modes.with_rules(known, rules), f1, b1, mean, second, static)


def _static(
    ring: JetRing, stiffness: PolyElement, inverse: PolyElement, f1: PolyElement, b1: PolyElement
) -> PolyElement:
    """Detuning alone: 0 = (K1 x')' + f, x(0) = 0, x'(1) = b with f, b the parts proportional to Delta."""
    delta, u = ring["Delta"], ring["u"]
    f, b = f1.diff(delta), b1.diff(delta)
    if ring.derive(f, "u"):
        raise ModelError("the body load of a detuned rod varies along it")
    if not ring.derive(stiffness, "u"):
        return ring.reduce(delta * (b * u + inverse * f * (u - u**2 / 2)))
    if b or ring.reduce(stiffness * ring.derive(ring["x_F"], "u") - f * (1 - u)):
        raise ArithmeticError("the straight rod under another force is not the static response")
    return delta * ring["x_F"]
