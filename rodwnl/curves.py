"""Curves of Hopf thresholds as a parameter of the rod varies, and the special points on them.

A threshold is D(F, iω) = 0, two real equations for F, ω and a parameter p, so thresholds lie on curves in
(p, F, ω). They are followed by pseudo-arclength, hence through the points where they turn back. Special
points:

    bautin     Re α = 0: the flutter changes from super- to subcritical
    closing    Re β = 0: two thresholds of the same pair meet, and the window between them closes
    double     a second pair is on the imaginary axis at the same force

Each of the first two is one more equation, a double point two more with one more unknown: with a second
parameter they lie on curves themselves (`special_curve`). Unknowns are logarithms, so that steps and errors
are relative; a model's own parameters, which may be 0 or negative, are measured in units of their range.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from contextlib import suppress
from dataclasses import dataclass, replace
from itertools import pairwise
from typing import Literal

import numpy as np

from rodwnl import kernels
from rodwnl.batch_characteristic import Complex, Real, gradient
from rodwnl.batch_coefficients import EPS, Coefficients, coefficients
from rodwnl.batch_rods import Rods
from rodwnl.batch_spectrum import Index, lines
from rodwnl.continuation import ConvergenceError, Point, advance, locate, solve_at
from rodwnl.errors import ComputationError, InputError
from rodwnl.inverse import KEPT
from rodwnl.parameters import RodParameters
from rodwnl.spectrum import route_of
from rodwnl.straightrod import parameter_values

Kind = Literal["bautin", "closing", "double"]
Special = Literal["bautin", "closing"]

BASIC = ("k1", "k2", "gamma3", "gamma1")  # positive
FIRST_STEP, LONGEST_STEP, SHORTEST_STEP = 0.01, 0.05, 1e-7  # along a curve, in natural logarithms
MOST_POINTS = 2000
FLAT = 1e-4  # stretch at which a curve ends
AT_REST = 1e-4  # frequency, of that at the start, at which a curve ends: there a real eigenvalue would cross
DIFFERENCE = 1e-5  # relative, for derivatives of α and β by the unknowns: good to its square
BESIDE = 1e-7  # relative distance in force at which other unstable pairs are counted
PLACED, PLACED_ROUGHLY = 1e-12, 1e-9  # how exactly special points are placed: Newton's last step
MOST_STEPS = 20
APART = 1e-3  # of ω: eigenvalues closer than this to the critical one are it


@dataclass(frozen=True)
class Equations:
    """D(F, iω) = 0 for one or two ω, and maybe Re α = 0 or Re β = 0; see `rodwnl.continuation.System`.

    Unknowns: the varied parameters, each in its unit, or, where that is None, its logarithm; the logarithms
    of F and of each ω. rod: all parameters by name.
    """

    model: str
    rod: Mapping[str, float]
    vary: tuple[str, ...]
    units: tuple[float | None, ...]
    special: Special | None = None
    pairs: int = 1

    @property
    def scales(self) -> Real:
        return np.ones(len(self.vary) + 1 + self.pairs)

    @property
    def metric(self) -> Real:
        return self.scales

    def unknown(self, index: int, value: float) -> float:
        """The unknown that stands for this value of the varied parameter with this index."""
        unit = self.units[index]
        return float(np.log(value)) if unit is None else value / unit

    def start(self, force: float, *omegas: float) -> Real:
        """The unknowns at the parameters of the rod, this force and these frequencies."""
        own = [self.unknown(i, self.rod[name]) for i, name in enumerate(self.vary)]
        return np.array([*own, *np.log([force, *omegas])])

    def at(self, X: Real) -> tuple[Rods, Real, Real]:
        """Rods, force (n,) and frequencies (pairs, n) for unknowns (…, n)."""
        varied = {
            name: np.exp(x) if unit is None else x * unit
            for name, unit, x in zip(self.vary, self.units, X, strict=False)
        }
        whole = {name: np.full(X.shape[1], number) for name, number in self.rod.items()} | varied
        force, *omegas = np.exp(X[len(self.vary) :])
        return Rods(self.model, whole), force, np.array(omegas)

    @np.errstate(all="ignore")
    def linearised(self, X: Real) -> tuple[Real, Real]:
        rods, force, omegas = self.at(X[:, None])
        if not (force[0] > 0 and stretch(rods, force)[0] > 0):
            raise ConvergenceError(f"there is no straight rod at the force {force[0]:.6g} of an iterate")
        residuals, slopes = [], []
        for i, omega in enumerate(omegas):
            D, by = gradient(rods, self.vary, force, 1j * omega)
            size = np.abs(by[-1] * omega)  # |λ D_λ|: D/size is the relative distance of λ from iω
            row = np.zeros(len(X), dtype=complex)
            for j, (name, unit) in enumerate(zip(self.vary, self.units, strict=True)):
                row[j] = (by[j] * (rods.values[name] if unit is None else unit) / size)[0]
            row[len(self.vary)] = (by[-2] * force / size)[0]
            row[len(self.vary) + 1 + i] = (1j * by[-1] * omega / size)[0]
            value = complex((D / size)[0])
            residuals += [value.real, value.imag]
            slopes += [row.real, row.imag]
        if self.special:
            shifts = DIFFERENCE * np.eye(len(X))
            values = self.event(
                np.concatenate([X[:, None], X[:, None] + shifts, X[:, None] - shifts], axis=1)
            )
            residuals.append(values[0])
            slopes.append((values[1 : len(X) + 1] - values[len(X) + 1 :]) / (2 * DIFFERENCE))
        return np.array(residuals), np.array(slopes)

    def event(self, X: Real, kind: Special | None = None) -> Real:
        """Re α/ω or F Re β/ω, (n,) for unknowns (…, n): vanishes at a special point, and is smooth."""
        c, (_, force, omegas) = self.coefficients(X), self.at(X)
        number = c.alpha if (kind or self.special) == "bautin" else c.beta * force
        return np.asarray(number.real / omegas[0])

    def noise(self, X: Real, kind: Special) -> float:
        """The error of the event at one point (…, 1)."""
        c, (_, force, omegas) = self.coefficients(X), self.at(X)
        number = c.alpha if kind == "bautin" else c.beta * force
        return float(c.rounding[0] * np.abs(number[0]) / omegas[0, 0])

    @np.errstate(all="ignore")
    def coefficients(self, X: Real) -> Coefficients:
        """α and β of the first pair."""
        rods, force, omegas = self.at(X)
        return coefficients(rods, force, omegas[0])


def equations(
    rod: RodParameters, units: Mapping[str, float | None], special: Special | None = None
) -> Equations:
    """Equations with these parameters free. Raises InputError for a rod that is not uniform when straight."""
    if not kernels.is_uniform(rod.model):
        raise InputError(
            f"a curve of thresholds needs coefficients that are constant along the rod, which they are not "
            f"under the load of {rod.model_name!r}; `landau` and `sweep` take it"
        )
    return Equations(rod.model, parameter_values(rod), tuple(units), tuple(units.values()), special)


def unit(name: str, *values: float) -> float | None:
    """In what a parameter is measured that goes through these values: None for its logarithm."""
    return None if name in BASIC else max(max(values) - min(values), EPS)


def stretch(rods: Rods, force: Real) -> Real:
    """ν of the straight rods, NaN where there is none."""
    return np.asarray(rods.at(force).stretch(0.0)[0])


@dataclass(frozen=True)
class SpecialPoint:
    """A special point: rod are all parameters by name, omega2 the second pair's, at a double point.

    units: of the varied parameters, see `Equations`. error: estimated relative error of the varied parameter,
    force and ω.
    """

    type: Kind
    model: str
    rod: Mapping[str, float]
    units: Mapping[str, float | None]
    force: float
    omega: float
    omega2: float | None
    alpha: complex
    beta: complex
    error: float


@dataclass(frozen=True)
class Curve:
    """n points of a curve: rods (parameters by name), force, omega, alpha, beta, each (n,).

    omega2 (n,): on a curve of double points. others (n,): number of unstable pairs beside the critical one, a
    real eigenvalue counted as one. end: why it ends, in words.
    """

    vary: tuple[str, ...]
    rods: Mapping[str, Real]
    force: Real
    omega: Real
    omega2: Real | None
    alpha: Complex
    beta: Complex
    others: Index
    end: str


def threshold_curve(
    rod: RodParameters, name: str, start: tuple[float, float], stop: float
) -> tuple[Curve, tuple[SpecialPoint, ...]]:
    """The curve from the threshold `start` = (force, ω) of this rod as its parameter `name` goes to `stop`.

    It ends where the parameter is at `stop` or, having turned back, where it was at the start; where the
    straight rod comes to length 0, or the frequency to 0; or after MOST_POINTS. Raises ComputationError where
    it cannot be followed, InputError for a rod whose straight state is not uniform.
    """
    begin = parameter_values(rod)[name]
    system = equations(rod, {name: unit(name, begin, stop)})
    X = system.start(*start)
    first = solve_at(system, X, 0, X[0])
    if (stop < begin) != (first.tangent[0] < 0):
        first = _reversed(first)
    low, high = sorted([X[0], system.unknown(0, stop)])
    points, end = _follow(system, first, 0, (low, high))
    curve = _curve(system, points, end, {name: (begin, stop)})
    return curve, tuple(_special_points(system, points, curve))


def special_curve(point: SpecialPoint, vary: tuple[str, str], stop: float) -> Curve:
    """The curve of such points in a plane, from this one until the second parameter is at `stop`."""
    first_name, second = vary
    kind = point.type
    units = {first_name: point.units[first_name], second: unit(second, point.rod[second], stop)}
    double = kind == "double"
    system = Equations(
        point.model,
        point.rod,
        vary,
        tuple(units.values()),
        None if kind == "double" else kind,
        2 if double else 1,
    )
    X = system.start(point.force, point.omega, *([] if point.omega2 is None else [point.omega2]))
    first = solve_at(system, X, 1, X[1])
    if (stop < point.rod[second]) != (first.tangent[1] < 0):
        first = _reversed(first)
    low, high = sorted([X[1], system.unknown(1, stop)])
    points, end = _follow(system, first, 1, (low, high))
    return _curve(system, points, end, {second: (point.rod[second], stop)})


def special_point(
    kind: Special, rod: RodParameters, units: Mapping[str, float | None], force: float, omega: float
) -> SpecialPoint:
    """The special point near this (force, ω), one parameter being free. Raises ComputationError."""
    system = equations(rod, units, kind)
    X = system.start(force, omega)
    for _ in range(2 * MOST_STEPS):
        step, J = _newton_step(system, X)
        X = X + step * min(1, LONGEST_STEP / np.max(np.abs(step)))
        if np.max(np.abs(step)) < PLACED_ROUGHLY:
            c = system.coefficients(X[:, None])
            noise = np.array([EPS, EPS, system.noise(X[:, None], kind)])
            error = float(np.linalg.norm(np.linalg.inv(J) * noise, 2)) + PLACED
            return _record(system, kind, X, c, error)
    raise ConvergenceError(f"Newton's iteration for a {kind} point near force {force:.6g} did not settle")


def _newton_step(system: Equations, X: Real) -> tuple[Real, Real]:
    """Step and Jacobian, of as many equations as unknowns. Raises ConvergenceError where it is singular."""
    G, J = system.linearised(X)
    try:
        step = np.asarray(np.linalg.solve(J, -G), dtype=float)
    except np.linalg.LinAlgError:
        step = np.full_like(X, np.nan)
    if not np.all(np.isfinite(step)):
        raise ConvergenceError("Newton's iteration met a singular Jacobian")
    return step, J


def _reversed(point: Point) -> Point:
    return replace(point, tangent=-point.tangent)


def _follow(
    system: Equations, first: Point, along: int, limits: tuple[float, float]
) -> tuple[list[Point], str]:
    """Points until the unknown `along` leaves its limits, the last one there."""
    points, step = [first], FIRST_STEP
    while len(points) < MOST_POINTS:
        try:
            new, _, wanted = advance(system, points[-1], step, SHORTEST_STEP)
        except ComputationError as error:
            if len(points) == 1:
                raise ComputationError(
                    f"the curve cannot be followed from its first point: {error}"
                ) from None
            return points, f"it cannot be followed further: {error}"
        step = min(wanted, LONGEST_STEP)
        last = points[-1].X
        for limit in limits:
            if (new.X[along] - limit) * (last[along] - limit) < 0 or new.X[along] == limit:
                between = (limit - last[along]) / (new.X[along] - last[along])
                points.append(solve_at(system, last + between * (new.X - last), along, limit))
                name = system.vary[along]
                value = system.at(points[-1].X[:, None])[0].values[name][0]
                return points, f"{name} is {value:.10g}"
        points.append(new)
        rods, force, omegas = system.at(new.X[:, None])
        if stretch(rods, force)[0] < FLAT:
            return points, "the straight rod comes to length 0"
        if omegas.min() < AT_REST * np.exp(first.X[len(system.vary) + 1 :]).min():
            return points, "the frequency comes to 0"
        if len(points) > 10 and np.linalg.norm(new.X - first.X) < step / 2:
            return points, "it is closed"
    return points, f"{MOST_POINTS} points were computed"


def _curve(
    system: Equations, points: list[Point], end: str, bounds: Mapping[str, tuple[float, float]]
) -> Curve:
    """The record of these points; bounds: from where to where a parameter was asked to vary."""
    X = np.array([point.X for point in points]).T
    rods, force, omegas = system.at(X)
    c = system.coefficients(X)
    # unstable eigenvalues on both sides of the threshold: the smaller number is without the critical pair
    both = np.concatenate([force * (1 - BESIDE), force * (1 + BESIDE)])
    number = np.arange(len(points))
    with np.errstate(all="ignore"):
        unstable = lines(rods, np.concatenate([number, number]), both).unstable.reshape(2, -1)
    omega2 = omegas[1] if len(omegas) > 1 else None
    values = dict(rods.values)
    for name, ends in bounds.items():  # exp(log x) is x up to rounding
        for bound in ends:
            values[name] = np.where(
                np.abs(values[name] - bound) <= 100 * EPS * abs(bound), bound, values[name]
            )
    others = (unstable.min(axis=0) + 1) // 2
    return Curve(system.vary, values, force, omegas[0], omega2, c.alpha, c.beta, others, end)


def _special_points(system: Equations, points: list[Point], curve: Curve) -> Iterator[SpecialPoint]:
    """Between neighbouring points where Re α or Re β changes its sign, or the number of other pairs."""
    for i, (point, after) in enumerate(pairwise(points)):
        kinds: list[tuple[Special, Complex]] = [("bautin", curve.alpha), ("closing", curve.beta)]
        for kind, numbers in kinds:
            if numbers[i].real * numbers[i + 1].real < 0:
                found = _placed(system, kind, point, after)
                if found:
                    yield found
        if curve.others[i] != curve.others[i + 1]:
            double = _double(system, point, float(np.linalg.norm(after.X - point.X)), float(curve.omega[i]))
            if double:
                yield double


def _placed(system: Equations, kind: Special, point: Point, after: Point) -> SpecialPoint | None:
    """The point where Re α or Re β vanishes; None where it changes its sign through infinity.

    Where it cannot be refined, the one in between that the two suggest, with their distance as its error.
    """

    def event(p: Point) -> float:
        return float(system.event(p.X[:, None], kind)[0])

    length = float(np.linalg.norm(after.X - point.X))
    before, behind = event(point), event(after)
    weight, largest = before / (before - behind), max(abs(before), abs(behind))
    try:
        along = float(point.tangent @ (after.X - point.X))
        placed, _ = locate(system, point, event, along * weight, PLACED, along)
        error = system.noise(placed.X[:, None], kind) * length / abs(behind - before) + PLACED
        largest *= DIFFERENCE
    except ConvergenceError:
        placed, error = replace(point, X=point.X + weight * (after.X - point.X)), length
    if abs(event(placed)) > largest:
        return None
    return _record(system, kind, placed.X, system.coefficients(placed.X[:, None]), error)


def _double(system: Equations, point: Point, length: float, omega: float) -> SpecialPoint | None:
    """The double point near this one: the second pair is the one nearest to the imaginary axis.

    None where it is a real eigenvalue that is nearest. Where it cannot be refined, this point, with the
    distance to the next one as its error.
    """
    rods, force, _ = system.at(point.X[:, None])
    eigenvalues, _ = route_of(rods.one(0)).leading(force, KEPT)
    other = eigenvalues[0][(eigenvalues[0].imag >= 0) & (np.abs(eigenvalues[0] - 1j * omega) > APART * omega)]
    if not other.size:
        return None
    nearest = other[np.argmin(np.abs(other.real))]
    if nearest.imag == 0:
        return None
    both = replace(system, pairs=2)
    X = rough = np.append(point.X, np.log(nearest.imag))
    with suppress(ConvergenceError):
        for _ in range(MOST_STEPS):
            step, J = _newton_step(both, X)
            X = X + step
            if np.max(np.abs(step)) < PLACED:
                error = float(np.linalg.norm(np.linalg.inv(J), 2)) * 1e-15 + PLACED
                return _record(both, "double", X, both.coefficients(X[:, None]), error)
    return _record(both, "double", rough, both.coefficients(rough[:, None]), length)


def _record(system: Equations, kind: Kind, X: Real, c: Coefficients, error: float) -> SpecialPoint:
    rods, force, omegas = system.at(X[:, None])
    return SpecialPoint(
        kind, system.model, {name: float(x[0]) for name, x in rods.values.items()},
        dict(zip(system.vary, system.units, strict=True)), float(force[0]), float(omegas[0, 0]),
        omega2=float(omegas[1, 0]) if len(omegas) > 1 else None,
        alpha=complex(c.alpha[0]), beta=complex(c.beta[0]), error=error,
    )  # fmt: skip
