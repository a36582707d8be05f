"""Where the leading eigenvalues λ(F) of a rod cross the imaginary axis, from samples of λ and dλ/dF.

The range of forces is bisected until, on each interval and for each eigenvalue that matters, the cubic
Hermite interpolant of λ(F) crosses the axis surely, or surely not. Lengths in L, times in γ2 L⁴/k3, forces
in k3/L².
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from rodwnl.errors import ComputationError
from rodwnl.inverse import KEPT, Complex, Real

Crossing = tuple[float, float, float, float]  # low, high: the interval that holds it alone; about F, ω

FIRST_INTERVALS = 16  # of the scan in the force; bisection does the rest
NARROWEST = 1e-9  # of the range: an interval not decided at this width holds a tangency
STEADY = 1e-8  # an eigenvalue relative to the next one, below which its sign may be round-off
MOST_SAMPLES = 200  # of the scan: 33 to 41 are usual, 70 where two thresholds nearly merge
KEPT_FOR_ALL = 30  # eigenvalues taken, at least, when all crossings are asked for; else KEPT
MOST_KEPT = 110  # more cost seconds a force, and those of largest modulus meet and part too often
MORE_KEPT = 4  # beyond those that hold all unstable ones


class Spectrum(Protocol):
    """What the scan asks of a rod."""

    def leading(self, force: Real, kept: int) -> tuple[Complex, Complex]:
        """The `kept` eigenvalues λ of least modulus and dλ/dF, (n, kept) each, for forces (n,)."""

    def marks(self, upper: float) -> Real:
        """Forces from which the scan starts too: they enclose every steady crossing closely."""

    def unstable(self, force: float) -> int:
        """The number of eigenvalues with Re λ > 0, computed more finely."""

    def settled(self, low: float, high: float) -> tuple[bool, float | None]:
        """Whether nothing crosses in an interval with a real eigenvalue near 0, known by other means than its
        sign, and the force near it at which it touches 0.
        """


@dataclass(frozen=True)
class Samples:
    """Leading eigenvalues at n forces: force (n,), eigenvalue and slope dλ/dF (n, m)."""

    force: Real
    eigenvalue: Complex
    slope: Complex

    def __getitem__(self, which: slice | NDArray[np.bool_]) -> Samples:
        return Samples(self.force[which], self.eigenvalue[which], self.slope[which])

    def followed_by(self, other: Samples) -> Samples:
        """These and the others."""
        return Samples(
            np.concatenate([self.force, other.force]),
            np.concatenate([self.eigenvalue, other.eigenvalue]),
            np.concatenate([self.slope, other.slope]),
        )


def scan(
    rod: Spectrum, upper: float, all_crossings: bool = False
) -> tuple[Samples, list[Crossing], list[float]]:
    """All samples taken, all crossings seen, and the forces at which a real eigenvalue only touches 0.

    Open intervals are bisected together until none is left.
    """
    kept = _kept_for_all(rod, upper) if all_crossings else KEPT

    def sampled(force: Real) -> Samples:
        return Samples(force, *rod.leading(force, kept))

    seen = sampled(np.union1d(np.linspace(0.0, upper, FIRST_INTERVALS + 1), rod.marks(upper)))
    if _nearly_steady(seen)[0]:
        raise ComputationError(
            "at F = 0 the straight rod is neither stable nor unstable: an eigenvalue is 0 to rounding; "
            "change a parameter a little"
        )
    left, right = seen[:-1], seen[1:]
    crossings: list[Crossing] = []
    touches: set[float] = set()
    while left.force.size and upper > 0:
        middle = sampled((left.force + right.force) / 2)
        seen = seen.followed_by(middle)
        decided, new = _decide(left, middle, right, all_crossings)
        crossings += new
        for i in np.flatnonzero(~decided & _nearly_steady(middle)):
            decided[i], touched = rod.settled(float(left.force[i]), float(right.force[i]))
            touches |= set() if touched is None else {touched}
        left, middle, right = left[~decided], middle[~decided], right[~decided]
        left, right = left.followed_by(middle), middle.followed_by(right)
        too_narrow = np.any(right.force - left.force < NARROWEST * upper)
        if too_narrow or (left.force.size and len(seen.force) > MOST_SAMPLES):
            raise ComputationError(_open(left))
    return seen, crossings, sorted(touches)


def _nearly_steady(samples: Samples) -> NDArray[np.bool_]:
    """Where one eigenvalue, a real one then, is so close to 0 that its sign may be round-off."""
    size = np.sort(np.abs(samples.eigenvalue), axis=1)
    return np.asarray(size[:, 0] < STEADY * size[:, 1])


def _kept_for_all(rod: Spectrum, upper: float) -> int:
    """So many that all unstable ones are among them: an eigenvalue that leaves them is not to be counted.

    Of a rod soft in shear dozens are unstable, and as the force grows others have a smaller modulus.

    Raises ComputationError where MOST_KEPT are too few.
    """
    forces = upper * np.arange(1, 5) / 4
    unstable = np.array([rod.unstable(force) for force in forces])
    kept = KEPT_FOR_ALL
    while kept <= MOST_KEPT:
        eigenvalues, _ = rod.leading(forces, kept)
        seen = np.sum(eigenvalues[:, : kept - MORE_KEPT].real > 0, axis=1)
        if np.all(seen == unstable):
            return kept
        taken, kept = kept, 3 * kept // 2
    at = int(np.argmax(unstable - seen))
    raise ComputationError(
        f"at F = {forces[at]:.10g} the rod has {unstable[at]} unstable eigenvalues, and only {seen[at]} are "
        f"among the {taken} of least modulus: not all can be followed; search a smaller range (max_force) or "
        f"for the leading crossings alone"
    )


def _open(left: Samples) -> str:
    """What the scan could not decide: the eigenvalue next to the axis on the first interval left."""
    first = int(np.argmin(left.force))
    eigenvalues = left.eigenvalue[first]
    return undecided(float(left.force[first]), complex(eigenvalues[np.argmin(np.abs(eigenvalues.real))]))


def undecided(force: float, eigenvalue: complex) -> str:
    return (
        f"near F = {force:.10g} double precision cannot tell whether the eigenvalue {eigenvalue:.6g} crosses "
        f"the imaginary axis: it touches it there, or meets another one; search up to there (max_force) or "
        f"change a parameter a little"
    )


def _decide(
    left: Samples, middle: Samples, right: Samples, all_crossings: bool
) -> tuple[NDArray[np.bool_], list[Crossing]]:
    """Per interval whether all that matters on it is known, and the crossings on those intervals."""
    followed = 2 * middle.eigenvalue.shape[1] // 3  # the others only serve as partners at the ends
    middle = Samples(middle.force, middle.eigenvalue[:, :followed], middle.slope[:, :followed])
    step = (middle.force - left.force)[:, None]
    before, after = _partners(left, middle, -step), _partners(right, middle, step)
    here = middle.eigenvalue, middle.slope
    # The error of the cubic over the whole interval, at its midpoint, bounds those over the halves.
    error = np.abs(((before[0] + after[0]) / 2 + step / 4 * (before[1] - after[1]) - here[0]).real)
    # Real all along, or of a pair all along: where two real ones become a pair there is no cubic.
    sides = [np.sign(eigenvalue.imag) for eigenvalue, _ in (before, here, after)]
    smooth = (sides[0] == sides[1]) & (sides[1] == sides[2])

    known, unstable = np.ones_like(error, dtype=bool), np.ones_like(error, dtype=bool)
    change, crossings = np.zeros(len(left.force)), []
    halves = (_bernstein(before, here, step), left.force), (_bernstein(here, after, step), middle.force)
    for half, start in halves:
        real, rise = half.real, np.diff(half.real, axis=0)
        above, below = np.all(real > error, axis=0), np.all(real < -error, axis=0)
        slow, fast = np.min(np.abs(rise), axis=0), np.max(np.abs(rise), axis=0)
        even = smooth & np.all(rise * rise[0] > 0, axis=0) & (slow > error) & (slow > fast / 4)
        crosses = (real[0] < 0) != (real[3] < 0)
        known &= above | below | even
        unstable &= above & smooth  # else the ends belong to two branches, and nothing is known between
        change += np.sum(np.where(crosses, np.sign(rise[0]), 0), axis=1)
        crossings.append((half, start, crosses & (middle.eigenvalue.imag >= 0)))
    decided = known.all(axis=1) & (_unstable(right) - _unstable(left) == change)
    throughout = unstable.any(axis=1) & (not all_crossings)
    return decided | throughout, [
        _crossing(half[:, i, j], float(start[i]), float(step[i, 0]))
        for half, start, crosses in crossings
        for i, j in np.argwhere(crosses & (decided & ~throughout)[:, None])
    ]


def _partners(end: Samples, middle: Samples, step: Real) -> tuple[Complex, Complex]:
    """For each eigenvalue at the middle the one at the end, at distance `step`, that continues it.

    It is the one that the trapezoidal rule fits best.
    """
    slope = (end.slope[:, None, :] + middle.slope[:, :, None]) / 2
    rise = end.eigenvalue[:, None, :] - middle.eigenvalue[:, :, None]
    best = np.argmin(np.abs(rise - step[..., None] * slope), axis=2)
    return np.take_along_axis(end.eigenvalue, best, 1), np.take_along_axis(end.slope, best, 1)


def _bernstein(start: tuple[Complex, Complex], end: tuple[Complex, Complex], step: Real) -> Complex:
    """Bernstein coefficients of the cubic Hermite interpolant: it lies between their extremes."""
    (a, a_slope), (b, b_slope) = start, end
    return np.stack([a, a + step * a_slope / 3, b - step * b_slope / 3, b])


def _crossing(bernstein: Complex, start: float, step: float) -> Crossing:
    """Where the cubic λ on [start, start + step] has Re λ = 0, by bisection (de Casteljau's algorithm)."""
    low, high, value = 0.0, 1.0, bernstein[0]
    while high - low > 1e-12:
        s, b = (low + high) / 2, bernstein
        while len(b) > 1:
            b = (1 - s) * b[:-1] + s * b[1:]
        value = b[0]
        low, high = (low, s) if (value.real > 0) == (bernstein[3].real > 0) else (s, high)
    return start, start + step, start + step * low, float(value.imag)


def _unstable(samples: Samples) -> NDArray[np.int_]:
    return np.asarray(np.sum(samples.eigenvalue.real > 0, axis=-1))


def highest(rod: Spectrum, seen: Samples, rounds: int) -> tuple[float, float]:
    """The largest Re λ and its force; each round looks more closely around the highest sample."""
    for _ in range(rounds):
        order = np.argsort(seen.force)
        force = seen.force[order]
        at = int(np.argmax(seen.eigenvalue.real.max(axis=1)[order]))
        between = np.linspace(force[max(at - 1, 0)], force[min(at + 1, len(force) - 1)], 7)[1:-1]
        seen = seen.followed_by(Samples(between, *rod.leading(between, seen.slope.shape[1])))
    growth = seen.eigenvalue.real.max(axis=1)
    return float(growth.max()), float(seen.force[np.argmax(growth)])
