"""Report section on percentiles of the response over start states, as a figure and a table."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING

import numpy as np

from stickslip.analyses.variability.percentiles import has_percentiles
from stickslip.analyses.variability.percentiles import percentiles as percentiles_of
from stickslip.results.view import peak_unit
from stickslip.show.plots.variability import response_percentiles
from stickslip.show.report.charts import Charts
from stickslip.show.report.markup import cell, section, table
from stickslip.show.report.numbers import hertz, number

if TYPE_CHECKING:
    import pandas as pd
    import xarray as xr

PERCENT = (5.0, 50.0, 95.0)
NOTE = (
    '<p class="note">Percentiles of the amplitude at each frequency, over the randomly drawn start states of the contacts that '
    "were solved.</p>"
)


def percentiles(datasets: Mapping[str, xr.Dataset], charts: Charts) -> str:
    """Figure and table of every result whose samples share their frequencies."""
    sampled = {label: dataset for label, dataset in datasets.items() if has_percentiles(dataset)}
    parts = []
    for place, (label, dataset) in enumerate(sampled.items()):
        shares, unit, rows = percentiles_of(dataset, PERCENT), peak_unit(dataset), []
        for i, level in enumerate(shares["force_level"].values):
            for k, frequency in enumerate(shares["frequency"].values):
                solved = int(shares["solved"].values[i, k])
                cells = [cell(f"{level:g}", float(level)), cell(hertz(float(frequency)), float(frequency))]
                cells += [cell(str(solved), solved)]
                cells += [cell(number(value / unit.metres), value) for value in shares.values[i, :, k]]
                rows.append(f"<tr>{''.join(cells)}</tr>")
        heads = ["force", "frequency in Hz", "start states", *(f"{p:g} % in {unit.name}" for p in PERCENT)]
        parts.append(charts.drawn(f"chart-percentiles-{place}", response_percentiles(dataset), "Percentiles of the response"))
        parts.append("" if place else NOTE)
        parts.append(table(f"percentiles-{place}", f"{label}: percentiles of the amplitude", heads, rows))
    return section("percentiles", "Percentiles", *parts)


def percentiles_table(dataset: xr.Dataset) -> pd.DataFrame:
    """The percentiles of `percentiles_of` at each force level and frequency, and how many start states they are of."""
    import pandas as pd

    shares = percentiles_of(dataset)
    levels, frequencies = shares["force_level"].values, shares["frequency"].values
    case, at = (index.ravel() for index in np.indices((levels.size, frequencies.size)))
    columns = {"force_level": levels[case], "frequency [Hz]": frequencies[at], "solved": shares["solved"].values[case, at]}
    columns |= {f"{p:g} % [{shares.attrs['units']}]": shares.values[case, k, at] for k, p in enumerate(shares["percent"].values)}
    return pd.DataFrame(columns)
