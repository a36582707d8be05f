"""Many rods of one emitted model: parameters as arrays, and their straight states under arrays of forces.

Only rods whose straight state is uniform: their linear problem has constant coefficients and modes that are
exponentials, so the emitted functions broadcast over rods. Lengths in L, times in γ2 L⁴/k3, forces in k3/L².
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from types import SimpleNamespace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from rodwnl import kernels
from rodwnl.jets import NAMESPACE, Jet, value
from rodwnl.parameters import PLAIN, RodParameters
from rodwnl.straightrod import StraightRod, arguments, assumptions, balanced_stretch, held

Real = NDArray[np.float64]

BISECTIONS = 50  # of the range of forces, in which it is found where the straight rod ends


@dataclass(frozen=True)
class Rods:
    """n rods of one model: every parameter by name, the model's own too, (n,) each, or Jets of them.

    compiled: whether there are so many that it pays to compile their characteristic function.
    """

    model: str
    values: Mapping[str, Any]
    compiled: bool = False

    def __getitem__(self, which: Any) -> Rods:
        return replace(self, values={name: array[which] for name, array in self.values.items()})

    def __len__(self) -> int:
        return len(self.values["k1"])

    def one(self, index: int) -> RodParameters:
        """One of the rods, as the routes of a single rod take it."""
        numbers: dict[str, Any] = {name: float(array[index]) for name, array in self.values.items()}
        return RodParameters(model=self.model, **numbers)

    @property
    def functions(self) -> SimpleNamespace:
        return kernels.load(self.model)

    @property
    def may_buckle(self) -> bool:
        """Whether a real eigenvalue can pass through 0: then the derivation has emitted the pitchfork."""
        return hasattr(self.functions, "steady_X001_forcing")

    def at(self, force: Any) -> StraightRod:
        """The straight rods under these forces, (n,) or Jets; an implicit ν is NaN where there is none.

        The derivatives of an implicit ν: one step of Newton's method with Jets from its value.
        """
        functions = self.functions
        given = {**self.values, "force": force, "xp": NAMESPACE}
        if "nu" in arguments(functions.straight_rod):
            given["nu"] = balanced_stretch(functions, {name: value(v) for name, v in given.items()})
            if isinstance(force, Jet):
                here = StraightRod(functions, force, given)
                given["nu"] = given["nu"] - here("straight_rod")[-1] / here("stretch_stiffness")
        return StraightRod(functions, force, given)


def largest_forces(rods: Rods, asked: float) -> Real:
    """Up to which force each rod is searched, (n,): `asked`, or where the straight rod ends; NaN without one.

    The plain rod ends at k1, where it has length 0. Others end where they are at the LEAST of an
    assumption of the theory, as for one rod (`rodwnl.straightrod`).
    """
    if rods.model == PLAIN:
        return np.asarray(np.minimum(rods.values["k1"], asked))
    high = np.full(len(rods), asked)
    low = np.where(_sound(rods, np.zeros(len(rods))), 0.0, np.nan)
    reached = _sound(rods, high)
    low = np.where(reached & np.isfinite(low), high, low)
    short = np.flatnonzero(~reached & np.isfinite(low))
    some, below, above = rods[short], low[short], high[short]
    for _ in range(BISECTIONS if short.size else 0):
        middle = (below + above) / 2
        good = _sound(some, middle)
        below, above = np.where(good, middle, below), np.where(good, above, middle)
    low[short] = below
    return low


def _sound(rods: Rods, force: Real) -> NDArray[np.bool_]:
    """Whether there is a straight rod that obeys the assumptions, each as far as LEAST says."""
    unloaded, straight = rods.at(np.zeros(len(rods))), rods.at(force)
    good = np.ones(len(rods), dtype=bool)
    for (what, before, _), (_, now, _) in zip(
        assumptions(unloaded, 0.0), assumptions(straight, 0.0), strict=True
    ):
        good &= held(what, np.real(before()), np.real(now()))
    return good
