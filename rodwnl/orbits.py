"""Periodic orbits of the full nonlinear rod: amplitude, frequency, harmonics, and their error."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from rodwnl.collocation import interpolation
from rodwnl.continuation import Point, root_at, solve_at
from rodwnl.cycles import PARITY, OrbitSystem
from rodwnl.errors import ComputationError
from rodwnl.halfperiod import half_period
from rodwnl.normalform import DiscreteRod, hopf_point
from rodwnl.strainform import RodLaw, integrals

Array = NDArray[np.float64]

Resolution = tuple[int, int]  # phases in half a period (even), degree in u

COARSE: Resolution = (8, 18)
FINEST: Resolution = (64, 80)  # 15700 unknowns: a Newton step takes 0.3 s and 0.2 GB
ACCURACY = 1e-9  # relative, of A_tip and ω
FLOOR = 1e-6  # of fields whose scale is 1
NEGLIGIBLE = 1e-6  # tail aimed at: what it changes in A_tip and ω is about a thousand times smaller


def highest(c: Array, s: Array) -> float:
    """The largest |Σ c_k cos kτ + s_k sin kτ| over odd k, refined by Newton's method."""
    k = np.arange(1.0, 2 * c.size, 2)

    def y(phase: Array, order: int) -> Array:
        angle = np.multiply.outer(phase, k) + order * np.pi / 2
        return np.asarray(np.cos(angle) @ (k**order * c) + np.sin(angle) @ (k**order * s))

    grid = np.linspace(0, np.pi, 16 * k.size)
    phase = grid[np.argmax(np.abs(y(grid, 0)))]
    for _ in range(4):
        curvature = y(phase, 2)
        if curvature:
            phase = phase - np.clip(y(phase, 1) / curvature, -grid[1], grid[1])
    return float(np.abs(y(phase, 0)))


def decay(slopes: Array) -> tuple[float, float]:
    """The highest harmonics and Chebyshev coefficients of slopes (m, 3, N+1), relative to the largest.

    A field that is nearly 0, as the stretch's slope is next to the Hopf point, counts as one of size FLOOR.
    """
    count, degree = slopes.shape[0], slopes.shape[2] - 1
    time = half_period(count)
    in_time = in_space = 0.0
    for i, parity in enumerate(PARITY):
        field, k = slopes[:, i], time.harmonics[parity]
        largest = max(float(np.abs(field).max()), FLOOR)
        high = np.concatenate([k, k[(k > 0) & (k < count)]]) >= count - 2
        harmonics = np.abs(time.series[parity] @ field).max(axis=1)
        mirrored = np.concatenate([field, field[:, -2:0:-1]], axis=1)
        powers = np.abs(np.fft.rfft(mirrored, axis=1)).max(axis=0) / degree
        in_time = max(in_time, float(harmonics[high].max() / largest))
        in_space = max(in_space, float(powers[-2:].max() / largest))
    return in_time, in_space


@dataclass(frozen=True)
class Cycle:
    """A solution of the orbit's equations on one grid; what is read off it is computed when asked for."""

    system: OrbitSystem
    X: Array

    @property
    def force(self) -> float:
        return float(self.X[-2])

    @property
    def omega(self) -> float:
        return float(self.X[-3])

    @property
    def square(self) -> float:
        """s = a², a the first harmonic of the tip's angle in radians."""
        return float(self.X[-1])

    def shape(self, phases: Array, points: Array | None = None) -> tuple[Array, Array, Array]:
        """x, y, θ at phases τ = ωt and points u (default: all nodes), (len(phases), len(points)) each."""
        x, y, theta = self.system.shape(self.X, phases)
        if points is None:
            return x, y, theta
        at = interpolation(self.system.degree, points).T
        return x @ at, y @ at, theta @ at

    @cached_property
    def tip_series(self) -> Array:
        """(2, K): cosine and sine coefficients of the tip's y(τ) for the odd harmonics 1, 3, …, 2K − 1."""
        fine = half_period(4 * self.system.count)
        series = fine.series["odd"] @ self.shape(fine.phases)[1][:, -1]
        return np.asarray(series.reshape(2, -1))

    @cached_property
    def tip_amplitude(self) -> float:
        """Half the peak-to-peak of the tip's y, that is the largest |y|, refined by Newton's method."""
        return highest(*self.tip_series)

    @cached_property
    def residual(self) -> float:
        """Largest defect of the equations relative to the largest velocity, by field."""
        defect, velocity = self.system.sizes(self.X)
        return float((defect / velocity).max())

    @cached_property
    def tails(self) -> tuple[float, float]:
        """The highest harmonics and Chebyshev coefficients of the slopes, relative to the largest."""
        return decay(self.system.slopes(self.X))


@dataclass(frozen=True)
class Orbit:
    """A periodic orbit; lengths in L, times in γ2 L⁴/k3, forces in k3/L².

    A_tip: half the peak-to-peak of the tip's y. error: relative change of A_tip or ω, the larger, by the
    last refinement. harmonics: amplitudes of the tip's y at ω, 3ω, 5ω, …. residual: see `Cycle`.
    multipliers: Floquet multipliers of the period without the trivial 1, largest first. multiplier_error:
    |μ − 1| of that one.
    """

    cycle: Cycle
    A_tip: float
    omega: float
    force: float
    harmonics: tuple[float, ...]
    residual: float
    error: float
    multipliers: tuple[complex, ...]
    multiplier_error: float
    stable: bool


@dataclass(frozen=True)
class Onset:
    """A Hopf point, where its branch begins: s = 0, tangent towards s > 0. tip_per_angle: A_tip/a there."""

    system: OrbitSystem
    point: Point
    tip_per_angle: float


def onset(law: RodLaw, force: float, omega: float, resolution: Resolution = COARSE) -> Onset:
    """The Hopf point nearest to this guess. Raises ComputationError where there is none."""
    count, degree = resolution
    rod, space = DiscreteRod(law, degree), integrals(degree)
    force, omega, mode, _ = hopf_point(rod, force, omega)  # the mode's tip displacement is 1
    system = OrbitSystem(law, count, degree, force, omega)
    bending = mode[2 * (degree + 1) : -3]  # its Π'
    angle = complex(mode[-1] - space.whole @ space.down @ bending)
    return Onset(system, solve_at(system, system.begin(mode / angle), -1, 0.0), 1 / abs(angle))


def needed(now: int, tail: float, target: float) -> int:
    """The even number at which a geometric tail would fall to the target, half to twice the present one."""
    wanted = now * np.log(target) / np.log(min(max(tail, 1e-15), 0.5))
    return int(2 * np.ceil(np.clip(wanted, now / 2, 2 * now) / 2))


def suited(cycle: Cycle, target: float = NEGLIGIBLE) -> Resolution:
    """The resolution at which the tails would fall to the target, from COARSE to FINEST."""
    now = cycle.system.count, cycle.system.degree
    wanted = [needed(number, tail, target) for number, tail in zip(now, cycle.tails, strict=True)]
    count, degree = np.clip(wanted, COARSE, FINEST)
    return int(count), int(degree)


def finer(cycle: Cycle) -> Resolution:
    """The suited resolution, but finer than the present one by 4 or more in each direction, within FINEST."""
    count, degree = suited(cycle)
    now = cycle.system
    return min(max(count, now.count + 4), FINEST[0]), min(max(degree, now.degree + 4), FINEST[1])


def regridded(cycle: Cycle, resolution: Resolution) -> tuple[OrbitSystem, Array]:
    """The system of this resolution and the cycle as a guess for it."""
    new = replace(cycle.system, count=resolution[0], degree=resolution[1])
    return new, cycle.system.resampled(cycle.X, new)


def orbit_at(guess: Cycle, force: float) -> Orbit:
    """The periodic orbit at this force, near the guess, refined until A_tip and ω settle.

    Raises ComputationError where Newton's method finds none or the finest grid does not suffice.
    """
    from rodwnl.floquet import multipliers

    cycle = _solved(guess.system, guess.X, force)
    while True:
        # Both numbers must rise, or the change says nothing about one of the two errors
        if cycle.system.count == FINEST[0] or cycle.system.degree == FINEST[1]:
            raise ComputationError(
                f"the orbit at force {force:.6g} is not resolved within {FINEST[0]} phases and degree "
                f"{FINEST[1]} (tails {cycle.tails[0]:.0e}, {cycle.tails[1]:.0e})"
            )
        system, X = regridded(cycle, finer(cycle))
        before, cycle = cycle, _solved(system, X, force)
        error = max(abs(before.tip_amplitude / cycle.tip_amplitude - 1), abs(before.omega / cycle.omega - 1))
        if error < ACCURACY:
            break
    floquet = multipliers(cycle)
    return Orbit(
        cycle=cycle,
        A_tip=cycle.tip_amplitude,
        omega=cycle.omega,
        force=force,
        harmonics=tuple(float(v) for v in np.hypot(*cycle.tip_series)[: cycle.system.count]),
        residual=cycle.residual,
        error=float(error),
        multipliers=tuple(complex(v) for v in floquet.full[:6]),
        multiplier_error=2 * floquet.error,
        stable=floquet.stable,
    )


def _solved(system: OrbitSystem, guess: Array, force: float) -> Cycle:
    cycle = Cycle(system, root_at(system, guess, -2, force))
    if cycle.square <= 0 or cycle.omega <= 0:
        raise ComputationError(
            f"no orbit of this branch at force {force:.10g}: the solution continued to there has a² = "
            f"{cycle.square:.3g} and frequency {cycle.omega:.6g}, but both must be positive"
        )
    return cycle
