"""The closed characteristic function of many straight rods at once, with analytic derivatives.

Arrays of one shape throughout. Lengths in L, times in γ2 L⁴/k3, forces in k3/L²; ν = 1 − F/k1, μ = k2 ν + F.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from rodwnl import kernels

Real = NDArray[np.float64]
Complex = NDArray[np.complexfloating[Any, Any]]
Rods = tuple[Any, Any, Any]  # k1, k2, gamma3: arrays, or jets

BLOCK = 2048  # array elements: the allocator reuses temporary arrays of 32 kB, not larger ones


@dataclass(frozen=True, slots=True)
class Jet:
    """A function of some variables, such as F and λ, at n points: value (n,) and slopes (variables, n)."""

    value: Any
    slopes: Any
    __array_ufunc__ = None  # array * jet is left to the jet

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

    __radd__, __rmul__ = __add__, __mul__


def _sqrt(z: Any) -> Any:
    if not isinstance(z, Jet):
        return np.sqrt(z)
    root = np.sqrt(z.value)
    return Jet(root, z.slopes * (0.5 / root))


def _exp(z: Any) -> Any:
    if not isinstance(z, Jet):
        return np.exp(z)
    power = np.exp(z.value)
    return Jet(power, power * z.slopes)


def _value(z: Any) -> Any:
    return z.value if isinstance(z, Jet) else z


@dataclass(frozen=True)
class Characteristic:
    """D e^{−r1−r2}, D's dominant term for Re r1, Re r2 → ∞ scaled alike, and Im(r1 + r2)."""

    scaled: Any
    dominant: Any
    turn: Any


def characteristic(rods: Rods, force: Any, lam: Any) -> Characteristic:
    """D(F, λ), zero exactly at the eigenvalues; real on the real axis, positive at λ = 0. Arrays or jets.

    With z = r² the exponents obey z² − s z + p = 0. Written in cosh r u and sinh r u the four boundary
    conditions have the determinant, up to a factor that never vanishes on the imaginary axis,

        λ(z1 − z2)² D = cosh r1 cosh r2 (a1² b2 + a2² b1) − (sinh r1 sinh r2)/(r1 r2) a1 a2 (b1 z2 + b2 z1)
                        − a1 a2 (b1 + b2),        a = k2 z − λ ~ Θ,    b = F z + νλ ~ H.

    Its symmetric functions of z1, z2 need no roots; the roots z1 ≠ z2 are distinct there (paper:
    eq:linearization).
    """
    k1, k2, gamma3 = rods
    nu = 1 - force * (1 / k1)
    mu = k2 * nu + force
    s = (lam * (1 + k2 * gamma3) - mu * force) / k2
    p = lam * (mu * nu + lam * gamma3) / k2
    discriminant = s * s - 4 * p
    z1, z2 = _roots(s, p, discriminant)
    r1, r2 = _sqrt(z1), _sqrt(z2)
    e1, e2 = _exp(-r1), _exp(-r2)
    a1, a2 = k2 * z1 - lam, k2 * z2 - lam
    b1, b2 = force * z1 + nu * lam, force * z2 + nu * lam
    product = a1 * a2
    clamped = a1 * a1 * b2 + a2 * a2 * b1
    mixed = product * (force * p * 2 + nu * lam * s) / (r1 * r2)
    square1, square2 = e1 * e1, e2 * e2
    both, neither = square1 * square2 + 1, square1 + square2
    scaled = (
        (both + neither) * clamped - (both - neither) * mixed - 4 * (e1 * e2 * product * (b1 + b2))
    )  # fmt: skip
    spurious = discriminant * lam * (k2 * k2)
    return Characteristic(scaled / spurious, (clamped - mixed) / spurious, (_value(r1) + _value(r2)).imag)


def _roots(s: Any, p: Any, discriminant: Any) -> tuple[Any, Any]:
    """Both roots of z² − s z + p = 0, without cancellation."""
    root = _sqrt(discriminant)
    side = np.where((np.conj(_value(s)) * _value(root)).real > 0, 0.5, -0.5)
    larger = s * 0.5 + root * side
    return larger, p / larger


def exponents(rods: Rods, force: Real, omega: Real) -> Complex:
    """(n, 2): r1, r2 of e^{±ru} at λ = iω, with positive real parts."""
    c4, c2, c0 = kernels.exponent_polynomial(1j * omega, *rods, force)
    s, p = -c2 / c4, c0 / c4
    return np.asarray(np.sqrt(np.stack(_roots(s, p, s * s - 4 * p), axis=-1)))


def jet(rods: Rods, force: Real, lam: Complex) -> tuple[Complex, Complex, Complex]:
    """The scaled D and its derivatives: (D, D_F, D_λ)."""
    D, (D_F, D_lam) = np.empty_like(lam), np.empty((2, len(lam)), dtype=complex)
    by_force, by_lam = np.eye(2)[..., None]
    for i in range(0, len(lam), BLOCK // 4):
        part = slice(i, i + BLOCK // 4)
        at = Jet(force[part], by_force), Jet(lam[part], by_lam)
        value: Jet = characteristic(rods_at(rods, part), *at).scaled
        D[part], D_F[part], D_lam[part] = value.value, value.slopes[0], value.slopes[1]
    return D, D_F, D_lam


def gradient(rods: Rods, force: Real, lam: Complex) -> tuple[Complex, Complex]:
    """The scaled D, (n,), and its derivatives by k1, k2, gamma3, force, λ, (5, n)."""
    unit = np.eye(5)[..., None]
    k1, k2, gamma3, F, eigenvalue = (Jet(x, e) for x, e in zip((*rods, force, lam), unit, strict=True))
    D: Jet = characteristic((k1, k2, gamma3), F, eigenvalue).scaled
    return D.value, D.slopes


def rods_at(rods: Rods, which: Any) -> Rods:
    """Some of the rods."""
    k1, k2, gamma3 = rods
    return k1[which], k2[which], gamma3[which]
