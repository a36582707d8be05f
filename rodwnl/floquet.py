"""Stability of periodic orbits: Floquet multipliers of the full nonlinear rod.

A perturbation y of the slopes and of the strains at the tip obeys ω E y_τ = A(τ) y, A = ∂R/∂w along the
orbit. It is carried over half a period by the Radau IIA method of order 5 (Hairer & Wanner, Solving Ordinary
Differential Equations II, section IV.8), which damps the stiff modes as the rod does and takes the singular E
in its stride, and is then mirrored. The orbit maps to itself under this half-period map S Φ(π), so that one
of its eigenvalues ρ is 1; the multipliers of the whole period are ρ².
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import reduce
from typing import Any

import numpy as np
from numpy.typing import NDArray

from rodwnl.orbits import Cycle, needed, regridded

STEPS = 24  # over half a period
TAIL = 1e-5  # of the orbit in u: what a coarser grid makes of multipliers is about a thousand times smaller

_R = np.sqrt(6.0)
_NODES = np.array([(4 - _R) / 10, (4 + _R) / 10, 1.0])
_INVERSE = np.linalg.inv(
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

    On a grid in u as coarse as TAIL allows. The algebraic conditions at the tip add zeros.
    """
    count, degree = cycle.system.count, cycle.system.degree
    coarse = Cycle(*regridded(cycle, (count, min(degree, needed(degree, cycle.tails[1], TAIL)))))
    half = np.linalg.eigvals(half_period_map(coarse, steps))
    trivial = int(np.argmin(np.abs(half - 1)))
    others = np.delete(half, trivial)
    return Multipliers(others[np.argsort(-np.abs(others))], float(np.abs(half[trivial] - 1)))


def half_period_map(cycle: Cycle, steps: int) -> NDArray[np.float64]:
    """S Φ(π): the unknowns of a perturbation -> the same half a period later, mirrored; (n, n)."""
    stages = np.pi / steps * (np.arange(steps)[:, None] + _NODES)
    E, A, mirror = cycle.system.variations(cycle.X, stages.ravel())
    return np.asarray(mirror[:, None] * carried(E, A, cycle.omega))


def carried(E: NDArray[Any], A: NDArray[np.float64], omega: float) -> NDArray[np.float64]:
    """Φ(π), (n, n), of ω E y_τ = A y from A (3·steps, n, n) at the phases of the stages.

    A step takes y to its last stage Y3. With B the inverse of the method's matrix,

        Σ_j B_ij E Y_j − (h/ω) A_i Y_i = (Σ_j B_ij) E y,    i = 1, 2, 3,

    so that Y1 = K (Σ_j B_1j y − B_12 Y2 − B_13 Y3), K = (B_11 E − (h/ω) A_1)⁻¹ E, and only E K is needed to
    eliminate it: half the work of the three stages together. All steps at once.
    """
    n, steps = len(E), len(A) // 3
    A = A.reshape(steps, 3, n, n) * (np.pi / steps / omega)
    B, b = _INVERSE, _INVERSE.sum(axis=1)
    EK = E @ np.linalg.solve(B[0, 0] * E - A[:, 0], np.broadcast_to(E, (steps, n, n)))

    def left(i: int, j: int) -> NDArray[np.float64]:
        return np.asarray(B[i, j] * E - B[i, 0] * B[0, j] * EK - (A[:, i] if i == j else 0))

    def right(i: int) -> NDArray[np.float64]:
        return np.asarray(b[i] * E - B[i, 0] * b[0] * EK)

    # Y2 = second (y, −Y3)
    second = np.linalg.solve(left(1, 1), np.concatenate([right(1), left(1, 2)], axis=2))
    carry, back = np.split(left(2, 1) @ second, 2, axis=2)
    maps = np.linalg.solve(left(2, 2) - back, right(2) - carry)
    return np.asarray(reduce(lambda out, step: step @ out, maps, np.eye(n)))
