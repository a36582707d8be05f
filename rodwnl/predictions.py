"""What the amplitude equation predicts at a force: tip amplitude and frequency of the limit cycles."""

from __future__ import annotations

from dataclasses import dataclass
from fractions import Fraction
from typing import Literal

from rodwnl import kernels
from rodwnl.coefficients import LandauCoefficients, landau
from rodwnl.parameters import Number, RodParameters
from rodwnl.spectrum import DEFAULT_MAX_FORCE


@dataclass(frozen=True)
class Prediction:
    """The branch of limit cycles that is born at one threshold, at one force (leading order in F − F_c).

    side: where the branch exists, "above" or "below" F_c; None where the criticality is degenerate.
    exists: whether the force lies there. stable: whether the branch is. A_tip: amplitude of y(1, t) in L,
    omega: frequency in k3/(γ2 L⁴); their errors are numerical ones, without what higher orders would add.
    All None where the branch does not exist.
    """

    coefficients: LandauCoefficients
    force: float
    side: Literal["above", "below"] | None
    exists: bool
    stable: bool | None
    A_tip: float | None
    omega: float | None
    A_tip_error: float | None
    omega_error: float | None


def predict(rod: RodParameters, force: Number) -> tuple[Prediction, ...]:
    """One prediction per Hopf threshold of the leading eigenvalue, by increasing threshold.

    Thresholds are searched up to max(400, force), but not beyond k1. Raises InputError for a force outside
    [0, k1), and what `landau` raises.
    """
    exact = rod.checked_force(force)
    found = landau(rod, max(exact, Fraction(DEFAULT_MAX_FORCE)))
    return tuple(predict_at(coefficients, float(exact)) for coefficients in found)


def predict_at(coefficients: LandauCoefficients, force: float) -> Prediction:
    """A_tip = 2√(−Re β/Re α (F − F_c)), ω = ω_c + (Im β − Im α Re β/Re α)(F − F_c).

    (Paper: eq:tipamplitude, eq:tipfrequency.) The branch is stable where −2 Re β (F − F_c) < 0.
    """
    c, alpha, beta = coefficients, coefficients.alpha, coefficients.beta
    if c.criticality == "degenerate":
        return Prediction(c, force, None, False, None, None, None, None, None)
    side: Literal["above", "below"] = "above" if c.A_tip2_slope > 0 else "below"
    detuning = force - c.force
    squared = kernels.tip_amplitude_squared(detuning, alpha.real, beta.real)
    if not squared > 0:
        return Prediction(c, force, side, False, None, None, None, None, None)
    A_tip = float(squared) ** 0.5
    squared_error = abs(detuning) * c.A_tip2_slope_error + abs(c.A_tip2_slope) * c.threshold.force_error
    return Prediction(
        c, force, side,
        exists=True,
        stable=bool(kernels.radial_stability(detuning, beta.real) < 0),
        A_tip=A_tip,
        omega=float(kernels.frequency(detuning, c.omega, alpha.real, alpha.imag, beta.real, beta.imag)),
        A_tip_error=squared_error / (2 * A_tip),
        omega_error=c.threshold.omega_error + abs(detuning) * c.omega_slope_error
        + abs(c.omega_slope) * c.threshold.force_error,
    )  # fmt: skip
