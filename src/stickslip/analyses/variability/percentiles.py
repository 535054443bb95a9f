"""Percentiles of the response over start states with a given distribution."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from stickslip.results.view import measure_in, sizes
from stickslip.support.checks import Array, InputError, fault
from stickslip.support.outcome import Outcome

if TYPE_CHECKING:
    import xarray as xr

PERCENT = (5.0, 25.0, 50.0, 75.0, 95.0)


def percentiles(dataset: xr.Dataset, percent: Sequence[float] = PERCENT, output: int = 0) -> xr.DataArray:
    """Percentiles of the amplitude of samples at each frequency, (force_level, percent, frequency), in m, m/s or m/s² as peaks
    are; `solved` (force_level, frequency) is how many start states they are of.

    Only of samples that were solved exactly at given frequencies: nothing is interpolated. NaN where no curve has a point.
    """
    import xarray as xr

    if not has_percentiles(dataset):
        raise InputError(
            "Percentiles must be of curves at common frequencies, but these were continued over a band. "
            "Give response_samples a list of frequencies instead of a band; in a study, [response_samples] points."
        )
    if not all(0.0 <= p <= 100.0 for p in percent):
        raise fault("percent", "must lie between 0 and 100", list(percent))
    levels, wanted = np.unique(dataset["force_level"].values), dataset["wanted"].values
    amplitude = np.stack([_at(dataset, frequency, output) for frequency in wanted], axis=1)
    cases = [dataset["force_level"].values == level for level in levels]
    table = np.stack([_percentiles(amplitude[which], percent) for which in cases])
    solved = np.stack([np.isfinite(amplitude[which]).sum(axis=0) for which in cases])
    coords = {"force_level": levels, "percent": list(percent), "frequency": wanted}
    coords["solved"] = (("force_level", "frequency"), solved)
    attrs = {"units": measure_in(dataset).units}
    return xr.DataArray(table, coords, ("force_level", "percent", "frequency"), "amplitude", attrs)


def has_percentiles(dataset: xr.Dataset) -> bool:
    """Whether the samples of a dataset were solved at common frequencies."""
    return "wanted" in dataset.variables and "start_variable" in dataset.variables


def _at(dataset: xr.Dataset, frequency: float, output: int) -> Array:
    """The amplitude of every case at a frequency, (case,); the largest where there are several, NaN where there is none."""
    here = np.abs(dataset["frequency"].values - frequency) <= 1e-9 * frequency
    measure, largest = measure_in(dataset), np.full(len(here), np.nan)
    for case, near in enumerate(here & (dataset["outcome"].values == Outcome.CONVERGED)):
        if near.any():
            largest[case] = np.max(sizes(dataset, case, output, measure, np.flatnonzero(near)))
    return largest


def _percentiles(amplitude: Array, percent: Sequence[float]) -> Array:
    """Of solved start states at each frequency, (percent, frequency)."""
    found = np.full((len(percent), amplitude.shape[1]), np.nan)
    for k, column in enumerate(amplitude.T):
        solved = column[np.isfinite(column)]
        found[:, k] = np.percentile(solved, percent) if solved.size else np.nan
    return found
