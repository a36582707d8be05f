"""The rod's parameters: exact rational numbers, dimensionless, checked once.

With lengths in L, times in γ₂L⁴/k₃ and forces in k₃/L² a rod is four numbers (paper: tab:summary):
k1 = k₁L²/k₃, k2 = k₂L²/k₃, gamma1 = γ₁/γ₂, gamma3 = γ₃/(γ₂L²).
"""

import numbers
from dataclasses import dataclass
from decimal import Context, Decimal, Inexact
from fractions import Fraction

from rodwnl.errors import InputError

Number = str | int | float | Fraction | Decimal

# Far outside what float64 can evaluate, and small enough that reading a number stays cheap.
_LARGEST = Fraction(10) ** 300
_MOST_CHARACTERS = 1000
_EXACT = Context(prec=5 * _MOST_CHARACTERS, traps=[Inexact])


@dataclass(frozen=True)
class Scales:
    """The SI units of a rod's dimensionless results: length (m), time (s), force (N)."""

    length: Fraction
    time: Fraction
    force: Fraction


@dataclass(frozen=True, init=False, repr=False)
class RodParameters:
    """Dimensionless stretch and shear stiffness, rotational and axial drag of one rod.

    Every value may be an int, a float, a Fraction, a Decimal or a text ("1e4", "1/2"); a float stands for
    the decimal number it prints as, so 2e-4 is exactly 1/5000. Raises InputError for anything that is not a
    finite positive number.
    """

    k1: Fraction
    k2: Fraction
    gamma3: Fraction
    gamma1: Fraction
    scales: Scales | None

    def __init__(
        self, k1: Number, k2: Number, gamma3: Number, gamma1: Number = "1/2", *, scales: Scales | None = None
    ) -> None:
        for name, value in {"k1": k1, "k2": k2, "gamma3": gamma3, "gamma1": gamma1}.items():
            object.__setattr__(self, name, positive(name, value))
        object.__setattr__(self, "scales", scales)

    @classmethod
    def from_physical(
        cls, L: Number, k1: Number, k2: Number, k3: Number, gamma1: Number, gamma2: Number, gamma3: Number
    ) -> "RodParameters":
        """A rod in SI units: L (m), k1 and k2 (N), k3 (N m²), drags gamma1, gamma2 (N s/m²), gamma3 (N s).

        The scales are kept, so that results can be given in SI units.
        """
        given = {"L": L, "k1": k1, "k2": k2, "k3": k3, "gamma1": gamma1, "gamma2": gamma2, "gamma3": gamma3}
        p = {name: positive(name, value) for name, value in given.items()}
        length = p["L"]
        scales = Scales(length=length, time=p["gamma2"] * length**4 / p["k3"], force=p["k3"] / length**2)
        return cls(
            k1=p["k1"] / scales.force,
            k2=p["k2"] / scales.force,
            gamma3=p["gamma3"] / (p["gamma2"] * length**2),
            gamma1=p["gamma1"] / p["gamma2"],
            scales=scales,
        )

    def floats(self) -> tuple[float, float, float, float]:
        """(k1, k2, gamma3, gamma1), each rounded to the nearest double."""
        return float(self.k1), float(self.k2), float(self.gamma3), float(self.gamma1)

    def texts(self) -> dict[str, str]:
        """The four values by name, as exact decimal text where they have one, else as a fraction."""
        return {name: decimal_text(getattr(self, name)) for name in ("k1", "k2", "gamma3", "gamma1")}

    def checked_force(self, value: Number, name: str = "force") -> Fraction:
        """The exact follower force; the base state needs 0 <= F < k1, so that ν = 1 - F/k1 > 0."""
        force = exact(name, value)
        if not 0 <= force < self.k1:
            raise InputError(
                f"{name} is {shown(value)}, but the straight rod exists only for 0 <= force < k1 = "
                f"{decimal_text(self.k1)} (at k1 it is compressed to length 0)"
            )
        return force

    def __repr__(self) -> str:
        return f"RodParameters({', '.join(f'{name}={text}' for name, text in self.texts().items())})"


def exact(name: str, value: object) -> Fraction:
    """The rational number that `value` stands for; `name` is what the error message calls it."""
    if isinstance(value, bool) or not isinstance(value, str | numbers.Real | Decimal):
        raise InputError(f"{name} must be a number, not {shown(value)}")
    text = str(value).strip()
    number = None
    try:
        if not _enormous(text):
            number = Fraction(text)
    except (ValueError, ZeroDivisionError):
        raise InputError(
            f"{name} is {shown(value)}: not a finite number; write it like 200, 1e4, 0.5 or 1/2"
        ) from None
    if number is None or (number and not 1 / _LARGEST <= abs(number) <= _LARGEST):
        raise InputError(f"{name} is {shown(value)}: its size must lie between 1e-300 and 1e300")
    return number


def positive(name: str, value: object) -> Fraction:
    """Like `exact`, and greater than zero."""
    number = exact(name, value)
    if number <= 0:
        raise InputError(f"{name} is {shown(value)}, but it must be greater than zero")
    return number


def decimal_text(number: Fraction) -> str:
    """Exact text of a rational: 10000, 0.0002, 1E+300, or 1/3 where no decimal ends."""
    try:
        decimal = _EXACT.normalize(_EXACT.divide(Decimal(number.numerator), Decimal(number.denominator)))
    except Inexact:
        return str(number)
    return f"{decimal:f}" if -7 <= decimal.adjusted() <= 20 else str(decimal)


def shown(value: object) -> str:
    """A value as an error message quotes it: cut when long."""
    text = repr(value) if isinstance(value, str) else str(value)
    return text if len(text) <= 60 else text[:57] + "..."


def _enormous(text: str) -> bool:
    """Whether Fraction would build an enormous integer from this text, as it would from 1e999999999."""
    _, e, exponent = text.lower().partition("e")
    return len(text) > _MOST_CHARACTERS or (bool(e) and abs(int(exponent)) > _MOST_CHARACTERS)
