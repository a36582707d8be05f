"""The equations of a periodic orbit of the full nonlinear rod, by Fourier × Chebyshev collocation.

They are E w_t = R(w, F) as the rod's law gives it (`strainform`, `normalform`), whose exact derivatives
Newton's method takes. An orbit that bifurcates from the straight rod repeats itself mirrored after half a
period: h1 has even harmonics of τ = ωt, h2 and Π odd ones. With a the first harmonic of the tip's angle and
s = a², write

    h1 = η1,    h2 = a η2,    Π = a P,

and divide the equations that are odd in τ by a:

    ω E ∂τ η1 = R1(η1, a η2, a P),    ω E ∂τ (η2, P) = (R2, R3)(η1, a η2, a P)/a,

closed by a choice of amplitude and phase: the first harmonic of ∫₀¹ P du is cos τ. So the straight rod is no
solution for s ≠ 0, and Newton's method cannot fall back to it. The rod's mirror symmetry makes both sides
functions of s, smooth through s = 0, where they are the straight rod's balance and the eigenvalue problem of
the Hopf point. Beyond, at s < 0, a is imaginary; Newton's method may step there, but no orbit lies there.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from rodwnl.collocation import chebyshev, interpolation
from rodwnl.halfperiod import by_parity, half_period
from rodwnl.harmonicsolve import CycleJacobian
from rodwnl.nilpotent import nilpotent
from rodwnl.normalform import DiscreteRod
from rodwnl.strainform import RodLaw, integrals, strains

Array = NDArray[np.float64]

PARITY = ("even", "odd", "odd")  # of h1, h2, Π in τ
LEAST = 1e-12  # |s| below which the equations are those at this s: they change by as much
SMALL = 1e-4  # s below which ∂s of the odd equations is the third derivative of R, which a difference loses


@dataclass(frozen=True)
class OrbitSystem:
    """The equations on m phases × (N + 1) points, for `continuation`: X = (states, ω, F, s), states (m, size)
    as `normalform` strings them, of η1, η2, P.

    force_scale, omega_scale: those of the Hopf point from which the branch comes.
    """

    law: RodLaw
    count: int
    degree: int
    force_scale: float
    omega_scale: float

    @cached_property
    def rod(self) -> DiscreteRod:
        return DiscreteRod(self.law, self.degree)

    @cached_property
    def odd(self) -> NDArray[np.bool_]:
        """(size,): of every entry of a state and every row of R whether it is odd in τ."""
        return np.array([p == "odd" for p in (*np.repeat(PARITY, self.degree + 1), *PARITY)])

    @property
    def scales(self) -> Array:
        return np.append(np.ones(self.count * self.rod.size), [self.omega_scale, self.force_scale, 1.0])

    @property
    def metric(self) -> Array:
        states = np.zeros(self.count * self.rod.size)
        return np.append(states, [self.omega_scale**-2, self.force_scale**-2, 1.0])

    def unpack(self, X: Array) -> tuple[Array, float, float, float]:
        """states (m, size), ω, F, s."""
        return X[:-3].reshape(self.count, -1), float(X[-3]), float(X[-2]), float(X[-1])

    def begin(self, mode: NDArray[Any]) -> Array:
        """The Hopf point as X, from its mode, whose tip has the angle 1."""
        waves = np.exp(1j * half_period(self.count).phases)[:, None] * mode
        states = np.where(self.odd, waves.real, self.rod.straight(self.force_scale))
        return np.append(states.ravel(), [self.omega_scale, self.force_scale, 0.0])

    def resampled(self, X: Array, other: OrbitSystem) -> Array:
        """The same orbit as an unknown of a system with other numbers of phases and points."""
        states = self._at(X, half_period(other.count).phases)
        space = interpolation(self.degree, chebyshev(other.degree).nodes)
        slopes = states[:, :-3].reshape(-1, 3, self.degree + 1) @ space.T
        states = np.hstack([slopes.reshape(other.count, -1), states[:, -3:]])
        return np.append(states.ravel(), X[-3:])

    def residual(self, X: Array) -> Array:
        """G(X): the equations at all phases, then amplitude and phase of the tip's angle."""
        states, omega, force, s = self.unpack(X)
        A = self._amplitudes(s)[1]
        return self._equations(states, omega, self.rod.derivative(A * states, force) / A)

    def linearised(self, X: Array) -> tuple[Array, CycleJacobian]:
        """G(X) and ∂G/∂X."""
        states, omega, force, s = self.unpack(X)
        a, A = self._amplitudes(s)
        w, odd_part = A * states, np.where(self.odd, states, 0.0)
        R, L, pull = self.rod.linearised(w, force)
        along = (L @ odd_part[..., None])[..., 0]
        # R1(η1, aq) by s is DR1 q/(2a); R2(η1, aq)/a is Lq + s D³R2[q, q, q]/6 + …
        by_square = (along - R / a) / (2 * a**2)
        if abs(s) < SMALL:
            by_square = self.rod.derivative(w, force, *3 * [(odd_part, 0.0)]) / 6
        by_square = np.where(self.odd, by_square, along / (2 * a))
        columns = [self._inertia(states), -(pull / A).real, -by_square.real]
        return self._equations(states, omega, R / A), CycleJacobian(
            omega=omega,
            E=self.rod.mass,
            L=(L * A / A[:, None]).real,
            odd=self.odd,
            columns=np.stack([column.ravel() for column in columns], axis=1),
            first=self._first_harmonic,
        )

    def _equations(self, states: Array, omega: float, R: NDArray[Any]) -> Array:
        defect = omega * self._inertia(states) - R.real
        return np.append(defect, self._first_harmonic @ states.ravel() - [1.0, 0.0])

    def slopes(self, X: Array) -> Array:
        """η1', η2', P', (m, 3, N+1); η1' without its mean, which a load along the rod gives it."""
        slopes = self.unpack(X)[0][:, :-3].reshape(self.count, 3, -1).copy()
        slopes[:, 0] -= slopes[:, 0].mean()
        return slopes

    def shape(self, X: Array, phases: Array) -> tuple[Array, Array, Array]:
        """x, y, θ at phases and all nodes, (len(phases), N+1) each."""
        states = self._at(X, phases) * self._amplitudes(float(X[-1]))[1].real
        up = integrals(self.degree).up.T
        h1, h2, pi = (z.part() for z in strains(*self.rod.split(nilpotent(states)), self.degree))
        theta = pi @ up
        c, sine = np.cos(theta), np.sin(theta)
        return (h1 * c - h2 * sine) @ up, (h1 * sine + h2 * c) @ up, theta

    def sizes(self, X: Array) -> tuple[Array, Array]:
        """Largest defect of the compatibility and largest velocity, by field, (3,) each."""
        states, _, force, s = self.unpack(X)
        A = self._amplitudes(s)[1]
        R = (self.rod.derivative(A * states, force) / A).real

        def fields(values: Array) -> Array:
            largest = np.abs(values.reshape(states.shape)[:, :-3])
            return np.asarray(largest.reshape(len(states), 3, -1).max(axis=(0, 2)))

        return fields(self.residual(X)[:-2]), fields(R)

    def variations(self, X: Array, phases: Array) -> tuple[Array, Array, Array]:
        """ω E y_τ = A y for small perturbations y: E, A at these phases, and the signs that mirror y."""
        w = self._at(X, phases) * self._amplitudes(float(X[-1]))[1].real
        return self.rod.mass, self.rod.linearised(w, float(X[-2]))[1], np.where(self.odd, -1.0, 1.0)

    def _amplitudes(self, s: float) -> tuple[Any, NDArray[Any]]:
        """a, and what multiplies every entry of a state: a or 1."""
        a = np.emath.sqrt(s if abs(s) > LEAST else LEAST)
        return a, np.where(self.odd, a, 1.0)

    def _at(self, X: Array, phases: Array) -> Array:
        """States at other phases, (len(phases), size)."""
        time = half_period(self.count)
        return by_parity({p: time.at(p, phases) for p in set(PARITY)}, self.odd, self.unpack(X)[0])

    def _inertia(self, states: Array) -> Array:
        """E ∂τ of the states."""
        return half_period(self.count).rate(self.odd, states) @ self.rod.mass.T

    @cached_property
    def _first_harmonic(self) -> Array:
        """(2, m·size): states -> cosine and sine coefficient of the first harmonic of ∫₀¹ P du."""
        time, space, n = half_period(self.count), integrals(self.degree), self.degree + 1
        row = np.zeros(self.rod.size)
        row[2 * n : 3 * n], row[-1] = -space.whole @ space.down, 1.0  # P = P(1) − ∫ᵤ¹ P'
        first = time.series["odd"][[0, time.harmonics["odd"].size]]
        return np.asarray(np.kron(first, row))
