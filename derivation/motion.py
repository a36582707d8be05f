"""The full nonlinear equations of motion as expressions, from the model and the exact kinematics."""

from __future__ import annotations

from dataclasses import dataclass

from sympy import Expr, factor_terms
from sympy import cos as cosine
from sympy import sin as sine
from sympy.polys.rings import PolyElement

from derivation.jets import from_expr
from derivation.kinematics import ExactKinematics
from derivation.model import RodModel
from derivation.symbols import symbol

Triple = tuple[Expr, Expr, Expr]
_STRAINS = ("h1", "h2", "Pi")
_VELOCITIES = ("v1", "v2", "Omega")


@dataclass(frozen=True)
class EquationsOfMotion:
    """Exact expressions in x_u, ..., theta_uu; ``stresses`` in h1, h2, Pi.

    ``rates`` are (x_t, y_t, theta_t), ``tip`` the stresses minus the load at u = 1.
    """

    strains: Triple
    velocities: Triple
    stresses: Triple
    rates: Triple
    tip: Triple


def equations_of_motion(model: RodModel, exact: ExactKinematics) -> EquationsOfMotion:
    """eq:dynamicsfull solved for the rates of x, y and theta.

    Raises:
        ArithmeticError: if the rates, put back into the exact velocities, do not balance the stresses.
    """
    ring = exact.ring
    law: Triple = tuple(factor_terms(model.energy.diff(symbol(q)).expand()) for q in _STRAINS)
    strains = {symbol(q): _expr(p) for q, p in zip(_STRAINS, exact.strains, strict=True)}
    slopes = [_expr(ring.derive(p, "u")) for p in exact.strains]
    f1, f2, m = (f.xreplace(strains) for f in law)
    # F_u = sum of dF/dq q_u over the strains q.
    f1_u, f2_u, m_u = (
        sum(f.diff(symbol(q)).xreplace(strains) * q_u for q, q_u in zip(_STRAINS, slopes, strict=True))
        for f in law
    )
    h1, h2, curvature = strains.values()
    elastic = (f1_u - curvature * f2, f2_u + curvature * f1, m_u + h1 * f2 - h2 * f1)
    # Drag acts along its own direction, so the velocity is elastic / (drag per unit velocity).
    coefficients = [d.diff(symbol(v)) for d, v in zip(model.drag, _VELOCITIES, strict=True)]
    v1, v2, spin = (e / c for e, c in zip(elastic, coefficients, strict=True))
    # r_t = v1 e1 + v2 e2, the frame being orthonormal.
    c, s = cosine(symbol("theta")), sine(symbol("theta"))
    rates = (v1 * c - v2 * s, v1 * s + v2 * c, spin)

    put_back = {symbol(f"{f}_t"): rate for f, rate in zip(("x", "y", "theta"), rates, strict=True)}
    for velocity, force, weight in zip(exact.velocities, elastic, coefficients, strict=True):
        residue = (weight * _expr(velocity).xreplace(put_back) - force).expand()
        if ring.reduce(from_expr(residue.xreplace({c: symbol("cos"), s: symbol("sin")}), ring)):
            raise ArithmeticError(f"{model.name}: the rates do not balance the stresses: {residue}")
    return EquationsOfMotion(
        tuple(strains.values()),
        tuple(map(_expr, exact.velocities)),
        law,
        rates,
        tuple(f - load for f, load in zip((f1, f2, m), model.tip_load, strict=True)),
    )


def _expr(p: PolyElement) -> Expr:
    theta = symbol("theta")
    return p.as_expr().xreplace({symbol("cos"): cosine(theta), symbol("sin"): sine(theta)})
