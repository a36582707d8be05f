"""α and β of many rods at their thresholds: the emitted formulas on arrays (rods, nodes).

What `rodwnl.modes` and `rodwnl.coefficients` do for one rod, arranged so that nothing is solved rod by rod:

* Gauss–Legendre nodes are symmetric, u_i + u_{N+1−i} = 1, so of each exponent only e^{−ru} at the nodes is
  needed: read backwards it is e^{r(u−1)}. The conjugate of the adjoint mode has the same exponents.
* The second-order problem (k1 + cT) w = f, T = ∫₀ᵘ∫ᵤ¹, is diagonal in the eigenvectors of T, which are those
  of a fixed symmetric matrix (`Basis`): X2 costs two products with real matrices.
* Every indefinite integral is a product with one real matrix, for all rods at once.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import lru_cache
from typing import Any

import numpy as np

from rodwnl import kernels
from rodwnl.batch_characteristic import Complex, Real, exponents
from rodwnl.quadrature import gauss_legendre

FEWEST, MORE, MOST = 20, 8, 400  # nodes
BLOCK = 8192  # rods times nodes
EPS = float(np.finfo(float).eps)
ROUNDING = 16  # rounding errors of an integrand, in units of EPS: twice what was seen against the exact route


@dataclass(frozen=True)
class Basis:
    """N nodes u with weights (N,), and matrices (N, N) that act on rows.

    f @ to_tip is ∫ᵤ¹ f, and ((f @ forth) * values) @ back is Tf = ∫₀ᵘ∫ᵤ¹ f. The nodes integrate the product
    of two polynomials of degree < N exactly, so integration by parts holds: with A = ∫₀ᵘ and W =
    diag(weights), W∫ᵤ¹ = AᵀW. Hence T = A W⁻¹AᵀW, and W^½ T W^−½ is symmetric and positive: its
    eigenvectors are orthogonal.
    """

    u: Real
    weights: Real
    to_tip: Real
    values: Real
    forth: Real
    back: Real


@lru_cache(maxsize=64)
def basis(count: int) -> Basis:
    """`count` nodes; the arrays are shared, so nobody may write to them."""
    nodes = gauss_legendre(count)
    root = np.sqrt(nodes.weights)
    half = root[:, None] * nodes.from_clamp / root
    values, vectors = np.linalg.eigh(half @ half.T)
    to_tip = np.ascontiguousarray(nodes.to_tip.T)
    return Basis(nodes.u, nodes.weights, to_tip, values, root[:, None] * vectors, vectors.T / root)


@dataclass(frozen=True)
class Coefficients:
    """alpha, beta (m,), and what is known about them.

    residual (m,): the largest of three relative defects: the boundary conditions of the mode and of the
    adjoint, of which three of four were used, and P2(0) = k1 X2'(0), the law of the axial force, which
    comes from the balance of forces. rounding (m,): estimated relative rounding error of α and β, from the
    cancellation in their integrals.
    """

    alpha: Complex
    beta: Complex
    residual: Real
    rounding: Real


def coefficients(parameters: tuple[Real, Real, Real, Real], force: Real, omega: Real) -> Coefficients:
    """At thresholds (force, omega), (m,), of rods (k1, k2, gamma3, gamma1), (m,) each.

    Where an exponent is so large that more than MOST nodes were needed: NaN with an infinite residual.
    """
    k1, k2, gamma3, gamma1 = parameters
    r = exponents((k1, k2, gamma3), force, omega)
    largest = np.maximum(np.abs(r).max(axis=1), np.sqrt(2 * omega * gamma1 / k1))
    counts = FEWEST + MORE * np.ceil(np.minimum(largest, MOST) / 4).astype(int)
    alpha, beta = np.full((2, len(force)), np.nan + 0j)
    residual, rounding = np.full((2, len(force)), np.inf)
    for count in np.unique(counts[counts <= MOST]).tolist():
        same = np.flatnonzero(counts == count)
        size = max(BLOCK // count, 1)
        for part in (same[i : i + size] for i in range(0, len(same), size)):
            rod = k1[part, None], k2[part, None], gamma3[part, None], gamma1[part, None]
            alpha[part], beta[part], residual[part], rounding[part] = _evaluate(
                *rod, force[part, None], omega[part, None], r[part], basis(count)
            )
    return Coefficients(alpha, beta, residual, rounding)


def _evaluate(
    k1: Real, k2: Real, gamma3: Real, gamma1: Real, force: Real, omega: Real, r: Complex, nodes: Basis
) -> tuple[Complex, Complex, Real, Real]:
    """α, β, residual and rounding, (m,); r is (m, 2), the other arrays are (m, 1)."""
    lam = 1j * omega
    end, decay = np.exp(-r), np.exp(-r[..., None] * nodes.u)
    Theta_Y, H_Y = kernels.mode_amplitudes(r, lam, k1, k2, force)

    tip, clamp, mode_defect = _amplitudes(kernels.boundary_column, r, end, lam, k1, k2, force)
    even, odd = _sums(tip, clamp, decay)
    Y, Theta_u = even[:, 0] + even[:, 1], _weighted(r * Theta_Y, even)
    Theta, H = _weighted(Theta_Y, odd), _weighted(H_Y, odd)
    Theta_tip = np.sum(Theta_Y * (tip - clamp * end), axis=1, keepdims=True)
    fields = Y, Theta, Theta_u, H

    tip, clamp, adjoint_defect = _amplitudes(kernels.adjoint_boundary_column, r, end, lam, k1, k2, force)
    even, odd = _sums(tip, clamp, decay)
    Psi = (even[:, 0] + even[:, 1]).conj(), _weighted(Theta_Y, odd).conj()

    # (k1 + cT) X2'' = f + cbu,    X2 = bu − T X2'' (paper: eq:longitudinalODE)
    c, b = kernels.X2_operator(lam, gamma1), kernels.X2_tip_slope(Theta_tip, k1, force)
    forcing = kernels.X2_forcing(*fields, lam, k1, k2, gamma1, force)
    w = _times(forcing + c * b * nodes.u, nodes.forth) / (k1 + c * nodes.values)
    X2 = b * nodes.u - _times(w * nodes.values, nodes.back)
    # P = −∫ᵤ¹ P', because P(1) = 0
    P2_slope = kernels.P2_slope(*fields, X2, lam, k2, gamma1)
    P0 = -_times(kernels.P0_slope(*fields, lam, k2, gamma1), nodes.to_tip)
    P2 = -_times(P2_slope, nodes.to_tip)

    g1 = kernels.g1(*fields, X2, P0, P2, lam, k1, k2, gamma1)
    g2 = kernels.g2(nodes.u, Theta_u, Theta_tip, lam, k1, k2)
    g3 = kernels.g3(Theta, Theta_u, H, P0, P2, k1, k2, force)
    g4 = kernels.g4(Theta, H, Theta_tip, k1, k2, force)
    integrands = (
        kernels.alpha_integrand(*Psi, g1, g3),
        kernels.beta_integrand(*Psi, g2, g4),
        kernels.norm_integrand(*Psi, Y, Theta, gamma3),
    )
    integrals = [f @ nodes.weights for f in integrands]
    cancellation = [np.abs(f) @ nodes.weights / np.abs(i) for f, i in zip(integrands, integrals, strict=True)]
    rounding = ROUNDING * EPS * (np.maximum(*cancellation[:2]) + cancellation[2])

    # P2(0) = k1X2'(0) = k1(b − ∫X2''): what is missing beyond the rounding of the terms
    slope, of_w, k1b = P2_slope @ nodes.weights, nodes.back @ nodes.weights, (k1 * b)[:, 0]
    lack = np.abs(slope + k1b - k1[:, 0] * (w @ of_w))
    noise = ROUNDING * EPS * (np.abs(k1b) + k1[:, 0] * (np.abs(w) @ np.abs(of_w)))
    tension_defect = np.maximum(lack - noise, 0) / (np.abs(P2_slope) @ nodes.weights)
    residual = np.max([mode_defect, adjoint_defect, tension_defect], axis=0)
    return integrals[0] / integrals[2], integrals[1] / integrals[2], residual, rounding


def _amplitudes(
    column: Callable[..., Any], r: Complex, end: Complex, lam: Complex, k1: Real, k2: Real, force: Real
) -> tuple[Complex, Complex, Real]:
    """(tip, clamp), (m, 2) each, of Y = Σ tip e^{r(u−1)} + clamp e^{−ru} with Y(1) = 1, and a defect.

    With θ = Θ/Y, odd in r, the conditions Σ (tip e^{−r} + clamp) = 0 and Σ θ (tip e^{−r} − clamp) = 0 at the
    clamp give clamp = M tip. The first condition at the tip gives the ratio of tip's components: nothing
    cancels as Re r → ∞, and its coefficients stay of one size (not below 0.28 of their terms on 24,000 rods
    over all decades). The defect is that of the second one, relative to its largest term.
    """
    (t1, t2), (e1, e2) = column(r, end, lam, k1, k2, force)[1].T, end.T
    M = np.array([[(t1 + t2) * e1, 2 * t2 * e2], [-2 * t1 * e1, -(t1 + t2) * e2]]) / (t1 - t2)
    _, _, rising, left_rising = column(r, 1.0, lam, k1, k2, force)
    _, _, falling, left_falling = column(-r, end, lam, k1, k2, force)
    row = rising + np.einsum("mi,ijm->mj", falling, M)
    tip = np.stack([row[:, 1], -row[:, 0]], axis=1) / np.abs(row).sum(axis=1, keepdims=True)
    clamp = np.einsum("ijm,mj->mi", M, tip)
    terms = np.concatenate([left_rising * tip, left_falling * clamp], axis=1)
    defect = np.abs(terms.sum(axis=1)) / np.abs(terms).max(axis=1)
    value = np.sum(tip + clamp * end, axis=1, keepdims=True)
    return tip / value, clamp / value, defect


def _sums(tip: Complex, clamp: Complex, decay: Complex) -> tuple[Complex, Complex]:
    """tip e^{r(u−1)} ± clamp e^{−ru}, (m, 2, N) each: even and odd under r → −r."""
    rising, falling = tip[..., None] * decay[..., ::-1], clamp[..., None] * decay
    return rising + falling, rising - falling


def _weighted(weight: Complex, terms: Complex) -> Complex:
    """Σ weight · terms over the two exponents, (m, N)."""
    total: Complex = weight[:, :1] * terms[:, 0] + weight[:, 1:] * terms[:, 1]
    return total


def _times(f: Complex, matrix: Real) -> Complex:
    """f @ matrix, without making the matrix complex."""
    product = np.empty(f.shape, dtype=complex)
    product.real, product.imag = f.real @ matrix, f.imag @ matrix
    return product
