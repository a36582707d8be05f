"""The amplitude equation beyond the cubic term in closed form: responses as sums of exponentials.

The problems are those of rodwnl/responses.py; here every response is a sum of P(u) e^{au}. For a forcing
P e^{au} the problem (λΓ − M(d/du)) V = P e^{au} has V = Q e^{au} with

    N Q − M'(a) Q' − ½ M''(a) Q'' = P,    N = λΓ − M(a),    M(r) = ((k2 r², −μ r), (μ r, r² − μν)),

solved from the highest power down. At a resonance, det N = 0, Q has one degree more than P. What remains,
the clamp and the tip, is met by the four exponentials of the homogeneous problem.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import dataclass
from typing import Any

import mpmath as mp

from rodwnl import kernels
from rodwnl.closedform import CriticalState, adjoint_mode, critical_mode, determinant
from rodwnl.errors import ComputationError
from rodwnl.exact import GUARD, MpNumbers, checked_digits, refine_threshold
from rodwnl.fields import Exponents, Field, Key, Scalar, two_point
from rodwnl.parameters import RodParameters
from rodwnl.responses import HIGHEST, Index, Pool, derived_from, terms
from rodwnl.straightrod import arguments

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

    Correct: two working precisions agree on them. Raises InputError for digits outside 1…10000 and
    ComputationError when there is no threshold near the approximation or the digits cannot be reached.
    """
    digits = checked_digits(digits)
    working = digits + 2 * GUARD
    coarse = _evaluate(rod, force, omega, digits, working)
    for _ in range(ATTEMPTS):
        working += GUARD
        fine = _evaluate(rod, coarse.force, coarse.omega, digits, working)
        with mp.workdps(working):
            if _agreement(coarse, fine) >= digits + 2:
                return fine
        coarse, working = fine, working + digits
    raise ComputationError(f"{digits} digits were not reached at order {HIGHEST}")


def _agreement(a: ExactAmplitudeEquation, b: ExactAmplitudeEquation) -> float:
    """Digits to which two evaluations agree in the worst number."""
    pairs = [(a.A_tip2_curvature, b.A_tip2_curvature), (a.omega_curvature, b.omega_curvature)]
    for name, c in a.coefficients.items():
        pairs += [(c.real, b.coefficients[name].real), (c.imag, b.coefficients[name].imag)]
    differing = [abs(x - y) / max(abs(x), abs(y)) for x, y in pairs if x != y]
    return float(-mp.log10(max(differing))) if differing else float("inf")


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


class _ExactResponses:
    """Solves response after response; what is known is kept by name, as fields and as values at the tip."""

    def __init__(self, rod: RodParameters, force: Scalar, omega: Scalar) -> None:
        numbers = MpNumbers()
        k1, k2, gamma3, gamma1 = (numbers.number(p) for p in (rod.k1, rod.k2, rod.gamma3, rod.gamma1))
        lam = mp.mpc(0, omega)
        self.nu, self.mu = kernels.base_state(k1, k2, force)
        self.k1, self.k2, self.gamma3, self.gamma1, self.lam = k1, k2, gamma3, gamma1, lam
        # Exponents of the homogeneous problems: (Y, Theta) at λ and 3λ, X at 2λ and 4λ.
        squares = [*self._squares(lam, force), *(h * lam * gamma1 / k1 for h in (2, 4))]
        squares += self._squares(3 * lam, force)
        self.exponents = Exponents([mp.sqrt(z) for z in squares], numbers)
        self.transverse_keys = {1: (0, 1), 3: (4, 5)}
        self.longitudinal_keys = {0: self.exponents.zero, 2: self.exponents.key(2), 4: self.exponents.key(3)}
        state = CriticalState(numbers, k1, k2, gamma3, gamma1, force, omega, self.exponents)
        mode, self.adjoint = critical_mode(state), adjoint_mode(state)
        self.parameters: Pool = {
            "k1": k1, "k2": k2, "gamma3": gamma3, "gamma1": gamma1, "force": force, "lam": lam,
        }  # fmt: skip
        self.fields: Pool = {"u": self.exponents.u(mp.mpf(1))}
        self.at_tip: Pool = {"u": mp.mpf(1)}
        self.force = force
        self._keep("Y", mode.Y)
        self._keep("Theta", mode.Theta)

    def _squares(self, lam: Scalar, force: Scalar) -> list[Scalar]:
        """r² of the homogeneous problem at this λ; the second root from the product of both."""
        c4, c2, c0 = kernels.exponent_polynomial(lam, self.k1, self.k2, self.gamma3, force)
        half, root = -c2 / (2 * c4), mp.sqrt(c2 * c2 - 4 * c4 * c0) / (2 * c4)
        larger = half + root if abs(half + root) > abs(half - root) else half - root
        return [larger, c0 / (c4 * larger)]

    def solve(self) -> dict[str, Scalar]:
        """All responses through the highest order; the coefficients by name."""
        coefficients = {}
        for index in terms(HIGHEST):
            p, q, _ = index
            digits = "".join(map(str, index))
            if (p + q) % 2 == 0:
                self._longitudinal(index, f"X{digits}")
                continue
            names = (f"Y{digits}", f"Theta{digits}")
            forcing = tuple(self._call(f"{names[0]}_forcing", self.fields))
            traction = tuple(self._call(f"{names[0]}_traction", self.at_tip))
            if p == q + 1:
                c = self._solvability(forcing, traction)
                coefficients[f"c{digits}"] = self.parameters[f"c{digits}"] = c
                weights = (mp.mpf(1), self.gamma3)
                mode = (self.fields["Y"], self.fields["Theta"])
                forcing = tuple(f - c * w * m for f, w, m in zip(forcing, weights, mode, strict=True))
            if sum(index) + index[2] < HIGHEST:
                for name, field in zip(names, self._transverse(p - q, forcing, traction), strict=True):
                    self._keep(name, field)
        return coefficients

    def _call(self, name: str, pool: Pool) -> Any:
        f: Callable[..., Any] = getattr(kernels, name)
        known = {**self.parameters, **pool}
        return f(*(known[a] for a in arguments(f)))

    def _keep(self, name: str, field: Field) -> None:
        slope = field.derivative()
        self.fields |= {name: field, f"{name}_u": slope, f"{name}_uu": slope.derivative()}
        self.at_tip |= {name: field.at_tip(), f"{name}_u": slope.at_tip()}

    def _longitudinal(self, index: Index, name: str) -> None:
        """hλγ1 X − k1 X'' = f, X(0) = 0, k1 X'(1) = t."""
        forcing = self._call(f"{name}_forcing", self.fields)
        traction = self._call(f"{name}_traction", self.at_tip)
        field = self._field(forcing) / (-self.k1)
        root = self.longitudinal_keys[index[0] - index[1]]
        self._keep(name, two_point(field, root, traction / self.k1))

    def _field(self, value: Field | Scalar) -> Field:
        return (
            value
            if isinstance(value, Field)
            else self.exponents.field({self.exponents.zero: (mp.mpc(value),)})
        )

    def _solvability(self, forcing: tuple[Any, ...], traction: tuple[Any, ...]) -> Scalar:
        """c = (∫ Ψ†f du + Ψ†t(1)) / ∫ Ψ†Γ(Y, Θ) du."""
        psi = (self.adjoint.Psi_Y, self.adjoint.Psi_Theta)
        bulk = sum((p.conjugate() * self._field(f)).integral() for p, f in zip(psi, forcing, strict=True))
        tip = sum(p.at_tip().conjugate() * t for p, t in zip(psi, traction, strict=True))
        norm = kernels.norm_integrand(*psi, self.fields["Y"], self.fields["Theta"], self.gamma3).integral()
        return (bulk + tip) / norm

    def _transverse(self, harmonic: int, forcing: tuple[Any, ...], traction: tuple[Any, ...]) -> list[Field]:
        """(λΓ − M) V = f, V(0) = 0, S V = t; where it is resonant with Y(1) = 0 for one of the conditions."""
        lam = harmonic * self.lam
        Y, Theta = self._particular(lam, harmonic, self._field(forcing[0]), self._field(forcing[1]))
        keys = [self.exponents.key(g, sign) for g in self.transverse_keys[harmonic] for sign in (1, -1)]
        columns = [self._boundary_column(key, lam) for key in keys]
        Y_u, Theta_u = Y.derivative(), Theta.derivative()
        tip_Y, tip_Theta = Y.at_tip(), Theta.at_tip()
        right = [
            -Y.at_start(),
            -Theta.at_start(),
            traction[0] - self.k2 * (Y_u.at_tip() - self.nu * tip_Theta),
            traction[1] - Theta_u.at_tip(),
        ]
        if harmonic == 1:
            # The four conditions are dependent; the last one is replaced by the gauge Y(1) = 0.
            for column, key in zip(columns, keys, strict=True):
                column[3] = mp.exp(self.exponents.value(key))
            right[3] = -tip_Y
        amplitudes = _cramer([list(row) for row in zip(*columns, strict=True)], right)
        for key, b in zip(keys, amplitudes, strict=True):
            ratio, _ = kernels.mode_amplitudes(self.exponents.value(key), lam, self.k1, self.k2, self.force)
            Y = Y + self.exponents.field({key: (b,)})
            Theta = Theta + self.exponents.field({key: (b * ratio,)})
        return [Y, Theta]

    def _boundary_column(self, key: Key, lam: Scalar) -> list[Scalar]:
        """Y(0), Θ(0), k2 H(1), Θ'(1) of one exponential."""
        r = self.exponents.value(key)
        clamp_Y, clamp_Theta, shear, moment = kernels.boundary_column(
            r, mp.exp(r), lam, self.k1, self.k2, self.force
        )
        return [clamp_Y, clamp_Theta, self.k2 * shear, moment]

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
        return (
            (lam - self.k2 * a * a, self.mu * a),
            (-self.mu * a, self.gamma3 * lam - a * a + self.mu * self.nu),
        )

    def _rest(self, a: Scalar, k: int, Q: dict[int, Pair]) -> Pair:
        """M'(a) (k+1) Q_{k+1} + ½ M''(a) (k+2)(k+1) Q_{k+2}: what Q' and Q'' put beside P at u^k."""
        y1, t1 = ((k + 1) * v for v in Q.get(k + 1, (mp.mpf(0), mp.mpf(0))))
        y2, t2 = ((k + 2) * (k + 1) * v for v in Q.get(k + 2, (mp.mpf(0), mp.mpf(0))))
        return 2 * self.k2 * a * y1 - self.mu * t1 + self.k2 * y2, self.mu * y1 + 2 * a * t1 + t2

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


def _cramer(rows: list[list[Scalar]], right: Iterable[Scalar]) -> list[Scalar]:
    """The solution of a small linear system whose entries may differ by any factor."""
    whole, right = determinant(rows), list(right)
    return [
        determinant([[*row[:j], b, *row[j + 1 :]] for row, b in zip(rows, right, strict=True)]) / whole
        for j in range(len(rows))
    ]
