"""The answer of an identification of frequency responses in a few lines."""

from __future__ import annotations

import json
from typing import TYPE_CHECKING

import numpy as np

from stickslip.laboratory.identification.response_fit import PHASE
from stickslip.support.checks import counted, rounded

if TYPE_CHECKING:
    import xarray as xr

    from stickslip.support.checks import Array

LISTED = 4
"""Tests up to which what each has by itself is listed; of more their range is shown."""


def summary(dataset: xr.Dataset) -> list[str]:
    """Parameters with intervals, what each test has by itself, misfit of each test, notes."""
    lines = [_parameter(dataset, k) for k in range(dataset.sizes["parameter"])]
    lines += [_of_each_test(dataset, str(name)) for name in dataset["own"].values]
    sizes, predicted = 100.0 * dataset["misfit"].values, 100.0 * dataset["held_out"].values
    worst = int(np.argmax(sizes))
    lines.append(
        f"{counted(sizes.size, 'test')}, misfit {rounded(float(np.median(sizes)), 2)} % of the largest response in the median, "
        f"at most {rounded(sizes[worst], 2)} % ({dataset['test'].values[worst]})"
    )
    if np.isfinite(predicted).any():
        lines.append(f"left out and predicted by the others: at most {rounded(float(np.nanmax(predicted)), 2)} %")
    return lines + [note for note in str(dataset.attrs.get("notes", "")).split("\n") if note]


def _parameter(dataset: xr.Dataset, k: int) -> str:
    """A parameter with its interval, a factor with what it makes of the value of the problem; or the lower bound of friction."""
    name = str(dataset["parameter"].values[k])
    value, low, high, least = (float(dataset[key].values[k]) for key in ("value", "low", "high", "least"))
    own, unit = json.loads(dataset.attrs.get("factors", "{}")).get(name, (None, ""))
    if np.isfinite(least):
        known = f"{least:.5g}" if own is None else f"{times(own, least, unit)} (× {least:.5g})" if own else f"× {least:.5g}"
        return f"{name} ≥ {known}: no contact slips or opens, with less one would"
    if own is None:
        return f"{name} = {value:.5g}, 95 % interval {low:.5g} to {high:.5g}"
    if not own:
        return f"{name} × {value:.5g}, 95 % interval × {low:.5g} to {high:.5g}"
    if own[0] < own[1]:
        whole = f"{times(own, value, unit)} over the contacts"
        return f"{name} × {value:.5g} = {whole}, 95 % interval × {low:.5g} to {high:.5g}"
    ends = f"{low * own[0]:.5g} to {times(own, high, unit)}"
    return f"{name} × {value:.5g} = {times(own, value, unit)}, 95 % interval {ends} (× {low:.5g} to {high:.5g})"


def times(own: list[float], factor: float, unit: str) -> str:
    """The value of the problem, or its least and largest one, times a factor."""
    values = " to ".join(dict.fromkeys(f"{factor * value:.5g}" for value in own))
    return f"{values} {unit}".rstrip()


def _of_each_test(dataset: xr.Dataset, name: str) -> str:
    """The values of what each test has by itself, or their range."""
    values: Array = dataset["own_value"].sel(own=name).values
    there = np.isfinite(values)
    tests, values = dataset["test"].values[there], np.degrees(values[there]) if name == PHASE else values[there]
    unit = "°" if name == PHASE else ""
    if values.size > LISTED:
        return f"{name}: {values.min():.4g} to {values.max():.4g}{unit} over {counted(values.size, 'test')}"
    return f"{name}: " + ", ".join(f"{value:.4g}{unit} ({test})" for test, value in zip(tests, values, strict=True))
