"""An orbit against the simulation that settles on it: CPU seconds, one BLAS thread.

    python benchmarks/orbit.py [--repeat 5]

The paper's supercritical rods about half a unit of force above their threshold. The orbit is timed from the
threshold on (onset, Newton's method on two grids, Floquet multipliers), and with the search for the
thresholds; its own refinement leaves less than 1e-9. The simulation starts from the straight rod, slightly
perturbed, and runs as the command does by itself, and long and accurately enough to give the orbit's A_tip to
1e-8. Orbits: the smallest time of so many repetitions.
"""

import argparse
import time
from collections.abc import Callable
from typing import Any

from threadpoolctl import threadpool_limits

from rodwnl import RodParameters, hopf_thresholds, periodic_orbits, simulate
from rodwnl.emittedlaw import emitted_law
from rodwnl.orbits import Cycle, Orbit, onset, orbit_at

CASES = [
    (RodParameters("1e4", "1e4", "1e-4"), 38.0),
    (RodParameters("1e4", "1e2", "1e-2"), 28.0),
    (RodParameters("200", "1e4", "1e-4"), 50.25),
]
RUNS = [(5.0, 1e-8), (7.0, 1e-9), (8.0, 1e-10), (8.0, 1e-11), (10.0, 1e-11)]  # time, tolerance; by cost
GOAL = 1e-8


def timed(work: Callable[[], Any], repeat: int) -> tuple[float, Any]:
    """The smallest CPU time of so many runs, and what the last one gave."""
    seconds = []
    for _ in range(repeat):
        begin = time.process_time()
        result = work()
        seconds.append(time.process_time() - begin)
    return min(seconds), result


def from_threshold(rod: RodParameters, force: float, hopf_force: float, omega: float) -> Orbit:
    """The orbit at this force, guessed by the branch's tangent at its Hopf point."""
    begin = onset(emitted_law(rod), hopf_force, omega)
    X, tangent = begin.point.X, begin.point.tangent
    return orbit_at(Cycle(begin.system, X + (force - X[-2]) / tangent[-2] * tangent), force)


def compare(rod: RodParameters, force: float, repeat: int) -> None:
    threshold = hopf_thresholds(rod)[0]
    solved, orbit = timed(lambda: from_threshold(rod, force, threshold.force, threshold.omega), repeat)
    whole, _ = timed(lambda: periodic_orbits(rod, force), repeat)
    print(f"{rod}, force {force:g}: A_tip {orbit.A_tip:.11f}, error {orbit.error:.0e}")
    print(f"  orbit {solved:.3f} s, with the search for thresholds {whole:.3f} s")
    for duration, rtol in RUNS:
        seconds, run = timed(lambda: simulate(rod, force, duration, rtol=rtol).reading, 1)  # noqa: B023
        error = abs((run.A_tip or 0) / orbit.A_tip - 1)
        print(
            f"  simulation of time {duration:g}, rtol {rtol:.0e}: {seconds:6.2f} s, {error:.0e} from the "
            f"orbit; ratio {seconds / solved:.0f}, with the search {seconds / whole:.0f}",
            flush=True,
        )
        if error < GOAL:
            break


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--repeat", type=int, default=5)
    arguments = parser.parse_args()
    periodic_orbits(*CASES[0])  # what is loaded and tabulated once
    for rod, force in CASES:
        compare(rod, force, arguments.repeat)


if __name__ == "__main__":
    with threadpool_limits(1):
        main()
