"""Every force at which an eigenvalue of the straight rod crosses the imaginary axis.

Seen by the inverse operator (rodwnl/inverse.py): λ(F) and dλ/dF of the leading eigenvalues, scanned until
none is undecided (rodwnl/scan.py). Made exact by the characteristic function (rodwnl/characteristic.py):
Newton's method for D(F, iω) = 0. For rods other than the plain one both are done by spectral integration
(rodwnl/collocated.py). Lengths in L, times in γ2 L⁴/k3, forces in k3/L².
"""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass, replace
from fractions import Fraction
from typing import Literal, Protocol

import numpy as np

from rodwnl.characteristic import characteristic, characteristic_slopes
from rodwnl.errors import ComputationError, InputError
from rodwnl.inverse import Complex, Floats, Real, leading_eigenvalues, unstable_count
from rodwnl.parameters import PLAIN, Number, RodParameters, exact, require_rod, shown
from rodwnl.scan import Spectrum, highest, scan, undecided

DEFAULT_MAX_FORCE = 400
CONVERGED, MOST_STEPS = 1e-10, 20  # of Newton's method: relative move from which only round-off is left
ROUNDING = 8  # rounding errors of a term of the determinant, in units of EPS
BESIDE = 1e-3  # relative distance from a threshold at which unstable eigenvalues are counted
EPS = float(np.finfo(float).eps)


@dataclass(frozen=True)
class HopfThreshold:
    """One crossing of the imaginary axis by a pair λ = ±iω of eigenvalues, or at ω = 0 by a real one.

    force, omega: F_c and ω_c >= 0. slope: dλ/dF there. unstable_below, unstable_above: numbers of
    eigenvalues with Re λ > 0 just below and above. residual: |D/(λ D_λ)|, the relative distance of iω from
    the exact zero (of a steady crossing: the distance in F, relative). force_error, omega_error: estimated
    absolute errors.
    """

    force: float
    omega: float
    slope: complex
    unstable_below: int
    unstable_above: int
    residual: float
    force_error: float
    omega_error: float

    @property
    def crossing(self) -> Literal["destabilizing", "restabilizing"]:
        """Which way the pair crosses as the force grows."""
        return "destabilizing" if self.slope.real > 0 else "restabilizing"

    @property
    def leading(self) -> bool:
        """Whether it is the leading eigenvalue that crosses: the straight rod is stable on one side."""
        return min(self.unstable_below, self.unstable_above) == 0

    @property
    def steady(self) -> bool:
        """Whether the rod buckles here and does not flutter: a real eigenvalue crosses, ω = 0."""
        return self.omega == 0


@dataclass(frozen=True)
class HopfSearch:
    """What was found for one rod in 0 <= F <= max_force. Iterates over `thresholds`.

    thresholds: crossings by a leading pair of eigenvalues, by increasing force. later: crossings by other
    eigenvalues, None if they were not asked for. range_cut: whether the range asked for was cut where the
    straight rod ends (of the plain rod at ν = 0, F = k1). growth, growth_force: the largest Re λ met and
    where; of the whole range if it is negative. evaluations: forces at which the scan computed the spectrum.
    steady: crossings by a leading real eigenvalue. touches: forces at which a real eigenvalue touches 0 and
    turns back. unstable_unloaded: number of eigenvalues with Re λ > 0 at F = 0, which a rod with a load of
    its own (a spring that pushes, say) may have.
    """

    rod: RodParameters
    max_force: Fraction
    range_cut: bool
    thresholds: tuple[HopfThreshold, ...]
    later: tuple[HopfThreshold, ...] | None
    growth: float
    growth_force: float
    evaluations: int
    steady: tuple[HopfThreshold, ...] = ()
    touches: tuple[float, ...] = ()
    unstable_unloaded: int = 0

    def __iter__(self) -> Iterator[HopfThreshold]:
        return iter(self.thresholds)

    def __len__(self) -> int:
        return len(self.thresholds)

    def __getitem__(self, index: int) -> HopfThreshold:
        return self.thresholds[index]


def hopf_thresholds(
    rod: RodParameters, max_force: Number | None = None, all_crossings: bool = False
) -> HopfSearch:
    """Every force 0 <= F <= max_force at which the straight rod begins or ceases to be unstable.

    max_force is 400 by default, and cut where the straight rod ends (the plain rod: at k1). With
    `all_crossings` the forces at which further eigenvalues cross are found too.

    What makes the list complete: the range is bisected until, on each interval and for each of the eight
    eigenvalues of least modulus, the cubic Hermite interpolant of Re λ(F) either keeps off the axis by
    more than its error, measured at the midpoint, or crosses it once with a slope that hardly varies.
    (Where one eigenvalue is clearly unstable on the whole interval, that is enough.) A window is missed
    only inside an interval on which the interpolant is right at the midpoint and wrong elsewhere by more
    than that. Besides, the thresholds must agree with the numbers of unstable eigenvalues beside them,
    counted with a finer operator. Steady crossings do not exist for the plain rod (`inverse_operator`).

    Raises InputError for a negative max_force; ComputationError where an eigenvalue touches the axis so
    closely that double precision cannot decide, where a count contradicts the crossings, or where a
    parameter is beyond the range of double precision.
    """
    upper, cut = searched_range(rod, max_force)
    route = route_of(rod)
    with finite():
        seen, crossings, touches = scan(route, float(upper), all_crossings)
        found = sorted((route.threshold(*crossing) for crossing in crossings), key=lambda t: t.force)
        unloaded = route.unstable(0.0)
        counted = _counted(route, found, unloaded, float(upper), all_crossings)
        growth, growth_force = highest(route, seen, rounds=0 if counted or unloaded else 3)
    if not (counted or unloaded) and growth > 0:
        raise ComputationError(
            f"at F = {growth_force:.10g} double precision gives an eigenvalue of real part {growth:.3g}, but "
            f"no crossing of the imaginary axis below: one was missed; search a smaller range (max_force)"
        )
    return HopfSearch(
        rod, upper, cut,
        thresholds=tuple(t for t in counted if t.leading and not t.steady),
        later=tuple(t for t in counted if not t.leading) if all_crossings else None,
        growth=growth, growth_force=growth_force,
        evaluations=len(seen.force),
        steady=tuple(t for t in counted if t.leading and t.steady),
        touches=tuple(touches),
        unstable_unloaded=unloaded,
    )  # fmt: skip


class Route(Spectrum, Protocol):
    """How the thresholds of a kind of rod are computed."""

    def threshold(self, low: float, high: float, force: float, omega: float) -> HopfThreshold:
        """The one crossing in [low, high], near this force and frequency; not yet counted (-1)."""


@dataclass(frozen=True)
class Exponentials:
    """The plain rod: inverse operator and characteristic function."""

    parameters: Floats

    def leading(self, force: Real, kept: int) -> tuple[Complex, Complex]:
        return leading_eigenvalues(self.parameters, force, kept)

    def marks(self, upper: float) -> Real:
        return np.empty(0)  # no real eigenvalue of the plain rod comes near 0

    def unstable(self, force: float) -> int:
        return unstable_count(self.parameters, force)

    def settled(self, low: float, high: float) -> tuple[bool, float | None]:
        return False, None

    def threshold(self, low: float, high: float, force: float, omega: float) -> HopfThreshold:
        return _newton(self.parameters, low, high, force, omega)


def route_of(rod: RodParameters) -> Route:
    """How the spectrum of this rod is computed."""
    if rod.model == PLAIN:
        return Exponentials(rod.floats())
    from rodwnl.thresholds import Collocation  # SciPy, which the plain rod does not need

    return Collocation(rod)


@contextmanager
def finite() -> Iterator[None]:
    """Turns numbers beyond float64's range, which would leave infinities, into a ComputationError."""
    try:
        with np.errstate(over="raise", divide="raise", invalid="raise"):
            yield
    except (ArithmeticError, np.linalg.LinAlgError) as error:
        raise ComputationError(
            f"a parameter is too large or too small for double precision ({error}); "
            f"take values between about 1e-100 and 1e100"
        ) from error


def searched_range(rod: RodParameters, max_force: Number | None) -> tuple[Fraction, bool]:
    """The force up to which to search: `max_force`, or where the straight rod ends before; if it was cut.

    Raises InputError for a negative force.
    """
    require_rod(rod)
    if max_force is None and rod.model == PLAIN:
        return min(rod.k1, Fraction(DEFAULT_MAX_FORCE)), rod.k1 < DEFAULT_MAX_FORCE
    asked = exact("max_force", DEFAULT_MAX_FORCE if max_force is None else max_force)
    if asked < 0:
        raise InputError(f"max_force is {shown(max_force)}, but a follower force is searched from 0 upwards")
    if rod.model == PLAIN:
        return min(asked, rod.k1), asked > rod.k1
    from rodwnl.straightrod import largest_force

    return largest_force(rod, asked)


def _newton(parameters: Floats, low: float, high: float, force: float, omega: float) -> HopfThreshold:
    """Solve D(F, iω) = 0 for real F and ω from a start in [low, high], where exactly one crossing lies.

    With dλ/dF = −D_F/D_λ:  D + D_F dF + i D_λ dω = 0  is  (dλ/dF) dF − i dω = D/D_λ.
    """
    moves = [np.inf]
    while moves[-1] > CONVERGED or moves[-1] < moves[-2] / 2:
        value, _, size = characteristic(parameters, force, 1j * omega)
        by_force, by_eigenvalue = characteristic_slopes(parameters, force, 1j * omega)
        slope, offset = -by_force / by_eigenvalue, complex(value) / by_eigenvalue
        step = offset.real / slope.real
        turn = slope.imag * step - offset.imag
        force, omega = force + step, omega + turn
        moves.append(abs(step) / force + abs(turn) / omega)
        if not (low - abs(step) <= force <= high + abs(step) and len(moves) < MOST_STEPS):
            raise ComputationError(undecided(low, 1j * omega))
    noise = ROUNDING * EPS * float(size) / abs(by_eigenvalue)  # of λ, at a given force
    force_error = noise / abs(slope.real) + EPS * force
    return HopfThreshold(
        force, omega, slope,
        unstable_below=-1, unstable_above=-1,  # until they are counted
        residual=abs(offset) / omega,
        force_error=force_error,
        omega_error=noise + abs(slope.imag) * force_error + EPS * omega,
    )  # fmt: skip


def _counted(
    route: Route, found: list[HopfThreshold], unloaded: int, upper: float, all_crossings: bool
) -> list[HopfThreshold]:
    """The thresholds with the numbers of unstable eigenvalues beside them, which must be consistent.

    unloaded: how many are unstable at F = 0; none of the plain rod, whose operator is negative there.
    """
    forces = [0.0, *(t.force for t in found), upper]
    counted, before = [], unloaded
    for threshold, low, high in zip(found, forces, forces[2:], strict=False):
        force = threshold.force
        below = route.unstable(force - min(BESIDE * force, (force - low) / 2))
        above = route.unstable(force + min(BESIDE * force, (high - force) / 2))
        _require_same(before, below, force, all_crossings)
        if above - below != (1 if threshold.steady else 2) * np.sign(threshold.slope.real):
            raise ComputationError(
                f"at F = {force:.10g} the number of unstable eigenvalues goes from {below} to {above}, which "
                f"does not agree with dλ/dF = {threshold.slope:.6g} of the one that crosses there; search up "
                f"to there (max_force)"
            )
        counted.append(replace(threshold, unstable_below=below, unstable_above=above))
        before = above
    _require_same(before, route.unstable(upper), upper, all_crossings)
    return counted


def _require_same(before: int, now: int, force: float, all_crossings: bool) -> None:
    """From one threshold to the next the number of unstable eigenvalues stays, or whether there are any."""
    if before != now if all_crossings else (before > 0) != (now > 0):
        raise ComputationError(
            f"below F = {force:.10g} there are {now} unstable eigenvalues, but {before} after the crossing "
            f"before, or at F = 0: one was missed; search a smaller range (max_force)"
        )
