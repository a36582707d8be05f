"""The equations of a periodic orbit of the full nonlinear rod, by Fourier × Chebyshev collocation.

They are those of `strainform` for the plain follower-force rod, whose strains at the tip are ν, 0, 0 at all
times, so that E w_t = R(w) with E = −∫₀ᵘ∫ᵤ¹. An orbit that bifurcates from the straight rod repeats itself
mirrored after half a period: h1 has even harmonics, h2 and Π odd ones. With a the first harmonic of the
tip's angle and s = a², write

    h1 = ν + s η1,    h2 = a η2,    Π = a P.

Then the equations, all of them polynomial, contain a only through s:

    F1 = k1 (h1 − 1),   V1 = (k1 η1' − k2 P η2)/γ1,   V2 = k2 η2' + P F1,   W = (P' + η2 (k2 h1 − F1))/γ3,
    ω E ∂τ η1' = V1 + ∫ (W η2 − P V2),    ω E ∂τ η2' = V2 + ∫ (s P V1 − W h1),    ω E ∂τ P' = W,

∫ from 0 to u, closed by the definition of a and a choice of phase: the first harmonic of ∫₀¹ P du is cos τ.
So the straight rod is no solution, and Newton's method cannot fall back to it; at s = 0 the equations are
the eigenvalue problem of the Hopf point, through which the branch passes smoothly in s.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property, lru_cache
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from rodwnl.collocation import chebyshev, interpolation
from rodwnl.strainform import Integrals, integrals, mass

Array = NDArray[np.float64]

PARITY = ("even", "odd", "odd")  # of η1', η2', P' in τ


class Rod(NamedTuple):
    """The dimensionless parameters as floats."""

    k1: float
    k2: float
    gamma3: float
    gamma1: float


@dataclass(frozen=True)
class HalfPeriod:
    """m (even) phases τ = πj/m, and what can be done with fields known there.

    Fields of odd parity change sign after half a period, those of even parity repeat. By parity: harmonics,
    those that m values determine; series, (m, m): values -> coefficients of cos kτ for all these k, then of
    sin kτ for all but 0 and m; derivative, (m, m): ∂τ at the phases.
    """

    phases: Array
    harmonics: dict[str, Array]
    series: dict[str, Array]
    derivative: dict[str, Array]

    def at(self, parity: str, phases: Array, order: int = 0) -> Array:
        """(len(phases), m): values at the m phases -> the derivative of this order at other phases."""
        basis = _basis(self.harmonics[parity], self.phases.size, phases, order)
        return np.asarray(basis @ self.series[parity])


def _basis(harmonics: Array, count: int, phases: Array, order: int = 0) -> Array:
    """cos kτ for all harmonics, then sin kτ but for k = 0 and for k = m, which vanishes at all m phases."""
    angle = np.outer(phases, harmonics) + order * np.pi / 2
    scale = harmonics**order
    sines = (harmonics > 0) & (harmonics < count)
    return np.hstack([np.cos(angle) * scale, (np.sin(angle) * scale)[:, sines]])


@lru_cache(maxsize=32)
def half_period(count: int) -> HalfPeriod:
    """The grid of this even number of phases."""
    if count < 2 or count % 2:
        raise ValueError(f"a half period needs an even number of phases, not {count}")
    phases = np.pi * np.arange(count) / count
    harmonics = {"even": np.arange(0.0, count + 1, 2), "odd": np.arange(1.0, count, 2)}
    series = {name: np.asarray(np.linalg.inv(_basis(k, count, phases))) for name, k in harmonics.items()}
    derivative = {name: _basis(k, count, phases, 1) @ series[name] for name, k in harmonics.items()}
    return HalfPeriod(phases, harmonics, series, derivative)


@dataclass(frozen=True)
class Flow:
    """The right-hand sides above at given slopes, with their derivatives. Fields (…, N+1); names as above."""

    rod: Rod
    s: float
    matrices: Integrals
    e1: Array
    e2: Array
    P: Array
    h1: Array
    F1: Array
    V1: Array
    V2: Array
    W: Array

    @property
    def right_hand_side(self) -> Array:
        """(…, 3, N+1)."""
        up = self.matrices.up.T
        first = self.V1 + (self.W * self.e2 - self.P * self.V2) @ up
        second = self.V2 + (self.s * self.P * self.V1 - self.W * self.h1) @ up
        return np.stack([first, second, self.W], axis=-2)

    def by_slopes(self) -> Array:
        """∂(right-hand sides)/∂(η1', η2', P'), (…, 3, N+1, 3, N+1)."""
        k1, k2, gamma3, gamma1 = self.rod
        s, up, G = self.s, self.matrices.up, -self.matrices.down  # η = G η'
        eye = np.eye(G.shape[0])

        def along(field: Array) -> Array:
            return field[..., :, None] * G

        def times(field: Array, matrix: Array) -> Array:
            return field[..., :, None] * matrix

        q = k2 * self.h1 - self.F1
        dV1 = (k1 / gamma1 * eye, along(-k2 / gamma1 * self.P), along(-k2 / gamma1 * self.e2))
        dV2 = (along(k1 * s * self.P), k2 * eye, along(self.F1))
        dW = (along((k2 - k1) * s / gamma3 * self.e2), along(q / gamma3), eye / gamma3)
        first = [times(self.e2, dW[i]) - times(self.P, dV2[i]) for i in range(3)]
        first[1] = first[1] + along(self.W)
        first[2] = first[2] - along(self.V2)
        second = [times(s * self.P, dV1[i]) - times(self.h1, dW[i]) for i in range(3)]
        second[0] = second[0] - along(s * self.W)
        second[2] = second[2] + along(s * self.V1)
        n = G.shape[0]
        out = np.empty((*self.P.shape[:-1], 3, n, 3, n))
        for i in range(3):
            out[..., 0, :, i, :] = dV1[i] + up @ first[i]
            out[..., 1, :, i, :] = dV2[i] + up @ second[i]
            out[..., 2, :, i, :] = dW[i]
        return out

    def by_force(self) -> Array:
        """∂(right-hand sides)/∂F, (…, 3, N+1)."""
        k1, k2, gamma3, _ = self.rod
        return self._by_parameter(
            -1 / k1 + 0 * self.P, -1 + 0 * self.P, self.e2 * (1 - k2 / k1) / gamma3, 0.0
        )

    def by_square(self) -> Array:
        """∂(right-hand sides)/∂s, (…, 3, N+1)."""
        k1, k2, gamma3, _ = self.rod
        return self._by_parameter(self.e1, k1 * self.e1, self.e2 * (k2 - k1) * self.e1 / gamma3, 1.0)

    def _by_parameter(self, dh1: Array, dF1: Array, dW: Array, ds: float) -> Array:
        up = self.matrices.up.T
        dV2 = self.P * dF1
        first = (dW * self.e2 - self.P * dV2) @ up
        second = dV2 + (ds * self.P * self.V1 - dW * self.h1 - self.W * dh1) @ up
        return np.stack([first, second, dW], axis=-2)


def flow(rod: Rod, slopes: Array, force: float, s: float, degree: int) -> Flow:
    """The flow at slopes (…, 3, N+1) under this force."""
    k1, k2, gamma3, gamma1 = rod
    matrices = integrals(degree)
    e1, e2, P = np.moveaxis(-slopes @ matrices.down.T, -2, 0)
    w1, w2, w3 = np.moveaxis(slopes, -2, 0)
    F1 = -force + k1 * s * e1
    h1 = 1 + F1 / k1
    V1 = (k1 * w1 - k2 * P * e2) / gamma1
    V2 = k2 * w2 + P * F1
    W = (w3 + e2 * (k2 * h1 - F1)) / gamma3
    return Flow(rod, s, matrices, e1, e2, P, h1, F1, V1, V2, W)


@dataclass(frozen=True)
class OrbitSystem:
    """The equations on m phases × (N + 1) points, for `continuation`: X = (slopes, ω, F, s), slopes (m, 3,
    N+1).

    force_scale, omega_scale: those of the Hopf point from which the branch comes.
    """

    rod: Rod
    count: int
    degree: int
    force_scale: float
    omega_scale: float

    @property
    def size(self) -> int:
        """Number of slopes, 3m(N + 1)."""
        return 3 * self.count * (self.degree + 1)

    @cached_property
    def scales(self) -> Array:
        return np.append(np.ones(self.size), [self.omega_scale, self.force_scale, 1.0])

    @cached_property
    def metric(self) -> Array:
        return np.append(np.zeros(self.size), [self.omega_scale**-2, self.force_scale**-2, 1.0])

    def pack(self, slopes: Array, omega: float, force: float, s: float) -> Array:
        """X."""
        return np.append(slopes.ravel(), [omega, force, s])

    def unpack(self, X: Array) -> tuple[Array, float, float, float]:
        """slopes (m, 3, N+1), ω, F, s."""
        return X[:-3].reshape(self.count, 3, self.degree + 1), float(X[-3]), float(X[-2]), float(X[-1])

    def resampled(self, X: Array, other: OrbitSystem) -> Array:
        """The same orbit as an unknown of a system with other numbers of phases and points."""
        slopes, omega, force, s = self.unpack(X)
        time, there = half_period(self.count), half_period(other.count).phases
        space = interpolation(self.degree, chebyshev(other.degree).nodes)
        fields = [time.at(parity, there) @ slopes[:, i] @ space.T for i, parity in enumerate(PARITY)]
        return other.pack(np.stack(fields, axis=1), omega, force, s)

    def linearised(self, X: Array) -> tuple[Array, Array]:
        """G(X) and ∂G/∂X: the equations at all phases and points, then amplitude and phase."""
        slopes, omega, force, s = self.unpack(X)
        m, n, size = self.count, 3 * (self.degree + 1), self.size
        here = flow(self.rod, slopes, force, s, self.degree)
        inertia = self._inertia @ X[:-3]
        G = np.append(omega * inertia - here.right_hand_side.ravel(), self._first_harmonic @ X[:-3] - [1, 0])
        J = np.zeros((size + 2, size + 3))
        np.multiply(self._inertia, omega, out=J[:size, :size])
        J[:size, -3] = inertia
        J[:size, -2] = -here.by_force().ravel()
        J[:size, -1] = -here.by_square().ravel()
        J[size:, :size] = self._first_harmonic
        by_slopes = here.by_slopes().reshape(m, n, n)
        for j in range(m):
            J[j * n : (j + 1) * n, j * n : (j + 1) * n] -= by_slopes[j]
        return G, J

    @cached_property
    def _first_harmonic(self) -> Array:
        """(2, size): slopes -> cosine and sine coefficient of the first harmonic of ∫₀¹ P du."""
        time, space = half_period(self.count), integrals(self.degree)
        first = time.series["odd"][[0, time.harmonics["odd"].size]]
        rows = np.zeros((2, self.count, 3, self.degree + 1))
        rows[:, :, 2] = first[:, :, None] * (-space.whole @ space.down)
        return rows.reshape(2, self.size)

    @cached_property
    def _inertia(self) -> Array:
        """E ∂τ, (size, size)."""
        time, n, E = half_period(self.count), self.degree + 1, mass(self.degree)
        out = np.zeros((self.count, 3, n, self.count, 3, n))
        for i, parity in enumerate(PARITY):
            out[:, i, :, :, i, :] = np.einsum("jk,ab->jakb", time.derivative[parity], E)
        return out.reshape(self.size, self.size)
