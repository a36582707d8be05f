"""Any emitted rod, straight under one force: its emitted functions, called with what they need.

The functions of one rod take other arguments than those of another (a stiffness of its own, the stretch ν
where the axial balance cannot be solved for it, the place u under a distributed load), so they are called by
name. Lengths in L, times in γ2 L⁴/k3, forces in k3/L².
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from decimal import ROUND_DOWN, Context
from fractions import Fraction
from functools import partial
from types import SimpleNamespace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from rodwnl import kernels
from rodwnl.errors import InputError
from rodwnl.parameters import RodParameters

MOST_STEPS = 60
SETTLED = 1e-15  # Newton step of ν after which only round-off is left
CLOSE = 1e-8  # step after which the next one is shorter by far, but for round-off
# Parts of their values without force to which the search for thresholds goes, of the others to 0: drag that
# follows the metric vanishes with ν, and with the stiffnesses so does the length of the waves to resolve.
LEAST = {"the stretch": 1e-3, "the shear stiffness": 1e-2, "the bending stiffness": 1e-2}
TIP_DRAG = {
    "v1": "axial",
    "v2": "transverse",
    "Omega": "rotational",
}  # rates that a load at the tip may brake
MAY_VANISH = {f"the {direction} drag of the tip load" for direction in TIP_DRAG.values()}
SLIGHT = 1e-6  # strains, where the laws of the deformed rod are looked at
ENDS = np.array([0.0, 1.0])
PLACES = np.linspace(0.0, 1.0, 33)  # along the rod, where its stretch, stiffnesses and drag must be positive


@dataclass(frozen=True)
class StraightRod:
    """A rod compressed straight. Calling it with the name of an emitted function evaluates that.

    force: may be complex, everything is analytic in it; or an array, for many rods. values: by name, what the
    functions may ask for. An implicit ν is among them where it is the same at every u, else it is solved for
    where a function is evaluated.
    """

    functions: SimpleNamespace
    force: Any
    values: Mapping[str, Any]
    _solved: dict[tuple[tuple[int, ...], bytes], Any] = field(default_factory=dict, compare=False, repr=False)

    def __call__(self, name: str, **fields: Any) -> Any:
        """The emitted function at these fields; those that it does not take are left out."""
        function = getattr(self.functions, name)
        known = {**self.values, **fields}
        asked = arguments(function)
        if "nu" in asked and "nu" not in known:
            known["nu"] = self._implicit(known["u"])
        if "nu_tip" in asked:
            known["nu_tip"] = self._implicit(1.0)
        return function(*(known[argument] for argument in asked))

    def stretch(self, u: Any) -> tuple[Any, Any]:
        """ν at these nodes and its derivative there, ν' = −P'/K1.

        The compression P is constant or falls linearly to the tip: a body load is a function of force alone.
        """
        if "nu" in self.values:
            return self.values["nu"], 0.0
        nu = self._implicit(u) if self.varies_implicitly else self("straight_rod", u=u)[0]
        at_clamp, at_tip = (self("straight_rod", u=end)[-2] for end in ENDS)
        return nu, (at_clamp - at_tip) / self("stretch_stiffness", u=u)

    @property
    def mu(self) -> Any:
        """μ = K2ν + P of a rod of uniform stretch."""
        found = self("base_state")
        return found[-1] if isinstance(found, tuple) else found

    @property
    def varies_implicitly(self) -> bool:
        """Whether ν is a function of u that the force does not give explicitly."""
        return {"u", "nu"} <= set(arguments(self.functions.straight_rod))

    def _implicit(self, u: Any) -> Any:
        """ν at these places, found once."""
        key = np.shape(u), np.asarray(u, float).tobytes()
        if key not in self._solved:
            nu = balanced_stretch(self.functions, {**self.values, "u": u})
            if np.isnan(nu).any():
                raise InputError(
                    f"at force = {np.real(self.force):.10g} no stretch of the straight rod was found at "
                    f"u = {np.asarray(u)[np.isnan(nu)].max():.6g}; take a smaller force"
                )
            self._solved[key] = nu[()]
        return self._solved[key]


@dataclass(frozen=True)
class Statics:
    """Constants of the linear problem at λ = 0 of a rod of uniform stretch.

    load: the compression. ay, atheta: derivatives of the tip load (F2, M) in the angle. As rodwnl/steady.py
    has them.
    """

    K2: Any
    K3: Any
    mu: Any
    load: Any
    ay: Any
    atheta: Any


def statics(straight: StraightRod, zero: Any) -> Statics:
    """The constants of a rod of uniform stretch, in its own numbers; zero: 0 among them."""
    *explicit, load, _ = straight("straight_rod")
    nu = explicit[0] if explicit else straight.values["nu"]
    _, K2, by_angle, _ = straight("y_tip_row", lam=zero)
    _, _, by_twist, K3 = straight("theta_tip_row", lam=zero)
    return Statics(K2, K3, straight.mu, load, -by_angle - K2 * nu, -by_twist)


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
    try:
        with np.errstate(all="ignore"):  # what is not finite is refused, here and below
            straight = _balanced(rod, force)
            _require_sound(rod, straight)
    except ZeroDivisionError:
        raise InputError(
            f"{_straight(rod, force)}: a derivative of its energy, or its drag, divides by zero, but both "
            "must be smooth there and at the undeformed rod, h1 = 1"
        ) from None
    return straight


def _balanced(rod: RodParameters, force: complex) -> StraightRod:
    """The straight rod whose axial forces balance, whatever else holds of it."""
    functions = kernels.load(rod.model)
    values: dict[str, Any] = parameter_values(rod) | {"force": force, "xp": np}
    straight = StraightRod(functions, force, values)
    if "nu" not in arguments(functions.straight_rod):
        return straight
    nu = _stretch(rod, straight)
    return straight if straight.varies_implicitly else StraightRod(functions, force, {**values, "nu": nu})


def _straight(rod: RodParameters, force: complex) -> str:
    """The rod and its state, as messages name them."""
    return f"rod {rod.model_name!r}, straight under force = {np.real(force):.10g}"


def _stretch(rod: RodParameters, straight: StraightRod) -> complex:
    """An implicit ν at the clamp, where the compression is largest."""
    nu = balanced_stretch(straight.functions, {**straight.values, "u": 0.0})
    if np.isnan(nu):
        with np.errstate(all="ignore"):
            stiffness = np.real(straight("stretch_stiffness", nu=np.float64(1)))
        if not 0 < stiffness < np.inf:
            raise InputError(
                f"rod {rod.model_name!r}: the stretch stiffness of the undeformed rod is {stiffness:.6g}, "
                "but its energy must be convex there"
            )
        raise InputError(
            f"rod {rod.model_name!r} has no straight state at force = {np.real(straight.force):.10g}: "
            "no stretch above 0 with positive stretch stiffness balances it; take a smaller force"
        )
    return complex(nu) if np.iscomplexobj(nu) else float(nu)


def balanced_stretch(functions: SimpleNamespace, values: Mapping[str, Any]) -> NDArray[Any]:
    """ν for parameters, forces and places u that broadcast, NaN where there is no straight rod.

    Newton's method for F1(ν) + F = 0, from the unloaded rod; the slope of the balance in ν is K1.
    """

    def at(nu: Any) -> tuple[Any, Any]:
        trial = StraightRod(functions, values["force"], {**values, "nu": nu})
        return trial("straight_rod")[-1], trial("stretch_stiffness")

    numbers = [np.asarray(v) for name, v in values.items() if name != "xp"]
    nu = np.ones(np.broadcast_shapes(*(v.shape for v in numbers)), dtype=np.result_type(*numbers, 1.0))
    found = np.full_like(nu, np.nan)
    open_ = np.ones(nu.shape, dtype=bool)
    with np.errstate(all="ignore"):
        balance, stiffness = at(nu)
        last = np.full(nu.shape, np.inf)
        for _ in range(MOST_STEPS):
            open_ &= np.real(stiffness) > 0
            step = np.where(open_, balance / stiffness, 0)
            # What the rounding of the balance, terms of the size of the force, does to ν; where its terms are
            # larger, the steps cease to shrink.
            size = np.abs(step)
            settled = open_ & (
                (size <= SETTLED * (1 + np.abs(values["force"]) / np.abs(stiffness)))
                | ((size < CLOSE) & (size > last / 4))
            )
            found = np.where(settled, nu - step, found)
            open_ &= ~settled
            if not open_.any():
                break
            # Not beyond zero length, nor beyond the largest load that the rod carries, where K1 changes sign.
            while True:
                balance, stiffness = at(nu - step)
                far = (np.real(step) >= np.real(nu)) | np.logical_not(np.real(stiffness) > 0)
                far &= open_
                open_ &= ~(far & (np.abs(step) < CLOSE))  # the load is beyond the largest one
                far &= open_
                if not far.any():
                    break
                step = np.where(far, step / 2, step)
            nu, last = nu - step, np.abs(step)
    return found


def assumptions(straight: StraightRod, u: Any) -> tuple[tuple[str, Callable[[], Any], str], ...]:
    """What must be positive at these nodes, or not negative (MAY_VANISH): name, value, and the reason."""
    length, convex = "the straight rod must have positive length", "its energy must be convex there"
    load = getattr(straight.functions, "tip_load", None)
    rates = [rate for rate in TIP_DRAG if load and rate in arguments(load)]
    return (
        ("the stretch", lambda: straight.stretch(u)[0], length),  # first: the others may divide by it
        ("the stretch stiffness", lambda: straight("stretch_stiffness", u=u), convex),
        ("the shear stiffness", lambda: straight("y_row", u=u)[2], convex),
        ("the bending stiffness", lambda: straight("theta_row", u=u)[5], convex),
        ("the axial drag", lambda: straight("drag_weights", u=u)[0], "drag must be positive"),
        ("the transverse drag", lambda: straight("drag_weights", u=u)[1], "drag must be positive"),
        ("the rotational drag", lambda: straight("drag_weights", u=u)[2], "drag must be positive"),
        *(
            (f"the {TIP_DRAG[rate]} drag of the tip load", partial(tip_drag, straight, rate), "it must brake")
            for rate in rates
        ),
    )


def tip_drag(straight: StraightRod, rate: str) -> Any:
    """−∂F1/∂v1, −∂F2/∂v2 or −∂M/∂Ω of the load at the tip of the straight rod at rest."""
    step = 1e-100j  # the load is a polynomial in the rates: its slope, to the last bit
    rest = dict.fromkeys(("theta", *TIP_DRAG), 0.0)
    given = rest | {rate: step, "force": np.real(straight.force)}
    load = straight("tip_load", **given)[list(TIP_DRAG).index(rate)]
    return -np.imag(load) / abs(step)


def _conditions(straight: StraightRod) -> tuple[tuple[str, Callable[[], Any], str], ...]:
    """`assumptions` along the rod; where ν(u) is implicit, also from end to end, so that it does not jump."""
    if not straight.varies_implicitly:
        return assumptions(straight, PLACES)

    def stiffness() -> Any:
        at_clamp, at_tip = np.real(straight.stretch(ENDS)[0])
        return straight("stretch_stiffness", nu=np.linspace(at_clamp, at_tip, PLACES.size))

    convex = "its energy must be convex there"
    return (*assumptions(straight, PLACES), ("the stretch stiffness", stiffness, convex))


def _require_sound(rod: RodParameters, straight: StraightRod) -> None:
    for what, value, assumption in _conditions(straight):
        least = np.min(np.real(value()))
        if not held(what, least, least):
            raise InputError(f"{_straight(rod, straight.force)}: {what} is {least:.6g}, but {assumption}")
    _require_real(rod, straight)


def _require_real(rod: RodParameters, straight: StraightRod) -> None:
    """A root or a logarithm of a parameter may make a law complex without touching the straight rod's own."""
    strains = {"h1": 1.0, "h2": SLIGHT, "Pi": SLIGHT}
    for what, name in (("the stresses", "stresses"), ("the drag", "drag_coefficients")):
        values = straight(name, **strains)
        if not np.all(np.isreal(values) & np.isfinite(values)):
            raise InputError(
                f"rod {rod.model_name!r}: {what} at h1 = 1, h2 = Pi = {SLIGHT:g} are "
                f"({', '.join(f'{v:.6g}' for v in values)}), but they must be real"
            )


def largest_force(rod: RodParameters, asked: Fraction) -> tuple[Fraction, bool]:
    """`asked`, or where the straight rod is at the LEAST of an assumption or ends before; whether it was cut.

    Raises InputError if there is no straight state even without a force.
    """
    straight_rod(rod, 0.0)
    if not obstacle(rod, asked):
        return asked, False
    low, high = Fraction(0), asked
    for _ in range(60):
        middle = (low + high) / 2
        low, high = (low, middle) if obstacle(rod, middle) else (middle, high)
    # Nine digits, rounded down: beyond `low` the search cannot go.
    return Fraction(Context(prec=9, rounding=ROUND_DOWN).create_decimal(repr(float(low)))), True


def obstacle(rod: RodParameters, force: Fraction) -> str:
    """What keeps the search from this force, in words; nothing where it may go there."""
    try:
        with np.errstate(all="ignore"):
            unloaded, straight = _balanced(rod, 0.0), _balanced(rod, float(force))
            pairs = zip(_conditions(unloaded), _conditions(straight), strict=True)
            for (what, before, _), (_, now, _) in pairs:
                # Up to the rounding of ν, so that the bound itself, often a short decimal, is reached.
                if not held(what, np.real(before()), np.real(now())).all():
                    return _broken(what)
    except (InputError, ZeroDivisionError):
        return "there is no straight rod"
    return ""


def held(what: str, before: Any, now: Any) -> NDArray[np.bool_]:
    """Whether a quantity of `assumptions` is as it must be, and at least its LEAST of that without force."""
    positive = (now >= 0) if what in MAY_VANISH else (now > 0)
    return np.asarray(positive & (now < np.inf) & (now >= (LEAST.get(what, 0) - SETTLED) * before))


def _broken(what: str) -> str:
    if what in LEAST:
        return f"{what} falls below {LEAST[what]:g} of its value without force"
    return f"{what} is negative" if what in MAY_VANISH else f"{what} is not positive"
