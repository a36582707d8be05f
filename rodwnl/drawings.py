"""The figures, each drawn from computed records and returned with its caption and its data."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from itertools import pairwise
from textwrap import wrap
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from rodwnl.animation import ARROW, STYLE, load_arrows
from rodwnl.collocation import interpolation
from rodwnl.errors import InputError
from rodwnl.figuredata import Column, Comparison, EigenvaluePath, SimulatedPoint, by_rod
from rodwnl.output import complex_number, measured
from rodwnl.parameters import PLAIN, RodParameters
from rodwnl.reduced import ReducedModel
from rodwnl.simulation import Simulation
from rodwnl.storage import require
from rodwnl.straightrod import parameter_values

if TYPE_CHECKING:
    import xarray

LIGHT, DARK, RED, BLUE = "0.55", "0.1", "#c8553d", "#2a6f97"
SNAPSHOTS = 10
TITLE = 24  # characters that stand over a narrow panel
# State of a simulation -> its marker, the marker's face, and what the key says
_SIMULATED = {
    "settled": ("o", RED, "simulation"),
    "not finished": ("o", "none", "simulation, not settled"),
    "decayed": ("x", RED, "simulation, came to rest"),
}
LETTERS = "abcdefghijklmnopqrstuvwxyz"
FORCE, TIME = "force $F$  ($k_3/L^2$)", r"$t$  ($\gamma_2 L^4/k_3$)"
RATE = r"$k_3/\gamma_2 L^4$"


@dataclass(frozen=True)
class Drawing:
    """A finished figure: its file name, caption and data (header and rows of a CSV)."""

    name: str
    caption: str
    figure: Any
    header: Sequence[str]
    rows: Sequence[Sequence[Any]]


@contextmanager
def style() -> Iterator[Any]:
    """matplotlib's Figure, in the style of the project and without a window system."""
    require("matplotlib", "figures").use("Agg")
    from matplotlib import pyplot
    from matplotlib.figure import Figure

    with pyplot.style.context(STYLE):
        yield Figure


def hopf(columns: Sequence[Column], path: EigenvaluePath) -> Drawing:
    """fig:hopf: Re λ and Im λ over the force, and the path of the pair in the complex plane."""
    with style() as Figure:
        figure = Figure(figsize=(4.6, 5.2))
        top, bottom = figure.subplots(2, 1)
        _parts(top, path, columns)
        re, im = path.eigenvalue.real, path.eigenvalue.imag
        bottom.axvline(0, color="0.7", linewidth=0.6, zorder=0)
        for j, color in ((1, LIGHT), (0, DARK)):
            bottom.plot(re[:, j], im[:, j], color=color)
            moved = np.concatenate([[0], np.cumsum(np.hypot(np.diff(re[:, j]), np.diff(im[:, j])))])
            for k in np.searchsorted(moved, moved[-1] * np.array([0.25, 0.5, 0.8])):
                ends = (re[k - 1, j], im[k - 1, j]), (re[k, j], im[k, j])
                arrow = {"arrowstyle": "-|>", "color": color, "lw": 1.2}
                bottom.annotate("", ends[1], ends[0], arrowprops=arrow)
        for column in columns:
            c = column.coefficients
            bottom.plot([0, 0], [c.omega, -c.omega], "o", color=RED)
            offset, side = ((-4, 5), "right") if column is columns[0] else ((4, 5), "left")
            text = f"$F = {c.force:.2f}$"
            bottom.annotate(text, (0, c.omega), offset, textcoords="offset points", ha=side)
        bottom.set(xlabel=rf"Re $\lambda$  ({RATE})", ylabel=rf"Im $\lambda$  ({RATE})")
    caption = (
        f"Spectrum of the straight rod, {_values(columns[0].rod)}: the critical pair of eigenvalues over "
        "the force (top; real parts solid, imaginary parts dashed, the other of the pair grey; thresholds "
        "and frequencies dotted) and its path in the complex plane as the force grows (bottom, arrows). The "
        f"rod is unstable {_unstable(columns)}."
    )
    return Drawing("hopf", caption, figure, *_path_table([(columns[0], path)]))


def _unstable(columns: Sequence[Column]) -> str:
    """Between which of its thresholds a rod is unstable, in words."""
    said = []
    for column in columns:
        c = column.coefficients
        at = f"F = {c.force:.2f} (ω = {c.omega:.6g})"
        if column.side > 0:
            said.append(f"beyond the threshold {at}")
        elif said:
            said[-1] = said[-1].replace("beyond the threshold", "between the thresholds") + f" and {at}"
        else:
            said.append(f"up to the threshold {at}")
    return " and ".join(said)


def beta_check(columns: Sequence[Column], paths: Sequence[EigenvaluePath]) -> Drawing:
    """fig:beta_check: the eigenvalue branches with tangents of slope β at the thresholds."""
    rods = by_rod(columns)
    with style() as Figure:
        figure = Figure(figsize=(2.4 * max(len(rods), 2), 2.6))
        panels = figure.subplots(1, len(rods), squeeze=False)[0]
        for panel, here, path, letter in zip(panels, rods, paths, LETTERS, strict=False):
            _parts(panel, path, here, legend=letter == "a")
            for other in here:
                c = other.coefficients
                step = 0.06 * (path.force[-1] - path.force[0]) * np.array([-1, 1])
                for value, slope in ((0.0, c.beta.real), (c.omega, c.beta.imag)):
                    panel.plot(c.force + step, value + slope * step, color=RED, linewidth=2.2, alpha=0.8)
            panel.set_title(f"({letter}) {_values(here[0].rod)}", loc="left", fontsize=6.5)
    slopes = [
        f"{_values(column.rod)}, F = {column.coefficients.force:.2f}: "
        f"β = {complex_number(column.coefficients.beta, digits=6)}, "
        f"dλ/dF = {complex_number(column.coefficients.threshold.slope, digits=6)}."
        for column in columns
    ]
    caption = (
        "Eigenvalue branches (real parts solid, imaginary parts dashed, the other of the pair grey) through "
        "the Hopf thresholds (dotted), with the tangents whose slopes are Re β and Im β of the weakly "
        "nonlinear theory (red). " + " ".join(slopes)
    )
    table = _path_table([(rod[0], path) for rod, path in zip(rods, paths, strict=True)])
    return Drawing("beta_check", caption, figure, *table)


def _parts(panel: Any, path: EigenvaluePath, columns: Sequence[Column], legend: bool = True) -> None:
    """Re λ solid and Im λ dashed over the force, thresholds and frequencies dotted."""
    panel.axhline(0, color="0.7", linewidth=0.6, zorder=0)
    for j, color in ((1, LIGHT), (0, DARK)):
        re, im = path.eigenvalue[:, j].real, path.eigenvalue[:, j].imag
        panel.plot(path.force, re, color=color, label="" if j else r"Re $\lambda$")
        panel.plot(path.force, im, "--", color=color, label="" if j else r"Im $\lambda$")
    for column in columns:
        c = column.coefficients
        panel.axvline(c.force, color="0.3", linestyle=":", linewidth=0.8)
        panel.axhline(c.omega, color="0.3", linestyle=":", linewidth=0.8)
    panel.set(xlabel=FORCE, ylabel=rf"$\lambda$  ({RATE})")
    if legend:
        panel.legend(loc="best")


def nonlinear(run: Simulation) -> Drawing:
    """fig:nonlinear: snapshots of one beat with the follower force, and the tip's motion."""
    last = run.frame_time.size - 1
    period = last
    if run.reading.omega:
        period = min(last, round(2 * np.pi / run.reading.omega / (run.time[1] - run.time[0])))
    shown = np.linspace(last - period, last, SNAPSHOTS + 1).astype(int)[1:]
    smooth = interpolation(run.nodes.size - 1, np.linspace(0, 1, 101)).T
    x, y = run.x[shown] @ smooth, run.y[shown] @ smooth
    with style() as Figure:
        figure = Figure(figsize=(5.2, 5.0))
        above, below = figure.subfigures(2, 1, height_ratios=[3, 2])
        shapes = above.subplots()
        for k, shade in enumerate(np.linspace(0.78, 0.0, SNAPSHOTS)):
            shapes.plot(x[k], y[k], color=str(shade), linewidth=1.4)
        load_arrows(shapes, x[:, -1], y[:, -1], run.tip_load[shown], RED)
        reach = float(np.abs(y).max()) + 0.75 * ARROW
        shapes.set(xlabel="$x/L$", ylabel="$y/L$", aspect="equal", xlim=(-0.03, 1.15), ylim=(-reach, reach))
        growing, beating = below.subplots(1, 2, sharey=True, width_ratios=[3, 2])
        early, late = run.time < 0.3 * run.time[-1], slice(-3 * period, None)
        growing.plot(run.time[early], run.tip_y[early], color=DARK, linewidth=0.6)
        beating.plot(run.time[late], run.tip_y[late], color=DARK, linewidth=0.9)
        for panel in (growing, beating):
            panel.set(xlabel=TIME, xmargin=0)
        growing.set(ylabel="$y(1, t)/L$")
    read = f"The oscillation has {run.reading.state}."
    if run.reading.A_tip is not None and run.reading.omega is not None:
        read = f"A_tip = {run.reading.A_tip:.6g}, ω = {run.reading.omega:.7g}."
    caption = (
        f"Beating rod, {_values(run.rod)}, F = {run.force:g}, full nonlinear equations. Top: {SNAPSHOTS} "
        f"shapes of one period, the later the darker{_load(run)}. Bottom: the tip "
        f"from the perturbed straight rod on (perturbation {run.perturbation:g}), and its last three "
        f"periods; times in γ2 L⁴/k3. {read}"
    )
    rows = np.column_stack([run.time, run.tip_x, run.tip_y, run.tip_theta]).tolist()
    return Drawing("nonlinear", caption, figure, ("t", "tip_x", "tip_y", "tip_theta"), rows)


def one_run(dataset: xarray.Dataset) -> Drawing:
    """A simulation read from its file: the tip over time, its last beats, the shapes of the last one."""
    names = ("time", "tip_y", "frame_time", "x", "y", "theta")
    if missing := [name for name in names if name not in dataset.variables]:
        raise InputError(f"this file holds no simulation of a rod: {', '.join(missing)} missing")
    time, tip_y, frame_time, x, y, theta = (dataset[name].to_numpy() for name in names)
    load = np.stack([-np.cos(theta[:, -1]), -np.sin(theta[:, -1])], axis=-1)  # a file from before it was kept
    if "load_x" in dataset.variables:
        load = np.stack([dataset["load_x"].to_numpy(), dataset["load_y"].to_numpy()], axis=-1)
    attributes = dataset.attrs
    omega = float(attributes.get("omega", 2 * np.pi / (frame_time[-1] - frame_time[0])))
    beat = np.flatnonzero(frame_time >= frame_time[-1] - 2 * np.pi / omega)
    shown = beat[:: max(1, beat.size // SNAPSHOTS)]
    with style() as Figure:
        figure = Figure(figsize=(7.2, 3.6))
        history, shapes = figure.subplots(1, 2)
        history.plot(time, tip_y, color=DARK, linewidth=0.4)
        history.set(xlabel=TIME, ylabel="$y(1, t)/L$", xmargin=0)
        for k, shade in zip(shown, np.linspace(0.78, 0.0, shown.size), strict=True):
            shapes.plot(x[k], y[k], color=str(shade), linewidth=1.2)
        load_arrows(shapes, x[shown, -1], y[shown, -1], load[shown], RED)
        shapes.set(xlabel="$x/L$", ylabel="$y/L$", aspect="equal", xlim=(-0.03, 1.2))
        reach = float(np.abs(y[shown]).max()) + ARROW
        shapes.set(ylim=(-reach, reach))
    names_of = str(attributes.get("parameters", "k1 k2 gamma3 gamma1")).split()
    shown_names = [name for name in ("model", *names_of, "force") if name in attributes]
    known = [f"{name} = {attributes[name]}" for name in shown_names]
    read = [
        f"{name} = {measured(attributes[name], attributes.get(f'{name}_error', 0.0))}"
        for name in ("A_tip", "omega", "y_tip")
        if name in attributes
    ]
    state = f"; {attributes['state']}" if "state" in attributes else ""
    caption = ", ".join([*known, *read]) + state
    figure.suptitle(caption, fontsize=6.5)
    return Drawing("run", caption, figure, ("t", "tip_y"), np.column_stack([time, tip_y]).tolist())


def compared(columns: Sequence[Comparison]) -> Drawing:
    """fig:comparison: amplitude and frequency by theory, simulation and periodic orbits."""
    rows: list[list[Any]] = []
    with style() as Figure:
        figure = Figure(figsize=(1.85 * max(len(columns), 2), 4.0))
        axes = figure.subplots(2, len(columns), squeeze=False)
        letters_of = [LETTERS[k : k + 2] for k in range(0, 2 * len(columns), 2)]
        for (top, bottom), item, letters in zip(axes.T, columns, letters_of, strict=True):
            _compare(item, top, 1)
            _compare(item, bottom, 2)
            first, rest = _values(item.column.rod).split(", γ3")
            lines = [f"({letters[0]}) {first},", *wrap(f"γ3{rest}", TITLE)]
            top.set_title("\n".join(lines), loc="left", fontsize=6)
            bottom.set_title(f"({letters[1]})", loc="left", fontsize=6)
            top.set(ylim=(-0.03 * top.get_ylim()[1], None))
            bottom.set(xlabel=FORCE)
            rows += _comparison_rows(item, letters)
        axes[0, 0].set(ylabel=r"$A_\mathrm{tip}/L$")
        axes[1, 0].set(ylabel=rf"$\omega$  ({RATE})")
        _key(figure, axes)
    folds = [f"F = {fold[0]:.8g}" for item in columns for fold in item.folds]
    caption = (
        "Tip amplitude (top) and frequency (bottom) of the oscillating rod: amplitude equation (black; "
        "unstable dashed), periodic orbits of the full rod (blue; unstable dashed; folds marked by "
        "diamonds), simulations (red circles, open where they had not settled; crosses where the rod came "
        f"to rest). Dotted: thresholds. Folds: {', '.join(folds) if folds else 'none in the range'}."
    )
    header = ("panels", "series", "force", "A_tip", "omega", "remark")
    return Drawing("comparison", caption, figure, header, rows)


def _key(figure: Any, axes: NDArray[Any]) -> None:
    """What occurs in the panels, once each, below all of them."""
    from matplotlib.lines import Line2D

    known: dict[str, Any] = {}
    for panel in axes.ravel():
        for handle, label in zip(*panel.get_legend_handles_labels(), strict=True):
            known.setdefault(label, handle)
    if any(line.get_linestyle() == "--" for panel in axes.ravel() for line in panel.lines):
        known["unstable"] = Line2D([], [], linestyle="--", color=LIGHT)
    known["threshold"] = Line2D([], [], linestyle=":", color="0.6", linewidth=0.7)
    figure.legend(known.values(), known.keys(), loc="outside lower center", ncols=4, fontsize=6)


def _compare(item: Comparison, panel: Any, which: int) -> None:
    """One panel: 1 amplitude, 2 frequency."""
    theory = item.theory
    dash = "-" if item.column.supercritical else "--"
    panel.plot(theory[:, 0], theory[:, which], dash, color=DARK, label="amplitude equation")
    along = smooth_branch(item.orbits)
    changes = np.flatnonzero(np.diff(along[:, 3])) + 1
    for k, stretch in enumerate(np.split(np.arange(len(along)), changes)):
        to = np.append(stretch, min(stretch[-1] + 1, len(along) - 1))  # up to where the next one begins
        dash = "-" if along[stretch[0], 3] else "--"
        label = "" if k else "periodic orbits"
        panel.plot(along[to, 0], along[to, which], dash, color=BLUE, linewidth=2.4, alpha=0.55, label=label)
    if len(item.folds):
        panel.plot(item.folds[:, 0], item.folds[:, which], "D", color=BLUE, markersize=4, label="fold")
    for state, (marker, face, label) in _SIMULATED.items():
        found = [(p.force, _value(p, which)) for p in item.points if p.reading.state == state]
        drawn = [(force, value) for force, value in found if value is not None]
        if drawn:
            panel.plot(*zip(*drawn, strict=True), marker, color=RED, markerfacecolor=face, label=label)
    panel.axvline(item.column.coefficients.force, color="0.6", linestyle=":", linewidth=0.7, zorder=0)
    panel.margins(x=0.08)
    panel.locator_params(axis="x", nbins=5, min_n_ticks=3)


def smooth_branch(orbits: NDArray[np.float64], between: int = 12) -> NDArray[np.float64]:
    """More points on a branch (k, 4), by cubic splines through those computed.

    In A_tip², F and ω a branch is smooth, through folds and down to its threshold.
    """
    from scipy.interpolate import CubicSpline

    smooth = np.column_stack([orbits[:, 0], orbits[:, 1] ** 2, orbits[:, 2]])
    lengths = np.linalg.norm(np.diff(smooth, axis=0) / np.ptp(smooth, axis=0), axis=1)
    new = np.append(True, lengths > 1e-9)  # the end stands there twice
    at = np.append(0.0, np.cumsum(lengths))[new]
    fine = np.unique(np.concatenate([np.linspace(a, b, between) for a, b in pairwise(at)]))
    F, square, omega = CubicSpline(at, smooth[new])(fine).T
    stable = orbits[new][np.searchsorted(at, fine, side="right") - 1, 3]
    return np.column_stack([F, np.sqrt(np.maximum(square, 0.0)), omega, stable])


def _value(point: SimulatedPoint, which: int) -> float | None:
    """What a simulation puts into a panel; a rod at rest has amplitude 0 and no frequency."""
    at_rest = point.reading.state == "decayed"
    if which == 1:
        return 0.0 if at_rest else point.reading.A_tip
    return None if at_rest else point.reading.omega


def _comparison_rows(item: Comparison, panels: str) -> list[list[Any]]:
    theory = "stable" if item.column.supercritical else "unstable"
    rows: list[list[Any]] = [[panels, "amplitude equation", *row, theory] for row in item.theory.tolist()]
    rows += [[panels, "orbit", *o[:3], "stable" if o[3] else "unstable"] for o in item.orbits.tolist()]
    rows += [[panels, "fold", *row, ""] for row in item.folds.tolist()]
    for p in item.points:
        remark = f"{p.reading.state}, from {p.perturbation:g}"
        rows.append([panels, "simulation", p.force, p.reading.A_tip, p.reading.omega, remark])
    return rows


def modes(models: Sequence[ReducedModel]) -> Drawing:
    """Y, Θ, their adjoints, X0 and X2 at the thresholds, one line each."""
    labels = {
        "Y": "$Y$", "Theta": r"$\Theta$", "Psi_Y": r"$\Psi_Y$", "Psi_Theta": r"$\Psi_\Theta$",
        "X0": r"Re $X_0$", "X2": "$X_2$",
    }  # fmt: skip
    u = np.linspace(0, 1, 201)
    rows: list[list[Any]] = []
    with style() as Figure:
        figure = Figure(figsize=(7.4, 1.45 * len(models) + 0.4))
        axes = figure.subplots(len(models), len(labels), sharex=True, squeeze=False)
        for line, model in zip(axes, models, strict=True):
            smooth = interpolation(model.u.size - 1, u)
            for panel, name in zip(line, labels, strict=True):
                values = smooth @ getattr(model, name)
                panel.axhline(0, color="0.8", linewidth=0.5, zorder=0)
                panel.plot(u, values.real, color=DARK, label="Re")
                if name != "X0":  # only its real part has a meaning
                    panel.plot(u, values.imag, "--", color=RED, label="Im")
                panel.tick_params(labelsize=5.5)
                columns = (u.tolist(), values.real.tolist(), values.imag.tolist())
                rows += [[repr(model.coefficients.force), name, *row] for row in zip(*columns, strict=True)]
            line[0].set_ylabel(f"$F_c = {model.coefficients.force:.2f}$")
        for panel, label in zip(axes[0], labels.values(), strict=True):
            panel.set_title(label)
        for panel in axes[-1]:
            panel.set_xlabel("$u/L$")
        axes[0, 0].legend(loc="upper left", fontsize=6)
    rods = "; ".join(dict.fromkeys(_values(model.rod) for model in models))
    caption = (
        "Critical modes Y, Θ with Y(1) = 1, adjoint modes with (Ψ, Φ)_Γ = 1, and second-order "
        f"displacements X0, X2 at the Hopf thresholds F_c of these rods: {rods}. "
        "Real parts solid, imaginary parts dashed; of X0 only the real part enters."
    )
    return Drawing("modes", caption, figure, ("F_c", "field", "u", "real", "imag"), rows)


def _values(rod: RodParameters) -> str:
    """A rod in a caption: its parameters, and the name of one that is not the plain one."""
    known = parameter_values(rod)
    plain = f"k1 = {known['k1']:g}, k2 = {known['k2']:g}, γ3 = {known['gamma3']:g}"
    own = "".join(f", {name} = {float(value):g}" for name, value in rod.own)
    return plain + own + ("" if rod.model == PLAIN else f" ({rod.model_name})")


def _load(run: Simulation) -> str:
    """What the arrows at the tip show."""
    if not run.tip_load.any():
        return ""
    return f", with the {'follower force' if run.rod.model == PLAIN else 'load'} at the tip"


def _path_table(paths: Sequence[tuple[Column, EigenvaluePath]]) -> tuple[Sequence[str], list[list[Any]]]:
    header = ("k1", "k2", "gamma3", "force", "re_1", "im_1", "re_2", "im_2")
    rows = [
        [
            *map(float, (column.rod.k1, column.rod.k2, column.rod.gamma3)),
            force,
            pair[0].real,
            pair[0].imag,
            pair[1].real,
            pair[1].imag,
        ]
        for column, path in paths
        for force, pair in zip(path.force.tolist(), path.eigenvalue.tolist(), strict=True)
    ]
    return header, rows
