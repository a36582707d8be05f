"""α and β of many rods at their thresholds: the emitted formulas on arrays (rods, nodes).

What `rodwnl.modes` and `rodwnl.coefficients` do for one rod, arranged so that nothing is solved rod by rod:

* Gauss–Legendre nodes are symmetric, u_i + u_{N+1−i} = 1, so of each exponent only e^{−ru} at the nodes is
  needed: read backwards it is e^{r(u−1)}. The conjugate of the adjoint mode has the same exponents.
* The second-order problem (K1 + cT) w = f, T = ∫₀ᵘ∫ᵤ¹, is diagonal in the eigenvectors of T, which are those
  of a fixed symmetric matrix (`Basis`): X2 costs two products with real matrices.
* Every indefinite integral is a product with one real matrix, for all rods at once.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import lru_cache
from typing import Any

import numpy as np

from rodwnl.batch_characteristic import Complex, Real, exponents
from rodwnl.batch_rods import Rods
from rodwnl.quadrature import gauss_legendre
from rodwnl.straightrod import StraightRod, arguments

FEWEST, MORE, MOST = 20, 8, 400  # nodes
BLOCK = 8192  # rods times nodes
EPS = float(np.finfo(float).eps)
ROUNDING = 16  # rounding errors of an integrand, in units of EPS: twice what was seen against the exact route
# The emitted functions of the coefficients: where the load follows the tip, in transformed variables without
# boundary terms; else with the boundary terms kept, in the same order.
BULK = ("P0_slope", "P0_tip", "P2_slope", "P2_tip")
TRANSFORMED = ("g1", "g2", "g3", "g4", "alpha_integrand", "beta_integrand", "norm_integrand")
KEPT = (
    "alpha_untransformed", "beta_untransformed", "norm_integrand",
    "alpha_boundary", "beta_boundary", "norm_boundary",
)  # fmt: skip


@dataclass(frozen=True)
class Basis:
    """N nodes u with weights (N,), and matrices (N, N) that act on rows.

    f @ to_tip is ∫ᵤ¹ f, and ((f @ forth) * values) @ back is Tf = ∫₀ᵘ∫ᵤ¹ f. The nodes integrate the product
    of two polynomials of degree < N exactly, so integration by parts holds: with A = ∫₀ᵘ and W =
    diag(weights), W∫ᵤ¹ = AᵀW. Hence T = A W⁻¹AᵀW, and W^½ T W^−½ is symmetric and positive: its
    eigenvectors are orthogonal. On coefficients in them: line are those of u, total gives ∫₀¹, twice ∫₀¹∫ᵤ¹.
    """

    u: Real
    weights: Real
    to_tip: Real
    values: Real
    forth: Real
    back: Real
    line: Real
    total: Real
    twice: Real


@lru_cache(maxsize=64)
def basis(count: int) -> Basis:
    """`count` nodes; the arrays are shared, so nobody may write to them."""
    nodes = gauss_legendre(count)
    root = np.sqrt(nodes.weights)
    half = root[:, None] * nodes.from_clamp / root
    values, vectors = np.linalg.eigh(half @ half.T)
    to_tip = np.ascontiguousarray(nodes.to_tip.T)
    forth, back = root[:, None] * vectors, vectors.T / root
    return Basis(
        nodes.u, nodes.weights, to_tip, values, forth, back,
        line=nodes.u @ forth, total=back @ nodes.weights, twice=back @ to_tip @ nodes.weights,
    )  # fmt: skip


@dataclass(frozen=True)
class Coefficients:
    """alpha, beta (m,), and what is known about them.

    residual (m,): the largest of three relative defects: the boundary conditions of the mode and of the
    adjoint, of which three of four were used, and the law of the axial force P2 at the clamp, where it was
    integrated to from the tip by the balance of forces. rounding (m,): estimated relative rounding error of α
    and β, from the cancellation in their integrals.
    """

    alpha: Complex
    beta: Complex
    residual: Real
    rounding: Real


def coefficients(rods: Rods, force: Real, omega: Real) -> Coefficients:
    """At thresholds (force, omega), (m,), of m rods.

    Where an exponent is so large that more than MOST nodes were needed: NaN with an infinite residual.
    """
    straight = rods.at(force)
    r = exponents(straight, omega)
    axial = straight("X2_operator", lam=1j * omega) / straight("stretch_stiffness")
    largest = np.maximum(np.abs(r).max(axis=1), np.sqrt(np.abs(axial)))
    counts = FEWEST + MORE * np.ceil(np.minimum(largest, MOST) / 4).astype(int)
    alpha, beta = np.full((2, len(force)), np.nan + 0j)
    residual, rounding = np.full((2, len(force)), np.inf)
    for count in np.unique(counts[counts <= MOST]).tolist():
        same = np.flatnonzero(counts == count)
        size = max(BLOCK // count, 1)
        for part in (same[i : i + size] for i in range(0, len(same), size)):
            here = rods[part][:, None].at(force[part, None])
            alpha[part], beta[part], residual[part], rounding[part] = _evaluate(
                here, omega[part, None], r[part], basis(count)
            )
    return Coefficients(alpha, beta, residual, rounding)


def _evaluate(
    straight: StraightRod, omega: Real, r: Complex, nodes: Basis
) -> tuple[Complex, Complex, Real, Real]:
    """α, β, residual and rounding, (m,), of rods (m, 1); r is (m, 2), omega (m, 1)."""
    given: dict[str, Any] = {"lam": 1j * omega, "u": nodes.u}
    end, decay = np.exp(-r), np.exp(-r[..., None] * nodes.u)
    Theta_Y, H_Y = straight("mode_amplitudes", r=r, **given)

    tip, clamp, mode_defect = _amplitudes(straight, "boundary_column", r, end, given["lam"])
    even, odd = _sums(tip, clamp, decay)
    given |= {
        "Y": even[:, 0] + even[:, 1], "Theta_u": _weighted(r * Theta_Y, even),
        "Theta": _weighted(Theta_Y, odd), "H": _weighted(H_Y, odd),
        "Y_tip": 1.0, "Theta_tip": np.sum(Theta_Y * (tip - clamp * end), axis=1, keepdims=True),
    }  # fmt: skip
    at_clamp = {
        "H": np.sum(H_Y * (tip * end - clamp), axis=1, keepdims=True),
        "Theta_u": np.sum(r * Theta_Y * (tip * end + clamp), axis=1, keepdims=True),
    }

    tip, clamp, adjoint_defect = _amplitudes(straight, "adjoint_boundary_column", r, end, given["lam"])
    even, odd = _sums(tip, clamp, decay)
    given |= {
        "Psi_Y": (even[:, 0] + even[:, 1]).conj(), "Psi_Theta": _weighted(Theta_Y, odd).conj(),
        "Psi_Y_tip": 1.0,
        "Psi_Theta_tip": np.sum(Theta_Y * (tip - clamp * end), axis=1, keepdims=True).conj(),
    }  # fmt: skip

    given |= _second_order(straight, given, _asked(vars(straight.functions)), nodes)
    tension_defect = _tension_defect(straight, given, at_clamp, nodes)

    at_tip: tuple[Any, ...] = (0.0, 0.0, 0.0)
    if hasattr(straight.functions, "g1"):
        given |= {g: straight(g, **given) for g in TRANSFORMED[:4]}
        names = TRANSFORMED[4:]
    else:
        names = KEPT[:3]
        # boundary terms take tip values under the plain names
        plain = given | {x: given.get(f"{x}_tip") for x in ("X0", "X2")}
        at_tip = tuple(straight(boundary, **plain) for boundary in KEPT[3:])
    integrals, cancellation = [], []
    for name, boundary in zip(names, at_tip, strict=True):
        integrand = straight(name, **given)
        total = integrand @ nodes.weights + np.ravel(boundary)
        integrals.append(total)
        cancellation.append((np.abs(integrand) @ nodes.weights + np.abs(np.ravel(boundary))) / np.abs(total))
    rounding = ROUNDING * EPS * (np.maximum(*cancellation[:2]) + cancellation[2])
    residual = np.max([mode_defect, adjoint_defect, tension_defect], axis=0)
    return integrals[0] / integrals[2], integrals[1] / integrals[2], residual, rounding


@dataclass(frozen=True)
class Correction:
    """X0 or X2 of m rods: w = X'' in the basis, (m, N), and s = X'(1), (m, 1).

    X' = s − ∫ᵤ¹ w, X = s u − Tw.
    """

    w: Complex
    s: Any
    nodes: Basis

    def named(self, x: str, asked: set[str]) -> dict[str, Any]:
        """Those of X, X' and X(1) that are asked for, by their names; the last as x_tip."""
        nodes, w, s = self.nodes, self.w, self.s
        found: dict[str, Any] = {}
        if x in asked:
            found[x] = s * nodes.u - _times(w * nodes.values, nodes.back)
            found[f"{x}_tip"] = s - (w @ nodes.twice)[:, None]
        if f"{x}_u" in asked:
            found[f"{x}_u"] = s - _times(_times(w, nodes.back), nodes.to_tip)
        return found


def _second_order(
    straight: StraightRod, given: dict[str, Any], asked: set[str], nodes: Basis
) -> dict[str, Any]:
    """X0 and X2 where they are asked for, and the tensions by the balance of forces: P = P(1) − ∫ᵤ¹ P'."""
    known: dict[str, Any] = {}
    for harmonic in (0, 2):
        x, p = f"X{harmonic}", f"P{harmonic}"
        if {x, f"{x}_u"} & asked:
            known["correction"] = _correction(straight, harmonic, given, nodes)
            known |= known["correction"].named(x, asked)
        known[f"{p}_slope"] = slope = straight(f"{p}_slope", **given, **known)
        tip = straight(f"{p}_tip", **(given | known | {x: known.get(f"{x}_tip")}))
        known[f"{p}_tip"], known[p] = tip, tip - _times(slope, nodes.to_tip)
    return known


def _correction(straight: StraightRod, harmonic: int, given: dict[str, Any], nodes: Basis) -> Correction:
    """K1 X'' = c X + f,  X(0) = 0,  X'(1) + k X(1) = b (paper: eq:longitudinalODE, eq:ODEBCs).

    With X = s u − Tw it is (K1 + cT) w = f + c s u, and s + k (s − ∫₀¹∫ᵤ¹ w) = b.
    """
    x, K1 = f"X{harmonic}", straight("stretch_stiffness")
    stress, by_slope = straight("x_tip_row", **(given | {"lam": given["lam"] * harmonic}))
    c, b = straight(f"{x}_operator", **given), straight(f"{x}_tip_slope", **given)
    stiffness = K1 + c * nodes.values
    forcing = straight(f"{x}_forcing", **given)
    if not np.any(stress):
        return Correction(_times(forcing + c * b * nodes.u, nodes.forth) / stiffness, b, nodes)
    k, of_f, of_s = stress / by_slope, _times(forcing, nodes.forth) / stiffness, c * nodes.line / stiffness
    s = (b + k * (of_f @ nodes.twice)[:, None]) / (1 + k * (1 - (of_s @ nodes.twice)[:, None]))
    return Correction(of_f + s * of_s, s, nodes)


def _tension_defect(
    straight: StraightRod, given: dict[str, Any], clamp: dict[str, Any], nodes: Basis
) -> Real:
    """How far P2(0) = P2(1) − ∫P2' is from its law, beyond the rounding of the terms; relative to ∫|P2'|.

    At the clamp Y = Θ = X2 = 0 and X2'(0) = s − ∫X2''.
    """
    X2, K1 = given["correction"], np.ravel(straight("stretch_stiffness"))
    slope = X2.s - (X2.w @ nodes.total)[:, None]
    law = straight("P2", **(given | clamp | {"Y": 0.0, "Theta": 0.0, "X2": 0.0, "u": 0.0, "X2_u": slope}))
    lack = np.abs(np.ravel(given["P2_tip"] - law) - given["P2_slope"] @ nodes.weights)
    noise = ROUNDING * EPS * K1 * (np.abs(X2.s)[:, 0] + np.abs(X2.w) @ np.abs(nodes.total))
    return np.asarray(np.maximum(lack - noise, 0) / (np.abs(given["P2_slope"]) @ nodes.weights))


def _asked(functions: Mapping[str, Any]) -> set[str]:
    """The names of what the functions used here take, X2 in any case: it is checked."""
    used = (*BULK, *(TRANSFORMED if "g1" in functions else KEPT))
    return {"X2"} | {name for f in used for name in arguments(functions[f])}


def _amplitudes(
    straight: StraightRod, column: str, r: Complex, end: Complex, lam: Complex
) -> tuple[Complex, Complex, Real]:
    """(tip, clamp), (m, 2) each, of Y = Σ tip e^{r(u−1)} + clamp e^{−ru} with Y(1) = 1, and a defect.

    With θ = Θ/Y, odd in r, the conditions Σ (tip e^{−r} + clamp) = 0 and Σ θ (tip e^{−r} − clamp) = 0 at the
    clamp give clamp = M tip. The first condition at the tip gives the ratio of tip's components: nothing
    cancels as Re r → ∞, and its coefficients stay of one size (not below 0.28 of their terms on 24,000 rods
    over all decades). The defect is that of the second one, relative to its largest term.
    """

    def contributions(r: Complex, scale: Any) -> tuple[Any, ...]:
        return tuple(straight(column, r=r, exp_r=scale, lam=lam))

    (t1, t2), (e1, e2) = contributions(r, end)[1].T, end.T
    M = np.array([[(t1 + t2) * e1, 2 * t2 * e2], [-2 * t1 * e1, -(t1 + t2) * e2]]) / (t1 - t2)
    _, _, rising, left_rising = contributions(r, 1.0)
    _, _, falling, left_falling = contributions(-r, end)
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
