"""Thresholds of any emitted rod: what `spectrum` asks for, answered by spectral integration.

Newton's method in the force on the real part of one eigenvalue, λ(F), with the exact slope

    dλ/dF = u* (A' − λB') v / u* B v,    A v = λ B v,  u* A = λ u* B,

and the whole repeated on more nodes, which tells the error. Lengths in L, times in γ2 L⁴/k3, forces in k3/L².
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from rodwnl import kernels
from rodwnl.collocated import (
    EPS,
    Eigenpair,
    leading_eigenvalues,
    nearest,
    static_sign,
    stepped,
    unstable_count,
    wave_number,
)
from rodwnl.errors import ComputationError, InputError
from rodwnl.inverse import Complex, Real
from rodwnl.parameters import RodParameters
from rodwnl.quadrature import Nodes, gauss_legendre
from rodwnl.scan import undecided
from rodwnl.spectrum import CONVERGED, MOST_STEPS, HopfThreshold
from rodwnl.straightrod import ENDS, straight_rod

MORE_NODES = 16  # what every threshold is compared with
MOST_NODES = 400
RESOLVED = 1e-5  # relative distance of two steady crossings that double precision tells apart
DIGITS = 17  # of a steady crossing's force, before it is rounded to a double
BESIDE_ZERO = 1e-6  # a shift next to the eigenvalue 0, at which the matrix is not singular
STATIC = 64  # forces at which the static problem is looked at: steps of 0.3 in √F where F goes to 400
NEAR = 1e-3  # relative distance of what is undecided from where a real eigenvalue is closest to 0


@dataclass(frozen=True)
class Collocation:
    """The spectrum of a rod by spectral integration."""

    rod: RodParameters

    def leading(self, force: Real, kept: int) -> tuple[Complex, Complex]:
        """As `Route` says."""
        return leading_eigenvalues(self.rod, force, kept)

    def marks(self, upper: float) -> Real:
        """As `Route` says: both ends of each of STATIC steps of equal size in √F on which one crosses.

        The wave number of a static mode goes with √F, and steady crossings are about as far apart in it.
        """
        force = upper * (np.arange(1, STATIC + 1) / STATIC) ** 2
        sign = np.array([static_sign(self.rod, f) for f in force])
        crossed = np.flatnonzero(sign[1:] != sign[:-1])
        return force[np.union1d(crossed, crossed + 1)]

    def unstable(self, force: float) -> int:
        """As `Route` says."""
        return unstable_count(self.rod, force)

    def settled(self, low: float, high: float) -> tuple[bool, float | None]:
        """As `Route` says: a real eigenvalue near 0, by the closed form of steady crossings."""
        if not kernels.is_uniform(self.rod.model):
            return False, None
        from rodwnl.steady import extremum  # mpmath, which few rods need here

        try:
            found = extremum(self.rod, (low + high) / 2)
        except (ComputationError, InputError):
            return False, None
        force = float(found.force)
        if not abs(force - (low + high) / 2) <= NEAR * force:
            return False, None
        if found.kind == "two crossings":
            if found.gap < RESOLVED * force:
                raise ComputationError(
                    f"near F = {force:.10g} a real eigenvalue crosses 0 twice, {2 * float(found.gap):.2g} "
                    f"apart: too close for double precision; search up to there (max_force)"
                )
            return False, None
        return True, force if found.kind == "touch" else None

    def threshold(self, low: float, high: float, force: float, omega: float) -> HopfThreshold:
        """As `Route` says. Raises ComputationError where Newton's method leaves the interval."""
        if omega == 0 and kernels.is_uniform(self.rod.model):
            return _steady(self.rod, low, high, force)
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


def _steady(rod: RodParameters, low: float, high: float, force: float) -> HopfThreshold:
    """A steady crossing by its closed form, which keeps all digits where two of them are close."""
    from rodwnl.steady import steady_force  # mpmath, which few rods need here

    force = float(steady_force(rod, force, DIGITS))
    if not low - (high - low) <= force <= high + (high - low):
        raise ComputationError(undecided(low, 0j))
    p, A_force, B_force = stepped(rod, force, nodes_at(rod, force, 0.0))
    pair = nearest(p, BESIDE_ZERO)
    u, v, lam = pair.left.conj(), pair.right, pair.eigenvalue
    slope = float((u @ (A_force - lam * B_force) @ v / (u @ p.B @ v)).real)
    return HopfThreshold(
        force, 0.0, complex(slope),
        unstable_below=-1, unstable_above=-1,  # until they are counted
        residual=abs(lam) / (force * abs(slope)), force_error=EPS * force, omega_error=0.0,
    )  # fmt: skip


def nodes_at(rod: RodParameters, force: float, omega: float) -> Nodes:
    """Nodes that resolve products of the modes: their number follows from the largest local wave number.

    Raises ComputationError where the boundary layers are too thin for MOST_NODES.
    """
    straight = straight_rod(rod, force)
    axial = straight("X2_operator", u=ENDS, lam=1j * omega) / straight("stretch_stiffness", u=ENDS)
    largest = max(wave_number(straight, 1j * omega), float(np.sqrt(np.max(np.abs(axial)))))
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
