"""Stability of periodic orbits: Floquet multipliers of the full nonlinear rod.

A perturbation y of the slopes and of the strains at the tip obeys ω E y_τ = A(τ) y, A = ∂R/∂w along the
orbit. It is carried over half a period by the Radau IIA method of order 5 (Hairer & Wanner, Solving Ordinary
Differential Equations II, section IV.8), which damps the stiff modes as the rod does and takes the singular E
in its stride, and is then mirrored. The orbit maps to itself under this half-period map S Φ(π), so that one
of its eigenvalues ρ is 1; the multipliers of the whole period are ρ².
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from rodwnl.orbits import Cycle

STEPS = 24  # over half a period

_R = np.sqrt(6.0)
_NODES = np.array([(4 - _R) / 10, (4 + _R) / 10, 1.0])
_WEIGHTS = np.array(
    [
        [(88 - 7 * _R) / 360, (296 - 169 * _R) / 1800, (-2 + 3 * _R) / 225],
        [(296 + 169 * _R) / 1800, (88 + 7 * _R) / 360, (-2 - 3 * _R) / 225],
        [(16 - _R) / 36, (16 + _R) / 36, 1 / 9],
    ]
)


@dataclass(frozen=True)
class Multipliers:
    """half: eigenvalues ρ of the half-period map except the trivial one, largest first, complex.

    error: |ρ − 1| of the trivial one, which measures the integration.
    """

    half: NDArray[np.complex128]
    error: float

    @property
    def full(self) -> NDArray[np.complex128]:
        """Multipliers of the whole period, ρ², without the trivial one."""
        return np.asarray(self.half**2)

    @property
    def stable(self) -> bool:
        """Whether every perturbation decays, up to a shift along the orbit."""
        return bool(np.abs(self.half[0]) < 1)


def multipliers(cycle: Cycle, steps: int = STEPS) -> Multipliers:
    """The Floquet multipliers of an orbit, with this number of Radau steps over half a period.

    The algebraic conditions at the tip add zeros.
    """
    half = np.linalg.eigvals(half_period_map(cycle, steps))
    trivial = int(np.argmin(np.abs(half - 1)))
    others = np.delete(half, trivial)
    return Multipliers(others[np.argsort(-np.abs(others))], float(np.abs(half[trivial] - 1)))


def half_period_map(cycle: Cycle, steps: int) -> NDArray[np.float64]:
    """S Φ(π): the unknowns of a perturbation -> the same half a period later, mirrored; (n, n)."""
    stages = np.pi / steps * (np.arange(steps)[:, None] + _NODES)
    E, A, mirror = cycle.system.variations(cycle.X, stages.ravel())
    return np.asarray(mirror[:, None] * carried(E, A, cycle.omega))


def carried(E: NDArray[Any], A: NDArray[np.float64], omega: float) -> NDArray[np.float64]:
    """Φ(π), (n, n), of ω E y_τ = A y from A (3·steps, n, n) at the phases of the stages."""
    n, steps = len(E), len(A) // 3
    A = A.reshape(steps, 3, n, n)
    # E (Y_i − y) = (h/ω) Σ_j a_ij A_j Y_j at the three stages; the last stage is the new y
    stages = np.kron(np.eye(3), E) - (np.pi / steps / omega) * np.einsum(
        "ij,tjab->tiajb", _WEIGHTS, A
    ).reshape(steps, 3 * n, 3 * n)
    out = np.eye(n)
    for stage in stages:
        out = np.linalg.solve(stage, np.tile(E @ out, (3, 1)))[-n:]
    return out
