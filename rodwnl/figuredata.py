"""What the figures show, computed: eigenvalues, simulations, theory, orbits; of the paper's rods or others.

Dimensionless: lengths in L, times in γ2 L⁴/k3, forces in k3/L².
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from rodwnl.branches import branch
from rodwnl.coefficients import LandauCoefficients, landau, landau_at
from rodwnl.errors import InputError
from rodwnl.inverse import leading_eigenvalues
from rodwnl.parameters import PLAIN, RodParameters
from rodwnl.predictions import predict_at
from rodwnl.readout import Reading
from rodwnl.simulation import Simulation, simulate
from rodwnl.spectrum import hopf_thresholds, searched_range

Array = NDArray[np.float64]
Complex = NDArray[np.complex128]

PERIODS = 40  # the shortest simulation
FARTHEST = 2.0  # force, relative to its subcritical threshold, up to which a branch of orbits is followed
BEATING = 0.06  # how far beyond its threshold a beating rod is drawn, relative to it
LONGEST = 16.0  # a simulation that has not settled by then is drawn as such
REACH = 0.12  # how far beyond a threshold the comparison goes, relative to it
DETUNINGS = (0.003, 0.01, 0.02, 0.035, 0.055, 0.085, 0.115)  # of the simulations, relative to the threshold


@dataclass(frozen=True)
class Column:
    """One rod at one of its thresholds: a line of the paper's table of parameters."""

    rod: RodParameters
    coefficients: LandauCoefficients

    @property
    def side(self) -> float:
        """+1 where the straight rod is unstable above the threshold, −1 where below."""
        return 1.0 if self.coefficients.crossing == "destabilizing" else -1.0

    @property
    def supercritical(self) -> bool:
        """Whether the branch of oscillations that begins here is stable."""
        return self.coefficients.criticality == "supercritical"


@dataclass(frozen=True)
class EigenvaluePath:
    """The pair of eigenvalues that becomes critical, followed in the force: (n,) and (n, 2)."""

    force: Array
    eigenvalue: Complex


@dataclass(frozen=True)
class SimulatedPoint:
    """The end of one simulation."""

    force: float
    perturbation: float
    reading: Reading


@dataclass(frozen=True)
class Comparison:
    """Theory, simulations and orbits beside one threshold.

    theory (m, 3): force, A_tip, ω of the amplitude equation. orbits (k, 4): force, A_tip, ω, 1 where the
    stretch after it is stable; folds (j, 3): force, A_tip, ω.
    """

    column: Column
    theory: Array
    points: tuple[SimulatedPoint, ...]
    orbits: Array
    folds: Array


def paper_columns() -> tuple[Column, ...]:
    """The paper's rods and thresholds (tab:parameters), in its order."""
    from rodwnl.tables import printed_rows

    rows = [row for row in printed_rows() if row.table == "tab:parameters"]
    found = {row.rod: hopf_thresholds(row.rod) for row in rows}
    return tuple(Column(row.rod, landau_at(row.rod, found[row.rod][row.threshold - 1])) for row in rows)


def columns_of(rods: Iterable[RodParameters]) -> tuple[Column, ...]:
    """All thresholds of these rods. Raises InputError where none of them has any."""
    columns = tuple(Column(rod, c) for rod in rods for c in landau(rod))
    if not columns:
        raise InputError("there is nothing to draw: the straight rod has no Hopf threshold")
    return columns


def by_rod(columns: Iterable[Column]) -> list[list[Column]]:
    """The columns of each rod, in their order."""
    groups: list[list[Column]] = []
    for column in columns:
        if groups and groups[-1][0].rod == column.rod:
            groups[-1].append(column)
        else:
            groups.append([column])
    return groups


def eigenvalue_path(column: Column, low: float, high: float, count: int = 400) -> EigenvaluePath:
    """The critical pair from `low` to `high`, by continuity from the threshold on."""
    from scipy.optimize import linear_sum_assignment

    force = np.linspace(low, high, count)
    candidates = _leading(column.rod, force)
    start = int(np.abs(force - column.coefficients.force).argmin())
    pair = 1j * column.coefficients.omega * np.array([1, -1])
    path = np.empty((count, 2), complex)
    for steps in (range(start, count), range(start, -1, -1)):
        here = pair
        for k in steps:
            _, chosen = linear_sum_assignment(np.abs(here[:, None] - candidates[k]))
            here = path[k] = candidates[k, chosen]
    return EigenvaluePath(force, path)


def _leading(rod: RodParameters, force: Array) -> Complex:
    if rod.model == PLAIN:
        return leading_eigenvalues(rod.floats(), force)[0]
    from rodwnl import collocated

    return collocated.leading_eigenvalues(rod, force)[0]


def starts(column: Column, quick: bool = False) -> list[tuple[float, float]]:
    """Force and perturbation of the simulations in fig:comparison; `quick`: of every other one."""
    perturbation = 0.01 if column.supercritical else 0.1
    detunings = DETUNINGS[1::2] if quick else DETUNINGS
    force = column.coefficients.force
    return [(force + d * force * column.side, perturbation) for d in detunings]


def coexisting(column: Column, folds: Array) -> list[tuple[float, float]]:
    """Two simulations of both stable states: half-way between the threshold and the farthest fold, if any."""
    if not folds.size:
        return []
    middle = 0.5 * (column.coefficients.force + float(folds[:, 0].max()))
    return [(middle, 0.005), (middle, 0.5)]


def simulated(column: Column, force: float, perturbation: float) -> SimulatedPoint:
    """Simulations of doubled length until one has settled or decayed."""
    time = PERIODS * 2 * np.pi / column.coefficients.omega
    while True:
        run = simulate(column.rod, repr(force), repr(time), repr(perturbation), rtol=1e-7)
        if run.reading.state != "not finished" or time >= LONGEST:
            return SimulatedPoint(force, perturbation, run.reading)
        time *= 2


def orbits(column: Column) -> tuple[Array, Array]:
    """The branch of orbits from the threshold on, within the forces that are drawn, and its folds.

    (k, 4) and (j, 3) as in `Comparison`. From a subcritical threshold the branch may go as far as it likes
    before it turns back.
    """
    c = column.coefficients
    reach = REACH * c.force
    bearable = float(searched_range(column.rod, FARTHEST * c.force)[0])
    farthest = min(c.force + reach, bearable) if column.supercritical else bearable
    found = branch(column.rod, c.force, c.omega, window=(c.force - reach, farthest))
    path = np.array([(o.force, o.tip_amplitude, o.omega, stable) for o, stable in found.path])
    path[-1, 3] = path[-2, 3]
    turns = [event.at.cycle for event in found.folds]
    return path, np.array([(o.force, o.tip_amplitude, o.omega) for o in turns]).reshape(-1, 3)


def theory(column: Column) -> Array:
    """(m, 3): A_tip and ω by eq:tipamplitude and eq:tipfrequency, dense where the root is steep."""
    c = column.coefficients
    detuning = np.sign(c.A_tip2_slope) * REACH * c.force * np.linspace(0, 1, 60)[1:] ** 2
    predictions = [predict_at(c, c.force + d) for d in detuning]
    rows = [(p.force, p.A_tip or 0.0, p.omega or 0.0) for p in predictions]
    return np.array([(c.force, 0.0, c.omega), *rows])


def beating_like_the_papers(columns: Iterable[Column]) -> list[tuple[Column, float, float]]:
    """What `beating` takes for the first threshold beyond which a rod beats ever more, if there is one.

    As far beyond it as the paper's, but not beyond half-way to where the rod is straight again.
    """
    for rod in by_rod(columns):
        for column, after in zip(rod, [*rod[1:], None], strict=True):
            c = column.coefficients
            if column.supercritical and column.side > 0:
                step = BEATING * c.force
                if after is not None:
                    step = min(step, (after.coefficients.force - c.force) / 2)
                return [(column, c.force + step, PERIODS * 2 * np.pi / c.omega)]
    return []


def beating(column: Column, force: float = 40.0, time: float = 2.0) -> Simulation:
    """The run of fig:nonlinear, repeated for twice the time until it has settled."""
    while True:
        run = simulate(column.rod, repr(force), repr(time))
        if run.reading.state != "not finished" or time >= LONGEST:
            return run
        time *= 2
