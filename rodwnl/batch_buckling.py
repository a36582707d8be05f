"""Forces at which a real eigenvalue of a straight rod passes through 0: there it buckles.

With a load that follows the tip none does. Otherwise D(F, 0), which is real, changes its sign there. It is
sampled along the force, between samples of opposite signs halved, and the force is corrected for the small λ
at which D is evaluated in place of 0, where its formula is 0/0. Lengths in L, times in γ2 L⁴/k3, forces in
k3/L².
"""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray

from rodwnl.batch_characteristic import (
    BLOCK,
    COMPILED_BLOCK,
    SMALL,
    Real,
    jet,
    problem_with_slopes,
    sign_at_rest,
)
from rodwnl.batch_problem import problem
from rodwnl.batch_rods import Rods

FEWEST, MOST = 64, 1024  # samples per rod
RESOLVED = 16  # wave number of the buckled shape that so few resolve
HALVINGS, STEPS = 20, 3  # to find a crossing, and to settle it
BESIDE = 1e-6  # relative distance from a steady crossing at which unstable eigenvalues are counted


def steady_crossings(rods: Rods, max_force: Real) -> tuple[NDArray[np.int_], Real]:
    """Indices of rods and forces, (m,) each, at which an eigenvalue of n rods is 0 in (0, max_force]."""
    found = [_bracketed(rods, part, max_force, count) for count, part in _groups(rods, max_force)]
    rod, low, high, below = (np.concatenate(x) for x in zip(*found, strict=True))
    here = rods[rod]
    for _ in range(HALVINGS if rod.size else 0):
        middle = (low + high) / 2
        same = sign_at_rest(problem(here.at(middle), rods.compiled)) == below
        low, high = np.where(same, middle, low), np.where(same, high, middle)
    return rod, settled(here, (low + high) / 2)


def _groups(rods: Rods, max_force: Real) -> Iterator[tuple[int, NDArray[np.int_]]]:
    """Indices of rods in blocks, with the number of samples that resolves shapes of their wave numbers."""
    parts = np.linspace(0, 1, 9)[1:]
    c4, c2, _ = rods[:, None].at(max_force[:, None] * parts)("exponent_polynomial", lam=0.0)
    wave = np.sqrt(np.broadcast_to(c2 / c4, (len(rods), len(parts))).max(axis=1))
    counts = FEWEST * 2 ** np.ceil(np.log2(np.clip(wave / RESOLVED, 1, MOST / FEWEST))).astype(int)
    for count in np.unique(counts).tolist():
        same = np.flatnonzero(counts == count)
        size = max((COMPILED_BLOCK if rods.compiled else BLOCK) // count, 1)
        yield from ((count, same[i : i + size]) for i in range(0, len(same), size))


def _bracketed(
    rods: Rods, part: NDArray[np.int_], max_force: Real, count: int
) -> tuple[NDArray[np.int_], Real, Real, Real]:
    """Rod, both ends of an interval and the sign at the lower one, for every change of sign."""
    force = max_force[part, None] * np.linspace(0, 1, count) ** 2
    everywhere = rods[np.repeat(part, count)].at(force.ravel())
    sign = sign_at_rest(problem(everywhere, rods.compiled)).reshape(force.shape)
    rod, at = np.nonzero(sign[:, 1:] * sign[:, :-1] < 0)
    return part[rod], force[rod, at], force[rod, at + 1], sign[rod, at]


def settled(rods: Rods, force: Real) -> Real:
    """The steady crossings near these forces, (n,), by Newton's method for λ(F) = 0 from λ(F) = SMALL."""
    small = np.full(len(force), SMALL + 0j)
    for _ in range(STEPS):
        # D(F, SMALL) + D_F dF = D_λ SMALL
        D, D_F, D_lam = jet(problem_with_slopes(rods, force), small)
        force = force + ((SMALL * D_lam - D) / D_F).real
    return force
