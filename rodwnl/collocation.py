"""The full nonlinear rod on a Chebyshev grid: q_t = f(q), exact, with its exact Jacobian.

Written by hand from the equations of motion in x, y, θ, so that what is computed with it checks the expansion
and not itself. Lengths are in L, times in γ2 L⁴/k3 (so γ2 = k3 = 1), forces in k3/L².

Balance of forces and of moments in the frame of the cross-section (paper: eq:definitions,
eq:explicitdynamics, eq:drag, eq:constitutive):

    h1 = cosθ x' + sinθ y',   h2 = −sinθ x' + cosθ y',   F1 = k1 (h1 − 1),   F2 = k2 h2,   M = θ',
    γ1 v1 = F1' − θ' F2,      v2 = F2' + θ' F1,          γ3 Ω = M' + h1 F2 − h2 F1.

Clamp (eq:clamping): x = y = θ = 0 at u = 0. Follower load (eq:follower): F1 = −F, F2 = M = 0 at u = 1, put
in the place of the computed stresses there before these are differentiated. (To eliminate the tip by its
slopes x' = ν cosθ, y' = ν sinθ, θ' = 0 gives the same spectrum of the straight rod, but a strongly bent soft
rod then has spurious growing modes on fewer than about 50 points.)
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import lru_cache
from typing import Self

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

MIN_DEGREE = 4


@dataclass(frozen=True)
class Grid:
    """Chebyshev–Lobatto points on [0, 1], in increasing order.

    nodes (N+1,); first and second, (N+1, N+1): values at the nodes -> derivatives there; weights (N+1,):
    Clenshaw–Curtis quadrature over [0, 1]. (Trefethen, Spectral Methods in MATLAB, chapters 6 and 12.)
    """

    nodes: Array
    first: Array
    second: Array
    weights: Array


@lru_cache(maxsize=32)
def chebyshev(degree: int) -> Grid:
    """The grid of polynomials of this degree N. Its arrays are read-only: every caller gets the same ones.

    Node differences come from the product of sines and each diagonal from the negative sum of its row, which
    keeps the derivative of a constant at zero and the round-off low (Baltensperger & Trummer 2003,
    doi:10.1137/S1064827501388182); the second derivative from Welfert's recursion (1997,
    doi:10.1137/S0036142993295545).
    """
    if degree < MIN_DEGREE:
        raise ValueError(f"degree is {degree}; a Chebyshev grid for the rod needs at least {MIN_DEGREE}")
    j = np.arange(degree + 1)
    angle = j * np.pi / degree
    nodes = np.sin(angle / 2) ** 2
    # u_i − u_j = (cos angle_j − cos angle_i)/2, without its cancellation
    difference = np.sin((angle[:, None] + angle) / 2) * np.sin((angle[:, None] - angle) / 2)
    np.fill_diagonal(difference, 1.0)
    c = (-1.0) ** j
    c[[0, -1]] *= 2.0
    first = c[:, None] / c / difference
    np.fill_diagonal(first, 0.0)
    np.fill_diagonal(first, -first.sum(axis=1))
    second = 2 * first * (np.diag(first)[:, None] - 1 / difference)
    np.fill_diagonal(second, 0.0)
    np.fill_diagonal(second, -second.sum(axis=1))
    grid = Grid(nodes, first, second, _clenshaw_curtis(degree))
    for array in (grid.nodes, grid.first, grid.second, grid.weights):
        array.setflags(write=False)
    return grid


def interpolation(degree: int, points: Array) -> Array:
    """(len(points), N+1): values at the nodes of this degree -> their polynomial at other points of [0, 1].

    The barycentric formula (Berrut & Trefethen 2004, doi:10.1137/S0036144502417715).
    """
    weights = (-1.0) ** np.arange(degree + 1)
    weights[[0, -1]] /= 2
    distance = np.asarray(points)[:, None] - chebyshev(degree).nodes
    at_node = distance == 0
    distance[at_node.any(axis=1)] = np.inf
    distance[at_node] = 1.0
    terms = weights / distance
    return np.asarray(terms / terms.sum(axis=1, keepdims=True))


def _clenshaw_curtis(degree: int) -> Array:
    """w·p(nodes) = ∫₀¹ p du for polynomials p up to the degree: ∫₀¹ T_k(2u − 1) du = 1/(1 − k²), k even."""
    k = np.arange(0, degree + 1, 2)
    moments = 1.0 / (1.0 - k**2.0)
    ends = np.ones(degree + 1)
    ends[[0, -1]] = 0.5
    cosines = np.cos(np.outer(np.arange(degree + 1), k) * np.pi / degree) * ends[k]
    return np.asarray(2.0 / degree * ends * (cosines @ moments))


@dataclass(frozen=True)
class DisplacementRod:
    """The rod under one force on one grid. Built by `discretise`, moved to another force by `at_force`.

    A state q has shape (…, 3N): x, then y, then θ at the nodes except the clamp (any leading axes: many
    states at once). nodes (N,): these nodes, the last is the tip. derivative (N+1, N): values there of a
    field that is 0 at the clamp -> its derivative at all nodes. flux (N, N+1): values at all nodes ->
    derivative at `nodes`.
    """

    k1: float
    k2: float
    gamma3: float
    gamma1: float
    force: float
    degree: int
    nodes: Array
    derivative: Array
    flux: Array

    @property
    def size(self) -> int:
        """Number of unknowns, 3N."""
        return 3 * self.degree

    @property
    def nu(self) -> float:
        """Compression of the straight rod, ν = 1 − F/k1 (eq:basestate)."""
        return 1.0 - self.force / self.k1

    def at_force(self, force: float) -> Self:
        """The same rod and grid under another force."""
        return replace(self, force=force)

    def straight(self) -> Array:
        """The compressed straight rod x = νu, y = θ = 0: f vanishes there exactly, without round-off."""
        return self.state(self.nu * self.nodes, 0.0 * self.nodes, 0.0 * self.nodes)

    def state(self, x: Array, y: Array, theta: Array) -> Array:
        """The state with these fields at `nodes`, (…, N) each."""
        return np.concatenate([x, y, theta], axis=-1)

    def split(self, q: Array) -> tuple[Array, Array, Array]:
        """x, y, θ at `nodes`, (…, N) each (views)."""
        n = self.degree
        return q[..., :n], q[..., n : 2 * n], q[..., 2 * n :]

    def tip(self, q: Array) -> tuple[Array, Array, Array]:
        """x, y, θ at u = 1, each of shape (…)."""
        x, y, theta = self.split(q)
        return x[..., -1], y[..., -1], theta[..., -1]

    def tip_defect(self, q: Array) -> Array:
        """(x' − ν cosθ, y' − ν sinθ, θ') at u = 1, (3, …): not imposed: a test of resolution."""
        x, y, theta = self.split(q)
        slope, angle = self.derivative[-1], theta[..., -1]
        return np.stack(
            [x @ slope - self.nu * np.cos(angle), y @ slope - self.nu * np.sin(angle), theta @ slope]
        )

    def rhs(self, q: Array) -> Array:
        """f(q), of the shape of q."""
        at = self._fields(q)
        c, s = at.c[..., 1:], at.s[..., 1:]
        return self.state(c * at.v1 - s * at.v2, s * at.v1 + c * at.v2, at.omega)

    def jacobian(self, q: Array) -> Array:
        """∂f/∂q, (…, 3N, 3N)."""
        at, n = self._fields(q), self.degree
        D, flux, k1, k2 = self.derivative[1:], self.flux, self.k1, self.k2
        inside = np.append(np.ones(n), 0.0)  # the tip's stresses are given

        def scaled(field: Array, matrix: Array) -> Array:
            return field[..., None] * matrix

        # Columns: ∂/∂x, ∂/∂y, ∂/∂θ. Strains: dh1 = c dx' + s dy' + h2 dθ, dh2 = −s dx' + c dy' − h1 dθ.
        eye = np.eye(n + 1)[:, 1:]
        dh1 = [scaled(at.c, self.derivative), scaled(at.s, self.derivative), scaled(at.h2, eye)]
        dh2 = [scaled(-at.s, self.derivative), scaled(at.c, self.derivative), scaled(-at.h1, eye)]
        dF1 = [k1 * scaled(inside, d) for d in dh1]
        dF2 = [k2 * scaled(inside, d) for d in dh2]
        dpi = [0.0 * D, 0.0 * D, D]
        dM_u = [0.0 * D, 0.0 * D, flux @ scaled(inside, self.derivative)]

        h1, h2, F1, F2, pi = (field[..., 1:] for field in (at.h1, at.h2, at.F1, at.F2, at.pi))
        c, s = at.c[..., 1:], at.s[..., 1:]
        out = np.empty((*q.shape[:-1], 3, n, 3, n))
        for i in range(3):
            g1, g2, b1, b2 = dh1[i][..., 1:, :], dh2[i][..., 1:, :], dF1[i][..., 1:, :], dF2[i][..., 1:, :]
            dv1 = (flux @ dF1[i] - scaled(F2, dpi[i]) - scaled(pi, b2)) / self.gamma1
            dv2 = flux @ dF2[i] + scaled(F1, dpi[i]) + scaled(pi, b1)
            turn = scaled(F2, g1) + scaled(h1, b2) - scaled(F1, g2) - scaled(h2, b1)
            out[..., 0, :, i, :] = scaled(c, dv1) - scaled(s, dv2)
            out[..., 1, :, i, :] = scaled(s, dv1) + scaled(c, dv2)
            out[..., 2, :, i, :] = (dM_u[i] + turn) / self.gamma3
        diagonal = np.arange(n)
        out[..., 0, diagonal, 2, diagonal] -= s * at.v1 + c * at.v2
        out[..., 1, diagonal, 2, diagonal] += c * at.v1 - s * at.v2
        return out.reshape(*q.shape, self.size)

    def force_derivative(self, q: Array) -> Array:
        """∂f/∂F at fixed q, of the shape of q: the force is the tip's F1 = −F and nothing else."""
        at = self._fields(q)
        c, s = at.c[..., 1:], at.s[..., 1:]
        tip = np.append(np.zeros(self.degree - 1), 1.0)
        dv1 = -self.flux[:, -1] / self.gamma1
        dv2 = -at.pi[..., 1:] * tip
        return self.state(c * dv1 - s * dv2, s * dv1 + c * dv2, at.h2[..., 1:] * tip / self.gamma3)

    def _fields(self, q: Array) -> _Fields:
        """Strains and stresses at all nodes, velocities at `nodes`."""
        x, y, theta = self.split(q)
        nu, D, flux = self.nu, self.derivative.T, self.flux.T
        theta_all = np.concatenate([np.zeros_like(theta[..., :1]), theta], axis=-1)
        c, s = np.cos(theta_all), np.sin(theta_all)
        # From the departures x − νu and h1 − ν: nothing large is differentiated
        departure, y_u, pi = (x - nu * self.nodes) @ D, y @ D, theta @ D
        stretch = c * departure + s * y_u - 2 * nu * np.sin(theta_all / 2) ** 2
        h1, h2 = nu + stretch, c * y_u - s * (nu + departure)
        F1, F2, M = self.k1 * stretch, self.k2 * h2, pi.copy()  # F1 + F for the moment
        F1[..., -1] = F2[..., -1] = M[..., -1] = 0.0
        F1_u, F2_u, M_u = F1 @ flux, F2 @ flux, M @ flux
        F1 = F1 - self.force

        inner = np.s_[..., 1:]
        v1 = (F1_u - pi[inner] * F2[inner]) / self.gamma1
        v2 = F2_u + pi[inner] * F1[inner]
        omega = (M_u + h1[inner] * F2[inner] - h2[inner] * F1[inner]) / self.gamma3
        return _Fields(c, s, h1, h2, pi, F1, F2, v1, v2, omega)


@dataclass(frozen=True)
class _Fields:
    """e1 = (c, s), strains and stresses at all nodes, (…, N+1) each; velocities at `nodes`, (…, N)."""

    c: Array
    s: Array
    h1: Array
    h2: Array
    pi: Array
    F1: Array
    F2: Array
    v1: Array
    v2: Array
    omega: Array


def discretise(
    k1: float, k2: float, gamma3: float, gamma1: float, force: float, degree: int = 32
) -> DisplacementRod:
    """The rod with these dimensionless stiffnesses and drags under a follower force, on this degree's points.

    24 to 32 suffice for the first modes; the round-off of two derivatives grows like degree⁴.
    """
    grid = chebyshev(degree)
    first = grid.first
    return DisplacementRod(k1, k2, gamma3, gamma1, force, degree, grid.nodes[1:], first[:, 1:], first[1:])
