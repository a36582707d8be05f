"""The rod in its strains: E w_t = R(w), well conditioned because nothing in it is ever differentiated.

The strains z = (h1, h2, Π) fix the rod's shape (θ' = Π, x' = h1 cosθ − h2 sinθ, y' = h1 sinθ + h2 cosθ).
Their compatibility with the velocities of the cross-section is polynomial and free of angles:

    h1_t = v1' − Π v2 + Ω h2,    h2_t = v2' + Π v1 − Ω h1,    Π_t = Ω'.

The unknowns are the slopes w = z' and the strains at the tip, z1 = z(1). Then z = z1 − ∫ᵤ¹ w, the velocities
follow from the balance of forces and moments, and the clamp is v(0) = 0, so that with ∫₀ᵘ of the above

    u z1_t − ∫₀ᵘ∫ᵤ¹ w_t = v + ∫₀ᵘ (Ω h2 − Π v2, Π v1 − Ω h1, 0),
                      0 = stress(z1) − load(θ(1), v(1), F),            in short E (w, z1)_t = R(w, z1).

w is a polynomial on Chebyshev points; the matrices of the two integrals have entries below 1, so that
nothing grows with the number of points, as the round-off of derivative matrices does.

A rod is given by its law: stresses, drags, loads. Each is evaluated on arrays or on `Nilpotent`s.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import lru_cache
from typing import Any

import numpy as np
from numpy.typing import NDArray

from rodwnl.collocation import chebyshev
from rodwnl.nilpotent import Nilpotent, Value, cos, nilpotent, sin

Matrix = NDArray[np.float64]
Triple = tuple[Any, Any, Any]

SLOPE = 8  # the e_i that carries ∂u in `velocities`; directions 1…7 are the caller's


@dataclass(frozen=True)
class RodLaw:
    """What a rod is made of, in units with γ2 = k3 = 1.

    stress: (h1, h2, Π) -> (F1, F2, M), the gradient of the stored energy. drag: (h1, h2, Π) -> (γ1, γ2,
    γ3). load: (θ, (v1, v2, Ω), force) -> the stresses imposed at u = 1. body: force -> force along e1 per
    length. Smooth functions of + − × ÷, powers, `nilpotent.sin` and `nilpotent.cos`.
    """

    stress: Callable[[Any, Any, Any], Triple]
    drag: Callable[[Any, Any, Any], Triple]
    load: Callable[[Any, Triple, Any], Triple]
    body: Callable[[Any], Any] = lambda force: 0.0


def follower(k1: float, k2: float, gamma3: float, gamma1: float = 0.5) -> RodLaw:
    """Quadratic energy, constant drag, follower force (eq:constitutive, eq:drag, eq:follower)."""
    return RodLaw(
        stress=lambda h1, h2, pi: (k1 * (h1 - 1.0), k2 * h2, pi),
        drag=lambda h1, h2, pi: (gamma1, 1.0, gamma3),
        load=lambda theta, v, force: (-force, 0.0, 0.0),
    )


@dataclass(frozen=True)
class Integrals:
    """nodes (N+1,); up, down (N+1, N+1): f at the nodes -> ∫₀ᵘ f and ∫ᵤ¹ f there; whole (N+1,): -> ∫₀¹ f."""

    nodes: Matrix
    up: Matrix
    down: Matrix
    whole: Matrix


@lru_cache(maxsize=32)
def integrals(degree: int) -> Integrals:
    """Exact integrals of the polynomials through N + 1 Chebyshev points, by their Chebyshev series.

    2∫T_k ds = T_{k+1}/(k+1) − T_{k−1}/(k−1) on s = 2u − 1 ∈ [−1, 1], du = ds/2.
    """
    grid = chebyshev(degree)
    n = degree + 1
    k = np.arange(n)
    # s = −cos(jπ/N): T_k(s_j) = (−1)^k cos(kjπ/N)
    values = np.cos(np.outer(np.arange(n), np.arange(n + 1)) * np.pi / degree) * (-1.0) ** np.arange(n + 1)
    ends = np.ones(n)
    ends[[0, -1]] = 0.5
    series = 2.0 / degree * (ends[:, None] * values[:, :n].T * ends)
    antiderivative = np.zeros((n + 1, n))
    antiderivative[k + 1, k] = 1.0 / (4.0 * (k + 1))
    antiderivative[1, 0] = 0.5
    antiderivative[k[2:] - 1, k[2:]] -= 1.0 / (4.0 * (k[2:] - 1))
    up = (values - values[0]) @ antiderivative @ series
    up[0] = 0.0
    down = up[::-1, ::-1].copy()
    for array in (up, down):
        array.setflags(write=False)
    return Integrals(grid.nodes, up, down, grid.weights)


def strains(ends: Triple, slopes: Triple, degree: int) -> Triple:
    """z = z1 − ∫ᵤ¹ w at the nodes. Ends z1: (…, 1) or numbers; fields, here and below: (…, N+1); three each,
    arrays or Nilpotents.
    """
    down = integrals(degree).down.T
    h1, h2, pi = (end - nilpotent(w).map(lambda a: a @ down) for end, w in zip(ends, slopes, strict=True))
    return h1, h2, pi


def velocities(law: RodLaw, z: Triple, slopes: Triple, force: Value) -> Triple:
    """(v1, v2, Ω) from the balance of forces and moments; F' is the stresses' derivative along z' = w."""
    moving = [_joined(field, nilpotent(w)) for field, w in zip(z, slopes, strict=True)]
    (F1, F1_u), (F2, F2_u), (_, M_u) = (_split(stress) for stress in law.stress(*moving))
    h1, h2, pi = z
    gamma1, gamma2, gamma3 = law.drag(h1, h2, pi)
    return (
        (F1_u - pi * F2 + law.body(force)) / gamma1,
        (F2_u + pi * F1) / gamma2,
        (M_u + h1 * F2 - h2 * F1) / gamma3,
    )


def residual(law: RodLaw, ends: Triple, slopes: Triple, force: Value, degree: int) -> tuple[Triple, Triple]:
    """R: at u = 0 the clamp's v = 0, elsewhere the compatibility of strains and velocities up to u; and the
    stresses minus the load at the tip, (…, 1) each.
    """
    up = integrals(degree).up.T
    h1, h2, pi = z = strains(ends, slopes, degree)
    v1, v2, omega = v = velocities(law, z, slopes, force)
    compatibility = (
        v1 + (omega * h2 - pi * v2).map(lambda a: a @ up),
        v2 + (pi * v1 - omega * h1).map(lambda a: a @ up),
        omega,
    )
    theta = pi.map(lambda a: a @ up[:, -1:])
    at_tip = [nilpotent(field).map(lambda a: a[..., -1:]) for field in v]
    imposed = law.load(theta, (at_tip[0], at_tip[1], at_tip[2]), force)
    f1, f2, m = (stress - load for stress, load in zip(law.stress(*ends), imposed, strict=True))
    return compatibility, (f1, f2, m)


def tip(ends: Triple, slopes: Triple, degree: int) -> Triple:
    """(x, y, θ) at u = 1, of shape (…)."""
    matrices = integrals(degree)
    h1, h2, pi = strains(ends, slopes, degree)
    theta = pi.map(lambda a: a @ matrices.up.T)
    c, s = cos(theta), sin(theta)
    x, y, angle = (f.map(lambda a: a @ matrices.whole) for f in (h1 * c - h2 * s, h1 * s + h2 * c, pi))
    return x, y, angle


def mass(degree: int) -> Matrix:
    """E of one field's slopes, (N+1, N+1): −∫₀ᵘ∫ᵤ¹. The same for each of the three."""
    matrices = integrals(degree)
    return np.asarray(-matrices.up @ matrices.down)


_BIT = 1 << (SLOPE - 1)


def _joined(value: Nilpotent, slope: Nilpotent) -> Nilpotent:
    """f + e f', e = e_SLOPE."""
    return Nilpotent(value.parts | {mask | _BIT: part for mask, part in slope.parts.items()})


def _split(value: Nilpotent) -> tuple[Nilpotent, Nilpotent]:
    """f and f' of f + e f', e = e_SLOPE."""
    return (
        Nilpotent({mask: part for mask, part in value.parts.items() if not mask & _BIT}),
        Nilpotent({0: 0.0, **{mask ^ _BIT: part for mask, part in value.parts.items() if mask & _BIT}}),
    )
