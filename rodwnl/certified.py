"""A Hopf threshold as a theorem: existence, uniqueness, direction of crossing, rank, α, β, criticality.

Everything is computed with Arb balls (rodwnl/balls.py) from the rod's exact rational parameters. A number is
given out only as a ball that contains the truth; where a step proves nothing, ComputationError says which.

1. Krawczyk's test isolates the solution (F, ω) of D(iω, F) = 0 (rodwnl/isolation.py). 2. D_λ ≠ 0: iω is a
simple eigenvalue. Re dλ/dF = −Re D_F/D_λ ≠ 0: it crosses the axis, in the direction of that sign. 3. The
eigenvalues to the right of the imaginary axis are counted (rodwnl/halfplane.py). 4. α and β follow from the
closed forms (rodwnl/closedform.py); the sign of Re α is the criticality.
"""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from typing import Literal

from rodwnl import kernels
from rodwnl.balls import BallNumbers, flint, relative_accuracy, working_bits
from rodwnl.closedform import coefficients, critical_state
from rodwnl.errors import ComputationError
from rodwnl.exact import checked_digits
from rodwnl.fields import Scalar
from rodwnl.halfplane import count_right_of, unstable_region
from rodwnl.isolation import Box, DecimalBox, eigenvalue_slope, tight_box, uniqueness_box
from rodwnl.linearrod import LinearRod, linear_rod, require_form
from rodwnl.parameters import RodParameters
from rodwnl.straightrod import arguments
from rodwnl.uniformrod import require_uniform

GUARD = 20  # digits carried beyond those asked for, at first; doubled where they do not suffice
ATTEMPTS = 6
COUNT_BITS = 128  # for whole numbers and wide boxes more bits than this do not help
STRIP = range(2, 40, 2)  # the axis is crossed by the pair alone within ω/2^n, for one of these n

Crossing = Literal["destabilizing", "restabilizing"]
Criticality = Literal["supercritical", "subcritical"]


@dataclass(frozen=True)
class CertifiedThreshold:
    """Real balls (arb) that contain the threshold's numbers, and what was proved of it.

    alpha, beta: the balls of their real and imaginary parts. A_tip2_slope, omega_slope: slopes in the force
    along the branch, at its onset. unique_in: no other threshold lies in this box. unstable: number of
    eigenvalues with Re λ >= 0 at the threshold, not counting the pair ±iω (0: the pair is leading). proved:
    one sentence a statement.
    """

    force: Scalar
    omega: Scalar
    alpha: tuple[Scalar, Scalar]
    beta: tuple[Scalar, Scalar]
    A_tip2_slope: Scalar
    omega_slope: Scalar
    crossing: Crossing
    criticality: Criticality
    unstable: int
    unique_in: DecimalBox
    proved: tuple[str, ...]
    digits: int


@dataclass(frozen=True)
class _Enclosures:
    """The balls at one working precision; slope: dλ/dF from the characteristic function."""

    box: Box
    alpha: Scalar
    beta: Scalar
    slopes: tuple[Scalar, Scalar]
    slope: Scalar

    @property
    def numbers(self) -> list[Scalar]:
        parts = [self.alpha.real, self.alpha.imag, self.beta.real, self.beta.imag]
        return [self.box.force, self.box.omega, *parts, *self.slopes]


def certify_threshold(rod: RodParameters, force: float, omega: float, digits: int = 30) -> CertifiedThreshold:
    """Prove what can be proved of the Hopf threshold near (force, omega), every ball good to `digits` digits.

    Raises InputError for digits outside 1…10000 or without python-flint, ComputationError naming the step
    that failed.
    """
    digits = checked_digits(digits)
    require_uniform(rod, "a certificate")
    flint()
    with working_bits(COUNT_BITS), _step("the form of the linear problem"):
        require_form(rod, flint().arb(force))
    with working_bits(COUNT_BITS), _step("existence and uniqueness of the threshold"):
        unique_in = uniqueness_box(rod, force, omega)
    found = _enclosures_to(rod, force, omega, digits, unique_in)
    if not found.beta.overlaps(found.slope):
        raise ComputationError(
            f"beta = {found.beta.str(9)} contradicts dλ/dF = {found.slope.str(9)}: a mistake in rodwnl"
        )
    with working_bits(COUNT_BITS), _step("the count of unstable eigenvalues"):
        unstable = _unstable_besides_the_pair(linear_rod(rod, found.box.force), found.box.omega)
    crossing: Crossing = "destabilizing" if found.beta.real > 0 else "restabilizing"
    criticality: Criticality = "supercritical" if found.alpha.real < 0 else "subcritical"
    return CertifiedThreshold(
        found.box.force, found.box.omega,
        (found.alpha.real, found.alpha.imag), (found.beta.real, found.beta.imag), *found.slopes,
        crossing, criticality, unstable, unique_in,
        _statements(rod, unique_in, unstable, crossing, criticality), digits,
    )  # fmt: skip


def _straight_statement(rod: RodParameters) -> tuple[str, ...]:
    """What is proved of a stretch that is not explicit in the force (`BallNumbers.stretch`)."""
    if "nu" not in arguments(kernels.load(rod.model).straight_rod):
        return ()
    return (
        "under each of these forces there is a straight rod whose stretch stiffness is positive for every "
        "stretch from its own to 1, so none between holds the balance too",
    )


def _statements(
    rod: RodParameters, unique_in: DecimalBox, unstable: int, crossing: Crossing, criticality: Criticality
) -> tuple[str, ...]:
    direction = "from left to right" if crossing == "destabilizing" else "from right to left"
    count = {0: "no eigenvalue has", 1: "one eigenvalue has"}.get(unstable, f"{unstable} eigenvalues have")
    return (
        f"for force in {' +/- '.join(unique_in.force)} and omega in {' +/- '.join(unique_in.omega)} there is "
        "one and only one pair (force, omega) such that i omega is an eigenvalue",
        *_straight_statement(rod),
        f"there i omega is a simple eigenvalue, and it crosses the imaginary axis {direction} as the force "
        "grows, with the speed Re beta, which is not 0",
        f"besides ±i omega {count} Re lambda >= 0 there: the crossing pair is "
        f"{'leading' if unstable == 0 else 'not leading'}",
        f"Re alpha {'< 0' if criticality == 'supercritical' else '> 0'}: the bifurcation is {criticality}",
        "every number lies in the ball given for it",
    )


@contextmanager
def _step(name: str) -> Iterator[None]:
    """Names the step that was not proved. A division by a ball that contains 0 is such a failure."""
    try:
        yield
    except (ComputationError, ZeroDivisionError, ValueError) as error:
        raise ComputationError(f"not proved: {name}: {error}") from error


def _enclosures_to(
    rod: RodParameters, force: float, omega: float, digits: int, unique_in: DecimalBox
) -> _Enclosures:
    """Enclosures with that many digits: the working precision is raised until they have them."""
    failure = ComputationError("")
    for attempt in range(ATTEMPTS):
        working = digits + GUARD * 2**attempt
        try:
            found = _enclosures(rod, force, omega, working, unique_in)
        except ComputationError as error:
            failure = error
            continue
        worst = min(relative_accuracy(x) for x in found.numbers)
        if worst >= digits + 1:
            return found
        failure = ComputationError(
            f"not proved: enclosures to {digits} digits: with {working} working digits one number has only "
            f"{max(worst, 0):.0f} (it may be 0)"
        )
    raise failure


def _enclosures(
    rod: RodParameters, force: float, omega: float, working: int, unique_in: DecimalBox
) -> _Enclosures:
    acb = flint().acb
    with working_bits(int(3.33 * working) + 16):
        with _step("an enclosure of the threshold"):
            box = tight_box(rod, force, omega, working, unique_in)
        with _step("a simple eigenvalue that crosses the axis"):
            slope = eigenvalue_slope(rod, box)
        with _step("enclosures of alpha and beta"):
            found = coefficients(critical_state(rod, acb(box.force), acb(box.omega), BallNumbers()))
            a, b = found.alpha, found.beta
            if not (a.is_finite() and b.is_finite()):
                raise ComputationError("a divisor may be 0")
        with _step("the criticality"):
            if a.real.contains(0):
                raise ComputationError("Re alpha may be 0; terms of fifth order would decide")
            A_tip2_slope = kernels.tip_amplitude_squared_slope(a.real, b.real)
            omega_slope = kernels.frequency_slope(a.real, a.imag, b.real, b.imag)
    return _Enclosures(box, a, b, (A_tip2_slope, omega_slope), slope)


def _unstable_besides_the_pair(rod: LinearRod, omega: Scalar) -> int:
    """The number of eigenvalues with Re λ >= 0 other than ±iω, which must be alone in |Re λ| <= δ."""
    for n in STRIP:
        margin = (omega / 2**n).mid()
        region = unstable_region(rod, margin)
        right = count_right_of(rod, -margin, region)
        unstable = 0 if right == 2 else count_right_of(rod, margin, region)
        if right == unstable + 2:
            return unstable
    raise ComputationError("other eigenvalues lie too close to the imaginary axis")
