"""Spectrum of any emitted rod by spectral integration: coefficients may vary along it, loads may have drag.

The rows of the linear operator M are those that the derivation emitted. With H = Y' − νΘ they are written on
(Y, H, H', Θ, Θ', Θ''), and the unknowns are what would otherwise be differentiated:

    z = (H', Θ'', H(1), Θ'(1)):    H = H(1) − ∫ᵤ¹ H',  Θ = ∫₀ᵘ (Θ'(1) − ∫ᵤ¹ Θ''),  Y = ∫₀ᵘ (H + νΘ).

M (Y, Θ) = λ Γ (Y, Θ) on Gauss–Legendre nodes, with the stresses minus load at the tip as two more rows, is
A z = λ B z. Divided by their stiffness the rows of A are integral equations of the second kind, well
conditioned for every stiffness. Lengths in L, times in γ2 L⁴/k3, forces in k3/L².
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import lu_factor, lu_solve

from rodwnl.errors import ComputationError
from rodwnl.inverse import KEPT, MOST_NODES, Complex, Real, eigenvalues_and_slopes
from rodwnl.parameters import RodParameters
from rodwnl.quadrature import Nodes, gauss_legendre
from rodwnl.straightrod import ENDS, StraightRod, straight_rod

Array = NDArray[Any]

STEP = 1e-100  # complex step: Im f(F + i·STEP)/STEP is f'(F) to round-off
SWEEPS = 4  # of inverse iteration, from a shift close to one eigenvalue
ASIDE = 1.0  # where to look from when 0 is an eigenvalue to the last digit
DROWNING = 1e-6  # an eigenvalue relative to the next one, below which its inverse leaves too few digits
ROUNDING = 8  # rounding errors of a term of a row, in units of EPS
NOISE = 1e-12  # of the largest 1/λ: what rounding makes of the smallest ones of a soft rod; 2e-13 was seen
EPS = float(np.finfo(float).eps)


@dataclass(frozen=True)
class Fields:
    """Linear maps z -> fields at the nodes, (n, 2n + 2), and -> their values at the tip, (2n + 2,)."""

    Y: Array
    H: Array
    Theta: Array
    Theta_u: Array
    Y_tip: Array
    H_tip: Array
    Theta_tip: Array
    Theta_u_tip: Array


@dataclass(frozen=True)
class Pencil:
    """A z = λ B z at one force, (2n + 2, 2n + 2): n rows of y, n of θ, one of either at the tip.

    size: |A| before the terms of its coefficients cancelled, which is what their rounding errors scale with.
    stiffness (2n + 2,): what the rows of M and of the tip stresses were divided by.
    """

    A: Array
    B: Array
    size: Array
    stiffness: Array
    fields: Fields


def fields_of(straight: StraightRod, nodes: Nodes) -> Fields:
    """Every field that the rows contain, from the unknowns."""
    n = len(nodes.u)
    one, none, first, second = np.eye(n), np.zeros((n, n)), np.ones((n, 1)), np.zeros((n, 1))
    nu, _ = straight.stretch(nodes.u)
    H = np.hstack([-nodes.to_tip, none, first, second])
    Theta_u = np.hstack([none, -nodes.to_tip, second, first])
    Theta = nodes.from_clamp @ Theta_u
    Y_u = H + (nu * one) @ Theta
    ends = np.zeros((2, 2 * n + 2))
    ends[0, -2] = ends[1, -1] = 1.0
    return Fields(
        nodes.from_clamp @ Y_u, H, Theta, Theta_u,
        nodes.weights @ Y_u, ends[0], nodes.weights @ Theta_u, ends[1],
    )  # fmt: skip


def pencil(straight: StraightRod, nodes: Nodes) -> Pencil:
    """The discretised linear problem of this straight rod; complex where its force is."""
    n = len(nodes.u)
    f = fields_of(straight, nodes)
    bend = np.zeros((n, 2 * n + 2))
    bend[:, n : 2 * n] = np.eye(n)
    shear = np.zeros_like(bend)
    shear[:, :n] = np.eye(n)
    stretch = straight.stretch(nodes.u)
    _, *weights = straight("drag_weights", u=nodes.u)
    A, B, size, stiffness = [], [], [], []
    for name, weight, field in (("y", weights[0], f.Y), ("theta", weights[1], f.Theta)):
        row = straight(f"{name}_row", u=nodes.u)
        scale = row[2] if name == "y" else row[5]
        fields = f.Y, f.H, shear, f.Theta, f.Theta_u, bend
        A.append(_combined(_on_shear(row, *stretch), fields, scale, n))
        absolute = [np.abs(c) for c in row], *(np.abs(s) for s in stretch)
        size.append(_combined(_on_shear(*absolute), [np.abs(g) for g in fields], scale, n))
        B.append(_column(weight / scale, n) * field)
        stiffness.append(_column(scale, n)[:, 0])
    at_tip = f.Y_tip, f.H_tip, f.Theta_tip, f.Theta_u_tip
    nu_tip, _ = straight.stretch(1.0)
    for name, scale in (("y", stiffness[0][-1]), ("theta", stiffness[1][-1])):
        still, moving = (straight(f"{name}_tip_row", u=1.0, lam=lam) for lam in (0.0, 1.0))
        drag = [b - a for a, b in zip(still, moving, strict=True)]  # a load with drag is linear in λ
        absolute_row, sizes = [np.abs(c) for c in still], [np.abs(g) for g in at_tip]
        for rows, coefficients, values, nu in (
            (A, still, at_tip, nu_tip),
            (B, [-c for c in drag], at_tip, nu_tip),
            (size, absolute_row, sizes, abs(nu_tip)),
        ):
            Y, Y_u, Theta, Theta_u = coefficients
            rows.append(_combined((Y, Y_u, Theta + nu * Y_u, Theta_u), values, scale, 1))
        stiffness.append(np.atleast_1d(scale))
    return Pencil(np.vstack(A), np.vstack(B), np.vstack(size).real, np.concatenate(stiffness), f)


def _combined(coefficients: Sequence[Any], fields: Sequence[Array], scale: Any, n: int) -> Array:
    """Σ c·field/scale, n rows; coefficients are numbers or (n,)."""
    terms = zip(coefficients, fields, strict=True)
    return np.asarray(sum(_column(c / scale, n) * np.atleast_2d(field) for c, field in terms))


def _on_shear(row: Sequence[Any], nu: Any, nu_u: Any) -> tuple[Any, ...]:
    """Coefficients of (Y, Y', Y'', Θ, Θ', Θ'') -> of (Y, H, H', Θ, Θ', Θ''): Y' = H + νΘ."""
    Y, Y_u, Y_uu, Theta, Theta_u, Theta_uu = row
    return Y, Y_u, Y_uu, Theta + nu * Y_u + nu_u * Y_uu, Theta_u + nu * Y_uu, Theta_uu


def _column(coefficient: Any, n: int) -> Array:
    return np.broadcast_to(np.asarray(coefficient), (n,))[:, None]


def stepped(rod: RodParameters, force: float, nodes: Nodes) -> tuple[Pencil, Array, Array]:
    """The pencil, real, and the slopes of A and B in the force."""
    p = pencil(straight_rod(rod, force + 1j * STEP), nodes)
    fields = Fields(*(np.real(m) for m in vars(p.fields).values()))
    real = Pencil(p.A.real, p.B.real, p.size, p.stiffness.real, fields)
    return real, p.A.imag / STEP, p.B.imag / STEP


def leading_eigenvalues(rod: RodParameters, force: Real, kept: int = KEPT) -> tuple[Complex, Complex]:
    """The `kept` eigenvalues λ of least modulus and their slopes dλ/dF, (n, kept) each, for forces (n,)."""
    found: list[tuple[Complex, Complex]] = []
    for f in force:
        nodes = gauss_legendre(max(nodes_for(rod, float(f)), kept))
        parts = stepped(rod, float(f), nodes)
        shift = 0.0
        try:
            with np.errstate(all="ignore"):  # an eigenvalue that is 0 to round-off is looked at below
                eigenvalue, slope = eigenvalues_and_slopes(*_inverse(*parts), kept)
                shift = _shift(eigenvalue, slope)
        except np.linalg.LinAlgError:
            shift = ASIDE
        if shift:
            eigenvalue, slope = eigenvalues_and_slopes(*_inverse(*parts, shift), kept)
            eigenvalue = eigenvalue + shift
        found.append((eigenvalue, slope))
    return np.stack([eigenvalue for eigenvalue, _ in found]), np.stack([slope for _, slope in found])


def _inverse(p: Pencil, A_force: Array, B_force: Array, shift: float = 0.0) -> tuple[Array, Array]:
    """K = (A − shift B)⁻¹ B and K', from (A − shift B) K' = B' − (A' − shift B') K.

    In real arithmetic: a complex solve leaves rounding errors of Re K in the entries of Im K that are small.
    """
    matrix = p.A - shift * p.B
    K = np.linalg.solve(matrix, p.B)
    return K, np.linalg.solve(matrix, B_force - (A_force - shift * B_force) @ K)


def _shift(*found: Array) -> float:
    """Where to look from when one eigenvalue is so small that its inverse drowns the others'; else 0."""
    eigenvalue = np.sort(np.abs(found[0]))
    if not all(np.all(np.isfinite(x)) for x in found):
        return ASIDE
    return float(eigenvalue[1]) / 8 if eigenvalue[0] < DROWNING * eigenvalue[1] else 0.0


def unstable_count(rod: RodParameters, force: float) -> int:
    """Number of eigenvalues with Re λ > 0, on half as many nodes again as `leading_eigenvalues` takes.

    Not among the leading ones only: a tip that pushes (a spring of negative stiffness) has an eigenvalue as
    large as its boundary layer is thin. So the tip rows without ∂t, which would add eigenvalues 1/λ that are
    0 but for rounding, of either sign, are first solved for two of the unknowns: z = null(A_still) w. And
    det K = Π 1/λ < 0 says that an odd number of λ is real and negative: where that contradicts those with
    Re λ > 0 that stand out from rounding, it hides one more. (Drag at the tip leaves B singular to rounding.)
    """
    p = pencil(straight_rod(rod, force), gauss_legendre(3 * nodes_for(rod, force) // 2))
    still = ~p.B.any(axis=1)
    within = np.linalg.qr(p.A[still].T, mode="complete")[0][:, np.sum(still) :]
    A, B = p.A[~still] @ within, p.B[~still] @ within
    try:
        inverse = np.linalg.eigvals(np.linalg.solve(A, B))
        size = np.abs(inverse)
        shift = _shift(1 / np.sort(size)[-2:])
    except np.linalg.LinAlgError:
        shift = ASIDE
    if shift:  # an eigenvalue that is 0 but for rounding drowns the others
        eigenvalue = shift + 1 / np.linalg.eigvals(np.linalg.solve(A - shift * B, B))
        modulus = np.abs(eigenvalue)
        return int(np.sum((eigenvalue.real > 0) & (modulus < np.sort(modulus)[1] / NOISE)))
    seen = int(np.sum((inverse.real > 0) & (size > NOISE * np.max(size))))
    if EPS * np.linalg.cond(B) > 1:  # the sign of det B is round-off
        return seen
    odd = np.linalg.slogdet(A).sign * np.linalg.slogdet(B).sign < 0
    return seen + int((len(A) - seen) % 2 != odd)


def static_sign(rod: RodParameters, force: float) -> float:
    """The sign of det A, which a real eigenvalue changes where it passes through 0."""
    p = pencil(straight_rod(rod, force), gauss_legendre(nodes_for(rod, force)))
    return float(np.linalg.slogdet(p.A).sign)


def nodes_for(rod: RodParameters, force: float) -> int:
    """Nodes that resolve the leading eigenfunctions: as for λ = 0. A multiple of 8."""
    wave = wave_number(straight_rod(rod, force), 0.0)
    count = 32 + 8 * int(wave / 16)
    if count > MOST_NODES:
        raise ComputationError(
            f"at F = {force:g} the shear waves of the rod have wave number {wave:.0f}: {count} nodes would "
            f"be needed, more than {MOST_NODES}; search a smaller range (max_force)"
        )
    return count


def wave_number(straight: StraightRod, eigenvalue: complex) -> float:
    """The largest |r| of exponentials e^{ru} that solve the rows with their coefficients at either end."""
    largest = 0.0
    for end in ENDS:
        _, w_y, w_theta = straight("drag_weights", u=end)
        Y, Y_u, Y_uu, Theta, Theta_u, Theta_uu = straight("y_row", u=end)
        Z, Z_u, Z_uu, Phi, Phi_u, Phi_uu = straight("theta_row", u=end)
        determinant: Array = np.polysub(
            np.polymul([Y_uu, Y_u, Y - eigenvalue * w_y], [Phi_uu, Phi_u, Phi - eigenvalue * w_theta]),
            np.polymul([Theta_uu, Theta_u, Theta], [Z_uu, Z_u, Z]),
        )
        largest = max(largest, float(np.max(np.abs(np.roots(determinant)))))
    return largest


@dataclass(frozen=True)
class Eigenpair:
    """One eigenvalue with its vectors: A v = λ B v, u* A = λ u* B; noise: its error by round-off."""

    eigenvalue: complex
    right: Complex
    left: Complex
    noise: float


def nearest(p: Pencil, shift: complex) -> Eigenpair:
    """The eigenvalue next to the shift, by inverse iteration on both sides.

    Raises ComputationError where the matrix is singular beyond float64 at the shift.
    """
    A, B = p.A, p.B
    matrix = A - shift * B
    factors = lu_factor(matrix + 0j, check_finite=False)
    right = left = np.ones(len(A), dtype=complex)
    for _ in range(SWEEPS):
        right = lu_solve(factors, B @ right, check_finite=False)
        left = lu_solve(factors, B.T.conj() @ left, trans=2, check_finite=False)
        right, left = right / np.linalg.norm(right), left / np.linalg.norm(left)
    pairing = left.conj() @ B @ right
    if not np.isfinite(pairing) or pairing == 0:
        raise ComputationError("inverse iteration broke down: the linear problem is singular in float64")
    # λ = shift + u* (A − shift B) v / u* B v: the small correction keeps its digits
    eigenvalue = shift + left.conj() @ matrix @ right / pairing
    terms = np.abs(left) @ (p.size + abs(shift) * np.abs(B)) @ np.abs(right)
    return Eigenpair(complex(eigenvalue), right, left, float(ROUNDING * EPS * terms / abs(pairing)))
