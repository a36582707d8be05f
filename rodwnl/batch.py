"""Thresholds and Landau coefficients of many rods at once, with a status for each rod.

The numbers are those of `rodwnl.landau`, to a relative error of 1e-9; the work is done by
`rodwnl.batch_spectrum` and `rodwnl.batch_coefficients`, and what these cannot settle is done one by one:
coefficients that cancel in exact arithmetic, the rest by the route of a single rod.
"""

from __future__ import annotations

from contextlib import suppress
from dataclasses import dataclass
from enum import IntEnum
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from rodwnl import kernels
from rodwnl.batch_characteristic import Complex, Real
from rodwnl.batch_coefficients import EPS, coefficients
from rodwnl.batch_rods import Rods, largest_forces
from rodwnl.batch_spectrum import thresholds
from rodwnl.errors import ComputationError, InputError
from rodwnl.parameters import PLAIN, Number, RodParameters, own_values, positive

if TYPE_CHECKING:
    from rodwnl.spectrum import HopfThreshold

DEFAULT_MAX_FORCE = 400.0
MOST = 4  # thresholds of a rod that are kept
ACCURACY = 1e-9  # relative, of every number given out
CHUNK = 8192  # rods: the memory used does not grow with their number
COMPILED_FROM = 1000  # rods: compiling takes 2 s, the first time for a kind of rod
ESCALATED_DIGITS, ACCURACY_OF_EXACT = 40, 1e-12  # working digits of the exact route, and what they must leave
BASIC = ("k1", "k2", "gamma3", "gamma1")
PER_ROD = ("status", "count", "buckling_force")
PER_THRESHOLD = (
    "force", "omega", "alpha", "beta", "A_tip2_slope", "omega_slope", "crossing", "residual", "error",
)  # fmt: skip


class Status(IntEnum):
    """How the search ended for one rod."""

    FOUND = 0  # thresholds with their coefficients, in float64
    NONE = 1  # no threshold in the range searched
    ESCALATED = (
        2  # found, with coefficients in more digits or by the route of a single rod, which take longer
    )
    FAILED = 3  # see `reasons`
    BUCKLES = 4  # a real eigenvalue crosses, at `buckling_force`; beside it there may be thresholds
    UNSTABLE = 5  # already without a force; there may be forces at which it becomes stable
    MORE = 6  # than MOST thresholds: the first ones are given


@dataclass(frozen=True)
class LandauBatch:
    """Results for rods of shape S, up to MOST thresholds each by increasing force: arrays S + (MOST,).

    status, count: S; `Status` and number of thresholds. Entries at and beyond `count` are NaN (crossing:
    0). force, omega, alpha, beta, A_tip2_slope, omega_slope: as in `LandauCoefficients`, dimensionless.
    crossing: +1 destabilizing, −1 restabilizing. residual: the largest of |β − dλ/dF|/|β|, with dλ/dF from
    the characteristic function, and the defects of boundary conditions and force balance. error: estimated
    relative error of α and β. buckling_force: S; where the leading eigenvalue first crosses at 0, or NaN.
    reasons: flat index of a rod that failed -> why.
    """

    status: NDArray[np.int8]
    count: NDArray[np.int8]
    buckling_force: Real
    force: Real
    omega: Real
    alpha: Complex
    beta: Complex
    A_tip2_slope: Real
    omega_slope: Real
    crossing: NDArray[np.int8]
    residual: Real
    error: Real
    reasons: dict[int, str]


def landau_batch(
    k1: ArrayLike,
    k2: ArrayLike,
    gamma3: ArrayLike,
    gamma1: ArrayLike = 0.5,
    max_force: Number | None = None,
    *,
    model: str = PLAIN,
    **own: ArrayLike,
) -> LandauBatch:
    """Every Hopf threshold of the leading eigenvalue up to max_force, with α and β.

    k1, k2, gamma3, gamma1: of any shapes that broadcast. max_force: 400 unless given, and no farther than the
    straight rod goes. model: as of `RodParameters`; its own parameters by name in the same way, each its
    default unless it is given. A rod that cannot be computed, or whose parameters are not finite and positive
    (its own: finite), has the status FAILED and a reason; the others are not affected. A rod's numbers do not
    depend on the rods beside it. Where the straight rod is not uniform, under a load spread along it, every
    rod is computed by itself: about a second each. Raises InputError for shapes that do not broadcast, for
    what are not real numbers, for a parameter that the model does not have, and for a max_force that is not
    positive.
    """
    given = {"k1": k1, "k2": k2, "gamma3": gamma3, "gamma1": gamma1}
    given |= {
        name: own.get(name, float(default)) for name, default in own_values(model, dict.fromkeys(own, 0))
    }
    try:
        arrays = np.broadcast_arrays(*(np.asarray(x, dtype=float) for x in given.values()))
    except (TypeError, ValueError) as error:
        raise InputError(
            f"{', '.join(given)} must be arrays of real numbers that broadcast: {error}"
        ) from None
    if max_force is not None:
        max_force = float(positive("max_force", max_force))
    values = dict(zip(given, (np.ravel(x) for x in arrays), strict=True))
    rods = Rods(model, values, compiled=arrays[0].size >= COMPILED_FROM)
    chunks = [slice(i, i + CHUNK) for i in range(0, len(rods), CHUNK)] or [slice(0)]
    parts = [_chunk(rods[p], max_force) for p in chunks]
    reasons = {
        part.start + i: why for part, got in zip(chunks, parts, strict=True) for i, why in got.reasons.items()
    }
    shape = arrays[0].shape
    return LandauBatch(
        **{name: np.concatenate([getattr(p, name) for p in parts]).reshape(shape) for name in PER_ROD},
        **{
            name: np.concatenate([getattr(p, name) for p in parts]).reshape(*shape, MOST)
            for name in PER_THRESHOLD
        },
        reasons=reasons,
    )


def _chunk(everything: Rods, max_force: float | None) -> LandauBatch:
    """`landau_batch` for a chunk of rods."""
    out = _empty(len(everything))
    usable = _usable(everything, out)
    if not kernels.is_uniform(everything.model):
        for i in usable.tolist():
            _escalate(out, i, everything, max_force)
        return out
    asked = DEFAULT_MAX_FORCE if max_force is None else max_force
    # What is not finite is found below by tests that it fails, and goes to the route of a single rod.
    with np.errstate(all="ignore"):
        upper = largest_forces(everything[usable], asked)
        for i in usable[np.isnan(upper)].tolist():
            _escalate(out, i, everything, max_force)  # for the reason
        which, upper = usable[np.isfinite(upper)], upper[np.isfinite(upper)]
        if not which.size:
            return out
        rods = everything[which]
        found = thresholds(rods, upper)
        c = coefficients(rods[found.rod], found.force, found.omega)
        values = {
            "force": found.force, "omega": found.omega, "alpha": c.alpha, "beta": c.beta,
            "crossing": np.where(found.slope.real > 0, 1, -1),
            "residual": np.maximum(c.residual, np.abs(c.beta - found.slope) / np.abs(c.beta)),
            "error": c.rounding,
        }  # fmt: skip
    cancelled = _made_exact(rods, found.rod, values)
    with np.errstate(all="ignore"):
        values = _with_slopes(values)
        good = (values["residual"] < ACCURACY) & (values["error"] < ACCURACY)
    count = np.bincount(found.rod, minlength=len(rods))
    number = np.arange(len(found.rod)) - (np.cumsum(count) - count)[found.rod]  # 0, 1, … within each rod
    doubtful = found.undecided | set(found.rod[~good].tolist())
    keep = ~np.isin(found.rod, list(doubtful)) & (number < MOST)
    for name, value in values.items():
        getattr(out, name)[which[found.rod[keep]], number[keep]] = value[keep]
    out.count[which] = np.minimum(count, MOST)
    out.buckling_force[which] = found.buckling
    route = np.where(np.isin(np.arange(len(rods)), cancelled), Status.ESCALATED, Status.FOUND)
    out.status[which] = _status(count, found.buckling, found.unloaded, route)
    for i in sorted(doubtful):
        _escalate(out, int(which[i]), everything, max_force)
    return out


def _made_exact(rods: Rods, rod: NDArray[np.int_], values: dict[str, Any]) -> NDArray[np.int_]:
    """Put exact values where a threshold is sure but the integrals of its coefficients cancel.

    Returns which rods, (thresholds made exact,).
    """
    cancels = np.flatnonzero((values["residual"] < ACCURACY) & ~(values["error"] < ACCURACY))
    for i in cancels.tolist():
        with suppress(
            ArithmeticError, ComputationError
        ):  # the rod is computed by itself below, for the reason
            exact = _exact(rods.one(int(rod[i])), values["force"][i], values["omega"][i])
            for name, number in exact.items():
                values[name][i] = number
    return rod[cancels]


def _with_slopes(values: dict[str, Any]) -> dict[str, Any]:
    """Numbers or arrays."""
    alpha, beta = values["alpha"], values["beta"]
    return values | {
        "A_tip2_slope": kernels.tip_amplitude_squared_slope(alpha.real, beta.real),
        "omega_slope": kernels.frequency_slope(alpha.real, alpha.imag, beta.real, beta.imag),
    }


def _status(count: Any, buckling: Any, unloaded: Any, found: Any) -> Any:
    """From the number of thresholds, a steady crossing or NaN, and how many eigenvalues are unstable at 0."""
    cases = (count > MOST, unloaded > 0, np.isfinite(buckling), count > 0)
    return np.select(cases, (Status.MORE, Status.UNSTABLE, Status.BUCKLES, found), Status.NONE)


def _usable(rods: Rods, out: LandauBatch) -> NDArray[np.int_]:
    """Indices of the rods whose parameters are in order; the others fail."""
    good = np.ones(len(rods), dtype=bool)
    for name, values in rods.values.items():
        own = name not in BASIC
        bad = good & ~(np.isfinite(values) & (own | (values > 0)))
        why = f"{name} must be finite" if own else f"{', '.join(BASIC)} must be finite and positive"
        for i in np.flatnonzero(bad).tolist():
            _refuse(out, i, why)
        good &= ~bad
    return np.flatnonzero(good)


def _empty(count: int) -> LandauBatch:
    def blank(kind: type) -> Any:
        return np.full((count, MOST), np.nan, dtype=kind)

    return LandauBatch(
        status=np.zeros(count, dtype=np.int8), count=np.zeros(count, dtype=np.int8),
        buckling_force=np.full(count, np.nan),
        force=blank(float), omega=blank(float), alpha=blank(complex), beta=blank(complex),
        A_tip2_slope=blank(float), omega_slope=blank(float),
        crossing=np.zeros((count, MOST), dtype=np.int8),
        residual=blank(float), error=blank(float), reasons={},
    )  # fmt: skip


def _refuse(out: LandauBatch, rod: int, why: str) -> None:
    out.status[rod], out.count[rod], out.reasons[rod] = Status.FAILED, 0, why


def _escalate(out: LandauBatch, rod: int, rods: Rods, max_force: float | None) -> None:
    """Compute one rod by itself: thresholds from the spectrum; coefficients in exact arithmetic, or by
    spectral integration where modes are no exponentials.
    """
    from rodwnl.spectrum import hopf_thresholds

    for name in (*PER_THRESHOLD, "buckling_force"):
        getattr(out, name)[rod] = 0 if name == "crossing" else np.nan
    try:
        one = rods.one(rod)
        search = hopf_thresholds(one, max_force)
        found = [
            _exact(one, t.force, t.omega) if kernels.is_uniform(one.model) else _collocated(one, t)
            for t in search
        ]
    except (ArithmeticError, ComputationError, InputError, np.linalg.LinAlgError) as error:
        _refuse(out, rod, str(error))
        return
    buckling = search.steady[0].force if search.steady else np.nan
    out.count[rod], out.buckling_force[rod] = min(len(found), MOST), buckling
    out.status[rod] = _status(len(found), buckling, search.unstable_unloaded, Status.ESCALATED)
    for i, (threshold, values) in enumerate(zip(search.thresholds[:MOST], found, strict=False)):
        values["crossing"] = 1 if threshold.crossing == "destabilizing" else -1
        values["residual"] = abs(values["beta"] - threshold.slope) / abs(values["beta"])
        for name, number in _with_slopes(values).items():
            getattr(out, name)[rod, i] = number


def _collocated(rod: RodParameters, threshold: HopfThreshold) -> dict[str, Any]:
    """By spectral integration, as `landau` does for this rod; the error is its own estimate."""
    from rodwnl.coefficients import ENOUGH, landau_at

    c = landau_at(rod, threshold)
    if c.digits < ENOUGH:
        raise ComputationError(
            f"float64 gives only {max(c.digits, 0):.0f} digits near force {threshold.force:.6g}"
        )
    return {
        "force": c.force, "omega": c.omega, "alpha": c.alpha, "beta": c.beta,
        "error": max(c.alpha_error / abs(c.alpha), c.beta_error / abs(c.beta)),
    }  # fmt: skip


def _exact(rod: RodParameters, force: float, omega: float) -> dict[str, Any]:
    """α and β with ESCALATED_DIGITS; the residuals compare two routes to each and must be small."""
    import mpmath as mp

    from rodwnl.closedform import coefficients as in_closed_form
    from rodwnl.closedform import critical_state
    from rodwnl.exact import MpNumbers, refine_threshold

    with mp.workdps(ESCALATED_DIGITS):
        at = refine_threshold(rod, mp.mpf(force), mp.mpf(omega))
        found = in_closed_form(critical_state(rod, *at, MpNumbers()))
        worst = max(found.residuals.values())
        if not worst < ACCURACY_OF_EXACT:
            raise ComputationError(
                f"{ESCALATED_DIGITS} digits are not enough near force {force:.6g} "
                f"(residual {mp.nstr(worst, 2)}); compute this rod by itself, with --digits"
            )
    return {
        "force": float(found.force), "omega": float(found.omega),
        "alpha": complex(found.alpha), "beta": complex(found.beta),
        "error": max(float(worst), EPS),
    }  # fmt: skip
