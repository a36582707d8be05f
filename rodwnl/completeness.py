"""That a list of thresholds is complete: at no other force is an eigenvalue on the imaginary axis. A proof.

For small forces every eigenvalue is stable. With the norms and the inequalities of rodwnl/halfplane.py, now
for any scaling: y <= (2/π)‖Y'‖, t <= 2kX/π and ‖Y'‖ <= wX with w = h + 2bk/π give TS <= (4/π) kwX², a y <=
(2/π) kwX² and T² <= (4/π) k²X², so

    Re λ (wy y² + wθ t² + G) <= −X² + (2F + |f|) TS + 2F a y + s T²
                             <= −(1 − (4/π)(3F + |f|) kw − (4/π) s k²) X².

For larger ones an eigenvalue iω has |ω| <= |f| TS, which is bounded. What is left is a bounded set of (F, ω).
It is cut into boxes until each of them either lies in a box that is proved to hold exactly one threshold, or
D(iω, F) excludes 0.

A rod that buckles has zeros at ω = 0. D(0, F) is real; an interval of forces in which its slope keeps its
sign and its ends differ in sign has one zero. Beside it Im D(iω, F) = ∫₀^ω Re D_λ(is, F) ds, so where Re D_λ
keeps its sign on a box that reaches down to ω = 0 there is no zero with ω > 0.
"""

from __future__ import annotations

from collections.abc import Sequence
from contextlib import suppress
from dataclasses import dataclass, replace
from fractions import Fraction
from itertools import combinations, pairwise

from rodwnl.balls import BallNumbers, flint, working_bits
from rodwnl.errors import ComputationError
from rodwnl.fields import Scalar
from rodwnl.halfplane import Energy, characteristic, unstable_region
from rodwnl.isolation import (
    Box,
    DecimalBox,
    derivatives,
    steady_box,
    steady_enclosure,
    tight_box,
    uniqueness_box,
)
from rodwnl.linearrod import LinearRod, linear_rod, require_form
from rodwnl.parameters import RodParameters
from rodwnl.spectrum import HopfSearch, hopf_thresholds, searched_range
from rodwnl.uniformrod import require_uniform

REACH = Fraction(19, 20)  # of the forces that the straight rod bears; nearer the work grows without limit
BITS = 64
DIGITS = 30  # to which a crossing is compared with the end of the range
SLABS = 16  # pieces of the force range, each with its own bound of ω
NARROWEST_SLAB = 1e-4  # relative width of such a piece, before a bound is given up
MOST_BOXES = 400_000
NARROW = 0.2  # relative width in ω below which slopes are worth computing


@dataclass(frozen=True)
class Complete:
    """For 0 <= F <= max_force an eigenvalue lies on the imaginary axis at exactly `crossings` forces.

    steady: at how many of them it is 0.
    """

    max_force: Fraction
    crossings: int
    steady: int = 0


def prove_complete(search: HopfSearch) -> Complete:
    """Prove how many crossings there are in a search's range, short of REACH of what the straight rod bears.

    Raises InputError without python-flint, ComputationError where the proof fails.
    """
    rod = search.rod
    require_uniform(rod, "a certificate")
    flint()
    borne, _ = searched_range(rod, search.max_force / REACH)
    upper = min(search.max_force, REACH * borne)
    every = hopf_thresholds(rod, upper, all_crossings=True)
    if every.touches:
        raise ComputationError(
            f"not proved: near force {every.touches[0]:.10g} a real eigenvalue touches 0, and no ball tells "
            f"one double zero from none or two"
        )
    found = (*every.thresholds, *every.steady, *(every.later or ()))
    with working_bits(BITS):
        boxes = [uniqueness_box(rod, t.force, t.omega) for t in found if not t.steady]
        boxes += [steady_box(rod, t.force) for t in found if t.steady]
        isolated = [box.balls for box in boxes]
        for a, b in combinations(isolated, 2):
            if a.force.overlaps(b.force) and a.omega.overlaps(b.omega):
                raise ComputationError("not proved: two thresholds are too close for boxes of their own")
        for box in boxes:
            require_below(rod, box, upper)
        certify_complete(rod, upper, isolated)
    return Complete(upper, len(isolated), sum(t.steady for t in found))


def require_below(rod: RodParameters, isolated: DecimalBox, upper: Fraction) -> None:
    """The crossing of a box lies in the range, beyond which the box itself may reach, or ComputationError."""
    force, omega = float(isolated.force[0]), float(isolated.omega[0])
    if omega == 0:
        crossing = steady_enclosure(rod, force, DIGITS, isolated)
    else:
        with working_bits(4 * DIGITS):
            crossing = tight_box(rod, force, omega, DIGITS, isolated).force
    with working_bits(4 * DIGITS):
        if not crossing < BallNumbers().number(upper).real:
            raise ComputationError(
                f"not proved: the crossing near force {force:.10g} lies at the end of the range, "
                f"{float(upper):.10g}, or beyond it; take another max_force"
            )


def certify_complete(rod: RodParameters, max_force: Fraction, isolated: Sequence[Box]) -> None:
    """Prove that for 0 <= F <= max_force eigenvalues lie on the imaginary axis in the isolated boxes only.

    max_force: an exact number (near the largest force that the straight rod bears the work grows without
    bound). Boxes of steady crossings have ω = 0. Raises ComputationError where that is not proved.
    """
    top_force = BallNumbers().number(max_force).real
    try:
        require_form(rod, top_force)
    except ComputationError as error:
        raise ComputationError(
            f"not proved: that there is a straight rod up to the last force: {error}"
        ) from None
    first = _stable_up_to(rod, top_force)
    cuts = [first + (top_force - first) * k / SLABS for k in range(SLABS + 1)]
    stack, boxes = [low.union(high) for low, high in reversed(list(pairwise(cuts)))], 0
    while stack:
        force = stack.pop()
        try:
            region = unstable_region(linear_rod(rod, force), flint().arb(0))
        except ComputationError:
            if _relative_width(force) < NARROWEST_SLAB:
                raise
            stack += reversed(_cut(force))  # over a smaller range the constants are better known
            continue
        boxes += _exclude(rod, Box(force, flint().arb(0).union(region.top)), isolated, MOST_BOXES - boxes)


def _stable_up_to(rod: RodParameters, top_force: Scalar) -> Scalar:
    """A force up to which Re λ < 0, by the inequality above: halved until that holds for all below it."""
    f = flint()
    force = top_force.upper()
    for _ in range(200):
        with suppress(ComputationError):
            e = Energy.of(linear_rod(rod, f.arb(0).union(force)))
            w = e.h + 2 * e.b * e.k / f.arb.pi()
            if 4 * e.k * ((3 * e.load + e.f) * w + e.spring * e.k) < f.arb.pi():
                return force
        force = (force / 2).mid()
    Energy.of(linear_rod(rod, f.arb(0)))  # which may say why
    raise ComputationError("not proved: stability for small forces")


@dataclass(frozen=True)
class _Piece:
    """A box with the rod's linear problem over its forces, in their middle, and as a series in them."""

    box: Box
    here: LinearRod
    middle: LinearRod
    series: LinearRod

    @classmethod
    def of(cls, rod: RodParameters, box: Box) -> _Piece:
        series = linear_rod(rod, flint().acb_series([box.force, 1]))
        return cls(box, series.over_ball(), linear_rod(rod, box.force.mid()), series)


def _exclude(rod: RodParameters, whole: Box, isolated: Sequence[Box], most: int) -> int:
    """Cut a box until D ≠ 0 on every piece outside the isolated boxes; returns the number of pieces."""
    stack, done = [_Piece.of(rod, whole)], 0
    while stack:
        piece = stack.pop()
        box = piece.box
        done += 1
        if done > most:
            raise ComputationError(
                f"not proved: {MOST_BOXES} boxes do not show that there is no threshold near force "
                f"{box.force.str(6)}, omega {box.omega.str(6)}"
            )
        if any(x.force.contains(box.force) and x.omega.contains(box.omega) for x in isolated):
            continue
        if _is_steady(rod, box, isolated):
            continue
        excluded, by_force = _excluded(piece)
        if not excluded:
            stack += _halves(rod, piece, by_force)
    return done


def _is_steady(rod: RodParameters, box: Box, isolated: Sequence[Box]) -> bool:
    """Whether the box reaches down to ω = 0 at forces of a steady crossing, and has no zero above."""
    if not any(x.force.contains(box.force) and x.omega == 0 and box.omega.contains(0) for x in isolated):
        return False
    _, D_lam = derivatives(rod, box)
    return bool(D_lam.is_finite()) and not D_lam.real.contains(0)


def _excluded(piece: _Piece) -> tuple[bool, bool]:
    """Whether D ≠ 0 on the box, by its ball or by centre and slopes; and whether to cut the force next."""
    f, box = flint(), piece.box
    lam = f.acb(0, box.omega)
    D = characteristic(piece.here, lam).scaled
    if D.is_finite() and not D.contains(0):
        return True, False
    force_width, omega_width = (_relative_width(x) for x in (box.force, box.omega))
    if omega_width < NARROW:
        try:
            three = [
                characteristic(piece.middle, lam.mid()),
                characteristic(piece.series, lam),
                characteristic(piece.here, f.acb_series([lam, 1])),
            ]
            # without its growth D is of one branch only where all are settled
            settled = all(value.settled for value in three)
            centre, by_force, by_lam = (value.scaled if settled else value.whole for value in three)
        except (ValueError, ZeroDivisionError):
            return False, force_width > omega_width
        of_force, of_omega = abs(by_force[1]) * box.force.rad(), abs(by_lam[1]) * box.omega.rad()
        if abs(centre) > of_force + of_omega:
            return True, False
        if of_force.is_finite() and of_omega.is_finite():
            return False, of_force.mid() > of_omega.mid()
    return False, force_width > omega_width


def _relative_width(x: Scalar) -> float:
    """Half-width relative to the size, and to 1 for a frequency near 0, where D hardly depends on it."""
    return float(x.rad()) / (abs(float(x.mid())) + 1)


def _halves(rod: RodParameters, piece: _Piece, by_force: bool) -> list[_Piece]:
    force, omega = piece.box.force, piece.box.omega
    if by_force:
        return [_Piece.of(rod, Box(part, omega)) for part in _cut(force)]
    return [replace(piece, box=Box(force, part)) for part in _cut(omega)]


def _cut(x: Scalar) -> list[Scalar]:
    return [x.lower().union(x.mid()), x.mid().union(x.upper())]
