"""Report section on stress: the largest at every place, with its vibratory and mean parts."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from stickslip.analyses.stress import has_stress
from stickslip.plots.stress import MPa, stress_curves
from stickslip.report.charts import Charts
from stickslip.report.fatigue import fatigue_part
from stickslip.report.markup import cell, section, table
from stickslip.report.numbers import hertz, number
from stickslip.results.shown_units import in_system, system_of
from stickslip.results.view import level_text

if TYPE_CHECKING:
    import pandas as pd
    import xarray as xr

NOTE = (
    '<p class="note">The largest of the computed points of each curve: the stress of von Mises at the worst instant of the '
    "period, with the mean; the component is the one that vibrates most there, in the axes of the body. At clamps, sharp corners "
    "and contacts stress is singular and grows with the mesh.</p>"
)


class Largest(NamedTuple):
    """The largest stress of one curve at one place: Hz, Pa; the component that vibrates most, its amplitude and mean."""

    case: int
    place: str
    frequency: float
    von_mises: float
    component: str
    amplitude: float
    mean: float


def largest_stresses(dataset: xr.Dataset) -> Iterator[Largest]:
    """Of every force level and place where a point was solved."""
    for case, curve in enumerate(dataset["stress_von_mises"].values):
        for k, place in enumerate(dataset["place"].values):
            if np.any(np.isfinite(curve[:, k])):
                point = int(np.nanargmax(curve[:, k]))
                amplitudes, means = (dataset[name].values[case, point, k] for name in ("stress_amplitude", "stress_mean"))
                most = int(np.argmax(amplitudes))
                frequency = float(dataset["frequency"].values[case, point])
                component = str(dataset["component"].values[most])
                yield Largest(case, str(place), frequency, curve[point, k], component, amplitudes[most], means[most])


def stress_table(dataset: xr.Dataset) -> pd.DataFrame:
    """`largest_stresses` as a table."""
    import pandas as pd

    rows = [(float(dataset["force_level"].values[found.case]), *found[1:]) for found in largest_stresses(dataset)]
    heads = ["frequency [Hz]", "von Mises [Pa]", "component", "amplitude [Pa]", "mean [Pa]"]
    return pd.DataFrame(rows, columns=["force_level", "place", *heads])


def stress_sentences(dataset: xr.Dataset) -> list[str]:
    """The largest stress of each force level."""
    lines, (unit, name) = ["largest von Mises stress"], _unit(dataset)
    for case, level in enumerate(dataset["force_level"].values):
        found = [stress for stress in largest_stresses(dataset) if stress.case == case]
        worst = max(found, key=lambda stress: stress.von_mises, default=None)
        words = "no point was found"
        if worst:
            words = f"{worst.von_mises / unit:.4g} {name} at {worst.frequency:.6g} Hz, {worst.place}"
        lines.append(f"  force {level:<8g} {words}")
    return lines


def _unit(dataset: xr.Dataset) -> tuple[float, str]:
    """The size in Pa of the unit to show stress in, and its name: MPa unless the study states others."""
    factor, name = in_system("MPa", system_of(dataset))
    return MPa / factor, name


def stress(datasets: Mapping[str, xr.Dataset], charts: Charts) -> str:
    """Figure and table of every result that holds stress."""
    found = {label: dataset for label, dataset in datasets.items() if has_stress(dataset)}
    return section("stress", "Stress", NOTE, *(_part(charts, k, *item) for k, item in enumerate(found.items())))


def _part(charts: Charts, k: int, label: str, dataset: xr.Dataset) -> str:
    name = _unit(dataset)[1]
    heads = ["force level", "place", "frequency in Hz", f"von Mises in {name}", "component"]
    heads += [f"vibrating in {name}", f"mean in {name}"]
    figure = charts.drawn(f"chart-stress-{k}", stress_curves(dataset), "Von Mises stress along the curves")
    largest = table(f"stress-{k}", f"{label}: largest stress at each place", heads, _rows(dataset))
    return fatigue_part(charts, str(k), label, dataset) + figure + largest


def _rows(dataset: xr.Dataset) -> Iterator[str]:
    unit, _ = _unit(dataset)
    for found in largest_stresses(dataset):
        cells = [cell(level_text(dataset, found.case), float(dataset["force_level"].values[found.case])), cell(found.place)]
        cells += [cell(hertz(found.frequency), found.frequency), cell(number(found.von_mises / unit), found.von_mises)]
        cells += [
            cell(found.component),
            cell(number(found.amplitude / unit), found.amplitude),
            cell(number(found.mean / unit), found.mean),
        ]
        yield f"<tr>{''.join(cells)}</tr>"
