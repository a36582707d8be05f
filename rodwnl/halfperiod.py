"""Fields known at equidistant phases of half a period: their harmonics, derivatives and values elsewhere."""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


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

    def rate(self, odd: NDArray[np.bool_], states: Array) -> Array:
        """∂τ of the states (m, n), whose entries are odd or even."""
        return by_parity(self.derivative, odd, states)


def by_parity(matrices: dict[str, Array], odd: NDArray[np.bool_], states: Array) -> Array:
    """Every entry of the states (m, n) taken through the matrix (k, m) of its parity, odd or even: (k, n)."""
    return np.asarray(np.where(odd, matrices["odd"] @ states, matrices["even"] @ states))


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
