"""The closed characteristic function of many straight rods at once, with analytic derivatives.

Everything specific to a model comes from its emitted functions: the polynomial of the exponents, and what one
exponential contributes to the boundary conditions. Lengths in L, times in γ2 L⁴/k3, forces in k3/L².
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from rodwnl.batch_rods import Rods
from rodwnl.jets import Jet, Powers, exp, sqrt, value
from rodwnl.jets import coefficients as by_power
from rodwnl.straightrod import StraightRod

Real = NDArray[np.float64]
Complex = NDArray[np.complexfloating[Any, Any]]

BLOCK = 2048  # array elements: the allocator reuses temporary arrays of 32 kB, not larger ones
SMALL = 1e-9  # λ in place of 0; the slowest rates are about 1


@dataclass(frozen=True)
class Characteristic:
    """D e^{−r1−r2}; what dominates it for Re r1, Re r2 → ∞, before the division by spurious; Im(r1 + r2)."""

    scaled: Any
    leading: Any
    spurious: Any
    turn: Any

    @property
    def dominant(self) -> Any:
        """At the last point of every line."""
        return self.leading[..., -1] / self.spurious[..., -1]


def characteristic(straight: StraightRod, lam: Any) -> Characteristic:
    """D(F, λ), zero exactly at the eigenvalues, real on the real axis. Arrays or Jets.

    An exponential e^{ru} has Θ/Y = q/r and contributes the stresses minus load s = S/r + S' and m = M/r + M'
    at the tip, where q, S, S', M, M' are even in r: functions of z = r², which obeys z² − s z + p = 0. The
    determinant of the four boundary conditions, by Laplace's rule on those at the clamp, is up to a factor
    that never vanishes on the imaginary axis, with E_i = e^{−r_i}

        λ(z1 − z2)² D e^{−r1−r2} = (1 + E1²)(1 + E2²) C − (1 − E1²)(1 − E2²) B − 4 E1E2 (q1 w2 + q2 w1) − A,
        C = q1 g1 + q2 g2,    B = (q1 g2 z2 + q2 g1 z1)/(r1 r2),
        g1 = S2 M1' − S1' M2,    g2 = S1 M2' − S2' M1,    w = S M' − S' M.

    and A, absent unless the tip conditions mix even and odd derivatives, as drag or a spring at the tip does,

        A = (1 − E1²E2²) (q1 (a/r1 + b r2) − q2 (a/r2 + b r1))
            + (E1² − E2²) (q1 (b r2 − a/r1) + q2 (b r1 − a/r2)),
        a = S1 M2 − S2 M1,    b = S1' M2' − S2' M1'.

    The roots z1 ≠ z2 are distinct on the imaginary axis (paper: eq:linearization).
    """
    c4, c2, c0 = straight("exponent_polynomial", lam=lam)
    s, p = -c2 / c4, c0 / c4
    discriminant = s * s - 4 * p
    z = z1, z2 = _roots(s, p, discriminant)
    r1, r2 = sqrt(z1), sqrt(z2)
    e1, e2 = exp(-r1), exp(-r2)
    _, clamp, shear, moment = straight("boundary_column", r=Powers({1: 1}), exp_r=1, lam=lam)
    (q1, q2), _ = _parts(clamp, z)
    (S1, S2), (S1_even, S2_even) = _parts(shear, z)
    (M1, M2), (M1_even, M2_even) = _parts(moment, z)
    g1 = _minus(_times(S2, M1_even), _times(S1_even, M2))
    g2 = _minus(_times(S1, M2_even), _times(S2_even, M1))
    w1 = _minus(_times(S1, M1_even), _times(S1_even, M1))
    w2 = _minus(_times(S2, M2_even), _times(S2_even, M2))
    clamped = q1 * g1 + q2 * g2
    mixed = (q1 * g2 * z2 + q2 * g1 * z1) / (r1 * r2)
    square1, square2 = e1 * e1, e2 * e2
    both, neither = square1 * square2 + 1, square1 + square2
    scaled = (both + neither) * clamped - (both - neither) * mixed - 4 * (e1 * e2 * (q1 * w2 + q2 * w1))
    leading = clamped - mixed
    odd = _minus(_times(S1, M2), _times(S2, M1))
    even = _minus(_times(S1_even, M2_even), _times(S2_even, M1_even))
    if odd is not ABSENT or even is not ABSENT:
        same = q1 * (odd / r1 + even * r2) - q2 * (odd / r2 + even * r1)
        crossed = q1 * (even * r2 - odd / r1) + q2 * (even * r1 - odd / r2)
        scaled = scaled - same * (1 - square1 * square2) - crossed * (square1 - square2)
        leading = leading - same
    spurious = discriminant * lam
    return Characteristic(scaled / spurious, leading, spurious, (value(r1) + value(r2)).imag)


ABSENT = None  # what an emitted boundary condition does not contain


def _parts(condition: Any, z: tuple[Any, Any]) -> tuple[list[Any], list[Any]]:
    """What is odd in r, times r, and what is even, of Laurent polynomials in r; each at z1 and z2."""
    terms = by_power(condition)
    odd = {(k + 1) // 2: c for k, c in terms.items() if k % 2}
    even = {k // 2: c for k, c in terms.items() if k % 2 == 0}
    return [_polynomial(odd, x) for x in z], [_polynomial(even, x) for x in z]


def _polynomial(terms: dict[int, Any], z: Any) -> Any:
    """Σ c_k z^k by Horner's rule."""
    total: Any = ABSENT
    for k in range(max(terms, default=-1), -1, -1):
        total = total if total is ABSENT else total * z
        total = total if k not in terms else terms[k] if total is ABSENT else total + terms[k]
    return total


def _times(a: Any, b: Any) -> Any:
    return ABSENT if a is ABSENT or b is ABSENT else a * b


def _minus(a: Any, b: Any) -> Any:
    return a if b is ABSENT else -b if a is ABSENT else a - b


def _roots(s: Any, p: Any, discriminant: Any) -> tuple[Any, Any]:
    """Both roots of z² − s z + p = 0, without cancellation."""
    root = sqrt(discriminant)
    side = np.where((np.conj(value(s)) * value(root)).real > 0, 0.5, -0.5)
    larger = s * 0.5 + root * side
    return larger, p / larger


def sign_at_rest(straight: StraightRod) -> Real:
    """The sign of D(F, 0), which is real, for forces of any shape; at a small λ, as it is 0/0 there."""
    D = characteristic(straight, np.full(np.shape(straight.force), SMALL + 0j))
    return np.asarray(np.sign((D.scaled * np.exp(1j * D.turn)).real))


def exponents(straight: StraightRod, omega: Real) -> Complex:
    """(n, 2): r1, r2 of e^{±ru} at λ = iω, with positive real parts."""
    c4, c2, c0 = straight("exponent_polynomial", lam=1j * omega)
    s, p = -c2 / c4, c0 / c4
    return np.asarray(np.sqrt(np.stack(_roots(s, p, s * s - 4 * p), axis=-1)))


def jet(rods: Rods, force: Real, lam: Complex) -> tuple[Complex, Complex, Complex]:
    """The scaled D and its derivatives: (D, D_F, D_λ)."""
    D, (D_F, D_lam) = np.empty_like(lam), np.empty((2, len(lam)), dtype=complex)
    by_force, by_lam = np.eye(2)[..., None]
    for i in range(0, len(lam), BLOCK // 4):
        part = slice(i, i + BLOCK // 4)
        straight = rods[part].at(Jet(force[part], by_force))
        found: Jet = characteristic(straight, Jet(lam[part], by_lam)).scaled
        D[part], D_F[part], D_lam[part] = found.value, found.slopes[0], found.slopes[1]
    return D, D_F, D_lam


def gradient(rods: Rods, names: Sequence[str], force: Real, lam: Complex) -> tuple[Complex, Complex]:
    """The scaled D, (n,), and its derivatives by these parameters, force, λ, (len(names) + 2, n)."""
    *units, by_force, by_lam = np.eye(len(names) + 2)[..., None]
    varied = {name: Jet(rods.values[name], unit) for name, unit in zip(names, units, strict=True)}
    straight = Rods(rods.model, {**rods.values, **varied}).at(Jet(force, by_force))
    found: Jet = characteristic(straight, Jet(lam, by_lam)).scaled
    return found.value, found.slopes
