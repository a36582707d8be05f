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

    A state q has shape (3n,), n = N − 1: ξ, then η, then θ at the inner nodes.

    nodes (N+1,): with clamp and tip. tip_row (n,): inner values -> value at the tip of a field that is 0 at
    the clamp and has no slope at the tip. inner (n, 2n), from the right: -> first and second derivatives at
    the inner nodes. slope (n, N+1), from the right: -> first derivative at all nodes. up (N+1, N+1): values
    at all nodes -> ∫₀ᵘ. vanishing (n, n): the same for what vanishes at both ends, at the inner nodes; omega
    (n, n): the same for a field like q.
    """

    k1: float
    k2: float
    gamma3: float
    gamma1: float
    force: float
    nodes: Array
    tip_row: Array
    inner: Array
    slope: Array
    up: Array
    vanishing: Array
    omega: Array
    compatibility: Array

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
        derivatives = q.reshape(3, n) @ self.inner
        (xi_u, h2, pi), (xi_uu, h2_u, pi_u) = derivatives[:, :n], derivatives[:, n:]
        F1, F2 = self.k1 * xi_u, self.k2 * h2
        F1 -= self.force  # k1 (h1 − 1) with h1 = ν + ξ'
        v1 = self.k1 * xi_uu
        v1 -= pi * F2
        v1 /= self.gamma1
        v2 = self.k2 * h2_u
        v2 += pi * F1
        integrands = np.empty((3, n))
        omega = np.add(xi_u, self.nu, out=integrands[2])
        omega *= F2
        omega -= h2 * F1
        omega += pi_u
        omega /= self.gamma3
        np.multiply(omega, h2, out=integrands[0])
        integrands[0] -= pi * v2
        np.multiply(pi, v1, out=integrands[1])
        integrands[1] -= omega * xi_u  # without Ω ν, for which the third row is
        out = np.empty(3 * n)
        np.matmul(integrands.reshape(-1), self.compatibility, out=out[: 2 * n])
        out[:n] += v1
        out[n : 2 * n] += v2
        out[2 * n :] = omega
        return out

    def jacobian(self, q: Array) -> Array:
        """∂f/∂q at one state, (3n, 3n)."""
        n, k1, k2, gamma1, gamma3, nu = self.tip_row.size, self.k1, self.k2, self.gamma1, self.gamma3, self.nu
        derivatives = q.reshape(3, n) @ self.inner
        (xi_u, h2, pi), (xi_uu, h2_u, pi_u) = derivatives[:, :n], derivatives[:, n:]
        h1 = nu + xi_u
        F1, F2 = k1 * (h1 - 1.0), k2 * h2
        v1, v2 = (k1 * xi_uu - pi * F2) / gamma1, k2 * h2_u + pi * F1
        omega = (pi_u + h1 * F2 - h2 * F1) / gamma3

        d, dd = self.inner[:, :n].T, self.inner[:, n:].T
        # ∂v1, ∂v2, ∂Ω by (ξ, η, θ); a[:, None] * d is the field a times the derivative of the variation
        v1_xi, v1_eta, v1_theta = (
            k1 / gamma1 * dd,
            (-k2 / gamma1 * pi)[:, None] * d,
            (-F2 / gamma1)[:, None] * d,
        )
        v2_xi, v2_eta, v2_theta = (k1 * pi)[:, None] * d, k2 * dd, F1[:, None] * d
        omega_xi, omega_eta = ((F2 - k1 * h2) / gamma3)[:, None] * d, ((k2 * h1 - F1) / gamma3)[:, None] * d
        omega_theta = dd / gamma3

        def over(v: Array, a: Array, omega_q: Array, b: Array, v_q: Array, c: Array | float) -> Array:
            """∂ of v + ∫ (a Ω + b v + …): the variation's own factor c times its slope comes last."""
            integrand = a[:, None] * omega_q + b[:, None] * v_q
            return v + self.vanishing @ (integrand + np.reshape(c, (-1, 1)) * d)

        out = np.empty((3, n, 3, n))
        out[0, :, 0] = over(v1_xi, h2, omega_xi, -pi, v2_xi, 0.0)
        out[0, :, 1] = over(v1_eta, h2, omega_eta, -pi, v2_eta, omega)
        out[0, :, 2] = over(v1_theta, h2, omega_theta, -pi, v2_theta, -v2)
        out[1, :, 0] = over(v2_xi, -xi_u, omega_xi, pi, v1_xi, -omega) - nu * self.omega @ omega_xi
        out[1, :, 1] = over(v2_eta, -xi_u, omega_eta, pi, v1_eta, 0.0) - nu * self.omega @ omega_eta
        out[1, :, 2] = over(v2_theta, -xi_u, omega_theta, pi, v1_theta, v1) - nu * self.omega @ omega_theta
        out[2, :, 0], out[2, :, 1], out[2, :, 2] = omega_xi, omega_eta, omega_theta
        return out.reshape(3 * n, 3 * n)

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
    vanishing = up[1:-1, 1:-1].copy()
    omega = vanishing + np.outer(up[1:-1, -1], tip_row)
    k1, k2, gamma3, gamma1 = rod.floats()
    zero = np.zeros_like(vanishing)
    compatibility = np.block([[vanishing.T, zero], [zero, vanishing.T], [zero, (force / k1 - 1) * omega.T]])
    return AngleForm(
        k1, k2, gamma3, gamma1, force, grid.nodes, tip_row,
        inner=np.concatenate([slope[1:-1].T, curvature.T], axis=1), slope=slope.T.copy(), up=up,
        vanishing=vanishing, omega=omega, compatibility=compatibility,
    )  # fmt: skip
