"""Critical mode, adjoint, second-order fields and the integrals of α and β for any emitted rod.

All by spectral integration on the pencil A z = λ B z (rodwnl/collocated.py). Its left vector is the adjoint
mode: Lagrange's identity says ∫ Ψ†(M − λΓ)Φ du − Ψ†(1) SΦ = 0 for every Φ with Φ(0) = 0, where S gives the
stresses minus load at the tip; on Gauss–Legendre nodes the vector's entries are w_i Ψ(u_i) and −Ψ(1), over
the stiffnesses by which the rows were divided. Lengths in L, times in γ2 L⁴/k3, forces in k3/L². Y(1) = 1.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.polynomial.legendre import leggauss, legvander
from numpy.typing import NDArray

from rodwnl.collocated import Array, nearest, pencil
from rodwnl.inverse import Complex, Real
from rodwnl.parameters import RodParameters
from rodwnl.quadrature import Nodes
from rodwnl.straightrod import StraightRod, straight_rod

Residuals = dict[str, float]


@dataclass(frozen=True)
class Mode:
    """The critical mode and its adjoint at the nodes, (n,), and at the tip; residuals of both.

    Y(1) = 1, max |Ψ_Y| = 1.
    """

    Y: Complex
    Theta: Complex
    Theta_u: Complex
    H: Complex
    Y_tip: complex
    Theta_tip: complex
    Psi_Y: Complex
    Psi_Theta: Complex
    Psi_Y_tip: complex
    Psi_Theta_tip: complex
    residuals: Residuals

    def named(self) -> dict[str, Any]:
        """The fields by the names that emitted functions use."""
        return {name: value for name, value in vars(self).items() if name != "residuals"}


def evaluate(rod: RodParameters, force: float, omega: float, nodes: Nodes) -> tuple[Complex, Real, Residuals]:
    """((α by the y row, by the θ row), (β by the y row, by the θ row)), (2, 2); the same sums of absolute
    values, (2,); residuals.
    """
    straight = straight_rod(rod, force)
    mode = critical_mode(straight, omega, nodes)
    given = mode.named() | {"u": nodes.u, "lam": 1j * omega}
    X, misfit = second_order(straight, omega, mode, nodes)
    given |= X
    norm = _integral(nodes, straight("norm_integrand", **given)) + straight("norm_boundary", **given)
    at_tip = {x: X[f"{x}_tip"] for x in ("X0", "X2")}  # boundary terms take tip values under the plain names
    none = np.zeros_like(mode.Y)
    only_y = {"Psi_Theta": none, "Psi_Theta_tip": 0j}
    only_theta = {"Psi_Y": none, "Psi_Y_tip": 0j}
    parts, sizes = np.zeros((2, 2), dtype=complex), np.zeros(2)
    for i, name in enumerate(("alpha", "beta")):
        for j, only in enumerate((only_y, only_theta)):
            integrand = straight(f"{name}_untransformed", **(given | only))
            boundary = straight(f"{name}_boundary", **(given | only | at_tip))
            parts[i, j] = _integral(nodes, integrand) + boundary
            sizes[i] += float(np.real(_integral(nodes, np.abs(integrand))) + abs(boundary))
    residuals = {**mode.residuals, "second_order": misfit}
    if hasattr(straight.functions, "g1"):
        residuals["transformed"] = _against_transformed(straight, given, nodes, parts)
    return parts / norm, sizes / abs(norm), residuals


def _against_transformed(straight: StraightRod, given: dict[str, Any], nodes: Nodes, parts: Complex) -> float:
    """How far the numerators are from those of the transformed variables, which have no boundary term."""
    g = {f"g{k}": straight(f"g{k}", **given) for k in (1, 2, 3, 4)}
    others = [_integral(nodes, straight(f"{name}_integrand", **given, **g)) for name in ("alpha", "beta")]
    return float(np.max(np.abs(others / parts.sum(axis=1) - 1)))


def _integral(nodes: Nodes, integrand: Any) -> complex:
    return complex(nodes.weights @ np.broadcast_to(integrand, nodes.u.shape))


def critical_mode(straight: StraightRod, omega: float, nodes: Nodes) -> Mode:
    """The right and the left vector of the pencil for the eigenvalue next to iω, as functions of u."""
    p = pencil(straight, nodes)
    pair = nearest(p, 1j * omega)
    f, n = p.fields, len(nodes.u)
    z = pair.right / (f.Y_tip @ pair.right)
    # u_i = w_i Ψ(u_i) k_i in the rows of M, −Ψ(1) k in those of the tip: k is what the row was divided by
    rows = pair.left / p.stiffness
    psi_y, psi_theta = rows[:n] / nodes.weights, rows[n : 2 * n] / nodes.weights
    tips = -rows[2 * n], -rows[2 * n + 1]
    size = np.max(np.abs(psi_y))
    to_tip = _value_at_tip(n)
    spread = max(np.max(np.abs(psi_y)), np.max(np.abs(psi_theta)))
    residuals = {
        "mode_equations": _defect(p.A, p.B, 1j * omega, z),
        "adjoint_equations": _defect(p.A.conj().T, p.B.conj().T, -1j * omega, pair.left),
        # The tip values come from rows of their own; the functions must run into them.
        "adjoint_tip": float(
            max(abs(to_tip @ psi - tip) for psi, tip in zip((psi_y, psi_theta), tips, strict=True)) / spread
        ),
    }
    return Mode(
        f.Y @ z, f.Theta @ z, f.Theta_u @ z, f.H @ z, complex(f.Y_tip @ z), complex(f.Theta_tip @ z),
        psi_y / size, psi_theta / size, complex(tips[0] / size), complex(tips[1] / size), residuals,
    )  # fmt: skip


def _defect(A: Array, B: Array, eigenvalue: complex, z: Complex) -> float:
    """The largest row of (A − λB) z relative to the largest row of its terms."""
    return float(np.max(np.abs(A @ z - eigenvalue * (B @ z))) / np.max(np.abs(A) @ np.abs(z)))


def _value_at_tip(count: int) -> Real:
    """Values at the Gauss–Legendre nodes -> value at u = 1 of the polynomial through them: Σ c_k P_k(1)."""
    s, w = leggauss(count)
    k = np.arange(count)
    return np.asarray(((k[:, None] + 0.5) * legvander(s, count - 1).T * w).sum(axis=0))


def second_order(
    straight: StraightRod, omega: float, mode: Mode, nodes: Nodes
) -> tuple[dict[str, Any], float]:
    """X0, X2, P0, P2 by name; how far the tensions are from their constitutive law, relative.

    (K1 X')' = c X + f,  X(0) = 0,  S_u X'(1) + S X(1) = S_u b,  P' = …,  P(1) = …
    """
    given = mode.named() | {"u": nodes.u, "lam": 1j * omega}
    at_tip = given | {"u": 1.0}
    _, K1_u, K1 = straight("x_row", u=nodes.u)
    known: dict[str, Any] = {}
    misfits = []
    for harmonic in (0, 2):
        x, p = f"X{harmonic}", f"P{harmonic}"
        S, S_u = straight("x_tip_row", u=1.0, lam=1j * omega * harmonic)
        X, X_u, X_tip = _two_point(
            (K1_u, K1), straight(f"{x}_operator", **given), straight(f"{x}_forcing", **given),
            straight(f"{x}_tip_slope", **at_tip), S / S_u, nodes,
        )  # fmt: skip
        known |= {x: X, f"{x}_u": X_u, f"{x}_tip": X_tip}
        slope = np.broadcast_to(straight(f"{p}_slope", **given, **known), nodes.u.shape)
        tip = straight(f"{p}_tip", **(at_tip | {x: X_tip}))
        known[p] = P = tip - nodes.to_tip @ slope
        misfit = P - straight(p, **given, **known)
        # With "+ c.c." only Re X0 and Re P0 mean anything; the two laws differ in Im P0.
        misfits.append(np.max(np.abs(misfit if harmonic else misfit.real)) / np.max(np.abs(K1 * X_u)))
    return known, float(max(misfits))


def _two_point(
    stiffness: tuple[Any, Any], c: Any, forcing: NDArray[Any], slope: complex, spring: complex, nodes: Nodes
) -> tuple[Complex, Complex, complex]:
    """X, X' and X(1) with K1 X'' + K1' X' = c X + forcing, X(0) = 0, X'(1) + spring X(1) = slope.

    stiffness: (K1', K1). They and c are numbers, or values at the nodes where the rod is not uniform.
    With w = X'' and s = X'(1): X' = s − ∫ᵤ¹ w and X = s u − ∫₀ᵘ∫ᵤ¹ w, in which (w, s) are the unknowns.
    """
    n = len(nodes.u)
    twice = nodes.from_clamp @ nodes.to_tip
    end = nodes.weights @ nodes.to_tip  # ∫₀¹∫ᵤ¹
    matrix, right = np.zeros((n + 1, n + 1), dtype=complex), np.zeros(n + 1, dtype=complex)
    K1_u, K1, c = (np.broadcast_to(value, (n,)) for value in (*stiffness, c))
    matrix[:n, :n] = np.diag(K1) - K1_u[:, None] * nodes.to_tip + c[:, None] * twice
    matrix[:n, n] = K1_u - c * nodes.u
    matrix[n, :n], matrix[n, n] = -spring * end, 1 + spring
    right[:n], right[n] = forcing, slope
    solved: NDArray[Any] = np.linalg.solve(matrix, right)
    w, s = solved[:n], complex(solved[n])
    return np.asarray(s * nodes.u - twice @ w), np.asarray(s - nodes.to_tip @ w), complex(s - end @ w)
