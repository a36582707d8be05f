"""Thresholds and Landau coefficients of many rods at once, with a status for each rod.

The numbers are those of `rodwnl.landau`, to a relative error of 1e-9; the work is done by
`rodwnl.batch_spectrum` and `rodwnl.batch_coefficients`, and what float64 cannot settle goes to the exact
route, rod by rod.
"""

from __future__ import annotations

from dataclasses import dataclass
from enum import IntEnum
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from rodwnl import kernels
from rodwnl.batch_characteristic import Complex, Real
from rodwnl.batch_coefficients import EPS, coefficients
from rodwnl.batch_spectrum import thresholds
from rodwnl.errors import ComputationError, InputError
from rodwnl.parameters import RodParameters

DEFAULT_MAX_FORCE = 400.0
MOST = 4  # thresholds of a rod that are kept
ACCURACY = 1e-9  # relative, of every number given out
CHUNK = 8192  # rods: the memory used does not grow with their number
ESCALATED_DIGITS, ACCURACY_OF_EXACT = 40, 1e-12  # working digits of the exact route, and what they must leave
PER_ROD = ("status", "count")
PER_THRESHOLD = (
    "force", "omega", "alpha", "beta", "A_tip2_slope", "omega_slope", "crossing", "residual", "error",
)  # fmt: skip


class Status(IntEnum):
    """How the search ended for one rod."""

    FOUND = 0  # thresholds with their coefficients, in float64
    NONE = 1  # no threshold in the range searched
    ESCALATED = 2  # found, with more digits than float64 has
    FAILED = 3  # see `reasons`


@dataclass(frozen=True)
class LandauBatch:
    """Results for rods of shape S, up to MOST thresholds each by increasing force: arrays S + (MOST,).

    status, count: S; `Status` and number of thresholds. Entries at and beyond `count` are NaN (crossing:
    0). force, omega, alpha, beta, A_tip2_slope, omega_slope: as in `LandauCoefficients`, dimensionless.
    crossing: +1 destabilizing, −1 restabilizing. residual: the largest of |β − dλ/dF|/|β|, with dλ/dF from
    the characteristic function, and the defects of boundary conditions and force balance. error: estimated
    relative error of α and β. reasons: flat index of a rod that failed -> why.
    """

    status: NDArray[np.int8]
    count: NDArray[np.int8]
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
    k1: ArrayLike, k2: ArrayLike, gamma3: ArrayLike, gamma1: ArrayLike = 0.5, max_force: float | None = None
) -> LandauBatch:
    """Every Hopf threshold of the leading eigenvalue up to max_force (default min(k1, 400)), with α and β.

    k1, k2, gamma3, gamma1: of any shapes that broadcast. A rod that cannot be computed, or whose parameters
    are not finite and positive, has the status FAILED and a reason; the others are not affected. A rod's
    numbers do not depend on the rods beside it. Raises InputError for shapes that do not broadcast, for
    what are not real numbers, and for a max_force that is not positive.
    """
    try:
        arrays = np.broadcast_arrays(*(np.asarray(x, dtype=float) for x in (k1, k2, gamma3, gamma1)))
    except (TypeError, ValueError) as error:
        raise InputError(
            f"k1, k2, gamma3, gamma1 must be arrays of real numbers that broadcast: {error}"
        ) from None
    if max_force is not None and not 0 < max_force < np.inf:
        raise InputError(f"max_force is {max_force}, but it must be positive and finite")
    flat = tuple(np.ravel(x) for x in arrays)
    chunks = [slice(i, i + CHUNK) for i in range(0, flat[0].size, CHUNK)] or [slice(0)]
    parts = [_chunk((flat[0][p], flat[1][p], flat[2][p], flat[3][p]), max_force) for p in chunks]
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


def _chunk(parameters: tuple[Real, Real, Real, Real], max_force: float | None) -> LandauBatch:
    """`landau_batch` for a chunk of rods of shape (n,)."""
    out = _empty(len(parameters[0]))
    usable = np.all([np.isfinite(p) & (p > 0) for p in parameters], axis=0)
    for i in np.flatnonzero(~usable).tolist():
        _refuse(out, i, "k1, k2, gamma3, gamma1 must be finite and positive")
    rods = np.flatnonzero(usable)
    if not rods.size:
        return out
    k1, k2, gamma3, gamma1 = (p[rods] for p in parameters)
    # What is not finite is found below by tests that it fails, and goes to the exact route.
    with np.errstate(all="ignore"):
        upper = np.minimum(k1, DEFAULT_MAX_FORCE if max_force is None else max_force)
        found = thresholds((k1, k2, gamma3), upper)
        c = coefficients(
            (k1[found.rod], k2[found.rod], gamma3[found.rod], gamma1[found.rod]), found.force, found.omega
        )
        values = {
            "force": found.force, "omega": found.omega, "alpha": c.alpha, "beta": c.beta,
            "A_tip2_slope": kernels.tip_amplitude_squared_slope(c.alpha.real, c.beta.real),
            "omega_slope": kernels.frequency_slope(c.alpha.real, c.alpha.imag, c.beta.real, c.beta.imag),
            "crossing": np.where(found.slope.real > 0, 1, -1),
            "residual": np.maximum(c.residual, np.abs(c.beta - found.slope) / np.abs(c.beta)),
            "error": c.rounding,
        }  # fmt: skip
        good = (values["residual"] < ACCURACY) & (values["error"] < ACCURACY)
    count = np.bincount(found.rod, minlength=len(rods))
    number = np.arange(len(found.rod)) - (np.cumsum(count) - count)[found.rod]  # 0, 1, … within each rod
    doubtful = found.undecided | set(found.rod[~good].tolist()) | set(np.flatnonzero(count > MOST).tolist())
    keep = ~np.isin(found.rod, list(doubtful))
    for name, value in values.items():
        getattr(out, name)[rods[found.rod[keep]], number[keep]] = value[keep]
    out.count[rods] = np.where(count > MOST, 0, count)
    out.status[rods] = np.where(count > 0, Status.FOUND, Status.NONE)
    for i in sorted(doubtful):
        _escalate(out, int(rods[i]), [float(p[rods[i]]) for p in parameters], max_force)
    return out


def _empty(count: int) -> LandauBatch:
    def blank(kind: type) -> Any:
        return np.full((count, MOST), np.nan, dtype=kind)

    return LandauBatch(
        status=np.zeros(count, dtype=np.int8), count=np.zeros(count, dtype=np.int8),
        force=blank(float), omega=blank(float), alpha=blank(complex), beta=blank(complex),
        A_tip2_slope=blank(float), omega_slope=blank(float),
        crossing=np.zeros((count, MOST), dtype=np.int8),
        residual=blank(float), error=blank(float), reasons={},
    )  # fmt: skip


def _refuse(out: LandauBatch, rod: int, why: str) -> None:
    out.status[rod], out.count[rod], out.reasons[rod] = Status.FAILED, 0, why


def _escalate(out: LandauBatch, rod: int, parameters: list[float], max_force: float | None) -> None:
    """Compute one rod by itself: thresholds from the spectrum, coefficients in exact arithmetic."""
    from rodwnl.spectrum import hopf_thresholds

    try:
        one = RodParameters(*parameters)
        search = hopf_thresholds(one, max_force)
        found = [_exact(one, t.force, t.omega) for t in search]
    except (ArithmeticError, ComputationError, InputError, np.linalg.LinAlgError) as error:
        _refuse(out, rod, str(error))
        return
    if len(found) > MOST:
        _refuse(out, rod, f"it has {len(found)} thresholds, more than the {MOST} that are kept")
        return
    out.status[rod], out.count[rod] = Status.ESCALATED if found else Status.NONE, len(found)
    for i, (c, threshold) in enumerate(zip(found, search, strict=True)):
        alpha, beta = complex(c.alpha), complex(c.beta)
        out.force[rod, i], out.omega[rod, i], out.alpha[rod, i], out.beta[rod, i] = (
            c.force,
            c.omega,
            alpha,
            beta,
        )
        out.A_tip2_slope[rod, i] = kernels.tip_amplitude_squared_slope(alpha.real, beta.real)
        out.omega_slope[rod, i] = kernels.frequency_slope(alpha.real, alpha.imag, beta.real, beta.imag)
        out.crossing[rod, i] = 1 if threshold.crossing == "destabilizing" else -1
        out.residual[rod, i] = abs(beta - threshold.slope) / abs(beta)
        out.error[rod, i] = max(float(max(c.residuals.values())), EPS)


def _exact(rod: RodParameters, force: float, omega: float) -> Any:
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
        return found
