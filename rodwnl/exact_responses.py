"""The amplitude equation beyond the cubic term in closed form: responses as sums of exponentials.

The problems are those of rodwnl/responses.py; here every response is a sum of P(u) e^{au}. For a forcing
P e^{au} the problem (λΓ − M(d/du)) V = P e^{au} has V = Q e^{au} with

    N Q − M'(a) Q' − ½ M''(a) Q'' = P,    N = λΓ − M(a),    M(r) = ((K2 r², −μ r), (μ r, K3 r² − μν)),

with M as the emitted rows have it, solved from the highest power down. At a resonance, det N = 0, Q has one
degree more than P. What remains, the clamp and the tip, is met by the four exponentials of the homogeneous
problem.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import mpmath as mp

from rodwnl.closedform import (
    CriticalState,
    adjoint_mode,
    critical_mode,
    critical_state,
    squared_exponents,
)
from rodwnl.closedresponses import ClosedResponses, cramer
from rodwnl.errors import ComputationError
from rodwnl.exact import GUARD, MpNumbers, checked_digits, digits_agreed, refine_threshold, same_texts
from rodwnl.fields import Exponents, Field, Key, Scalar
from rodwnl.parameters import RodParameters
from rodwnl.responses import HIGHEST, Pool, derived_from, terms
from rodwnl.uniformrod import require_uniform

Pair = tuple[Scalar, Scalar]
ATTEMPTS = 4  # how often the working precision is raised before giving up


@dataclass(frozen=True)
class ExactAmplitudeEquation:
    """What `responses.AmplitudeEquation` holds, each number (or part of one) to `digits` digits."""

    force: Scalar
    omega: Scalar
    coefficients: dict[str, Scalar]
    third_harmonic: Scalar
    A_tip2_slope: Scalar
    A_tip2_curvature: Scalar
    omega_slope: Scalar
    omega_curvature: Scalar
    digits: int


def exact_amplitude_equation(
    rod: RodParameters, force: Scalar, omega: Scalar, digits: int = 20
) -> ExactAmplitudeEquation:
    """The coefficients through order 5 at the threshold near (force, omega), to `digits` correct digits.

    Correct: two working precisions agree on all of them and round alike. Raises InputError for digits outside
    1…10000 and ComputationError when there is no threshold near the approximation or the digits cannot be
    reached.
    """
    digits = checked_digits(digits)
    require_uniform(rod, "the exact route")
    working = digits + 2 * GUARD
    coarse = _evaluate(rod, force, omega, digits, working)
    for _ in range(ATTEMPTS):
        working += GUARD
        fine = _evaluate(rod, coarse.force, coarse.omega, digits, working)
        with mp.workdps(working):
            numbers = _numbers(coarse), _numbers(fine)
            if digits_agreed(*numbers) >= digits + 2 and same_texts(*numbers, digits):
                return fine
        coarse, working = fine, working + digits
    raise ComputationError(f"{digits} digits were not reached at order {HIGHEST}")


def _numbers(e: ExactAmplitudeEquation) -> list[Scalar]:
    """Every real number in it."""
    both = [*e.coefficients.values(), e.third_harmonic]
    slopes = [e.A_tip2_slope, e.A_tip2_curvature, e.omega_slope, e.omega_curvature]
    return [e.force, e.omega, *slopes, *(part for c in both for part in (c.real, c.imag))]


def _evaluate(
    rod: RodParameters, force: Scalar, omega: Scalar, digits: int, working: int
) -> ExactAmplitudeEquation:
    with mp.workdps(working):
        force, omega = refine_threshold(rod, mp.mpf(force), mp.mpf(omega))
        solver = _ExactResponses(rod, force, omega)
        c = solver.solve()
        eta = solver.at_tip["Y300"]
        predicted = derived_from(c, eta)
        return ExactAmplitudeEquation(
            force, omega, c, eta,
            predicted("tip_amplitude_squared_slope"), predicted("tip_amplitude_squared_curvature"),
            predicted("frequency_slope"), predicted("frequency_curvature"), digits,
        )  # fmt: skip


class _ExactResponses(ClosedResponses):
    """Solves response after response; what is known is kept by name, as fields and as values at the tip."""

    def __init__(self, rod: RodParameters, force: Scalar, omega: Scalar) -> None:
        numbers = MpNumbers()
        straight = critical_state(rod, force, omega, numbers).straight
        lam = mp.mpc(0, omega)
        # Exponents of the homogeneous problems: (Y, Theta) at λ and 3λ, X at 2λ and 4λ.
        axial = (h * lam * straight("drag_weights")[0] / straight("stretch_stiffness") for h in (2, 4))
        squares = [*squared_exponents(straight, lam, numbers), *axial]
        squares += squared_exponents(straight, 3 * lam, numbers)
        super().__init__(straight, lam, Exponents([mp.sqrt(z) for z in squares], numbers))
        self.transverse_keys = {1: (0, 1), 3: (4, 5)}
        self.longitudinal_keys = {0: self.exponents.zero, 2: self.exponents.key(2), 4: self.exponents.key(3)}
        state = CriticalState(numbers, straight, omega, self.exponents)
        mode, self.adjoint = critical_mode(state), adjoint_mode(state)
        self.keep("Y", mode.Y)
        self.keep("Theta", mode.Theta)
        self.norm = self._norm(mode.named())

    def _norm(self, mode: Pool) -> Scalar:
        """∫ Ψ†Γ(Y, Θ) du, and what a load with drag adds at the tip."""
        given = mode | self.adjoint.named()
        return self.straight("norm_integrand", **given).integral() + self.straight("norm_boundary", **given)

    def solve(self) -> dict[str, Scalar]:
        """All responses through the highest order; the coefficients by name."""
        coefficients = {}
        for index in terms(HIGHEST):
            p, q, _ = index
            digits = "".join(map(str, index))
            if (p + q) % 2 == 0:
                self.longitudinal(f"X{digits}", (p - q) * self.lam, self.longitudinal_keys[p - q])
                continue
            names = (f"Y{digits}", f"Theta{digits}")
            forcing = tuple(self.call(f"{names[0]}_forcing", self.fields))
            traction = tuple(self.call(f"{names[0]}_traction", self.at_tip))
            if p == q + 1:
                c = self._solvability(forcing, traction)
                coefficients[f"c{digits}"] = self.known[f"c{digits}"] = c
                mode = (self.fields["Y"], self.fields["Theta"])
                forcing = tuple(f - c * w * m for f, w, m in zip(forcing, self.drag[1:], mode, strict=True))
                traction = tuple(t - c * s for t, s in zip(traction, self.tip_drag(), strict=True))
            if sum(index) + index[2] < HIGHEST:
                for name, field in zip(names, self._transverse(p - q, forcing, traction), strict=True):
                    self.keep(name, field)
        return coefficients

    def _solvability(self, forcing: tuple[Any, ...], traction: tuple[Any, ...]) -> Scalar:
        """c = (∫ Ψ†f du + Ψ†t(1)) / ∫ Ψ†Γ(Y, Θ) du."""
        psi = (self.adjoint.Psi_Y, self.adjoint.Psi_Theta)
        bulk = sum(
            (p.conjugate() * self.exponents.promoted(f)).integral() for p, f in zip(psi, forcing, strict=True)
        )
        tip = sum(p.at_tip().conjugate() * t for p, t in zip(psi, traction, strict=True))
        return (bulk + tip) / self.norm

    def _transverse(self, harmonic: int, forcing: tuple[Any, ...], traction: tuple[Any, ...]) -> list[Field]:
        """(λΓ − M) V = f, V(0) = 0, S V = t; where it is resonant with Y(1) = 0 for one of the conditions."""
        lam = harmonic * self.lam
        Y, Theta = self._particular(
            lam, harmonic, self.exponents.promoted(forcing[0]), self.exponents.promoted(forcing[1])
        )
        keys = [self.exponents.key(g, sign) for g in self.transverse_keys[harmonic] for sign in (1, -1)]
        columns = [self._boundary_column(key, lam) for key in keys]
        tip = [f.at_tip() for f in (Y, Y.derivative(), Theta, Theta.derivative())]
        right = [-Y.at_start(), -Theta.at_start()]
        for row, t in zip(self.tip_rows(lam), traction, strict=True):
            right.append(t - sum(c * value for c, value in zip(row, tip, strict=True)))
        if harmonic == 1:
            # The four conditions are dependent; the last one is replaced by the gauge Y(1) = 0.
            for column, key in zip(columns, keys, strict=True):
                column[3] = mp.exp(self.exponents.value(key))
            right[3] = -tip[0]
        amplitudes = cramer([list(row) for row in zip(*columns, strict=True)], right)
        for key, b in zip(keys, amplitudes, strict=True):
            ratio, _ = self.straight("mode_amplitudes", r=self.exponents.value(key), lam=lam)
            Y = Y + self.exponents.field({key: (b,)})
            Theta = Theta + self.exponents.field({key: (b * ratio,)})
        return [Y, Theta]

    def _boundary_column(self, key: Key, lam: Scalar) -> list[Scalar]:
        """Y(0), Θ(0) and the two tip stresses minus load of one exponential."""
        r = self.exponents.value(key)
        column = self.straight("boundary_column", r=r, exp_r=mp.exp(r), lam=lam)
        clamp_Y, clamp_Theta, shear, moment = column
        return [clamp_Y, clamp_Theta, self.y_row[2] * shear, self.theta_row[5] * moment]

    def _particular(self, lam: Scalar, harmonic: int, f: Field, g: Field) -> tuple[Field, Field]:
        """Some (Y, Θ) with (λΓ − M)(Y, Θ) = (f, g)."""
        named = {self.exponents.key(j, sign) for j in self.transverse_keys[harmonic] for sign in (1, -1)}
        Y, Theta = {}, {}
        for key in {*f.terms, *g.terms}:
            p, q = f.terms.get(key, ()), g.terms.get(key, ())
            a = self.exponents.value(key)
            length = max(len(p), len(q))
            rows = [
                (p[k] if k < len(p) else mp.mpf(0), q[k] if k < len(q) else mp.mpf(0)) for k in range(length)
            ]
            found = self._resonant(lam, a, rows) if key in named else self._regular(lam, a, rows)
            Y[key], Theta[key] = (tuple(column) for column in zip(*found, strict=True))
        return self.exponents.field(Y), self.exponents.field(Theta)

    def _symbol(self, lam: Scalar, a: Scalar) -> tuple[Pair, Pair]:
        """N = λΓ − M(a)."""
        (yy, yt), (ty, tt) = (
            [row[k] + row[k + 1] * a + row[k + 2] * a * a for k in (0, 3)]
            for row in (self.y_row, self.theta_row)
        )
        return (lam * self.drag[1] - yy, -yt), (-ty, lam * self.drag[2] - tt)

    def _rest(self, a: Scalar, k: int, Q: dict[int, Pair]) -> Pair:
        """M'(a) (k+1) Q_{k+1} + ½ M''(a) (k+2)(k+1) Q_{k+2}: what Q' and Q'' put beside P at u^k."""
        none = (mp.mpf(0), mp.mpf(0))
        first = [(k + 1) * v for v in Q.get(k + 1, none)]
        second = [(k + 2) * (k + 1) * v for v in Q.get(k + 2, none)]
        y, theta = (
            sum(
                (row[n + 1] + 2 * row[n + 2] * a) * v1 + row[n + 2] * v2
                for n, v1, v2 in zip((0, 3), first, second, strict=True)
            )
            for row in (self.y_row, self.theta_row)
        )
        return y, theta

    def _regular(self, lam: Scalar, a: Scalar, rows: list[Pair]) -> list[Pair]:
        """Q_k = N⁻¹ (P_k + rest), from the highest power down."""
        (yy, yt), (ty, tt) = self._symbol(lam, a)
        det = yy * tt - yt * ty
        Q: dict[int, Pair] = {}
        for k in reversed(range(len(rows))):
            y, t = (p + r for p, r in zip(rows[k], self._rest(a, k, Q), strict=True))
            Q[k] = ((tt * y - yt * t) / det, (yy * t - ty * y) / det)
        return [Q[k] for k in range(len(rows))]

    def _resonant(self, lam: Scalar, a: Scalar, rows: list[Pair]) -> list[Pair]:
        """N v = 0, w N = 0: Q_k = (0, ·) + c_k v, where c_k makes the equation at u^{k−1} solvable."""
        (yy, yt), (ty, _) = self._symbol(lam, a)
        v, w = (mp.mpf(1), -yy / yt), (mp.mpf(1), -yy / ty)
        slope = self._rest(a, 0, {1: v})
        by_slope = w[0] * slope[0] + w[1] * slope[1]
        Q: dict[int, Pair] = {}
        for k in reversed(range(len(rows) + 1)):
            y, t = mp.mpf(0), mp.mpf(0)
            if k < len(rows):
                right, _ = (p + r for p, r in zip(rows[k], self._rest(a, k, Q), strict=True))
                t = right / yt  # the first row of N Q_k = right, with no Y; the second follows from w
            if k:
                Q[k] = (y, t)
                lower = [p + r for p, r in zip(rows[k - 1], self._rest(a, k - 1, Q), strict=True)]
                c = -(w[0] * lower[0] + w[1] * lower[1]) / (k * by_slope)
                y, t = c * v[0], t + c * v[1]
            Q[k] = (y, t)
        return [Q[k] for k in range(len(rows) + 1)]
