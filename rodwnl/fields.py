"""Sums of P(u) e^{au}, P a polynomial: the functions that the linear rod's modes and all their products are.

Every exponent that occurs is an integer combination of a few numbers: the exponents of the mode, their
conjugates and the exponent of X2. A term is therefore filed under its integers: equal exponents merge
exactly, without comparing numbers, and products, conjugates, derivatives and integrals stay within the
class. The coefficients are whatever numbers the `Arithmetic` brings: mpmath's, at any precision, or balls
that contain the truth (rodwnl/certified.py). Neither can overflow, so that no term needs scaling.

An emitted formula runs on a `Field` as on a number: + − ×, division by a number, integer powers,
.conjugate().
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import Any, Protocol

import mpmath as mp

Scalar = Any  # mpf, mpc or acb: all that is asked of them is arithmetic and .conjugate()
Key = tuple[int, ...]
Polynomial = tuple[Scalar, ...]  # coefficients of 1, u, u², …


class Arithmetic(Protocol):
    """What a kind of number must bring besides + − × ÷."""

    def exp(self, z: Scalar) -> Scalar:
        """e^z."""

    def moment(self, p: int, a: Scalar) -> Scalar:
        """∫₀¹ u^p e^{au} du, for every a, 0 included."""

    def coincide(self, a: Scalar, b: Scalar) -> bool:
        """Whether a − b is to be taken as 0. Raises where it can be neither taken as 0 nor divided by."""


class MpArithmetic:
    """mpmath numbers, at the working precision of the moment."""

    # Numbers this many units of the last place apart are taken as equal. What a smaller gap would do to the
    # result, or a larger one by cancellation, shows when the working precision is raised.
    UNITS = 1000

    def exp(self, z: Scalar) -> Scalar:
        return mp.exp(z)

    def moment(self, p: int, a: Scalar) -> Scalar:
        return moment(p, a, self.exp, series=abs(a) < p + 1, tiny=mp.eps)

    def coincide(self, a: Scalar, b: Scalar) -> bool:
        return bool(abs(a - b) <= self.UNITS * mp.eps * max(1, abs(a), abs(b)))


def moment(p: int, a: Scalar, exp: Any, *, series: bool, tiny: Scalar) -> Scalar:
    """I_p = ∫₀¹ u^p e^{au} du = Σ aⁿ/(n! (n+p+1)); by parts, I_p = (e^a − p I_{p−1})/a, unless a is small."""
    if not series:
        e = exp(a)
        value = (e - 1) / a
        for k in range(1, p + 1):
            value = (e - k * value) / a
        return value
    value, power, n = a * 0, a * 0 + 1, 0
    while abs(power) > tiny:
        value += power / (n + p + 1)
        n += 1
        power *= a / n
    return value


class Exponents:
    """The numbers g₁, g₁*, g₂, g₂*, … of which all exponents are integer combinations."""

    def __init__(self, generators: Iterable[Scalar], arithmetic: Arithmetic) -> None:
        self.arithmetic = arithmetic
        self.basis = [each for g in generators for each in (g, g.conjugate())]
        self.zero: Key = (0,) * len(self.basis)
        self._values: dict[Key, Scalar] = {}
        self._moments: dict[tuple[Key, int], Scalar] = {}

    def key(self, generator: int, times: int = 1) -> Key:
        """The exponent `times`·g of the generator with this index."""
        return tuple(times if i == 2 * generator else 0 for i in range(len(self.basis)))

    def conjugate(self, key: Key) -> Key:
        """The exponent a*."""
        return tuple(key[i ^ 1] for i in range(len(key)))

    def value(self, key: Key) -> Scalar:
        """The number a."""
        if key not in self._values:
            self._values[key] = sum(
                (n * g for n, g in zip(key, self.basis, strict=True) if n), 0 * self.basis[0]
            )
        return self._values[key]

    def moment(self, key: Key, p: int) -> Scalar:
        """∫₀¹ u^p e^{au} du."""
        if (key, p) not in self._moments:
            self._moments[key, p] = self.arithmetic.moment(p, self.value(key))
        return self._moments[key, p]

    def field(self, terms: Mapping[Key, Polynomial]) -> Field:
        """Σ P(u) e^{au} from its terms."""
        return Field(self, dict(terms))

    def promoted(self, value: Field | Scalar) -> Field:
        """A number as a constant function; a function as it is."""
        return value if isinstance(value, Field) else Field(self, {self.zero: (value,)})

    def u(self, one: Scalar) -> Field:
        """The function u."""
        return Field(self, {self.zero: (0 * one, one)})


class Field:
    """Σ P(u) e^{au} over one set of `Exponents`; immutable. Numbers count as constant functions."""

    def __init__(self, exponents: Exponents, terms: dict[Key, Polynomial]) -> None:
        self.exponents = exponents
        self.terms = terms

    def __add__(self, other: Field | Scalar) -> Field:
        terms = dict(self.terms)
        for key, polynomial in self._promoted(other).terms.items():
            terms[key] = _sum(terms[key], polynomial) if key in terms else polynomial
        return Field(self.exponents, terms)

    def __mul__(self, other: Field | Scalar) -> Field:
        if not isinstance(other, Field):
            return self._map(lambda _, polynomial: tuple(c * other for c in polynomial))
        terms: dict[Key, Polynomial] = {}
        for a, p in self.terms.items():
            for b, q in self._promoted(other).terms.items():
                key = tuple(m + n for m, n in zip(a, b, strict=True))
                product = _product(p, q)
                terms[key] = _sum(terms[key], product) if key in terms else product
        return Field(self.exponents, terms)

    def __truediv__(self, number: Scalar) -> Field:
        if isinstance(number, Field):
            raise TypeError("a sum of exponentials can be divided by a number only")
        return self._map(lambda _, polynomial: tuple(c / number for c in polynomial))

    def __pow__(self, power: int) -> Field:
        if not isinstance(power, int) or power < 1:
            raise TypeError(
                f"a sum of exponentials can be raised to positive integer powers only, not {power!r}"
            )
        result = self
        for _ in range(power - 1):
            result = result * self
        return result

    def __neg__(self) -> Field:
        return self._map(lambda _, polynomial: tuple(-c for c in polynomial))

    def __sub__(self, other: Field | Scalar) -> Field:
        return self + (-self._promoted(other))

    def __rsub__(self, other: Scalar) -> Field:
        return (-self).__add__(other)

    __radd__ = __add__
    __rmul__ = __mul__

    def conjugate(self) -> Field:
        """The complex conjugate at real u."""
        conjugate = self.exponents.conjugate
        return Field(
            self.exponents,
            {conjugate(key): tuple(c.conjugate() for c in p) for key, p in self.terms.items()},
        )

    def derivative(self) -> Field:
        """(P e^{au})' = (P' + aP) e^{au}."""
        value = self.exponents.value
        return self._map(lambda key, p: _sum(_derivative(p), tuple(value(key) * c for c in p)))

    def antiderivative(self) -> Field:
        """The integral from 0 to u: Q e^{au} with Q' + aQ = P, which for a = 0 raises the degree by one."""
        terms = {}
        for key, p in self.terms.items():
            a = self.exponents.value(key)
            if key == self.exponents.zero or self.exponents.arithmetic.coincide(a, 0 * a):
                terms[key] = (0 * a, *(c / (k + 1) for k, c in enumerate(p)))
            else:
                terms[key] = _downward(p, lambda k, q, a=a: (q.get(k + 1, 0) * (k + 1), a))
        integral = Field(self.exponents, terms)
        return integral + integral._promoted(-integral.at_start())

    def integral(self) -> Scalar:
        """∫₀¹ du."""
        return sum(
            c * self.exponents.moment(key, k) for key, p in self.terms.items() for k, c in enumerate(p)
        )

    def __call__(self, u: Scalar) -> Scalar:
        """The value at u."""
        exp, value = self.exponents.arithmetic.exp, self.exponents.value
        return sum(exp(value(key) * u) * _horner(p, u) for key, p in self.terms.items())

    def at_start(self) -> Scalar:
        """The value at u = 0."""
        return sum(p[0] for p in self.terms.values())

    def at_tip(self) -> Scalar:
        """The value at u = 1."""
        exp, value = self.exponents.arithmetic.exp, self.exponents.value
        return sum(exp(value(key)) * sum(p) for key, p in self.terms.items())

    def _map(self, change: Any) -> Field:
        return Field(self.exponents, {key: change(key, p) for key, p in self.terms.items()})

    def _promoted(self, other: Field | Scalar) -> Field:
        promoted = self.exponents.promoted(other)
        if promoted.exponents is not self.exponents:
            raise ValueError("these two sums of exponentials do not share their exponents")
        return promoted


def two_point(forcing: Field, root: Key, slope: Scalar, spring: Scalar = 0) -> Field:
    """The solution of X'' − s²X = forcing, X(0) = 0, X'(1) + spring X(1) = slope; `root` is the key of s.

    X = X_p + A e^{su} + B e^{−su}, or X_p + A + Bu where s = 0 (a key of zeros). Unique unless
    cosh s + spring sinh(s)/s = 0.
    """
    exponents = forcing.exponents
    X = particular(forcing, root)
    start, slope = X.at_start(), slope - X.derivative().at_tip() - spring * X.at_tip()
    if root == exponents.zero:
        return X + exponents.field({root: (-start, (slope + spring * start) / (1 + spring))})
    s = exponents.value(root)
    # A + B = −start,  A (s + spring) e^s − B (s − spring) e^{−s} = slope
    grow = exponents.arithmetic.exp(s) * (1 + spring / s)
    decay = exponents.arithmetic.exp(-s) * (1 - spring / s)
    return X + exponents.field(
        {
            root: ((slope / s - start * decay) / (grow + decay),),
            tuple(-n for n in root): ((-slope / s - start * grow) / (grow + decay),),
        }
    )


def particular(forcing: Field, root: Key) -> Field:
    """Some X with X'' − s²X = forcing: for a term P e^{au} it is Q e^{au} with Q'' + 2aQ' + (a² − s²)Q = P.

    Solved from the highest power down. At a resonance, a = ±s, the factor of Q vanishes and Q has one degree
    more than P (two, if s = 0).
    """
    exponents = forcing.exponents
    s, coincide = exponents.value(root), exponents.arithmetic.coincide
    terms: dict[Key, Polynomial] = {}
    for key, p in forcing.terms.items():
        a = exponents.value(key)
        named = key in (root, tuple(-n for n in root))
        if not named and (key == exponents.zero or not (coincide(a, s) or coincide(a, -s))):
            # (a² − s²) Q = P − 2aQ' − Q''
            terms[key] = _downward(
                p,
                lambda k, q, a=a: (
                    2 * a * (k + 1) * q.get(k + 1, 0) + (k + 2) * (k + 1) * q.get(k + 2, 0),
                    (a - s) * (a + s),
                ),
            )
        elif root != exponents.zero:
            # 2aR = P − R' for R = Q'
            R = _downward(p, lambda k, q, a=a: ((k + 1) * q.get(k + 1, 0), 2 * a))
            terms[key] = (0 * a, *(c / (k + 1) for k, c in enumerate(R)))
        else:
            # Q'' = P
            terms[key] = (0 * a, 0 * a, *(c / ((k + 1) * (k + 2)) for k, c in enumerate(p)))
    return Field(exponents, terms)


def _downward(p: Polynomial, known: Any) -> Polynomial:
    """q_k = (p_k − rest)/divisor from the highest k down, (rest, divisor) = known(k, those found so far)."""
    q: dict[int, Scalar] = {}
    for k in reversed(range(len(p))):
        rest, divisor = known(k, q)
        q[k] = (p[k] - rest) / divisor
    return tuple(q[k] for k in range(len(p)))


def _sum(p: Polynomial, q: Polynomial) -> Polynomial:
    short, long = sorted((p, q), key=len)
    return tuple(a + b for a, b in zip(short, long, strict=False)) + long[len(short) :]


def _product(p: Polynomial, q: Polynomial) -> Polynomial:
    result: list[Scalar] = [0] * (len(p) + len(q) - 1)
    for i, a in enumerate(p):
        for j, b in enumerate(q):
            result[i + j] += a * b
    return tuple(result)


def _derivative(p: Polynomial) -> Polynomial:
    return tuple(k * c for k, c in enumerate(p))[1:]


def _horner(p: Polynomial, u: Scalar) -> Scalar:
    value = p[-1]
    for c in reversed(p[:-1]):
        value = value * u + c
    return value
