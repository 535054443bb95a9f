"""Report section on response variability: bounds over the start states as a figure and a table."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import TYPE_CHECKING

import numpy as np

from stickslip.analyses.variability.bounds_dataset import detached, has_bounds
from stickslip.results.view import measure_in
from stickslip.show.plots.response_bounds import bound_unit, response_bounds
from stickslip.show.report.charts import Charts
from stickslip.show.report.markup import cell, section, table
from stickslip.show.report.numbers import hertz, number, percent
from stickslip.solve.balance.measure import DISPLACEMENT_AMPLITUDE

if TYPE_CHECKING:
    import pandas as pd
    import xarray as xr

NOTE = (
    '<p class="note">Friction forces of contacts that stick are not unique, so neither is the response. Highest and lowest '
    "response found over all states from which the contacts may start; the search is for local optima from many starts, so a "
    "bound is the best one found.</p>"
)


def bounds(datasets: Mapping[str, xr.Dataset], charts: Charts) -> str:
    """Figure and table of every result that has bounds."""
    found = {label: detached(dataset) for label, dataset in datasets.items() if has_bounds(dataset)}
    return section("bounds", "Bounds", NOTE, *(_part(charts, k, *item, len(found) > 1) for k, item in enumerate(found.items())))


def bounds_table(bounds: xr.Dataset) -> pd.DataFrame:
    """Lower and upper bound of each force level and frequency; by peaks, each bound has a frequency of its own."""
    import pandas as pd

    levels, hertz_wanted = bounds["force_level"].values, bounds["frequency"].values
    case, at = (index.ravel() for index in np.indices((levels.size, hertz_wanted.size)))
    columns = {"force_level": levels[case]}
    columns |= {"frequency [Hz]": hertz_wanted[at]} if np.all(np.isfinite(hertz_wanted)) else {}
    for k, bound in enumerate(bounds["bound"].values):
        columns[f"{bound} [Hz]"] = bounds["resonance"].values[case, k, at]
        columns[f"{bound} {measure_in(bounds).kind} [{bounds['amplitude'].attrs['units']}]"] = bounds["amplitude"].values[
            case, k, at
        ]
        columns[f"{bound} loss_factor"] = bounds["loss_factor"].values[case, k, at]
    columns["start states without solution"] = bounds["unsolved_share"].values[case, at]
    return pd.DataFrame(columns)


def _part(charts: Charts, place: int, label: str, dataset: xr.Dataset, several: bool) -> str:
    unit, measure = bound_unit(dataset), measure_in(dataset)
    ends = (f"lower bound in {unit.name}", f"upper bound in {unit.name}")
    heads = ["force", "frequency in Hz", *ends, "loss factor, lower", "loss factor, upper", "start states without solution"]
    name, of = f"{label}: " if several else "", "amplitude" if measure == DISPLACEMENT_AMPLITUDE else measure.words
    caption = f"{name}bounds of the {of}, by {str(dataset.attrs['objective']).replace('_', ' ')}"
    rows = _rows(dataset, unit.metres)
    return charts.drawn(f"chart-bounds-{place}", response_bounds(dataset), "Bounds of the response") + table(
        f"bounds-{place}", caption, heads, rows
    )


def _rows(dataset: xr.Dataset, unit: float) -> Iterator[str]:
    for case, level in enumerate(dataset["force_level"].values):
        unsolved = dataset["unsolved_share"].values[case]
        for k, frequency in enumerate(dataset["frequency"].values):
            low, high = dataset["amplitude"].values[case, :, k]
            eta = dataset["loss_factor"].values[case, :, k]
            at = dataset["resonance"].values[case, :, k]
            shown = hertz(float(frequency)) if np.isfinite(frequency) else f"{hertz(float(at[0]))}, {hertz(float(at[1]))}"
            cells = [
                cell(f"{level:g}", float(level)),
                cell(shown),
                cell(number(low / unit), low),
                cell(number(high / unit), high),
            ]
            cells += [*(cell(number(value), value) for value in eta), cell(percent(unsolved[k]), unsolved[k])]
            yield f"<tr>{''.join(cells)}</tr>"
