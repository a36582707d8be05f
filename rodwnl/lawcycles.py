"""Periodic orbits of the full rod of any law, by Fourier × Chebyshev collocation of E w_t = R(w, F).

Written on `strainform` alone, so that near onset it checks thresholds, α and β without any expansion. The
first harmonic of the tip's displacement y(1, t) is given, a cos ωt; the force and ω are found. Lengths in L,
times in γ2 L⁴/k3, forces in k3/L².
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from rodwnl.errors import ComputationError
from rodwnl.nilpotent import nilpotent
from rodwnl.normalform import DiscreteRod, NormalForm
from rodwnl.strainform import RodLaw, tip

Array = NDArray[np.float64]

MOST_STEPS = 30
SETTLED = 1e-11  # relative Newton step: below it only round-off changes the orbit


@dataclass(frozen=True)
class LawCycle:
    """One orbit: states (m, 3(N+1) + 3) at m phases of the period, as `normalform` strings them.

    amplitude: of the first harmonic of y(1, t). tip: y(1, t) at the phases.
    """

    amplitude: float
    force: float
    omega: float
    states: Array
    tip: Array


def law_cycle(law: RodLaw, onset: NormalForm, amplitude: float, count: int = 12) -> LawCycle:
    """The orbit of this amplitude on the branch from a Hopf point, with `count` (even) phases.

    Raises ComputationError where Newton's method does not converge.
    """
    rod = DiscreteRod(law, onset.degree)
    phases = 2 * np.pi * np.arange(count) / count
    waves = np.exp(1j * phases)[:, None] * onset.mode
    states = rod.straight(onset.force) + amplitude * waves.real
    force, omega = onset.force, onset.omega
    D, harmonic = _derivative(count), 2 * np.exp(-1j * phases) / count
    size = rod.size
    for _ in range(MOST_STEPS):
        R, L, pull = rod.linearised(states, force)
        residual = omega * D @ states @ rod.mass.T - R
        matrix = np.zeros((count * size + 2, count * size + 2))
        matrix[:-2, :-2] = np.kron(omega * D, rod.mass)
        tips = np.empty(count)
        for j, w in enumerate(states):
            rows = slice(j * size, (j + 1) * size)
            matrix[rows, rows] -= L[j]
            row = rod.tip_row(w, force)
            matrix[-2, rows], matrix[-1, rows] = harmonic[j].real * row, harmonic[j].imag * row
            tips[j] = tip(*rod.split(nilpotent(w)), onset.degree)[1].part()
        matrix[:-2, -2] = (D @ states @ rod.mass.T).ravel()
        matrix[:-2, -1] = -pull.ravel()
        first = harmonic @ tips
        right = np.append(residual.ravel(), [first.real - amplitude, first.imag])
        step = np.linalg.solve(matrix, right)
        states = states - step[:-2].reshape(count, size)
        omega, force = omega - step[-2], force - step[-1]
        if abs(step[-2]) <= SETTLED * omega and abs(step[-1]) <= SETTLED * force:
            return LawCycle(amplitude, float(force), float(omega), states, tips)
    raise ComputationError(f"no orbit of amplitude {amplitude:g} was found near force {onset.force:.10g}")


def _derivative(count: int) -> Array:
    """d/dτ at `count` (even) equidistant phases (Trefethen, Spectral Methods in MATLAB, chapter 3)."""
    j = np.arange(count)
    distance = j[:, None] - j
    with np.errstate(divide="ignore"):
        D = 0.5 * (-1.0) ** distance / np.tan(np.pi * distance / count)
    np.fill_diagonal(D, 0.0)
    return np.asarray(D)
