"""What the figures show, computed: eigenvalues, simulations, theory and orbits of the paper's rods.

Dimensionless: lengths in L, times in γ2 L⁴/k3, forces in k3/L².
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from rodwnl.branches import Branch, branch
from rodwnl.coefficients import LandauCoefficients, landau_at
from rodwnl.cycles import Rod
from rodwnl.inverse import leading_eigenvalues
from rodwnl.parameters import RodParameters
from rodwnl.predictions import predict_at
from rodwnl.readout import Reading
from rodwnl.simulation import Simulation, simulate
from rodwnl.spectrum import hopf_thresholds

Array = NDArray[np.float64]
Complex = NDArray[np.complex128]
Watch = Callable[[str], None]

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

    theory (m, 3): force, A_tip, ω of the amplitude equation; theory_stable: whether that branch is stable.
    orbits (k, 4): force, A_tip, ω, 1 where the stretch after it is stable; folds (j, 3): force, A_tip, ω.
    """

    column: Column
    theory: Array
    theory_stable: bool
    points: tuple[SimulatedPoint, ...]
    orbits: Array
    folds: Array


def paper_columns() -> tuple[Column, ...]:
    """The paper's rods and thresholds (tab:parameters), in its order."""
    from rodwnl.tables import printed_rows

    rows = [row for row in printed_rows() if row.table == "tab:parameters"]
    found = {row.rod: hopf_thresholds(row.rod) for row in rows}
    return tuple(Column(row.rod, landau_at(row.rod, found[row.rod][row.threshold - 1])) for row in rows)


def eigenvalue_path(column: Column, low: float, high: float, count: int = 400) -> EigenvaluePath:
    """The critical pair from `low` to `high`, by continuity from the threshold on."""
    from scipy.optimize import linear_sum_assignment

    force = np.linspace(low, high, count)
    candidates, _ = leading_eigenvalues(column.rod.floats(), force)
    start = int(np.abs(force - column.coefficients.force).argmin())
    pair = 1j * column.coefficients.omega * np.array([1, -1])
    path = np.empty((count, 2), complex)
    for steps in (range(start, count), range(start, -1, -1)):
        here = pair
        for k in steps:
            _, chosen = linear_sum_assignment(np.abs(here[:, None] - candidates[k]))
            here = path[k] = candidates[k, chosen]
    return EigenvaluePath(force, path)


def until_settled(rod: RodParameters, force: float, perturbation: float, first: float) -> SimulatedPoint:
    """Simulations of doubled length, from `first` on, until one has settled or decayed."""
    time = first
    while True:
        run = simulate(rod, repr(force), repr(time), repr(perturbation), rtol=1e-7)
        if run.reading.state != "not finished" or time >= LONGEST:
            return SimulatedPoint(force, perturbation, run.reading)
        time *= 2


def comparison(column: Column, watch: Watch, quick: bool = False) -> Comparison:
    """Everything fig:comparison shows of one column."""
    c = column.coefficients
    reach = REACH * c.force
    supercritical = c.criticality == "supercritical"
    first = 40 * 2 * np.pi / c.omega  # 40 periods
    detunings = [d * c.force * column.side for d in (DETUNINGS[1::2] if quick else DETUNINGS)]
    points = []
    for detuning in detunings:
        watch(f"simulating k1 = {float(column.rod.k1):g} at force {c.force + detuning:.4g}")
        points.append(until_settled(column.rod, c.force + detuning, 0.01 if supercritical else 0.1, first))
    watch(f"orbits of k1 = {float(column.rod.k1):g} from force {c.force:.4g}")
    orbits = orbit_branch(column, reach)
    path = np.array([(o.force, o.tip_amplitude, o.omega, stable) for o, stable in orbits.path])
    path[-1, 3] = path[-2, 3]
    turns = [event.at.cycle for event in orbits.folds]
    folds = np.array([(o.force, o.tip_amplitude, o.omega) for o in turns]).reshape(-1, 3)
    if folds.size and not quick:  # both states at one force
        middle = 0.5 * (c.force + float(folds[:, 0].max()))
        for perturbation in (0.005, 0.5):
            watch(f"simulating at force {middle:.6g} from {perturbation}")
            points.append(until_settled(column.rod, middle, perturbation, first))
    return Comparison(column, _theory(column, reach), supercritical, tuple(points), path, folds)


def orbit_branch(column: Column, reach: float) -> Branch:
    """The branch of orbits from the threshold on, within the forces that are drawn.

    From a subcritical threshold it may go as far as it likes before it turns back.
    """
    c = column.coefficients
    farthest = c.force + reach if c.criticality == "supercritical" else float(column.rod.k1)
    return branch(Rod(*column.rod.floats()), c.force, c.omega, window=(c.force - reach, farthest))


def _theory(column: Column, reach: float) -> Array:
    """(m, 3): A_tip and ω by eq:tipamplitude and eq:tipfrequency, dense where the root is steep."""
    c = column.coefficients
    side = np.sign(c.A_tip2_slope)
    detuning = side * reach * np.linspace(0, 1, 60)[1:] ** 2
    predictions = [predict_at(c, c.force + d) for d in detuning]
    rows = [(p.force, p.A_tip or 0.0, p.omega or 0.0) for p in predictions]
    return np.array([(c.force, 0.0, c.omega), *rows])


def beating(column: Column, force: float = 40.0) -> Simulation:
    """The run of fig:nonlinear."""
    return simulate(column.rod, repr(force), 2)
