"""Thresholds of any emitted rod: what `spectrum` asks for, answered by spectral integration.

Newton's method in the force on the real part of one eigenvalue, λ(F), with the exact slope

    dλ/dF = u* (A' − λB') v / u* B v,    A v = λ B v,  u* A = λ u* B,

and the whole repeated on more nodes, which tells the error. Lengths in L, times in γ2 L⁴/k3, forces in k3/L².
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from rodwnl.collocated import (
    EPS,
    Eigenpair,
    leading_eigenvalues,
    nearest,
    stepped,
    unstable_count,
    wave_number,
)
from rodwnl.errors import ComputationError
from rodwnl.inverse import Complex, Real
from rodwnl.parameters import RodParameters
from rodwnl.quadrature import Nodes, gauss_legendre
from rodwnl.spectrum import CONVERGED, MOST_STEPS, HopfThreshold, undecided
from rodwnl.straightrod import straight_rod

MORE_NODES = 16  # what every threshold is compared with
MOST_NODES = 400


@dataclass(frozen=True)
class Collocation:
    """The spectrum of a rod by spectral integration."""

    rod: RodParameters

    def leading(self, force: Real, kept: int) -> tuple[Complex, Complex]:
        """As `Route` says."""
        return leading_eigenvalues(self.rod, force, kept)

    def unstable(self, force: float) -> int:
        """As `Route` says."""
        return unstable_count(self.rod, force)

    def threshold(self, low: float, high: float, force: float, omega: float) -> HopfThreshold:
        """As `Route` says. Raises ComputationError where Newton's method leaves the interval."""
        nodes = nodes_at(self.rod, force, omega)
        coarse = _newton(self.rod, low, high, force, omega, nodes)
        fine = _newton(self.rod, low, high, force, omega, gauss_legendre(len(nodes.u) + MORE_NODES))
        rise = abs(fine.slope.real)
        force_error = abs(fine.force - coarse.force) + fine.pair.noise / rise + EPS * fine.force
        offset = fine.pair.eigenvalue - 1j * fine.omega
        scale = fine.omega if fine.omega else fine.force * rise
        return HopfThreshold(
            fine.force, fine.omega, fine.slope,
            unstable_below=-1, unstable_above=-1,  # until they are counted
            residual=abs(offset) / scale,
            force_error=force_error,
            omega_error=0.0 if fine.omega == 0 else (
                abs(fine.omega - coarse.omega) + fine.pair.noise + abs(fine.slope.imag) * force_error
                + EPS * fine.omega
            ),
        )  # fmt: skip


def nodes_at(rod: RodParameters, force: float, omega: float) -> Nodes:
    """Nodes that resolve products of the modes: their number follows from the largest local wave number.

    Raises ComputationError where the boundary layers are too thin for MOST_NODES.
    """
    straight = straight_rod(rod, force)
    axial = straight("X2_operator", u=1.0, lam=1j * omega) / straight("stretch_stiffness", u=1.0)
    largest = max(wave_number(straight, 1j * omega), float(np.sqrt(np.abs(axial))))
    count = 32 + 8 * int(np.ceil(largest / 4))
    if count > MOST_NODES:
        raise ComputationError(
            f"at F = {force:.6g}, omega = {omega:.6g} the modes vary like exp({largest:.0f} u): {count} "
            f"nodes would be needed, more than {MOST_NODES}; the rod is too stiff or its drag too uneven"
        )
    return gauss_legendre(count)


@dataclass(frozen=True)
class _Found:
    force: float
    omega: float
    slope: complex
    pair: Eigenpair


def _newton(rod: RodParameters, low: float, high: float, force: float, omega: float, nodes: Nodes) -> _Found:
    """Re λ(F) = 0 from a start in [low, high], where exactly one crossing lies; λ real where omega is 0."""
    moves, noise = [np.inf], 0.0
    while moves[-1] > max(CONVERGED, noise) or moves[-1] < moves[-2] / 2:
        p, A_force, B_force = stepped(rod, force, nodes)
        pair = nearest(p, 1j * omega)
        u, v, lam = pair.left.conj(), pair.right, pair.eigenvalue
        omega = omega if abs(lam.imag) > pair.noise else 0.0  # the pencil is real
        slope = complex(u @ (A_force - lam * B_force) @ v / (u @ p.B @ v))
        step = -lam.real / slope.real
        turn = lam.imag + slope.imag * step - omega if omega else 0.0
        moves.append(abs(step) / force + (abs(turn) / omega if omega else 0.0))
        noise = pair.noise / (abs(slope.real) * force)  # what rounding leaves of a small force
        settled = not (moves[-1] > max(CONVERGED, noise) or moves[-1] < moves[-2] / 2)
        if settled:
            return _Found(force, omega, slope if omega else complex(slope.real), pair)
        force, omega = force + step, omega + turn
        if not (low - abs(step) <= force <= high + abs(step) and len(moves) < MOST_STEPS):
            break
    raise ComputationError(undecided(low, 1j * omega))
