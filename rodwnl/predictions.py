"""What the amplitude equation predicts at a force: tip amplitude and frequency of the limit cycles.

At order 3 linear in F − F_c, at order 5 with the curvatures of A_tip² and ω. Where the rod buckles: the tip
displacement of the bent equilibria, at order 3.
"""

from __future__ import annotations

from dataclasses import dataclass
from fractions import Fraction
from typing import Literal

from rodwnl import kernels
from rodwnl.coefficients import LandauCoefficients, landau
from rodwnl.errors import InputError
from rodwnl.parameters import Number, RodParameters, require_rod, shown
from rodwnl.responses import HIGHEST, AmplitudeEquation, Pitchfork, amplitude_equation, pitchfork
from rodwnl.spectrum import DEFAULT_MAX_FORCE, HopfThreshold


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


@dataclass(frozen=True)
class Buckled:
    """The two bent equilibria, each the other's mirror image, that are born at one steady crossing.

    side, exists, stable: as of a `Prediction`. y_tip: |y(1)| in L with its numerical error, None where they
    do not exist.
    """

    threshold: HopfThreshold
    pitchfork: Pitchfork
    force: float
    side: Literal["above", "below"] | None
    exists: bool
    stable: bool | None
    y_tip: float | None
    y_tip_error: float | None


@dataclass(frozen=True)
class Predictions:
    """What is predicted at one force: by increasing threshold, of each kind."""

    oscillating: tuple[Prediction, ...]
    buckled: tuple[Buckled, ...]


def predict(rod: RodParameters, force: Number, order: int = 3) -> tuple[Prediction, ...]:
    """One prediction per Hopf threshold of the leading eigenvalue, by increasing threshold.

    order: 3, or 5 for the curvatures of A_tip² and ω in the force. Thresholds are searched up to
    max(400, force), but not beyond k1. Raises InputError for a force outside [0, k1), and what `landau`
    raises.
    """
    return predictions(rod, force, order).oscillating


def predict_buckled(rod: RodParameters, force: Number) -> tuple[Buckled, ...]:
    """One prediction per steady crossing of the leading eigenvalue; range and errors as of `predict`."""
    return predictions(rod, force).buckled


def predictions(rod: RodParameters, force: Number, order: int = 3) -> Predictions:
    """What `predict` and `predict_buckled` give, by one search."""
    require_rod(rod)
    if order not in (3, HIGHEST):
        raise InputError(
            f"order is {shown(order)}, but the amplitude equation is evaluated to 3 or {HIGHEST}"
        )
    exact = rod.checked_force(force)
    found = landau(rod, max(exact, Fraction(DEFAULT_MAX_FORCE)))
    beyond = [amplitude_equation(rod, c.threshold, order) if order > 3 else None for c in found]
    at = float(exact)
    return Predictions(
        tuple(predict_at(c, at, equation) for c, equation in zip(found, beyond, strict=True)),
        tuple(buckled_at(t, pitchfork(rod, t), at) for t in found.search.steady),
    )


def buckled_at(threshold: HopfThreshold, form: Pitchfork, force: float) -> Buckled:
    """y_tip² = −(β/α)(F − F_c): da/dt = βδa + αa³ has the rate −2βδ there, and the others are stable."""
    if form.criticality == "degenerate":
        return Buckled(threshold, form, force, None, False, None, None, None)
    side: Literal["above", "below"] = "above" if form.y_tip2_slope > 0 else "below"
    detuning = force - threshold.force
    squared = form.y_tip2_slope * detuning
    if not squared > 0:
        return Buckled(threshold, form, force, side, False, None, None, None)
    squared_error = abs(detuning) * form.y_tip2_slope_error + abs(form.y_tip2_slope) * threshold.force_error
    return Buckled(
        threshold, form, force, side,
        exists=True,
        stable=form.beta * detuning > 0,
        y_tip=squared**0.5,
        y_tip_error=squared_error / (2 * squared**0.5),
    )  # fmt: skip


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
    omega_error = abs(detuning) * c.omega_slope_error + abs(c.omega_slope) * c.threshold.force_error
    omega_error += c.threshold.omega_error
    if beyond is not None and beyond.A_tip2_curvature is not None and beyond.omega_curvature is not None:
        squared += beyond.A_tip2_curvature * detuning**2
        omega += beyond.omega_curvature * detuning**2
        squared_error += beyond.A_tip2_curvature_error * detuning**2
        omega_error += beyond.omega_curvature_error * detuning**2
    A_tip = float(squared) ** 0.5 if squared > 0 else None
    return Prediction(
        c, force, side,
        exists=True,
        stable=bool(kernels.radial_stability(detuning, beta.real) < 0),
        A_tip=A_tip,
        omega=float(omega),
        A_tip_error=None if A_tip is None else squared_error / (2 * A_tip),
        omega_error=omega_error,
    )  # fmt: skip
