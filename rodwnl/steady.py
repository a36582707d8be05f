"""Steady crossings of a rod of uniform stretch in closed form: where 0 is an eigenvalue, to any precision.

At λ = 0 the linear problem of rodwnl/linearrod.py is K2 H − FΘ = (ay − F)Θ(1), K3 Θ'' + μH = 0 and Θ(0) = 0,
K3 Θ'(1) = aθ Θ(1). So Θ − (1 − ay/F)Θ(1) is a multiple of cos and sin of pu, p² = μF/(K2K3), and there is a
solution where

    E(F) = 1 − (ay/F)(1 − cos p) − (aθ/K3) sin(p)/p = 0.

A simple zero of E is a real eigenvalue that crosses, a double one a real eigenvalue that touches 0 and turns
back. Near a double zero two crossings, a touch and none look alike in double precision; digits tell.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

import mpmath as mp

from rodwnl.errors import ComputationError
from rodwnl.exact import GUARD, MpNumbers, checked_digits
from rodwnl.fields import Scalar
from rodwnl.parameters import RodParameters
from rodwnl.straightrod import statics
from rodwnl.uniformrod import uniform_rod

TOUCH_DIGITS = 50  # to which E vanishes where it is said to touch 0
MOST_STEPS = 60


@dataclass(frozen=True)
class Extremum:
    """An extremum of E. kind: whether E vanishes there to TOUCH_DIGITS, or changes its sign on both sides, at
    about force ± gap, or keeps it.
    """

    force: Scalar
    kind: Literal["touch", "two crossings", "none"]
    gap: Scalar


def static_balance(rod: RodParameters, force: Scalar) -> Scalar:
    """E(F), at the working precision of the moment."""
    at = statics(uniform_rod(rod, force, MpNumbers()), mp.mpf(0))
    p = mp.sqrt(at.mu * at.load / (at.K2 * at.K3))
    return 1 - at.ay / at.load * (1 - mp.cos(p)) - at.atheta / at.K3 * mp.sincpi(p / mp.pi)


def steady_force(rod: RodParameters, near: float, digits: int) -> Scalar:
    """The force of the steady crossing near this one, to so many digits: two working precisions agree.

    Raises ComputationError where Newton's method finds none.
    """
    digits = checked_digits(digits)
    found = [_zero(rod, mp.mpf(near), digits + n * GUARD, 0) for n in (1, 2)]
    if abs(found[0] - found[1]) > mp.mpf(10) ** -(digits + 2) * abs(found[1]):
        raise ComputationError(f"{digits} digits of the steady crossing near {near!r} were not reached")
    return found[1]


def extremum(rod: RodParameters, near: float) -> Extremum:
    """The extremum of E near a force, and what E does there. Raises ComputationError where there is none."""
    working = 2 * TOUCH_DIGITS
    force = _zero(rod, mp.mpf(near), working, 1)
    with mp.workdps(working):
        value = static_balance(rod, force)
        step = force * mp.mpf(10) ** -(TOUCH_DIGITS // 3)
        beside = static_balance(rod, force + step) + static_balance(rod, force - step)
        curvature = (beside - 2 * value) / step**2
        if abs(value) < mp.mpf(10) ** -TOUCH_DIGITS:
            return Extremum(force, "touch", mp.mpf(0))
        crosses = value * curvature < 0
        return Extremum(force, "two crossings" if crosses else "none", mp.sqrt(2 * abs(value / curvature)))


def _zero(rod: RodParameters, force: Scalar, working: int, order: Literal[0, 1]) -> Scalar:
    """Newton's method for E = 0 or E' = 0; derivatives are central differences over 10^(−working/2)."""
    with mp.workdps(2 * working):
        h = mp.mpf(10) ** -(working // 2)
        for _ in range(MOST_STEPS):
            low, here, high = (static_balance(rod, force * (1 + k * h)) for k in (-1, 0, 1))
            slope, bend = (high - low) / (2 * h), (high + low - 2 * here) / h**2
            step = -(slope / bend if order else here / slope)
            force *= 1 + step
            if abs(step) > mp.mpf("0.1"):
                break
            if abs(step) < mp.mpf(10) ** -working:
                return force
    raise ComputationError(f"no steady crossing is found near force {mp.nstr(force, 10)}")
