"""How many eigenvalues lie in the right half-plane: a number, proved.

The straight rod's eigenvalues are the zeros, with multiplicity, of an entire function D(λ), real on the real
axis: the determinant of the tip conditions of the two solutions that start at the clamp. Up to a factor that
depends on the rod and the force alone it is the determinant of the four boundary columns of e^{±r1 u},
e^{±r2 u}, divided by their Wronskian, which is proportional to λ(r1² − r2²)²/(r1 r2). Written out, with σ =
r1² + r2², π = r1² r2² and S_i = sinh(r_i)/r_i,

    D = [μ(Fσ + 2νλ) + μ(2Fπ + νλσ) S1 S2 + (2k2π − λσ − γ3λ(k2σ − 2λ)) cosh r1 cosh r2] / (σ² − 4π).

Its zeros inside a contour are counted by the change of arg D along it: on every piece of the contour the ball
D(piece) excludes 0.

All unstable eigenvalues lie inside, because they obey a bound. With Q = k2Y' − μΘ, b = μ/k2 and the norms y
= ‖Y‖, t = ‖Θ‖, q = ‖Q‖, a = ‖Θ'‖, T = |Θ(1)|, S = |Y(1)|, scaled so that y² + γ3t² = 1, the equations
multiplied by Y*, Θ* and integrated by parts give

    λ = −q²/k2 − a² + F b t² − F Θ(1) Y*(1),        b t² = ∫Θ*(Y' − Q/k2) <= TS + a + tq/k2.

Young's inequality applied to F t q/k2 turns the second into F b t² <= 2F(TS + a) + (F/μ)q²/k2. So, where
Re λ >= −δ, the number X defined by X² = a² + c q²/k2, c = 1 − F/μ = ν/b, obeys

    (1)  X² <= δ + 3F TS + 2F X,    |Im λ| <= F TS,    Re λ <= 3F TS + 2F X.

T² <= 2ta and S² <= 2‖Y'‖ <= 2(q/k2 + bt) with q/k2 <= hX, h = 1/√(c k2), give

    (2)  TS <= 2 √(tX (hX + bt)),

and t is bounded by t <= 2X/π, by t <= 1/√γ3 and, the second relation again, by

    (3)  b t² <= 4 √(tX (hX + bt)) + 2X + X²/(νk2).

Divided by X², (1) to (3) become tighter as X grows, so a number X that violates (1) exceeds all that occur.
"""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise

from rodwnl import kernels
from rodwnl.balls import flint, leading, square_root
from rodwnl.errors import ComputationError
from rodwnl.fields import Scalar

MOST_PIECES = 200_000  # of a contour, before the count is given up
SMALLEST = 2.0**-50  # relative length of a piece, before the count is given up
MOST_DOUBLINGS = 400  # of X, before the bound is given up


@dataclass(frozen=True)
class BallRod:
    """A rod under a force, or under all forces of a ball: k1, k2, gamma3, force as complex balls."""

    k1: Scalar
    k2: Scalar
    gamma3: Scalar
    force: Scalar


@dataclass(frozen=True)
class Region:
    """Re λ from −margin to right, |Im λ| up to top: no eigenvalue with Re λ >= −margin lies outside."""

    margin: Scalar
    right: Scalar
    top: Scalar


@dataclass(frozen=True)
class Value:
    """D = scaled·e^{growth}, growth = r1 + r2. `settled`: surely Re r1, Re r2 > 0, so both are analytic."""

    scaled: Scalar
    growth: Scalar
    settled: bool

    @property
    def whole(self) -> Scalar:
        """D itself."""
        return self.scaled * self.growth.exp()


def characteristic(rod: BallRod, lam: Scalar) -> Value:
    """D(λ), for a ball λ or for a series in it (or in the force)."""
    k2, gamma3, F = rod.k2, rod.gamma3, rod.force
    nu, mu = kernels.base_state(rod.k1, k2, F)
    c4, c2, c0 = kernels.exponent_polynomial(lam, rod.k1, k2, gamma3, F)
    total, product = -c2 / c4, c0 / c4
    root = square_root(total * total - 4 * product)
    # the larger of the two z = r² loses nothing; the other one follows from z1 z2
    same_way = (leading(total) * leading(root).conjugate()).real.mid() >= 0
    z1 = (total + root if same_way else total - root) / 2
    (g1, cosh1, sinh1), (g2, cosh2, sinh2) = _decaying(z1), _decaying(product / z1)
    scaled = (
        mu * (F * total + 2 * nu * lam) * (-g1 - g2).exp()
        + mu * (2 * F * product + nu * lam * total) * sinh1 * sinh2
        + (2 * k2 * product - lam * total - gamma3 * lam * (k2 * total - 2 * lam)) * cosh1 * cosh2
    ) / (root * root)
    return Value(scaled, g1 + g2, all(leading(g).real > 0 for g in (g1, g2)))


def _decaying(z: Scalar) -> tuple[Scalar, Scalar, Scalar]:
    """(g, e^{−g} cosh r, e^{−g} sinh(r)/r), r² = z: g = r with Re r > 0, or 0 for a ball z that contains 0.

    Both functions are entire in z, ₀F₁(1/2; z/4) and ₀F₁(3/2; z/4), while r is not.
    """
    if z is leading(z) and z.contains(0):
        half = flint().acb(1) / 2
        return 0 * z, (z / 4).hypgeom_0f1(half), (z / 4).hypgeom_0f1(3 * half)
    r = _turned_right(square_root(z))
    e = (-2 * r).exp()
    return r, (1 + e) / 2, (1 - e) / (2 * r)


def _turned_right(r: Scalar) -> Scalar:
    """±r, the one whose centre lies to the right."""
    return r if leading(r).real.mid() > 0 else -r


def unstable_region(rod: BallRod, margin: Scalar) -> Region:
    """A rectangle that contains every eigenvalue with Re λ >= −margin (the bound of the module's text)."""
    f = flint()
    k2, gamma3, F = (z.real for z in (rod.k2, rod.gamma3, rod.force))
    nu, mu = (z.real for z in kernels.base_state(rod.k1, rod.k2, rod.force))
    b = mu / k2
    h = 1 / (nu / b * k2).sqrt()

    def bounds(X: Scalar) -> tuple[Scalar, Scalar]:
        """Upper bounds of t and TS at this X."""
        t = min(2 * X / f.arb.pi(), 1 / gamma3.sqrt(), key=lambda ball: float(ball.upper()))
        while b * (s := t / 2) ** 2 > 4 * (s * X * (h * X + b * s)).sqrt() + 2 * X + X**2 / (nu * k2):
            t = s
        return t, 2 * (t * X * (h * X + b * t)).sqrt()

    X = f.arb(1)
    for _ in range(MOST_DOUBLINGS):
        TS = bounds(X)[1]
        if margin + 3 * F * TS + 2 * F * X < X**2:
            return Region(margin, (3 * F * TS + 2 * F * X).upper(), (F * TS).upper())
        X = 2 * X
    raise ComputationError("no bound of the unstable spectrum was found")


def count_right_of(rod: BallRod, line: Scalar, region: Region) -> int:
    """The number of eigenvalues, with multiplicity, with Re λ > line >= −margin; none lies on the line.

    Raises ComputationError where that is not proved.
    """
    f = flint()
    corners = [f.acb(region.right), f.acb(region.right, region.top), f.acb(line, region.top), f.acb(line)]
    turn, pieces = f.arb(0), 0
    for start, end in pairwise(corners):
        stack = [(start, end, characteristic(rod, start), characteristic(rod, end))]
        while stack:
            z0, z1, D0, D1 = stack.pop()
            pieces += 1
            if pieces > MOST_PIECES:
                raise ComputationError(f"the contour was not covered by {MOST_PIECES} pieces")
            angle = _turn(characteristic(rod, z0.union(z1)), D0, D1)
            if angle is not None:
                turn += angle
                continue
            if (z1 - z0).abs_upper() < SMALLEST * (z0.abs_upper() + 1):
                raise ComputationError(f"an eigenvalue lies on the contour or close to it, near {z0.str(6)}")
            middle = ((z0 + z1) / 2).mid()
            Dm = characteristic(rod, middle)
            stack += [(middle, z1, Dm, D1), (z0, middle, D0, Dm)]
    # the lower half of the contour, its mirror image, turns arg D as much again
    count = (turn / f.arb.pi()).unique_fmpz()
    if count is None:
        raise ComputationError("the change of the argument along the contour is not known well enough")
    return int(count)


def _turn(piece: Value, start: Value, end: Value) -> Scalar | None:
    """The change of arg D along a piece of the contour, or None if the ball D(piece) does not exclude 0.

    A ball without 0 lies in a half-plane, so there the argument changes by less than π. Where the growth
    e^{r1 + r2} is analytic its turn is known exactly and only the rest has to exclude 0.
    """
    if piece.settled and _excludes_0(piece.scaled):
        return (end.scaled / start.scaled).arg() + (end.growth - start.growth).imag
    if _excludes_0(piece.whole):
        return (end.whole / start.whole).arg()
    return None


def _excludes_0(ball: Scalar) -> bool:
    return bool(ball.is_finite()) and not ball.contains(0)
