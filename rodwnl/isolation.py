"""Isolating a Hopf threshold: boxes in which D(iω, F) = 0 is proved to have exactly one solution.

Krawczyk's test for two real equations G(x) = 0 in x = (F, ω), with m the centre of the box X and C near
G'(m)⁻¹:

    K = m − C G(m) + (1 − C G'(X))(X − m) inside X

proves one and only one zero in X, and that it lies in K (Krawczyk 1969, doi:10.1007/BF02234767).
"""

from __future__ import annotations

from dataclasses import dataclass

import mpmath as mp

from rodwnl.balls import flint, relative_accuracy, working_bits
from rodwnl.errors import ComputationError
from rodwnl.exact import GUARD, refine_threshold
from rodwnl.fields import Scalar
from rodwnl.halfplane import characteristic
from rodwnl.linearrod import linear_rod
from rodwnl.parameters import RodParameters
from rodwnl.steady import steady_force

WIDEST, NARROWEST = 4, 80  # the uniqueness box has relative half-widths 2^−4, 2^−5, …
TIGHT = (5, 10)  # digits by which the enclosing box is wider than the working precision


@dataclass(frozen=True)
class Box:
    """Real balls (arb) for the force and for ω."""

    force: Scalar
    omega: Scalar


@dataclass(frozen=True)
class DecimalBox:
    """Middle and radius of a force interval and of an ω interval, as exact decimal texts."""

    force: tuple[str, str]
    omega: tuple[str, str]

    @property
    def balls(self) -> Box:
        """Balls that contain the box: a radius has 30 bits and is rounded up, so they are a little larger."""
        arb = flint().arb
        return Box(*(arb(arb(mid), arb(rad)) for mid, rad in (self.force, self.omega)))

    def holds_force(self, force: Scalar) -> bool:
        """Whether a ball surely lies in the force interval itself."""
        return _inside(force, self.force)

    def holds(self, box: Box) -> bool:
        """Whether both balls do."""
        return _inside(box.force, self.force) and _inside(box.omega, self.omega)


def _inside(x: Scalar, interval: tuple[str, str]) -> bool:
    mid, rad = (flint().arb(text) for text in interval)
    return bool(abs(x - mid) < rad)


def uniqueness_box(rod: RodParameters, force: float, omega: float) -> DecimalBox:
    """The largest of a sequence of boxes around the given point in which Krawczyk's test succeeds."""
    for exponent in range(WIDEST, NARROWEST):
        box = DecimalBox(*((f"{x:.12g}", f"{x / 2**exponent:.3g}") for x in (force, omega)))
        if _krawczyk(rod, box.balls) is not None:
            return box
    raise ComputationError(
        f"Krawczyk's test fails in every box around force {force!r}, omega {omega!r}: no threshold is there, "
        "or two of them meet"
    )


def steady_box(rod: RodParameters, force: float) -> DecimalBox:
    """The largest of a sequence of intervals, at ω = 0, in which D(0, F), which is real, has one zero.

    It differs in sign at the ends, and D_F ≠ 0 between. Raises ComputationError where that is not proved.
    """
    f = flint()
    for exponent in range(WIDEST, NARROWEST):
        box = DecimalBox((f"{force:.12g}", f"{force / 2**exponent:.3g}"), ("0", "0"))
        forces = box.balls.force
        try:
            slope, _ = derivatives(rod, box.balls)
            ends = [
                characteristic(linear_rod(rod, end), f.acb(0)).whole.real
                for end in (forces.lower(), forces.upper())
            ]
        except (ComputationError, ValueError, ZeroDivisionError):
            continue
        if slope.is_finite() and not slope.real.contains(0) and ends[0] * ends[1] < 0:
            return box
    raise ComputationError(f"not proved: one and only one steady crossing near force {force!r}")


def steady_enclosure(rod: RodParameters, force: float, digits: int, unique_in: DecimalBox) -> Scalar:
    """The steady crossing of `unique_in` in a ball of `digits` digits: an interval Newton step for D(0, F).

    X contains m − D(0, m)/D_F(X), which then contains a zero. Raises ComputationError where it does not, or
    that ball is wider than asked for.
    """
    f = flint()
    working = digits + GUARD
    text = mp.nstr(steady_force(rod, force, working), working)
    with working_bits(int(3.33 * working) + 16):
        X = f.arb(text, abs(f.arb(text)) * f.arb(10) ** (TIGHT[0] - working))
        D = characteristic(linear_rod(rod, X.mid()), f.acb(0)).whole.real
        slope, _ = derivatives(rod, Box(X, f.arb(0)))
        inner = X.mid() - D / slope.real
        if not (X.contains_interior(inner) and unique_in.holds_force(inner)):
            raise ComputationError(f"not proved: an enclosure of the steady crossing near force {force!r}")
        if relative_accuracy(inner) < digits + 1:
            raise ComputationError(f"not proved: {digits} digits of the steady crossing near force {force!r}")
        return inner


def tight_box(rod: RodParameters, force: float, omega: float, digits: int, unique_in: DecimalBox) -> Box:
    """A box of about the working precision that contains the threshold of `unique_in` and lies in it."""
    f = flint()
    with mp.workdps(digits):
        centre = refine_threshold(rod, mp.mpf(force), mp.mpf(omega))
        texts = [mp.nstr(x, digits + 3) for x in centre]
    for kept in (digits - spare for spare in TIGHT):
        box = Box(*(f.arb(text, abs(f.arb(text)) * f.arb(10) ** -kept) for text in texts))
        inner = _krawczyk(rod, box)
        if inner is not None:
            if not unique_in.holds(inner):
                raise ComputationError("it lies outside the box in which it is unique")
            return inner
    raise ComputationError("Krawczyk's test fails in a small box around the approximate threshold")


def _krawczyk(rod: RodParameters, box: Box) -> Box | None:
    """K of Krawczyk's test if it lies inside the box, which then has exactly one zero of D(iω, F), in K."""
    f = flint()
    centre = Box(box.force.mid(), box.omega.mid())
    try:
        D = characteristic(linear_rod(rod, centre.force), f.acb(0, centre.omega)).whole
        J, Jm = (_jacobian(rod, each) for each in (box, centre))
        C = f.arb_mat(Jm).inv()
        C = f.arb_mat([[C[i, j].mid() for j in (0, 1)] for i in (0, 1)])
        m = f.arb_mat([[centre.force], [centre.omega]])
        away = f.arb_mat([[box.force - centre.force], [box.omega - centre.omega]])
        K = m - C * f.arb_mat([[D.real], [D.imag]]) + (f.arb_mat([[1, 0], [0, 1]]) - C * f.arb_mat(J)) * away
    except (ComputationError, ValueError, ZeroDivisionError):
        return None  # no straight rod is proved, or a divisor may be 0
    inside = box.force.contains_interior(K[0, 0]) and box.omega.contains_interior(K[1, 0])
    return Box(K[0, 0], K[1, 0]) if inside else None


def _jacobian(rod: RodParameters, box: Box) -> list[list[Scalar]]:
    """∂(Re D, Im D)/∂(F, ω) over a box."""
    D_force, D_lam = derivatives(rod, box)
    D_omega = D_lam * 1j
    return [[D_force.real, D_omega.real], [D_force.imag, D_omega.imag]]


def derivatives(rod: RodParameters, box: Box) -> tuple[Scalar, Scalar]:
    """D_F and D_λ at λ = iω, over balls: the linear coefficients of power series."""
    f = flint()
    lam = f.acb(0, box.omega)
    by_force = characteristic(linear_rod(rod, f.acb_series([box.force, 1])), lam).whole
    by_lam = characteristic(linear_rod(rod, box.force), f.acb_series([lam, 1])).whole
    return by_force[1], by_lam[1]


def eigenvalue_slope(rod: RodParameters, box: Box) -> Scalar:
    """dλ/dF = −D_F/D_λ; finite only if D_λ ≠ 0, that is if the eigenvalue is simple."""
    D_force, D_lam = derivatives(rod, box)
    slope = -D_force / D_lam
    if not slope.is_finite() or slope.real.contains(0):
        raise ComputationError("the eigenvalue may be multiple, or touch the axis without crossing it")
    return slope
