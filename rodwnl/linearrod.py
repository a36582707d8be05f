"""The linear problem of a rod of uniform stretch, in balls: a few constants, read off its emitted functions.

With H = Y' − νΘ, the stiffnesses K2 and K3, the compression F, μ = K2ν + F and the drags wy, wθ of the
straight rod it is

    λwy Y = K2 H' − FΘ',    λwθ Θ = K3 Θ'' + μH,    Y(0) = Θ(0) = 0,
    K2 H(1) = ay Θ(1) + λ(byy Y(1) + byθ Θ(1)),    K3 Θ'(1) = aθ Θ(1) + λ(bθy Y(1) + bθθ Θ(1)),

where a and b are the derivatives of the tip load (F2, M) in the angle and in the rates. That the emitted rows
have this form is checked.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from rodwnl.balls import BallNumbers, flint, leading, series_terms
from rodwnl.errors import ComputationError
from rodwnl.fields import Scalar
from rodwnl.parameters import RodParameters
from rodwnl.straightrod import StraightRod, arguments
from rodwnl.uniformrod import uniform_rod

RATES = ("v2", "Omega")  # of Y and Θ at the straight rod
NONE = 0  # of a load that does not depend on a quantity: kept as a plain zero, so that its terms are left out


@dataclass(frozen=True)
class LinearRod:
    """The constants under a force, under all forces of a ball, or as series in the force.

    by_angle: (ay, aθ). by_rate: ((byy, byθ), (bθy, bθθ)). The others are positive.
    """

    K2: Scalar
    K3: Scalar
    nu: Scalar
    mu: Scalar
    load: Scalar
    w_y: Scalar
    w_theta: Scalar
    by_angle: tuple[Scalar, Scalar]
    by_rate: tuple[tuple[Scalar, Scalar], tuple[Scalar, Scalar]]

    def over_ball(self) -> LinearRod:
        """Of a series in a ball of forces: the rod over that ball."""
        (yy, yt), (ty, tt) = self.by_rate
        plain = {name: leading(z) for name, z in vars(self).items() if not name.startswith("by_")}
        ay, atheta, yy, yt, ty, tt = (leading(z) for z in (*self.by_angle, yy, yt, ty, tt))
        return LinearRod(**plain, by_angle=(ay, atheta), by_rate=((yy, yt), (ty, tt)))


def linear_rod(rod: RodParameters, force: Scalar) -> LinearRod:
    """The rod's linear problem for a ball of forces, or for a series in one.

    Raises ComputationError where it is not proved that there is a straight rod of positive length with convex
    energy and positive drag.
    """
    straight = _straight(rod, force)
    *explicit, load, _ = straight("straight_rod")
    _, w_y, w_theta = straight("drag_weights")
    # An implicit stretch comes with the proof that K1 > 0, which a wide ball of it might not show again.
    K1 = {"K1": straight("stretch_stiffness")} if explicit else {}
    found = K1 | {
        "nu": explicit[0] if explicit else straight.values["nu"],
        "K2": straight("y_row")[2],
        "K3": straight("theta_row")[5],
        "w_y": w_y,
        "w_theta": w_theta,
    }
    for name, value in found.items():
        found[name] = ball = _ball(value)
        if not leading(ball).real > 0:
            raise ComputationError(
                f"the straight rod may not exist at force {leading(straight.force).real.str(6)}: "
                f"{name} = {leading(ball).real.str(6)} is not surely positive"
            )
    found.pop("K1", None)
    slopes = [_slopes(straight, name) for name in ("theta", *RATES)]
    return LinearRod(
        **found,
        mu=straight.mu,
        load=load,
        by_angle=slopes[0],
        by_rate=((slopes[1][0], slopes[2][0]), (slopes[1][1], slopes[2][1])),
    )


def require_form(rod: RodParameters, force: Scalar) -> None:
    """That the emitted rows are those of the linear problem above: ball by ball, at this force."""
    straight, given = _straight(rod, force), linear_rod(rod, force)
    lam = flint().acb(1, 2)
    K2, K3, nu, mu = given.K2, given.K3, given.nu, given.mu
    (yy, yt), (ty, tt) = given.by_rate
    expected = {
        "y_row": (0, 0, K2, 0, -mu, 0),
        "theta_row": (0, mu, 0, -mu * nu, 0, K3),
        "y_tip_row": (-lam * yy, K2, -K2 * nu - given.by_angle[0] - lam * yt, 0),
        "theta_tip_row": (-lam * ty, 0, -given.by_angle[1] - lam * tt, K3),
        "base_state": (K2 * nu + given.load,),
    }
    for name, row in expected.items():
        found = straight(name, lam=lam)
        found = found[-len(row) :] if isinstance(found, tuple) else (found,)
        if not all(_ball(a).overlaps(_ball(b)) for a, b in zip(found, row, strict=True)):
            raise ComputationError(f"the emitted {name} does not have the form that the proofs are made for")


def _straight(rod: RodParameters, force: Scalar) -> StraightRod:
    force = force if hasattr(force, "coeffs") else flint().acb(force)
    return uniform_rod(rod, force, BallNumbers())


def _ball(value: Any) -> Scalar:
    return flint().acb(value) if isinstance(value, int) else value


def _slopes(straight: StraightRod, quantity: str) -> tuple[Scalar, Scalar]:
    """Derivatives of the tip load's F2 and M in the angle or a rate t, at the straight rod at rest.

    Both are odd in t, by reflection. So where the force is a series F + F't, with the same t, the load's
    series is a(F) t + a'(F)F' t² + …: it holds the series of the derivative.
    """
    if quantity not in arguments(straight.functions.tip_load):
        return NONE, NONE
    f, force = flint(), straight.force
    with series_terms(3):
        still = {name: f.acb(0) for name in ("theta", "v1", *RATES)}
        known = f.acb_series(list(force.coeffs())) if hasattr(force, "coeffs") else force
        _, *odd = straight("tip_load", **(still | {quantity: f.acb_series([0, 1]), "force": known}))
        parts = [(x[1], x[2]) if hasattr(x, "coeffs") else (f.acb(0), f.acb(0)) for x in odd]
    in_series = hasattr(force, "coeffs")
    first, second = (
        NONE if a == 0 and a_force == 0 else f.acb_series([a, a_force]) if in_series else a
        for a, a_force in parts
    )
    return first, second
