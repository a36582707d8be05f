"""The rod's parameters: exact rational numbers, dimensionless, checked once.

With lengths in L, times in γ₂L⁴/k₃ and forces in k₃/L² a rod is four numbers (paper: tab:summary):
k1 = k₁L²/k₃, k2 = k₂L²/k₃, gamma1 = γ₁/γ₂, gamma3 = γ₃/(γ₂L²).
"""

import numbers
from collections.abc import Mapping
from dataclasses import dataclass
from decimal import Context, Decimal, Inexact
from fractions import Fraction

from rodwnl import kernels
from rodwnl.errors import InputError

PLAIN = kernels.DEFAULT

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

    model: the name of an emitted rod, or the folder that holds one; own: the values of the parameters that
    only this model has, by name in the model's order, given as further keyword arguments.

    Every value may be an int, a float, a Fraction, a Decimal or a text ("1e4", "1/2"); a float stands for
    the decimal number it prints as, so 2e-4 is exactly 1/5000. Raises InputError for anything that is not a
    finite number, for one of the four that is not positive, and for parameters that the model does not have.
    """

    k1: Fraction
    k2: Fraction
    gamma3: Fraction
    gamma1: Fraction
    scales: Scales | None
    model: str
    own: tuple[tuple[str, Fraction], ...]

    def __init__(
        self,
        k1: Number,
        k2: Number,
        gamma3: Number,
        gamma1: Number = "1/2",
        *,
        scales: Scales | None = None,
        model: str = PLAIN,
        **own: Number,
    ) -> None:
        for name, value in {"k1": k1, "k2": k2, "gamma3": gamma3, "gamma1": gamma1}.items():
            object.__setattr__(self, name, positive(name, value))
        require_kind("model", model, str, "the name of a rod, or the folder of an emitted one")
        if scales is not None:
            require_kind("scales", scales, Scales, "as `from_physical` makes them")
        object.__setattr__(self, "scales", scales)
        object.__setattr__(self, "model", model)
        object.__setattr__(self, "own", own_values(model, own))

    @classmethod
    def from_physical(
        cls,
        L: Number,
        k1: Number,
        k2: Number,
        k3: Number,
        gamma1: Number,
        gamma2: Number,
        gamma3: Number,
        *,
        model: str = PLAIN,
        **own: Number,
    ) -> "RodParameters":
        """A rod in SI units: L (m), k1 and k2 (N), k3 (N m²), drags gamma1, gamma2 (N s/m²), gamma3 (N s).

        A model's own parameters stay dimensionless. The scales are kept, so that results can be given in SI
        units.
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
            model=model,
            **own,
        )

    def floats(self) -> tuple[float, float, float, float]:
        """(k1, k2, gamma3, gamma1) of the plain rod, each rounded to the nearest double.

        Raises InputError for another rod: those who ask would take it for the plain one.
        """
        self.require_plain("this computation")
        return float(self.k1), float(self.k2), float(self.gamma3), float(self.gamma1)

    def texts(self) -> dict[str, str]:
        """All values by name, as exact decimal text where they have one, else as a fraction."""
        basic = {name: getattr(self, name) for name in ("k1", "k2", "gamma3", "gamma1")}
        return {name: decimal_text(value) for name, value in (basic | dict(self.own)).items()}

    def require_plain(self, what: str) -> None:
        """InputError unless this is the plain rod: `what` is written for that one alone."""
        if self.model != PLAIN:
            raise InputError(
                f"{what} is made for the rod {PLAIN!r} (constant coefficients, modes known in closed form), "
                f"not for {self.model_name!r}"
            )

    @property
    def model_name(self) -> str:
        """The model's name without the folder it may stand in."""
        return name_of(self.model)

    def checked_force(self, value: Number, name: str = "force") -> Fraction:
        """The exact follower force; the base state needs 0 <= F < k1, so that ν = 1 - F/k1 > 0.

        Another rod than the plain one must have a straight state at this force.
        """
        force = exact(name, value)
        if self.model != PLAIN:
            from rodwnl.straightrod import straight_rod

            if force < 0:
                raise InputError(f"{name} is {shown(value)}, but it must not be negative")
            straight_rod(self, float(force))
            return force
        if not 0 <= force < self.k1:
            raise InputError(
                f"{name} is {shown(value)}, but the straight rod exists only for 0 <= force < k1 = "
                f"{decimal_text(self.k1)} (at k1 it is compressed to length 0)"
            )
        return force

    def __repr__(self) -> str:
        model = "" if self.model == PLAIN else f", model={self.model!r}"
        return f"RodParameters({', '.join(f'{name}={text}' for name, text in self.texts().items())}{model})"


def name_of(model: str) -> str:
    """The name of a model that is given by name or as the folder of an emitted rod."""
    return model.replace("\\", "/").rstrip("/").rpartition("/")[2]


def require_rod(rod: object) -> None:
    """InputError unless this is a rod."""
    require_kind("rod", rod, RodParameters, "as RodParameters(200, '1e4', '1e-4') makes one")


def require_kind(name: str, value: object, kind: type, meaning: str) -> None:
    """InputError unless the value is of this kind, of which `meaning` says where it comes from."""
    if not isinstance(value, kind):
        raise InputError(f"{name} must be a {kind.__name__} ({meaning}), not {shown(value)}")


def own_values(model: str, given: Mapping[str, Number]) -> tuple[tuple[str, Fraction], ...]:
    """What was given for the parameters that a model has of its own, else their defaults, in its order."""
    known = {} if model == PLAIN else kernels.own_parameters(model)
    if strange := [name for name in given if name not in known]:
        has = f"its own are {', '.join(known)}" if known else "it has none beside k1, k2, gamma3 and gamma1"
        raise InputError(f"rod {name_of(model)!r} has no parameter {shown(strange[0])}; {has}")
    return tuple((name, exact(name, given.get(name, default))) for name, default in known.items())


def exact(name: str, value: object) -> Fraction:
    """The rational number that `value` stands for; `name` is what the error message calls it."""
    if isinstance(value, bool) or not isinstance(value, str | numbers.Real | Decimal):
        raise InputError(f"{name} must be a number, not {shown(value)}")
    text = str(value).strip()
    if len(text) > _MOST_CHARACTERS:
        raise InputError(
            f"{name} is {shown(value)}: it has {len(text)} characters, more than {_MOST_CHARACTERS}; "
            "write it shorter"
        )
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
    if isinstance(value, Fraction):
        text = decimal_text(value)
    return text if len(text) <= 60 else text[:57] + "..."


def _enormous(text: str) -> bool:
    """Whether Fraction would build an enormous integer from this text, as it would from 1e999999999."""
    _, e, exponent = text.lower().partition("e")
    return bool(e) and abs(int(exponent)) > _MOST_CHARACTERS
