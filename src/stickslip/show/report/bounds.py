"""Report sections on response variability: bounds over the start states, and percentiles of sampled ones, each as a figure and a
table."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from stickslip.analyses.variability.bounds import detached, has_bounds
from stickslip.analyses.variability.samples import has_percentiles
from stickslip.analyses.variability.samples import percentiles as percentiles_of
from stickslip.results.view import measure_in, peak_unit
from stickslip.show.plots.variability import bound_unit, response_bounds, response_percentiles
from stickslip.show.report.markup import Charts, cell, hertz, number, percent, section, table
from stickslip.solve.balance.measure import DISPLACEMENT_AMPLITUDE
from stickslip.support.late import pd, xr

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


PERCENT = (5.0, 50.0, 95.0)
OF_PERCENTILES = (
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
        parts.append("" if place else OF_PERCENTILES)
        parts.append(table(f"percentiles-{place}", f"{label}: percentiles of the amplitude", heads, rows))
    return section("percentiles", "Percentiles", *parts)


def percentiles_table(dataset: xr.Dataset) -> pd.DataFrame:
    """The percentiles of `percentiles_of` at each force level and frequency, and how many start states they are of."""
    shares = percentiles_of(dataset)
    levels, frequencies = shares["force_level"].values, shares["frequency"].values
    case, at = (index.ravel() for index in np.indices((levels.size, frequencies.size)))
    columns = {"force_level": levels[case], "frequency [Hz]": frequencies[at], "solved": shares["solved"].values[case, at]}
    columns |= {f"{p:g} % [{shares.attrs['units']}]": shares.values[case, k, at] for k, p in enumerate(shares["percent"].values)}
    return pd.DataFrame(columns)
