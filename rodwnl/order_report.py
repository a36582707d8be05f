"""What `landau --order 5` adds: the coefficients beyond the cubic term and what follows from them.

Tables are in SI units for a rod that was given in SI units; JSON is always dimensionless.
"""

from __future__ import annotations

from collections.abc import Mapping
from fractions import Fraction
from typing import TYPE_CHECKING, Any

from rodwnl.errors import InputError
from rodwnl.output import print_table
from rodwnl.parameters import RodParameters
from rodwnl.report import cell, heading

if TYPE_CHECKING:
    from collections.abc import Sequence

    from rodwnl.exact_responses import ExactAmplitudeEquation
    from rodwnl.responses import AmplitudeEquation
    from rodwnl.spectrum import HopfSearch, HopfThreshold

ORDERS = (3, 5)
#: dA/dt = (beta δ + beta2 δ²) A + (alpha + alpha_prime δ)|A|²A + alpha5 |A|⁴A, δ = F − F_c.
LETTERS = {"beta2": "c102", "alpha_prime": "c211", "alpha5": "c320"}
CURVATURES = ("A_tip2_curvature", "omega_curvature")
STEADY_IS_CUBIC = (
    "Order 5 is evaluated for oscillations; at a steady crossing the numbers are those of order 3."
)


def read_order(order: int) -> int:
    """Raises InputError for an order that is not evaluated."""
    if order not in ORDERS:
        allowed = " or ".join(map(str, ORDERS))
        raise InputError(f"--order is {order}, but the amplitude equation is evaluated to order {allowed}")
    return order


def equations(rod: RodParameters, thresholds: Sequence[HopfThreshold]) -> list[AmplitudeEquation]:
    """The amplitude equation at each threshold."""
    from rodwnl.responses import amplitude_equation

    return [amplitude_equation(rod, threshold) for threshold in thresholds]


def order_entry(equation: AmplitudeEquation) -> dict[str, Any]:
    """What order 5 adds to a threshold in JSON; complex numbers are pairs [re, im]."""
    error = {name: repr(equation.errors[c]) for name, c in LETTERS.items()}
    error |= {name: repr(getattr(equation, f"{name}_error")) for name in CURVATURES}
    fold = equation.fold
    return {
        "order": 5,
        **{name: _pair(equation.coefficients[c]) for name, c in LETTERS.items()},
        **{name: repr(getattr(equation, name)) for name in CURVATURES},
        "third_harmonic": None if equation.third_harmonic is None else _pair(equation.third_harmonic),
        "fold": None if fold is None else {"force": repr(fold.force), "A_tip": repr(fold.A_tip)},
        "order_error": error,
    }


def print_order(rod: RodParameters, found: Sequence[AmplitudeEquation]) -> None:
    """The table that follows that of the cubic theory."""
    rows: list[list[str]] = []
    for name, c in LETTERS.items():
        cells = (cell(rod, name, e.coefficients[c], e.errors[c]) for e in found)
        rows.append([heading(rod, name), *cells])
    for name in CURVATURES:
        cells = (cell(rod, name, getattr(e, name), getattr(e, f"{name}_error")) for e in found)
        rows.append([heading(rod, name), *cells])
    print("To order 5, with d = force - critical force:")
    print("dA/dt = (beta d + beta2 d²) A + (alpha + alpha_prime d) |A|² A + alpha5 |A|⁴ A;")
    print("alpha_prime and Im alpha5 belong to the amplitude of the tip at the fundamental frequency.")
    print_table(["threshold", *(str(i) for i in range(1, len(found) + 1))], rows)
    for i, e in enumerate(found, 1):
        if e.fold is not None:
            force = cell(rod, "force", e.fold.force, 1e-4 * abs(e.fold.force - e.force))
            print(
                f"Threshold {i}: by these coefficients the branch turns around near force = {force}; "
                "good where Re alpha is small."
            )


def print_pitchforks(search: HopfSearch, fifth: bool = False) -> None:
    """The amplitude equation of every steady crossing, one line each; fifth: order 5 was asked for."""
    from rodwnl.responses import pitchfork

    rod = search.rod
    for threshold in search.steady:
        p = pitchfork(rod, threshold)
        numbers = {
            "beta": (p.beta, p.beta_error),
            "alpha": (p.alpha, p.alpha_error),
            "y_tip2_slope": (p.y_tip2_slope, p.y_tip2_slope_error),
        }
        said = ", ".join(f"{heading(rod, n)} = {cell(rod, n, *v)}" for n, v in numbers.items())
        print(f"There da/dt = beta d a + alpha a³ with a the tip's displacement, {p.criticality}: {said}.")
    if fifth and search.steady:
        print(STEADY_IS_CUBIC)


def with_pitchforks(document: dict[str, Any], search: HopfSearch, fifth: bool = False) -> dict[str, Any]:
    """The JSON document with the coefficients of its steady crossings."""
    from rodwnl.responses import pitchfork

    for entry, threshold in zip(document.get("steady", []), search.steady, strict=True):
        p = pitchfork(search.rod, threshold)
        entry |= {name: repr(getattr(p, name)) for name in ("alpha", "beta", "y_tip2_slope")}
        entry["criticality"] = p.criticality
        entry["error"] |= {"alpha": repr(p.alpha_error), "beta": repr(p.beta_error)}
    if fifth and search.steady:
        document["notes"].append(STEADY_IS_CUBIC)
    return document


def exact_order_entry(equation: ExactAmplitudeEquation) -> dict[str, Any]:
    """The same as texts of as many digits as were asked for."""
    numbers = _numbers(equation)
    return {"order": 5, **{name: value[0] if len(value) == 1 else value for name, value in numbers.items()}}


def print_exact_order(rod: RodParameters, number: int, equation: ExactAmplitudeEquation) -> None:
    """One threshold, one row a real number."""
    rows = []
    for name, texts in _numbers(equation, rod).items():
        parts = ("Re ", "Im ") if len(texts) == 2 else ("",)
        rows += [[part + heading(rod, name), text] for part, text in zip(parts, texts, strict=True)]
    print_table(["threshold", f"{number} to order 5"], rows)


def _numbers(equation: ExactAmplitudeEquation, rod: RodParameters | None = None) -> Mapping[str, list[str]]:
    import mpmath as mp

    from rodwnl.exact import GUARD, digits_text
    from rodwnl.report import exact_scale

    found = {}
    with mp.workdps(equation.digits + GUARD):
        values = {name: equation.coefficients[c] for name, c in LETTERS.items()}
        values |= {name: getattr(equation, name) for name in CURVATURES}
        for name, value in values.items():
            factor = Fraction(1) if rod is None else exact_scale(rod, name)
            parts = (value.real, value.imag) if isinstance(value, mp.mpc) else (value,)
            found[name] = [
                digits_text(x * factor.numerator / factor.denominator, equation.digits) for x in parts
            ]
    return found


def _pair(value: complex) -> list[str]:
    return [repr(float(value.real)), repr(float(value.imag))]
