"""The linear problem of many straight rods as polynomials, read off the emitted functions.

Everything specific to a model comes from these: the polynomial of the exponents, and what one exponential
contributes to the boundary conditions. A formula of a problem may be compiled: it is called once with numbers
that record it. Lengths in L, times in γ2 L⁴/k3, forces in k3/L².
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from typing import Any

import numpy as np

from rodwnl.compiled import Complex, Kernel, kernel
from rodwnl.jets import Jet, Powers
from rodwnl.jets import coefficients as by_power
from rodwnl.recorded import Recorded, Tape
from rodwnl.straightrod import StraightRod

RATE = 100  # Kronecker's substitution: λ = r^RATE, so that r^i λ^j is the power i + RATE j
Terms = dict[int, dict[int, Any]]
Formula = Callable[["Problem", Any], tuple[Any, ...]]


@dataclass(frozen=True)
class Problem:
    """The linear problem of straight rods as polynomials: real arrays, or Jets, as coefficients.

    exponents: c4, c2, c0 of c4 r⁴ + c2 r² + c0 = 0, by powers of λ. clamp, shear, moment: what e^{ru} adds to
    Θ(0) and to the stresses minus load at the tip over their stiffness, by powers of r, then of λ. compiled:
    whether its formulas are to be compiled.
    """

    exponents: tuple[dict[int, Any], ...]
    clamp: Terms
    shear: Terms
    moment: Terms
    compiled: bool = False

    def __getitem__(self, which: Any) -> Problem:
        """Of some of the rods, or of all in another shape."""
        return self.map(lambda c: c[which] if isinstance(c, np.ndarray | Jet) else c)

    def map(self, change: Callable[[Any], Any]) -> Problem:
        """The problem with every coefficient changed, always in the same order."""

        def changed(terms: dict[int, Any]) -> dict[int, Any]:
            return {k: change(c) for k, c in terms.items()}

        clamp, shear, moment = (
            {i: changed(x) for i, x in c.items()} for c in (self.clamp, self.shear, self.moment)
        )
        return Problem(tuple(map(changed, self.exponents)), clamp, shear, moment, self.compiled)


def problem(straight: StraightRod, compiled: bool = False) -> Problem:
    """The emitted formulas, called with r and λ as variables of polynomials."""
    r, lam = Powers({1: 1}), Powers({RATE: 1})
    _, *conditions = straight("boundary_column", r=r, exp_r=1, lam=lam)
    exponents = tuple(_by_r_and_lam(c)[0] for c in straight("exponent_polynomial", lam=lam))
    clamp, shear, moment = map(_by_r_and_lam, conditions)
    return Problem(exponents, clamp, shear, moment, compiled)


def _by_r_and_lam(formula: Any) -> Terms:
    terms: Terms = {}
    for k, c in by_power(formula).items():
        j = (k + RATE // 2) // RATE
        terms.setdefault(k - RATE * j, {})[j] = c
    return terms


# ---- compiled formulas

_kernels: dict[tuple[Formula, str], Kernel | None] = {}


def compiled_formula(given: Problem, formula: Formula) -> Callable[[Complex], Complex] | None:
    """The formula as a function of λ (points, n), of n rods, that gives its results (results, points, n).

    None where the problem does not ask for it or no compiler takes it. Coefficients do not depend on λ: of
    Jets in (F, λ) only the slope in F is not 0.
    """
    if not given.compiled:
        return None
    kinds = given.map(lambda c: type(c) if isinstance(c, np.ndarray | Jet) else c)
    key = formula, repr(kinds)
    if key not in _kernels:
        _kernels[key] = _recorded(kinds, formula)
    run = _kernels[key]
    columns: list[Any] = []

    def collect(c: Any) -> None:
        if isinstance(c, Jet):
            columns.extend((c.value, c.slopes[0]))
        elif isinstance(c, np.ndarray):
            columns.append(c)

    given.map(collect)
    return run and partial(run, columns)


def _recorded(kinds: Problem, formula: Formula) -> Kernel | None:
    """The formula, recorded with a column of numbers for every array, and compiled."""
    tape = Tape()
    columns: list[str] = []

    def column() -> Recorded:
        columns.append(f"column{len(columns)}")
        return Recorded(tape, columns[-1])

    def recorded(kind: Any) -> Any:
        if kind is Jet:
            return Jet(column(), np.array([[column()], [Recorded(tape, 0.0)]]))
        return column() if kind is np.ndarray else Recorded(tape, float(kind))

    results = formula(kinds.map(recorded), Recorded(tape, "lam_re", "lam_im"))
    return kernel(tape, columns, [np.ravel(result).item() for result in results])
