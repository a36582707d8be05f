"""What the amplitude equation predicts at a force: tip amplitude and frequency of the limit cycles.

At order 3 linear in F − F_c, at order 5 with the curvatures of A_tip² and ω.
"""

from __future__ import annotations

from dataclasses import dataclass
from fractions import Fraction
from typing import Literal

from rodwnl import kernels
from rodwnl.coefficients import LandauCoefficients, landau
from rodwnl.parameters import Number, RodParameters
from rodwnl.responses import AmplitudeEquation, amplitude_equation
from rodwnl.spectrum import DEFAULT_MAX_FORCE


@dataclass(frozen=True)
class Prediction:
    """The branch of limit cycles that is born at one threshold, at one force.

    side: where the branch exists, "above" or "below" F_c; None where the criticality is degenerate.
    exists: whether the force lies there. stable: whether the branch is. A_tip: amplitude of y(1, t) in L,
    omega: frequency in k3/(γ2 L⁴); their errors are numerical ones, without what higher orders would add.
    All None where the branch does not exist. A_tip is None too where the curvature has brought A_tip² to 0,
    far outside the reach of the expansion.
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


def predict(rod: RodParameters, force: Number, order: int = 3) -> tuple[Prediction, ...]:
    """One prediction per Hopf threshold of the leading eigenvalue, by increasing threshold.

    order: 3, or 5 for the curvatures of A_tip² and ω in the force. Thresholds are searched up to
    max(400, force), but not beyond k1. Raises InputError for a force outside [0, k1), and what `landau`
    raises.
    """
    exact = rod.checked_force(force)
    found = landau(rod, max(exact, Fraction(DEFAULT_MAX_FORCE)))
    beyond = [amplitude_equation(rod, c.threshold, order) if order > 3 else None for c in found]
    return tuple(predict_at(c, float(exact), equation) for c, equation in zip(found, beyond, strict=True))


def predict_at(
    coefficients: LandauCoefficients, force: float, beyond: AmplitudeEquation | None = None
) -> Prediction:
    """A_tip = 2√(−Re β/Re α (F − F_c)), ω = ω_c + (Im β − Im α Re β/Re α)(F − F_c).

    (Paper: eq:tipamplitude, eq:tipfrequency.) The branch is stable where −2 Re β (F − F_c) < 0. beyond: adds
    the curvatures of A_tip² and ω.
    """
    c, alpha, beta = coefficients, coefficients.alpha, coefficients.beta
    if c.criticality == "degenerate":
        return Prediction(c, force, None, False, None, None, None, None, None)
    side: Literal["above", "below"] = "above" if c.A_tip2_slope > 0 else "below"
    detuning = force - c.force
    squared = kernels.tip_amplitude_squared(detuning, alpha.real, beta.real)
    if not squared > 0:
        return Prediction(c, force, side, False, None, None, None, None, None)
    omega = kernels.frequency(detuning, c.omega, alpha.real, alpha.imag, beta.real, beta.imag)
    squared_error = abs(detuning) * c.A_tip2_slope_error + abs(c.A_tip2_slope) * c.threshold.force_error
    if beyond is not None and beyond.A_tip2_curvature is not None and beyond.omega_curvature is not None:
        squared += beyond.A_tip2_curvature * detuning**2
        omega += beyond.omega_curvature * detuning**2
        squared_error += beyond.A_tip2_curvature_error * detuning**2
    A_tip = float(squared) ** 0.5 if squared > 0 else None
    return Prediction(
        c, force, side,
        exists=True,
        stable=bool(kernels.radial_stability(detuning, beta.real) < 0),
        A_tip=A_tip,
        omega=float(omega),
        A_tip_error=None if A_tip is None else squared_error / (2 * A_tip),
        omega_error=c.threshold.omega_error + abs(detuning) * c.omega_slope_error
        + abs(c.omega_slope) * c.threshold.force_error,
    )  # fmt: skip
