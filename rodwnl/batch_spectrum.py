"""Hopf thresholds of many straight rods at once: a closed characteristic function, counts, Newton.

For one rod `rodwnl.spectrum` finds thresholds from the eigenvalues of an operator. For many rods that is
too slow, so here everything is read off one analytic function of the force F and the eigenvalue λ
(`characteristic`). On a line F = const its phase along the imaginary axis counts the unstable eigenvalues
(`Lines`); between neighbouring lines the pair that may cross is followed, and where an interval is not
understood a line is put into its middle (`thresholds`). Where the load allows a real eigenvalue to cross,
the forces at which one does are found first (`rodwnl.batch_buckling`) and have a line on either side.

Arrays of one shape throughout: n rods, or n lines, each with its own rod. Lengths in L, times in γ2 L⁴/k3,
forces in k3/L².
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, ClassVar, Self, TypeVar

import numpy as np
from numpy.typing import NDArray

from rodwnl.batch_buckling import BESIDE, settled, steady_crossings
from rodwnl.batch_characteristic import (
    BLOCK,
    COMPILED_BLOCK,
    Complex,
    Real,
    along,
    jet,
    problem_with_slopes,
    sign_at_rest,
)
from rodwnl.batch_problem import Problem, problem
from rodwnl.batch_rods import Rods
from rodwnl.straightrod import StraightRod

Index = NDArray[np.int_]
Mask = NDArray[np.bool_]
R = TypeVar("R", bound="Rows")

FIRST_LINES = 9  # of the scan in the force: Chebyshev's points, as close to k1 much happens
POINTS = (11, 16, 25)  # on a line, from q = 1 or less to at least 8
FARTHER, MORE_POINTS = 16, 40  # of a line on which the count was not whole: how much farther it goes
RATIO = 1.25  # of the wave numbers of neighbouring points, if the line does not end too far out for that
NEAR = 1.2  # a turn of the phase between neighbouring points (radians) that betrays a pair near the axis
CLOSE = 2.0  # a turn whose sense is not trusted: the pair itself is computed
WHOLE, UNKNOWN = 0.2, -(10**6)  # of a number of eigenvalues: distance from an integer; the value if none
MARGIN = 0.1  # how far from the axis, of its variation, a followed pair must stay
MOST_BISECTIONS, MOST_OPEN = 24, 24  # halvings of an interval; intervals of one rod open at a time
MOST_STEPS = 12  # of Newton's method
ROUGHLY = 1e-2  # relative error of Re λ, in following a pair
CONVERGED = 1e-11  # a relative step of F and ω that leaves an error of its square


# ---- one line F = const


class Rows:
    """A record whose fields are arrays of one length."""

    __dataclass_fields__: ClassVar[dict[str, Any]]

    def __getitem__(self, which: Any) -> Self:
        return type(self)(*(getattr(self, name)[which] for name in self.__dataclass_fields__))


def joined(parts: Sequence[R]) -> R:
    """Records of one kind end to end."""
    names = parts[0].__dataclass_fields__
    return type(parts[0])(*(np.concatenate([getattr(part, name) for part in parts]) for name in names))


@dataclass(frozen=True)
class Lines(Rows):
    """n lines F = const of given rods.

    rod (n,): which rod. force (n,). unstable (n,): number of unstable eigenvalues; it is odd where a real one
    is past 0. near (n,): whether the pair of `guess` is close to the axis. guess (n,): approximate λ of the
    least stable pair of a stable line, else of an unstable pair; NaN where it is not known.
    """

    rod: Index
    force: Real
    unstable: Index
    near: Mask
    guess: Complex


def lines(rods: Rods, rod: Index, force: Real) -> Lines:
    """The number of unstable eigenvalues at these forces (n,) of the rods with these indices (n,)."""
    straight = rods[rod].at(force)
    here = problem(straight, rods.compiled)
    lowest, highest = _range(straight, here)
    enough = np.searchsorted(RATIO ** (np.array(POINTS[:-1]) - 1), highest / lowest)
    seen = _phases(here, lowest, highest, np.array(POINTS)[enough], rods.may_buckle)
    # Near the end of the straight rod D may come to its dominant term only far beyond the line's last point.
    if (short := np.flatnonzero(seen.unstable == UNKNOWN)).size:
        points = np.full(len(short), MORE_POINTS)
        longer = _phases(here[short], lowest[short], FARTHER * highest[short], points, rods.may_buckle)
        for name in seen.__dataclass_fields__:
            getattr(seen, name)[short] = getattr(longer, name)
    # A pair may be so close to the axis that the sense of its turn is lost: its own real part decides.
    lost = np.flatnonzero(seen.lost)
    lam, _ = follow(rods[rod[lost]], force[lost], seen.guess[lost])
    between = (seen.low[lost] < lam.imag) & (lam.imag < seen.high[lost])
    unstable, counted = lam.real > 0, seen.counted[lost]
    seen.unstable[lost] += np.where(between, 2 * (unstable.astype(int) - counted), 0)
    # else the pair lost is a stable one beside the unstable one
    meant = unstable | (seen.unstable[lost] == 0)
    seen.guess[lost] = np.where(meant, lam, seen.other[lost])
    seen.near[lost] = meant | seen.other_near[lost]
    return Lines(rod, force, seen.unstable, seen.near, seen.guess)


@dataclass(frozen=True)
class Phase(Rows):
    """What the phase of D shows on n lines; see `Lines`.

    lost (n,): the pair of `guess`, between ω = low and ω = high, is so close to the axis that its turn has
    no reliable sign. counted (n,): whether it was counted as unstable. other, other_near (n,): as guess and
    near, of the most nearly unstable of the other pairs.
    """

    unstable: Index
    near: Mask
    guess: Complex
    lost: Mask
    low: Real
    high: Real
    counted: Mask
    other: Complex
    other_near: Mask


def _range(straight: StraightRod, given: Problem) -> tuple[Real, Real]:
    """The wave numbers at which a line begins and ends: beyond D is its dominant term.

    The plain rod has its thresholds near 3. Drag at the tip slows everything down.
    """
    c4, c2, _ = given.exponents
    highest = np.maximum(8.0, 1.5 * np.sqrt(c2[0] / c4[0]))
    return 1 / (1 + np.broadcast_to(_tip_drag(straight), straight.force.shape)), highest


def _phases(given: Problem, lowest: Real, highest: Real, points: Index, may_buckle: bool) -> Phase:
    """`_phase` of n lines with so many points, (n,), block by block."""
    most = COMPILED_BLOCK if given.compiled else BLOCK
    groups = [(count, np.flatnonzero(points == count)) for count in np.unique(points).tolist()]
    blocks = [
        (count, group[i : i + most // count])
        for count, group in groups
        for i in range(0, len(group), most // count)
    ]
    parts = [_phase(given[p], lowest[p], highest[p], count, may_buckle) for count, p in blocks]
    return joined(parts)[np.argsort(np.concatenate([p for _, p in blocks]))]


def _phase(given: Problem, lowest: Real, highest: Real, points: int, may_buckle: bool) -> Phase:
    """The argument principle: arg D from ω = 0 to ∞ falls short of that of D's dominant term by π each.

    D is real at ω = 0; where it is negative there, a real eigenvalue has passed, and arg D begins at π. The
    points lie at the wave numbers q of ω = c4 q⁴/(c0' − q² c2'), with c0', c2' the slopes in λ, about the
    rate at which a wave of number q decays.
    """
    c4, c2, c0 = given.exponents
    low, steps = np.log(lowest), np.arange(points)[:, None] / (points - 1)
    q2 = np.exp(2 * (low + (np.log(highest) - low) * steps))  # (points, n), so that loops run over lines
    omega = c4[0] * q2 * q2 / (c0[1] - q2 * c2[1])
    scaled, turn, dominant = along(given, 1j * omega)
    turns = np.angle(scaled[1:] * np.conj(scaled[:-1]))
    start = scaled[0] * np.exp(1j * turn)
    if may_buckle:
        start = start * sign_at_rest(given)
    shortfall = np.angle(dominant) - (np.angle(start) - turn) - turns.sum(axis=0)
    unstable = np.rint(shortfall / np.pi)
    # far from a whole number: the line ends too early, or something overflowed
    whole = np.abs(shortfall / np.pi - unstable) < WHOLE
    unstable = np.where(whole, unstable, UNKNOWN).astype(int)

    def turn_at(at: Index) -> tuple[Any, ...]:
        """The pair that makes D turn after this point, by D's secant; the turn, and ω on both sides."""
        before, after, low, high = (x[at + k, line] for x in (scaled, omega) for k in (0, 1))
        return 1j * (low - before * (high - low) / (after - before)), turns[at, line], low, high

    line, sharpest = np.arange(len(start)), np.abs(turns).argmax(axis=0)
    lost = np.abs(turns[sharpest, line]) > CLOSE
    at = np.where(lost, sharpest, np.where(unstable > 0, turns.argmin(axis=0), turns.argmax(axis=0)))
    guess, turn, low, high = turn_at(at)
    turns[at, line] = np.pi
    other, other_turn, _, _ = turn_at(turns.argmin(axis=0))
    return Phase(unstable, np.abs(turn) > NEAR, guess, lost, low, high, turn < 0, other, other_turn < -NEAR)


def _tip_drag(straight: StraightRod) -> Any:
    """Drag at the tip over that of the rod, roughly: what of the tip conditions changes with λ."""
    total: Any = 0.0
    for name in ("y_tip_row", "theta_tip_row"):
        still, moving = (straight(name, lam=lam) for lam in (0.0, 1.0))
        total = total + sum(np.abs(b - a) for a, b in zip(still, moving, strict=True))
    return total / straight("drag_weights")[1]


def follow(rods: Rods, force: Real, guess: Complex) -> tuple[Complex, Complex]:
    """Roughly the eigenvalue near the guess at a force, and dλ/dF, by Newton's method; NaN if it is lost."""
    lam, slope = np.full((2, len(force)), np.nan + 0j)
    active = np.flatnonzero(_plausible(guess))
    here, given = guess[active], problem_with_slopes(rods[active], force[active])
    for _ in range(MOST_STEPS):
        D, D_F, D_lam = jet(given, here)
        step = D / D_lam
        here = here - step
        # the error that is left is about step²/λ: it must not matter for the distance from the axis
        error = np.abs(step) ** 2 / np.abs(here)
        settled = (error <= ROUGHLY * np.abs(here.real)) & (error <= ROUGHLY * np.abs(here))
        lam[active[settled]], slope[active[settled]] = here[settled], (-D_F / D_lam)[settled]
        going = ~settled & _plausible(here)
        active, here, given = active[going], here[going], given[going]
        if not active.size:
            break
    return lam, slope


def _plausible(lam: Complex) -> Mask:
    """One of a pair of complex eigenvalues that may come to the axis; False for NaN."""
    return (lam.imag > 0) & (np.abs(lam.real) < 10 * lam.imag)


# ---- intervals between lines


@dataclass(frozen=True)
class Crossings:
    """Thresholds of the leading eigenvalue, ordered by rod and force; and the rods that were not understood.

    rod, force, omega (m,). slope (m,): dλ/dF from the characteristic function. residual (m,): last Newton
    step of (F, ω), relative. undecided: indices of rods on which intervals were left open. buckling (n,): the
    smallest force at which the leading eigenvalue crosses at 0, NaN where there is none. unloaded (n,): how
    many eigenvalues are unstable without a force, as under a spring that pushes.
    """

    rod: Index
    force: Real
    omega: Real
    slope: Complex
    residual: Real
    undecided: set[int]
    buckling: Real
    unloaded: Index


def thresholds(rods: Rods, max_force: Real) -> Crossings:
    """Every crossing of the imaginary axis by the leading eigenvalue in (0, max_force], for n rods.

    An interval between two lines is understood when the pair that might cross in it, followed from one end
    to the other, keeps its side by a margin or crosses once, and the counts at the ends say the same.
    Otherwise it is halved. Where more than one pair, or a real eigenvalue, is unstable at both ends no pair
    is followed.
    """
    count = len(max_force)
    left, right = _first_intervals(rods, max_force)
    unloaded = left.unstable[left.force == 0]
    buckling = np.full(count, np.nan)
    found: list[tuple[Any, ...]] = []
    hopeless: set[int] = set()
    for _ in range(MOST_BISECTIONS):
        lost = (left.unstable < 0) | (right.unstable < 0)
        hopeless.update(left.rod[lost].tolist())
        left, right = left[~lost], right[~lost]
        decided, crossings = _decide(rods, left, right)
        found.append(crossings)
        steady = (
            decided
            & (np.minimum(left.unstable, right.unstable) == 0)
            & ((left.unstable + right.unstable) == 1)
        )
        np.fmin.at(buckling, left.rod[steady], (left.force + right.force)[steady] / 2)
        left, right = left[~decided], right[~decided]
        many = np.bincount(left.rod, minlength=count)[left.rod] > MOST_OPEN
        hopeless.update(left.rod[many].tolist())
        left, right = left[~many], right[~many]
        if not left.rod.size:
            break
        middle = lines(rods, left.rod, (left.force + right.force) / 2)
        left, right = joined([left, middle]), joined([middle, right])
    buckled = np.flatnonzero(np.isfinite(buckling))
    buckling[buckled] = settled(rods[buckled], buckling[buckled])
    rod, force, omega, slope, residual = (np.concatenate(x) for x in zip(*found, strict=True))
    order = np.lexsort((force, rod))
    undecided = hopeless | set(left.rod.tolist())
    return Crossings(
        rod[order], force[order], omega[order], slope[order], residual[order], undecided, buckling, unloaded
    )


def _first_intervals(rods: Rods, max_force: Real) -> tuple[Lines, Lines]:
    """Intervals between lines at Chebyshev's points, and on both sides of every steady crossing."""
    count = len(max_force)
    rod, parts = np.arange(count), np.sin(np.pi / 2 * np.linspace(0, 1, FIRST_LINES)[1:]) ** 2
    which, force = np.tile(rod, len(parts)), np.outer(parts, max_force).ravel()
    if not rods.may_buckle:
        # its operator is negative at F = 0
        unloaded = Lines(
            rod, np.zeros(count), np.zeros(count, int), np.zeros(count, bool), np.full(count, np.nan + 0j)
        )
        loaded = lines(rods, which, force)
        return joined([unloaded, loaded[: -count or None]]), loaded
    crossing, steady = steady_crossings(rods, max_force)
    which = np.concatenate([rod, which, crossing, crossing])
    beside = steady * (1 - BESIDE), np.minimum(steady * (1 + BESIDE), max_force[crossing])
    everything = lines(rods, which, np.concatenate([np.zeros(count), force, *beside]))
    ordered = everything[np.lexsort((everything.force, everything.rod))]
    same = np.flatnonzero(ordered.rod[1:] == ordered.rod[:-1])
    return ordered[same], ordered[same + 1]


def _decide(rods: Rods, left: Lines, right: Lines) -> tuple[Mask, tuple[Any, ...]]:
    """Per interval whether it is understood, and the crossings on those that are."""
    fewest, most = np.minimum(left.unstable, right.unstable), np.maximum(left.unstable, right.unstable)
    crosses = (fewest == 0) & (most == 2)
    # An odd change belongs to a steady crossing, and its interval is narrow.
    narrow = right.force - left.force <= 3 * BESIDE * right.force
    understood = np.where(
        (most - fewest) % 2 == 1, narrow & ((fewest > 0) | (most == 1)), (fewest > 0) | (most < 4)
    )
    lam, slope = np.full((2, len(most)), np.nan + 0j)
    for start, end in ((left, right), (right, left)):
        # The pair that crosses is followed from where it is unstable. Any other near the axis must be seen
        # to keep its side; an unstable one only if it is the only one.
        alone = (start.unstable == 0) | ((start.unstable == 2) & (fewest % 2 == 0))
        asked = np.where(crosses, start.unstable == 2, start.near & alone & ((most - fewest) % 2 == 0))
        i = np.flatnonzero(asked & understood)
        understood[i], lam[i], slope[i] = _understood(rods, start[i], end[i], crosses[i])
    which = np.flatnonzero(understood & crosses)
    understood[which], crossings = _crossings(rods, left[which], right[which], lam[which], slope[which])
    return understood, crossings


def _understood(rods: Rods, start: Lines, end: Lines, crosses: Mask) -> tuple[Mask, Complex, Complex]:
    """Whether the pair at the start keeps its side up to the end, or crosses once; the pair and its slope.

    A pair that does not leave the axis behind is followed to the end, and must keep its side by a margin.
    """
    here, step = rods[start.rod], end.force - start.force
    side = np.where(start.unstable > 0, 1, -1)
    lam, slope = follow(here, start.force, start.guess)
    good = (slope.real * step * side > 0) & ~crosses  # it leaves the axis behind
    i = np.flatnonzero(~good)
    step, before, by_force = step[i], lam[i], slope[i]
    after, by_force_after = follow(here[i], end.force[i], before + step * by_force)
    change = after - before
    smooth = np.abs(change - step * (by_force + by_force_after) / 2) < np.abs(change) / 2 + ROUGHLY * np.abs(
        before.real
    )
    # Bernstein coefficients of the cubic Hermite interpolant of Re λ
    path = np.stack([before, before + step * by_force / 3, after - step * by_force_after / 3, after]).real
    own = path * side[i]
    keeps = np.min(own, axis=0) > MARGIN * np.ptp(path, axis=0)
    signs = own > 0
    once = signs[0] & ~signs[3] & (np.diff(signs, axis=0).sum(axis=0) == 1)
    good[i] = smooth & np.where(crosses[i], once, keeps)
    return good, lam, slope


def _crossings(
    rods: Rods, left: Lines, right: Lines, lam: Complex, slope: Complex
) -> tuple[Mask, tuple[Any, ...]]:
    """Newton's method for D(F, iω) = 0, F and ω real, on intervals that hold one crossing each.

    lam, slope: of the pair that crosses, at the end where it is unstable.

    With dλ/dF = −D_F/D_λ:  D + D_F dF + i D_λ dω = 0  is  (dλ/dF) dF − i dω = D/D_λ.
    """
    rods = rods[left.rod]
    rises = right.unstable == 2
    force = np.where(rises, right.force, left.force)
    first = np.clip(-lam.real / slope.real, left.force - force, right.force - force)
    omega, force, slope = (lam + first * slope).imag, force + first, slope.copy()
    residual, active = np.full(len(force), np.inf), np.arange(len(force))
    for _ in range(MOST_STEPS):
        D, D_F, D_lam = jet(problem_with_slopes(rods[active], force[active]), 1j * omega[active])
        by_force, offset = -D_F / D_lam, D / D_lam
        step = offset.real / by_force.real
        turn = by_force.imag * step - offset.imag
        force[active] += step
        omega[active] += turn
        slope[active] = by_force
        residual[active] = np.abs(step) / np.abs(force[active]) + np.abs(turn) / np.abs(omega[active])
        active = active[residual[active] > CONVERGED]
        if not active.size:
            break
    inside = (left.force <= force) & (force <= right.force) & (omega > 0)
    settled = (residual <= CONVERGED) & inside & ((slope.real > 0) == rises)
    parts = (left.rod, force, omega, slope, residual)
    return settled, tuple(part[settled] for part in parts)
