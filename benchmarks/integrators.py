"""Which integrator, and in which unknowns: time until A_tip is right to 1e-5, one BLAS thread.

    python benchmarks/integrators.py [--time 5] [--nodes 24]

The rod k1 = k2 = 1e4, gamma3 = 1e-4 at force 38 from its perturbed straight state. Every method gets the
same grid, the exact Jacobian, and tolerances in half decades; it is represented by its cheapest run whose
A_tip, and that of all its tighter runs, is within 1e-5 of a run with tolerance 1e-12 in the same unknowns.
Times are CPU seconds, so that other processes disturb less.
"""

import argparse
import time
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
from scipy.integrate import solve_ivp
from sksundae.cvode import CVODE
from threadpoolctl import threadpool_limits

from rodwnl.angleform import angle_form
from rodwnl.collocation import discretise
from rodwnl.parameters import RodParameters
from rodwnl.readout import read
from rodwnl.simulation import ATOL, perturbed, sampling_step

ROD, FORCE, GOAL = RodParameters("1e4", "1e4", "1e-4"), 38.0, 1e-5
REFERENCE = 1e-12


@dataclass(frozen=True)
class Problem:
    """q_t = f(q) with its Jacobian, where it starts, and the tip's y of its states (m, size)."""

    rhs: Callable[[Any], Any]
    jacobian: Callable[[Any], Any]
    start: Any
    tip_y: Callable[[Any], Any]


@dataclass(frozen=True)
class Run:
    rtol: float
    seconds: float
    A_tip: float
    rhs: int
    jacobian: int


def problems(degree: int) -> dict[str, Problem]:
    form = angle_form(ROD, FORCE, degree)
    start = perturbed(form, 1e-2)
    other = discretise(*ROD.floats(), FORCE, degree)
    at = np.searchsorted(form.nodes, other.nodes)
    displaced = other.state(*(field[at] for field in form.fields(start)[:3]))
    return {
        "strain integrals": Problem(form.rhs, form.jacobian, start, lambda q: form.tip(q)[1]),
        "displacements": Problem(other.rhs, other.jacobian, displaced, lambda q: other.tip(q)[1]),
    }


def integrate(problem: Problem, method: str, times: Any, rtol: float) -> Run:
    """One run; its time includes the samples but not the reading."""
    counts = [0, 0]

    def rhs(t: float, q: Any, out: Any = None) -> Any:
        counts[0] += 1
        value = problem.rhs(q)
        if out is None:
            return value
        out[:] = value
        return None

    def jacobian(t: float, q: Any, q_t: Any = None, out: Any = None) -> Any:
        counts[1] += 1
        value = problem.jacobian(q)
        if out is None:
            return value
        out[:] = value
        return None

    begin = time.process_time()
    if method == "CVODE":
        solver = CVODE(rhs, jacfn=jacobian, rtol=rtol, atol=ATOL * rtol, max_num_steps=1_000_000)
        states = solver.solve(times, problem.start).y
    else:
        solution = solve_ivp(
            rhs,
            (0, times[-1]),
            problem.start,
            method,
            t_eval=times,
            rtol=rtol,
            atol=ATOL * rtol,
            jac=jacobian,
        )
        states = solution.y.T
    seconds = time.process_time() - begin
    return Run(rtol, seconds, read(times, problem.tip_y(states)).A_tip or np.nan, *counts)


def cheapest(runs: list[Run], A: float) -> Run | None:
    """The loosest run that, like all tighter ones, reaches the goal."""
    good = None
    for run in sorted(runs, key=lambda run: run.rtol):
        if not abs(run.A_tip / A - 1) <= GOAL:
            break
        good = run
    return good


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--time", type=float, default=5.0)
    parser.add_argument("--nodes", type=int, default=24)
    arguments = parser.parse_args()
    step = sampling_step(ROD, FORCE, arguments.time)
    times = step * np.arange(round(arguments.time / step) + 1)
    tolerances = {"CVODE": (6, 8.5), "LSODA": (6, 8.5), "BDF": (6, 8.5), "Radau": (4, 6.5)}
    best: dict[tuple[str, str], Run] = {}
    print(f"T = {arguments.time:g}, {arguments.nodes} Chebyshev intervals, goal {GOAL:g} in A_tip\n")
    for unknowns, problem in problems(arguments.nodes).items():
        A = integrate(problem, "CVODE", times, REFERENCE).A_tip
        print(f"unknowns: {unknowns}; A_tip = {A:.9f} at tolerance {REFERENCE:g}")
        for method, (loose, tight) in tolerances.items():
            if method == "Radau" and unknowns == "displacements":
                continue  # more than ten times slower than the rest
            runs = []
            for exponent in np.arange(loose, tight, 0.5):
                runs.append(integrate(problem, method, times, 10.0**-exponent))
                run = runs[-1]
                print(
                    f"  {method:6} rtol {run.rtol:.0e}: error {abs(run.A_tip / A - 1):.1e}, "
                    f"{run.seconds:6.2f} s, {run.rhs} right-hand sides, {run.jacobian} Jacobians",
                    flush=True,
                )
            if (good := cheapest(runs, A)) is not None:
                best[unknowns, method] = good
    ours = best["strain integrals", "CVODE"].seconds
    print(f"\ntime to {GOAL:g}, relative to CVODE in strain integrals ({ours:.2f} s):")
    for (unknowns, method), run in best.items():
        print(f"  {method:6} in {unknowns:17}: {run.seconds / ours:5.2f}  (rtol {run.rtol:.0e})")


if __name__ == "__main__":
    with threadpool_limits(1):
        main()
