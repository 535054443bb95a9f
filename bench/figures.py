"""The figures of the benchmark page: how cost grows, and the curves with the points that each code spent on them."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import matplotlib

matplotlib.use("Agg")
from matplotlib import pyplot as plt

from stickslip.show.plots.look import CONTACTS, GREY, house_style

OURS, THEIRS = CONTACTS[0], CONTACTS[5]
AXES = {
    "contacts": "contacts (all slip at resonance)",
    "harmonics": "harmonics H",
    "samples": "samples in a period",
    "size": "degrees of freedom",
}
METADATA = {"Date": None, "Creator": "stickslip"}


def growth(found: dict[str, Any], path: Path) -> None:
    """Four panels on logarithmic axes; the expected slope is drawn through the last value."""
    with house_style():
        figure, panels = plt.subplots(2, 2, figsize=(8.0, 5.6), layout="constrained")
        for axes, (kind, label) in zip(panels.flat, AXES.items(), strict=True):
            rows = [row for row in found[kind]["rows"] if "per_point" in row]
            x, y = [row["value"] for row in rows], [1e3 * row["per_point"] for row in rows]
            slope = found[kind]["expected_slope"]
            axes.loglog(x, y, "o-", color=OURS, markersize=4)
            reach = [value for value in x if y[-1] * (value / x[-1]) ** slope > 0.5 * min(y)]
            axes.loglog(reach, [y[-1] * (value / x[-1]) ** slope for value in reach], "--", color=GREY, linewidth=1.0)
            axes.annotate(f"slope {slope:g}", (reach[0], y[-1] * (reach[0] / x[-1]) ** slope), color=GREY, fontsize=8)
            axes.set(xlabel=label, ylabel="CPU time of a point, ms")
        figure.savefig(path, metadata=METADATA)
        plt.close(figure)


def curves(found: dict[str, Any], path: Path) -> None:
    """The exact curve of each case with the points of the chosen sweeps."""
    with house_style():
        figure, panels = plt.subplots(2, 3, figsize=(10.0, 5.6), layout="constrained")
        for axes, (case, result) in zip(panels.flat, found.items(), strict=True):
            drawn = result["curves"]
            axes.plot(*(values[::4] for values in drawn["reference"]), color=GREY, linewidth=1.0)
            for name, colour, marker in (("pyHarm", THEIRS, "x"), ("stickslip", OURS, ".")):
                axes.plot(*drawn[name], marker, color=colour, markersize=5, label=f"{name}, {len(drawn[name][0])} points")
            axes.set(title=case, xlabel="ω, rad/s", ylabel="|X₁|", yscale="log", xlim=result["band"])
            axes.legend(fontsize=7.5)
        figure.savefig(path, metadata=METADATA)
        plt.close(figure)
