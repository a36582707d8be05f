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
    """Arithmetic that can also find modes: square roots, linear systems, exact rationals."""

    def number(self, value: Fraction) -> Scalar: ...
    def sqrt(self, z: Scalar) -> Scalar: ...
    def solve(self, matrix: list[list[Scalar]], right: list[Scalar]) -> list[Scalar]: ...


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
    """α, β of dA/dT = α|A|²A + βΔA and the residuals behind them, in one kind of number."""

    force: Scalar
    omega: Scalar
    alpha: Scalar
    beta: Scalar
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
        columns.append(column(r, state.numbers.exp(r), lam, state.k1, state.k2, state.gamma3, state.force))
    return [list(row) for row in zip(*columns, strict=True)]


def _amplitudes(
    state: CriticalState, keys: list[Key], rows: list[list[Scalar]]
) -> tuple[list[Scalar], Scalar]:
    """c from the first three conditions and Σ c_j e^{r_j} = 1, and the fourth relative to its terms."""
    tip = [state.numbers.exp(state.exponents.value(key)) for key in keys]
    zero = 0 * tip[0]
    c = state.numbers.solve([*rows[:3], tip], [zero, zero, zero, zero + 1])
    terms = [a * x for a, x in zip(rows[3], c, strict=True)]
    return c, sum(terms) / max(abs(t) for t in terms)


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
    """X0, X2 from k1X0'' = f0, k1X2'' − 2iωγ1X2 = f2 in closed form, and the tensions P0, P2."""
    s, e = state, state.exponents
    fields = (mode.Y, mode.Theta, mode.Theta_u, mode.H)
    Theta_tip = mode.Theta.at_tip()
    f0 = kernels.forcing_0(*fields, s.omega, s.k1, s.k2, s.gamma1, s.force)
    f2 = kernels.forcing_2(*fields, s.omega, s.k1, s.k2, s.gamma1, s.force)
    X0 = two_point(f0 / s.k1, e.zero, kernels.boundary_0(Theta_tip, s.k1, s.force))
    X2 = two_point(f2 / s.k1, e.key(2), kernels.boundary_2(Theta_tip, s.k1, s.force))
    P0 = kernels.P0(X0.derivative(), mode.Theta, mode.H, s.k1, s.force)
    P2 = kernels.P2(X2.derivative(), mode.Theta, mode.H, s.k1, s.force)
    return Corrections(X0, X2, P0, P2)


def coefficients(state: CriticalState) -> Coefficients:
    """α = ∫(Ψ_Y* g1 + Ψ_Θ* g3)/∫(Ψ_Y* Y + γ3Ψ_Θ* Θ), and β the same with g2 and g4."""
    s, mode, adjoint = state, critical_mode(state), adjoint_mode(state)
    X = second_order(state, mode)
    Y, Theta, Theta_u, H = mode.Y, mode.Theta, mode.Theta_u, mode.H
    Theta_tip, u = Theta.at_tip(), s.exponents.u(s.k1 / s.k1)
    g1 = kernels.g1(Y, Theta, Theta_u, H, X.X2, X.P0, X.P2, s.omega, s.k1, s.k2, s.gamma1)
    g3 = kernels.g3(Theta, Theta_u, H, X.P0, X.P2, s.k1, s.k2, s.force)
    g2 = kernels.g2(u, Theta_u, Theta_tip, s.omega, s.k1, s.k2)
    g4 = kernels.g4(Theta, Theta_tip, H, s.k1, s.k2, s.force)
    Psi_Y, Psi_Theta = adjoint.Psi_Y.conjugate(), adjoint.Psi_Theta.conjugate()
    norm = (Psi_Y * Y + s.gamma3 * (Psi_Theta * Theta)).integral()
    alpha = (Psi_Y * g1 + Psi_Theta * g3).integral() / norm
    beta = (Psi_Y * g2 + Psi_Theta * g4).integral() / norm
    residuals = {"mode": abs(mode.defect), "adjoint": abs(adjoint.defect)}
    return Coefficients(s.force, s.omega, alpha, beta, residuals)
