"""Exact evaluation: a threshold and its α, β to as many correct digits as asked for.

Everything is in closed form (rodwnl/closedform.py); what remains is rounding, and it is measured. All is
evaluated at two working precisions, and digits are given out only when both agree on them. Where numbers
cancel (stiff rods, exponents that nearly coincide) the working precision rises by the digits that were seen
to be lost.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from fractions import Fraction
from typing import Literal

import mpmath as mp

from rodwnl import kernels
from rodwnl.closedform import Coefficients, boundary_rows, coefficients, critical_state, determinant
from rodwnl.errors import ComputationError, InputError
from rodwnl.fields import MpArithmetic, Scalar
from rodwnl.parameters import RodParameters
from rodwnl.uniformrod import Balance, require_uniform

MAX_DIGITS = 10_000
GUARD = 15  # digits carried beyond those asked for, at first
ATTEMPTS = 8  # how often the working precision is raised before giving up
MOST_STEPS = 60  # of Newton's method for the stretch, which starts with 16 digits
MAX_STEP = 0.1  # a longer relative step of Newton's iteration leaves the threshold that it was started at


class MpNumbers(MpArithmetic):
    """mpmath at its current working precision, with what it takes to find modes."""

    def number(self, value: Fraction) -> Scalar:
        return mp.mpf(value.numerator) / value.denominator

    def sqrt(self, z: Scalar) -> Scalar:
        return mp.sqrt(z)

    def log(self, z: Scalar) -> Scalar:
        return mp.log(z)

    def sin(self, z: Scalar) -> Scalar:
        return mp.sin(z)

    def cos(self, z: Scalar) -> Scalar:
        return mp.cos(z)

    def stretch(self, force: Scalar, balance: Balance, start: Callable[[float], float]) -> Scalar:
        """Newton's method from the float64 solution, until a step is rounding."""
        nu = mp.mpf(start(float(force)))
        for _ in range(MOST_STEPS):
            defect, stiffness = balance(force, nu)
            step = defect / stiffness
            nu -= step
            # what is left is the square of the step, or rounding of terms of the size of the force
            if abs(step) <= mp.sqrt(mp.eps) * 1e-3 or abs(step) <= 8 * mp.eps * (1 + abs(force / stiffness)):
                return nu
        raise ComputationError(f"Newton's iteration finds no straight rod under force = {mp.nstr(force, 10)}")


@dataclass(frozen=True)
class ExactThreshold:
    """A Hopf threshold to `digits` digits, each of these numbers (of complex ones: each part).

    force, omega (mpf), alpha, beta (mpc), A_tip2_slope, omega_slope (mpf): dimensionless. alpha_parts,
    beta_parts: as in `Coefficients`, at the working precision. working_digits: the
    precision at which they were computed. agreement: the digits to which two working precisions agree.
    residuals: equations that were not imposed, relative to their terms, at the working precision.
    """

    force: Scalar
    omega: Scalar
    alpha: Scalar
    beta: Scalar
    alpha_parts: tuple[Scalar, Scalar]
    beta_parts: tuple[Scalar, Scalar]
    A_tip2_slope: Scalar
    omega_slope: Scalar
    digits: int
    working_digits: int
    agreement: float
    residuals: dict[str, Scalar]

    @property
    def crossing(self) -> Literal["destabilizing", "restabilizing"]:
        """By the sign of Re β."""
        return "destabilizing" if self.beta.real > 0 else "restabilizing"

    @property
    def criticality(self) -> Literal["supercritical", "subcritical"]:
        """By the sign of Re α, of which `digits` digits are known: it is not 0."""
        return "supercritical" if self.alpha.real < 0 else "subcritical"


def exact_threshold(rod: RodParameters, force: Scalar, omega: Scalar, digits: int = 30) -> ExactThreshold:
    """The Hopf threshold near (force, omega) and its α, β, to `digits` correct digits.

    force, omega: an approximation, good to a few digits. Raises InputError for digits outside 1…10000,
    ComputationError when there is no threshold near the approximation or the digits cannot be reached.
    """
    digits = checked_digits(digits)
    require_uniform(rod, "the exact route")
    working = digits + GUARD
    coarse = _evaluate(rod, mp.mpf(force), mp.mpf(omega), working)
    for _ in range(ATTEMPTS):
        lower, working = working, working + GUARD
        fine = _evaluate(rod, coarse.force, coarse.omega, working)
        with mp.workdps(working):
            numbers = _numbers(coarse), _numbers(fine)
            agreement = digits_agreed(*numbers)
            if agreement >= digits + 2 and same_texts(*numbers, digits):
                _require_consistent(fine, digits)
                return _record(fine, digits, working, agreement)
        lost = lower - int(agreement)
        coarse, working = fine, max(working, digits + lost) if agreement > 0 else 2 * working
    raise ComputationError(
        f"{digits} digits were not reached at the threshold near force {mp.nstr(coarse.force, 8)}: "
        f"with {lower} working digits two evaluations agree to {agreement:.0f}; is the crossing degenerate?"
    )


def checked_digits(digits: object) -> int:
    """The number of digits asked for, or InputError."""
    if isinstance(digits, bool) or not isinstance(digits, int) or not 1 <= digits <= MAX_DIGITS:
        raise InputError(f"digits is {digits!r}, but it must be a whole number from 1 to {MAX_DIGITS}")
    return digits


def _evaluate(rod: RodParameters, force: Scalar, omega: Scalar, working: int) -> Coefficients:
    """The threshold and its coefficients at one working precision."""
    with mp.workdps(working):
        force, omega = refine_threshold(rod, force, omega)
        return coefficients(critical_state(rod, force, omega, MpNumbers()))


def _require_consistent(c: Coefficients, digits: int) -> None:
    """What was not imposed must hold: a wrong formula would give digits that agree, and this in them."""
    name, worst = max(c.residuals.items(), key=lambda item: item[1])
    if worst > mp.mpf(10) ** -(digits // 2 + 1):
        raise ComputationError(
            f"at the threshold near force {mp.nstr(c.force, 8)} the formulas contradict each other (residual "
            f"{name!r}: {mp.nstr(worst, 2)}); compute this rod in double precision"
        )


def digits_agreed(a: Sequence[Scalar], b: Sequence[Scalar]) -> float:
    """Digits to which two evaluations of some real numbers agree, in the worst of them."""
    differing = [abs(x - y) / max(abs(x), abs(y)) for x, y in zip(a, b, strict=True) if x != y]
    return float(-mp.log10(max(differing))) if differing else float("inf")


def same_texts(a: Sequence[Scalar], b: Sequence[Scalar], digits: int) -> bool:
    """Whether both round alike: agreement alone does not decide the last digit of a number near a tie."""
    return all(digits_text(x, digits) == digits_text(y, digits) for x, y in zip(a, b, strict=True))


def _numbers(c: Coefficients) -> list[Scalar]:
    return [c.force, c.omega, c.alpha.real, c.alpha.imag, c.beta.real, c.beta.imag, *_slopes(c)]


def digits_text(value: Scalar, digits: int) -> str:
    """A real number rounded to so many significant digits, trailing zeros kept."""
    return str(mp.nstr(value, digits, strip_zeros=False))


def _slopes(c: Coefficients) -> tuple[Scalar, Scalar]:
    """Slopes of A_tip² and of ω in the force, along the branch at its onset."""
    a, b = c.alpha, c.beta
    return kernels.tip_amplitude_squared_slope(a.real, b.real), kernels.frequency_slope(
        a.real, a.imag, b.real, b.imag
    )


def _record(c: Coefficients, digits: int, working: int, agreement: float) -> ExactThreshold:
    return ExactThreshold(
        c.force, c.omega, c.alpha, c.beta, c.alpha_parts, c.beta_parts, *_slopes(c),
        digits, working, agreement, c.residuals,
    )  # fmt: skip


def refine_threshold(rod: RodParameters, force: Scalar, omega: Scalar) -> tuple[Scalar, Scalar]:
    """Newton for D(iω, F) = 0, two real equations, to the current working precision.

    Slopes are differences over 10^(−precision/2), so that every step still doubles the digits; the precision
    of a step follows the digits that are already there. Raises ComputationError when it does not converge.
    """
    final, precision = mp.mp.dps, 20
    for _ in range(60):
        precision = min(precision, final)
        with mp.workdps(precision + 5):
            step = _newton_step(rod, force, omega, mp.mpf(10) ** (-(precision // 2)))
            relative = max(abs(step[0] / force), abs(step[1] / omega))
            if relative > MAX_STEP:
                break
            force, omega = force + step[0], omega + step[1]
        if relative < mp.mpf(10) ** (-(precision // 2) - 1):
            if precision == final:
                return +force, +omega
            precision = 2 * precision - 5
    raise ComputationError(
        f"Newton's iteration finds no Hopf threshold near force {mp.nstr(force, 10)}, "
        f"omega {mp.nstr(omega, 10)}"
    )


def _newton_step(rod: RodParameters, force: Scalar, omega: Scalar, h: Scalar) -> tuple[Scalar, Scalar]:
    """(ΔF, Δω) with D + D_F ΔF + D_ω Δω = 0, slopes by differences over h; infinite if they are parallel."""
    D = characteristic(rod, force, omega)
    D_force = (characteristic(rod, force * (1 + h), omega) - D) / (force * h)
    D_omega = (characteristic(rod, force, omega * (1 + h)) - D) / (omega * h)
    cross = (D_force * D_omega.conjugate()).imag
    if cross == 0:
        return mp.inf, mp.inf
    return -(D * D_omega.conjugate()).imag / cross, -(D_force * D.conjugate()).imag / cross


def characteristic(rod: RodParameters, force: Scalar, omega: Scalar) -> Scalar:
    """The determinant of the four boundary conditions at λ = iω, an analytic function of (F, ω).

    Divided by λ(r1² − r2²)²/(r1 r2), to which the Wronskian of the four exponentials is proportional, it
    depends neither on the signs of the roots nor on their order.
    """
    state = critical_state(rod, force, omega, MpNumbers())
    D = determinant(boundary_rows(state, "boundary_column", state.lam))
    r1, _, r2, *_ = state.exponents.basis
    return D * r1 * r2 / (state.lam * (r1**2 - r2**2) ** 2)
