"""The full nonlinear rod as a system to integrate in time: q_t = f(q), with its exact Jacobian.

Written by hand from the equations of motion, without any expansion (paper: eq:definitions,
eq:explicitdynamics, eq:drag, eq:constitutive). Lengths in L, times in γ2 L⁴/k3, forces in k3/L².

What makes the displacements (x, y, θ) hard to integrate is that the large stiffnesses multiply products of
them: h1 = x' cosθ + y' sinθ has to stay near 1 while θ swings. Here the unknowns are

    ξ = ∫₀ᵘ (h1 − ν),    η = ∫₀ᵘ h2,    θ,

so that the stresses are linear in them and f is a polynomial of third degree without sines and cosines. With
the velocities from the balance of forces and moments,

    γ1 v1 = F1' − θ' F2,   v2 = F2' + θ' F1,   γ3 Ω = θ'' + h1 F2 − h2 F1,   F1 = k1 (h1 − 1),  F2 = k2 h2,

the compatibility of strains and velocities, integrated from the clamp, is

    ξ_t = v1 + ∫₀ᵘ (Ω h2 − θ' v2),    η_t = v2 + ∫₀ᵘ (θ' v1 − Ω h1),    θ_t = Ω.

The clamp (eq:clamping) is ξ = η = θ = 0 at u = 0. The follower load (eq:follower), F1 = −F and F2 = M = 0, is
ξ' = η' = θ' = 0 at u = 1 with ν = 1 − F/k1. The straight rod is q = 0.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from rodwnl.collocation import chebyshev
from rodwnl.parameters import RodParameters
from rodwnl.strainform import integrals

Array = NDArray[np.float64]


@dataclass(frozen=True)
class AngleForm:
    """f and ∂f/∂q on Chebyshev points of one degree N. Built by `angle_form`.

    A state q has shape (3n,), n = N − 1: ξ, then η, then θ at the inner nodes, where f is made of four
    products of linear functions of q, and of four products with their sums:

        X = (θ', θ', h2, h1),    Y = (−F2/γ1, F1, −F1/γ3, F2/γ3),    V = (k1 ξ''/γ1, k2 η'', θ''/γ3),
        v1 = V1 + X1 Y1,   v2 = V2 + X2 Y2,   Ω = V3 + X3 Y3 + X4 Y4,   Z = (X1 v1, X2 v2, X3 Ω, X4 Ω).

    nodes (N+1,): with clamp and tip. tip_row (n,): inner values -> value at the tip of a field that is 0 at
    the clamp and has no slope at the tip. slope (n, N+1), from the right: -> first derivative at all nodes.
    up (N+1, N+1): values at all nodes -> ∫₀ᵘ. linear (11n, 3n) and constant (11n,): q -> X, Y, V. closing
    (3n, 7n): Z, v1, v2, Ω -> f.
    """

    k1: float
    k2: float
    gamma3: float
    gamma1: float
    force: float
    nodes: Array
    tip_row: Array
    slope: Array
    up: Array
    linear: Array
    constant: Array
    closing: Array

    @property
    def size(self) -> int:
        """The number of unknowns, 3(N − 1)."""
        return 3 * self.tip_row.size

    @property
    def nu(self) -> float:
        """Compression of the straight rod, ν = 1 − F/k1 (eq:basestate)."""
        return 1.0 - self.force / self.k1

    def rhs(self, q: Array) -> Array:
        """f(q) at one state, (3n,). In place where it can be: of an integration most time is spent here."""
        n = self.tip_row.size
        rows = np.empty(12 * n)
        np.matmul(self.linear, q, out=rows[: 11 * n])
        rows[: 11 * n] += self.constant
        X, Y, V = rows.reshape(3, 4, n)
        Y *= X
        V[:3] += Y[:3]
        V[2] += Y[3]
        V[3] = V[2]
        np.multiply(X, V, out=Y)
        return np.asarray(self.closing @ rows[4 * n : 11 * n])

    def jacobian(self, q: Array) -> Array:
        """∂f/∂q at one state, (3n, 3n)."""
        n = self.tip_row.size
        X, Y, V = np.split((self.linear @ q + self.constant).reshape(11, n, 1), [4, 8])
        dX, dY, dV = np.split(self.linear.reshape(11, n, 3 * n), [4, 8])
        products, by_q = X * Y, X * dY + Y * dX
        v, dv = V + products[:3], dV + by_q[:3]
        v[2] += products[3]
        dv[2] += by_q[3]
        last = [0, 1, 2, 2]
        dZ = X * dv[last] + v[last] * dX
        return np.asarray(self.closing @ np.concatenate([dZ, dv]).reshape(7 * n, 3 * n))

    def fields(self, q: Array) -> tuple[Array, Array, Array, Array]:
        """x, y, θ and the axial force F1 at all N + 1 nodes, (…, N+1) each, of states (…, 3n)."""
        n = self.tip_row.size
        q = q.reshape(*q.shape[:-1], 3, n)
        strains = q[..., :2, :] @ self.slope
        theta = self._closed(q[..., 2, :])
        c, s = np.cos(theta), np.sin(theta)
        h1, h2 = self.nu + strains[..., 0, :], strains[..., 1, :]
        x, y = (h1 * c - h2 * s) @ self.up.T, (h1 * s + h2 * c) @ self.up.T
        return x, y, theta, self.k1 * (h1 - 1.0)

    def tip(self, q: Array) -> tuple[Array, Array, Array]:
        """x, y, θ at u = 1, each of shape (…)."""
        x, y, theta, _ = self.fields(q)
        return x[..., -1], y[..., -1], theta[..., -1]

    def state(self, h1: Array, h2: Array, theta: Array) -> Array:
        """The state with these strains and angle at the nodes, (…, N+1) each; the tip follows the load."""
        xi, eta = (h1 - self.nu) @ self.up.T, h2 @ self.up.T
        return np.concatenate([xi[..., 1:-1], eta[..., 1:-1], theta[..., 1:-1]], axis=-1)

    def tail(self, q: Array) -> float:
        """How well the grid resolves these states: the last Chebyshev coefficients of ξ, η, θ, relative.

        The largest of the last three coefficients of a field over its largest one, at worst over the states.
        """
        n = self.tip_row.size
        values = self._closed(q.reshape(-1, n))
        even = np.concatenate([values, values[:, -2:0:-1]], axis=1)  # cosine series, by the FFT
        series = np.abs(np.fft.rfft(even, axis=1)).reshape(-1, 3, n + 2)
        size = series.max(axis=(0, 2))
        return float((series[..., -3:].max(axis=(0, 2)) / np.where(size > 0, size, 1.0)).max())

    def _closed(self, field: Array) -> Array:
        """Inner values -> values at all nodes: 0 at the clamp, no slope at the tip."""
        tip = field @ self.tip_row
        return np.concatenate([np.zeros_like(tip)[..., None], field, tip[..., None]], axis=-1)


def angle_form(rod: RodParameters, force: float, degree: int = 16) -> AngleForm:
    """The rod under this dimensionless follower force, 0 < force < k1, on Chebyshev points of this degree."""
    grid, up = chebyshev(degree), np.array(integrals(degree).up)
    tip_row = -grid.first[-1, 1:-1] / grid.first[-1, -1]
    slope = grid.first[:, 1:-1] + np.outer(grid.first[:, -1], tip_row)
    curvature = grid.second[1:-1, 1:-1] + np.outer(grid.second[1:-1, -1], tip_row)
    slope[-1] = 0.0
    k1, k2, gamma3, gamma1 = rod.floats()
    nu, n = 1 - force / k1, degree - 1
    # ∫₀ᵘ of a field that vanishes at both ends, and of one like q
    vanishing, one = up[1:-1, 1:-1], np.eye(n)
    omega = vanishing + np.outer(up[1:-1, -1], tip_row)
    d, dd, zero = slope[1:-1], curvature, np.zeros((n, n))
    linear = np.block(
        [
            [zero, zero, d], [zero, zero, d], [zero, d, zero], [d, zero, zero],
            [zero, -k2 / gamma1 * d, zero], [k1 * d, zero, zero],
            [-k1 / gamma3 * d, zero, zero], [zero, k2 / gamma3 * d, zero],
            [k1 / gamma1 * dd, zero, zero], [zero, k2 * dd, zero], [zero, zero, dd / gamma3],
        ]
    )  # fmt: skip
    constant = np.repeat([0, 0, 0, nu, 0, -force, force / gamma3, 0, 0, 0, 0], n)
    # θ' v2, h2 Ω and θ' v1 vanish at both ends; h1 Ω does not, but (h1 − ν) Ω does
    closing = np.block(
        [
            [zero, -vanishing, vanishing, zero, one, zero, zero],
            [vanishing, zero, zero, -vanishing, zero, one, nu * (vanishing - omega)],
            [zero, zero, zero, zero, zero, zero, one],
        ]
    )
    return AngleForm(
        k1, k2, gamma3, gamma1, force, grid.nodes, tip_row, slope=slope.T.copy(), up=up,
        linear=linear, constant=constant, closing=closing,
    )  # fmt: skip
