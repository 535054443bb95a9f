"""Figures of response bounds: the two curves with the cloud, range of the peak, loss factors, contact forces, start states."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from stickslip.checks import Array, fault
from stickslip.plots.look import CONTACTS, GREY, house_style, level_colours, plain

if TYPE_CHECKING:
    import xarray as xr

LOWER, UPPER = CONTACTS[0], CONTACTS[5]
MOST_ROWS = 8
"""Contact rows in one figure of forces."""


def response_bounds(dataset: xr.Dataset) -> Figure:
    """Amplitude bounds against frequency, a panel per force level, with the sampled start states; of peaks, their ranges."""
    if dataset.attrs["objective"] == "peak":
        return peak_ranges(dataset)
    levels = dataset["force_level"].values
    with house_style():
        figure = Figure(figsize=(7.6, 0.8 + 2.4 * levels.size), layout="constrained")
        for case, axes in enumerate(figure.subplots(levels.size, 1, squeeze=False, sharex=True).ravel()):
            _band(axes, dataset, case)
            axes.set_title(f"force {levels[case]:g}")
            axes.set_ylabel("amplitude |X₁| in µm")
        axes.set_xlabel("frequency in Hz")
        figure.axes[0].legend(loc="upper left")
        _title(figure, f"Bounds by {dataset.attrs['objective'].replace('_', ' ')}: {dataset.attrs['title']}")
    return figure


def _band(axes: Axes, dataset: xr.Dataset, case: int) -> None:
    hertz, (low, high) = dataset["frequency"].values, 1e6 * dataset["amplitude"].values[case]
    cloud = 1e6 * dataset["sampled_amplitude"].values[case]
    axes.plot(np.broadcast_to(hertz, cloud.shape).ravel(), cloud.ravel(), ".", color=GREY, markersize=3, label="sampled starts")
    axes.plot(hertz, low, ".-", color=LOWER, label="lower bound")
    axes.plot(hertz, high, ".-", color=UPPER, label="upper bound")
    axes.fill_between(hertz, low, high, color=UPPER, alpha=0.08, linewidth=0)
    axes.set_ylim(bottom=0.0)


def peak_ranges(dataset: xr.Dataset) -> Figure:
    """Range of the resonance amplitude per force, and of its frequency, against the force level."""
    levels = dataset["force_level"].values
    per_force = 1e6 * dataset["amplitude"].values[:, :, 0] / levels[:, None]
    virgin = 1e6 * dataset["sampled_amplitude"].values[:, 0, 0] / levels
    with house_style():
        figure = Figure(figsize=(7.6, 3.4), layout="constrained")
        left, right = figure.subplots(1, 2)
        for axes, values, label in (
            (left, per_force, "peak amplitude per force in µm"),
            (right, dataset["resonance"].values[:, :, 0], "its frequency in Hz"),
        ):
            axes.plot(levels, values[:, 0], ".-", color=LOWER, label="lower bound")
            axes.plot(levels, values[:, 1], ".-", color=UPPER, label="upper bound")
            axes.set(xlabel="force level", ylabel=label)
            if levels.size > 1 and levels.max() > 8.0 * levels.min():
                axes.set_xscale("log")
        left.plot(levels, virgin, "--", color=GREY, label="virgin contacts")
        left.fill_between(levels, per_force[:, 0], per_force[:, 1], color=UPPER, alpha=0.08, linewidth=0)
        left.legend()
        _title(figure, f"Range of the resonance: {dataset.attrs['title']}")
    return figure


def loss_factors(dataset: xr.Dataset) -> Figure:
    """Loss factor along the lower (solid) and the upper bound (dash-dotted), one colour per force level."""
    levels = dataset["force_level"].values
    across = dataset["frequency"].values if dataset.attrs["objective"] != "peak" else dataset["resonance"].values
    with house_style():
        figure = Figure(figsize=(7.6, 3.8), layout="constrained")
        axes = figure.subplots()
        for case, colour in enumerate(level_colours(levels.size)):
            for bound, style in ((0, "-"), (1, "-.")):
                x = across if across.ndim == 1 else across[case, bound]
                label = f"force {levels[case]:g}" if bound == 0 else None
                axes.plot(x, dataset["loss_factor"].values[case, bound], style, marker=".", color=colour, label=label)
        axes.set(xlabel="frequency in Hz", ylabel="loss factor")
        axes.legend(loc="upper left", bbox_to_anchor=(1.0, 1.0))
        _title(figure, "Loss factor along the bounds: lower solid, upper dash-dotted")
    return figure


def contact_forces(dataset: xr.Dataset, case: int = 0, frequency: float | None = None, rows: list[str] | None = None) -> Figure:
    """Contact forces over a cycle at both bounds, the rows that differ most; at the frequency nearest to the given one."""
    k = 0 if frequency is None else int(np.nanargmin(np.abs(dataset["frequency"].values - frequency)))
    forces = dataset["contact_force"].values[case, :, k]
    chosen = [_row(dataset, name) for name in rows] if rows else _most_different(forces)
    phase = np.arange(forces.shape[-1]) / forces.shape[-1]
    hertz = dataset["resonance"].values[case, :, k]
    with house_style():
        figure = Figure(figsize=(7.6, 0.8 + 1.6 * ((len(chosen) + 1) // 2)), layout="constrained")
        panels = figure.subplots((len(chosen) + 1) // 2, 2, squeeze=False).ravel()
        for axes, row in zip(panels, chosen, strict=False):
            for bound, (word, colour) in enumerate((("lower", LOWER), ("upper", UPPER))):
                axes.plot(phase, forces[bound, row], color=colour, label=f"{word} bound, {hertz[bound]:.1f} Hz")
            axes.set_title(plain(str(dataset["row"].values[row])), fontsize=9)
        panels[0].legend(fontsize=7)
        figure.supxlabel("share of the period", fontsize=9.5)
        figure.supylabel("contact force in N", fontsize=9.5)
        _title(figure, f"Contact forces at the bounds, force {float(dataset['force_level'][case]):g}")
    return figure


def force_ratios(dataset: xr.Dataset, case: int = 0, frequency: float | None = None) -> Figure:
    """|T|/N over a cycle at both bounds, for every contact with a tangential and a normal direction."""
    k = 0 if frequency is None else int(np.nanargmin(np.abs(dataset["frequency"].values - frequency)))
    names = [str(name) for name in dataset["row"].values]
    pairs = [(name[:-3], names.index(name), names.index(name[:-2] + "n")) for name in names if name.endswith(" t1")
             and name[:-2] + "n" in names]  # fmt: skip
    if not pairs:
        raise fault("The result", "must have contacts with a normal direction", names)
    forces = dataset["contact_force"].values[case, :, k]
    phase = np.arange(forces.shape[-1]) / forces.shape[-1]
    with house_style():
        figure = Figure(figsize=(7.6, 3.6), layout="constrained")
        for bound, axes in enumerate(figure.subplots(1, 2, sharey=True)):
            for i, (name, tangential, normal) in enumerate(pairs):
                load = forces[bound, normal]
                ratio = np.where(load > 1e-9 * load.max(), forces[bound, tangential] / np.maximum(load, 1e-300), np.nan)
                axes.plot(phase, ratio, color=CONTACTS[i % len(CONTACTS)], linewidth=1.0, label=plain(name))
            axes.set(title=("lower", "upper")[bound] + " bound", xlabel="share of the period")
        figure.axes[0].set_ylabel("T/N along t1")
        figure.axes[1].legend(fontsize=7, loc="upper left", bbox_to_anchor=(1.0, 1.0))
        _title(figure, f"Ratio of friction to normal force, force {float(dataset['force_level'][case]):g}")
    return figure


def start_states(dataset: xr.Dataset, case: int = 0) -> Figure:
    """The start variables that make the bounds, against frequency."""
    variables = dataset["start_variable"].values[case]
    with house_style():
        figure = Figure(figsize=(7.6, 4.4), layout="constrained")
        for bound, axes in enumerate(figure.subplots(2, 1, sharex=True)):
            image = axes.imshow(variables[bound].T, vmin=-1.0, vmax=1.0, cmap="RdBu", aspect="auto", interpolation="nearest")
            axes.set_title(("lower", "upper")[bound] + " bound")
            axes.set_ylabel("start variable")
            axes.grid(visible=False)
        hertz = dataset["frequency"].values
        ticks = np.unique(np.linspace(0, hertz.size - 1, 7).round().astype(int))
        axes.set_xticks(ticks, [f"{hertz[tick]:.4g}" for tick in ticks])
        axes.set_xlabel("frequency in Hz")
        figure.colorbar(image, ax=figure.axes, label="variable in [−1, 1]")
    return figure


def _row(dataset: xr.Dataset, name: str) -> int:
    names = [str(known) for known in dataset["row"].values]
    if name not in names:
        raise fault("row", f"must be one of {', '.join(names)}", name)
    return names.index(name)


def _most_different(forces: Array) -> list[int]:
    """Rows whose force differs most between the bounds, in their old order."""
    difference = np.nan_to_num(np.ptp(forces, axis=0).max(axis=-1))
    return sorted(np.argsort(-difference, kind="stable")[:MOST_ROWS].tolist())


def _title(figure: Figure, text: str) -> None:
    figure.suptitle(plain(text), x=0.01, ha="left", fontweight="bold", fontsize=10.5)
