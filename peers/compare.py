"""Thresholds and slopes of the paper's four rows by programs that nobody here wrote: `make peers`.

Each tool runs as a process of its own in the environment .peers/NAME, is given the exact rod (NAME_rod.py)
and the paper's threshold to start from, and answers in JSON, as `rodwnl landau --json` does. What is compared
does not depend on how a mode is normalised. Prints a table in Markdown.
"""

import json
import subprocess
import sys
import time
from pathlib import Path

HERE = Path(__file__).parent
ENVIRONMENTS = HERE.parent / ".peers"
ROWS = [  # the paper's tab:parameters: k1, k2, gamma3, force, omega
    (1e4, 1e4, 1e-4, 37.66, 191.21),
    (1e4, 1e2, 1e-2, 27.43, 113.55),
    (200, 1e4, 1e-4, 49.76, 334.32),
    (200, 1e4, 1e-4, 155.60, 3367.28),
]
TOOLS = {  # numerical parameters, and those that a tool has no use for
    "jaxcont": ({"degree": 28}, ("omega",)),
    "pyoomph": ({"elements": 160, "steps": 40, "distance": 0.02}, ()),
}
QUANTITIES = ("force", "omega", "A_tip2_slope", "omega_slope")
HEADINGS = ("F_c", "ω_c", "dA_tip²/dF", "dω/dF")


def answer(command: list[str]) -> dict:
    """The JSON that a process prints in the end; {"failed": …} where it does not."""
    done = subprocess.run(command, capture_output=True, text=True)
    if done.returncode:
        return {"failed": (done.stderr.strip().splitlines() or ["no message"])[-1]}
    return json.loads(done.stdout[done.stdout.rindex("\n{") if "\n{" in done.stdout else 0 :])


def ours(k1: float, k2: float, gamma3: float, force: float) -> tuple[dict, float]:
    """The threshold nearest to this force, and the seconds taken, start of the program included."""
    options = [f"--{name}={value!r}" for name, value in (("k1", k1), ("k2", k2), ("gamma3", gamma3))]
    begin = time.perf_counter()
    found = answer([sys.executable, "-m", "rodwnl", "landau", *options, "--json"])["thresholds"]
    seconds = time.perf_counter() - begin
    nearest = min(found, key=lambda threshold: abs(float(threshold["force"]) - force))
    return {name: float(nearest[name]) for name in QUANTITIES}, seconds


def theirs(tool: str, row: tuple[float, ...]) -> dict:
    settings, unused = TOOLS[tool]
    request = dict(zip(("k1", "k2", "gamma3", "force", "omega"), row, strict=True), gamma1=0.5, **settings)
    request = {name: value for name, value in request.items() if name not in unused}
    python = ENVIRONMENTS / tool / "bin" / "python"
    return answer([str(python), str(HERE / f"{tool}_rod.py"), json.dumps(request)])


def compared(tool: str, found: dict, reference: dict) -> list[str]:
    """A line of the table: relative differences from the reference."""
    if "failed" in found:
        return [tool, f"failed: {found['failed']}", *[""] * len(QUANTITIES)]
    if not found.get("converged", True):
        tool += " (did not converge)"
    cells = [
        "cannot" if found[name] is None else f"{found[name] / reference[name] - 1:+.1e}"
        for name in QUANTITIES
    ]
    return [tool, *cells, f"{found['seconds']:.1f}"]


def print_row(cells: list[str]) -> None:
    print("| " + " | ".join(cells) + " |", flush=True)


def main() -> None:
    print_row(["", *HEADINGS, "seconds"])
    print_row(["---"] * (len(HEADINGS) + 2))
    for row in ROWS:
        k1, k2, gamma3, force, _ = row
        reference, seconds = ours(k1, k2, gamma3, force)
        print_row([f"**k1 = {k1:g}, k2 = {k2:g}, gamma3 = {gamma3:g}, F_c near {force:g}**", *[""] * 5])
        print_row(["rodwnl", *(f"{reference[name]:.12g}" for name in QUANTITIES), f"{seconds:.1f}"])
        for tool in TOOLS:
            print_row(compared(tool, theirs(tool, row), reference))


if __name__ == "__main__":
    main()
