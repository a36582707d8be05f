"""How many eigenvalues lie in the right half-plane: a number, proved.

The eigenvalues of the linear problem of rodwnl/linearrod.py are the zeros, with multiplicity, of an entire
function D(λ), real on the real axis: the determinant of the tip conditions of two solutions that start at the
clamp. With the exponents ±r1, ±r2, z = r², and

    g(z) = (K2z − λwy)/μ,   h(z) = z − νg(z) = (Fz + νλwy)/μ,   C = cosh r,   S = sinh(r)/r,   m = μ/K3

the two solutions have the tip values (Y, H, Θ, Θ')(1)

    U = (C1 − C2, h1S1 − h2S2, g1S1 − g2S2, g1C1 − g2C2),
    V = ((m + g2)S1/K2 − (m + g1)S2/K2, (F/K3 + g2)C1/K2 − (F/K3 + g1)C2/K2, (C1 − C2)/K3, (z1S1 − z2S2)/K3)

over z1 − z2: then their Y' and Θ' at the clamp are constants, so they are a basis for every λ, and entire. D
is the sum over pairs of components of p_ij (UiVj − UjVi)/(z1 − z2)², with p the minors of the two tip rows.
There C² − zS² = 1 removes the squares of C and S, and g1g2 = λwy/K3, g1 + g2 = κ − F/K3 with κ = λ(K2wθ/K3 −
wy)/μ remove what else would cancel (`_minors`).

Its zeros inside a contour are counted by the change of arg D along it: on every piece of the contour the ball
D(piece) excludes 0.

All unstable eigenvalues lie inside, because they obey a bound. With Q = K2Y' − μΘ, b = μ/K2 and the norms y
= ‖Y‖, t = ‖Θ‖, q = ‖Q‖, a = ‖Θ'‖, T = |Θ(1)|, S = |Y(1)|, the equations multiplied by Y*, Θ* and integrated
by parts give

    λ (wy y² + wθ t² + G) = −q²/K2 − K3a² + F b t² + f Θ(1)Y*(1) + aθ T²,    f = ay − F,
    b t² = ∫Θ*(Y' − Q/K2) <= TS + a y + tq/K2,

where G = −(byy S² + bθθ T²) >= 0 is the work done on the drag of the load; a load whose drag drives, or
couples the rates, is refused. The sum in parentheses is scaled to 1, so y <= y0 = 1/√wy and t <= 1/√wθ.
Young's inequality applied to F t q/K2 turns the second relation into F b t² <= 2F(TS + a y0) + (F/μ)q²/K2.
So, where Re λ >= −δ, the number X defined by X² = K3a² + c q²/K2, c = 1 − F/μ = ν/b, obeys, with a <= X/√K3,
T² <= 2ta, s = max(aθ, 0) and k = 1/√K3,

    (1)  X² <= δ + R,    Re λ <= R,    |Im λ| <= |f| TS,    R = (2F + |f|) TS + 2F y0 k X + 2s k t X.

S² <= 2 y0 ‖Y'‖ <= 2 y0 (q/K2 + bt) with q/K2 <= hX, h = 1/√(c K2), gives

    (2)  TS <= 2 √(t k y0 X (hX + bt)),

and t is bounded by t <= 2kX/π, by t <= 1/√wθ and, the second relation again, by

    (3)  b t² <= 4 √(t k y0 X (hX + bt)) + 2 y0 k X + X²/(νK2).

Divided by X², (1) to (3) become tighter as X grows, so a number X that violates (1) exceeds all that occur.
"""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise

from rodwnl.balls import flint, leading, square_root
from rodwnl.errors import ComputationError
from rodwnl.fields import Scalar
from rodwnl.linearrod import NONE, LinearRod

MOST_PIECES = 200_000  # of a contour, before the count is given up
SMALLEST = 2.0**-50  # relative length of a piece, before the count is given up
MOST_DOUBLINGS = 400  # of X, before the bound is given up


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


def characteristic(rod: LinearRod, lam: Scalar) -> Value:
    """D(λ), for a ball λ or for a series in it (or in the force)."""
    K2, K3, w_y, w_theta = rod.K2, rod.K3, rod.w_y, rod.w_theta
    total = (lam * (K2 * w_theta + K3 * w_y) - rod.mu * rod.load) / (K2 * K3)
    product = lam * w_y * (lam * w_theta + rod.mu * rod.nu) / (K2 * K3)
    root = square_root(total * total - 4 * product)
    # the larger of the two z = r² loses nothing; the other one follows from z1 z2
    if (leading(total) * leading(root).conjugate()).real.mid() < 0:
        root = -root
    z1 = (total + root) / 2
    z2 = product / z1
    (r1, *first), (r2, *second) = _decaying(z1), _decaying(z2)
    pair = _Pair(z1, z2, total, product, root, (-r1 - r2).exp(), *first, *second)
    scaled = sum(p * minor for p, minor in _minors(rod, lam, pair)) / (root * root)
    return Value(scaled, r1 + r2, all(leading(r).real > 0 for r in (r1, r2)))


@dataclass(frozen=True)
class _Pair:
    """z1, z2 with their sum, product and difference; 1 and cosh r, sinh(r)/r of both, times e^{−r} each."""

    z1: Scalar
    z2: Scalar
    total: Scalar
    product: Scalar
    root: Scalar
    one: Scalar
    C1: Scalar
    S1: Scalar
    C2: Scalar
    S2: Scalar


def _minors(rod: LinearRod, lam: Scalar, e: _Pair) -> list[tuple[Scalar, Scalar]]:
    """(p_ij, (UiVj − UjVi)(z1 − z2)²) for the minors p of the tip rows that are not 0.

    The rows, on (Y, H, Θ, Θ')(1): (−λbyy, K2, −ty, 0) and (−λbθy, 0, −tθ, K3), t = a + λb in Θ.
    """
    K2, K3, nu, mu, F, lw = rod.K2, rod.K3, rod.nu, rod.mu, rod.load, lam * rod.w_y
    ((yy, yt), (ty, tt)), CC, SS, one = rod.by_rate, e.C1 * e.C2, e.S1 * e.S2, e.one
    kappa = lam * (K2 * rod.w_theta / K3 - rod.w_y) / mu
    both, q = kappa - F / K3, lw / K3  # g1 + g2 and g1 g2
    sum_h = (F * e.total + 2 * nu * lw) / mu
    cross = (2 * F * e.product + nu * lw * e.total) / mu  # h1 z2 + h2 z1
    found = [(K2 * K3, (kappa * both - 2 * q) / K2 * CC - (sum_h * one + cross * SS) / K3)]  # H Θ'
    of_y, of_theta = (_with_rate(a, lam, b) for a, b in zip(rod.by_angle, (yt, tt), strict=True))
    if of_y is not NONE:  # Θ Θ'
        cross = (2 * K2 * e.product - lw * e.total) / mu  # g1 z2 + g2 z1
        found.append((-of_y * K3, (both * (CC - one) - cross * SS) / K3))
    if of_theta is NONE and yy is NONE and ty is NONE:
        return found
    g1, g2, m = (K2 * e.z1 - lw) / mu, (K2 * e.z2 - lw) / mu, mu / K3
    if of_theta is not NONE:  # H Θ
        found.append((-of_theta * K2, e.root / mu * (g1 * e.S1 * e.C2 - g2 * e.C1 * e.S2)))
    if yy is not NONE:  # Y Θ'
        found.append((-lam * yy * K3, e.root / mu * ((m + g1) * e.C1 * e.S2 - (m + g2) * e.S1 * e.C2)))
    p = lam * yy * of_theta - lam * ty * of_y  # Y Θ
    found.append((p, 2 * (one - CC) / K3 + (both * (K2 * nu / K3 + kappa) - 2 * q) / K2 * SS))
    if ty is not NONE:  # Y H
        squares = (K2 * (e.total * e.total - 2 * e.product) - lw * e.total) / mu  # g1 z1 + g2 z2
        cross = m * sum_h + (F * squares + nu * lw * both) / mu
        found.append((K2 * lam * ty, (F / K3 + kappa) / K2 * (one - CC) + cross / K2 * SS))
    return found


def _with_rate(by_angle: Scalar, lam: Scalar, by_rate: Scalar) -> Scalar:
    """a + λb, or NONE where both are."""
    return NONE if by_angle is NONE and by_rate is NONE else by_angle + lam * by_rate


def _decaying(z: Scalar) -> tuple[Scalar, Scalar, Scalar]:
    """(g, e^{−g} cosh r, e^{−g} sinh(r)/r), r² = z: g = r with Re r > 0, or 0 for a ball z that contains 0.

    Both functions are entire in z, ₀F₁(1/2; z/4) and ₀F₁(3/2; z/4), while r is not; their derivatives are
    ₀F₁(3/2; z/4)/2 and ₀F₁(5/2; z/4)/6.
    """
    at = leading(z)
    if at.contains(0):
        f = flint()
        C, S, dS = ((at / 4).hypgeom_0f1(f.acb(n) / 2) for n in (1, 3, 5))
        if z is at:
            return 0 * z, C, S
        return 0 * z, f.acb_series([C, S / 2 * z[1]]), f.acb_series([S, dS / 6 * z[1]])
    r = _turned_right(square_root(z))
    e = (-2 * r).exp()
    return r, (1 + e) / 2, (1 - e) / (2 * r)


def _turned_right(r: Scalar) -> Scalar:
    """±r, the one whose centre lies to the right."""
    return r if leading(r).real.mid() > 0 else -r


def unstable_region(rod: LinearRod, margin: Scalar) -> Region:
    """A rectangle that contains every eigenvalue with Re λ >= −margin (the bound of the module's text).

    Raises ComputationError for a load that drives or couples the rates, and where no bound is found.
    """
    f, e = flint(), Energy.of(rod)

    def most(t: Scalar, X: Scalar) -> Scalar:
        """What bounds TS at this t."""
        return 2 * (t * e.k * e.y0 * X * (e.h * X + e.b * t)).sqrt()

    def bounds(X: Scalar) -> tuple[Scalar, Scalar]:
        """Upper bounds of t and TS at this X."""
        t = min(2 * e.k * X / f.arb.pi(), 1 / e.w_theta.sqrt(), key=lambda ball: float(ball.upper()))
        while e.b * (s := t / 2) ** 2 > 2 * most(s, X) + 2 * e.y0 * e.k * X + X**2 / e.shear:
            t = s
        return t, most(t, X)

    X = f.arb(1)
    for _ in range(MOST_DOUBLINGS):
        t, TS = bounds(X)
        R = (2 * e.load + e.f) * TS + 2 * e.load * e.y0 * e.k * X + 2 * e.spring * e.k * t * X
        if margin + R < X**2:
            return Region(margin, R.upper(), (e.f * TS).upper())
        X = 2 * X
    raise ComputationError("no bound of the unstable spectrum was found")


@dataclass(frozen=True)
class Energy:
    """Real balls that the energy bound is made of: F, |f|, s, k = 1/√K3, y0, wθ, b, h, νK2."""

    load: Scalar
    f: Scalar
    spring: Scalar
    k: Scalar
    y0: Scalar
    w_theta: Scalar
    b: Scalar
    h: Scalar
    shear: Scalar

    @classmethod
    def of(cls, rod: LinearRod) -> Energy:
        """Raises ComputationError where the drag of the load may drive the tip, or couples its rates."""
        (yy, yt), (ty, tt) = rod.by_rate
        if yt is not NONE or ty is not NONE or not all(b is NONE or b.real <= 0 for b in (yy, tt)):
            raise ComputationError(
                "the energy bound needs a load whose drag only brakes: -transverse v2 in F2 and -drag Omega "
                "in M, with drags that are not negative"
            )
        K2, K3, nu, mu, F, w_y, w_theta = (
            z.real for z in (rod.K2, rod.K3, rod.nu, rod.mu, rod.load, rod.w_y, rod.w_theta)
        )
        ay, atheta = (flint().acb(a).real for a in rod.by_angle)
        b, zero = mu / K2, flint().arb(0)
        spring = zero if atheta <= 0 else zero.union(atheta).upper()
        h = 1 / (nu / b * K2).sqrt()
        return cls(F, abs(ay - F), spring, 1 / K3.sqrt(), 1 / w_y.sqrt(), w_theta, b, h, nu * K2)


def count_right_of(rod: LinearRod, line: Scalar, region: Region) -> int:
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
    e^{r1 + r2} is analytic, and of one branch at the ends, its turn is known exactly and only the rest has to
    exclude 0.
    """
    if piece.settled and start.settled and end.settled and _excludes_0(piece.scaled):
        return (end.scaled / start.scaled).arg() + (end.growth - start.growth).imag
    if _excludes_0(piece.whole):
        return (end.whole / start.whole).arg()
    return None


def _excludes_0(ball: Scalar) -> bool:
    return bool(ball.is_finite()) and not ball.contains(0)
