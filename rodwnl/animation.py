"""The beating rod as a film: its shapes, the load at its tip, the path of the tip."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from rodwnl.collocation import interpolation
from rodwnl.errors import InputError
from rodwnl.storage import replacing, require

if TYPE_CHECKING:
    from rodwnl.simulation import Simulation

STYLE = Path(__file__).with_name("figures.mplstyle")
FORMATS = (".gif", ".mp4")
SHOWN = 64  # frames: the last two periods
FRAMES_PER_SECOND = 24
ARROW = 0.15  # length of the force's arrow, in L


def require_format(path: Path) -> None:
    """Raise InputError unless a film of this kind can be written here."""
    if path.suffix.lower() not in FORMATS:
        raise InputError(f"cannot film to {path.name!r}: its name must end in {' or '.join(FORMATS)}")
    require("matplotlib", "figures")
    if path.suffix.lower() == ".mp4":
        require("imageio_ffmpeg", "film")


def film(run: Simulation, path: Path) -> None:
    """Draw the last beats of a run as a gif or mp4. Raises what `require_format` raises."""
    require_format(path)
    import matplotlib

    matplotlib.use("Agg")
    from matplotlib import animation, pyplot

    with pyplot.style.context(STYLE):
        figure, axes = pyplot.subplots(figsize=(4.8, 3.2))
        update = _scene(run, axes)
        frames = range(max(0, run.frame_time.size - SHOWN), run.frame_time.size)
        moving = animation.FuncAnimation(figure, update, frames=frames, blit=False)
        writer: animation.AbstractMovieWriter = animation.PillowWriter(fps=FRAMES_PER_SECOND)
        if path.suffix.lower() == ".mp4":
            from imageio_ffmpeg import get_ffmpeg_exe

            matplotlib.rcParams["animation.ffmpeg_path"] = get_ffmpeg_exe()
            writer = animation.FFMpegWriter(fps=FRAMES_PER_SECOND)
        try:
            with replacing(path) as temporary:
                moving.save(temporary, writer=writer, dpi=110)
        finally:
            pyplot.close(figure)


def _scene(run: Simulation, axes: Any) -> Any:
    """Prepare the axes; the function returned draws frame k."""
    x, y = run.x[-SHOWN:], run.y[-SHOWN:]
    reach = max(0.1, 1.1 * float(np.abs(y).max()) + 0.03)
    axes.set(xlim=(-0.05, max(1.0, float(x.max())) + ARROW + 0.05), ylim=(-reach, reach), aspect="equal")
    axes.set(xlabel="$x/L$", ylabel="$y/L$")
    axes.plot([0, 0], [-0.05, 0.05], color="0.5", linewidth=3, solid_capstyle="butt")  # the clamp
    axes.plot(x[:, -1], y[:, -1], color="0.7", linewidth=0.8)
    (rod,) = axes.plot([], [], color="C0", linewidth=2.2)
    smooth = interpolation(run.nodes.size - 1, np.linspace(0, 1, 101))
    load = run.tip_load[-SHOWN:]
    arrow = load_arrows(axes, x[:1, -1], y[:1, -1], load[:1], "C1")

    def draw(k: int) -> Any:
        rod.set_data(smooth @ run.x[k], smooth @ run.y[k])
        arrow.set_offsets([[run.x[k, -1], run.y[k, -1]]])
        arrow.set_UVC(*run.tip_load[k])
        axes.set_title(f"force {run.force:g},   t = {run.frame_time[k]:.4f}", loc="left")
        return rod, arrow

    return draw


def load_arrows(axes: Any, x: Any, y: Any, load: Any, color: Any) -> Any:
    """The load over the force, (k, 2), at tips (x, y): arrows that end there, as long as ARROW for 1."""
    return axes.quiver(
        x, y, *load.T, angles="xy", scale_units="xy", scale=1 / ARROW, pivot="tip",
        color=color, width=0.006, minlength=0, zorder=3,
    )  # fmt: skip
