"""The characteristic function D(F, λ) of the straight rod: analytic, and zero exactly at its eigenvalues.

A mode is a sum of four exponentials e^{ru}; the four boundary conditions have a solution where their
determinant vanishes. Dimensionless: lengths in L, times in γ2 L⁴/k3, forces in k3/L².
"""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from rodwnl import kernels
from rodwnl.inverse import Complex, Floats, Real

CIRCLE, RADIUS = 16, 0.05  # of Cauchy's formula: points, and radius relative to the nearest singularity
PHASE = 1.0  # by which an exponent may change from the centre of the circle to its rim

# A 4×4 determinant by the minors of its upper and lower two rows: columns above, columns below, sign.
_LAPLACE = (
    (0, 1, 2, 3, 1), (0, 2, 1, 3, -1), (0, 3, 1, 2, 1), (1, 2, 0, 3, 1), (1, 3, 0, 2, -1), (2, 3, 0, 1, 1),
)  # fmt: skip


def exponents(parameters: Floats, force: ArrayLike, eigenvalue: ArrayLike) -> Complex:
    """(r1, r2, −r1, −r2) with Re r1, Re r2 >= 0, on a new last axis."""
    k1, k2, gamma3, _ = parameters
    force, eigenvalue = np.asarray(force), np.asarray(eigenvalue) + 0j
    c4, c2, c0 = kernels.exponent_polynomial(eigenvalue, k1, k2, gamma3, force)
    root = np.sqrt(c2 * c2 - 4 * c4 * c0)
    sign = np.where((np.conj(c2) * root).real > 0, -1, 1)  # no cancellation in −c2 + sign √…
    squares = kernels.squared_exponents(np, sign, eigenvalue, k1, k2, gamma3, force)
    r = np.sqrt(np.stack(np.broadcast_arrays(*squares), axis=-1))
    return np.concatenate([r, -r], axis=-1)


def exponentials(r: Complex, u: float | Real) -> Complex:
    """e^{ru}, divided by e^{r} where Re r > 0: never larger than 1."""
    return np.exp(np.where(r.real > 0, r * (u - 1), r * u))


def boundary_matrix(
    parameters: Floats, force: ArrayLike, eigenvalue: ArrayLike, r: Complex, adjoint: bool = False
) -> Complex:
    """Rows: the four boundary conditions; columns: the exponentials, scaled as by `exponentials`.

    (…, 4, 4) for force and eigenvalue (…) and r (…, 4). With `adjoint`, `eigenvalue` is the adjoint's, λ*.
    """
    k1, k2, _, _ = parameters
    column = kernels.adjoint_boundary_column if adjoint else kernels.boundary_column
    force, eigenvalue = np.asarray(force)[..., None], np.asarray(eigenvalue)[..., None]
    clamp = exponentials(r, 0.0)
    first, second, third, fourth = column(r, exponentials(r, 1.0), eigenvalue, k1, k2, force)
    return np.stack(np.broadcast_arrays(first * clamp, second * clamp, third, fourth), axis=-2)


def characteristic(
    parameters: Floats, force: ArrayLike, eigenvalue: ArrayLike
) -> tuple[Complex, Complex, Real]:
    """(value, growth, size), (…) each, for forces and eigenvalues (…): D = value·e^{growth}.

    The determinant of `boundary_matrix` without the factors that vanish where there is no eigenvalue: λ, r1,
    r2 and (r1² − r2²)². D is even in r1 and in r2, so it is analytic in F and λ; growth = r1 + r2 is what the
    columns were scaled by. size: of the terms that `value` sums.
    """
    eigenvalue = np.asarray(eigenvalue) + 0j
    r = exponents(parameters, force, eigenvalue)
    m = boundary_matrix(parameters, force, eigenvalue, r)
    value, size = np.zeros(r.shape[:-1], complex), np.zeros(r.shape[:-1])
    for i, j, k, n, sign in _LAPLACE:
        upper = m[..., 0, i] * m[..., 1, j], m[..., 0, j] * m[..., 1, i]
        lower = m[..., 2, k] * m[..., 3, n], m[..., 2, n] * m[..., 3, k]
        value += sign * (upper[0] - upper[1]) * (lower[0] - lower[1])
        size += (np.abs(upper[0]) + np.abs(upper[1])) * (np.abs(lower[0]) + np.abs(lower[1]))
    r1, r2 = r[..., 0], r[..., 1]
    spurious = eigenvalue * (r1**2 - r2**2) ** 2 / (r1 * r2)
    return value / spurious, r1 + r2, size / np.abs(spurious)


def characteristic_slopes(parameters: Floats, force: float, eigenvalue: complex) -> tuple[complex, complex]:
    """(∂D/∂F, ∂D/∂λ), divided by e^{growth}, by Cauchy's formula on circles: exact up to round-off.

    The radii are a part of the distance to λ = 0, and to F = 0 and F = k1 (where μ may vanish beyond); they
    are smaller where the modes have short waves, of which D would go through many on the circle.
    """
    turn = np.exp(2j * np.pi * (np.arange(CIRCLE) + 0.5) / CIRCLE)
    steepest = np.max(np.abs(exponents(parameters, force, eigenvalue)))
    radius = min(RADIUS, PHASE / float(steepest))  # r grows no faster than F and λ do, relatively
    reach_force = radius * min(force, parameters[0] - force)
    reach = radius * abs(eigenvalue)
    _, here, _ = characteristic(parameters, force, eigenvalue)

    def slope(force: ArrayLike, eigenvalue: ArrayLike, reach: float) -> complex:
        value, growth, _ = characteristic(parameters, force, eigenvalue)
        return complex(np.mean(value * np.exp(growth - here) / turn) / reach)

    return (
        slope(force + reach_force * turn, eigenvalue, reach_force),
        slope(force, eigenvalue + reach * turn, reach),
    )
