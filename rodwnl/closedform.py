"""A rod at a threshold in closed form: mode, adjoint, second-order corrections, α and β; nothing discretised.

The emitted formulas run on sums of exponentials (rodwnl/fields.py), over whichever numbers are given:
mpmath's (rodwnl/exact.py) or balls that contain the truth (rodwnl/certified.py). Every integral is a finite
sum.

    Y = Σ c_j e^{r_j u},  k2 r⁴ + (μF − λ − k2γ3λ) r² + λ(μν + γ3λ) = 0,  λ = iω

Dimensionless throughout: lengths in L, times in γ2L⁴/k3, forces in k3/L².
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from fractions import Fraction
from typing import Any, Protocol

from rodwnl import kernels
from rodwnl.fields import Arithmetic, Exponents, Field, Key, Scalar, two_point
from rodwnl.parameters import RodParameters


class Numbers(Arithmetic, Protocol):
    """Arithmetic with square roots, that knows the exact rationals which a rod is made of."""

    def number(self, value: Fraction) -> Scalar: ...
    def sqrt(self, z: Scalar) -> Scalar: ...


@dataclass(frozen=True)
class CriticalState:
    """A rod at a threshold, in one kind of number, and the exponents that occur there.

    exponents: generators r1, r2 (of the mode) and s, s² = 2iωγ1/k1 (of X2).
    """

    numbers: Numbers
    k1: Scalar
    k2: Scalar
    gamma3: Scalar
    gamma1: Scalar
    force: Scalar
    omega: Scalar
    exponents: Exponents

    @property
    def lam(self) -> Scalar:
        """λ = iω."""
        return self.omega * 1j


@dataclass(frozen=True)
class Mode:
    """The critical mode, Y(1) = 1; `defect` is what remains of Θ'(1) = 0, which was not imposed."""

    Y: Field
    Theta: Field
    Theta_u: Field
    H: Field
    defect: Scalar


@dataclass(frozen=True)
class Adjoint:
    """The adjoint mode, Ψ_Y(1) = 1; `defect` is what remains of Ψ_Θ'(1) + FΨ_Y(1) = 0."""

    Psi_Y: Field
    Psi_Theta: Field
    defect: Scalar


@dataclass(frozen=True)
class Corrections:
    """Second-order axial displacement and tension: mean (0) and second harmonic (2)."""

    X0: Field
    X2: Field
    P0: Field
    P2: Field


@dataclass(frozen=True)
class Coefficients:
    """α, β of dA/dT = α|A|²A + βΔA and the residuals behind them, in one kind of number.

    alpha_parts, beta_parts: what (g1, g3) and (g2, g4) contribute.
    """

    force: Scalar
    omega: Scalar
    alpha: Scalar
    beta: Scalar
    alpha_parts: tuple[Scalar, Scalar]
    beta_parts: tuple[Scalar, Scalar]
    residuals: dict[str, Scalar]


def critical_state(rod: RodParameters, force: Scalar, omega: Scalar, numbers: Numbers) -> CriticalState:
    """The rod's numbers and exponents at λ = iω.

    The two roots r² never coincide there: their discriminant (μF − λ − k2γ3λ)² − 4k2λ(μν + γ3λ) has the
    imaginary part −2ωμ(F(1 + k2γ3) + 2k2ν) < 0.
    """
    k1, k2, gamma3, gamma1 = (numbers.number(p) for p in (rod.k1, rod.k2, rod.gamma3, rod.gamma1))
    lam = omega * 1j
    c4, c2, c0 = kernels.exponent_polynomial(lam, k1, k2, gamma3, force)
    half, root = -c2 / (2 * c4), numbers.sqrt(c2 * c2 - 4 * c4 * c0) / (2 * c4)
    # the larger of half ± root loses nothing; the other one follows from r1² r2² = c0/c4
    larger = half + root if abs(half + root) > abs(half - root) else half - root
    squares = (larger, c0 / (c4 * larger), 2 * lam * gamma1 / k1)
    exponents = Exponents([numbers.sqrt(z) for z in squares], numbers)
    return CriticalState(numbers, k1, k2, gamma3, gamma1, force, omega, exponents)


def critical_mode(state: CriticalState) -> Mode:
    """Y, Θ, H from Y(0) = Θ(0) = H(1) = 0 and Y(1) = 1; the fourth condition holds at a threshold."""
    keys = _mode_keys(state)
    c, defect = _amplitudes(state, keys, boundary_rows(state, kernels.boundary_column, state.lam))
    Y, Theta, H = _mode_fields(state, keys, c, state.lam)
    return Mode(Y, Theta, Theta.derivative(), H, defect)


def adjoint_mode(state: CriticalState) -> Adjoint:
    """Ψ from Ψ_Y(0) = Ψ_Θ(0) = 0, k2Ψ_Y'(1) = μΨ_Θ(1) and Ψ_Y(1) = 1, at the eigenvalue λ*: exponents r*."""
    keys, lam = [state.exponents.conjugate(key) for key in _mode_keys(state)], state.lam.conjugate()
    c, defect = _amplitudes(state, keys, boundary_rows(state, kernels.adjoint_boundary_column, lam, keys))
    Psi_Y, Psi_Theta, _ = _mode_fields(state, keys, c, lam)
    return Adjoint(Psi_Y, Psi_Theta, defect)


def _mode_keys(state: CriticalState) -> list[Key]:
    """The exponents ±r1, ±r2."""
    return [state.exponents.key(i, sign) for i in (0, 1) for sign in (1, -1)]


def boundary_rows(
    state: CriticalState, column: Callable[..., Any], lam: Scalar, keys: list[Key] | None = None
) -> list[list[Scalar]]:
    """The four boundary conditions (rows) of the four exponentials (columns), from an emitted column."""
    columns = []
    for key in keys or _mode_keys(state):
        r = state.exponents.value(key)
        columns.append(column(r, state.numbers.exp(r), lam, state.k1, state.k2, state.force))
    return [list(row) for row in zip(*columns, strict=True)]


def _amplitudes(
    state: CriticalState, keys: list[Key], rows: list[list[Scalar]]
) -> tuple[list[Scalar], Scalar]:
    """c from the first three conditions and Σ c_j e^{r_j} = 1, and the fourth relative to its terms.

    The vector orthogonal to three rows has their minors as its components.
    """
    minors = [determinant([row[:j] + row[j + 1 :] for row in rows[:3]]) for j in range(4)]
    signed = [minor if j % 2 else -minor for j, minor in enumerate(minors)]
    tip = sum(x * state.numbers.exp(state.exponents.value(key)) for x, key in zip(signed, keys, strict=True))
    c = [x / tip for x in signed]
    terms = [a * x for a, x in zip(rows[3], c, strict=True)]
    return c, sum(terms) / max(abs(t) for t in terms)


def determinant(rows: list[list[Scalar]]) -> Scalar:
    """By expansion along the first row: small matrices, of entries whose sizes may differ by any factor."""
    if len(rows) == 1:
        return rows[0][0]
    minors = [determinant([row[:j] + row[j + 1 :] for row in rows[1:]]) for j in range(len(rows))]
    return sum(-a * m if j % 2 else a * m for j, (a, m) in enumerate(zip(rows[0], minors, strict=True)))


def _mode_fields(
    state: CriticalState, keys: list[Key], c: list[Scalar], lam: Scalar
) -> tuple[Field, Field, Field]:
    """Σ c_j (1, Θ/Y, H/Y)(r_j) e^{r_j u}."""
    Y: dict[Key, Scalar] = dict(zip(keys, c, strict=True))
    Theta, H = {}, {}
    for key in keys:
        r = state.exponents.value(key)
        by_Y = kernels.mode_amplitudes(r, lam, state.k1, state.k2, state.force)
        Theta[key], H[key] = (Y[key] * ratio for ratio in by_Y)
    Y_field, Theta_field, H_field = (
        state.exponents.field({key: (x,) for key, x in terms.items()}) for terms in (Y, Theta, H)
    )
    return Y_field, Theta_field, H_field


def second_order(state: CriticalState, mode: Mode) -> Corrections:
    """X0 and X2, k1X0'' = f0 and k1X2'' − 2iωγ1X2 = f2 with their tip slopes, and the tensions P0 and P2."""
    s, k1, force = state, state.k1, state.force
    fields = (mode.Y, mode.Theta, mode.Theta_u, mode.H)
    Theta_tip = mode.Theta.at_tip()
    f0 = kernels.X0_forcing(*fields, s.lam, k1, s.k2, s.gamma1, force)
    f2 = kernels.X2_forcing(*fields, s.lam, k1, s.k2, s.gamma1, force)
    X0 = two_point(f0 / k1, s.exponents.zero, kernels.X0_tip_slope(Theta_tip, k1, force))
    X2 = two_point(f2 / k1, s.exponents.key(2), kernels.X2_tip_slope(Theta_tip, k1, force))
    P0 = kernels.P0(mode.Theta, mode.H, X0.derivative(), k1, force)
    P2 = kernels.P2(mode.Theta, mode.H, X2.derivative(), k1, force)
    return Corrections(X0, X2, P0, P2)


def coefficients(state: CriticalState) -> Coefficients:
    """α = ∫(Ψ_Y* g1 + Ψ_Θ* g3)/∫(Ψ_Y* Y + γ3Ψ_Θ* Θ), and β the same with g2 and g4."""
    s, mode, adjoint = state, critical_mode(state), adjoint_mode(state)
    X = second_order(state, mode)
    Y, Theta, Theta_u, H = mode.Y, mode.Theta, mode.Theta_u, mode.H
    Psi = adjoint.Psi_Y, adjoint.Psi_Theta
    Theta_tip, u = Theta.at_tip(), s.exponents.u(s.k1 / s.k1)
    g1 = kernels.g1(Y, Theta, Theta_u, H, X.X2, X.P0, X.P2, s.lam, s.k1, s.k2, s.gamma1)
    g2 = kernels.g2(u, Theta_u, Theta_tip, s.lam, s.k1, s.k2)
    g3 = kernels.g3(Theta, Theta_u, H, X.P0, X.P2, s.k1, s.k2, s.force)
    g4 = kernels.g4(Theta, H, Theta_tip, s.k1, s.k2, s.force)
    norm = kernels.norm_integrand(*Psi, Y, Theta, s.gamma3).integral()
    zero = s.exponents.field({})
    by_g1, by_g3 = (kernels.alpha_integrand(*Psi, *g).integral() / norm for g in ((g1, zero), (zero, g3)))
    by_g2, by_g4 = (kernels.beta_integrand(*Psi, *g).integral() / norm for g in ((g2, zero), (zero, g4)))
    alpha, beta = by_g1 + by_g3, by_g2 + by_g4
    residuals = {"mode": abs(mode.defect), "adjoint": abs(adjoint.defect)}
    residuals |= _tension_defects(s, mode, X)
    residuals |= _other_route(s, mode, adjoint, X, alpha * norm, beta * norm)
    return Coefficients(s.force, s.omega, alpha, beta, (by_g1, by_g3), (by_g2, by_g4), residuals)


def _tension_defects(state: CriticalState, mode: Mode, X: Corrections) -> dict[str, Scalar]:
    """The axial force balance P' = … in mid-rod, relative to P'. Of P0 only the real part has a meaning."""
    fields, half = (mode.Y, mode.Theta, mode.Theta_u, mode.H), state.k1 / state.k1 / 2
    mean = kernels.P0_slope(*fields, state.lam, state.k2, state.gamma1)(half).real
    harmonic = kernels.P2_slope(*fields, X.X2, state.lam, state.k2, state.gamma1)(half)
    return {
        "P0": abs(X.P0.derivative()(half).real / mean - 1),
        "P2": abs(X.P2.derivative()(half) / harmonic - 1),
    }


def _other_route(
    state: CriticalState, mode: Mode, adjoint: Adjoint, X: Corrections, alpha: Scalar, beta: Scalar
) -> dict[str, Scalar]:
    """The numerators of α and β against those of the untransformed theory, which keeps boundary terms."""
    s, Psi, fields = state, (adjoint.Psi_Y, adjoint.Psi_Theta), (mode.Theta, mode.Theta_u, mode.H)
    tips = mode.Theta.at_tip(), adjoint.Psi_Y.at_tip()
    other_alpha = kernels.alpha_untransformed(
        *Psi, mode.Y, *fields, X.X2, X.P0, X.P2, s.lam, s.k1, s.k2, s.gamma1, s.force
    ).integral() + kernels.alpha_boundary(*tips, s.k1, s.k2, s.force)
    other_beta = kernels.beta_untransformed(
        *Psi, *fields, s.k1, s.k2, s.force
    ).integral() + kernels.beta_boundary(*tips, s.k1, s.k2)
    return {"alpha_routes": abs(other_alpha / alpha - 1), "beta_routes": abs(other_beta / beta - 1)}
