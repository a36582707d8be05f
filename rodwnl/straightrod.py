"""Any emitted rod, straight under one force: its emitted functions, called with what they need.

The functions of one rod take other arguments than those of another (a stiffness of its own, the stretch ν
where the axial balance cannot be solved for it, the place u under a distributed load), so they are called by
name. Lengths in L, times in γ2 L⁴/k3, forces in k3/L².
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from decimal import ROUND_DOWN, Context
from fractions import Fraction
from types import SimpleNamespace
from typing import Any

import numpy as np

from rodwnl import kernels
from rodwnl.errors import InputError
from rodwnl.parameters import RodParameters

MOST_STEPS = 60
SETTLED = 1e-15  # Newton step of ν after which only round-off is left
LEAST_STRETCH = 1e-3  # to which the search for thresholds goes: drag that follows the metric vanishes with ν
ENDS = np.array([0.0, 1.0])  # what varies along the rod is monotonic: extremes are at its ends


@dataclass(frozen=True)
class StraightRod:
    """A rod compressed straight. Calling it with the name of an emitted function evaluates that.

    force: may be complex, everything is analytic in it. values: by name, what the functions may ask for.
    """

    functions: SimpleNamespace
    force: complex
    values: Mapping[str, Any]

    def __call__(self, name: str, **fields: Any) -> Any:
        """The emitted function at these fields; those that it does not take are left out."""
        function = getattr(self.functions, name)
        known = {**self.values, **fields}
        return function(*(known[argument] for argument in arguments(function)))

    def stretch(self, u: Any) -> tuple[Any, Any]:
        """ν at these nodes and its derivative there.

        The compression is constant or falls linearly to the tip: a body load is a function of force alone,
        and a model that has one has a constant stretch stiffness.
        """
        if "nu" in self.values:
            return self.values["nu"], 0.0
        at_clamp, at_tip = (self("straight_rod", u=end)[0] for end in ENDS)
        return at_clamp + (at_tip - at_clamp) * u, at_tip - at_clamp


def arguments(function: Callable[..., Any]) -> tuple[str, ...]:
    """The names of a plain function's arguments."""
    code = function.__code__
    return code.co_varnames[: code.co_argcount]


def parameter_values(rod: RodParameters) -> dict[str, float]:
    """All parameters of the rod by name, the model's own too, each rounded to the nearest double."""
    names = ("k1", "k2", "gamma3", "gamma1")
    return {n: float(getattr(rod, n)) for n in names} | {n: float(v) for n, v in rod.own}


def straight_rod(rod: RodParameters, force: complex) -> StraightRod:
    """The straight rod under this force.

    Raises InputError where there is none or where it breaks an assumption of the theory: the stretch must be
    positive, the energy convex and the drag positive.
    """
    functions = kernels.load(rod.model)
    values: dict[str, Any] = parameter_values(rod) | {"force": force, "xp": np}
    try:
        with np.errstate(all="ignore"):  # what is not finite is refused, here and below
            if "nu" in arguments(functions.straight_rod):
                values["nu"] = _stretch(rod, functions, values)
            straight = StraightRod(functions, force, values)
            _require_sound(rod, straight)
    except ZeroDivisionError:
        raise InputError(
            f"{_straight(rod, force)}: a derivative of its energy, or its drag, divides by zero, but both "
            "must be smooth there and at the undeformed rod, h1 = 1"
        ) from None
    return straight


def _straight(rod: RodParameters, force: complex) -> str:
    """The rod and its state, as messages name them."""
    return f"rod {rod.model_name!r}, straight under force = {np.real(force):.10g}"


def _stretch(rod: RodParameters, functions: SimpleNamespace, values: Mapping[str, Any]) -> complex:
    """Newton's method for F1(ν) + F = 0, from the unloaded rod; the slope of the balance in ν is K1."""

    def at(nu: complex) -> tuple[complex, complex]:
        trial = StraightRod(functions, values["force"], {**values, "nu": nu})
        return trial("straight_rod")[-1], trial("stretch_stiffness")

    nu: complex = 1.0
    balance, stiffness = at(nu)
    if not 0 < np.real(stiffness) < np.inf:
        raise InputError(
            f"rod {rod.model_name!r}: the stretch stiffness of the undeformed rod is "
            f"{np.real(stiffness):.6g}, but its energy must be convex there"
        )
    for _ in range(MOST_STEPS):
        if not np.real(stiffness) > 0:
            break
        step = balance / stiffness
        # What the rounding of the balance, terms of the size of the force, does to ν.
        if abs(step) <= SETTLED * (1 + abs(values["force"]) / abs(stiffness)):
            return nu - step
        # Not beyond zero length, nor beyond the largest load that the rod can carry, where K1 changes sign.
        while np.real(step) >= np.real(nu) or not np.real(at(nu - step)[1]) > 0:
            step = step / 2
            if abs(step) <= SETTLED:
                break
        nu = nu - step
        balance, stiffness = at(nu)
    raise InputError(
        f"rod {rod.model_name!r} has no straight state at force = {np.real(values['force']):.10g}: "
        "no stretch above 0 with positive stretch stiffness balances it; take a smaller force"
    )


def _require_sound(rod: RodParameters, straight: StraightRod) -> None:
    length, convex = "the straight rod must have positive length", "its energy must be convex there"
    checks: tuple[tuple[str, Callable[[], Any], str], ...] = (
        ("the stretch", lambda: straight.stretch(ENDS)[0], length),  # first: the others may divide by it
        ("the stretch stiffness", lambda: straight("stretch_stiffness", u=ENDS), convex),
        ("the shear stiffness", lambda: straight("y_row", u=ENDS)[2], convex),
        ("the bending stiffness", lambda: straight("theta_row", u=ENDS)[5], convex),
        ("the axial drag", lambda: straight("drag_weights", u=ENDS)[0], "drag must be positive"),
        ("the transverse drag", lambda: straight("drag_weights", u=ENDS)[1], "drag must be positive"),
        ("the rotational drag", lambda: straight("drag_weights", u=ENDS)[2], "drag must be positive"),
    )
    for what, value, assumption in checks:
        least = float(np.min(np.real(value())))
        if not 0 < least < np.inf:
            raise InputError(f"{_straight(rod, straight.force)}: {what} is {least:.6g}, but {assumption}")


def largest_force(rod: RodParameters, asked: Fraction) -> tuple[Fraction, bool]:
    """`asked`, or where the straight rod is compressed to LEAST_STRETCH or ends before; whether it was cut.

    Raises InputError if there is no straight state even without a force.
    """
    straight_rod(rod, 0.0)
    if _reaches(rod, asked):
        return asked, False
    low, high = Fraction(0), asked
    for _ in range(60):
        middle = (low + high) / 2
        low, high = (middle, high) if _reaches(rod, middle) else (low, middle)
    # Nine digits, rounded down: beyond `low` there is no straight rod.
    return Fraction(Context(prec=9, rounding=ROUND_DOWN).create_decimal(repr(float(low)))), True


def _reaches(rod: RodParameters, force: Fraction) -> bool:
    try:
        straight = straight_rod(rod, float(force))
    except InputError:
        return False
    # Up to the rounding of ν, so that the bound itself, often a short decimal, is reached.
    return bool(np.min(straight.stretch(ENDS)[0]) >= LEAST_STRETCH - SETTLED)
