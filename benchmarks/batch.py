"""Rods per second: the batch, one rod at a time, and the discretised normal form; one BLAS thread.

    python benchmarks/batch.py [--rods 16384] [--single 60] [--jaxcont .peers/jaxcont/bin/python]
    python benchmarks/batch.py --model quartic
    python benchmarks/batch.py --numpy

CPU seconds on the same random rods, k1 from 20 to 1e6, k2 from 5 to 1e6, gamma3 from 1e-6 to 1: thresholds
found and α, β computed. The discretised normal form (exact directional derivatives, 33 Chebyshev points) and
jaxcont are timed on the paper's first rod. They do not search for thresholds, they are given one; jaxcont is
timed once it has compiled. Accuracies are printed beside.

What the batch could reach is estimated from what it calls: every complex exponential, root and product, each
at its own speed in NumPy on arrays that stay in the cache, and nothing else.
"""

import argparse
import json
import subprocess
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
from threadpoolctl import threadpool_limits

from rodwnl import RodParameters, batch, landau, landau_batch
from rodwnl import batch_coefficients as nodes
from rodwnl import batch_spectrum as spectrum
from rodwnl.batch import Status
from rodwnl.models import emitted
from rodwnl.normalform import normal_form
from rodwnl.strainform import follower

PAPER = (1e4, 1e4, 1e-4, 0.5)
# Of one evaluation, counted in the source: complex exponentials, square roots, products (divisions as 7).
POINT = (2, 3, 70)  # `along` and what `_phase` does with it
JET = (2, 3, 190)  # `jet`, with two slopes
# `_evaluate`, the emitted kernels by their own counts; besides, 5 products with real matrices
NODE = (2, 0, 105)


def timed(work: Callable[[], Any], repeat: int = 3) -> tuple[float, Any]:
    """The smallest CPU time of so many runs, and what the last one gave."""
    seconds = []
    for _ in range(repeat):
        begin = time.process_time()
        result = work()
        seconds.append(time.process_time() - begin)
    return min(seconds), result


def sample(count: int) -> tuple[np.ndarray, ...]:
    """Random rods, evenly in the logarithms."""
    rng = np.random.default_rng(0)
    k1, k2 = 10 ** rng.uniform(np.log10(20), 6, count), 10 ** rng.uniform(np.log10(5), 6, count)
    return k1, k2, 10 ** rng.uniform(-6, 0, count), np.full(count, 0.5)


def ideal(rods: tuple[np.ndarray, ...]) -> float:
    """Seconds for the exponentials, roots and products alone."""
    calls = {"points": 0, "jets": 0, "nodes": 0, "matrix": 0.0}
    along, jet, evaluate = spectrum.along, spectrum.jet, nodes._evaluate

    def counted(given: Any, lam: Any) -> Any:
        calls["points"] += lam.size
        return along(given, lam)

    def counted_jet(given: Any, lam: Any) -> Any:
        calls["jets"] += lam.size
        return jet(given, lam)

    def counted_nodes(*arguments: Any) -> Any:
        count, rods_here = len(arguments[-1].u), len(arguments[1])
        calls["nodes"] += count * rods_here
        calls["matrix"] += 5 * 2 * rods_here * count * count  # real multiply-adds
        return evaluate(*arguments)

    spectrum.along, spectrum.jet, nodes._evaluate = counted, counted_jet, counted_nodes
    try:
        landau_batch(*rods)
    finally:
        spectrum.along, spectrum.jet, nodes._evaluate = along, jet, evaluate

    z = np.exp(1j * np.linspace(0, 6, 1024))
    out, matrix = np.empty_like(z), np.ones((32, 32))
    block = np.ones((256, 32))

    def speed(work: Callable[[], Any], size: float) -> float:
        return timed(lambda: [work() for _ in range(300)], 5)[0] / 300 / size

    exp, sqrt = speed(lambda: np.exp(z, out=out), 1024), speed(lambda: np.sqrt(z, out=out), 1024)
    product = speed(lambda: np.multiply(z, z, out=out), 1024)
    gemm = speed(lambda: block @ matrix, 256 * 32 * 32)
    count = len(rods[0])
    each = np.array([calls["points"], calls["jets"], calls["nodes"]]) / count
    kinds = each @ np.array([POINT, JET, NODE])
    print(f"a rod takes {each[0]:.0f} points of lines, {each[1]:.0f} jets, {each[2]:.0f} nodes of modes:")
    print(
        f"  {kinds[0]:.0f} exponentials at {exp * 1e9:.1f} ns, {kinds[1]:.0f} roots at {sqrt * 1e9:.1f} ns,"
    )
    print(
        f"  {kinds[2]:.0f} products at {product * 1e9:.2f} ns, "
        f"{calls['matrix'] / count:.0f} real multiply-adds at {gemm * 1e9:.3f} ns"
    )
    return float(kinds @ [exp, sqrt, product] + calls["matrix"] / count * gemm) * count


def jaxcont(python: Path) -> dict[str, float]:
    """Seconds for its Lyapunov coefficient, compiled, and what it is, on the paper's first rod."""
    program = """
import json, sys, time
sys.path.insert(0, "peers")
from jaxcont_rod import *
f, straight = rod(1e4, 1e4, 1e-4, 0.5, 28)
q, F = straight(37.66), 37.66
for _ in range(2):
    q, F, q1, q2, omega, _ = hopf_point(f, q, F, tol=1e-3, max_iter=30)
seconds = []
for _ in range(4):
    begin = time.process_time()
    l1 = float(lyapunov_coefficient(f, q, F, q1, q2, omega))
    seconds.append(time.process_time() - begin)
print(json.dumps({"seconds": min(seconds), "l1": l1}))
"""
    done = subprocess.run([python, "-c", program], capture_output=True, text=True, check=True)
    return dict(json.loads(done.stdout.splitlines()[-1]))


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--rods", type=int, default=16384)
    parser.add_argument("--single", type=int, default=60)
    parser.add_argument("--jaxcont", type=Path)
    parser.add_argument("--numpy", action="store_true", help="nothing compiled")
    parser.add_argument("--model", default="follower", help="another rod: the batch alone, own defaults")
    arguments = parser.parse_args()
    rods, model = sample(arguments.rods), emitted(arguments.model)
    if arguments.numpy:
        batch.COMPILED_FROM = arguments.rods + 1
    landau_batch(*(p[:2000] for p in rods), model=model)
    seconds, found = timed(lambda: landau_batch(*rods, model=model))
    per_rod = seconds / arguments.rods
    thresholds = int(found.count.sum())
    print(f"batch: {1 / per_rod:.0f} rods/s, {per_rod * 1e6:.1f} us a rod, {thresholds} thresholds")
    statuses = ", ".join(s.name.lower() for s in Status)
    print(f"  status: {np.bincount(found.status, minlength=len(Status)).tolist()} ({statuses})")
    if arguments.model != "follower":
        return
    bound = ideal(rods)
    print(
        f"  these alone: {arguments.rods / bound:.0f} rods/s; "
        f"the batch takes {seconds / bound:.2f} times as long"
    )

    few = [RodParameters(*(float(p[i]) for p in rods)) for i in range(arguments.single)]
    seconds, single = timed(lambda: [landau(rod) for rod in few], 1)
    one = seconds / arguments.single
    worst = max(
        (abs(found.alpha[i, j] / c.alpha - 1) for i, s in enumerate(single) for j, c in enumerate(s)),
        default=0.0,
    )
    print(f"rodwnl.landau: {one * 1e3:.1f} ms a rod; the batch is {one / per_rod:.0f} times as fast")
    print(f"  largest relative difference in alpha: {worst:.1e}")

    (exact,) = landau(RodParameters(*PAPER))
    seconds, form = timed(lambda: normal_form(follower(*PAPER), exact.force, exact.omega))
    per_threshold = per_rod * arguments.rods / thresholds
    print(f"discretised normal form: {seconds * 1e3:.1f} ms a threshold (given it), alpha to ", end="")
    print(
        f"{abs(form.alpha / exact.alpha - 1):.1e}; the batch is {seconds / per_threshold:.0f} times as fast"
    )
    if arguments.jaxcont:
        answer = jaxcont(arguments.jaxcont)
        print(
            f"jaxcont's Lyapunov coefficient: {answer['seconds'] * 1e3:.1f} ms a threshold (given it, ",
            end="",
        )
        print(f"real part only); the batch is {answer['seconds'] / per_threshold:.0f} times as fast")


if __name__ == "__main__":
    with threadpool_limits(1):
        main()
