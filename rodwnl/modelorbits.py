"""Periodic orbits of the full nonlinear rod of any law, at one force.

As `cycles` does for the plain rod, by Fourier × Chebyshev collocation over half a period, after which an
orbit repeats itself mirrored; but on E w_t = R(w, F) as a law gives it (`strainform`, `normalform`), whose
exact derivatives Newton's method takes:

    ω E ∂τ w = R(w, F),    first harmonic of the tip's angle = a cos τ.

h1 has even harmonics of τ = ωt, h2 and Π odd ones. The straight rod under any force is the solution a = 0, so
that a branch is begun at a finite a, and an orbit is only accepted with a > 0.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from rodwnl.collocation import chebyshev, interpolation
from rodwnl.continuation import ConvergenceError, Point, advance, solve_at
from rodwnl.cycles import PARITY, half_period
from rodwnl.emittedlaw import emitted_law
from rodwnl.errors import ComputationError, InputError
from rodwnl.floquet import STEPS, Multipliers, carried, of_map, stage_phases
from rodwnl.nilpotent import nilpotent
from rodwnl.normalform import _Discrete, normal_form
from rodwnl.orbits import ACCURACY, FINEST, Resolution, decay, finer, highest
from rodwnl.parameters import Number, RodParameters
from rodwnl.predictions import Prediction, predict
from rodwnl.strainform import RodLaw, integrals, strains, tip

Array = NDArray[np.float64]

START: Resolution = (8, 22)
FIRST_ANGLE = 0.05  # a, in radians, at which a branch is begun unless its orbit is expected below twice that
LONGEST_STEP, SHORTEST_STEP = 0.25, 1e-5  # in (F/F_c, ω/ω_c, a)
MOST_POINTS = 60
SAME = 1e-6  # relative difference in ω below which two branches have led to one orbit
ROUGH = 1e-3  # tail beyond which a branch is continued on a finer grid


@dataclass(frozen=True)
class LawSystem:
    """The equations on m phases × (N + 1) points, for `continuation`: X = (states, ω, F, a), states (m, size)
    as `normalform` strings them.

    force_scale, omega_scale: those of the Hopf point. angle: about the a that is looked for, against which
    Newton's steps are measured.
    """

    law: RodLaw
    count: int
    degree: int
    force_scale: float
    omega_scale: float
    angle: float

    @cached_property
    def rod(self) -> _Discrete:
        return _Discrete(self.law, self.degree)

    @cached_property
    def parities(self) -> list[str]:
        """Of every entry of a state."""
        return [*np.repeat(PARITY, self.degree + 1), *PARITY]

    @cached_property
    def tip_angle(self) -> Array:
        """(size,): a state -> θ(1) = ∫₀¹ Π du, Π = Π(1) − ∫ᵤ¹ Π'."""
        space, n = integrals(self.degree), self.degree + 1
        row = np.zeros(self.rod.size)
        row[2 * n : 3 * n], row[-1] = -space.whole @ space.down, 1.0
        return row

    @property
    def scales(self) -> Array:
        states = np.full(self.count * self.rod.size, self.angle)
        return np.append(states, [self.omega_scale, self.force_scale, self.angle])

    @property
    def metric(self) -> Array:
        states = np.zeros(self.count * self.rod.size)
        return np.append(states, [self.omega_scale**-2, self.force_scale**-2, 1.0])

    def unpack(self, X: Array) -> tuple[Array, float, float, float]:
        """states (m, size), ω, F, a."""
        return X[:-3].reshape(self.count, -1), float(X[-3]), float(X[-2]), float(X[-1])

    def at(self, X: Array, phases: Array) -> Array:
        """States at other phases, (len(phases), size)."""
        return _by_parity(
            self.parities, {p: half_period(self.count).at(p, phases) for p in set(PARITY)}, self.unpack(X)[0]
        )

    def resampled(self, X: Array, resolution: Resolution) -> tuple[LawSystem, Array]:
        """The system of another resolution, and the same orbit as an unknown of it."""
        other = replace(self, count=resolution[0], degree=resolution[1])
        states = self.at(X, half_period(other.count).phases)
        space = interpolation(self.degree, chebyshev(other.degree).nodes)
        slopes = states[:, :-3].reshape(-1, 3, self.degree + 1) @ space.T
        states = np.hstack([slopes.reshape(other.count, -1), states[:, -3:]])
        return other, np.append(states.ravel(), X[-3:])

    def linearised(self, X: Array) -> tuple[Array, Array]:
        """G(X) and ∂G/∂X: the equations at all phases, then amplitude and phase of the tip's angle."""
        states, omega, force, a = self.unpack(X)
        m, n = states.shape
        E, first = self.rod.mass, self._first_harmonic
        inertia = _by_parity(self.parities, half_period(m).derivative, states) @ E.T
        G = np.append(
            omega * inertia - self.rod.derivative(states, force), np.tensordot(first, states, 2) - [a, 0.0]
        )
        J = np.zeros((m * n + 2, m * n + 3))
        J[:-2, :-3] = omega * self._inertia
        J[:-2, -3] = inertia.ravel()
        J[:-2, -2] = -self.rod.derivative(states, force, (np.zeros_like(states), 1.0)).ravel()
        J[-2:, :-3] = first.reshape(2, -1)
        J[-2, -1] = -1.0
        for j, block in enumerate(self.jacobians(states, force)):
            J[j * n : (j + 1) * n, j * n : (j + 1) * n] -= block
        return G, J

    def jacobians(self, states: Array, force: float) -> Array:
        """∂R/∂w at states (k, size): (k, size, size)."""
        directions = np.eye(states.shape[1])[None], 0.0
        return np.swapaxes(self.rod.derivative(states[:, None], force, directions), 1, 2)

    @cached_property
    def _inertia(self) -> Array:
        """E ∂τ, (m·size, m·size)."""
        D = np.stack([half_period(self.count).derivative[p] for p in self.parities], axis=-1)
        size = self.count * self.rod.size
        return np.asarray(np.einsum("jkc,rc->jrkc", D, self.rod.mass).reshape(size, size))

    @cached_property
    def _first_harmonic(self) -> Array:
        """(2, m, size): states -> cosine and sine coefficient of the first harmonic of the tip's angle."""
        time = half_period(self.count)
        first = time.series["odd"][[0, time.harmonics["odd"].size]]
        return np.asarray(first[:, :, None] * self.tip_angle)


@dataclass(frozen=True)
class LawCycle:
    """A solution of these equations on one grid."""

    system: LawSystem
    X: Array

    @property
    def force(self) -> float:
        return float(self.X[-2])

    @property
    def omega(self) -> float:
        return float(self.X[-3])

    @cached_property
    def tip_series(self) -> Array:
        """(2, K): cosine and sine coefficients of the tip's y(τ) for the odd harmonics 1, 3, …, 2K − 1."""
        fine, rod = half_period(4 * self.system.count), self.system.rod
        states = nilpotent(self.system.at(self.X, fine.phases))
        series = fine.series["odd"] @ tip(*rod._split(states), rod.degree)[1].part()
        return np.asarray(series.reshape(2, -1))

    @cached_property
    def tip_amplitude(self) -> float:
        """Half the peak-to-peak of the tip's y, that is the largest |y|."""
        return highest(*self.tip_series)

    @cached_property
    def residual(self) -> float:
        """Largest defect of the compatibility relative to the largest velocity, by field."""
        G, _ = self.system.linearised(self.X)
        states, _, force, _ = self.system.unpack(self.X)

        def fields(values: Array) -> Array:
            largest = np.abs(values.reshape(states.shape)[:, :-3])
            return np.asarray(largest.reshape(len(states), 3, -1).max(axis=(0, 2)))

        return float((fields(G[:-2]) / fields(self.system.rod.derivative(states, force))).max())

    @cached_property
    def tails(self) -> tuple[float, float]:
        """The highest harmonics and Chebyshev coefficients of the strains, relative to the largest."""
        rod = self.system.rod
        split = rod._split(nilpotent(self.system.unpack(self.X)[0]))
        return decay(np.stack([z.part() for z in strains(*split, rod.degree)], axis=1))


@dataclass(frozen=True)
class LawOrbit:
    """A periodic orbit of any rod; the fields are those of `orbits.Orbit`."""

    cycle: LawCycle
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
class LawOrbits:
    """Orbits of any rod at a force, stable ones first, then by falling amplitude.

    failures: what came in the way of following a branch that the amplitude equation predicts here.
    """

    force: float
    straight_stable: bool
    orbits: tuple[LawOrbit, ...]
    failures: tuple[str, ...]


def model_orbits(rod: RodParameters, force: Number, every: bool = False) -> LawOrbits:
    """The orbits at this force on the branches that the amplitude equation says to exist there.

    Where the straight rod is unstable, the first that is found, from the nearest threshold on; with `every`,
    and where the straight rod is stable, one for each of these branches. What a branch reaches only beyond a
    fold, on the other side of its threshold, is not looked for.
    Raises InputError for a force without straight state, or where no branch is predicted, and
    ComputationError where no predicted orbit is found.
    """
    from rodwnl.collocated import unstable_count

    at = float(rod.checked_force(force))
    predictions = predict(rod, force)
    here = sorted((p for p in predictions if p.exists), key=lambda p: abs(p.coefficients.force - at))
    if not here:
        raise InputError(_none(rod, at, predictions))
    stable = unstable_count(rod, at) == 0
    law = emitted_law(rod)
    orbits: list[LawOrbit] = []
    failures: list[str] = []
    for prediction in here:
        try:
            orbit = orbit_of(law, prediction)
        except ComputationError as error:
            failures.append(f"the branch from force {prediction.coefficients.force:.10g}: {error}")
            continue
        if all(abs(orbit.omega / other.omega - 1) > SAME for other in orbits):
            orbits.append(orbit)
        if not stable and not every:
            break
    if not orbits:
        raise ComputationError(f"no orbit was found at force {at:.10g}: {'; '.join(failures)}")
    orbits.sort(key=lambda orbit: (not orbit.stable, -orbit.A_tip))
    return LawOrbits(at, stable, tuple(orbits), tuple(failures))


def _none(rod: RodParameters, at: float, predictions: tuple[Prediction, ...]) -> str:
    sides = [f"{p.side or 'undecided about'} {p.coefficients.force:.10g}" for p in predictions]
    lie = f"its branches lie {', '.join(sides)}" if sides else "it has no Hopf threshold"
    return f"rod {rod.model_name!r} has no orbit at force {at:.10g} by the amplitude equation: {lie}"


def orbit_of(law: RodLaw, prediction: Prediction) -> LawOrbit:
    """The orbit at the prediction's force on the branch from its threshold, refined until A_tip and ω settle.

    Raises ComputationError where the branch does not lead there or the finest grid does not suffice.
    """
    cycle = _followed(law, prediction)
    while True:
        if (cycle.system.count, cycle.system.degree) == FINEST:
            raise ComputationError(
                f"the orbit is not resolved by {FINEST[0]} phases and degree {FINEST[1]} "
                f"(tails {cycle.tails[0]:.0e}, {cycle.tails[1]:.0e})"
            )
        before, cycle = cycle, _solved(*cycle.system.resampled(cycle.X, finer(cycle)), prediction.force)
        error = max(abs(before.tip_amplitude / cycle.tip_amplitude - 1), abs(before.omega / cycle.omega - 1))
        if error < ACCURACY:
            break
    floquet = law_multipliers(cycle)
    return LawOrbit(
        cycle=cycle,
        A_tip=cycle.tip_amplitude,
        omega=cycle.omega,
        force=cycle.force,
        harmonics=tuple(float(v) for v in np.hypot(*cycle.tip_series)[: cycle.system.count]),
        residual=cycle.residual,
        error=float(error),
        multipliers=tuple(complex(v) for v in floquet.full[:6]),
        multiplier_error=2 * floquet.error,
        stable=floquet.stable,
    )


def law_multipliers(cycle: LawCycle, steps: int = STEPS) -> Multipliers:
    """The Floquet multipliers; the strains' algebraic conditions add multipliers 0 (see `floquet`)."""
    system = cycle.system
    states = system.at(cycle.X, stage_phases(steps))
    A = system.jacobians(states, cycle.force)
    mirror = np.where(np.array(system.parities) == "even", 1.0, -1.0)
    return of_map(mirror[:, None] * carried(system.rod.mass, A, cycle.omega))


def _followed(law: RodLaw, prediction: Prediction) -> LawCycle:
    """The branch from its threshold to the prediction's force, on grids that suit stepping."""
    c, force = prediction.coefficients, prediction.force
    system, point, step = _begun(law, prediction)
    for _ in range(MOST_POINTS):
        before = point
        if (before.X[-2] - force) * (c.force - force) <= 0:  # the begun orbit lies beyond already
            return _solved(system, before.X, force)
        system = replace(system, angle=abs(before.X[-1]))
        point, _, step = advance(system, before, step, SHORTEST_STEP)
        step = min(step, LONGEST_STEP)
        if (point.X[-2] - force) * (before.X[-2] - force) <= 0:
            share = (force - before.X[-2]) / (point.X[-2] - before.X[-2])
            return _solved(system, before.X + share * (point.X - before.X), force)
        cycle = LawCycle(system, point.X)
        if max(cycle.tails) > ROUGH:
            resolution = finer(cycle)
            if resolution == (system.count, system.degree):
                raise ConvergenceError(f"no grid resolves the orbit at force {cycle.force:.6g} on the way")
            system, X = system.resampled(point.X, resolution)
            new = solve_at(system, X, -1, float(X[-1]))
            sign = np.sign((system.metric[-3:] * point.tangent[-3:]) @ new.tangent[-3:])
            point = replace(new, tangent=sign * new.tangent)
    raise ConvergenceError(f"after {MOST_POINTS} orbits the branch was only at force {point.X[-2]:.6g}")


def _begun(law: RodLaw, prediction: Prediction) -> tuple[LawSystem, Point, float]:
    """The first orbit of the branch, from the critical mode, the tangent towards larger ones, and a step."""
    c = prediction.coefficients
    count, degree = START
    form = normal_form(law, c.force, c.omega, degree)
    system = LawSystem(law, count, degree, form.force, form.omega, 1.0)
    mode = np.exp(1j * half_period(count).phases)[:, None] * form.mode
    angle = complex(system.tip_angle @ form.mode)  # for a tip displacement of 1
    expected = abs(angle) * (prediction.A_tip or FIRST_ANGLE)
    a = min(FIRST_ANGLE, expected / 2)
    amplitude = a / abs(angle)  # of the tip
    detuning = amplitude**2 / c.A_tip2_slope
    force = form.force + detuning
    waves = (mode * (np.exp(-1j * np.angle(angle)) * amplitude)).real
    states = system.rod.straight(force) + waves
    X = np.append(states.ravel(), [form.omega + c.omega_slope * detuning, force, a])
    system = replace(system, angle=a)
    return system, solve_at(system, X, -1, a), a


def _solved(system: LawSystem, guess: Array, force: float) -> LawCycle:
    """Newton's method at this force. Raises ComputationError where it fell back to the straight rod."""
    system = replace(system, angle=abs(float(guess[-1])))
    X = solve_at(system, guess, -2, force).X
    if not (X[-1] > 1e-3 * guess[-1] > 0 and X[-3] > 0):
        raise ComputationError(
            f"Newton's method fell back to the straight rod at force {force:.10g} (amplitude {X[-1]:.1e})"
        )
    return LawCycle(system, X)


def _by_parity(parities: list[str], matrices: dict[str, Any], states: Array) -> Array:
    """Every entry of the states (m, size) taken through the matrix (k, m) of its parity: (k, size)."""
    odd = np.array(parities) == "odd"
    return np.asarray(np.where(odd, matrices["odd"] @ states, matrices["even"] @ states))
