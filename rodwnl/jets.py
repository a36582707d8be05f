"""Numbers that emitted functions, plain arithmetic on whatever they are given, can be called with.

`Jet`: a function with its first derivatives, so that a formula gives its own. `Powers`: a Laurent polynomial
in one variable with arrays as coefficients, so that a formula gives its coefficients.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from types import SimpleNamespace
from typing import Any

import numpy as np


@dataclass(frozen=True, slots=True)
class Jet:
    """A function of some variables, such as F and λ, at n points: value (n,) and slopes (variables, n)."""

    value: Any
    slopes: Any
    __array_ufunc__ = None  # array * jet is left to the jet

    def __getitem__(self, which: Any) -> Jet:
        """At some of the points."""
        slopes = self.slopes[:, which] if self.slopes.shape[-1] > 1 else self.slopes
        return Jet(self.value[which], slopes)

    def __add__(self, other: Any) -> Jet:
        if isinstance(other, Jet):
            return Jet(self.value + other.value, self.slopes + other.slopes)
        return Jet(self.value + other, self.slopes)

    def __neg__(self) -> Jet:
        return Jet(-self.value, -self.slopes)

    def __sub__(self, other: Any) -> Jet:
        if isinstance(other, Jet):
            return Jet(self.value - other.value, self.slopes - other.slopes)
        return Jet(self.value - other, self.slopes)

    def __rsub__(self, other: Any) -> Jet:
        return Jet(other - self.value, -self.slopes)

    def __mul__(self, other: Any) -> Jet:
        if isinstance(other, Jet):
            return Jet(self.value * other.value, self.slopes * other.value + self.value * other.slopes)
        return Jet(self.value * other, self.slopes * other)

    def __truediv__(self, other: Any) -> Jet:
        if not isinstance(other, Jet):
            return Jet(self.value / other, self.slopes / other)
        inverse = 1 / other.value
        quotient = self.value * inverse
        return Jet(quotient, (self.slopes - quotient * other.slopes) * inverse)

    def __rtruediv__(self, other: Any) -> Jet:
        inverse = other / self.value
        return Jet(inverse, self.slopes * (-inverse / self.value))

    def __pow__(self, n: Any) -> Jet:
        return Jet(self.value**n, self.slopes * (n * self.value ** (n - 1)))

    __radd__, __rmul__ = __add__, __mul__


def value(x: Any) -> Any:
    """The value of a Jet, or what was given."""
    return x.value if isinstance(x, Jet) else x


def _lifted(function: Callable[[Any], Any], slope: Callable[[Any, Any], Any]) -> Callable[[Any], Any]:
    """A function of arrays as one of Jets too; slope: its derivative from its argument and its value."""

    def lifted(z: Any) -> Any:
        if not isinstance(z, Jet):
            return function(z)
        at = function(z.value)
        return Jet(at, z.slopes * slope(z.value, at))

    return lifted


sqrt = _lifted(np.sqrt, lambda z, root: 0.5 / root)
exp = _lifted(np.exp, lambda z, power: power)
#: What emitted functions take as `xp`.
NAMESPACE = SimpleNamespace(
    sqrt=sqrt,
    exp=exp,
    log=_lifted(np.log, lambda z, _: 1 / z),
    cos=_lifted(np.cos, lambda z, _: -np.sin(z)),
    sin=_lifted(np.sin, lambda z, _: np.cos(z)),
)


@dataclass(frozen=True, slots=True)
class Powers:
    """Σ c_k x^k: terms by power k, which may be negative. Divided only by one term.

    With Jets it meets inside them: the product is a Jet whose value and slopes are Powers.
    """

    terms: dict[int, Any]
    __array_ufunc__ = None

    def __add__(self, other: Any) -> Any:
        if isinstance(other, Jet):
            return NotImplemented
        terms = dict(self.terms)
        for k, c in _terms(other).items():
            terms[k] = terms[k] + c if k in terms else c
        return Powers(terms)

    def __mul__(self, other: Any) -> Any:
        if isinstance(other, Jet):
            return NotImplemented
        if not isinstance(other, Powers):
            return Powers({k: c * other for k, c in self.terms.items()})
        total: dict[int, Any] = {}
        for j, a in self.terms.items():
            for k, b in other.terms.items():
                total[j + k] = total[j + k] + a * b if j + k in total else a * b
        return Powers(total)

    def __neg__(self) -> Powers:
        return Powers({k: -c for k, c in self.terms.items()})

    def __sub__(self, other: Any) -> Any:
        return NotImplemented if isinstance(other, Jet) else self + -other

    def __rsub__(self, other: Any) -> Any:
        return -self + other

    def __truediv__(self, other: Any) -> Any:
        return NotImplemented if isinstance(other, Jet) else self * (1 / other)

    def __rtruediv__(self, other: Any) -> Powers:
        ((k, c),) = self.terms.items()
        return Powers({-k: other / c})

    def __pow__(self, n: int) -> Any:
        return self if n == 1 else self * self ** (n - 1)

    __radd__, __rmul__ = __add__, __mul__


def _terms(x: Any) -> dict[int, Any]:
    return x.terms if isinstance(x, Powers) else {0: x}


def coefficients(x: Any) -> dict[int, Any]:
    """By power the coefficients of Powers, of a Jet of them, or of what does not contain the variable."""
    if not isinstance(x, Jet):
        return _terms(x)
    value, slopes = _terms(x.value), _terms(x.slopes)
    return {k: Jet(value[k], slopes[k]) if k in slopes else value[k] for k in value}
