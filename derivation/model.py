"""A rod as data: stored energy, drag law, tip load. Everything downstream is computed from this record."""

from __future__ import annotations

from dataclasses import dataclass

from sympy import Expr, Integer, Rational

from derivation.symbols import symbol


@dataclass(frozen=True)
class RodModel:
    """A planar Cosserat rod with linear-response drag, clamped at u = 0 and loaded at u = 1.

    Attributes:
        name: the package name of what is emitted for it (a Python identifier).
        title: one line for headers and help.
        energy: stored energy per unit reference length, W(h1, h2, Pi); stresses are its gradient.
        drag: what balances the gradient of the stresses, per unit reference length, as functions of
            (v1, v2, Omega): the paper's (-f1, -f2, -m), eq:drag.
        tip_load: the stresses (F1, F2, M) imposed at u = 1, eq:follower.

    All expressions are polynomials in the symbols of :mod:`derivation.symbols`, scaled so that
    gamma2 = k3 = 1 (eq:dimensionlessconstitutive).
    """

    name: str
    title: str
    energy: Expr
    drag: tuple[Expr, Expr, Expr]
    tip_load: tuple[Expr, Expr, Expr]


def _follower() -> RodModel:
    h1, h2, curvature = symbol("h1"), symbol("h2"), symbol("Pi")
    k1, k2 = symbol("k1"), symbol("k2")
    return RodModel(
        name="follower",
        title="planar Cosserat rod under a tip follower force",
        # eq:constitutive: F1 = k1 (h1 - 1), F2 = k2 h2, M = Pi.
        energy=Rational(1, 2) * (k1 * (h1 - 1) ** 2 + k2 * h2**2 + curvature**2),
        # eq:drag.
        drag=(symbol("gamma1") * symbol("v1"), symbol("v2"), symbol("gamma3") * symbol("Omega")),
        # eq:follower: the load turns with the tip, so it is constant in the moving frame.
        tip_load=(-symbol("force"), Integer(0), Integer(0)),
    )


#: The paper's rod.
FOLLOWER = _follower()

#: The rods that are shipped, by name.
MODELS: dict[str, RodModel] = {FOLLOWER.name: FOLLOWER}
