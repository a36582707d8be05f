"""The closed characteristic function of many straight rods at once, with analytic derivatives.

One formula, `characteristic`, for arrays, Jets, and numbers that a compiler is told about: `along` and `jet`
run it on many points, compiled if the problem asks for it. Lengths in L, times in γ2 L⁴/k3, forces in k3/L².
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from rodwnl.batch_problem import Problem, Terms, compiled_formula, problem
from rodwnl.batch_rods import Rods
from rodwnl.jets import Jet, exp, sqrt, value
from rodwnl.straightrod import StraightRod

Real = NDArray[np.float64]
Complex = NDArray[np.complexfloating[Any, Any]]

# Array elements at a time: the allocator reuses temporary arrays of 32 kB, not larger ones; what is compiled
# needs none.
BLOCK, COMPILED_BLOCK = 2048, 32768
SMALL = 1e-9  # λ in place of 0; the slowest rates are about 1


def _at(terms: dict[int, Any], lam: Any) -> Any:
    """Σ c_k λ^k by Horner's rule."""
    highest = max(terms)
    total = terms[highest]
    for k in range(highest - 1, -1, -1):
        total = total * lam + terms[k] if k in terms else total * lam
    return total


@dataclass(frozen=True)
class Characteristic:
    """D e^{−r1−r2} and Im(r1 + r2); C, B and λ(z1 − z2)² of its formula."""

    scaled: Any
    turn: Any
    clamped: Any
    mixed: Any
    spurious: Any

    def __getitem__(self, points: Any) -> Characteristic:
        """At some of the points, by the first axis."""
        return Characteristic(*(getattr(self, name)[points] for name in self.__dataclass_fields__))

    @property
    def dominant(self) -> Any:
        """What dominates the scaled D for Re r1, Re r2 → ∞."""
        return (self.clamped - self.mixed) / self.spurious


def characteristic(given: Problem, lam: Any) -> Characteristic:
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
    c4, c2, c0 = (_at(c, lam) for c in given.exponents)
    s, p = -c2 / c4, c0 / c4
    discriminant = s * s - 4 * p
    z = z1, z2 = _roots(s, p, discriminant)
    r1, r2 = sqrt(z1), sqrt(z2)
    e1, e2 = exp(-r1), exp(-r2)
    (q1, q2), _ = _parts(given.clamp, z, lam)
    (S1, S2), (S1_even, S2_even) = _parts(given.shear, z, lam)
    (M1, M2), (M1_even, M2_even) = _parts(given.moment, z, lam)
    g1 = _minus(_times(S2, M1_even), _times(S1_even, M2))
    g2 = _minus(_times(S1, M2_even), _times(S2_even, M1))
    w1 = _minus(_times(S1, M1_even), _times(S1_even, M1))
    w2 = _minus(_times(S2, M2_even), _times(S2_even, M2))
    clamped = q1 * g1 + q2 * g2
    mixed = (q1 * g2 * z2 + q2 * g1 * z1) / (r1 * r2)
    square1, square2 = e1 * e1, e2 * e2
    both, neither = square1 * square2 + 1, square1 + square2
    scaled = (both + neither) * clamped - (both - neither) * mixed - 4 * (e1 * e2 * (q1 * w2 + q2 * w1))
    odd = _minus(_times(S1, M2), _times(S2, M1))
    even = _minus(_times(S1_even, M2_even), _times(S2_even, M1_even))
    if odd is not ABSENT or even is not ABSENT:
        odd, even = (r1 * 0 if part is ABSENT else part for part in (odd, even))  # a spring alone: no `even`
        same = q1 * (odd / r1 + even * r2) - q2 * (odd / r2 + even * r1)
        crossed = q1 * (even * r2 - odd / r1) + q2 * (even * r1 - odd / r2)
        scaled = scaled - same * (1 - square1 * square2) - crossed * (square1 - square2)
        clamped = clamped - same  # it dominates too
    spurious = discriminant * lam
    return Characteristic(scaled / spurious, (value(r1) + value(r2)).imag, clamped, mixed, spurious)


ABSENT = None  # what an emitted boundary condition does not contain


def _parts(condition: Terms, z: tuple[Any, Any], lam: Any) -> tuple[list[Any], list[Any]]:
    """What is odd in r, times r, and what is even; each at z1 and z2."""
    terms = {k: _at(c, lam) for k, c in condition.items()}
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
    side = ((np.conj(value(s)) * value(root)).real > 0) - 0.5
    larger = s * 0.5 + root * side
    return larger, p / larger


def sign_at_rest(given: Problem) -> Real:
    """The sign of D(F, 0), which is real; at a small λ, as it is 0/0 there."""
    at_rest = np.full((1, given.exponents[1][0].size), SMALL + 0j)
    scaled, turn, _ = along(given, at_rest)
    return np.asarray(np.sign((scaled[0] * np.exp(1j * turn)).real))


def exponents(straight: StraightRod, omega: Real) -> Complex:
    """(n, 2): r1, r2 of e^{±ru} at λ = iω, with positive real parts."""
    c4, c2, c0 = straight("exponent_polynomial", lam=1j * omega)
    s, p = -c2 / c4, c0 / c4
    return np.asarray(np.sqrt(np.stack(_roots(s, p, s * s - 4 * p), axis=-1)))


def problem_with_slopes(rods: Rods, force: Real) -> Problem:
    """The problem of n rods at these forces as Jets in (F, λ)."""
    by_force = np.repeat(np.eye(2)[0][:, None], len(force), axis=1)
    return problem(rods.at(Jet(force, by_force)), rods.compiled)


def along(given: Problem, lam: Complex) -> tuple[Complex, Real, Complex]:
    """On lines of points λ (points, n): the scaled D, Im(r1 + r2) at the first point and D's dominant term at
    the last one.
    """
    if evaluate := compiled_formula(given, _along):
        scaled, turn, dominant = evaluate(lam)
        return scaled, turn[0].real, dominant[-1]
    D = characteristic(given, lam)
    return D.scaled, D[0].turn, D[-1].dominant


def _along(given: Problem, lam: Any) -> tuple[Any, ...]:
    D = characteristic(given, lam)
    return D.scaled, D.turn, D.dominant


def jet(given: Problem, lam: Complex) -> tuple[Complex, Complex, Complex]:
    """The scaled D and its derivatives, (D, D_F, D_λ), (n,) each, of a problem with slopes."""
    if evaluate := compiled_formula(given, _jet):
        D, D_F, D_lam = evaluate(lam[None])[:, 0]
        return D, D_F, D_lam
    D, D_F, D_lam = np.empty((3, len(lam)), dtype=complex)
    for i in range(0, len(lam), BLOCK // 4):
        part = slice(i, i + BLOCK // 4)
        D[part], D_F[part], D_lam[part] = _jet(given[part], lam[part])
    return D, D_F, D_lam


def _jet(given: Problem, lam: Any) -> tuple[Any, ...]:
    found: Jet = characteristic(given, Jet(lam, np.eye(2)[1][:, None])).scaled
    return found.value, *found.slopes


def gradient(rods: Rods, names: Sequence[str], force: Real, lam: Complex) -> tuple[Complex, Complex]:
    """The scaled D, (n,), and its derivatives by these parameters, force, λ, (len(names) + 2, n)."""
    *units, by_force, by_lam = np.eye(len(names) + 2)[..., None]
    varied = {name: Jet(rods.values[name], unit) for name, unit in zip(names, units, strict=True)}
    straight = Rods(rods.model, {**rods.values, **varied}).at(Jet(force, by_force))
    found: Jet = characteristic(problem(straight), Jet(lam, by_lam)).scaled
    return found.value, found.slopes
