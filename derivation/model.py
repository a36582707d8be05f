"""A rod as data: stored energy, drag law, loads. Everything downstream is computed from this record."""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

from sympy import Expr, Integer, Rational, sqrt

from derivation.symbols import parameter, symbol

Triple = tuple[Expr, Expr, Expr]
_NONE: Triple = (Integer(0), Integer(0), Integer(0))


class Parameter(NamedTuple):
    """A parameter of a rod beyond k1, k2, gamma1 and gamma3; ``default`` is the text of a number."""

    name: str
    meaning: str
    default: str


@dataclass(frozen=True)
class RodModel:
    """A planar Cosserat rod, clamped at u = 0 and loaded at u = 1.

    Attributes:
        name: the package name of what is emitted for it (a Python identifier).
        title: one line for headers and help.
        energy: stored energy per unit reference length, W(h1, h2, Pi); stresses are its gradient.
        drag: what balances the gradient of the stresses, per unit reference length: linear in
            (v1, v2, Omega), each along its own direction, with coefficients that may depend on the strains.
        tip_load: the stresses (F1, F2, M) imposed at u = 1, in the moving frame, as functions of cos(theta),
            sin(theta), theta and (v1, v2, Omega) there, eq:follower.
        body_load: the force and moment per unit reference length beside drag, in the moving frame; may hold
            ``force`` only.
        parameters: those beyond k1, k2, gamma1, gamma3, force.

    ``force`` is the control parameter. Expressions are in the symbols of :mod:`derivation.symbols`, scaled so
    that gamma2 = k3 = 1 (eq:dimensionlessconstitutive).
    """

    name: str
    title: str
    energy: Expr
    drag: Triple
    tip_load: Triple
    body_load: Triple = _NONE
    parameters: tuple[Parameter, ...] = ()


_H1, _H2, _CURVATURE = symbol("h1"), symbol("h2"), symbol("Pi")
_COS, _SIN = symbol("cos"), symbol("sin")
_FORCE = symbol("force")
# eq:constitutive: F1 = k1 (h1 - 1), F2 = k2 h2, M = Pi.
_QUADRATIC = Rational(1, 2) * (symbol("k1") * (_H1 - 1) ** 2 + symbol("k2") * _H2**2 + _CURVATURE**2)
# eq:drag.
_DRAG: Triple = (symbol("gamma1") * symbol("v1"), symbol("v2"), symbol("gamma3") * symbol("Omega"))
# eq:follower: the load turns with the tip, so it is constant in the moving frame.
_FOLLOWS: Triple = (-_FORCE, Integer(0), Integer(0))


def _metric_drag() -> Triple:
    """Drag per unit current length: the reference length stretches by the metric factor."""
    metric = sqrt(_H1**2 + _H2**2)
    return _DRAG[0] * metric, _DRAG[1] * metric, _DRAG[2] * metric


def _quartic() -> Expr:
    s, b = parameter("stretch4", "k_{1}''"), parameter("bend4", "k_{3}''")
    return _QUADRATIC + s * (_H1 - 1) ** 4 / 4 + b * _CURVATURE**4 / 4


def _partial_follower() -> Triple:
    """A fraction chi of the load follows the tip, the rest keeps its direction along -x."""
    chi = parameter("chi", r"\chi")
    return -_FORCE * (chi + (1 - chi) * _COS), _FORCE * (1 - chi) * _SIN, Integer(0)


#: The paper's rod.
FOLLOWER = RodModel("follower", "planar Cosserat rod under a tip follower force", _QUADRATIC, _DRAG, _FOLLOWS)

#: The rods that are shipped, by name.
MODELS: dict[str, RodModel] = {
    m.name: m
    for m in (
        FOLLOWER,
        RodModel(
            "metric_drag",
            "planar Cosserat rod under a tip follower force, drag per unit current length",
            _QUADRATIC,
            _metric_drag(),
            _FOLLOWS,
        ),
        RodModel(
            "quartic",
            "planar Cosserat rod under a tip follower force, stiffening in stretch and bending",
            _quartic(),
            _DRAG,
            _FOLLOWS,
            parameters=(
                Parameter("stretch4", "quartic stretch stiffness", "100"),
                Parameter("bend4", "quartic bending stiffness", "1/10"),
            ),
        ),
        RodModel(
            "partial_follower",
            "planar Cosserat rod under a tip load of which a fraction follows",
            _QUADRATIC,
            _DRAG,
            _partial_follower(),
            parameters=(Parameter("chi", "fraction of the load that follows the tip", "9/10"),),
        ),
        RodModel(
            "distributed",
            "planar Cosserat rod under a follower force spread along its length",
            _QUADRATIC,
            _DRAG,
            _NONE,
            body_load=_FOLLOWS,
        ),
    )
}
