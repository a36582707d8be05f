"""What `hopf`, `landau` and `predict` print about a rod: its values, the range searched, its thresholds.

Tables are in SI units for a rod that was given in SI units; JSON is always dimensionless and carries the
scales.
"""

from collections.abc import Sequence
from fractions import Fraction
from typing import TYPE_CHECKING, Any

from rodwnl.output import complex_number, full_texts, number
from rodwnl.parameters import PLAIN, RodParameters, decimal_text

if TYPE_CHECKING:
    from rodwnl.coefficients import LandauCoefficients
    from rodwnl.spectrum import HopfSearch, HopfThreshold

# Quantity: powers of length, time and force, and the SI unit.
_UNITS = {
    "force": (0, 0, 1, "N"),
    "omega": (0, -1, 0, "rad/s"),
    "growth": (0, -1, 0, "1/s"),
    "alpha": (-2, -1, 0, "1/(m² s)"),
    "beta": (0, -1, -1, "1/(N s)"),
    "A_tip": (1, 0, 0, "m"),
    "A_tip2_slope": (2, 0, -1, "m²/N"),
    "omega_slope": (0, -1, -1, "rad/(N s)"),
    "beta2": (0, -1, -2, "1/(N² s)"),
    "alpha_prime": (-2, -1, -1, "1/(m² N s)"),
    "alpha5": (-4, -1, 0, "1/(m⁴ s)"),
    "A_tip2_curvature": (2, 0, -2, "m²/N²"),
    "omega_curvature": (0, -1, -2, "rad/(N² s)"),
    "y_tip": (1, 0, 0, "m"),
    "y_tip2_slope": (2, 0, -1, "m²/N"),
}


def exact_scale(rod: RodParameters, quantity: str) -> Fraction:
    """What a dimensionless quantity is multiplied by for printing: 1, or its SI scale."""
    if rod.scales is None:
        return Fraction(1)
    length, time, force, _ = _UNITS[quantity]
    return rod.scales.length**length * rod.scales.time**time * rod.scales.force**force


def scale(rod: RodParameters, quantity: str) -> float:
    """`exact_scale`, rounded."""
    return float(exact_scale(rod, quantity))


def heading(rod: RodParameters, quantity: str) -> str:
    """The quantity's name, with its unit where there is one."""
    return quantity if rod.scales is None else f"{quantity} ({_UNITS[quantity][3]})"


def cell(rod: RodParameters, quantity: str, value: complex | None, error: float | None) -> str:
    """A value as a table shows it: in the rod's units, with the digits that its absolute error allows."""
    if value is None or error is None:
        return "-"
    factor = scale(rod, quantity)
    if isinstance(value, complex):
        return complex_number(value * factor, error * factor)
    return number(value * factor, error * factor)


def with_unit(rod: RodParameters, quantity: str, value: Fraction | float) -> str:
    """A value inside a sentence."""
    if rod.scales is None:
        return decimal_text(value) if isinstance(value, Fraction) else f"{value:.6g}"
    return f"{float(value) * scale(rod, quantity):.6g} {_UNITS[quantity][3]}"


def rod_sentence(rod: RodParameters) -> str:
    """The rod in words."""
    values = ", ".join(f"{name} = {text}" for name, text in rod.texts().items())
    model = "" if rod.model == PLAIN else f" {rod.model_name!r}"
    return f"Rod{model} with {values}{'' if rod.scales is None else ' (dimensionless)'}."


def rod_document(rod: RodParameters) -> dict[str, Any]:
    """The rod in JSON."""
    whole: dict[str, Any] = {} if rod.model == PLAIN else {"model": rod.model_name}
    whole["rod"] = rod.texts()
    if rod.scales is not None:
        scales = rod.scales
        whole["scales"] = {name: decimal_text(getattr(scales, name)) for name in ("length", "time", "force")}
    return whole


def sentences(search: "HopfSearch") -> list[str]:
    """The rod, the range searched, and what was found in it, in words."""
    rod = search.rod
    said = [rod_sentence(rod), f"Searched 0 <= force <= {with_unit(rod, 'force', search.max_force)}."]
    if search.range_cut:
        said.append(
            "The range ends at force = k1, where the straight rod would have length zero."
            if rod.model == PLAIN
            else f"The range ends there: beyond, {_beyond(search)}."
        )
    if search.unstable_unloaded:
        many = search.unstable_unloaded > 1
        said.append(
            f"The straight rod is unstable already at force = 0: {search.unstable_unloaded} "
            f"{'eigenvalues have' if many else 'eigenvalue has'} positive real part."
        )
    said += [_buckling(search, t) for t in search.steady]
    said += [_touch(search, force) for force in search.touches]
    if not search.thresholds:
        said.append("No Hopf threshold." if search.steady else _quiet(search))
    return said


def _beyond(search: "HopfSearch") -> str:
    """What keeps the search from a force a little larger than those searched."""
    from rodwnl.straightrod import obstacle

    return obstacle(search.rod, search.max_force * Fraction(1000001, 1000000))


def _buckling(search: "HopfSearch", threshold: "HopfThreshold") -> str:
    change = "buckles" if threshold.crossing == "destabilizing" else "recovers from buckling"
    name, value = (
        heading(search.rod, "force"),
        cell(search.rod, "force", threshold.force, threshold.force_error),
    )
    return f"At {name} = {value} the straight rod {change}: a steady crossing, omega = 0."


def _touch(search: "HopfSearch", force: float) -> str:
    name, value = heading(search.rod, "force"), cell(search.rod, "force", force, 1e-15 * force)
    return (
        f"At {name} = {value} a real eigenvalue touches 0 and turns back (two steady crossings in one: the "
        "static balance has a double zero, to 50 digits); nothing crosses there."
    )


def _quiet(search: "HopfSearch") -> str:
    rod = search.rod
    if search.unstable_unloaded:
        return "No Hopf threshold: it is unstable in the whole range."
    growth = with_unit(rod, "growth", search.growth)
    force = with_unit(rod, "force", search.growth_force)
    return (
        "No Hopf threshold: the straight rod is stable in the whole range; its leading eigenvalue comes "
        f"closest to the imaginary axis at force = {force}, with real part {growth}."
    )


def document(search: "HopfSearch", thresholds: Sequence[dict[str, Any]]) -> dict[str, Any]:
    """The JSON document of `hopf` and `landau`."""
    steady: dict[str, Any] = {}
    if search.steady:
        steady["steady"] = [threshold_entry(t) for t in search.steady]
    if search.touches:
        steady["touches"] = [repr(force) for force in search.touches]
    return rod_document(search.rod) | {
        "range": ["0", decimal_text(search.max_force)],
        "thresholds": list(thresholds),
        **steady,
        **({"unstable_unloaded": search.unstable_unloaded} if search.unstable_unloaded else {}),
        "notes": sentences(search)[2:],
    }


def threshold_entry(threshold: "HopfThreshold") -> dict[str, Any]:
    """A threshold in JSON, every number as a decimal text that reads back to the same double."""
    return {
        "force": repr(threshold.force),
        "omega": repr(threshold.omega),
        "crossing": threshold.crossing,
        "residual": repr(threshold.residual),
        "error": {"force": repr(threshold.force_error), "omega": repr(threshold.omega_error)},
    }


def landau_entry(c: "LandauCoefficients", plain: bool = True) -> dict[str, Any]:
    """A threshold with its coefficients in JSON; complex numbers are pairs [re, im].

    The parts are called after g1 ... g4 of the plain rod, else after the rows of the equations.
    """
    of_alpha, of_beta = (("g1", "g3"), ("g2", "g4")) if plain else (("y", "theta"), ("y", "theta"))
    entry = threshold_entry(c.threshold)
    error = entry.pop("error") | {
        "alpha": repr(c.alpha_error),
        "beta": repr(c.beta_error),
        "A_tip2_slope": repr(c.A_tip2_slope_error),
        "omega_slope": repr(c.omega_slope_error),
    }
    residuals = {name: repr(r) for name, r in c.residuals.items()} | {"threshold": entry.pop("residual")}
    return entry | {
        "alpha": full_texts(c.alpha),
        "beta": full_texts(c.beta),
        "criticality": c.criticality,
        "A_tip2_slope": repr(c.A_tip2_slope),
        "omega_slope": repr(c.omega_slope),
        "alpha_parts": dict(zip(of_alpha, map(full_texts, c.alpha_parts), strict=True)),
        "beta_parts": dict(zip(of_beta, map(full_texts, c.beta_parts), strict=True)),
        "error": error,
        "residuals": residuals,
        "working_digits": c.working_digits,
    }
