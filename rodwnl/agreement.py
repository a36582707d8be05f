"""Random rods: whether what float64 reports, with its error estimates, is what the exact route gives.

    python -m rodwnl.agreement --count 10000 --shard 1/2

Rod i of a seed is always the same rod, so a run that is repeated or was cut off goes on where its folder
ends, and shards divide the numbers i among processes. Every line of a file in the folder is one rod with its
verdict.
"""

from __future__ import annotations

import argparse
import json
import random
from collections import Counter
from collections.abc import Iterator
from dataclasses import asdict, dataclass
from pathlib import Path

import mpmath as mp

from rodwnl.coefficients import LandauCoefficients, landau
from rodwnl.errors import ComputationError, InputError
from rodwnl.exact import ExactThreshold, exact_threshold
from rodwnl.parameters import RodParameters

# Decades over which the parameters are spread, uniformly in the logarithm.
RANGES = {"k1": ("20", "1e8"), "k2": ("5", "1e8"), "gamma3": ("1e-8", "1"), "gamma1": ("0.05", "2")}
DIGITS = 20  # of the exact side
STATUSES = ("agrees", "stable", "refused", "wrong")


@dataclass(frozen=True)
class Verdict:
    """What came out for one rod.

    status: agrees (every number lies within its reported error), stable (no threshold), refused (a clear
    error, its text in `detail`), wrong. thresholds: how many were compared. worst: the largest error in
    units of the reported one. digits: relative accuracy, in decimal digits, of the worst number.
    """

    index: int
    rod: dict[str, str]
    status: str
    thresholds: int = 0
    worst: float = 0.0
    digits: float = 0.0
    detail: str = ""


def random_rod(index: int, seed: int = 0) -> RodParameters:
    """Rod number `index`: parameters of four digits, spread over RANGES."""
    source = random.Random(f"{seed}:{index}")
    k1, k2, gamma3, gamma1 = (
        f"{float(low) * (float(high) / float(low)) ** source.random():.4g}" for low, high in RANGES.values()
    )
    return RodParameters(k1, k2, gamma3, gamma1)


def check(index: int, seed: int = 0) -> Verdict:
    """Compare the two routes for one random rod. Any exception but the two clear ones passes through."""
    rod = random_rod(index, seed)
    texts = rod.texts()
    try:
        found = landau(rod, escalate=False)
    except (InputError, ComputationError) as error:
        return Verdict(index, texts, "refused", detail=str(error))
    if not found.thresholds:
        return Verdict(index, texts, "stable")
    try:
        pairs = [(c, exact_threshold(rod, c.force, c.omega, DIGITS)) for c in found]
    except ComputationError as error:
        return Verdict(index, texts, "wrong", len(found), detail=f"exact route: {error}")
    compared = [each for pair in pairs for each in differences(*pair)]
    worst = max(compared, key=lambda each: each.ratio)
    digits = min(each.digits for each in compared)
    status = "agrees" if worst.ratio <= 1 else "wrong"
    detail = "" if worst.ratio <= 1 else f"{worst.name} at force {worst.force!r}"
    return Verdict(index, texts, status, len(found), worst.ratio, digits, detail)


@dataclass(frozen=True)
class Difference:
    """Of one number: |float64 − exact| in units of the reported error, and the digits that agree."""

    name: str
    force: float
    ratio: float
    digits: float


def differences(c: LandauCoefficients, e: ExactThreshold) -> Iterator[Difference]:
    """The six numbers of one threshold, float64 against exact."""
    reported = {
        "force": (c.force, c.threshold.force_error),
        "omega": (c.omega, c.threshold.omega_error),
        "alpha": (c.alpha, c.alpha_error),
        "beta": (c.beta, c.beta_error),
        "A_tip2_slope": (c.A_tip2_slope, c.A_tip2_slope_error),
        "omega_slope": (c.omega_slope, c.omega_slope_error),
    }
    with mp.workdps(e.working_digits):
        for name, (value, error) in reported.items():
            exact = getattr(e, name)
            gap = abs(mp.mpmathify(value) - exact)
            ratio = float(gap / error) if error > 0 else float("inf" if gap else 0)
            yield Difference(name, c.force, ratio, float(-mp.log10(gap / abs(exact))) if gap else 17.0)


def main() -> int:
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("--count", type=int, default=10_000, help="rods in all shards together")
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--shard", default="1/1", help="i/n: this process takes every n-th rod")
    parser.add_argument("--out", type=Path, default=Path("random-rods"), help="folder of the verdicts")
    given = parser.parse_args()
    first, of = (int(part) for part in given.shard.split("/"))
    given.out.mkdir(exist_ok=True)
    done = _read(given.out, given.seed)
    path = given.out / f"seed{given.seed}-{first}-of-{of}.jsonl"
    cut_off = path.exists() and not path.read_bytes().endswith(b"\n")
    with path.open("a", encoding="utf-8") as file:
        file.write("\n" if cut_off else "")
        for index in range(first - 1, given.count, of):
            if index not in done:
                done[index] = check(index, given.seed)
                file.write(json.dumps(asdict(done[index])) + "\n")
                file.flush()
    return _report(list(_read(given.out, given.seed).values()))


def _read(folder: Path, seed: int) -> dict[int, Verdict]:
    """All verdicts in the folder by the rod's number; a line that was cut off is left out."""
    verdicts = {}
    for path in sorted(folder.glob(f"seed{seed}-*.jsonl")):
        for line in path.read_text(encoding="utf-8").splitlines():
            try:
                verdict = Verdict(**json.loads(line))
            except json.JSONDecodeError:
                continue
            verdicts[verdict.index] = verdict
    return verdicts


def _report(verdicts: list[Verdict]) -> int:
    counts = Counter(v.status for v in verdicts)
    print(f"{len(verdicts)} rods:", ", ".join(f"{counts[status]} {status}" for status in STATUSES))
    agreeing = [v for v in verdicts if v.status == "agrees"]
    if agreeing:
        print(f"fewest digits of a rod that agrees: {min(v.digits for v in agreeing):.1f}")
    for v in verdicts:
        if v.status == "wrong":
            print("wrong:", v)
    return 1 if counts["wrong"] else 0


if __name__ == "__main__":
    raise SystemExit(main())
