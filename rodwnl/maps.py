"""The figures of the atlas: regions, criticality of thresholds, and special curves in one plane."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from rodwnl.atlas import PAPER, REGIONS, Map, Sheet, buckling
from rodwnl.drawings import style
from rodwnl.parameters import PLAIN
from rodwnl.storage import replacing

if TYPE_CHECKING:
    import xarray

LABELS = {"k1": "stretch stiffness k1", "k2": "shear stiffness k2", "gamma3": "rotational drag γ3"}
# colours told apart by hue and by lightness
NONE, SUPER, SUB = "#e6e6e6", "#2a6f97", "#e8a33d"
BUCKLED = ("#c9a9c4", "#7d4a75")
SHADES = ("#e6e6e6", "#8fb8d0", "#2a6f97", "#123047", "#000000")
LINES: dict[str, dict[str, Any]] = {
    "bautin": {"color": "#c8102e", "linestyle": "-"},
    "closing": {"color": "#111111", "linestyle": "--"},
}
NAMES = {"bautin": "Re α = 0 (Bautin)", "closing": "Re β = 0 (closing)"}


@dataclass(frozen=True)
class Panel:
    """One plane of classes 0, 1, … with a colour and a name each, and the special curves to draw over it.

    curves: kind -> sign of Re β at the thresholds it is drawn for; 0 for all.
    """

    title: str
    classes: NDArray[np.int_]
    colors: tuple[str, ...]
    names: tuple[str, ...]
    curves: dict[str, int]


def draw(sheet: Sheet, path: Path) -> None:
    """path.svg and path.png: four panels over the plane of the map."""
    one, data = sheet.map, sheet.data.transpose(sheet.map.y, sheet.map.x, ...)
    with style() as Figure:
        figure = Figure(figsize=(7.4, 7.6))
        axes = figure.subplots(2, 2, sharex=True, sharey=True)
        for axis, panel in zip(axes.ravel(), _panels(data), strict=False):
            _classes(axis, data, one, panel)
            _curves(axis, sheet, panel.curves)
            _legend(axis, panel)
        _force(figure, axes[1, 1], data, one)
        _curves(axes[1, 1], sheet, {"closing": 0})
        for axis in axes.ravel():
            axis.set(xscale="log", yscale="log", xlim=one.limits[one.x], ylim=one.limits[one.y])
            axis.set_xlabel(LABELS[one.x])
            axis.tick_params(labelbottom=True)
            _rods(axis, sheet)
        for axis in axes[:, 0]:
            axis.set_ylabel(LABELS[one.y])
        fixed = ", ".join(f"{LABELS[n]} = {v:g}" for n, v in one.fixed.items() if n in LABELS)
        rod = "" if one.model == PLAIN else ", ".join(
            [f"rod {Path(one.model).name}", *(f"{n} = {v:g}" for n, v in sheet.own.items())]
        )  # fmt: skip
        forces = "0 < force < k1" if one.model == PLAIN else "forces to the end of the straight rod"
        figure.suptitle(
            "; ".join(filter(None, [rod, fixed, "axial drag γ1 = 1/2", forces])), fontsize="medium"
        )
        for kind, metadata in (("svg", {"Date": None}), ("png", None)):
            with replacing(path.with_name(f"{path.name}.{kind}")) as temporary:
                figure.savefig(temporary, format=kind, metadata=metadata)


def _panels(data: xarray.Dataset) -> tuple[Panel, ...]:
    number, crossing, alpha = data["count"].values, data.crossing.values, data.alpha_re.values
    buckles = buckling(data)
    most = int(number[~buckles].max(initial=0))

    def criticality(at: NDArray[np.bool_]) -> NDArray[np.int_]:
        """0 where there is no such threshold, 1 where the first one is supercritical, 2 where subcritical."""
        first = np.take_along_axis(alpha, at.argmax(axis=-1)[..., None], -1)[..., 0]
        return np.where(at.any(axis=-1), np.where(first < 0, 1, 2), 0)

    kinds = ("supercritical", "subcritical")
    lower, upper = criticality(crossing == 1), criticality(crossing == -1)
    regions = tuple(REGIONS.get(n, f"{n} thresholds") for n in range(most + 1))
    shades = SHADES[: most + 1]
    if buckles.any():
        number = np.where(buckles, most + 1 + (number > 0), number)
        regions, shades = (*regions, "buckles", "buckles and flutters"), (*shades, *BUCKLED)
    return (
        Panel("Regions", number, shades, regions, {"closing": 0}),
        Panel("Lower threshold", lower, (NONE, SUPER, SUB), ("none", *kinds), {"closing": 0, "bautin": 1}),
        Panel("Upper threshold", upper, (NONE, SUPER, SUB), ("none", *kinds), {"closing": 0, "bautin": -1}),
    )


def _force(figure: Any, axis: Any, data: xarray.Dataset, one: Map) -> None:
    """The force of the lower threshold."""
    axis.set_facecolor(NONE)
    mesh = axis.pcolormesh(
        data[one.x],
        data[one.y],
        data.force.values[..., 0],
        cmap="viridis",
        shading="nearest",
        rasterized=True,
    )
    axis.set_title("Force of the lower threshold")
    figure.colorbar(mesh, ax=axis, label="force")


def _classes(axis: Any, data: xarray.Dataset, one: Map, panel: Panel) -> None:
    from matplotlib.colors import ListedColormap

    axis.pcolormesh(
        data[one.x], data[one.y], panel.classes, cmap=ListedColormap(list(panel.colors)),
        vmin=-0.5, vmax=len(panel.colors) - 0.5, shading="nearest", rasterized=True,
    )  # fmt: skip
    axis.set_title(panel.title)


def _legend(axis: Any, panel: Panel) -> None:
    """Below the panel and its label."""
    from matplotlib.lines import Line2D
    from matplotlib.patches import Patch

    named = zip(panel.colors, panel.names, strict=True)
    handles: list[Any] = [Patch(facecolor=c, edgecolor="0.4", linewidth=0.4, label=text) for c, text in named]
    handles += [Line2D([], [], linewidth=1, label=NAMES[kind], **LINES[kind]) for kind in panel.curves]
    axis.legend(handles=handles, loc="upper center", bbox_to_anchor=(0.5, -0.16), ncols=2)


def _curves(axis: Any, sheet: Sheet, kinds: dict[str, int]) -> None:
    """The special curves of these kinds; where a sign is given, only at thresholds whose crossing has it."""
    for kind, curve in sheet.curves:
        if kind in kinds:
            here = np.sign(curve.beta.real) == kinds[kind] if kinds[kind] else np.ones(len(curve.force), bool)
            x, y = (np.where(here, curve.rods[name], np.nan) for name in (sheet.map.x, sheet.map.y))
            axis.plot(x, y, linewidth=1, **LINES[kind])


def _rods(axis: Any, sheet: Sheet) -> None:
    """The paper's rods that lie in this plane."""
    for rod in PAPER if sheet.map.model == PLAIN else ():
        values = dict(zip(("k1", "k2", "gamma3"), rod, strict=True))
        if all(values[n] == v for n, v in sheet.map.fixed.items()):
            axis.plot(
                values[sheet.map.x],
                values[sheet.map.y],
                "o",
                color="white",
                markeredgecolor="black",
                markersize=5,
            )
