"""The spectrum of the straight rod under a follower force, and every force at which it crosses the imaginary axis.

Lengths in L, times in γ2 L⁴/k3, forces in k3/L²; ν = 1 − F/k1, μ = k2 ν + F. The eigenvalue problem (paper:
eq:linearization) is, with H = Y' − νΘ,

    λ Y = k2 H' − F Θ',    γ3 λ Θ = Θ'' + μ H,    Y(0) = Θ(0) = H(1) = Θ'(1) = 0.

It is used in two forms. Inverted, it is a compact integral operator (`inverse_operator`), from which all leading
eigenvalues and their slopes dλ/dF come at once: enough to see every crossing. Solved by exponentials, it is the zero
set of one analytic function (`characteristic`), on which Newton's method makes a crossing exact to round-off.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace
from fractions import Fraction
from typing import Literal

import numpy as np
from numpy.typing import ArrayLike, NDArray

from rodwnl import kernels
from rodwnl.errors import ComputationError, InputError
from rodwnl.parameters import Number, RodParameters, exact, shown
from rodwnl.quadrature import gauss_legendre

Real = NDArray[np.float64]
Complex = NDArray[np.complex128]
Floats = tuple[float, float, float, float]  # k1, k2, gamma3, gamma1
Crossing = tuple[float, float, float, float]  # low, high, F, ω

DEFAULT_MAX_FORCE = 400
FIRST_INTERVALS = 16  # of the scan in the force; bisection does the rest
NARROWEST = 1e-9  # of the range: an interval not decided at this width holds a tangency
KEPT, KEPT_FOR_ALL = 12, 30  # eigenvalues of least modulus; two thirds of them are followed through the scan
BESIDE = 1e-3  # relative distance from a threshold at which unstable eigenvalues are counted
MOST_NODES = 160
CIRCLE, RADIUS = 12, 0.03  # points and relative radius of Cauchy's formula: truncation (1/30)¹² of the scale
CONVERGED, MOST_STEPS = 1e-10, 20
ROUNDING = 8  # rounding errors of a term of the determinant, in units of EPS
EPS = float(np.finfo(float).eps)


@dataclass(frozen=True)
class HopfThreshold:
    """One crossing of the imaginary axis by a pair λ = ±iω of eigenvalues.

    force, omega: F_c and ω_c > 0. slope: dλ/dF there, from the characteristic function. unstable_below and
    unstable_above: number of eigenvalues with Re λ > 0 just below and above. residual: |D/(λ D_λ)|, the
    relative distance of iω from the zero that is left. force_error, omega_error: estimated absolute errors.
    """

    force: float
    omega: float
    slope: complex
    unstable_below: int
    unstable_above: int
    residual: float
    force_error: float
    omega_error: float

    @property
    def crossing(self) -> Literal["destabilizing", "restabilizing"]:
        return "destabilizing" if self.unstable_above > self.unstable_below else "restabilizing"

    @property
    def leading(self) -> bool:
        """Whether the straight rod is linearly stable on one side: the leading eigenvalue crosses."""
        return min(self.unstable_below, self.unstable_above) == 0


@dataclass(frozen=True)
class HopfSearch:
    """What was found for one rod in 0 <= F <= max_force. Iterates over `thresholds`.

    thresholds: crossings by the leading eigenvalue, by increasing force. later: crossings by other eigenvalues, None if not asked for.
    range_cut: the range asked for was cut at ν = 0 (F = k1). growth: the largest Re λ met in the scan, growth_force:
    where. evaluations: forces at which the spectrum was computed.
    """

    rod: RodParameters
    max_force: Fraction
    range_cut: bool
    thresholds: tuple[HopfThreshold, ...]
    later: tuple[HopfThreshold, ...] | None
    growth: float
    growth_force: float
    evaluations: int

    def __iter__(self) -> Iterator[HopfThreshold]:
        return iter(self.thresholds)

    def __len__(self) -> int:
        return len(self.thresholds)

    def __getitem__(self, index: int) -> HopfThreshold:
        return self.thresholds[index]


def hopf_thresholds(
    rod: RodParameters, max_force: Number | None = None, all_crossings: bool = False
) -> HopfSearch:
    """Every force 0 <= F <= max_force (default min(k1, 400); cut at k1) at which the straight rod begins or ceases to be
    unstable; with `all_crossings` also those at which further eigenvalues cross.

    What makes the list complete: the range is bisected until, on each interval and for each of the eight eigenvalues
    of least modulus, the cubic Hermite interpolant of Re λ(F) either keeps off the axis by more than its error, measured
    at the midpoint, or crosses it once with a slope that hardly varies; an interval on which one eigenvalue is clearly
    unstable throughout needs no more. So a window is missed only if it lies inside an interval on which the interpolant
    is right at the midpoint and wrong elsewhere by more than that. Besides, the thresholds must agree with the numbers of
    unstable eigenvalues on both sides of each, counted with a finer operator. λ = 0 is never an eigenvalue
    (`inverse_operator`).

    Raises InputError for a negative max_force, ComputationError where an eigenvalue touches the axis without a
    decidable crossing or a count of unstable eigenvalues contradicts the crossings.
    """
    upper, cut = _searched_range(rod, max_force)
    parameters = rod.floats()
    seen, crossings = scan(parameters, float(upper), all_crossings)
    found = sorted((_newton(parameters, *crossing) for crossing in crossings), key=lambda t: t.force)
    thresholds = _counted(parameters, found, float(upper), all_crossings)
    highest = np.unravel_index(np.argmax(seen.eigenvalue.real), seen.eigenvalue.shape)
    return HopfSearch(
        rod, upper, cut,
        thresholds=tuple(t for t in thresholds if t.leading),
        later=tuple(t for t in thresholds if not t.leading) if all_crossings else None,
        growth=float(seen.eigenvalue.real[highest]), growth_force=float(seen.force[highest[0]]),
        evaluations=len(seen.force),
    )  # fmt: skip


def _searched_range(rod: RodParameters, max_force: Number | None) -> tuple[Fraction, bool]:
    if max_force is None:
        return min(rod.k1, Fraction(DEFAULT_MAX_FORCE)), rod.k1 < DEFAULT_MAX_FORCE
    asked = exact("max_force", max_force)
    if asked < 0:
        raise InputError(f"max_force is {shown(max_force)}, but a follower force is searched from 0 upwards")
    return min(asked, rod.k1), asked > rod.k1


# ---- the inverse of the linear operator: all leading eigenvalues at once


def inverse_operator(parameters: Floats, force: ArrayLike, count: int) -> NDArray[np.inexact]:
    """The matrix of K = M⁻¹Γ on `count` nodes, (…, 2·count, 2·count) for forces (…): eigenvalues 1/λ, vectors (Y, √γ3 Θ).

    Given a = λY and b = λΘ: k2 H − FΘ = −∫ᵤ¹ a − FΘ(1), so with φ = Θ − Θ(1)

        k2 H = Fφ − ∫ᵤ¹ a,    φ'' + (μF/k2) φ = γ3 b + (μ/k2) ∫ᵤ¹ a,    φ(1) = φ'(1) = 0.

    This is a Volterra equation for h = φ'' (φ = ∫ᵤ¹∫ᵤ¹ h), so it is solvable for every force: M has no kernel, and no
    eigenvalue passes through 0 (no steady crossing). Then Θ = −∫₀ᵘ∫ᵤ¹ h and Y = ∫₀ᵘ (H + νΘ).
    """
    k1, k2, gamma3, _ = parameters
    nodes = gauss_legendre(count)
    rise, fall = nodes.from_clamp, nodes.to_tip
    force = np.asarray(force)[..., None, None]
    nu = 1 - force / k1
    stiff = nu + force / k2  # μ/k2
    root = np.sqrt(gamma3)
    phi = fall @ fall
    theta = -rise @ fall
    h_of_b = np.linalg.inv(np.eye(count) + stiff * force * phi)
    h_of_a = h_of_b @ (stiff * fall)
    y = rise @ (force / k2 * phi + nu * theta)
    rows = (
        np.concatenate([y @ h_of_a - rise @ fall / k2, root * y @ h_of_b], axis=-1),
        np.concatenate([root * theta @ h_of_a, gamma3 * theta @ h_of_b], axis=-1),
    )
    return np.concatenate(rows, axis=-2)


def leading_eigenvalues(parameters: Floats, force: Real, kept: int = KEPT) -> tuple[Complex, Complex]:
    """The `kept` eigenvalues λ of least modulus and their slopes dλ/dF, (n, kept) each, for forces (n,)."""
    eigenvalue, slope = np.empty((2, len(force), kept), dtype=complex)
    counts = np.array([max(_nodes_for(parameters, f), 2 * kept) for f in force])
    for count in np.unique(counts):
        same = counts == count
        eigenvalue[same], slope[same] = _leading(parameters, force[same], int(count), kept)
    return eigenvalue, slope


def _leading(parameters: Floats, force: Real, count: int, kept: int) -> tuple[Complex, Complex]:
    step = 1e-100  # complex step: K is real-analytic in F, so Im K(F + i step)/step is its derivative to round-off
    operator = inverse_operator(parameters, force + 1j * step, count)
    inverse, vectors = np.linalg.eig(operator.real)
    # κ' = (V⁻¹ K' V)_jj,    λ = 1/κ,    λ' = −κ'/κ²
    slope = np.einsum("...ij,...ji->...i", np.linalg.inv(vectors), operator.imag / step @ vectors)
    order = np.argsort(-np.abs(inverse), axis=-1, kind="stable")[..., :kept]
    inverse, slope = np.take_along_axis(inverse, order, -1), np.take_along_axis(slope, order, -1)
    eigenvalue = 1 / inverse.astype(complex)
    return eigenvalue, -slope * eigenvalue**2


def _nodes_for(parameters: Floats, force: float) -> int:
    """Nodes that resolve the operator at this force: φ oscillates with wave number √(μF/k2). A multiple of 8."""
    k1, k2, _, _ = parameters
    wave = np.sqrt((1 - force / k1 + force / k2) * force)
    count = 24 + 8 * int(wave / 16)
    if count > MOST_NODES:
        raise ComputationError(
            f"at F = {force:g} the shear wave number of the rod is {wave:.0f}: it would need {count} nodes, "
            f"more than {MOST_NODES}; search a smaller range (max_force)"
        )
    return count


def unstable_count(parameters: Floats, force: float) -> int:
    """Number of eigenvalues with Re λ > 0 among the leading ones, on half as many nodes again as the scan takes."""
    count = 3 * _nodes_for(parameters, force) // 2
    inverse = np.linalg.eigvals(inverse_operator(parameters, force, count))
    leading = inverse[np.argsort(-np.abs(inverse))[: count // 2]]
    return int(np.sum(leading.real > 0))


# ---- the scan in the force


@dataclass(frozen=True)
class Samples:
    """Leading eigenvalues at n forces: force (n,), eigenvalue and slope (n, m)."""

    force: Real
    eigenvalue: Complex
    slope: Complex

    def __getitem__(self, which: slice | NDArray[np.bool_]) -> Samples:
        return Samples(self.force[which], self.eigenvalue[which], self.slope[which])

    def followed_by(self, other: Samples) -> Samples:
        return Samples(
            np.concatenate([self.force, other.force]),
            np.concatenate([self.eigenvalue, other.eigenvalue]),
            np.concatenate([self.slope, other.slope]),
        )


def scan(parameters: Floats, upper: float, all_crossings: bool = False) -> tuple[Samples, list[Crossing]]:
    """Bisect [0, upper] until every interval is decided (see `hopf_thresholds`); all open intervals at once.

    All samples taken, and per crossing seen: the interval that holds it alone and its approximate (F, ω).
    """

    def sampled(force: Real) -> Samples:
        return Samples(
            force, *leading_eigenvalues(parameters, force, KEPT_FOR_ALL if all_crossings else KEPT)
        )

    seen = sampled(np.linspace(0.0, upper, FIRST_INTERVALS + 1))
    left, right = seen[:-1], seen[1:]
    crossings: list[Crossing] = []
    while left.force.size:
        middle = sampled((left.force + right.force) / 2)
        seen = seen.followed_by(middle)
        decided, new = _decide(left, middle, right, all_crossings)
        crossings += new
        left, middle, right = left[~decided], middle[~decided], right[~decided]
        left, right = left.followed_by(middle), middle.followed_by(right)
        if left.force.size and np.min(right.force - left.force) < NARROWEST * upper:
            raise ComputationError(
                f"near F = {left.force[0]:.10g} an eigenvalue touches the imaginary axis so closely that double "
                f"precision cannot tell whether it crosses; search up to a smaller max_force"
            )
    return seen, crossings


def _decide(
    left: Samples, middle: Samples, right: Samples, all_crossings: bool
) -> tuple[NDArray[np.bool_], list[Crossing]]:
    """Per interval: whether every eigenvalue is understood on it; and the crossings on those that are."""
    followed = 2 * middle.eigenvalue.shape[1] // 3  # the rest only serve as partners at the ends
    middle = Samples(middle.force, middle.eigenvalue[:, :followed], middle.slope[:, :followed])
    step = (middle.force - left.force)[:, None]
    before, after = _partners(left, middle, -step), _partners(right, middle, step)
    # cubic Hermite from the two ends, at the midpoint; on a half interval its error is smaller still
    predicted = (before[0] + after[0]) / 2 + step / 4 * (before[1] - after[1])
    error = np.abs(predicted.real - middle.eigenvalue.real)
    here = (middle.eigenvalue, middle.slope)
    halves = [_bernstein(before, here, step), _bernstein(here, after, step)]
    understood, unstable = np.ones_like(error, dtype=bool), np.ones_like(error, dtype=bool)
    change = np.zeros(len(left.force))
    crossings = []
    for half, start in zip(halves, (left.force, middle.force), strict=True):
        real = half.real
        rise = np.diff(real, axis=0)
        above, below = np.all(real > error, axis=0), np.all(real < -error, axis=0)
        steady = np.min(np.abs(rise), axis=0) > np.maximum(error, np.max(np.abs(rise), axis=0) / 4)
        understood &= above | below | (steady & np.all(rise * rise[0] > 0, axis=0))
        unstable &= above
        crosses = (real[0] < 0) != (real[3] < 0)
        change += np.sum(np.where(crosses, np.sign(real[3] - real[0]), 0), axis=1)
        crossings.append((half, crosses & (middle.eigenvalue.imag > 0), start))
    decided = understood.all(axis=1) & (_unstable(right.eigenvalue) - _unstable(left.eigenvalue) == change)
    throughout = unstable.any(axis=1) & (not all_crossings)
    decided |= throughout
    return decided, [
        _crossing(half[:, i, j], float(start[i]), float(step[i, 0]))
        for half, crosses, start in crossings
        for i, j in np.argwhere(crosses & (decided & ~throughout)[:, None])
    ]


def _partners(end: Samples, middle: Samples, step: Real) -> tuple[Complex, Complex]:
    """For each eigenvalue at the middle the one at the end that continues it: the trapezoidal rule fits best."""
    slope = (end.slope[:, None, :] + middle.slope[:, :, None]) / 2
    misfit = np.abs(end.eigenvalue[:, None, :] - middle.eigenvalue[:, :, None] - step[..., None] * slope)
    best = np.argmin(misfit, axis=2)
    return np.take_along_axis(end.eigenvalue, best, 1), np.take_along_axis(end.slope, best, 1)


def _bernstein(start: tuple[Complex, Complex], end: tuple[Complex, Complex], step: Real) -> Complex:
    """Bernstein coefficients of the cubic Hermite interpolant of λ: its values lie between their extremes."""
    (a, a_slope), (b, b_slope) = start, end
    return np.stack([a, a + step * a_slope / 3, b - step * b_slope / 3, b])


def _crossing(bernstein: Complex, start: float, step: float) -> Crossing:
    """Where the cubic λ on [start, start + step] has Re λ = 0, by bisection (de Casteljau's algorithm)."""
    low, high, value = 0.0, 1.0, bernstein[0]
    while high - low > 1e-12:
        s, b = (low + high) / 2, bernstein
        while len(b) > 1:
            b = (1 - s) * b[:-1] + s * b[1:]
        value = b[0]
        low, high = (low, s) if (value.real > 0) == (bernstein[3].real > 0) else (s, high)
    return start, start + step, start + step * low, float(value.imag)


def _unstable(eigenvalue: Complex) -> NDArray[np.int_]:
    return np.sum(eigenvalue.real > 0, axis=-1)


# ---- the characteristic function


def exponents(parameters: Floats, force: ArrayLike, eigenvalue: ArrayLike) -> Complex:
    """The exponents (r1, r2, −r1, −r2) of e^{ru}, with Re r1, Re r2 >= 0, on a new last axis."""
    k1, k2, gamma3, _ = parameters
    c4, c2, c0 = kernels.exponent_polynomial(eigenvalue, k1, k2, gamma3, force)
    root = np.sqrt(c2 * c2 - 4 * c4 * c0 + 0j)
    sign = np.where((np.conj(c2) * root).real > 0, -1, 1)  # no cancellation in −c2 + sign √…
    squares = kernels.squared_exponents(np, sign, eigenvalue + 0j, k1, k2, gamma3, force)
    r = np.sqrt(np.stack(np.broadcast_arrays(*squares), axis=-1))
    return np.concatenate([r, -r], axis=-1)


def boundary_matrix(
    parameters: Floats, force: ArrayLike, eigenvalue: ArrayLike, r: Complex, adjoint: bool = False
) -> Complex:
    """Rows: the four boundary conditions; columns: e^{ru} for each exponent, divided by e^{r} where Re r > 0.

    (…, 4, 4) for force and eigenvalue (…), r (…, 4). With `adjoint`, `eigenvalue` is the adjoint's, λ*.
    """
    k1, k2, _, _ = parameters
    column = kernels.adjoint_boundary_column if adjoint else kernels.boundary_column
    force, eigenvalue = np.asarray(force)[..., None], np.asarray(eigenvalue)[..., None]
    grows = r.real > 0
    at_clamp, at_tip = np.exp(np.where(grows, -r, 0)), np.exp(np.where(grows, 0, r))
    rows = column(r, at_tip, eigenvalue, k1, k2, force)
    rows = np.broadcast_arrays(rows[0] * at_clamp, rows[1] * at_clamp, rows[2], rows[3])
    return np.stack(rows, axis=-2)


def characteristic(parameters: Floats, force: ArrayLike, eigenvalue: ArrayLike) -> tuple[Complex, Real]:
    """D(F, λ), zero exactly at the eigenvalues, and the size of the terms that it sums; both (…).

    The determinant of `boundary_matrix`, with the factors divided out that vanish without an eigenvalue:
    λ, r1, r2 and (r1² − r2²)². Analytic in F and λ wherever Re λ > −μν/(2γ3) and Im λ > 0.
    """
    r = exponents(parameters, force, eigenvalue)
    m = boundary_matrix(parameters, force, eigenvalue, r)
    value, size = 0, 0
    for i, j, k, n, sign in _LAPLACE:
        upper = m[..., 0, i] * m[..., 1, j], m[..., 0, j] * m[..., 1, i]
        lower = m[..., 2, k] * m[..., 3, n], m[..., 2, n] * m[..., 3, k]
        value = value + sign * (upper[0] - upper[1]) * (lower[0] - lower[1])
        size = size + (abs(upper[0]) + abs(upper[1])) * (abs(lower[0]) + abs(lower[1]))
    spurious = (r[..., 0] ** 2 - r[..., 1] ** 2) ** 2 * eigenvalue / (r[..., 0] * r[..., 1])
    return value / spurious, size / abs(spurious)


_LAPLACE = (
    (0, 1, 2, 3, 1),
    (0, 2, 1, 3, -1),
    (0, 3, 1, 2, 1),
    (1, 2, 0, 3, 1),
    (1, 3, 0, 2, -1),
    (2, 3, 0, 1, 1),
)


def characteristic_slopes(parameters: Floats, force: float, eigenvalue: complex) -> tuple[complex, complex]:
    """(∂D/∂F, ∂D/∂λ) by Cauchy's formula: the mean of D(z) / (z − z0) over a circle, exact up to round-off."""
    turn = np.exp(2j * np.pi * (np.arange(CIRCLE) + 0.5) / CIRCLE)
    reach_force, reach = RADIUS * max(force, 1.0), RADIUS * abs(eigenvalue)
    by_force, _ = characteristic(parameters, force + reach_force * turn, eigenvalue)
    by_eigenvalue, _ = characteristic(parameters, force, eigenvalue + reach * turn)
    return complex(np.mean(by_force / turn) / reach_force), complex(np.mean(by_eigenvalue / turn) / reach)


def _newton(parameters: Floats, low: float, high: float, force: float, omega: float) -> HopfThreshold:
    """Solve D(F, iω) = 0 for real F and ω from a start in [low, high], where exactly one crossing lies.

    With dλ/dF = −D_F/D_λ:  D + D_F dF + i D_λ dω = 0  is  (dλ/dF) dF − i dω = D/D_λ.
    """
    moves = [np.inf]
    while moves[-1] > CONVERGED or moves[-1] < moves[-2] / 2:
        value, size = characteristic(parameters, force, 1j * omega)
        by_force, by_eigenvalue = characteristic_slopes(parameters, force, 1j * omega)
        slope, offset = -by_force / by_eigenvalue, complex(value) / by_eigenvalue
        step = offset.real / slope.real
        turn = slope.imag * step - offset.imag
        force, omega = force + step, omega + turn
        moves.append(abs(step) / force + abs(turn) / omega)
        if not (low - abs(step) <= force <= high + abs(step) and len(moves) < MOST_STEPS):
            raise ComputationError(
                f"Newton's iteration for the threshold between F = {low:.6g} and {high:.6g} went to {force:.6g}"
            )
    noise = ROUNDING * EPS * float(size) / abs(by_eigenvalue)  # of λ, at a fixed force
    force_error = noise / abs(slope.real) + EPS * force
    return HopfThreshold(
        force, omega, slope, 0, 0,
        residual=abs(offset) / omega,
        force_error=force_error, omega_error=noise + abs(slope.imag) * force_error + EPS * omega,
    )  # fmt: skip


def _counted(
    parameters: Floats, found: list[HopfThreshold], upper: float, all_crossings: bool
) -> tuple[HopfThreshold, ...]:
    """The thresholds with the numbers of unstable eigenvalues just below and above; their story must be consistent."""
    edges = [0.0, *(t.force for t in found), upper]
    counted, before = [], 0  # at F = 0 the operator is self-adjoint and negative
    for threshold, low, high in zip(found, edges, edges[2:], strict=False):
        force = threshold.force
        below = unstable_count(parameters, force - min(BESIDE * force, (force - low) / 2))
        above = unstable_count(parameters, force + min(BESIDE * force, (high - force) / 2))
        known = before == below if all_crossings else (before > 0) == (below > 0)
        if not known or above - below != 2 * np.sign(threshold.slope.real):
            raise ComputationError(
                f"at F = {force:.10g} the number of unstable eigenvalues goes from {below} to {above}, having been "
                f"{before} before, while dλ/dF = {threshold.slope:.6g}: a crossing was missed; this rod needs more digits"
            )
        counted.append(replace(threshold, unstable_below=below, unstable_above=above))
        before = above
    return tuple(counted)
