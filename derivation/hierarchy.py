"""The balance laws and tip conditions order by order: base state, linear operator, forcings.

At each order n the balance laws read  Gamma d_tau xi_n = M xi_n + f_n  with xi = (x, y, theta) and the tip
conditions  B xi_n = b_n  at u = 1 (eq:hierarchy), where M, Gamma and B are those of order 1 and f_n, b_n
hold lower orders only. The split is computed, and that f_n is free of order-n fields is checked.
"""

from __future__ import annotations

from dataclasses import dataclass

from sympy.polys.rings import PolyElement

from derivation.jets import JetRing, from_expr, jet_ring
from derivation.kinematics import ExpandedKinematics, Series, multiply, substitute
from derivation.model import RodModel
from derivation.symbols import FIELDS, jet_name, symbol

Vector = tuple[PolyElement, PolyElement, PolyElement]


@dataclass(frozen=True)
class BaseState:
    """The compressed straight rod x = nu u (eq:basestate).

    ``axial_balance`` is F1 at order 0 minus the imposed tip load, zero at the base state;
    ``force`` and ``mu`` are the force and the stiffness of the linear problem in the letters nu, k1, k2.
    """

    axial_balance: PolyElement
    nu: PolyElement
    mu: PolyElement


@dataclass(frozen=True)
class Order:
    """The problem at one order n of epsilon.

    Attributes:
        stresses: (F1, F2, M) at order n.
        balance: drag minus elastic terms, written in stresses expanded in the fields; zero on solutions.
        tip: stresses minus the imposed load at u = 1; zero on solutions.
        linear: the part of ``balance`` linear in the order-n fields, Gamma d_tau xi - M xi.
        forcing: f_n = linear - balance.
        tip_linear: the geometric left-hand sides x', y' - nu theta, theta' of order n.
        tip_forcing: b_n, so that tip_linear = b_n at u = 1, reduced by the conditions of lower orders.
    """

    n: int
    stresses: Vector
    balance: Vector
    tip: Vector
    linear: Vector
    forcing: Vector
    tip_linear: Vector
    tip_forcing: Vector


@dataclass(frozen=True)
class Hierarchy:
    """All orders 1 ... N over one ring of jets."""

    model: RodModel
    ring: JetRing
    base: BaseState
    orders: tuple[Order, ...]
    tip_rules: dict[PolyElement, PolyElement]

    def __getitem__(self, n: int) -> Order:
        """The problem at order ``n``, 1 <= n <= N."""
        if not 1 <= n <= len(self.orders):
            raise IndexError(f"order {n}: derived are orders 1 to {len(self.orders)}")
        return self.orders[n - 1]


def build_hierarchy(model: RodModel, kinematics: ExpandedKinematics) -> Hierarchy:
    """Substitute the expanded kinematics into the balance laws (eq:dynamicsfull) and the tip conditions."""
    ring, order = kinematics.ring, kinematics.order
    base = _base_state(model, ring)
    stresses = _stresses(model, kinematics, base)
    balance = _balance(model, kinematics, stresses, base)
    tip = _tip(model, stresses, ring)
    orders: list[Order] = []
    tip_rules: dict[PolyElement, PolyElement] = {}
    for n in range(1, order + 1):
        fields = _fields_of_order(ring, n)
        at_n: Vector = tuple(b[n] for b in balance)
        linear = tuple(_part_in(ring, p, fields, linear=True) for p in at_n)
        forcing = tuple(lin - p for lin, p in zip(linear, at_n, strict=True))
        for f in forcing:
            if _part_in(ring, f, fields, linear=False):
                raise ArithmeticError(f"order {n}: the forcing holds fields of its own order: {f}")
        tip_n: Vector = tuple(t[n] for t in tip)
        rules = _solve_tip(ring, tip_n, n, tip_rules)
        tip_rules.update(rules)
        tip_linear = _tip_linear(ring, n)
        tip_forcing = tuple(ring.rewrite(p, tip_rules) for p in tip_linear)
        orders.append(
            Order(n, tuple(s[n] for s in stresses), at_n, tip_n, linear, forcing, tip_linear, tip_forcing)
        )
    return Hierarchy(model, ring, base, tuple(orders), tip_rules)


def _base_state(model: RodModel, ring: JetRing) -> BaseState:
    """Order 0 of the axial tip condition, linear in nu: solve it."""
    axial = model.energy.diff(symbol("h1")).subs(
        {symbol("h1"): symbol("nu"), symbol("h2"): 0, symbol("Pi"): 0}
    )
    balance = from_expr(axial - model.tip_load[0], ring)
    slope = balance.diff(ring["nu"])
    if slope != ring["k1"]:
        raise NotImplementedError(
            f"{model.name}: the axial balance {balance} = 0 is not k1 nu + ...; no closed nu"
        )
    nu = ring.reduce((slope * ring["nu"] - balance) * ring["k1_inv"])
    return BaseState(balance, nu, ring["k2"] * ring["nu"] + ring["force"])


def _stresses(
    model: RodModel, kinematics: ExpandedKinematics, base: BaseState
) -> tuple[Series, Series, Series]:
    """(F1, F2, M) = grad W, expanded; F1 of the base state in terms of the force."""
    ring = kinematics.ring
    names = ("h1", "h2", "Pi")
    law = jet_ring([*names, "k1", "k2", "gamma1", "gamma3", "force"])
    images = {law[q]: s for q, s in zip(names, kinematics.strains, strict=True)}
    f1, f2, m = (
        substitute(from_expr(model.energy.diff(symbol(q)).expand(), law), images, ring, kinematics.order)
        for q in names
    )
    # Base state: F1 at order 0 equals the imposed load, whatever the constitutive law.
    return (f1[0] - base.axial_balance, *f1[1:]), f2, m


def _balance(
    model: RodModel, kinematics: ExpandedKinematics, stresses: tuple[Series, Series, Series], base: BaseState
) -> tuple[Series, Series, Series]:
    """eq:dynamicsfull, drag minus elastic: zero on solutions; force written as mu - k2 nu."""
    ring = kinematics.ring
    names = ("v1", "v2", "Omega")
    law = jet_ring([*names, "k1", "k2", "gamma1", "gamma3"])
    images = {law[q]: s for q, s in zip(names, kinematics.velocities, strict=True)}
    drag = [substitute(from_expr(d, law), images, ring, kinematics.order) for d in model.drag]
    (f1, f2, m), (h1, h2, curvature) = stresses, kinematics.strains

    def d_u(s: Series) -> Series:
        return tuple(ring.derive(c, "u") for c in s)

    elastic = (
        _combine((1, d_u(f1)), (-1, multiply(curvature, f2, ring))),
        _combine((1, d_u(f2)), (1, multiply(curvature, f1, ring))),
        _combine((1, d_u(m)), (1, multiply(h1, f2, ring)), (-1, multiply(h2, f1, ring))),
    )
    letters = {ring["force"]: ring["mu"] - ring["k2"] * ring["nu"]}

    def row(d: Series, e: Series) -> Series:
        return tuple(ring.apply(a - b, letters) for a, b in zip(d, e, strict=True))

    x, y, theta = map(row, drag, elastic)
    return x, y, theta


def _tip(
    model: RodModel, stresses: tuple[Series, Series, Series], ring: JetRing
) -> tuple[Series, Series, Series]:
    """Stresses minus load at u = 1, with force = critical force + epsilon^2 Delta."""
    law = jet_ring(["force"])
    order = len(stresses[0]) - 1
    force = [ring["force"], ring.zero, ring["Delta"], *[ring.zero] * order][: order + 1]
    loads = [
        substitute(from_expr(load, law), {law["force"]: tuple(force)}, ring, order) for load in model.tip_load
    ]
    axial, shear, moment = (_combine((1, s), (-1, load)) for s, load in zip(stresses, loads, strict=True))
    return axial, shear, moment


def _combine(*terms: tuple[int, Series]) -> Series:
    return tuple(sum(c * s[n] for c, s in terms) for n in range(len(terms[0][1])))


def _fields_of_order(ring: JetRing, n: int) -> list[PolyElement]:
    held = {f"{f}{n}" for f in FIELDS}
    return [g for g in ring.ring.gens if str(g).split("_")[0] in held]


def _part_in(ring: JetRing, p: PolyElement, fields: list[PolyElement], *, linear: bool) -> PolyElement:
    """The part of ``p`` of degree 1 in ``fields`` with no other field (linear), or of any positive degree."""
    total = ring.zero
    others = [g for g in ring.ring.gens if _is_jet(str(g)) and g not in fields]
    for monomial, rest in ring.parts(p, fields).items():
        degree = ring.degree(monomial, fields)
        if linear and degree == 1:
            for m2, rest2 in ring.parts(rest, others).items():
                if not ring.degree(m2, others):
                    total += monomial * m2 * rest2
        elif not linear and degree:
            total += monomial * rest
    return total


def _is_jet(name: str) -> bool:
    head = name.split("_")[0]
    return head.rstrip("0123456789") in FIELDS and head[-1:].isdigit()


def _tip_linear(ring: JetRing, n: int) -> Vector:
    """eq:linearization's free-end conditions: x', y' - nu theta, theta'."""
    x_u, y_u, theta_u = (ring[jet_name(f, n, 1)] for f in FIELDS)
    return x_u, y_u - ring["nu"] * ring[jet_name("theta", n, 0)], theta_u


def _solve_tip(
    ring: JetRing, tip: Vector, n: int, lower: dict[PolyElement, PolyElement]
) -> dict[PolyElement, PolyElement]:
    """Solve the tip conditions of order n for x', y', theta' there; each enters linearly."""
    rules = dict(lower)
    slopes = [ring[jet_name(f, n, 1)] for f in FIELDS]
    inverse = {"x": ring["k1_inv"], "y": ring["k2_inv"], "theta": ring.one}
    for f, condition in zip(("theta", "x", "y"), (tip[2], tip[0], tip[1]), strict=True):
        unknown = ring[jet_name(f, n, 1)]
        scaled = ring.reduce(inverse[f] * condition)
        coupled = [g for g in ring.generators_of(scaled - unknown) if g in slopes and g not in rules]
        if scaled.diff(unknown) != ring.one or coupled:
            raise ArithmeticError(
                f"order {n}: the tip condition {condition} = 0 does not give {unknown} alone"
            )
        rules[unknown] = ring.rewrite(unknown - scaled, rules)
    return rules
