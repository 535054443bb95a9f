"""Report section on response variability: bounds over the start states as a figure and a table."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING

import numpy as np

from stickslip.analyses.variability.bounds_dataset import detached, has_bounds
from stickslip.results.view import measure_in
from stickslip.show.plots.variability import bound_unit, response_bounds
from stickslip.show.report.charts import Charts
from stickslip.show.report.markup import cell, section, table
from stickslip.show.report.numbers import hertz, number, percent
from stickslip.solve.balance.measure import DISPLACEMENT_AMPLITUDE

if TYPE_CHECKING:
    import pandas as pd
    import xarray as xr

NOTE = (
    '<p class="note">Friction forces of sticking contacts are not unique, so neither is the response. The bounds are the highest '
    "and the lowest response found over all start states of the contacts. The search finds local optima from many starts, so the "
    "true bounds can lie further apart.</p>"
)


def bounds(datasets: Mapping[str, xr.Dataset], charts: Charts) -> str:
    """Figure and table of every result that has bounds."""
    bounded = {label: detached(dataset) for label, dataset in datasets.items() if has_bounds(dataset)}
    parts = [
        charts.drawn(f"chart-bounds-{k}", response_bounds(dataset), "Bounds of the response")
        + ("" if k else NOTE)
        + _table(k, f"{label}: " if len(bounded) > 1 else "", dataset)
        for k, (label, dataset) in enumerate(bounded.items())
    ]
    return section("bounds", "Bounds", *parts)


def bounds_table(bounds: xr.Dataset) -> pd.DataFrame:
    """Lower and upper bound of each force level and frequency; by peaks, each bound has a frequency of its own."""
    import pandas as pd

    levels, hertz_wanted = bounds["force_level"].values, bounds["frequency"].values
    case, at = (index.ravel() for index in np.indices((levels.size, hertz_wanted.size)))
    columns = {"force_level": levels[case]}
    columns |= {"frequency [Hz]": hertz_wanted[at]} if np.all(np.isfinite(hertz_wanted)) else {}
    for k, bound in enumerate(bounds["bound"].values):
        columns[f"{bound} [Hz]"] = bounds["resonance"].values[case, k, at]
        size = f"{bound} {measure_in(bounds).kind} [{bounds['amplitude'].attrs['units']}]"
        columns[size] = bounds["amplitude"].values[case, k, at]
        columns[f"{bound} loss_factor"] = bounds["loss_factor"].values[case, k, at]
    columns["start states without solution"] = bounds["unsolved_share"].values[case, at]
    return pd.DataFrame(columns)


def _table(k: int, begin: str, dataset: xr.Dataset) -> str:
    """Both bounds at each force level and frequency; of peaks, each bound has a frequency of its own."""
    unit, measure = bound_unit(dataset), measure_in(dataset)
    ends = (f"lower bound in {unit.name}", f"upper bound in {unit.name}")
    heads = ["force", "frequency in Hz", *ends, "loss factor, lower", "loss factor, upper", "start states without solution"]
    of = "amplitude" if measure == DISPLACEMENT_AMPLITUDE else measure.words
    caption, rows = f"{begin}bounds of the {of}, by {str(dataset.attrs['objective']).replace('_', ' ')}", []
    for case, level in enumerate(dataset["force_level"].values):
        unsolved = dataset["unsolved_share"].values[case]
        for point, frequency in enumerate(dataset["frequency"].values):
            low, high = dataset["amplitude"].values[case, :, point]
            loss = dataset["loss_factor"].values[case, :, point]
            at = dataset["resonance"].values[case, :, point]
            shown = hertz(float(frequency)) if np.isfinite(frequency) else f"{hertz(float(at[0]))}, {hertz(float(at[1]))}"
            cells = [cell(f"{level:g}", float(level)), cell(shown)]
            cells += [cell(number(size / unit.metres), size) for size in (low, high)]
            cells += [*(cell(number(value), value) for value in loss), cell(percent(unsolved[point]), unsolved[point])]
            rows.append(f"<tr>{''.join(cells)}</tr>")
    return table(f"bounds-{k}", caption, heads, rows)
