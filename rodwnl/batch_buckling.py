"""Forces at which a real eigenvalue of a straight rod passes through 0: there it buckles, without a frequency.

With a load that follows the tip none does. Otherwise D(F, 0), which is real, changes its sign there. It is
sampled along the force, between samples of opposite signs halved, and the force is corrected for the small λ
at which D is evaluated in place of 0, where its formula is 0/0. Lengths in L, times in γ2 L⁴/k3, forces in
k3/L².
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from rodwnl.batch_characteristic import Real, characteristic, jet
from rodwnl.batch_rods import Rods

SAMPLES = 65  # per rod; between zeros √F grows by about π/2 or more
SMALL = 1e-9  # λ, where the slowest rate is about 1
HALVINGS, STEPS = 20, 3  # to find a crossing, and to settle it
BESIDE = 1e-6  # relative distance from a steady crossing at which unstable eigenvalues are counted


def steady_crossings(rods: Rods, max_force: Real) -> tuple[NDArray[np.int_], Real]:
    """Indices of rods and forces, (m,) each, at which an eigenvalue of n rods is 0 in (0, max_force]."""
    force = max_force[:, None] * np.sin(np.pi / 2 * np.linspace(0, 1, SAMPLES)) ** 2
    sign = _sign(rods[:, None], force)
    rod, at = np.nonzero(sign[:, 1:] * sign[:, :-1] < 0)
    low, high, below = force[rod, at], force[rod, at + 1], sign[rod, at]
    here = rods[rod]
    for _ in range(HALVINGS if rod.size else 0):
        middle = (low + high) / 2
        same = _sign(here, middle) == below
        low, high = np.where(same, middle, low), np.where(same, high, middle)
    return rod, settled(here, (low + high) / 2)


def settled(rods: Rods, force: Real) -> Real:
    """The steady crossings near these forces, (n,), by Newton's method for λ(F) = 0 from λ(F) = SMALL."""
    small = np.full(len(force), SMALL + 0j)
    for _ in range(STEPS):
        # D(F, SMALL) + D_F dF = D_λ SMALL
        D, D_F, D_lam = jet(rods, force, small)
        force = force + ((SMALL * D_lam - D) / D_F).real
    return force


def _sign(rods: Rods, force: Real) -> Real:
    D = characteristic(rods.at(force), np.full(force.shape, SMALL + 0j))
    return np.sign((D.scaled * np.exp(1j * D.turn)).real)
