"""The shipped rods written by hand for the independent route (`normalform`): what confirms the derivation.

Each is a `RodLaw` in the rod's own parameters, lengths in L, times in γ2 L⁴/k3, forces in k3/L² (γ2 = k3 =
1). Neither the derivation nor what it emits is used.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

from rodwnl.nilpotent import cos, sin
from rodwnl.strainform import RodLaw, follower


def metric_drag(k1: float, k2: float, gamma3: float, gamma1: float = 0.5) -> RodLaw:
    """Drag per unit current length: each coefficient times √(h1² + h2²)."""

    def drag(h1, h2, pi):  # type: ignore[no-untyped-def]
        metric = (h1 * h1 + h2 * h2) ** 0.5
        return gamma1 * metric, metric, gamma3 * metric

    return replace(follower(k1, k2, gamma3, gamma1), drag=drag)


def quartic(
    k1: float, k2: float, gamma3: float, gamma1: float = 0.5, *, stretch4: float, bend4: float
) -> RodLaw:
    """F1 = k1 (h1 − 1) + stretch4 (h1 − 1)³, M = Π + bend4 Π³."""
    return replace(
        follower(k1, k2, gamma3, gamma1),
        stress=lambda h1, h2, pi: (
            k1 * (h1 - 1.0) + stretch4 * (h1 - 1.0) ** 3,
            k2 * h2,
            pi + bend4 * pi**3,
        ),
    )


def partial_follower(k1: float, k2: float, gamma3: float, gamma1: float = 0.5, *, chi: float) -> RodLaw:
    """χF along −e1, which follows the tip, and (1 − χ)F along −x, which does not."""
    return replace(
        follower(k1, k2, gamma3, gamma1),
        load=lambda theta, v, force: (
            -force * (chi + (1.0 - chi) * cos(theta)),
            force * (1.0 - chi) * sin(theta),
            0.0,
        ),
    )


def distributed(k1: float, k2: float, gamma3: float, gamma1: float = 0.5) -> RodLaw:
    """No load at the tip, the force −F e1 per length along the rod."""
    return replace(
        follower(k1, k2, gamma3, gamma1),
        load=lambda theta, v, force: (0.0, 0.0, 0.0),
        body=lambda force: -force,
    )


#: By the name of the rod.
LAWS: dict[str, Callable[..., RodLaw]] = {
    "follower": follower,
    "metric_drag": metric_drag,
    "quartic": quartic,
    "partial_follower": partial_follower,
    "distributed": distributed,
}
