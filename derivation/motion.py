"""The full nonlinear equations of motion as expressions, from the model and the exact kinematics."""

from __future__ import annotations

from dataclasses import dataclass

from sympy import Expr, factor_terms
from sympy import cos as cosine
from sympy import sin as sine
from sympy.polys.rings import PolyElement

from derivation.constitutive import multiplied_out
from derivation.jets import JetRing, from_expr, jet_ring
from derivation.kinematics import ExactKinematics
from derivation.model import RodModel
from derivation.symbols import symbol

Triple = tuple[Expr, Expr, Expr]
_STRAINS = ("h1", "h2", "Pi")
_VELOCITIES = ("v1", "v2", "Omega")


@dataclass(frozen=True)
class EquationsOfMotion:
    """Exact expressions in x_u, ..., theta_uu; ``stresses`` and ``drag`` per unit velocity in h1, h2, Pi.

    ``load`` are the stresses imposed at u = 1, in theta and the velocities; ``rates`` (x_t, y_t, theta_t);
    ``tip`` the stresses minus the load at u = 1; ``tip_holds_rates`` whether the load has drag.
    """

    strains: Triple
    velocities: Triple
    stresses: Triple
    drag: Triple
    load: Triple
    rates: Triple
    tip: Triple
    tip_holds_rates: bool


def equations_of_motion(model: RodModel, exact: ExactKinematics) -> EquationsOfMotion:
    """eq:dynamicsfull solved for the rates of x, y and theta.

    Raises:
        ArithmeticError: if the rates, put back into the exact velocities, do not balance the stresses.
    """
    ring = exact.ring
    law: Triple = tuple(factor_terms(multiplied_out(model.energy.diff(symbol(q)))) for q in _STRAINS)
    strains = {symbol(q): _expr(p) for q, p in zip(_STRAINS, exact.strains, strict=True)}
    slopes = [_expr(ring.derive(p, "u")) for p in exact.strains]
    f1, f2, m = (f.xreplace(strains) for f in law)
    # F_u = sum of dF/dq q_u over the strains q.
    f1_u, f2_u, m_u = (
        sum(f.diff(symbol(q)).xreplace(strains) * q_u for q, q_u in zip(_STRAINS, slopes, strict=True))
        for f in law
    )
    h1, h2, curvature = strains.values()
    b1, b2, b3 = model.body_load
    elastic = (f1_u - curvature * f2 + b1, f2_u + curvature * f1 + b2, m_u + h1 * f2 - h2 * f1 + b3)
    # Drag acts along its own direction, so the velocity is elastic / (drag per unit velocity).
    coefficients = [d.diff(symbol(v)).xreplace(strains) for d, v in zip(model.drag, _VELOCITIES, strict=True)]
    balanced = {symbol(v): e / c for v, e, c in zip(_VELOCITIES, elastic, coefficients, strict=True)}
    x_t, y_t, theta_t = (rate.xreplace(balanced) for rate in _rates_of_velocities(exact))
    c, s = cosine(symbol("theta")), sine(symbol("theta"))
    velocities = {symbol(v): _expr(p) for v, p in zip(_VELOCITIES, exact.velocities, strict=True)}
    letters = {**velocities, symbol("cos"): c, symbol("sin"): s}
    loads = [load.xreplace(letters) for load in model.tip_load]
    held = set().union(*(load.free_symbols for load in model.tip_load))
    return EquationsOfMotion(
        tuple(strains.values()),
        tuple(velocities.values()),
        law,
        tuple(d.diff(symbol(v)) for d, v in zip(model.drag, _VELOCITIES, strict=True)),
        tuple(load.xreplace({symbol("cos"): c, symbol("sin"): s}) for load in model.tip_load),
        (x_t, y_t, theta_t),
        tuple(f - load for f, load in zip((f1, f2, m), loads, strict=True)),
        bool(held & set(map(symbol, _VELOCITIES))),
    )


def _rates_of_velocities(exact: ExactKinematics) -> Triple:
    """(x_t, y_t, theta_t) in (v1, v2, Omega): r_t = v1 e1 + v2 e2, the frame being orthonormal."""
    ring, c, s = exact.ring, cosine(symbol("theta")), sine(symbol("theta"))
    v1, v2, spin = map(symbol, _VELOCITIES)
    rates = (v1 * c - v2 * s, v1 * s + v2 * c, spin)
    put_back = {symbol(f"{f}_t"): rate for f, rate in zip(("x", "y", "theta"), rates, strict=True)}
    wide = jet_ring([*map(str, ring.ring.symbols), *_VELOCITIES])
    known = JetRing(wide.ring, products=((wide["sin"] ** 2, 1 - wide["cos"] ** 2),))
    for velocity, name in zip(exact.velocities, (v1, v2, spin), strict=True):
        residue = (_expr(velocity).xreplace(put_back) - name).expand()
        if known.reduce(from_expr(residue.xreplace({c: symbol("cos"), s: symbol("sin")}), known)):
            raise ArithmeticError(f"the rates do not reproduce {name}: {residue}")
    return rates


def _expr(p: PolyElement) -> Expr:
    theta = symbol("theta")
    return p.as_expr().xreplace({symbol("cos"): cosine(theta), symbol("sin"): sine(theta)})
