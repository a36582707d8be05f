"""At a Hopf threshold: critical mode, adjoint and second-order corrections, on quadrature nodes.

Modes are sums of four exponentials, evaluated and never collocated, so that stiff rods lose no digits:

    Y = Σ c_j e^{r_j u},    k2 r⁴ + (μF − λ − k2γ3λ) r² + λ(μν + γ3λ) = 0,    λ = iω

The corrections solve two-point problems with smooth data. Written for w = X'' they are integral
equations of the second kind, as well conditioned for k1 → ∞ as at a resonance k1(r_i + r_j)² = 2iωγ1,
where the sum of exponentials is not. Lengths in L, times in γ2 L⁴/k3, forces in k3/L². Y(1) = 1.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from rodwnl import kernels
from rodwnl.characteristic import boundary_matrix, exponentials, exponents
from rodwnl.errors import ComputationError
from rodwnl.inverse import Complex, Floats
from rodwnl.quadrature import Nodes, gauss_legendre

MOST_NODES = 400


@dataclass(frozen=True)
class CriticalMode:
    """Y, Θ, Θ' and H = Y' − νΘ at the nodes, (N,), and Θ(1). Y(1) = 1.

    boundary_residual: the four boundary conditions, ode_residual: the two differential equations
    (integrated from the tip), each relative to its largest term.
    """

    Y: Complex
    Theta: Complex
    Theta_u: Complex
    H: Complex
    Theta_tip: complex
    boundary_residual: float
    ode_residual: float


@dataclass(frozen=True)
class AdjointMode:
    """Ψ_Y, Ψ_Θ at the nodes, (N,), and Ψ_Y(1), scaled to max |Ψ_Y| = 1; residuals as for the mode."""

    Psi_Y: Complex
    Psi_Theta: Complex
    Psi_Y_tip: complex
    boundary_residual: float
    ode_residual: float


@dataclass(frozen=True)
class Corrections:
    """X0, X2 and the tensions P0, P2 at the nodes, (N,).

    Of X0 and P0 only the real parts have a meaning ("+ c.c."). P0, P2 come from the axial balance of
    forces. residual: how far they are from k1(X' + …), their constitutive law, relative to k1 max|X'|.
    """

    X0: Complex
    X2: Complex
    P0: Complex
    P2: Complex
    residual: float


def nodes_at(parameters: Floats, force: float, omega: float) -> Nodes:
    """Nodes that resolve products of the modes: their number follows from the largest exponent.

    Raises ComputationError where the boundary layers are too thin for MOST_NODES.
    """
    k1, _, _, gamma1 = parameters
    axial = np.sqrt(2 * omega * gamma1 / k1)
    largest = max(float(np.max(np.abs(exponents(parameters, force, 1j * omega)))), axial)
    count = 24 + 8 * np.ceil(largest / 4)
    if count > MOST_NODES:
        raise ComputationError(
            f"at F = {force:.6g}, omega = {omega:.6g} the modes vary like exp({largest:.3g} u): {count:.3g} "
            f"nodes would be needed, more than {MOST_NODES}; compute this rod with more digits"
        )
    return gauss_legendre(int(count))


def critical_mode(parameters: Floats, force: float, omega: float, nodes: Nodes) -> CriticalMode:
    """The mode e^{iωt}(Y, Θ) with Y(0) = Θ(0) = H(1) = Θ'(1) = 0 (paper: eq:primal_eigenproblem)."""
    k1, k2, gamma3, _ = parameters
    lam = 1j * omega
    _, mu = kernels.base_state(k1, k2, force)
    r = exponents(parameters, force, lam)
    c, boundary = _null_vector(boundary_matrix(parameters, force, lam, r))
    c = c / np.sum(c * exponentials(r, 1.0))
    by_Y, by_Y_H = kernels.mode_amplitudes(r, lam, k1, k2, force)
    weights = np.stack([c, c * by_Y, c * r * by_Y, c * by_Y_H])
    Y, Theta, Theta_u, H = weights @ exponentials(r, nodes.u[:, None]).T
    Theta_tip = complex(weights[1] @ exponentials(r, 1.0))
    # λY = k2 H' − FΘ' and γ3 λ Θ = Θ'' + μH, integrated from u to the tip
    tip = nodes.to_tip
    ode = max(
        _relative(k2 * H, -force * Theta, force * Theta_tip, lam * tip @ Y),
        _relative(Theta_u, -mu * tip @ H, gamma3 * lam * tip @ Theta),
    )
    return CriticalMode(Y, Theta, Theta_u, H, Theta_tip, boundary, ode)


def adjoint_mode(parameters: Floats, force: float, omega: float, nodes: Nodes) -> AdjointMode:
    """The adjoint mode, eigenvalue −iω: Ψ_Y(0) = Ψ_Θ(0) = 0, k2Ψ_Y'(1) = μΨ_Θ(1), Ψ_Θ'(1) = −FΨ_Y(1)
    (paper: eq:adjoint_eigenproblem).
    """
    k1, k2, gamma3, _ = parameters
    lam = -1j * omega
    _, mu = kernels.base_state(k1, k2, force)
    r = exponents(parameters, force, lam)
    c, boundary = _null_vector(boundary_matrix(parameters, force, lam, r, adjoint=True))
    by_Y, by_Y_H = kernels.mode_amplitudes(r, lam, k1, k2, force)
    weights = np.stack([c, c * by_Y, c * r * by_Y, c * by_Y_H])
    weights /= np.max(np.abs(weights[0] @ exponentials(r, nodes.u[:, None]).T))
    Psi_Y, Psi_Theta, slope, shear = weights @ exponentials(r, nodes.u[:, None]).T
    Psi_Y_tip, *_ = weights @ exponentials(r, 1.0)
    # The same differential equations, other values at the tip: k2 H − FΘ → 0 and Θ' → −F Ψ_Y(1)
    tip = nodes.to_tip
    ode = max(
        _relative(k2 * shear, -force * Psi_Theta, lam * tip @ Psi_Y),
        _relative(slope, force * Psi_Y_tip, -mu * tip @ shear, gamma3 * lam * tip @ Psi_Theta),
    )
    return AdjointMode(Psi_Y, Psi_Theta, complex(Psi_Y_tip), boundary, ode)


def second_order(
    parameters: Floats, force: float, omega: float, mode: CriticalMode, nodes: Nodes
) -> Corrections:
    """Solve k1X'' = c X + f, X(0) = 0, X'(1) = b for X0 (c = 0), X2 (c = 2iωγ1); eq:longitudinalODE."""
    k1, k2, _, gamma1 = parameters
    lam = 1j * omega
    fields = (mode.Y, mode.Theta, mode.Theta_u, mode.H)
    X0, X0_u = two_point(
        k1, kernels.X0_operator(),
        kernels.X0_forcing(*fields, lam, k1, k2, gamma1, force),
        kernels.X0_tip_slope(mode.Theta_tip, k1, force), nodes,
    )  # fmt: skip
    X2, X2_u = two_point(
        k1, kernels.X2_operator(lam, gamma1),
        kernels.X2_forcing(*fields, lam, k1, k2, gamma1, force),
        kernels.X2_tip_slope(mode.Theta_tip, k1, force), nodes,
    )  # fmt: skip
    # P = −∫ᵤ¹ P', because P(1) = 0
    P0 = -nodes.to_tip @ kernels.P0_slope(*fields, lam, k2, gamma1)
    P2 = -nodes.to_tip @ kernels.P2_slope(*fields, X2, lam, k2, gamma1)
    # With "+ c.c." only Re X0 and Re P0 mean anything; the two laws differ in Im P0.
    misfit0 = (P0 - kernels.P0(mode.Theta, mode.H, X0_u, k1, force)).real
    misfit2 = P2 - kernels.P2(mode.Theta, mode.H, X2_u, k1, force)
    residual = max(
        np.max(np.abs(misfit)) / (k1 * np.max(np.abs(X_u)))
        for misfit, X_u in ((misfit0, X0_u), (misfit2, X2_u))
    )
    return Corrections(X0, X2, P0, P2, float(residual))


def two_point(
    k1: float, c: complex, forcing: Complex, slope: complex, nodes: Nodes
) -> tuple[Complex, Complex]:
    """X and X' with k1X'' = cX + forcing, X(0) = 0, X'(1) = slope.

    With w = X'': X' = slope − ∫ᵤ¹ w, X = slope·u − ∫₀ᵘ∫ᵤ¹ w, so (k1 + c ∫₀ᵘ∫ᵤ¹) w = forcing + c·slope·u.
    """
    twice = nodes.from_clamp @ nodes.to_tip
    w = np.linalg.solve(k1 * np.eye(len(nodes.u)) + c * twice, forcing + c * slope * nodes.u)
    return np.asarray(slope * nodes.u - twice @ w), np.asarray(slope - nodes.to_tip @ w)


def _null_vector(matrix: Complex) -> tuple[Complex, float]:
    """c with matrix·c = 0 as nearly as possible, and the largest residual of a row, relative."""
    rows = np.max(np.abs(matrix), axis=1, keepdims=True)
    columns = np.max(np.abs(matrix / rows), axis=0)
    c = np.linalg.svd(matrix / rows / columns)[2][-1].conj() / columns
    return c, float(np.max(np.abs(matrix @ c) / np.max(np.abs(matrix * c), axis=1)))


def _relative(*terms: Complex | complex) -> float:
    """The largest sum of the terms, relative to the largest term."""
    return float(np.max(np.abs(sum(terms))) / max(np.max(np.abs(term)) for term in terms))
