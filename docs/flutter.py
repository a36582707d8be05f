"""Draws docs/flutter.svg, the picture of the README: `python docs/flutter.py` (extra `figures`)."""

from pathlib import Path

import matplotlib as mpl
import matplotlib.pyplot as plt
import numpy as np

from rodwnl import RodParameters, landau
from rodwnl.inverse import leading_eigenvalues
from rodwnl.predictions import predict_at

ROD = RodParameters(k1=200, k2="1e4", gamma3="1e-4")


def main() -> None:
    found = landau(ROD)
    mpl.rcParams.update({"svg.hashsalt": "rodwnl", "font.size": 9, "axes.spines.top": False})
    figure, (left, right) = plt.subplots(1, 2, figsize=(7.2, 2.7), layout="constrained")

    force = np.linspace(0, 199, 400)
    eigenvalues, _ = leading_eigenvalues(ROD.floats(), force)
    left.plot(force, eigenvalues.real.max(axis=1), color="tab:blue")
    left.axhline(0, color="0.7", linewidth=0.8, zorder=0)
    left.plot([c.force for c in found], [0, 0], "o", color="tab:red")
    for c, offset in zip(found, ((6, -14), (-48, 8)), strict=True):
        left.annotate(f"{c.force:.2f}", (c.force, 0), textcoords="offset points", xytext=offset)
    left.set(xlabel="follower force $F$", ylabel=r"leading growth rate Re $\lambda$", ylim=(-400, 900))

    for c, reach in zip(found, (12, 30), strict=True):
        branch = c.force + reach * np.linspace(0.01, 1, 100) ** 2  # dense at onset
        predictions = [predict_at(c, f) for f in branch]
        style = "-" if predictions[0].stable else "--"
        label = f"{c.criticality}, {'stable' if predictions[0].stable else 'unstable'}"
        right.plot(branch, [p.A_tip for p in predictions], style, color="tab:blue", label=label)
        right.plot(c.force, 0, "o", color="tab:red", clip_on=False)
    right.set(
        xlabel="follower force $F$",
        ylabel=r"tip amplitude $A_\mathrm{tip}$",
        xlim=left.get_xlim(),
        ylim=(0, None),
    )
    right.legend(frameon=False, loc="upper right")

    figure.savefig(Path(__file__).with_name("flutter.svg"), metadata={"Date": None})


if __name__ == "__main__":
    main()
