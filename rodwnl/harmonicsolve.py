"""Linear systems with the Jacobian of a periodic orbit, solved one harmonic at a time.

Newton's method needs (ωE∂τ − L(τ)) x = r, bordered by ω, F, s and three conditions. L = ∂R/∂w swings about
its mean L̄ over the period, less so the smaller the orbit, and L̄ mixes no fields of even and odd harmonics.
With L̄ in the place of L the harmonics of x decouple,

    (iωk E − L̄) x_k = r_k,

and GMRES (Saad & Schultz 1986, doi:10.1137/0907058), preconditioned by this, needs 10 to 50 products with the
exact Jacobian: a matrix of all phases together is never formed. Harmonics 0 and 1 and the border are taken
together, with all that L couples among them: at a Hopf point iωE − L̄ is singular.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.sparse.linalg import LinearOperator, gmres

from rodwnl.continuation import ConvergenceError
from rodwnl.halfperiod import half_period

Array = NDArray[np.float64]
Map = Callable[[Array], Array]

ACCURACY = 1e-9  # of a solution: its preconditioned residual, relative to that of 0
MOST_STEPS = 200


@dataclass(frozen=True)
class CycleJacobian:
    """∂G/∂X of `cycles` at m phases with states of n entries, as a matrix (m n + 2, m n + 3).

    E (n, n); L (m, n, n): of η1, η2, P as unknowns; odd (n,): of every entry of a state; columns (m n, 3):
    derivatives by ω, F, s; first (2, m n): states -> the conditions on amplitude and phase.
    """

    omega: float
    E: Array
    L: Array
    odd: NDArray[np.bool_]
    columns: Array
    first: Array

    def __matmul__(self, x: Array) -> Array:
        states = x[:-3].reshape(self.L.shape[:2])
        rate = half_period(len(states)).rate(self.odd, states)
        rows = self.omega * rate @ self.E.T - (self.L @ states[..., None])[..., 0]
        return np.concatenate([rows.ravel() + self.columns @ x[-3:], self.first @ x[:-3]])

    def bordered(self, row: Array) -> Map:
        """b -> the x with (this; row) x = b. Raises ConvergenceError where GMRES does not arrive."""
        try:
            near = _MeanInverse(self, row)
        except np.linalg.LinAlgError as error:
            raise ConvergenceError(f"the mean Jacobian of an orbit is no help: {error}") from None
        return lambda b: solved(lambda x: np.append(self @ x, row @ x), near, b)


class _MeanInverse:
    """About the inverse of a bordered Jacobian: harmonics above 1 by the mean of L, the rest exactly."""

    def __init__(self, J: CycleJacobian, row: Array) -> None:
        (m, n, _), phases, mean = J.L.shape, half_period(len(J.L)).phases, J.L.mean(axis=0)
        self.higher = []
        for fields, lowest in ((~J.odd, 2), (J.odd, 3)):
            k, on = np.arange(lowest, m + 1, 2), np.ix_(fields, fields)
            wave = np.exp(1j * np.outer(k, phases))
            to = wave.conj() * np.where(k < m, 2, 1)[:, None] / m
            rate = 1j * J.omega * np.where(k < m, k, 0)  # at these phases ∂τ of cos mτ is 0
            inverse = np.linalg.inv(rate[:, None, None] * J.E[on] - mean[on])
            self.higher.append((fields, to, inverse, wave.T))
        # Harmonics 0 and 1: coefficients of 1, cos τ, sin τ, each of the fields that have it
        self.waves = np.stack([np.ones(m), np.cos(phases), np.sin(phases)])
        self.to = self.waves * [[1 / m], [2 / m], [2 / m]]
        self.kept = np.concatenate([~J.odd, J.odd, J.odd])
        products = (self.to[:, None] * self.waves).reshape(9, m)
        coupled = (products @ J.L.reshape(m, -1)).reshape(3, 3, n, n).swapaxes(1, 2).reshape(3 * n, 3 * n)
        turn = np.array([[0, 0, 0], [0, 0, 1], [0, -1, 0]])  # ∂τ
        block = (J.omega * np.kron(turn, J.E) - coupled)[np.ix_(self.kept, self.kept)]
        right = (self.to @ J.columns.reshape(m, -1)).reshape(3 * n, 3)[self.kept]
        rows = np.vstack([J.first, row[:-3]]).reshape(3, m, n)
        below = (self.waves @ rows).reshape(3, -1)[:, self.kept]
        corner = np.vstack([np.zeros((2, 3)), row[-3:]])
        self.low = np.linalg.inv(np.block([[block, right], [below, corner]]))

    def __call__(self, b: Array) -> Array:
        m = self.waves.shape[1]
        states = b[:-3].reshape(m, -1)
        out = np.empty_like(states)
        for fields, to, inverse, wave in self.higher:
            amplitudes = inverse @ (to @ states[:, fields])[..., None]
            out[:, fields] = (wave @ amplitudes[..., 0]).real
        low = self.low @ np.append((self.to @ states).ravel()[self.kept], b[-3:])
        coefficients = np.zeros(self.kept.size)
        coefficients[self.kept] = low[:-3]
        return np.append(out + self.waves.T @ coefficients.reshape(3, -1), low[-3:])


def solved(matrix: Map, near: Map, b: Array) -> Array:
    """x with matrix(x) = b, both linear, where near is about the inverse of matrix.

    Raises ConvergenceError where MOST_STEPS do not suffice.
    """
    start = near(b)
    if not np.isfinite(start).all():
        raise ConvergenceError("the linear equations of an orbit are singular")
    product = LinearOperator((b.size, b.size), matvec=lambda x: near(matrix(x)), dtype=b.dtype)
    x, left = gmres(product, start, rtol=ACCURACY, atol=0.0, restart=MOST_STEPS, maxiter=1)
    if left:
        raise ConvergenceError(f"the linear equations of an orbit were not solved in {MOST_STEPS} steps")
    return np.asarray(x)
