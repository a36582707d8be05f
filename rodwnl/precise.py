"""What `--digits` and `--certified` print: thresholds to any number of digits, or as balls with their proof.

Tables are in SI units for a rod that was given in SI units; JSON is always dimensionless.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from decimal import Decimal
from fractions import Fraction
from typing import TYPE_CHECKING, Any

import mpmath as mp

from rodwnl.balls import enclosure, flint, working_bits
from rodwnl.dialects import CONVENTIONS, Converted, convert
from rodwnl.errors import InputError
from rodwnl.exact import GUARD, ExactThreshold, digits_text, exact_threshold
from rodwnl.exact_pitchfork import ExactPitchfork, exact_pitchfork
from rodwnl.exact_responses import exact_amplitude_equation
from rodwnl.fields import Scalar
from rodwnl.order_report import exact_order_entry, print_exact_order
from rodwnl.output import print_json, print_table
from rodwnl.parameters import RodParameters, decimal_text
from rodwnl.report import document, exact_scale, heading, sentences
from rodwnl.steady import steady_force
from rodwnl.uniformrod import require_uniform

if TYPE_CHECKING:
    from rodwnl.certified import CertifiedThreshold
    from rodwnl.spectrum import HopfSearch

Dialect = tuple[str, int | None]  # a convention's name and the number of intervals of the mesh

DEFAULT_DIGITS = 15
DOUBLE_DIGITS = 17  # of JSON without --digits: as many as a double may need
NUMBERS_OF_HOPF = ("force", "omega")
NUMBERS_OF_PITCHFORK = ("force", "alpha", "beta", "y_tip2_slope")
NUMBERS_OF_LANDAU = (*NUMBERS_OF_HOPF, "alpha", "beta", "A_tip2_slope", "omega_slope")


def print_precise(
    rod: RodParameters,
    max_force: Fraction | None,
    digits: int | None,
    names: Sequence[str],
    *,
    certified: bool,
    json: bool,
    dialect: Dialect | None = None,
    fifth: bool = False,
    complete: bool = False,
) -> None:
    """Print the named numbers of every threshold up to a force: to so many digits, certified or not.

    With a dialect (a convention's name and the mesh) its numbers are printed too.
    """
    from rodwnl.spectrum import hopf_thresholds

    require_uniform(rod, "--certified" if certified else "--digits" if dialect is None else "--convention")
    if certified and dialect:
        raise InputError("--convention converts numbers, not balls: leave out --certified")
    if complete and not certified:
        raise InputError("--complete is a proof: it belongs to --certified")
    if certified:
        flint()
    search = hopf_thresholds(rod, max_force)
    if digits is None:
        digits = DOUBLE_DIGITS if json and not certified else DEFAULT_DIGITS
    if certified:
        print_certified(search, digits, names, json=json, complete=complete)
    else:
        print_exact(search, digits, names, json=json, dialect=dialect, fifth=fifth)


def print_exact(
    search: HopfSearch,
    digits: int,
    names: Sequence[str],
    *,
    json: bool,
    dialect: Dialect | None = None,
    fifth: bool = False,
) -> None:
    """Print the named numbers of every threshold of a search to so many digits; fifth: also of order 5."""
    found = [exact_threshold(search.rod, t.force, t.omega, digits) for t in search]
    beyond = [exact_amplitude_equation(search.rod, t.force, t.omega, digits) for t in search if fifth]
    converted = [convert(search.rod, t, *dialect) if dialect else None for t in found]
    buckled = "alpha" in names
    steady = [
        (exact_pitchfork if buckled else steady_force)(search.rod, t.force, digits) for t in search.steady
    ]
    if json:
        entries = [
            exact_entry(t, names) | _dialect_entry(c, digits) for t, c in zip(found, converted, strict=True)
        ]
        for entry, equation in zip(entries, beyond, strict=False):
            entry |= exact_order_entry(equation)
        whole = document(search, entries)
        for entry, one in zip(whole.get("steady", []), steady, strict=True):
            crossing = entry["crossing"]
            entry.clear()
            entry |= _steady_entry(one, digits) | {"omega": "0", "crossing": crossing, "digits": digits}
        print_json(whole)
        return
    print("\n".join(sentences(search)))
    for number, crossing in enumerate(steady, 1):
        _print_steady(search.rod, number, crossing, digits)
    for number, (t, c) in enumerate(zip(found, converted, strict=True), 1):
        with mp.workdps(t.working_digits):
            rows = _rows(search, t, names, lambda x: digits_text(x, digits))
            rows.append(["largest residual", mp.nstr(max(t.residuals.values()), 1)])
            rows += _dialect_rows(c, digits)
        print_table(["threshold", str(number)], rows)
        if fifth:
            print_exact_order(search.rod, number, beyond[number - 1])
    if dialect and found:
        print(f"{dialect[0]}: {CONVENTIONS[dialect[0]].equation}; dimensionless numbers.")


def _steady_numbers(found: ExactPitchfork | Scalar) -> dict[str, Scalar]:
    """The numbers of a steady crossing, or its force alone."""
    if isinstance(found, ExactPitchfork):
        return {name: getattr(found, name) for name in NUMBERS_OF_PITCHFORK}
    return {"force": found}


def _steady_entry(found: ExactPitchfork | Scalar, digits: int) -> dict[str, str]:
    """A steady crossing in JSON: texts of so many digits."""
    with mp.workdps(digits + GUARD):
        entry = {name: digits_text(x, digits) for name, x in _steady_numbers(found).items()}
    return entry | ({"criticality": found.criticality} if isinstance(found, ExactPitchfork) else {})


def _print_steady(rod: RodParameters, number: int, found: ExactPitchfork | Scalar, digits: int) -> None:
    """The force of a steady crossing, and its amplitude equation where it was asked for."""
    with mp.workdps(digits + GUARD):
        texts = {}
        for name, x in _steady_numbers(found).items():
            factor = exact_scale(rod, name)
            texts[heading(rod, name)] = digits_text(x * factor.numerator / factor.denominator, digits)
    if not isinstance(found, ExactPitchfork):
        print(f"The steady crossing to {digits} digits: {' = '.join(*texts.items())}.")
        return
    print("There da/dt = beta d a + alpha a³ with a the tip's displacement.")
    verdicts = [["crossing", found.crossing], ["criticality", found.criticality]]
    print_table(["steady crossing", str(number)], [*verdicts, *map(list, texts.items())])


def _dialect_rows(converted: Converted | None, digits: int) -> list[list[str]]:
    if converted is None:
        return []
    mesh = "" if converted.mesh is None else f", {converted.mesh} intervals"
    rows = [[f"in the convention {converted.convention}{mesh}", ""]]
    for name, value in converted.numbers.items():
        rows += [[part + name, digits_text(x, digits)] for part, x in _real_parts(value)]
    return rows


def _dialect_entry(converted: Converted | None, digits: int) -> dict[str, Any]:
    if converted is None:
        return {}
    convention = CONVENTIONS[converted.convention]
    entry = {
        "name": converted.convention,
        "equation": convention.equation,
        "source": convention.source,
        "mesh": converted.mesh,
        "mode_norm": digits_text(converted.norm, digits),
        "numbers": {
            name: _entry(value, lambda x: digits_text(x, digits)) for name, value in converted.numbers.items()
        },
    }
    return {"convention": entry}


def print_certified(
    search: HopfSearch, digits: int, names: Sequence[str], *, json: bool, complete: bool = False
) -> None:
    """Print the named numbers of every threshold as balls of so many digits, and what was proved of it."""
    from rodwnl.certified import COUNT_BITS, certify_threshold
    from rodwnl.isolation import steady_box, steady_enclosure

    def ball_text(x: Any) -> str:
        return "{mid} ± {rad}".format(**enclosure(x, digits))

    found = [certify_threshold(search.rod, t.force, t.omega, digits) for t in search]
    statement = _completeness(search) if complete else {}
    with working_bits(COUNT_BITS):
        boxes = [steady_box(search.rod, t.force) for t in search.steady]
        steady = [
            steady_enclosure(search.rod, t.force, digits, box)
            for t, box in zip(search.steady, boxes, strict=True)
        ]
    with working_bits(4 * digits + 64):
        if json:
            whole = document(search, [certified_entry(t, names) for t in found])
            for entry, force, box in zip(whole.get("steady", []), steady, boxes, strict=True):
                crossing = entry["crossing"]
                entry.clear()
                entry |= {"force": enclosure(force, digits), "omega": "0", "crossing": crossing}
                entry["unique_in"] = {"force": dict(zip(("mid", "rad"), box.force, strict=True))}
            print_json(whole | {"certified": True} | statement)
            return
        print("\n".join(sentences(search)))
        for force, box in zip(steady, boxes, strict=True):
            print(f"The steady crossing, dimensionless: force = {ball_text(force)}.")
            print(f"Proved: it is the only force in {' +/- '.join(box.force)} at which an eigenvalue is 0.")
            print("More is not proved of a steady crossing.")
        for number, t in enumerate(found, 1):
            print_table(["threshold", str(number)], _rows(search, t, names, ball_text))
            print("Proved of it, in dimensionless numbers:")
            print("\n".join(f"  {i}. {sentence}" for i, sentence in enumerate(t.proved, 1)))
    if statement:
        print(f"Proved: {statement['complete']['statement']}")


def _completeness(search: HopfSearch) -> dict[str, Any]:
    """What is proved of the whole range, for JSON."""
    from rodwnl.completeness import prove_complete

    proved = prove_complete(search)
    upper = decimal_text(proved.max_force)
    forces = "one force" if proved.crossings == 1 else f"{proved.crossings} forces"
    sentence = f"for 0 <= force <= {upper} an eigenvalue lies on the imaginary axis at exactly {forces}"
    numbers = {"max_force": upper, "crossings": proved.crossings}
    if proved.steady:
        numbers["steady"] = proved.steady
        sentence += f"; at {proved.steady} of these it is 0"
    return {"complete": numbers | {"statement": sentence}}


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
            "error": {name: _rounding(getattr(t, name), t.digits) for name in names},
            "crossing": t.crossing,
            "criticality": t.criticality,
            "digits": t.digits,
            "working_digits": t.working_digits,
            "digits_that_agree": int(min(t.agreement, t.working_digits)),
            "residuals": {name: mp.nstr(r, 3) for name, r in t.residuals.items()},
        }


def _rounding(value: Any, digits: int) -> str:
    """A bound of what rounding to so many correct digits changes; of a complex number in either part."""
    places = [Decimal(digits_text(x, digits)).adjusted() - digits for _, x in _real_parts(value)]
    return f"5e{max(places)}"


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
