"""The Landau coefficients of dA/dT = α|A|²A + βΔA at every Hopf threshold of a rod, and what they decide.

    α = ∫(Ψ_Y* g1 + Ψ_Θ* g3) du / ∫(Ψ_Y* Y + γ3 Ψ_Θ* Θ) du,    β the same with g2, g4

(paper: eq:alphabetaformulas). Lengths in L, times in γ2 L⁴/k3, forces in k3/L². Y(1) = 1, so the tip moves
by 2|A| cos(ωt + …).
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from functools import partial
from typing import Literal

import numpy as np

from rodwnl import kernels
from rodwnl.errors import ComputationError, InputError
from rodwnl.inverse import Complex, Floats, Real
from rodwnl.modes import adjoint_mode, critical_mode, nodes_at, second_order
from rodwnl.parameters import PLAIN, Number, RodParameters
from rodwnl.quadrature import Nodes, gauss_legendre
from rodwnl.spectrum import EPS, HopfSearch, HopfThreshold, finite, hopf_thresholds

DOUBLE = 16  # working digits of double precision
ENOUGH = 8  # digits below which it is left
SHIFT = 1e-6  # relative shift of (F, ω) that measures how α and β depend on them
MORE_NODES = 16  # what the quadrature is compared with
ROUNDING = 32  # rounding errors of an integrand, in units of EPS


@dataclass(frozen=True)
class LandauCoefficients:
    """α and β at one Hopf threshold.

    alpha, beta: of dA/dT = α|A|²A + βΔA, F = F_c + ε²Δ. alpha_parts, beta_parts: what the y and the θ row
    contribute; of the plain rod what (g1, g3) and (g2, g4) do. A_tip2_slope, omega_slope: d(A_tip²)/dF and
    dω/dF along the branch of limit cycles at onset, which do not depend on how the mode is normalised.
    *_error: estimates of the absolute error. residuals: of the mode, the adjoint and the second-order
    fields, and |β − dλ/dF|/|β| with dλ/dF from the spectrum. working_digits: 16 for double precision, more
    where it did not suffice.
    """

    threshold: HopfThreshold
    alpha: complex
    beta: complex
    alpha_parts: tuple[complex, complex]
    beta_parts: tuple[complex, complex]
    A_tip2_slope: float
    omega_slope: float
    alpha_error: float
    beta_error: float
    A_tip2_slope_error: float
    omega_slope_error: float
    residuals: dict[str, float]
    working_digits: int = DOUBLE

    @property
    def force(self) -> float:
        return self.threshold.force

    @property
    def omega(self) -> float:
        return self.threshold.omega

    @property
    def crossing(self) -> Literal["destabilizing", "restabilizing"]:
        return self.threshold.crossing

    @property
    def digits(self) -> float:
        """Decimal digits that hold in the worst of F_c, ω_c, α, β and the slopes; negative where none do."""
        relative = (
            self.threshold.force_error / self.force,
            self.threshold.omega_error / self.omega,
            self.alpha_error / abs(self.alpha),
            self.beta_error / abs(self.beta),
            self.A_tip2_slope_error / abs(self.A_tip2_slope),
            self.omega_slope_error / abs(self.omega_slope),
        )
        return -float(np.log10(max(relative)))

    @property
    def criticality(self) -> Literal["supercritical", "subcritical", "degenerate"]:
        """By the sign of Re α; degenerate where the errors do not exclude Re α = 0 or Re β = 0.

        Then higher orders decide: |A|⁴A where Re α = 0, Δ² where Re β = 0.
        """
        if abs(self.alpha.real) <= self.alpha_error or abs(self.beta.real) <= self.beta_error:
            return "degenerate"
        return "supercritical" if self.alpha.real < 0 else "subcritical"


@dataclass(frozen=True)
class LandauSearch:
    """The coefficients at every threshold that `search` found, by increasing force. Iterates over them."""

    search: HopfSearch
    thresholds: tuple[LandauCoefficients, ...]

    @property
    def rod(self) -> RodParameters:
        return self.search.rod

    def __iter__(self) -> Iterator[LandauCoefficients]:
        return iter(self.thresholds)

    def __len__(self) -> int:
        return len(self.thresholds)

    def __getitem__(self, index: int) -> LandauCoefficients:
        return self.thresholds[index]


def landau(rod: RodParameters, max_force: Number | None = None, *, escalate: bool = True) -> LandauSearch:
    """α and β at every Hopf threshold of the leading eigenvalue with 0 <= F <= max_force.

    max_force is 400 by default, or where the rod ends. Where float64 keeps fewer than 8 digits of a rod's
    numbers, or its modes are too steep for quadrature, they are computed with more digits if the straight
    rod has the same stretch everywhere (not with escalate=False).
    Raises what `hopf_thresholds` raises, and ComputationError where the modes are too steep and stay so.
    """
    search = hopf_thresholds(rod, max_force)
    escalate = escalate and kernels.is_uniform(rod.model)
    return LandauSearch(search, tuple(_to_enough_digits(rod, t, escalate) for t in search))


def _to_enough_digits(rod: RodParameters, threshold: HopfThreshold, escalate: bool) -> LandauCoefficients:
    """In float64, or with more digits where that does not give ENOUGH of them and more digits help."""
    found = None
    try:
        with finite():
            found = landau_at(rod, threshold)
    except ComputationError:
        if not escalate:
            raise
    if found and (found.digits >= ENOUGH or not escalate):
        return found
    from rodwnl.escalation import exact_coefficients  # mpmath, which most rods do not need

    try:
        return exact_coefficients(rod, threshold)
    except ComputationError:
        if found is None:
            raise
        return found


def landau_at(rod: RodParameters, threshold: HopfThreshold) -> LandauCoefficients:
    """The coefficients at one threshold of this rod, also at one of `HopfSearch.later`.

    Raises InputError at a steady one: its amplitude equation is real and has other coefficients.
    """
    if threshold.steady:
        raise InputError(
            f"at force = {threshold.force:.10g} the rod buckles (a real eigenvalue crosses): there is no "
            f"frequency, and the coefficients of an oscillation do not apply"
        )
    force, omega = threshold.force, threshold.omega
    nodes, evaluate = _route(rod, force, omega)
    parts, scale, residuals = evaluate(force, omega, nodes)

    def change(force: float, omega: float, nodes: Nodes) -> Real:
        return np.asarray(abs((evaluate(force, omega, nodes)[0] - parts).sum(axis=1)))

    # What the quadrature, the rounding of the integrands and the error of (F, ω) do to α and to β.
    alpha_error, beta_error = (
        change(force, omega, gauss_legendre(len(nodes.u) + MORE_NODES))
        + ROUNDING * EPS * scale
        + change(force * (1 + SHIFT), omega, nodes) / SHIFT * threshold.force_error / force
        + change(force, omega * (1 + SHIFT), nodes) / SHIFT * threshold.omega_error / omega
    ).tolist()
    (by_g1, by_g3), (by_g2, by_g4) = parts.tolist()
    alpha, beta = by_g1 + by_g3, by_g2 + by_g4
    A_tip2_slope = float(kernels.tip_amplitude_squared_slope(alpha.real, beta.real))
    ratio = beta.real / alpha.real
    ratio_error = abs(ratio) * (alpha_error / abs(alpha.real) + beta_error / abs(beta.real))
    return LandauCoefficients(
        threshold, alpha, beta,
        alpha_parts=(by_g1, by_g3), beta_parts=(by_g2, by_g4),
        A_tip2_slope=A_tip2_slope,
        omega_slope=float(kernels.frequency_slope(alpha.real, alpha.imag, beta.real, beta.imag)),
        alpha_error=alpha_error, beta_error=beta_error,
        A_tip2_slope_error=4 * ratio_error,
        # Im β − Im α Re β/Re α
        omega_slope_error=beta_error + abs(ratio) * alpha_error + abs(alpha.imag) * ratio_error,
        residuals={
            "threshold": threshold.residual, **residuals, "beta": abs(beta - threshold.slope) / abs(beta)
        },
    )  # fmt: skip


Evaluation = tuple[Complex, Real, dict[str, float]]


def _route(rod: RodParameters, force: float, omega: float) -> tuple[Nodes, Callable[..., Evaluation]]:
    """Nodes for this threshold, and what evaluates the coefficients of this rod at (F, ω, nodes)."""
    if rod.model == PLAIN:
        parameters = rod.floats()
        return nodes_at(parameters, force, omega), partial(_evaluate, parameters)
    from rodwnl import expansion, thresholds  # SciPy, which the plain rod does not need

    return thresholds.nodes_at(rod, force, omega), partial(expansion.evaluate, rod)


def _evaluate(parameters: Floats, force: float, omega: float, nodes: Nodes) -> Evaluation:
    """((α by g1, by g3), (β by g2, by g4)), (2, 2); the same sums of absolute values, (2,); residuals."""
    k1, k2, gamma3, gamma1 = parameters
    lam = 1j * omega
    mode = critical_mode(parameters, force, omega, nodes)
    adjoint = adjoint_mode(parameters, force, omega, nodes)
    X = second_order(parameters, force, omega, mode, nodes)
    Y, Theta, Theta_u, H = mode.Y, mode.Theta, mode.Theta_u, mode.H
    Psi = adjoint.Psi_Y, adjoint.Psi_Theta

    norm = nodes.weights @ kernels.norm_integrand(*Psi, Y, Theta, gamma3)
    g1 = kernels.g1(Y, Theta, Theta_u, H, X.X2, X.P0, X.P2, lam, k1, k2, gamma1)
    g2 = kernels.g2(nodes.u, Theta_u, mode.Theta_tip, lam, k1, k2)
    g3 = kernels.g3(Theta, Theta_u, H, X.P0, X.P2, k1, k2, force)
    g4 = kernels.g4(Theta, H, mode.Theta_tip, k1, k2, force)
    zero = np.zeros_like(Y)
    integrands = np.array([
        [kernels.alpha_integrand(*Psi, g1, zero), kernels.alpha_integrand(*Psi, zero, g3)],
        [kernels.beta_integrand(*Psi, g2, zero), kernels.beta_integrand(*Psi, zero, g4)],
    ])  # fmt: skip
    residuals = {
        "mode_boundary": mode.boundary_residual,
        "mode_equations": mode.ode_residual,
        "adjoint_boundary": adjoint.boundary_residual,
        "adjoint_equations": adjoint.ode_residual,
        "second_order": X.residual,
    }
    scale = (np.abs(integrands) @ nodes.weights).sum(axis=1) / abs(norm)
    return integrands @ nodes.weights / norm, scale, residuals
