"""The balance laws and tip conditions order by order: straight rod, linear operator, forcings.

At each order n the balance laws read  Gamma d_tau xi_n = M xi_n + f_n  with xi = (x, y, theta), and the tip
conditions  S xi_n = t_n  at u = 1 (eq:hierarchy), where M, Gamma and S are those of order 1 and f_n, t_n
hold lower orders only. The split is computed, and that f_n and t_n are free of order-n fields is checked.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

from sympy import Expr, Integer
from sympy.polys.rings import PolyElement

from derivation.constitutive import SHIFTED, VELOCITIES, Constitution
from derivation.errors import ModelError
from derivation.jets import JetRing, from_expr, jet_ring
from derivation.kinematics import ExpandedKinematics, Series, multiply, substitute
from derivation.model import RodModel
from derivation.symbols import FIELDS, jet_name, symbol

Vector = tuple[PolyElement, PolyElement, PolyElement]
SeriesVector = tuple[Series, Series, Series]


@dataclass(frozen=True)
class StraightRod:
    """The compressed straight rod x' = nu (eq:basestate), y = theta = 0.

    Attributes:
        nu: where the axial balance can be solved for it (a quadratic energy), else None.
        balance: F1 + load, zero at the straight rod.
        mu: k2 nu + load, the stiffness of the linear problem.
        load: the compression it carries, ``force`` under a tip load alone.
        stiffness, inverse: K1, K2, K3 and their inverses.
        weights: the drag per unit velocity (the diagonal of Gamma).
    """

    nu: PolyElement | None
    balance: PolyElement
    mu: PolyElement
    load: PolyElement
    stiffness: Vector
    inverse: Vector
    weights: Vector


@dataclass(frozen=True)
class Order:
    """The problem at one order n of epsilon.

    Attributes:
        stresses: (F1, F2, M) at order n.
        balance: drag minus elastic terms, written in stresses expanded in the fields; zero on solutions.
        tip: stresses minus the imposed load at u = 1; zero on solutions.
        linear: the part of ``balance`` linear in the order-n fields, Gamma d_tau xi - M xi.
        forcing: f_n = linear - balance.
        tip_linear: the part of ``tip`` linear in the order-n fields.
        traction: t_n = tip_linear - tip, so that tip_linear = t_n at u = 1, reduced by the conditions of
            lower orders: what loads the tip at this order.
        slopes: the same conditions solved for x', y', theta'.
    """

    n: int
    stresses: Vector
    balance: Vector
    tip: Vector
    linear: Vector
    forcing: Vector
    tip_linear: Vector
    traction: Vector
    slopes: Vector


@dataclass(frozen=True)
class Hierarchy:
    """All orders 1 ... N over one ring of jets."""

    model: RodModel
    law: Constitution
    ring: JetRing
    straight: StraightRod
    orders: tuple[Order, ...]
    tip_rules: dict[PolyElement, PolyElement]

    def __getitem__(self, n: int) -> Order:
        """The problem at order ``n``, 1 <= n <= N."""
        if not 1 <= n <= len(self.orders):
            raise IndexError(f"order {n}: derived are orders 1 to {len(self.orders)}")
        return self.orders[n - 1]


def build_hierarchy(model: RodModel, law: Constitution, kinematics: ExpandedKinematics) -> Hierarchy:
    """Substitute the expanded kinematics into the balance laws (eq:dynamicsfull) and the tip conditions."""
    ring, order = kinematics.ring, kinematics.order
    straight, stresses, balance, tip = balance_laws(law, kinematics)
    orders: list[Order] = []
    tip_rules: dict[PolyElement, PolyElement] = {}
    for n in range(1, order + 1):
        fields = _fields_of_order(ring, n)
        at_n, tip_n = (_vector(row[n] for row in rows) for rows in (balance, tip))
        linear, tip_linear = (_vector(_linear_in(ring, p, fields) for p in rows) for rows in (at_n, tip_n))
        forcing = _vector(a - p for a, p in zip(linear, at_n, strict=True))
        residue = _vector(a - p for a, p in zip(tip_linear, tip_n, strict=True))
        for f in (*forcing, *residue):
            if any(g in fields for g in ring.generators_of(f)):
                raise ArithmeticError(f"order {n}: the forcing holds fields of its own order: {f}")
        traction = _vector(ring.rewrite(p, tip_rules) for p in residue)
        solved = _solve_tip(ring, straight, tip_linear, traction, n)
        tip_rules.update(solved)
        slopes = _vector(solved[ring[jet_name(f, n, 1)]] for f in FIELDS)
        at_n_stresses = _vector(s[n] for s in stresses)
        orders.append(Order(n, at_n_stresses, at_n, tip_n, linear, forcing, tip_linear, traction, slopes))
    return Hierarchy(model, law, ring, straight, tuple(orders), tip_rules)


def balance_laws(
    law: Constitution, kinematics: ExpandedKinematics
) -> tuple[StraightRod, SeriesVector, SeriesVector, SeriesVector]:
    """The straight rod; then, as series in epsilon, stresses, balance laws and tip conditions.

    Balance laws are drag minus elastic terms, tip conditions stresses minus load: zero on solutions.
    """
    straight = _straight_rod(law, kinematics.ring)
    stresses = _stresses(law, kinematics, straight)
    balance = _balance(law, kinematics, stresses, straight)
    return straight, stresses, balance, _tip(law, kinematics, stresses)


def _vector(rows: Iterable[PolyElement]) -> Vector:
    x, y, theta = rows
    return x, y, theta


def _straight_rod(law: Constitution, ring: JetRing) -> StraightRod:
    """Order 0: F1(nu) balances the compression; for F1 = k1 (nu - 1) it is solved for nu."""
    load = ring["force"] if law.uniform else ring["load"]
    k1, k2, k3 = (from_expr(k, ring) for k in law.stiffness)
    balance = from_expr(law.axial, ring) + load
    inverse = _vector(from_expr(k, ring) for k in law.compliance)
    nu = None
    if balance.diff(ring["nu"]) == k1:
        nu = ring.reduce((k1 * ring["nu"] - balance) * inverse[0])
    weights = []
    for drag, v in zip(law.drag, VELOCITIES, strict=True):
        constant = drag.xreplace({symbol(q): Integer(0) for q in SHIFTED}).coeff(symbol(v))
        weights.append(from_expr(constant, ring))
    return StraightRod(nu, balance, k2 * ring["nu"] + load, load, (k1, k2, k3), inverse, _vector(weights))


def _stresses(law: Constitution, kinematics: ExpandedKinematics, straight: StraightRod) -> SeriesVector:
    """(F1, F2, M) = grad W, expanded; F1 of the straight rod is minus the compression it carries."""
    ring = kinematics.ring
    h1, h2, curvature = kinematics.strains
    small = {"stretch": (ring.zero, *h1[1:]), "h2": h2, "Pi": curvature}
    f1, f2, m = (_insert(e, small, ring, kinematics.order) for e in law.stresses)
    return (-straight.load, *f1[1:]), f2, m


def _insert(e: Expr, images: dict[str, Series], ring: JetRing, order: int) -> Series:
    """A polynomial of the constitution at series; its parameters are generators of ``ring``."""
    names = sorted({s.name for s in e.free_symbols} | set(images))
    law = jet_ring(names)
    return substitute(from_expr(e, law), {law[q]: s for q, s in images.items()}, ring, order)


def _balance(
    law: Constitution,
    kinematics: ExpandedKinematics,
    stresses: SeriesVector,
    straight: StraightRod,
) -> SeriesVector:
    """eq:dynamicsfull, drag minus elastic: zero on solutions; the compression written as mu - k2 nu."""
    ring, order = kinematics.ring, kinematics.order
    (f1, f2, m), (h1, h2, curvature) = stresses, kinematics.strains
    small = {"stretch": (ring.zero, *h1[1:]), "h2": h2, "Pi": curvature}
    small |= dict(zip(VELOCITIES, kinematics.velocities, strict=True))
    drag = [_insert(d, small, ring, order) for d in law.drag]
    body = [_insert(b, {"force": _detuned_force(ring, order)}, ring, order) for b in law.body_load]

    def d_u(s: Series) -> Series:
        return tuple(ring.derive(c, "u") for c in s)

    elastic = (
        _combine((1, d_u(f1)), (-1, multiply(curvature, f2, ring)), (1, body[0])),
        _combine((1, d_u(f2)), (1, multiply(curvature, f1, ring)), (1, body[1])),
        _combine((1, d_u(m)), (1, multiply(h1, f2, ring)), (-1, multiply(h2, f1, ring)), (1, body[2])),
    )
    letters = {straight.load: ring["mu"] - straight.stiffness[1] * ring["nu"]}

    def row(d: Series, e: Series) -> Series:
        # At order 0 the straight rod balances; beyond it the compression appears through mu.
        return (
            ring.zero,
            *(ring.reduce(ring.apply(a - b, letters)) for a, b in zip(d[1:], e[1:], strict=True)),
        )

    for name, rest in zip(("F1", "F2", "M"), (elastic[0][0], elastic[1][0], elastic[2][0]), strict=True):
        if ring.reduce(rest):
            raise ArithmeticError(f"the straight rod is not in balance: {name} leaves {rest}")
    x, y, theta = map(row, drag, elastic)
    return x, y, theta


def _detuned_force(ring: JetRing, order: int) -> Series:
    """force = critical force + epsilon^2 Delta."""
    return (ring["force"], ring.zero, ring["Delta"], *[ring.zero] * order)[: order + 1]


def _tip(
    law: Constitution,
    kinematics: ExpandedKinematics,
    stresses: SeriesVector,
) -> SeriesVector:
    """Stresses minus load at u = 1."""
    ring, order = kinematics.ring, kinematics.order
    images = {"theta": kinematics.theta, "force": _detuned_force(ring, order)}
    images |= dict(zip(VELOCITIES, kinematics.velocities, strict=True))
    # What the straight rod carries at its tip: all of it under a tip load, nothing under a distributed one.
    carried = ((-ring["force"] if law.uniform else ring.zero), *stresses[0][1:])
    loads = [_insert(load, images, ring, order) for load in law.tip_load]
    axial, shear, moment = (
        _combine((1, s), (-1, load)) for s, load in zip((carried, *stresses[1:]), loads, strict=True)
    )
    if ring.reduce(axial[0]) or shear[0] or moment[0]:
        raise ModelError(
            "the tip load of a straight rod is not the axial force -force: "
            f"it leaves {axial[0]}, {shear[0]}, {moment[0]}"
        )
    return axial, shear, moment


def _combine(*terms: tuple[int, Series]) -> Series:
    return tuple(sum(c * s[n] for c, s in terms) for n in range(len(terms[0][1])))


def _fields_of_order(ring: JetRing, n: int) -> list[PolyElement]:
    held = {f"{f}{n}" for f in FIELDS}
    return [g for name, g in zip(ring.names, ring.ring.gens, strict=True) if name.split("_")[0] in held]


def _linear_in(ring: JetRing, p: PolyElement, fields: list[PolyElement]) -> PolyElement:
    """The part of ``p`` of degree 1 in ``fields`` and without any other field."""
    others = [ring[name] for name in ring.names_of(p) if _is_jet(name) and ring[name] not in fields]
    alone = ring.coefficient(p, ring.one, others)
    return sum(
        (m * c for m, c in ring.parts(alone, fields).items() if ring.degree(m, fields) == 1), ring.zero
    )


def _is_jet(name: str) -> bool:
    head = name.split("_")[0]
    return head.rstrip("0123456789") in FIELDS and head[-1:].isdigit()


def _solve_tip(
    ring: JetRing, straight: StraightRod, linear: Vector, traction: Vector, n: int
) -> dict[PolyElement, PolyElement]:
    """Solve the tip conditions of order n for x', y', theta' there; each enters its own row with its K."""
    solved = {}
    slopes = [ring[jet_name(f, n, 1)] for f in FIELDS]
    for unknown, row, t, k, inverse in zip(
        slopes, linear, traction, straight.stiffness, straight.inverse, strict=True
    ):
        rest = row - k * unknown
        if any(g in slopes for g in ring.generators_of(rest)):
            raise ArithmeticError(f"order {n}: the tip condition {row} = {t} does not give {unknown} alone")
        solved[unknown] = ring.reduce(inverse * (t - rest))
    return solved
