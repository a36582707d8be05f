"""The inverse of the linear operator: an integral operator that gives all leading eigenvalues at once.

Lengths in L, times in γ2 L⁴/k3, forces in k3/L²; ν = 1 − F/k1, μ = k2 ν + F. The eigenvalue problem
(paper: eq:linearization) is, with H = Y' − νΘ,

    λ Y = k2 H' − F Θ',    γ3 λ Θ = Θ'' + μ H,    Y(0) = Θ(0) = H(1) = Θ'(1) = 0.

Discretised by integration and not by differentiation it stays well conditioned for every stiffness.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray

from rodwnl.errors import ComputationError
from rodwnl.quadrature import gauss_legendre

Real = NDArray[np.float64]
Complex = NDArray[np.complex128]
Floats = tuple[float, float, float, float]  # k1, k2, gamma3, gamma1

KEPT = 12  # eigenvalues of least modulus that are returned
MOST_NODES = 160


def inverse_operator(parameters: Floats, force: ArrayLike, count: int) -> NDArray[np.inexact]:
    """K = M⁻¹Γ on `count` nodes, (…, 2·count, 2·count) for forces (…): eigenvalues 1/λ, vectors Y, √γ3 Θ.

    Given a = λY and b = λΘ: k2 H − FΘ = −∫ᵤ¹ a − FΘ(1), so with φ = Θ − Θ(1)

        k2 H = Fφ − ∫ᵤ¹ a,    φ'' + (μF/k2) φ = γ3 b + (μ/k2) ∫ᵤ¹ a,    φ(1) = φ'(1) = 0.

    This is a Volterra equation for h = φ'' (φ = ∫ᵤ¹∫ᵤ¹ h), so it is solvable for every force: M has no
    kernel, no eigenvalue passes through 0, there is no steady crossing. Then Θ = −∫₀ᵘ∫ᵤ¹ h and Y = ∫₀ᵘ
    (H + νΘ). Analytic in the force, which may be complex.
    """
    k1, k2, gamma3, _ = parameters
    nodes = gauss_legendre(count)
    rise, fall = nodes.from_clamp, nodes.to_tip
    force = np.asarray(force)[..., None, None]
    nu = 1 - force / k1
    stiff = nu + force / k2  # μ/k2
    root = np.sqrt(gamma3)
    phi, theta = fall @ fall, -rise @ fall
    h_of_b = np.linalg.inv(np.eye(count) + stiff * force * phi)
    h_of_a = h_of_b @ (stiff * fall)
    y = rise @ (force / k2 * phi + nu * theta)
    rows = (
        np.concatenate([y @ h_of_a - rise @ fall / k2, root * y @ h_of_b], axis=-1),
        np.concatenate([root * theta @ h_of_a, gamma3 * theta @ h_of_b], axis=-1),
    )
    return np.concatenate(rows, axis=-2)


def leading_eigenvalues(parameters: Floats, force: Real, kept: int = KEPT) -> tuple[Complex, Complex]:
    """The `kept` eigenvalues λ of least modulus and their slopes dλ/dF, (n, kept) each, for forces (n,).

    Raises ComputationError where the shear waves of a soft rod are too short for MOST_NODES.
    """
    eigenvalue = np.empty((len(force), kept), dtype=complex)
    slope = np.empty((len(force), kept), dtype=complex)
    counts = np.array([max(_nodes_for(parameters, f), 2 * kept) for f in force])
    for count in np.unique(counts):
        same = counts == count
        eigenvalue[same], slope[same] = _leading(parameters, force[same], int(count), kept)
    return eigenvalue, slope


def unstable_count(parameters: Floats, force: float) -> int:
    """Number of eigenvalues with Re λ > 0, on half as many nodes again as `leading_eigenvalues` takes."""
    count = 3 * _nodes_for(parameters, force) // 2
    inverse = np.linalg.eigvals(inverse_operator(parameters, force, count))
    resolved = inverse[np.argsort(-np.abs(inverse))[: count // 2]]
    return int(np.sum(resolved.real > 0))


def _leading(parameters: Floats, force: Real, count: int, kept: int) -> tuple[Complex, Complex]:
    step = 1e-100  # complex step: Im K(F + i·step)/step is the derivative of K to round-off
    K = inverse_operator(parameters, force + 1j * step, count)
    return eigenvalues_and_slopes(K.real, K.imag / step, kept)


def eigenvalues_and_slopes(operator: Real, by_force: Real, kept: int) -> tuple[Complex, Complex]:
    """λ and dλ/dF of the `kept` largest eigenvalues 1/λ of K, (…, kept) each, from K and K' = dK/dF."""
    inverse, vectors = np.linalg.eig(operator)
    # κ = 1/λ:    κ' = (V⁻¹ K' V)_jj,    λ' = −λ² κ'
    slope = np.einsum("...ij,...ji->...i", np.linalg.inv(vectors), by_force @ vectors)
    order = np.argsort(-np.abs(inverse), axis=-1, kind="stable")[..., :kept]
    inverse, slope = np.take_along_axis(inverse, order, -1), np.take_along_axis(slope, order, -1)
    eigenvalue: Complex = 1 / inverse.astype(np.complex128)
    moved: Complex = -slope * eigenvalue**2
    moved.imag[eigenvalue.imag == 0] = 0  # K is real: what is real stays real; V⁻¹ is rounded as complex
    return eigenvalue, moved


def _nodes_for(parameters: Floats, force: float) -> int:
    """Nodes that resolve the operator: φ oscillates with wave number √(μF/k2). A multiple of 8."""
    k1, k2, _, _ = parameters
    wave = np.sqrt((1 - force / k1 + force / k2) * force)
    count = 24 + 8 * np.floor(wave / 16)
    if count > MOST_NODES:
        raise ComputationError(
            f"at F = {force:g} the shear waves of the rod have wave number {wave:.3g}: {count:.3g} nodes "
            f"would be needed, more than {MOST_NODES}; search a smaller range (max_force)"
        )
    return int(count)
