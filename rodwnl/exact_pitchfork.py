"""The amplitude equation of a steady crossing, da/dt = β δ a + α a³, to any number of digits.

The problems are those of rodwnl/responses.py at λ = 0, for a rod of uniform stretch. With f for the forcing
less cΓ(Y, Θ), the first row is integrated once, from 0 to u,

    K2 Y' = μΘ − ∫f_y + C,    K3 Θ'' + (μF/K2) Θ = (μ/K2)(∫f_y − C) − f_θ,

so with the clamp everything is known up to C, the coefficient B of sin pu in Θ, p² = μF/(K2K3), and c. Two
tip conditions and the gauge Y(1) = 0 (of the mode: Y(1) = 1) give these. No adjoint is needed.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

import mpmath as mp

from rodwnl.closedresponses import ClosedResponses, cramer
from rodwnl.errors import ComputationError
from rodwnl.exact import GUARD, MpNumbers, checked_digits, digits_agreed, same_texts
from rodwnl.fields import Exponents, Field, Scalar, particular
from rodwnl.parameters import RodParameters
from rodwnl.responses import is_resonant, terms
from rodwnl.steady import steady_force
from rodwnl.uniformrod import uniform_rod

ATTEMPTS = 4  # how often the working precision is raised before giving up

Transverse = tuple[Field, Field]


@dataclass(frozen=True)
class ExactPitchfork:
    """What `responses.Pitchfork` holds, each number to `digits` digits; a is the tip's displacement."""

    force: Scalar
    alpha: Scalar
    beta: Scalar
    y_tip2_slope: Scalar
    digits: int

    @property
    def crossing(self) -> Literal["destabilizing", "restabilizing"]:
        """By the sign of β = dλ/dF."""
        return "destabilizing" if self.beta > 0 else "restabilizing"

    @property
    def criticality(self) -> Literal["supercritical", "subcritical"]:
        """By the sign of α, of which `digits` digits are known: it is not 0."""
        return "supercritical" if self.alpha < 0 else "subcritical"


def exact_pitchfork(rod: RodParameters, force: Scalar, digits: int = 30) -> ExactPitchfork:
    """The steady crossing near a force and its α, β, to `digits` correct digits.

    Correct: two working precisions agree on all of them and round alike. Raises InputError for digits outside
    1…10000, ComputationError where there is no steady crossing, or the digits cannot be reached.
    """
    digits = checked_digits(digits)
    working = digits + GUARD
    coarse = _evaluate(rod, force, digits, working)
    for _ in range(ATTEMPTS):
        working += GUARD
        fine = _evaluate(rod, coarse.force, digits, working)
        with mp.workdps(working):
            numbers = _numbers(coarse), _numbers(fine)
            if digits_agreed(*numbers) >= digits + 2 and same_texts(*numbers, digits):
                return fine
        coarse, working = fine, working + digits
    raise ComputationError(
        f"{digits} digits were not reached at the steady crossing near force {mp.nstr(coarse.force, 8)}: is "
        f"alpha or beta 0 there?"
    )


def _evaluate(rod: RodParameters, force: Scalar, digits: int, working: int) -> ExactPitchfork:
    force = steady_force(rod, force, working)
    with mp.workdps(working):
        found = _Steady(rod, force).solve()
        alpha, beta = found["c300"].real, found["c101"].real
        return ExactPitchfork(force, alpha, beta, -beta / alpha, digits)


def _numbers(p: ExactPitchfork) -> list[Scalar]:
    return [p.force, p.alpha, p.beta, p.y_tip2_slope]


class _Steady(ClosedResponses):
    """The mode and the responses through order 3 at a steady crossing."""

    def __init__(self, rod: RodParameters, force: Scalar) -> None:
        numbers = MpNumbers()
        straight = uniform_rod(rod, force, numbers)
        self.K2, self.K3 = straight("y_row")[2], straight("theta_row")[5]
        self.mu = -straight("y_row")[4]  # μ multiplies −Θ' in the y row, and Y' in the θ row
        self.squared = straight("theta_row")[3] / self.K3 + self.mu**2 / (self.K2 * self.K3)
        exponents = Exponents([1j * mp.sqrt(self.squared)], numbers)
        super().__init__(straight, mp.mpf(0), exponents, prefix="steady_")
        self.free = [self._clamped((0, 0), C, B) for C, B in ((1, 0), (0, 1))]
        by_C, by_B = (self._tip(V)[0] for V in self.free)  # the θ condition holds too at the crossing
        Y, Theta = (by_B * of_C - by_C * of_B for of_C, of_B in zip(*self.free, strict=True))
        for name, field in (("Y", Y), ("Theta", Theta)):
            self.keep(name, field / Y.at_tip())

    def solve(self) -> dict[str, Scalar]:
        """The coefficients by name."""
        found = {}
        for index in terms(3, steady=True):
            digits = "".join(map(str, index))
            if is_resonant(index, steady=True):
                found[f"c{digits}"] = self._coefficient(f"Y{digits}")
            else:
                self.longitudinal(f"X{digits}", self.lam, self.exponents.zero)
        return found

    def _coefficient(self, name: str) -> Scalar:
        """c of the last responses, which themselves are of no use at this order."""
        mode = [w * self.fields[s] for w, s in zip(self.drag[1:], ("Y", "Theta"), strict=True)]
        known = self._clamped(self.call(f"{name}_forcing", self.fields))
        by_c = self._clamped((-mode[0], -mode[1]))
        columns = [[*self._tip(V), V[0].at_tip()] for V in (*self.free, by_c, known)]
        for row, drag in enumerate(self.tip_drag()):
            columns[2][row] += drag
        traction = [*self.call(f"{name}_traction", self.at_tip), 0]
        right = [t - k for t, k in zip(traction, columns.pop(), strict=True)]
        return cramer([list(row) for row in zip(*columns, strict=True)], right)[2]

    def _clamped(self, forcing: tuple[Field | Scalar, Field | Scalar], C: int = 0, B: int = 0) -> Transverse:
        """−M (Y, Θ) = forcing with Y(0) = Θ(0) = 0, for these two constants."""
        f, g = forcing
        total = self.exponents.promoted(f).antiderivative() - mp.mpc(C)
        rest = (self.mu / self.K2) * total - g
        Theta = particular(self.exponents.promoted(rest) / self.K3, self.exponents.key(0))
        plus, minus = (self.exponents.field({self.exponents.key(0, s): (mp.mpc(1),)}) for s in (1, -1))
        Theta = Theta - (plus + minus) * (Theta.at_start() / 2) + (plus - minus) * mp.mpc(0, -B) / 2
        return ((self.mu * Theta - total) / self.K2).antiderivative(), Theta

    def _tip(self, V: Transverse) -> list[Scalar]:
        """The two stresses minus load at the tip."""
        values = [x for field in V for x in (field.at_tip(), field.derivative().at_tip())]
        return [sum(c * x for c, x in zip(row, values, strict=True)) for row in self.tip_rows(self.lam)]
