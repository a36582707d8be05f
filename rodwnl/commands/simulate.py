"""`rodwnl simulate`: the full nonlinear rod in time, and what its tip does in the end."""

import sys
from collections.abc import Iterator
from contextlib import contextmanager
from fractions import Fraction
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from rodwnl.errors import InputError
from rodwnl.options import Json, read_force, takes_rod
from rodwnl.output import measured, print_json, print_table
from rodwnl.parameters import RodParameters, decimal_text, positive
from rodwnl.report import heading, rod_document, rod_sentence, scale, with_unit

if TYPE_CHECKING:
    from rodwnl.readout import Reading
    from rodwnl.reduced import ReducedModel
    from rodwnl.simulation import Progress, Simulation

INTERRUPTED = 130


@takes_rod
def command(
    rod: RodParameters,
    force: Annotated[str, typer.Option(metavar="F", help="The force, 0 < F < k1.")],
    time: Annotated[str, typer.Option(metavar="T", help="How long to simulate.")] = "5",
    perturbation: Annotated[
        str, typer.Option(metavar="E", help="Size of the first sine in y (in L) and in the angle.")
    ] = "1e-2",
    nodes: Annotated[str, typer.Option(metavar="N", help="Chebyshev intervals along the rod.")] = "auto",
    rtol: Annotated[str, typer.Option(metavar="R", help="Tolerance of the integrator.")] = "1e-8",
    reduced: Annotated[bool, typer.Option("--reduced", help="The amplitude equation beside it.")] = False,
    check: Annotated[
        bool, typer.Option("--check", help="Again with twice the time, and with a finer grid and tolerance.")
    ] = False,
    out: Annotated[Path | None, typer.Option(metavar="FILE.nc", help="Write the run as netCDF.")] = None,
    overwrite: Annotated[bool, typer.Option("--overwrite", help="Replace the run in FILE.nc.")] = False,
    animate: Annotated[
        Path | None, typer.Option(metavar="FILE.gif|mp4", help="Draw the last beats as a film.")
    ] = None,
    json: Json = False,
) -> int:
    """Integrate the exact equations of the rod and read how its tip beats, or where it comes to rest.

    The rod starts compressed and straight with a small sinusoidal perturbation. As in the paper, the
    amplitude is half the peak-to-peak of the tip in the second half of the run, and the frequency the peak of
    its spectrum. Ctrl-C ends the run early; what was computed is still read and written.
    """
    from rodwnl.simulation import expected_size, simulate

    exact = read_force(rod, "force", force)
    duration = positive("time", time) / (rod.scales.time if rod.scales else 1)
    chosen = _nodes(nodes)
    tolerance = float(positive("rtol", rtol))
    _require_writable(out, overwrite, animate, expected_size(rod, exact, duration))
    # It may be refused; a run that is finished is not to be lost then.
    model = _reduced_model(rod, exact) if reduced else None
    with _progress("simulating") as progress:
        run = simulate(rod, exact, duration, perturbation, chosen, tolerance, progress)
    if out is not None:
        from rodwnl.simulation import to_dataset
        from rodwnl.storage import save

        save(to_dataset(run), out)
    if animate is not None:
        from rodwnl.animation import film

        film(run, animate)
    readings: dict[str, Reading | None] = {"full rod": run.reading}
    if model is not None:
        readings["reduced model"] = _reduced(model, run)
    if check and run.complete:
        again: dict[str, dict[str, Any]] = {
            "twice the time": {"time": 2 * duration},
            "finer": {"nodes": min(128, 3 * (run.nodes.size - 1) // 2), "rtol": tolerance / 10},
        }
        usual = {"time": duration, "perturbation": perturbation, "nodes": chosen, "rtol": tolerance}
        for name, changed in again.items():
            with _progress(name) as progress:
                readings[name] = simulate(rod, exact, **{**usual, **changed}, progress=progress).reading
    if json:
        print_json(_document(run, exact, readings))
    else:
        _print(run, exact, readings)
    return 0 if run.complete else INTERRUPTED


def _nodes(text: str) -> Any:
    if text == "auto":
        return text
    if text.isascii() and text.isdigit():
        return int(text)
    raise InputError(f"nodes is {text!r}, but it must be auto or a whole number from 8 to 128")


def _require_writable(out: Path | None, overwrite: bool, film: Path | None, size: int) -> None:
    from rodwnl.storage import require_new, require_writable

    if out is not None:
        from rodwnl.simulation import is_run

        if out.suffix != ".nc":
            raise InputError(f"cannot write the run to {out}: its name must end in .nc (netCDF)")
        require_writable(out, size)
        require_new(out, overwrite, is_run, "a run that simulate wrote")
    elif overwrite:
        raise InputError("--overwrite says that --out may replace an earlier run: give --out FILE.nc too")
    if film is not None:
        from rodwnl.animation import require_format

        require_format(film)
        require_writable(film)


@contextmanager
def _progress(what: str) -> "Iterator[Progress | None]":
    """A bar on a terminal's stderr, nothing elsewhere."""
    if not sys.stderr.isatty():
        yield None
        return
    from rich.console import Console
    from rich.progress import Progress as Bar

    with Bar(console=Console(stderr=True), transient=True) as bar:
        task = bar.add_task(what, total=1.0)
        yield lambda done: bar.update(task, completed=done)


def _reduced_model(rod: RodParameters, force: Fraction) -> "ReducedModel":
    from rodwnl.reduced import reduced_model

    return reduced_model(rod, force)


def _reduced(model: "ReducedModel", run: "Simulation") -> "Reading | None":
    """The amplitude equation from the same perturbation, read like the run; None where it runs away."""
    import numpy as np

    from rodwnl.errors import ComputationError
    from rodwnl.readout import read

    wave = run.perturbation * np.sin(np.pi * model.u / 2)
    try:
        A = model.transient(model.amplitude(wave, wave), run.time)
    except ComputationError:
        return None
    return read(run.time, 2 * (A * np.exp(1j * model.coefficients.omega * run.time)).real)


def _print(run: "Simulation", force: Fraction, readings: "dict[str, Reading | None]") -> None:
    rod = run.rod
    time = run.time[-1] * (float(rod.scales.time) if rod.scales else 1.0)
    print(rod_sentence(rod))
    until = f"t = {time:.6g}{' s' if rod.scales else ''}{'' if run.complete else ' (interrupted)'}"
    print(f"Simulated at force = {with_unit(rod, 'force', force)} until {until} in {run.seconds:.1f} s.")
    print(
        f"{run.nodes.size - 1} Chebyshev intervals; last coefficients {run.tail:.0e}, tip conditions "
        f"{run.tip_residual:.0e}{'' if run.resolved else ' (NOT RESOLVED: more nodes are needed)'}."
    )
    full = run.reading
    print(_STATES.get(full.state) or _not_finished(run))
    buckled = any(reading and reading.state == "buckled" for reading in readings.values())
    names = ("A_tip", "omega", "y_tip") if buckled else ("A_tip", "omega")
    rows = []
    for name, reading in readings.items():
        if reading is None:
            rows.append([name, RUNS_AWAY, *["-"] * (len(names) * (1 + (len(readings) > 1)))])
            continue
        values = [_cell(rod, n, getattr(reading, n), getattr(reading, f"{n}_error")) for n in names]
        changes = [
            _relative(getattr(reading, n), getattr(full, n)) if reading is not full else "" for n in names
        ]
        rows.append([name, reading.state, *values, *(changes if len(readings) > 1 else [])])
    changes = [f"change of {names[0]}", *(f"of {n}" for n in names[1:])] if len(readings) > 1 else []
    print_table(["", "state", *(heading(rod, n) for n in names), *changes], rows)


def _cell(rod: RodParameters, name: str, value: float | None, error: float | None) -> str:
    """What was read, in the rod's units; what has not settled with its error."""
    if value is None or error is None:
        return "-"
    return measured(value * scale(rod, name), error * scale(rod, name))


RUNS_AWAY = "leaves every bound"  # the amplitude equation, where its cubic term drives and does not limit

_STATES = {
    "settled": "The oscillation has settled.",
    "decayed": "The oscillation has decayed.",
    "buckled": "The rod has buckled: its tip has come to rest away from the straight rod.",
}


def _not_finished(run: "Simulation") -> str:
    growth = run.reading.growth
    if growth is None:
        return "The run has not finished: late in it the tip neither beats about one place nor comes to rest."
    change = "grows" if growth > 0 else "decays"
    return f"The run has not finished: the amplitude still {change}, d ln A/dt = {growth:.3g}."


def _relative(value: float | None, reference: float | None) -> str:
    return "-" if value is None or not reference else f"{value / reference - 1:+.1e}"


def _document(run: "Simulation", force: Fraction, readings: "dict[str, Reading | None]") -> dict[str, Any]:
    entries = {name.replace(" ", "_"): _entry(reading) for name, reading in readings.items()}
    return rod_document(run.rod) | {
        "force": decimal_text(force),
        "simulation": entries.pop("full_rod")
        | {
            "time": repr(float(run.time[-1])),
            "perturbation": repr(run.perturbation),
            "rtol": repr(run.rtol),
            "nodes": run.nodes.size - 1,
            "complete": run.complete,
            "resolved": run.resolved,
            "spectral_tail": repr(run.tail),
            "tip_residual": repr(run.tip_residual),
            "evaluations": {"right_hand_side": run.evaluations[0], "jacobian": run.evaluations[1]},
        },
        **entries,
    }


def _entry(reading: "Reading | None") -> dict[str, Any]:
    if reading is None:
        return {"state": RUNS_AWAY}
    names: tuple[str, ...] = ("A_tip", "A_tip_error", "omega", "omega_error", "growth")
    if reading.state == "buckled":
        names += ("y_tip", "y_tip_error")
    values = {name: getattr(reading, name) for name in names}
    return {"state": reading.state} | {k: None if v is None else repr(float(v)) for k, v in values.items()}
