"""A straight rod of uniform stretch in numbers of any kind: its emitted functions and its parameters, exact.

Where the same stretch holds all along the straight rod its linear problem has constant coefficients, and its
modes are exponentials. The functions run on whatever numbers are given, mpmath's (rodwnl/exact.py) or balls
(rodwnl/balls.py), which serve as their namespace of functions too. Lengths in L, times in γ2L⁴/k3, forces in
k3/L².
"""

from __future__ import annotations

from collections.abc import Callable
from fractions import Fraction
from typing import Any, Protocol

from rodwnl import kernels
from rodwnl.errors import InputError
from rodwnl.fields import Arithmetic, Scalar
from rodwnl.parameters import RodParameters
from rodwnl.straightrod import StraightRod, arguments, straight_rod

Balance = Callable[[Scalar, Scalar], tuple[Scalar, Scalar]]


class Numbers(Arithmetic, Protocol):
    """Arithmetic with what emitted functions contain, that knows the exact rationals a rod is made of."""

    def number(self, value: Fraction) -> Scalar: ...
    def sqrt(self, z: Scalar) -> Scalar: ...
    def log(self, z: Scalar) -> Scalar: ...
    def sin(self, z: Scalar) -> Scalar: ...
    def cos(self, z: Scalar) -> Scalar: ...

    def stretch(self, force: Scalar, balance: Balance, start: Callable[[float], float]) -> Scalar:
        """ν with F1(ν) + F = 0. balance: (F, ν) -> (F1 + F, K1); start: the float64 solution at a force."""


def require_uniform(rod: RodParameters, what: str) -> None:
    """InputError unless the modes are exponentials; `what` is computed from those."""
    if not kernels.is_uniform(rod.model):
        raise InputError(
            f"{what} needs modes that are exponentials, that is a straight rod with the same stretch "
            f"everywhere; that of {rod.model_name!r} varies along it under its distributed load: "
            f"leave out {what}"
        )


def uniform_rod(rod: RodParameters, force: Scalar, numbers: Numbers) -> StraightRod:
    """The rod straight under this force, every value of it in these numbers.

    Raises InputError where there is no straight rod or where its stretch is not uniform, and what `numbers`
    raises where it cannot solve for an implicit stretch.
    """
    require_uniform(rod, "this computation")
    functions = kernels.load(rod.model)
    basic = {name: getattr(rod, name) for name in ("k1", "k2", "gamma3", "gamma1")}
    values: dict[str, Any] = {name: numbers.number(p) for name, p in (basic | dict(rod.own)).items()}
    values |= {"force": force, "xp": numbers}
    straight = StraightRod(functions, force, values)
    if "nu" in arguments(functions.straight_rod):

        def balance(force: Scalar, nu: Scalar) -> tuple[Scalar, Scalar]:
            at = {"force": force, "nu": nu}
            return straight("straight_rod", **at)[-1], straight("stretch_stiffness", **at)

        values["nu"] = numbers.stretch(force, balance, lambda f: straight_rod(rod, f).values["nu"].real)
    return straight
