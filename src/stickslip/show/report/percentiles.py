"""Report section on percentiles of the response over start states, as a figure and a table."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import TYPE_CHECKING

import numpy as np

from stickslip.analyses.variability.percentiles import has_percentiles
from stickslip.analyses.variability.percentiles import percentiles as percentiles_of
from stickslip.results.view import peak_unit
from stickslip.show.plots.response_samples import response_percentiles
from stickslip.show.report.charts import Charts
from stickslip.show.report.markup import cell, section, table
from stickslip.show.report.numbers import hertz, number

if TYPE_CHECKING:
    import pandas as pd
    import xarray as xr

PERCENT = (5.0, 50.0, 95.0)
NOTE = (
    '<p class="note">The start states of the contacts are drawn from a law; these are the percentiles of the amplitude that '
    "follow, at each frequency, of the start states that were solved.</p>"
)


def percentiles(datasets: Mapping[str, xr.Dataset], charts: Charts) -> str:
    """Figure and table of every result whose samples share their frequencies."""
    found = {label: dataset for label, dataset in datasets.items() if has_percentiles(dataset)}
    return section("percentiles", "Percentiles", NOTE, *(_part(charts, k, *item) for k, item in enumerate(found.items())))


def percentiles_table(dataset: xr.Dataset) -> pd.DataFrame:
    """The percentiles of `percentiles_of` at each force level and frequency, and how many start states they are of."""
    import pandas as pd

    found = percentiles_of(dataset)
    levels, frequencies = found["force_level"].values, found["frequency"].values
    case, at = (index.ravel() for index in np.indices((levels.size, frequencies.size)))
    columns = {"force_level": levels[case], "frequency [Hz]": frequencies[at], "solved": found["solved"].values[case, at]}
    columns |= {f"{p:g} % [{found.attrs['units']}]": found.values[case, k, at] for k, p in enumerate(found["percent"].values)}
    return pd.DataFrame(columns)


def _part(charts: Charts, place: int, label: str, dataset: xr.Dataset) -> str:
    heads = ["force", "frequency in Hz", "start states", *(f"{p:g} % in {peak_unit(dataset).name}" for p in PERCENT)]
    figure = charts.drawn(f"chart-percentiles-{place}", response_percentiles(dataset), "Percentiles of the response")
    return figure + table(f"percentiles-{place}", f"{label}: percentiles of the amplitude", heads, _rows(dataset))


def _rows(dataset: xr.Dataset) -> Iterator[str]:
    found, unit = percentiles_of(dataset, PERCENT), peak_unit(dataset).metres
    for i, level in enumerate(found["force_level"].values):
        for k, frequency in enumerate(found["frequency"].values):
            solved = int(found["solved"].values[i, k])
            cells = [cell(f"{level:g}", float(level)), cell(hertz(float(frequency)), float(frequency)), cell(str(solved), solved)]
            cells += [cell(number(value / unit), value) for value in found.values[i, :, k]]
            yield f"<tr>{''.join(cells)}</tr>"
