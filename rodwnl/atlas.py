"""The atlas of criticality: where in parameter space a rod flutters, up to which force, and how it begins.

Each map is a sweep over a plane of two parameters, with the curves on which the character of a threshold
changes followed by continuation (`rodwnl.curves`): Re α = 0 (bautin) and Re β = 0 (closing).
"""

from __future__ import annotations

import csv
import json
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, replace
from itertools import pairwise
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from rodwnl import kernels
from rodwnl.batch import Status, landau_batch
from rodwnl.batch_characteristic import Real
from rodwnl.curves import Curve, Special, SpecialPoint, special_curve, special_point
from rodwnl.errors import ComputationError, InputError
from rodwnl.grids import NAMES, Grid, grid
from rodwnl.parameters import PLAIN, RodParameters
from rodwnl.storage import replacing, require
from rodwnl.sweep import Progress, sweep

if TYPE_CHECKING:
    import xarray

MAX_FORCE = 1e5  # no less than any k1: forces up to k1 are searched
POINTS = 160  # along each side of a map
K1, K2, GAMMA3 = (20.0, 1e5), (5.0, 1e6), (1e-6, 1.0)
MOST_CURVES = 40  # of one kind in one map

# Character of a rod by the number of its thresholds in 0 < F < k1
REGIONS = {
    0: "no flutter",
    1: "flutter without upper bound",
    2: "reentrant window",
    3: "window, and flutter again",
}
PAPER = ((1e4, 1e4, 1e-4), (1e4, 1e2, 1e-2), (200.0, 1e4, 1e-4))


@dataclass(frozen=True)
class Map:
    """A plane of two parameters, x and y, with the others fixed; those of a model's own have their defaults
    unless they are fixed too.
    """

    name: str
    x: str
    y: str
    fixed: Mapping[str, float]
    model: str = PLAIN

    def grid(self, points: int) -> Grid:
        ranges = {"k1": K1, "k2": K2, "gamma3": GAMMA3}
        axes: dict[str, Any] = {n: {"log": [*ranges[n]], "points": points} for n in (self.x, self.y)}
        return grid(axes | dict(self.fixed) | {"max_force": MAX_FORCE}, self.model)

    @property
    def limits(self) -> dict[str, tuple[float, float]]:
        return {n: {"k1": K1, "k2": K2, "gamma3": GAMMA3}[n] for n in (self.x, self.y)}


MAPS = (
    Map("k1_k2_gamma3_1e-4", "k1", "k2", {"gamma3": 1e-4}),
    Map("k1_k2_gamma3_1e-2", "k1", "k2", {"gamma3": 1e-2}),
    Map("k1_k2_gamma3_1", "k1", "k2", {"gamma3": 1.0}),
    Map("k1_gamma3_k2_1e4", "k1", "gamma3", {"k2": 1e4}),
)


@dataclass(frozen=True)
class Sheet:
    """One map: its sweep as a dataset, and its special curves."""

    map: Map
    data: xarray.Dataset
    curves: tuple[tuple[Special, Curve], ...]

    @property
    def own(self) -> dict[str, float]:
        """The values of the model's own parameters."""
        return {name: float(self.data[name]) for name in kernels.own_parameters(self.map.model)}


@dataclass(frozen=True)
class Witness:
    """A rod of some region whose branch at one threshold was computed as orbits of the full nonlinear rod.

    predicted: d(A_tip²)/dF from α, β; seen: from the branch, extrapolated to the threshold.
    """

    region: str
    rod: tuple[float, float, float]
    threshold: int
    force: float
    criticality: str
    predicted: float
    seen: float
    stable: bool


def make(
    folder: Path,
    points: int = POINTS,
    workers: int | None = None,
    watch: Callable[[str], None] = print,
    model: str = PLAIN,
    own: Mapping[str, float] | None = None,
) -> None:
    """Compute all maps into the folder: data (.nc), curves (.csv), figures (.svg, .png), and summary.json.

    Of another model than the plain one, with these values of its own parameters; branches of orbits are
    followed for the plain rod alone. Raises InputError for a rod whose straight state is not uniform.
    """
    from rodwnl.maps import draw

    if not kernels.is_uniform(model):
        raise InputError(
            f"an atlas needs coefficients that are constant along the rod, which they are not under the load "
            f"of {Path(model).name!r}; `rodwnl sweep` takes it, rod by rod"
        )
    maps = [replace(one, fixed=dict(one.fixed) | dict(own or {}), model=model) for one in MAPS]
    maps[0].grid(2)  # refuses what is wrong before anything is written
    folder.mkdir(parents=True, exist_ok=True)
    sheets = []
    for one in maps:
        watch(f"computing {one.name}")
        sheets.append(compute(one, folder, points, workers, watch=watch))
    for sheet in sheets:
        watch(f"drawing {sheet.map.name}")
        _write_curves(sheet, folder / f"{sheet.map.name}.csv")
        draw(sheet, folder / sheet.map.name)
    summary: dict[str, Any] = {"maps": {s.map.name: count(s.data) for s in sheets}}
    if model == PLAIN:
        watch("following branches of orbits")
        summary["witnesses"] = [vars(w) for w in witnesses()]
    else:
        summary |= {"model": Path(model).name, "parameters": sheets[0].own}
    with replacing(folder / "summary.json") as temporary:
        temporary.write_text(json.dumps(summary, indent=1), encoding="utf-8")


def compute(
    one: Map,
    folder: Path,
    points: int,
    workers: int | None,
    progress: Progress = lambda *_: None,
    watch: Callable[[str], None] = lambda text: None,
) -> Sheet:
    """The sweep of one map, kept in the folder, and its special curves."""
    xr = require("xarray", "sweep")
    path = folder / f"{one.name}.nc"
    sweep(one.grid(points), path, workers=workers, overwrite=True, progress=progress)
    with xr.open_dataset(path, engine="h5netcdf") as dataset:
        data = dataset.load()
    return Sheet(one, data, tuple(special_curves(one, data, watch)))


def buckling(data: xarray.Dataset) -> NDArray[np.bool_]:
    """Which rods have an unstable real eigenvalue at some force, or without one."""
    return np.asarray(np.isfinite(data.buckling_force.values) | (data.status.values == Status.UNSTABLE))


def count(data: xarray.Dataset) -> dict[str, Any]:
    """Rods per region, and thresholds by kind of crossing and criticality.

    Rods that buckle are in none of the regions by the number of thresholds.
    """
    buckles = buckling(data)
    regular = ~buckles & (data.status.values != Status.FAILED)
    number, crossing, alpha = (
        data["count"].values,
        data.crossing.values * regular[..., None],
        data.alpha_re.values,
    )
    order = np.cumsum(crossing == 1, axis=-1)  # 1: up to the second destabilizing crossing
    kinds = {
        "lower": (crossing == 1) & (order == 1),
        "upper": crossing == -1,
        "again": (crossing == 1) & (order > 1),
    }
    return {
        "rods": int(number.size),
        "regions": {name: int(np.sum(regular & (number == n))) for n, name in REGIONS.items()},
        "buckle": int(np.sum(buckles & (number == 0))),
        "buckle and flutter": int(np.sum(buckles & (number > 0))),
        "thresholds": {
            kind: {
                "supercritical": int(np.sum(where & (alpha < 0))),
                "subcritical": int(np.sum(where & (alpha > 0))),
            }
            for kind, where in kinds.items()
        },
        "failed": int(np.sum(data.status.values == Status.FAILED)),
    }


# ---- special curves


def special_curves(
    one: Map, data: xarray.Dataset, watch: Callable[[str], None] = lambda text: None
) -> Iterator[tuple[Special, Curve]]:
    """Every curve of special points that is seen between neighbouring rods of the map.

    A change that lies on a curve already followed gives nothing new; others start a curve, which is
    followed both ways to the edges of the map, up to MOST_CURVES of a kind, which is said.
    """
    known: dict[Special, list[Real]] = {"bautin": [], "closing": []}
    cut: set[Special] = set()
    for kind, rod, force, omega in _changes(one, data):
        here = np.log([rod[n] for n in (one.x, one.y)])
        if any(np.min(np.hypot(*(path - here[:, None]))) < 3 * _spacing(data, one) for path in known[kind]):
            continue
        if len(known[kind]) >= MOST_CURVES:
            if kind not in cut:
                watch(f"{one.name}: of the curves of {kind} points only the first {MOST_CURVES} are followed")
            cut.add(kind)
            continue
        try:
            at = RodParameters(model=one.model, **rod)  # type: ignore[arg-type]
            point = special_point(kind, at, {one.x: None}, force, omega)
        except ComputationError:
            continue
        for curve in _both_ways(point, one):
            yield kind, curve
            known[kind].append(np.log([curve.rods[one.x], curve.rods[one.y]]))


def _spacing(data: xarray.Dataset, one: Map) -> float:
    return max(float(np.log(data[n].values[1] / data[n].values[0])) for n in (one.x, one.y))


def _changes(one: Map, data: xarray.Dataset) -> Iterator[tuple[Special, dict[str, float], float, float]]:
    """Starts for special points, between rods next to each other in x.

    There Re α changes its sign at a threshold, or two thresholds vanish.
    """
    names = (*NAMES, *kernels.own_parameters(one.model))
    rods = {n: float(data[n]) if data[n].ndim == 0 else np.nan for n in names}
    number, force, omega, alpha = (
        data[n].transpose(one.x, one.y, ...).values for n in ("count", "force", "omega", "alpha_re")
    )
    crossing = data.crossing.transpose(one.x, one.y, ...).values
    x, y = data[one.x].values, data[one.y].values
    for j in range(len(y)):
        for i, k in pairwise(range(len(x))):
            rod = rods | {one.x: float(np.sqrt(x[i] * x[k])), one.y: float(y[j])}
            for t in range(min(number[i, j], number[k, j])):
                same = crossing[i, j, t] == crossing[k, j, t]
                if same and alpha[i, j, t] * alpha[k, j, t] < 0:
                    yield (
                        "bautin",
                        rod,
                        float((force[i, j, t] + force[k, j, t]) / 2),
                        float(np.sqrt(omega[i, j, t] * omega[k, j, t])),
                    )
            more, fewer = (i, k) if number[i, j] > number[k, j] else (k, i)
            if number[more, j] == number[fewer, j] + 2:
                t = int(number[fewer, j])  # the pair of thresholds that meet
                low = slice(t, t + 2)
                start = rod | {one.x: float(x[more])}
                yield (
                    "closing",
                    start,
                    float(force[more, j, low].mean()),
                    float(np.sqrt(omega[more, j, low].prod())),
                )


def _both_ways(point: SpecialPoint, one: Map) -> Iterator[Curve]:
    for stop in one.limits[one.y]:
        if not np.isclose(stop, point.rod[one.y], rtol=1e-6):
            try:
                yield special_curve(point, (one.x, one.y), stop)
            except ComputationError:
                continue


def _write_curves(sheet: Sheet, path: Path) -> None:
    names = (*NAMES, *sheet.own)
    numbers = ("force", "omega", "alpha_re", "alpha_im", "beta_re", "beta_im")
    with replacing(path) as temporary, temporary.open("w", newline="", encoding="utf-8") as file:
        writer = csv.writer(file)
        writer.writerow(["type", "curve", *names, *numbers])
        for i, (kind, c) in enumerate(sheet.curves):
            of_rods = (c.rods[name] for name in names)
            columns = (*of_rods, c.force, c.omega, c.alpha.real, c.alpha.imag, c.beta.real, c.beta.imag)
            writer.writerows(
                [kind, i, *map(repr, row)] for row in zip(*(x.tolist() for x in columns), strict=True)
            )


# ---- a branch of orbits from one threshold of each kind

WITNESSES = (
    ("flutter without upper bound", (1e4, 1e4, 1e-4), 0),
    ("reentrant window", (200.0, 1e4, 1e-4), 0),
    ("reentrant window", (200.0, 1e4, 1e-4), 1),
    ("reentrant window, upper threshold supercritical", (149.5, 1e4, 1e-4), 1),
    ("reentrant window, lower threshold subcritical", (95.0, 2e4, 0.17), 0),
    ("window, and flutter again", (150.0, 1365.0, 3.26e-4), 2),
)


def witnesses() -> Iterator[Witness]:
    """For each kind of region a branch of orbits of the full nonlinear rod, beside the prediction."""
    from rodwnl.branches import branch

    for region, rod, number in WITNESSES:
        b = landau_batch(*rod, max_force=MAX_FORCE)
        force, alpha = float(b.force[number]), complex(b.alpha[number])
        points = branch(
            RodParameters(*rod), force, float(b.omega[number]), most_points=4, locate_events=False
        ).points
        detuning = np.array([p.cycle.force - force for p in points])
        slopes = np.array([p.cycle.tip_amplitude**2 for p in points])[detuning != 0] / detuning[detuning != 0]
        # A² = a (F − F_c) + b (F − F_c)² + …: the slope at the threshold
        seen = np.polynomial.Polynomial.fit(detuning[detuning != 0], slopes, len(slopes) - 1)(0)
        yield Witness(
            region, rod, number + 1, force, "supercritical" if alpha.real < 0 else "subcritical",
            float(b.A_tip2_slope[number]), seen, points[0].stable,
        )  # fmt: skip
