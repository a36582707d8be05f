"""Curves of Hopf thresholds as a parameter of the rod varies, and the special points on them.

A threshold is D(F, iω) = 0, two real equations for F, ω and a parameter p, so thresholds lie on curves in
(p, F, ω). They are followed by pseudo-arclength, hence through the points where they turn back. Special
points:

    bautin     Re α = 0: the flutter changes from super- to subcritical
    closing    Re β = 0: two thresholds of the same pair meet, and the window between them closes
    double     a second pair is on the imaginary axis at the same force

Each of the first two is one more equation, a double point two more with one more unknown: with a second
parameter they lie on curves themselves (`special_curve`). Unknowns are logarithms, so that steps and errors
are relative.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace
from itertools import pairwise
from typing import Literal

import numpy as np

from rodwnl.batch_characteristic import Complex, Real, gradient
from rodwnl.batch_coefficients import EPS, Coefficients, coefficients
from rodwnl.batch_spectrum import Index, lines
from rodwnl.continuation import ConvergenceError, Point, advance, locate, solve_at
from rodwnl.errors import ComputationError
from rodwnl.inverse import leading_eigenvalues

Kind = Literal["bautin", "closing", "double"]
Special = Literal["bautin", "closing"]

NAMES = ("k1", "k2", "gamma3", "gamma1")
FIRST_STEP, LONGEST_STEP, SHORTEST_STEP = 0.01, 0.05, 1e-7  # along a curve, in natural logarithms
MOST_POINTS = 2000
AT_K1 = 1e-4  # relative distance of the force from k1 at which a curve ends
DIFFERENCE = 1e-5  # relative, for derivatives of α and β by the unknowns: good to its square
BESIDE = 1e-7  # relative distance in force at which other unstable pairs are counted
PLACED, PLACED_ROUGHLY = (
    1e-12,
    1e-9,
)  # how exactly special points are placed; by Newton's method, its last step
MOST_STEPS = 20
APART = 1e-3  # of ω: eigenvalues closer than this to the critical one are it


@dataclass(frozen=True)
class Equations:
    """D(F, iω) = 0 for one or two ω, and maybe Re α = 0 or Re β = 0; see `rodwnl.continuation.System`.

    Unknowns: the logarithms of the varied parameters, of F and of each ω.
    """

    rod: tuple[float, float, float, float]
    vary: tuple[int, ...]
    special: Special | None = None
    pairs: int = 1

    @property
    def scales(self) -> Real:
        return np.ones(len(self.vary) + 1 + self.pairs)

    @property
    def metric(self) -> Real:
        return self.scales

    def at(self, X: Real) -> tuple[Real, Real, Real]:
        """Rod (4, n), force (n,) and frequencies (pairs, n) for unknowns (…, n)."""
        values = np.exp(X)
        rods = np.repeat(np.array(self.rod)[:, None], X.shape[1], axis=1)
        rods[list(self.vary)] = values[: len(self.vary)]
        return rods, values[len(self.vary)], values[len(self.vary) + 1 :]

    def linearised(self, X: Real) -> tuple[Real, Real]:
        rods, force, omegas = self.at(X[:, None])
        if _outside(force[0], rods[0, 0]):
            raise ConvergenceError(f"the iteration left 0 < force < k1, to force {force[0]:.6g}")
        residuals, slopes = [], []
        for i, omega in enumerate(omegas):
            D, by = gradient(tuple(rods[:3]), force, 1j * omega)
            size = np.abs(by[4] * omega)  # |λ D_λ|: D/size is the relative distance of λ from iω
            row = np.zeros(len(X), dtype=complex)
            for j, p in enumerate(self.vary):
                row[j] = (by[p] * rods[p] / size)[0] if p < 3 else 0  # γ1 is not in the linear problem
            row[len(self.vary)] = (by[3] * force / size)[0]
            row[len(self.vary) + 1 + i] = (1j * by[4] * omega / size)[0]
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

    def coefficients(self, X: Real) -> Coefficients:
        """α and β of the first pair."""
        (k1, k2, gamma3, gamma1), force, omegas = self.at(X)
        return coefficients((k1, k2, gamma3, gamma1), force, omegas[0])


def _outside(force: float, k1: float) -> bool:
    """Whether there is no straight rod at this force."""
    return not 0 < force < k1


@dataclass(frozen=True)
class SpecialPoint:
    """A special point: rod is (k1, k2, gamma3, gamma1), omega2 the second pair's, at a double point.

    error: estimated relative error of the varied parameter, force and ω.
    """

    type: Kind
    rod: tuple[float, float, float, float]
    force: float
    omega: float
    omega2: float | None
    alpha: complex
    beta: complex
    error: float


@dataclass(frozen=True)
class Curve:
    """n points of a curve: rods (4, n), force, omega, alpha, beta (n,).

    omega2 (n,): on a curve of double points. others (n,): number of unstable pairs beside the critical one.
    end: why it ends, in words.
    """

    vary: tuple[str, ...]
    rods: Real
    force: Real
    omega: Real
    omega2: Real | None
    alpha: Complex
    beta: Complex
    others: Index
    end: str


def threshold_curve(
    rod: tuple[float, float, float, float], name: str, start: tuple[float, float], stop: float
) -> tuple[Curve, tuple[SpecialPoint, ...]]:
    """The curve from the threshold `start` = (force, ω) of this rod as its parameter `name` goes to `stop`.

    It ends where the parameter is at `stop` or, having turned back, where it was at the start; where the
    force comes to 0 or k1; or after MOST_POINTS. Raises ComputationError where it cannot be followed.
    """
    index = NAMES.index(name)
    system = Equations(rod, (index,))
    first = solve_at(system, np.log([rod[index], *start]), 0, np.log(rod[index]))
    if (stop < rod[index]) != (first.tangent[0] < 0):
        first = _reversed(first)
    low, high = sorted([np.log(rod[index]), np.log(stop)])
    points, end = _follow(system, first, 0, (low, high), name)
    curve = _curve(system, points, (name,), end)
    return curve, tuple(_special_points(system, points, curve))


def special_curve(point: SpecialPoint, vary: tuple[str, str], stop: float) -> Curve:
    """The curve of such points in a plane, from this one until the second parameter is at `stop`."""
    indices = tuple(NAMES.index(name) for name in vary)
    kind = point.type
    system = Equations(point.rod, indices, None if kind == "double" else kind, 2 if kind == "double" else 1)
    omegas = [point.omega] if point.omega2 is None else [point.omega, point.omega2]
    X = np.log([*(point.rod[i] for i in indices), point.force, *omegas])
    first = solve_at(system, X, 1, X[1])
    if (stop < point.rod[indices[1]]) != (first.tangent[1] < 0):
        first = _reversed(first)
    low, high = sorted([X[1], np.log(stop)])
    points, end = _follow(system, first, 1, (low, high), vary[1])
    return _curve(system, points, vary, end)


def special_point(
    kind: Special, rod: tuple[float, float, float, float], name: str, force: float, omega: float
) -> SpecialPoint:
    """The special point near this (force, ω), the parameter `name` being free. Raises ComputationError."""
    system = Equations(rod, (NAMES.index(name),), kind)
    X = np.log([rod[system.vary[0]], force, omega])
    for _ in range(2 * MOST_STEPS):
        G, J = system.linearised(X)
        step = np.linalg.solve(J, -G)
        X = X + step * min(1, LONGEST_STEP / np.max(np.abs(step)))
        if np.max(np.abs(step)) < PLACED_ROUGHLY:
            c = system.coefficients(X[:, None])
            noise = np.array([EPS, EPS, system.noise(X[:, None], kind)])
            error = float(np.linalg.norm(np.linalg.inv(J) * noise, 2)) + PLACED
            return _record(system, kind, X, c, error)
    raise ConvergenceError(f"Newton's iteration for a {kind} point near force {force:.6g} did not settle")


def _reversed(point: Point) -> Point:
    return replace(point, tangent=-point.tangent)


def _follow(
    system: Equations, first: Point, along: int, limits: tuple[float, float], name: str
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
                return points, f"{name} is {np.exp(limit):.10g}"
        points.append(new)
        rods, force, _ = system.at(new.X[:, None])
        if force[0] > (1 - AT_K1) * rods[0, 0]:
            return points, "the force comes to k1"
        if len(points) > 10 and np.linalg.norm(new.X - first.X) < step / 2:
            return points, "it is closed"
    return points, f"{MOST_POINTS} points were computed"


def _curve(system: Equations, points: list[Point], vary: tuple[str, ...], end: str) -> Curve:
    X = np.array([point.X for point in points]).T
    rods, force, omegas = system.at(X)
    c = system.coefficients(X)
    # unstable pairs on both sides of the threshold: the smaller number does not contain the critical pair
    both = np.concatenate([force * (1 - BESIDE), np.minimum(force * (1 + BESIDE), rods[0])])
    number = np.arange(len(points))
    pairs = lines(tuple(rods[:3]), np.concatenate([number, number]), both).pairs.reshape(2, -1)
    omega2 = omegas[1] if len(omegas) > 1 else None
    return Curve(vary, rods, force, omegas[0], omega2, c.alpha, c.beta, pairs.min(axis=0), end)


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
            yield _double(system, point, float(curve.omega[i]))


def _placed(system: Equations, kind: Special, point: Point, after: Point) -> SpecialPoint | None:
    """The point where Re α or Re β vanishes; None where it changes its sign through infinity."""

    def event(p: Point) -> float:
        return float(system.event(p.X[:, None], kind)[0])

    length = float(np.linalg.norm(after.X - point.X))
    before, behind = event(point), event(after)
    placed, _ = locate(system, point, event, length * before / (before - behind), PLACED)
    if abs(event(placed)) > DIFFERENCE * max(abs(before), abs(behind)):
        return None
    c = system.coefficients(placed.X[:, None])
    error = system.noise(placed.X[:, None], kind) * length / abs(behind - before) + PLACED
    return _record(system, kind, placed.X, c, error)


def _double(system: Equations, point: Point, omega: float) -> SpecialPoint:
    """The double point near this one: the second pair is the one nearest to the imaginary axis."""
    rods, force, _ = system.at(point.X[:, None])
    eigenvalues, _ = leading_eigenvalues(tuple(rods[:, 0].tolist()), force)
    other = eigenvalues[0][(eigenvalues[0].imag > 0) & (np.abs(eigenvalues[0] - 1j * omega) > APART * omega)]
    if not other.size:
        raise ComputationError(f"no second pair was found near force {force[0]:.6g}")
    both = replace(system, pairs=2)
    X = np.append(point.X, np.log(other[np.argmin(np.abs(other.real))].imag))
    for _ in range(MOST_STEPS):
        G, J = both.linearised(X)
        step = np.linalg.solve(J, -G)
        X = X + step
        if np.max(np.abs(step)) < PLACED:
            error = float(np.linalg.norm(np.linalg.inv(J), 2)) * 1e-15 + PLACED
            return _record(both, "double", X, both.coefficients(X[:, None]), error)
    raise ComputationError(f"Newton's iteration for a double point near force {force[0]:.6g} did not settle")


def _record(system: Equations, kind: Kind, X: Real, c: Coefficients, error: float) -> SpecialPoint:
    rods, force, omegas = system.at(X[:, None])
    k1, k2, gamma3, gamma1 = rods[:, 0].tolist()
    return SpecialPoint(
        kind, (k1, k2, gamma3, gamma1), float(force[0]), float(omegas[0, 0]),
        omega2=float(omegas[1, 0]) if len(omegas) > 1 else None,
        alpha=complex(c.alpha[0]), beta=complex(c.beta[0]), error=error,
    )  # fmt: skip
