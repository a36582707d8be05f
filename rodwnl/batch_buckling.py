"""Forces at which a real eigenvalue of a straight rod passes through 0: there it buckles.

With a load that follows the tip none does. Otherwise E(F) of rodwnl/steady.py changes its sign there. It is
sampled along the force; between samples of opposite signs, and on both sides of an extremum between samples
of one sign that has the other, the force is halved. Two crossings closer than about 1e-4 of the force are
not told from none: the count of unstable eigenvalues between them may be wrong.

Lengths in L, times in γ2 L⁴/k3, forces in k3/L².
"""

from __future__ import annotations

from collections.abc import Callable, Iterator

import numpy as np
from numpy.typing import NDArray

from rodwnl.batch_characteristic import SMALL, Real, jet, problem_with_slopes
from rodwnl.batch_rods import Rods
from rodwnl.straightrod import statics

FEWEST, MOST = 64, 1024  # samples per rod
AT_ONCE = 32768  # samples: of real numbers these fit into the cache
RESOLVED = 16  # wave number of the buckled shape that so few resolve
HALVINGS, STEPS = 50, 3  # to find a crossing of E, and to settle one of D
BACK = 1e-7  # relative step of the difference that tells the sign of E'
BESIDE = 1e-6  # relative distance from a steady crossing at which unstable eigenvalues are counted


def steady_crossings(rods: Rods, max_force: Real) -> tuple[NDArray[np.int_], Real]:
    """Indices of rods and forces, (m,) each, at which an eigenvalue of n rods is 0 in (0, max_force]."""
    found = [_bracketed(rods, part, max_force, count) for count, part in _groups(rods, max_force)]
    rod, low, high, below = (np.concatenate(x) for x in zip(*found, strict=True))
    here = rods[rod]
    return rod, _halved(low, high, lambda force: np.sign(static_balance(here, force)) == below)


def static_balance(rods: Rods, force: Real) -> Real:
    """E(F) = 1 − (ay μ/(2 K2 K3)) sinc²(p/2) − (aθ/K3) sinc(p), also where p = 0."""
    at = statics(rods.at(force), 0.0)
    half = np.sqrt(at.mu * at.load / (at.K2 * at.K3)) / 2
    bent = at.ay * at.mu / (2 * at.K2 * at.K3) * np.sinc(half / np.pi) ** 2
    return np.asarray(1 - bent - at.atheta / at.K3 * np.sinc(2 * half / np.pi))


def _slope(rods: Rods, force: Real) -> Real:
    """The sign of E'(F)."""
    return np.asarray(np.sign(static_balance(rods, force) - static_balance(rods, force * (1 - BACK))))


def _halved(low: Real, high: Real, as_at_low: Callable[[Real], NDArray[np.bool_]]) -> Real:
    """Where a property of the lower ends is lost, (n,)."""
    for _ in range(HALVINGS if low.size else 0):
        middle = (low + high) / 2
        same = as_at_low(middle)
        low, high = np.where(same, middle, low), np.where(same, high, middle)
    return (low + high) / 2


def _groups(rods: Rods, max_force: Real) -> Iterator[tuple[int, NDArray[np.int_]]]:
    """Indices of rods in blocks, with the number of samples that resolves shapes of their wave numbers."""
    parts = np.linspace(0, 1, 9)[1:]
    c4, c2, _ = rods[:, None].at(max_force[:, None] * parts)("exponent_polynomial", lam=0.0)
    wave = np.sqrt(np.broadcast_to(c2 / c4, (len(rods), len(parts))).max(axis=1))
    counts = FEWEST * 2 ** np.ceil(np.log2(np.clip(wave / RESOLVED, 1, MOST / FEWEST))).astype(int)
    for count in np.unique(counts).tolist():
        same = np.flatnonzero(counts == count)
        size = max(AT_ONCE // count, 1)
        yield from ((count, same[i : i + size]) for i in range(0, len(same), size))


def _bracketed(
    rods: Rods, part: NDArray[np.int_], max_force: Real, count: int
) -> tuple[NDArray[np.int_], Real, Real, Real]:
    """Rod, both ends of an interval and the sign at the lower one, for every change of sign."""
    force = max_force[part, None] * np.linspace(0, 1, count) ** 2
    here = rods[part][:, None]
    sign, slope = np.sign(static_balance(here, force)), _slope(here, force)
    rod, at = np.nonzero(sign[:, 1:] * sign[:, :-1] < 0)
    found = [(rod, force[rod, at], force[rod, at + 1], sign[rod, at])]
    # between two samples of one sign |E| falls and rises again: E has the other sign there, or not
    turns = (slope[:, 1:] * slope[:, :-1] < 0) & (slope[:, 1:] == sign[:, 1:])
    rod, at = np.nonzero(turns & (sign[:, 1:] == sign[:, :-1]))
    low, high, below = force[rod, at], force[rod, at + 1], sign[rod, at]
    some = rods[part][rod]
    between = _halved(low, high, lambda force: _slope(some, force) == -below)
    turned = np.flatnonzero(np.sign(static_balance(some, between)) == -below)
    rod, low, high = rod[turned], low[turned], high[turned]
    between, below = between[turned], below[turned]
    found += [(rod, low, between, below), (rod, between, high, -below)]
    which, starts, ends, signs = (np.concatenate(x) for x in zip(*found, strict=True))
    return part[which], starts, ends, signs


def settled(rods: Rods, force: Real) -> Real:
    """The steady crossings near these forces, (n,), by Newton's method for λ(F) = 0 from λ(F) = SMALL."""
    small = np.full(len(force), SMALL + 0j)
    for _ in range(STEPS):
        # D(F, SMALL) + D_F dF = D_λ SMALL
        D, D_F, D_lam = jet(problem_with_slopes(rods, force), small)
        force = force + ((SMALL * D_lam - D) / D_F).real
    return force
