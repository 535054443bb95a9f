"""Presentation of stepped sines in time."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from itertools import pairwise
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from stickslip.results.view import length_text
from stickslip.show.plots.paper import Figures
from stickslip.show.plots.time_response import stepped_sine
from stickslip.show.report.markup import Presentation, hertz, presents
from stickslip.support.checks import Index, counted
from stickslip.support.late import pd, xr

ANSWER = "highest amplitude at the end of a dwell"

SETTLED = 1e-3
"""Estimated distance from the steady motion below which a dwell counts as long enough."""


class Highest(NamedTuple):
    """The highest amplitude of an output while the frequency goes one way."""

    output: int
    way: str
    step: int


def ways(dataset: xr.Dataset) -> list[tuple[str, Index]]:
    """The steps in runs whose frequency goes up or down, each with the step at which it turned; one step alone goes upwards."""
    rising = np.diff(dataset["frequency"].values) > 0.0
    turns = np.flatnonzero(rising[1:] != rising[:-1]) + 1
    ends = [0, *turns.tolist(), dataset.sizes["step"] - 1]
    runs = [np.arange(low, high + 1) for low, high in pairwise(ends)]
    return [("upwards" if run[0] >= rising.size or rising[run[0]] else "downwards", run) for run in runs]


def highest(dataset: xr.Dataset) -> Iterator[Highest]:
    """Of every output and every run."""
    amplitude = dataset["amplitude"].values
    for output in range(dataset.sizes["output"]):
        for way, run in ways(dataset):
            yield Highest(output, way, int(run[np.argmax(amplitude[run, output])]))


def sentences(dataset: xr.Dataset) -> list[str]:
    """How many dwells were long enough, how far the harmonic balance is from them, and the highest amplitudes."""
    frequency, settled = dataset["frequency"].values, dataset["distance"].values < SETTLED
    line = f"{counted(len(frequency), 'dwell')} of {int(dataset.attrs['dwell'])} periods: "
    if settled.all():
        lines = [f"{line}all end within {_share(SETTLED)} of the steady motion, by estimate"]
    else:
        where = " to ".join(dict.fromkeys(hertz(f) for f in (frequency[~settled].min(), frequency[~settled].max())))
        lines = [
            f"{line}{int(settled.sum())} end within {_share(SETTLED)} of the steady motion, by estimate; the others, at {where} "
            "Hz, are farther from it; longer dwells would bring them nearer"
        ]
    lines += _beside(dataset, settled)
    for output, way, step in highest(dataset):
        size = length_text(float(dataset["amplitude"].values[step, output]), dataset)
        lines.append(f"{dataset['output'].values[output]}: highest amplitude {way} {size} at {hertz(frequency[step])} Hz")
    return lines


def _share(value: float) -> str:
    """A share in per cent, to two digits."""
    return f"{100.0 * value:.2g} %"


def _beside(dataset: xr.Dataset, settled: NDArray[np.bool_]) -> list[str]:
    """How far the harmonic balance is from the dwells, relative to the highest steady amplitude of each output."""
    if "balance_amplitude" not in dataset:
        return []
    balance, frequency = dataset["balance_amplitude"].values, dataset["frequency"].values
    lines = [f"harmonic balance: {dataset['balance_message'].values}"]
    if not np.isfinite(balance).any():
        return lines
    apart = np.nan_to_num(np.abs(dataset["amplitude"].values - balance) / np.nanmax(balance, axis=0)).max(axis=1)
    sets = {"that end near the steady motion": settled, "that are farther from it": ~settled}
    for which, steps in sets.items():
        if steps.any():
            worst = np.flatnonzero(steps)[np.argmax(apart[steps])]
            lines.append(
                f"harmonic balance: differs from the dwells {which} by up to {_share(apart[worst])} of its highest amplitude, at "
                f"{hertz(frequency[worst])} Hz"
            )
    return lines


def failures(dataset: xr.Dataset) -> list[str]:
    """Frequencies at which the harmonic balance has no solution; a dwell that fails is refused."""
    if "balance_amplitude" not in dataset:
        return []
    unsolved = int(np.isnan(dataset["balance_amplitude"].values).any(axis=1).sum())
    return [f"harmonic balance: {counted(unsolved, 'frequency', 'frequencies')} could not be solved"] if unsolved else []


def tables(dataset: xr.Dataset) -> Mapping[str, pd.DataFrame]:
    """The highest amplitude of each output and way, and all dwells."""
    columns = {"amplitude [m]": "amplitude"}
    if "balance_amplitude" in dataset:
        columns["harmonic balance [m]"] = "balance_amplitude"
    columns["largest displacement [m]"] = "max_abs"
    frequency, distance = dataset["frequency"].values, dataset["distance"].values
    distance = np.where(np.isfinite(distance), distance, np.nan)
    top, every = [], []
    for output, way, step in highest(dataset):
        values = [float(dataset[key].values[step, output]) for key in columns.values()]
        top.append((str(dataset["output"].values[output]), way, float(frequency[step]), *values, float(distance[step])))
    for step, output in np.ndindex(dataset["amplitude"].shape):
        values = [float(dataset[key].values[step, output]) for key in columns.values()]
        every.append((str(dataset["output"].values[output]), float(frequency[step]), *values, float(distance[step])))
    end = [*columns, "estimated relative distance from the steady motion [1]"]
    return {
        ANSWER: pd.DataFrame(top, columns=["output", "sweep direction", "frequency [Hz]", *end]),
        "dwells": pd.DataFrame(every, columns=["output", "frequency [Hz]", *end]),
    }


def figures(dataset: xr.Dataset) -> Figures:
    """Amplitudes, and distances from the steady motion."""
    return {"stepped_sine": stepped_sine}


PRESENTATION = presents("stepped_sine", Presentation("Stepped sine", sentences, failures, figures, tables, ANSWER))
