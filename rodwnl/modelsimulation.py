"""The full nonlinear rod of any law in time: E w_t = R(w, F) as `strainform` gives it.

E is constant and singular in the rows of the clamp and of the tip, whose conditions are algebraic; SUNDIALS'
IDA integrates the whole with the exact Jacobian of R. What is kept, read and written is as for the plain
rod (`simulation`), of which this is the other integrator.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from rodwnl.collocation import chebyshev
from rodwnl.emittedlaw import emitted_law
from rodwnl.errors import ComputationError
from rodwnl.nilpotent import nilpotent
from rodwnl.normalform import DiscreteRod
from rodwnl.parameters import RodParameters
from rodwnl.storage import require
from rodwnl.strainform import integrals

Array = NDArray[np.float64]

ATOL = 1e-2  # absolute tolerance over the relative one, as for the plain rod
MOST_STEPS = 20
SETTLED = 1e-9  # relative Newton step of a consistent start: the error left is its square, or round-off


@dataclass(frozen=True)
class LawForm:
    """A rod under one force on Chebyshev points: the counterpart of `angleform.AngleForm`, with states as
    `normalform` strings them, (3(N+1) + 3,).
    """

    rod: DiscreteRod
    force: float

    @property
    def size(self) -> int:
        return self.rod.size

    @property
    def nodes(self) -> Array:
        return integrals(self.rod.degree).nodes

    @cached_property
    def straight(self) -> Array:
        return np.asarray(self.rod.straight(self.force))

    @cached_property
    def algebraic(self) -> NDArray[np.intp]:
        """The rows without time derivatives: v = 0 at the clamp, the load at the tip."""
        n = self.rod.degree + 1
        return np.array([0, n, 2 * n, 3 * n, 3 * n + 1, 3 * n + 2])

    def perturbed(self, epsilon: float) -> Array:
        """x that of the straight rod, y = ε sin(πu/2), θ = ε sin(πu/2), but for what clamp and tip demand."""
        grid, wave = chebyshev(self.rod.degree), np.pi / 2 * self.nodes
        theta, slope = epsilon * np.sin(wave), epsilon * np.pi / 2 * np.cos(wave)
        x_u = self._strains(self.straight)[0]
        c, s = np.cos(theta), np.sin(theta)
        z = np.stack([x_u * c + slope * s, slope * c - x_u * s, slope])
        return self._consistent(np.append(z @ grid.first.T, z[:, -1]))

    def _consistent(self, guess: Array) -> Array:
        """The state with the same ∫₀ᵘ z that obeys clamp and tip, by Newton's method."""
        state = guess
        for _ in range(MOST_STEPS):
            defect = self.rod.mass @ (state - guess)
            defect[self.algebraic] = self.rod.derivative(state, self.force)[self.algebraic]
            step = np.linalg.solve(self._bordered(state), defect)
            state = state - step
            if np.abs(step).max() <= SETTLED * (1 + np.abs(state).max()):
                return state
        raise ComputationError(
            "no start was found that obeys the conditions at clamp and tip; a smaller perturbation may help"
        )

    def rate(self, state: Array) -> Array:
        """w_t at a consistent state: E w_t = R, and the derivative of the algebraic rows vanishes."""
        right = self.rod.derivative(state, self.force)
        right[self.algebraic] = 0.0
        return np.asarray(np.linalg.solve(self._bordered(state), right))

    def _bordered(self, state: Array) -> Array:
        matrix = self.rod.mass.copy()
        matrix[self.algebraic] = self.rod.jacobian(state, self.force)[self.algebraic]
        return np.asarray(matrix)

    def solver(self, state: Array, rtol: float) -> Any:
        """IDA, at t = 0 in this consistent state."""
        sundae = require("sksundae.ida", "simulate")
        E, rod, force = self.rod.mass, self.rod, self.force

        def residual(t: float, w: Array, w_t: Array, out: Array) -> None:
            out[:] = E @ w_t - rod.derivative(w, force)

        def jacobian(t: float, w: Array, w_t: Array, out: Array, c: float, J: Array) -> None:
            J[:] = c * E - rod.jacobian(w, force)

        solver = sundae.IDA(residual, jacfn=jacobian, rtol=rtol, atol=ATOL * rtol, max_num_steps=100_000)
        solver.init_step(0.0, state, self.rate(state))
        return solver

    def fields(self, states: Array) -> tuple[Array, Array, Array, Array]:
        """x, y, θ and the axial force F1 at all N + 1 nodes, (…, N+1) each."""
        up = integrals(self.rod.degree).up.T
        h1, h2, pi = self._strains(states)
        theta = pi @ up
        c, s = np.cos(theta), np.sin(theta)
        stress = self.rod.law.stress(h1, h2, pi)[0]
        return (h1 * c - h2 * s) @ up, (h1 * s + h2 * c) @ up, theta, stress

    def tip(self, states: Array) -> tuple[Array, Array, Array]:
        """x, y, θ at u = 1, each of shape (…)."""
        x, y, theta, _ = self.fields(states)
        return x[..., -1], y[..., -1], theta[..., -1]

    def tail(self, states: Array) -> float:
        """The last three Chebyshev coefficients of ∫₀ᵘ z, without the straight rod's, over the largest."""
        values = (states - self.straight) @ self.rod.mass.T
        values = values[..., :-3].reshape(-1, self.rod.degree + 1)
        series = np.abs(np.fft.rfft(np.concatenate([values, values[:, -2:0:-1]], axis=1)))
        series = series.reshape(-1, 3, self.rod.degree + 1)
        size = series.max(axis=(0, 2))
        return float((series[..., -3:].max(axis=(0, 2)) / np.where(size > 0, size, 1.0)).max())

    def tip_residual(self, states: Array) -> float:
        """The largest stress minus load at the tip, over the force."""
        return float(np.abs(self.rod.derivative(states, self.force)[..., -3:]).max() / self.force)

    def tip_load(self, theta: Array) -> tuple[Any, Any]:
        """The load on a tip at rest along e1 and e2, over the force."""
        along, across, _ = self.rod.law.load(theta, (0.0, 0.0, 0.0), self.force)
        return along / self.force, across / self.force

    def _strains(self, states: Array) -> tuple[Array, Array, Array]:
        ends, slopes = self.rod.split(nilpotent(states))
        down = integrals(self.rod.degree).down.T
        h1, h2, pi = (end.part() - w.part() @ down for end, w in zip(ends, slopes, strict=True))
        return h1, h2, pi


def law_form(rod: RodParameters, force: float, degree: int) -> LawForm:
    """Any rod under this force, on Chebyshev points of this degree."""
    return LawForm(DiscreteRod(emitted_law(rod), degree), force)
