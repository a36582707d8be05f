"""What `--digits` and `--certified` print: thresholds to any number of digits, or as balls with their proof.

Tables are in SI units for a rod that was given in SI units; JSON is always dimensionless.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from fractions import Fraction
from typing import TYPE_CHECKING, Any

import mpmath as mp

from rodwnl.balls import enclosure, flint, working_bits
from rodwnl.exact import ExactThreshold, digits_text, exact_threshold
from rodwnl.output import print_json, print_table
from rodwnl.parameters import RodParameters
from rodwnl.report import document, exact_scale, heading, sentences

if TYPE_CHECKING:
    from rodwnl.certified import CertifiedThreshold
    from rodwnl.spectrum import HopfSearch

DEFAULT_DIGITS = 15
NUMBERS_OF_HOPF = ("force", "omega")
NUMBERS_OF_LANDAU = (*NUMBERS_OF_HOPF, "alpha", "beta", "A_tip2_slope", "omega_slope")


def print_precise(
    rod: RodParameters,
    max_force: Fraction | None,
    digits: int | None,
    names: Sequence[str],
    *,
    certified: bool,
    json: bool,
) -> None:
    """Print the named numbers of every threshold up to a force: to so many digits, certified or not."""
    from rodwnl.spectrum import hopf_thresholds

    if certified:
        flint()
    search = hopf_thresholds(rod, max_force)
    show = print_certified if certified else print_exact
    show(search, DEFAULT_DIGITS if digits is None else digits, names, json=json)


def print_exact(search: HopfSearch, digits: int, names: Sequence[str], *, json: bool) -> None:
    """Print the named numbers of every threshold of a search to so many digits."""
    found = [exact_threshold(search.rod, t.force, t.omega, digits) for t in search]
    if json:
        print_json(document(search, [exact_entry(t, names) for t in found]))
        return
    print("\n".join(sentences(search)))
    for number, t in enumerate(found, 1):
        with mp.workdps(t.working_digits):
            rows = _rows(search, t, names, lambda x: digits_text(x, digits))
            rows.append(["largest residual", mp.nstr(max(t.residuals.values()), 1)])
        print_table(["threshold", str(number)], rows)


def print_certified(search: HopfSearch, digits: int, names: Sequence[str], *, json: bool) -> None:
    """Print the named numbers of every threshold as balls of so many digits, and what was proved of it."""
    from rodwnl.certified import certify_threshold

    def ball_text(x: Any) -> str:
        return "{mid} ± {rad}".format(**enclosure(x, digits))

    found = [certify_threshold(search.rod, t.force, t.omega, digits) for t in search]
    with working_bits(4 * digits + 64):
        if json:
            print_json(document(search, [certified_entry(t, names) for t in found]) | {"certified": True})
            return
        print("\n".join(sentences(search)))
        for number, t in enumerate(found, 1):
            print_table(["threshold", str(number)], _rows(search, t, names, ball_text))
            print("Proved of it, in dimensionless numbers:")
            print("\n".join(f"  {i}. {statement}" for i, statement in enumerate(t.proved, 1)))


def _rows(
    search: HopfSearch, threshold: Any, names: Sequence[str], text: Callable[[Any], str]
) -> list[list[str]]:
    """The verdicts, then one row a real number, in the rod's units."""
    rows = [["crossing", threshold.crossing], ["criticality", threshold.criticality]]
    for name in names:
        factor = exact_scale(search.rod, name)
        for part, value in _real_parts(getattr(threshold, name)):
            rows.append(
                [part + heading(search.rod, name), text(value * factor.numerator / factor.denominator)]
            )
    return rows


def exact_entry(t: ExactThreshold, names: Sequence[str]) -> dict[str, Any]:
    """An exact threshold in JSON: texts of t.digits digits, complex numbers as pairs [re, im]."""
    with mp.workdps(t.working_digits):
        return {
            **{name: _entry(getattr(t, name), lambda x: digits_text(x, t.digits)) for name in names},
            "crossing": t.crossing,
            "criticality": t.criticality,
            "digits": t.digits,
            "working_digits": t.working_digits,
            "digits_that_agree": int(min(t.agreement, t.working_digits)),
            "residuals": {name: mp.nstr(r, 3) for name, r in t.residuals.items()},
        }


def certified_entry(t: CertifiedThreshold, names: Sequence[str]) -> dict[str, Any]:
    """A certified threshold in JSON: every number as {"mid", "rad"}, complex ones as pairs of them."""
    box = {
        name: dict(zip(("mid", "rad"), getattr(t.unique_in, name), strict=True)) for name in NUMBERS_OF_HOPF
    }
    return {
        **{name: _entry(getattr(t, name), lambda x: enclosure(x, t.digits)) for name in names},
        "crossing": t.crossing,
        "criticality": t.criticality,
        "unstable_eigenvalues": t.unstable,
        "unique_in": box,
        "proved": list(t.proved),
    }


def _entry(value: Any, convert: Callable[[Any], Any]) -> Any:
    parts = [convert(x) for _, x in _real_parts(value)]
    return parts if len(parts) == 2 else parts[0]


def _real_parts(value: Any) -> list[tuple[str, Any]]:
    """A real number alone, a complex one as Re and Im; complex balls are kept as such pairs."""
    if isinstance(value, mp.mpc):
        value = (value.real, value.imag)
    return [("Re ", value[0]), ("Im ", value[1])] if isinstance(value, tuple) else [("", value)]
