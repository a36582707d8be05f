"""The full nonlinear rod on a Chebyshev grid: q_t = f(q), exact, with its exact Jacobian.

Written by hand from the equations of motion, so that what is computed with it checks the expansion and not
itself. Lengths are in L, times in γ2 L⁴/k3 (so γ2 = k3 = 1), forces in k3/L².

Balance of forces and of moments in the frame of the cross-section (paper: eq:explicitdynamics, eq:drag,
eq:constitutive), with h1 = cosθ x' + sinθ y', h2 = −sinθ x' + cosθ y', Π = θ':

    γ1 v1 = F1' − Π F2,    v2 = F2' + Π F1,    γ3 Ω = M' + h1 F2 − h2 F1,
    F1 = k1 (h1 − 1),      F2 = k2 h2,         M = Π.

Clamp (eq:clamping): x = y = θ = 0 at u = 0. Follower load (eq:follower), with ν = 1 − F/k1: x' = ν cosθ, y'
= ν sinθ, θ' = 0 at u = 1. The derivative at the tip is linear in the tip value, so these three conditions
give first θ(1), then x(1) and y(1), in closed form: an ordinary differential equation is left.
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
class DiscreteRod:
    """The rod under one force on one grid. Built by `discretise`, moved to another by `at_force`.

    A state q has shape (…, 3n), n = N − 1: x, then y, then θ at the inner nodes (any leading axes: many
    states at once). What happens at the clamp and at the tip follows from it.

    nodes (n,): the inner nodes. tip_row (n,): inner values -> tip value of a field whose derivative
    vanishes at the tip. inner (n, 2n): such a field's inner values, from the right -> its first and second
    derivatives at the inner nodes. edge (2n,): the same derivatives of the field that is 0 at the inner
    nodes and has unit slope at the tip; edge_tip: that field's tip value.
    """

    k1: float
    k2: float
    gamma3: float
    gamma1: float
    force: float
    degree: int
    nodes: Array
    tip_row: Array
    inner: Array
    edge: Array
    edge_tip: float

    @property
    def size(self) -> int:
        """Number of unknowns, 3(N − 1)."""
        return 3 * (self.degree - 1)

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
        """The state with these fields at the inner nodes, (…, n) each."""
        return np.concatenate([x, y, theta], axis=-1)

    def split(self, q: Array) -> tuple[Array, Array, Array]:
        """x, y, θ at the inner nodes, (…, n) each (views)."""
        n = self.degree - 1
        return q[..., :n], q[..., n : 2 * n], q[..., 2 * n :]

    def tip(self, q: Array) -> tuple[Array, Array, Array]:
        """x, y, θ at u = 1, each of shape (…)."""
        x, y, theta = self.split(q)
        theta_tip = theta @ self.tip_row
        slope = self.nu * self.edge_tip
        return (
            x @ self.tip_row + slope * np.cos(theta_tip),
            y @ self.tip_row + slope * np.sin(theta_tip),
            theta_tip,
        )

    def fields(self, q: Array) -> tuple[Array, Array, Array]:
        """x, y, θ at all N + 1 nodes of `chebyshev(degree)`, clamp and tip included, (…, N+1) each."""
        x, y, theta = (
            np.concatenate([np.zeros_like(tip)[..., None], field, tip[..., None]], axis=-1)
            for field, tip in zip(self.split(q), self.tip(q), strict=True)
        )
        return x, y, theta

    def rhs(self, q: Array) -> Array:
        """f(q), of the shape of q."""
        local = self._local(q)
        c, s, v1, v2 = local.c, local.s, local.v1, local.v2
        return self.state(c * v1 - s * v2, s * v1 + c * v2, local.omega)

    def jacobian(self, q: Array) -> Array:
        """∂f/∂q, shape (…, 3n, 3n)."""
        local, n = self._local(q), self.degree - 1
        first, second = self.inner[:, :n].T, self.inner[:, n:].T
        by_x_u, by_x_uu, by_y_u, by_y_uu, by_theta, by_theta_u, by_theta_uu = self._partials(local)
        out = np.empty((*q.shape[:-1], 3 * n, 3 * n))
        # x' and y' know θ(1) as well: ∂x'/∂θ = −ν sinθ(1) edge ⊗ tip_row, ∂y'/∂θ = ν cosθ(1) edge ⊗ tip_row
        x_tip, y_tip = -self.nu * local.sin_tip[..., None], self.nu * local.cos_tip[..., None]
        edge_u, edge_uu = self.edge[:n], self.edge[n:]
        for row in range(3):
            rows = slice(row * n, (row + 1) * n)
            out[..., rows, :n] = by_x_u[row][..., None] * first + by_x_uu[row][..., None] * second
            out[..., rows, n : 2 * n] = by_y_u[row][..., None] * first + by_y_uu[row][..., None] * second
            through_tip = x_tip * (by_x_u[row] * edge_u + by_x_uu[row] * edge_uu) + y_tip * (
                by_y_u[row] * edge_u + by_y_uu[row] * edge_uu
            )
            block = by_theta_u[row][..., None] * first + through_tip[..., None] * self.tip_row
            if row == 2:
                block = block + by_theta_uu * second
            np.einsum("...ii->...i", block)[...] += by_theta[row]
            out[..., rows, 2 * n :] = block
        return out

    def force_derivative(self, q: Array) -> Array:
        """∂f/∂F at fixed q, of the shape of q. The force acts through ν in the tip conditions alone."""
        local, n = self._local(q), self.degree - 1
        by_x_u, by_x_uu, by_y_u, by_y_uu, *_ = self._partials(local)
        x_nu, y_nu = local.cos_tip[..., None] * self.edge, local.sin_tip[..., None] * self.edge
        parts = [
            by_x_u[row] * x_nu[..., :n]
            + by_x_uu[row] * x_nu[..., n:]
            + by_y_u[row] * y_nu[..., :n]
            + by_y_uu[row] * y_nu[..., n:]
            for row in range(3)
        ]
        return np.concatenate(parts, axis=-1) / -self.k1

    def _local(self, q: Array) -> _Local:
        """Strains and velocities at the inner nodes."""
        x, y, theta = self.split(q)
        n, nu = self.degree - 1, self.nu
        theta_tip = theta @ self.tip_row
        cos_tip, sin_tip = np.cos(theta_tip), np.sin(theta_tip)
        # Differentiate the departure from the straight rod, x − νu: its slope at the tip is ν(cosθ − 1).
        departure = -2 * nu * np.sin(theta_tip / 2) ** 2
        x_d = (x - nu * self.nodes) @ self.inner + departure[..., None] * self.edge
        y_d = y @ self.inner + (nu * sin_tip)[..., None] * self.edge
        theta_d = theta @ self.inner
        x_u, x_uu, y_u, y_uu = nu + x_d[..., :n], x_d[..., n:], y_d[..., :n], y_d[..., n:]
        pi, theta_uu = theta_d[..., :n], theta_d[..., n:]

        c, s = np.cos(theta), np.sin(theta)
        h1, h2 = c * x_u + s * y_u, c * y_u - s * x_u
        p1, p2 = c * x_uu + s * y_uu, c * y_uu - s * x_uu  # h1' = p1 + Π h2, h2' = p2 − Π h1
        k1, k2, k = self.k1, self.k2, self.k1 - self.k2
        v1 = (k1 * p1 + k * pi * h2) / self.gamma1
        v2 = k2 * p2 + pi * (k * h1 - k1)
        omega = (theta_uu + h2 * (k1 - k * h1)) / self.gamma3
        return _Local(c, s, cos_tip, sin_tip, h1, h2, pi, p1, p2, v1, v2, omega)

    def _partials(self, local: _Local) -> tuple[Array, Array, Array, Array, Array, Array, Array]:
        """∂(x_t, y_t, θ_t) by x', x'', y', y'', θ, θ' at a node, (3, …, n) each; by θ'': (0, 0, the last)."""
        c, s, h1, h2, pi, p1, p2 = local.c, local.s, local.h1, local.h2, local.pi, local.p1, local.p2
        v1, v2, k1, k2, k = local.v1, local.v2, self.k1, self.k2, self.k1 - self.k2
        kg, g1, g3 = k / self.gamma1, self.gamma1, self.gamma3
        a = (k1 - k * h1) / g3

        def turned(d1: Array, d2: Array, d3: Array) -> Array:
            """(dv1, dv2, dΩ) -> (dx_t, dy_t, dθ_t) at fixed θ."""
            return np.stack([c * d1 - s * d2, s * d1 + c * d2, d3])

        zero = np.zeros_like(c)
        by_theta = turned((k1 * p2 - k * pi * h1) / g1, k * pi * h2 - k2 * p1, -h1 * a - k * h2 * h2 / g3)
        by_theta[0] -= s * v1 + c * v2
        by_theta[1] += c * v1 - s * v2
        return (
            turned(-kg * pi * s, k * pi * c, -s * a - k * h2 * c / g3),
            turned(k1 / g1 * c, -k2 * s, zero),
            turned(kg * pi * c, k * pi * s, c * a - k * h2 * s / g3),
            turned(k1 / g1 * s, k2 * c, zero),
            by_theta,
            turned(kg * h2, k * h1 - k1, zero),
            np.asarray(1 / g3),
        )


@dataclass(frozen=True)
class _Local:
    """Inner nodes: e1 = (c, s), strains, (x'', y'') along e1, e2, velocities; tip: cosθ, sinθ."""

    c: Array
    s: Array
    cos_tip: Array
    sin_tip: Array
    h1: Array
    h2: Array
    pi: Array
    p1: Array
    p2: Array
    v1: Array
    v2: Array
    omega: Array


def discretise(
    k1: float, k2: float, gamma3: float, gamma1: float, force: float, degree: int = 32
) -> DiscreteRod:
    """The rod with these dimensionless stiffnesses and drags under a follower force, on this degree's
    points.

    24 to 32 suffice for the first modes; the round-off of the second derivative grows like degree⁴.
    """
    grid = chebyshev(degree)
    last = grid.first[-1, -1]
    tip_row = -grid.first[-1, 1:-1] / last
    both = np.stack([grid.first, grid.second])[:, 1:-1]
    inner = both[:, :, 1:-1] + both[:, :, -1:] * tip_row
    n = degree - 1
    # (2, node, column) -> (column, 2·node): a field's derivatives are field @ inner
    return DiscreteRod(
        k1, k2, gamma3, gamma1, force, degree,
        nodes=grid.nodes[1:-1], tip_row=tip_row, inner=inner.transpose(2, 0, 1).reshape(n, 2 * n),
        edge=(both[:, :, -1] / last).reshape(2 * n), edge_tip=float(1 / last),
    )  # fmt: skip
