"""That a list of thresholds is complete: at no other force is an eigenvalue on the imaginary axis. A proof.

For small forces every eigenvalue is stable. With the norms and the inequalities of rodwnl/halfplane.py, now
for any scaling: y <= (2/π)‖Y'‖, t <= 2X/π and ‖Y'‖ <= wX with w = h + 2b/π give TS <= (4/π) w X² and a y <=
(2/π) w X², so

    Re λ (y² + γ3t²) <= −X² + 3F TS + 2F a y <= −(1 − (16/π) F w) X².

For larger ones an eigenvalue iω has |ω| <= F TS, which is bounded. What is left is a bounded set of (F, ω).
It is cut into boxes until each of them either lies in a box that is proved to hold exactly one threshold, or
D(iω, F) excludes 0.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from fractions import Fraction
from itertools import combinations

from rodwnl import kernels
from rodwnl.balls import BallNumbers, flint, working_bits
from rodwnl.errors import ComputationError
from rodwnl.fields import Scalar
from rodwnl.halfplane import BallRod, characteristic, unstable_region
from rodwnl.isolation import Box, ball_rod, uniqueness_box
from rodwnl.parameters import RodParameters
from rodwnl.spectrum import HopfSearch, hopf_thresholds

REACH = Fraction(19, 20)  # of k1; nearer to it the bounds, and the work, grow without limit
BITS = 64
SLABS = 16  # pieces of the force range, each with its own bound of ω
MOST_BOXES = 400_000
NARROW = 0.2  # relative width in ω below which slopes are worth computing


@dataclass(frozen=True)
class Complete:
    """For 0 <= F <= max_force an eigenvalue lies on the imaginary axis at exactly `crossings` forces."""

    max_force: Fraction
    crossings: int


def prove_complete(search: HopfSearch) -> Complete:
    """Prove how many crossings there are in a search's range (of which the last 1/20 below k1 is left out).

    Raises InputError without python-flint, ComputationError where the proof fails.
    """
    rod = search.rod
    rod.require_plain("a certificate")
    upper = min(search.max_force, REACH * rod.k1)
    every = hopf_thresholds(rod, upper, all_crossings=True)
    with working_bits(BITS):
        found = (*every.thresholds, *(every.later or ()))
        isolated = [uniqueness_box(rod, t.force, t.omega).balls for t in found]
        for a, b in combinations(isolated, 2):
            if a.force.overlaps(b.force) and a.omega.overlaps(b.omega):
                raise ComputationError("not proved: two thresholds are too close for boxes of their own")
        certify_complete(rod, upper, isolated)
    return Complete(upper, len(isolated))


def certify_complete(rod: RodParameters, max_force: Fraction, isolated: Sequence[Box]) -> None:
    """Prove that for 0 <= F <= max_force eigenvalues lie on the imaginary axis in the isolated boxes only.

    max_force: an exact number below k1 (near k1 the work grows without bound). Raises ComputationError where
    that is not proved.
    """
    top_force = BallNumbers().number(max_force).real
    if not top_force < BallNumbers().number(rod.k1).real:
        raise ComputationError("not proved: the list is complete only up to forces below k1")
    first = _stable_up_to(rod, top_force)
    boxes = 0
    for i in range(SLABS):
        low, high = (first + (top_force - first) * k / SLABS for k in (i, i + 1))
        force = low.union(high)
        region = unstable_region(ball_rod(rod, force), flint().arb(0))
        boxes += _exclude(rod, Box(force, flint().arb(0).union(region.top)), isolated, MOST_BOXES - boxes)


def _stable_up_to(rod: RodParameters, top_force: Scalar) -> Scalar:
    """A force up to which Re λ < 0, by (16/π) F w < 1: halved until it is so for all forces below it."""
    f = flint()
    force = top_force.upper()
    for _ in range(200):
        ball = ball_rod(rod, f.arb(0).union(force))
        nu, mu = (z.real for z in kernels.base_state(ball.k1, ball.k2, ball.force))
        k2 = ball.k2.real
        b = mu / k2
        w = 1 / (nu / b * k2).sqrt() + 2 * b / f.arb.pi()
        if nu > 0 and 16 * force * w < f.arb.pi():
            return force
        force = (force / 2).mid()
    raise ComputationError("not proved: stability for small forces")


def _exclude(rod: RodParameters, whole: Box, isolated: Sequence[Box], most: int) -> int:
    """Cut a box until D ≠ 0 on every piece outside the isolated boxes; returns the number of pieces."""
    stack, done = [whole], 0
    while stack:
        box = stack.pop()
        done += 1
        if done > most:
            raise ComputationError(
                f"not proved: {MOST_BOXES} boxes do not show that there is no threshold near force "
                f"{box.force.str(6)}, omega {box.omega.str(6)}"
            )
        if any(x.force.contains(box.force) and x.omega.contains(box.omega) for x in isolated):
            continue
        excluded, by_force = _excluded(ball_rod(rod, box.force), box)
        if not excluded:
            stack += _halves(box, by_force)
    return done


def _excluded(rod: BallRod, box: Box) -> tuple[bool, bool]:
    """Whether D ≠ 0 on the box, by its ball or by centre and slopes; and whether to cut the force next."""
    f = flint()
    lam = f.acb(0, box.omega)
    D = characteristic(rod, lam).scaled
    if D.is_finite() and not D.contains(0):
        return True, False
    force_width, omega_width = (_relative_width(x) for x in (box.force, box.omega))
    if omega_width < NARROW:
        try:
            centre = characteristic(replace(rod, force=rod.force.mid()), lam.mid()).scaled
            D_force = characteristic(replace(rod, force=f.acb_series([rod.force, 1])), lam).scaled[1]
            D_lam = characteristic(rod, f.acb_series([lam, 1])).scaled[1]
        except (ValueError, ZeroDivisionError):
            return False, force_width > omega_width
        by_force, by_omega = abs(D_force) * box.force.rad(), abs(D_lam) * box.omega.rad()
        if abs(centre) > by_force + by_omega:
            return True, False
        if by_force.is_finite() and by_omega.is_finite():
            return False, by_force.mid() > by_omega.mid()
    return False, force_width > omega_width


def _relative_width(x: Scalar) -> float:
    """Half-width relative to the size, and to 1 for a frequency near 0, where D hardly depends on it."""
    return float(x.rad()) / (abs(float(x.mid())) + 1)


def _halves(box: Box, by_force: bool) -> list[Box]:
    x = box.force if by_force else box.omega
    parts = [x.lower().union(x.mid()), x.mid().union(x.upper())]
    return [Box(part, box.omega) if by_force else Box(box.force, part) for part in parts]
