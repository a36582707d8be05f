"""Exact directional derivatives: numbers with nilpotent parts, e_i² = 0.

A function of + − × ÷, powers, sin and cos, evaluated at a + e1 b + e2 c + e3 d, has as its coefficient of
e1 e2 e3 the third derivative D³f(a)[b, c, d], exactly up to round-off, for real or complex directions and
without any step size; the coefficients of e1 and e1 e2 are Df(a)[b] and D²f(a)[b, c]. (Multi-dimensional
dual numbers.)
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from math import factorial
from typing import Any, TypeAlias

import numpy as np

Value: TypeAlias = Any  # a number or an array: whatever has + − × ÷ and is known to numpy


@dataclass(frozen=True, eq=False)
class Nilpotent:
    """Σ parts[m] Π_{i∈m} e_i: the set m is a bit mask, a missing part is zero, parts[0] is always there."""

    parts: dict[int, Value]

    __array_ufunc__ = None  # array + Nilpotent is ours, not an array of objects

    def __add__(self, other: Value) -> Nilpotent:
        out = dict(self.parts)
        for mask, value in nilpotent(other).parts.items():
            out[mask] = out[mask] + value if mask in out else value
        return Nilpotent(out)

    def __mul__(self, other: Value) -> Nilpotent:
        if not isinstance(other, Nilpotent):
            return Nilpotent({mask: value * other for mask, value in self.parts.items()})
        out: dict[int, Value] = {}
        for left, a in self.parts.items():
            for right, b in other.parts.items():
                if left & right == 0:
                    mask = left | right
                    out[mask] = out[mask] + a * b if mask in out else a * b
        return Nilpotent(out)

    def __neg__(self) -> Nilpotent:
        return Nilpotent({mask: -value for mask, value in self.parts.items()})

    def __sub__(self, other: Value) -> Nilpotent:
        return self.__add__(-other)

    def __rsub__(self, other: Value) -> Nilpotent:
        return (-self).__add__(other)

    def __truediv__(self, other: Value) -> Nilpotent:
        return self.__mul__(other**-1 if isinstance(other, Nilpotent) else 1 / other)

    def __rtruediv__(self, other: Value) -> Nilpotent:
        return (self**-1).__mul__(other)

    def __pow__(self, power: int | float) -> Nilpotent:
        """Any fixed power: D^k a^p = p(p−1)…(p−k+1) a^{p−k}."""

        def derivative(a: Value, k: int) -> Value:
            falling = float(np.prod([power - i for i in range(k)]))
            return falling * a ** (power - k) if falling else 0.0

        return self.apply(derivative)

    __radd__ = __add__
    __rmul__ = __mul__

    def apply(self, derivative: Callable[[Value, int], Value]) -> Nilpotent:
        """f of this number from `derivative(a, k)`, the k-th derivative of f at a; its Taylor series ends."""
        a = self.parts[0]
        rest = Nilpotent({mask: value for mask, value in self.parts.items() if mask})
        power, out, order = rest, Nilpotent({0: derivative(a, 0)}), 1
        while power.parts:
            out = out + power * (derivative(a, order) / factorial(order))
            power, order = power * rest, order + 1
        return out

    def map(self, linear: Callable[[Value], Value]) -> Nilpotent:
        """A linear operator (an integral, say) applied to every part."""
        return Nilpotent({mask: linear(value) for mask, value in self.parts.items()})

    def part(self, *directions: int) -> Value:
        """The coefficient of the product of these e_i, i ≥ 1; of no e at all: the value itself."""
        return self.parts.get(sum(1 << (i - 1) for i in directions), 0.0)


def nilpotent(value: Value, *directions: tuple[int, Value]) -> Nilpotent:
    """value + Σ e_i direction_i; a Nilpotent without directions passes unchanged."""
    if isinstance(value, Nilpotent):
        return sum((Nilpotent({0: 0.0, 1 << (i - 1): d}) for i, d in directions), value)
    return Nilpotent({0: value, **{1 << (i - 1): d for i, d in directions}})


def sin(value: Value) -> Value:
    """sin of a number, an array or a Nilpotent."""
    if not isinstance(value, Nilpotent):
        return np.sin(value)
    return value.apply(lambda a, k: (np.sin, np.cos, lambda z: -np.sin(z), lambda z: -np.cos(z))[k % 4](a))


def cos(value: Value) -> Value:
    """cos of a number, an array or a Nilpotent."""
    if not isinstance(value, Nilpotent):
        return np.cos(value)
    return value.apply(lambda a, k: (np.cos, lambda z: -np.sin(z), lambda z: -np.cos(z), np.sin)[k % 4](a))


def sqrt(value: Value) -> Value:
    """Square root of a number, an array or a Nilpotent."""
    return value**0.5 if isinstance(value, Nilpotent) else np.sqrt(value)


def exp(value: Value) -> Value:
    """exp of a number, an array or a Nilpotent."""
    return value.apply(lambda a, k: np.exp(a)) if isinstance(value, Nilpotent) else np.exp(value)


def log(value: Value) -> Value:
    """Natural logarithm of a number, an array or a Nilpotent: (−1)^{k−1} (k − 1)!/a^k after the first."""
    if not isinstance(value, Nilpotent):
        return np.log(value)
    return value.apply(lambda a, k: -factorial(k - 1) * (-1 / a) ** k if k else np.log(a))
