"""Contact forces, friction ratios and loops over a cycle at both bounds, with samples in the background."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from stickslip.show.plots.chart import Axis, Chart, Layer, Line, Panel, closed
from stickslip.show.plots.cycles import Cycles, bound_cycles, sample_cycles
from stickslip.show.plots.look import LOWER, SAMPLE, UPPER, contact
from stickslip.support.checks import Array, fault
from stickslip.support.renderers import FIGURES
from stickslip.support.units import um

if TYPE_CHECKING:
    import xarray as xr

BOUNDS = (("lower", replace(LOWER, marker="")), ("upper", replace(UPPER, marker="")))
MOST_ROWS = 8
"""Contact rows in one figure."""
PERIOD = Axis("share of the period")


@FIGURES.of("ResponseBounds", "contact_forces")
def contact_forces(
    dataset: xr.Dataset,
    case: int = 0,
    frequency: float | None = None,
    rows: Sequence[str] | None = None,
    samples: xr.Dataset | None = None,
    summed: bool = False,
) -> Chart:
    """Contact forces over a cycle at both bounds, of the rows that differ most, at the frequency nearest to the given one.

    samples: of the same force level, drawn behind, best solved at that frequency alone; summed: over the points of a surface.
    """
    cycles = bound_cycles(dataset, case, frequency, summed)
    chosen = [cycles.row(name) for name in rows] if rows else most_different(cycles.force)
    labels = _labels(dataset, case, frequency)
    behind = None if samples is None else sample_cycles(samples, float(dataset["force_level"][case]), summed)
    panels = []
    for row in chosen:
        layers: list[Layer] = []
        if behind is not None:
            of_samples = behind.force[:, behind.row(cycles.rows[row])]
            layers += [Line(behind.phase, force, SAMPLE, "samples", listed=not k) for k, force in enumerate(of_samples)]
        layers += [Line(cycles.phase, cycles.force[bound, row], style, labels[bound]) for bound, (_, style) in enumerate(BOUNDS)]
        panels.append(Panel(PERIOD, Axis("contact force", "N"), layers, cycles.rows[row], 1.7))
    return Chart(f"Contact forces at the bounds, force {float(dataset['force_level'][case]):g}", panels, columns=2)


@FIGURES.of("ResponseBounds", "force_ratios")
def force_ratios(dataset: xr.Dataset, case: int = 0, frequency: float | None = None, summed: bool = False) -> Chart:
    """T/N over a cycle at both bounds, for every contact, or surface, with a tangential and a normal direction."""
    cycles = bound_cycles(dataset, case, frequency, summed)
    if not cycles.contacts:
        raise fault("The result", "must have contacts with a normal direction", list(cycles.rows))
    axis = Axis("ratio T/N along t1")
    panels = []
    for bound, (word, _) in enumerate(BOUNDS):
        ratios = ((name, ratio(cycles, name)[bound]) for name in cycles.contacts)
        lines = [Line(cycles.phase, values, contact(i, width=1.2), name) for i, (name, values) in enumerate(ratios)]
        panels.append(Panel(PERIOD, axis, lines, f"{word} bound", 2.9))
    return Chart(f"Ratio of friction to normal force, force {float(dataset['force_level'][case]):g}", panels, columns=2)


@FIGURES.of("ResponseBounds", "loops")
def loops(
    dataset: xr.Dataset,
    case: int = 0,
    frequency: float | None = None,
    rows: Sequence[str] | None = None,
    samples: xr.Dataset | None = None,
    summed: bool = False,
) -> Chart:
    """Hysteresis loops T against displacement at both bounds; arguments as of `contact_forces`. A stuck side is a line."""
    cycles = bound_cycles(dataset, case, frequency, summed)
    tangential = [k for k, name in enumerate(cycles.rows) if not name.endswith(" n")]
    chosen = [cycles.row(name) for name in rows] if rows else [tangential[k] for k in most_different(cycles.force[:, tangential])]
    behind = None if samples is None else sample_cycles(samples, float(dataset["force_level"][case]), summed)
    labels = _labels(dataset, case, frequency)
    panels = []
    for row in chosen:
        layers: list[Layer] = []
        if behind is not None:
            own, like = behind.row(cycles.rows[row]), Line([], [], SAMPLE, "samples")
            layers += [replace(_loop(behind, k, own, like), listed=not k) for k in range(len(behind.force))]
        layers += [_loop(cycles, bound, row, Line([], [], style, labels[bound])) for bound, (_, style) in enumerate(BOUNDS)]
        panels.append(Panel(Axis("displacement", "µm"), Axis("tangential force", "N"), layers, cycles.rows[row], 2.2))
    return Chart(f"Loops at the bounds, force {float(dataset['force_level'][case]):g}", panels, columns=2)


def ratio(cycles: Cycles, contact: str) -> Array:
    """T/N along t1, (curve, sample), NaN where the contact is open."""
    tangential, load = cycles.force[:, cycles.row(f"{contact} t1")], cycles.force[:, cycles.row(f"{contact} n")]
    closed_there = load > 1e-9 * np.nanmax(np.abs(load), initial=0.0)
    return np.asarray(np.where(closed_there, tangential / np.where(closed_there, load, 1.0), np.nan))


def most_different(force: Array) -> list[int]:
    """Rows of (curve, row, sample) whose force differs most between the curves, in their old order."""
    difference = np.nan_to_num(np.ptp(force, axis=0).max(axis=-1))
    return sorted(np.argsort(-difference, kind="stable")[:MOST_ROWS].tolist())


def _loop(cycles: Cycles, curve: int, row: int, like: Line) -> Line:
    """The closed loop of a row, with style and label of a line."""
    return replace(like, x=closed(cycles.motion[curve, row]) / um, y=closed(cycles.force[curve, row]))


def _labels(dataset: xr.Dataset, case: int, frequency: float | None) -> list[str]:
    """Both bounds with the frequencies that they are of."""
    k = 0 if frequency is None else int(np.nanargmin(np.abs(dataset["frequency"].values - frequency)))
    at = dataset["resonance"].values[case, :, k]
    return [f"{word} bound, {hertz:.1f} Hz" for (word, _), hertz in zip(BOUNDS, at, strict=True)]
