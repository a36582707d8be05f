"""The figures of the atlas: regions, criticality of thresholds, and special curves in one plane."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

from rodwnl.atlas import PAPER, REGIONS, Sheet
from rodwnl.drawings import style
from rodwnl.storage import replacing

LABELS = {"k1": "stretch stiffness k1", "k2": "shear stiffness k2", "gamma3": "rotational drag γ3"}
# colours told apart by hue and by lightness
NONE, SUPER, SUB, ABSENT = "#e6e6e6", "#2a6f97", "#e8a33d", "#ffffff"
SHADES = ("#e6e6e6", "#8fb8d0", "#2a6f97", "#123047", "#000000")
LINES: dict[str, dict[str, Any]] = {
    "bautin": {"color": "#c8102e", "linestyle": "-"},
    "closing": {"color": "#111111", "linestyle": "--"},
}
NAMES = {"bautin": "Re α = 0 (Bautin)", "closing": "Re β = 0 (closing)"}


def draw(sheet: Sheet, path: Path) -> None:
    """path.svg and path.png: four panels over the plane of the map."""
    with style() as Figure:
        figure = Figure(figsize=(7.4, 6.4))
        panels = figure.subplots(2, 2, sharex=True, sharey=True).ravel()
        one, data = sheet.map, sheet.data.transpose(sheet.map.y, sheet.map.x, ...)
        number, crossing, alpha = data["count"].values, data.crossing.values, data.alpha_re.values
        lower = np.where(number > 0, np.where(alpha[..., 0] < 0, 1, 2), 0)
        upper_at = crossing == -1
        upper_alpha = np.where(upper_at, alpha, 0).sum(
            axis=-1
        )  # no rod of the atlas has two upper thresholds
        upper = np.where(upper_at.any(axis=-1), np.where(upper_alpha < 0, 1, 2), 0)
        most = max(int(number.max()), 2)
        _classes(panels[0], data, one, number, SHADES[: most + 1])
        _legend(panels[0], [(SHADES[n], REGIONS.get(n, f"{n} thresholds")) for n in range(most + 1)])
        _classes(panels[1], data, one, lower, (NONE, SUPER, SUB))
        _legend(panels[1], [(SUPER, "supercritical"), (SUB, "subcritical"), (NONE, "no threshold")])
        _classes(panels[2], data, one, upper, (ABSENT, SUPER, SUB))
        _legend(panels[2], [(SUPER, "supercritical"), (SUB, "subcritical"), (ABSENT, "no upper threshold")])
        first = np.where(number > 0, data.force.values[..., 0], np.nan)
        mesh = panels[3].pcolormesh(
            data[one.x], data[one.y], first, cmap="viridis", shading="nearest", rasterized=True
        )
        figure.colorbar(mesh, ax=panels[3], label="force")
        titles = ("Regions", "Lower threshold", "Upper threshold", "Force of the lower threshold")
        drawn = ({"closing": 0}, {"closing": 0, "bautin": 1}, {"closing": 0, "bautin": -1}, {"closing": 0})
        for panel, title, kinds in zip(panels, titles, drawn, strict=True):
            panel.set(xscale="log", yscale="log", title=title, xlim=one.limits[one.x], ylim=one.limits[one.y])
            _curves(panel, sheet, kinds)
            _rods(panel, sheet)
        for panel in panels[2:]:
            panel.set_xlabel(LABELS[one.x])
        for panel in panels[::2]:
            panel.set_ylabel(LABELS[one.y])
        fixed = ", ".join(f"{LABELS[n]} = {v:g}" for n, v in one.fixed.items())
        figure.suptitle(f"{fixed}; axial drag γ1 = 1/2; 0 < force < k1")
        for suffix in (".svg", ".png"):
            with replacing(path.with_name(path.name + suffix)) as temporary:
                figure.savefig(
                    temporary, format=suffix[1:], metadata={"Date": None} if suffix == ".svg" else None
                )


def _classes(panel: Any, data: Any, one: Any, classes: Any, colors: tuple[str, ...]) -> None:
    from matplotlib.colors import ListedColormap

    panel.pcolormesh(
        data[one.x], data[one.y], classes, cmap=ListedColormap(list(colors)),
        vmin=-0.5, vmax=len(colors) - 0.5, shading="nearest", rasterized=True,
    )  # fmt: skip


def _legend(panel: Any, entries: list[tuple[str, str]]) -> None:
    from matplotlib.lines import Line2D
    from matplotlib.patches import Patch

    handles: list[Any] = [
        Patch(facecolor=c, edgecolor="0.4", linewidth=0.4, label=text) for c, text in entries
    ]
    kinds = ["closing"] if entries[0][0] in SHADES else ["closing", "bautin"]
    handles += [Line2D([], [], linewidth=1, label=NAMES[kind], **LINES[kind]) for kind in kinds]
    panel.legend(handles=handles, loc="lower right", frameon=True, framealpha=0.9)


def _curves(panel: Any, sheet: Sheet, kinds: dict[str, int]) -> None:
    """The special curves of these kinds; where a sign is given, only at thresholds whose crossing has it."""
    for kind, curve in sheet.curves:
        if kind in kinds:
            rods = dict(zip(("k1", "k2", "gamma3"), curve.rods, strict=False))
            here = np.sign(curve.beta.real) == kinds[kind] if kinds[kind] else np.ones(len(curve.force), bool)
            x, y = (np.where(here, rods[name], np.nan) for name in (sheet.map.x, sheet.map.y))
            panel.plot(x, y, linewidth=1, **LINES[kind])


def _rods(panel: Any, sheet: Sheet) -> None:
    """The paper's rods that lie in this plane."""
    for rod in PAPER:
        values = dict(zip(("k1", "k2", "gamma3"), rod, strict=True))
        if all(values[n] == v for n, v in sheet.map.fixed.items()):
            panel.plot(
                values[sheet.map.x],
                values[sheet.map.y],
                "o",
                color="white",
                markeredgecolor="black",
                markersize=5,
            )
