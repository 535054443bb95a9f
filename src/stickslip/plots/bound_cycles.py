"""Contact forces, friction ratios and loops over a cycle at both bounds, with samples in the background."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from stickslip.checks import Array, fault
from stickslip.plots.cycles import Cycles, bound_cycles, sample_cycles
from stickslip.plots.look import CONTACTS, GREY, beside, headed, house_style, plain
from stickslip.units import um

if TYPE_CHECKING:
    import xarray as xr

BOUNDS = (("lower", CONTACTS[0]), ("upper", CONTACTS[5]))
MOST_ROWS = 8
"""Contact rows in one figure."""


def contact_forces(
    dataset: xr.Dataset,
    case: int = 0,
    frequency: float | None = None,
    rows: Sequence[str] | None = None,
    samples: xr.Dataset | None = None,
    summed: bool = False,
) -> Figure:
    """Contact forces over a cycle at both bounds, of the rows that differ most, at the frequency nearest to the given one.

    samples: of the same force level, drawn behind, best solved at that frequency alone; summed: over the points of a surface.
    """
    found = bound_cycles(dataset, case, frequency, summed)
    chosen = [found.row(name) for name in rows] if rows else most_different(found.force)
    labels = [
        f"{word} bound, {hertz:.1f} Hz" for (word, _), hertz in zip(BOUNDS, _resonance(dataset, case, frequency), strict=True)
    ]
    behind = None if samples is None else sample_cycles(samples, float(dataset["force_level"][case]), summed)
    with house_style():
        figure = panels(len(chosen), "share of the period", "contact force in N")
        for axes, row in zip(figure.axes, chosen, strict=False):
            if behind is not None:
                axes.plot(behind.phase, behind.force[:, behind.row(found.rows[row])].T, color=GREY, linewidth=0.5, alpha=0.6)
            for bound, (_, colour) in enumerate(BOUNDS):
                axes.plot(found.phase, found.force[bound, row], color=colour, label=labels[bound])
            axes.set_title(plain(found.rows[row]), fontsize=9)
        figure.axes[0].legend(fontsize=7)
        headed(figure, f"Contact forces at the bounds, force {float(dataset['force_level'][case]):g}")
    return figure


def force_ratios(dataset: xr.Dataset, case: int = 0, frequency: float | None = None, summed: bool = False) -> Figure:
    """T/N over a cycle at both bounds, for every contact, or surface, with a tangential and a normal direction."""
    found = bound_cycles(dataset, case, frequency, summed)
    if not found.contacts:
        raise fault("The result", "must have contacts with a normal direction", list(found.rows))
    with house_style():
        figure = Figure(figsize=(7.6, 3.6), layout="constrained")
        for bound, axes in enumerate(figure.subplots(1, 2, sharey=True)):
            for i, name in enumerate(found.contacts):
                axes.plot(
                    found.phase, ratio(found, name)[bound], color=CONTACTS[i % len(CONTACTS)], linewidth=1.0, label=plain(name)
                )
            axes.set(title=BOUNDS[bound][0] + " bound", xlabel="share of the period")
        figure.axes[0].set_ylabel("T/N along t1")
        beside(figure.axes[1])
        headed(figure, f"Ratio of friction to normal force, force {float(dataset['force_level'][case]):g}")
    return figure


def loops(
    dataset: xr.Dataset,
    case: int = 0,
    frequency: float | None = None,
    rows: Sequence[str] | None = None,
    samples: xr.Dataset | None = None,
    summed: bool = False,
) -> Figure:
    """Hysteresis loops T against displacement at both bounds; arguments as of `contact_forces`. A stuck side is a line."""
    found = bound_cycles(dataset, case, frequency, summed)
    tangential = [k for k, name in enumerate(found.rows) if not name.endswith(" n")]
    chosen = [found.row(name) for name in rows] if rows else [tangential[k] for k in most_different(found.force[:, tangential])]
    behind = None if samples is None else sample_cycles(samples, float(dataset["force_level"][case]), summed)
    with house_style():
        figure = panels(len(chosen), "displacement in µm", "tangential force in N", height=2.2)
        for axes, row in zip(figure.axes, chosen, strict=False):
            if behind is not None:
                _closed(axes, behind, behind.row(found.rows[row]), [("", GREY)] * len(behind.force), linewidth=0.5, alpha=0.6)
            _closed(axes, found, row, BOUNDS)
            axes.set_title(plain(found.rows[row]), fontsize=9)
        figure.axes[0].legend(fontsize=7)
        headed(figure, f"Loops at the bounds, force {float(dataset['force_level'][case]):g}")
    return figure


def ratio(found: Cycles, contact: str) -> Array:
    """T/N along t1, (curve, sample), NaN where the contact is open."""
    tangential, load = found.force[:, found.row(f"{contact} t1")], found.force[:, found.row(f"{contact} n")]
    closed = load > 1e-9 * np.nanmax(np.abs(load), initial=0.0)
    return np.asarray(np.where(closed, tangential / np.where(closed, load, 1.0), np.nan))


def panels(count: int, across: str, up: str, height: float = 1.6) -> Figure:
    """A figure of so many panels, two beside each other."""
    rows = (count + 1) // 2
    figure = Figure(figsize=(7.6, 0.8 + height * rows), layout="constrained")
    for k in range(count):
        figure.add_subplot(rows, 2, k + 1)
    figure.supxlabel(across, fontsize=9.5)
    figure.supylabel(up, fontsize=9.5)
    return figure


def most_different(force: Array) -> list[int]:
    """Rows of (curve, row, sample) whose force differs most between the curves, in their old order."""
    difference = np.nan_to_num(np.ptp(force, axis=0).max(axis=-1))
    return sorted(np.argsort(-difference, kind="stable")[:MOST_ROWS].tolist())


def _closed(axes: Axes, found: Cycles, row: int, curves: Sequence[tuple[str, str]], **style: float) -> None:
    for k, (word, colour) in enumerate(curves):
        motion, force = (np.append(values[k, row], values[k, row, :1]) for values in (found.motion, found.force))
        axes.plot(motion / um, force, color=colour, label=f"{word} bound" if word else None, **style)  # type: ignore[arg-type]


def _resonance(dataset: xr.Dataset, case: int, frequency: float | None) -> Array:
    k = 0 if frequency is None else int(np.nanargmin(np.abs(dataset["frequency"].values - frequency)))
    return np.asarray(dataset["resonance"].values[case, :, k])
