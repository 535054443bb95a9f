"""Presentations of motions in time: free decays, computed and measured, and stepped sines."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from itertools import pairwise
from typing import Any

import numpy as np
from numpy.typing import NDArray

from stickslip.results.schema import Row
from stickslip.results.view import length_text
from stickslip.show.plots.time_response import decay, measured, stepped_sine
from stickslip.show.report.markup import hertz, percent, presents
from stickslip.support.checks import Index, counted, first_of, in_percent
from stickslip.support.late import pd, xr

ANSWER = "frequency and damping over the amplitude"

SURE = 1.96
"""Standard errors on each side that hold 95 % of the values."""

ROWS = 9
"""Windows of a measured decay in its first table."""


GROWTH, SHARE = 1e-3, 0.02
"""Negative damping ratio of a half cycle that grows, and the share of such half cycles above which several modes move: the
amplitude of a single mode never grows."""


def sentences(dataset: xr.Dataset) -> list[str]:
    """Of each output the first and the last half cycle and the most damping, or that several modes move."""
    lines, mixed = [], []
    for k, name in enumerate(dataset["output"].values):
        amplitude, frequency, damping = (dataset[key].values[k] for key in ("amplitude", "frequency", "damping_ratio"))
        there = np.flatnonzero(np.isfinite(frequency) & np.isfinite(damping))
        if not there.size:
            lines.append(f"{name}: fewer than three half cycles, so no damping ratio")
            continue
        if np.mean(damping[there] < -GROWTH) > SHARE:
            mixed.append(str(name))
            continue
        first, last, most = there[0], there[-1], there[int(np.argmax(damping[there]))]
        lines.append(
            f"{name}: {hertz(frequency[first])} Hz at {length_text(amplitude[first], dataset)}, {hertz(frequency[last])} Hz at "
            f"{length_text(amplitude[last], dataset)}; most damping {percent(damping[most])} at "
            f"{length_text(amplitude[most], dataset)}"
        )
    if mixed:
        lines.append(
            f"{', '.join(mixed)}: some half cycles are larger than those before them, so several modes move and no half cycle "
            "has the frequency and damping of one of them. Write the motion with `stickslip export RESULTS --out NAME.csv`, then "
            f"run `stickslip decay NAME_motion.csv --column 'signal={mixed[0]}' --band LOW:HIGH` for each mode (in "
            "Python `ss.measured_decay(time, signal, band=(low, high))`)"
        )
    return lines


def tables(dataset: xr.Dataset) -> Mapping[str, pd.DataFrame]:
    """The half cycles of all outputs."""
    columns: dict[str, Any] = {"output": np.repeat(dataset["output"].values, dataset.sizes["half_cycle"])}
    keys = ("turning_time", "turning_point", "amplitude", "frequency", "damping_ratio")
    for key in keys:
        factor, unit = (100.0, "%") if key == "damping_ratio" else (1.0, dataset[key].attrs["units"])
        columns[f"{key.replace('_', ' ')} [{unit}]"] = factor * dataset[key].values.ravel()
    return {"half cycles": pd.DataFrame(columns).dropna(subset=["turning time [s]"], ignore_index=True)}


def histories(dataset: xr.Dataset) -> Mapping[str, pd.DataFrame]:
    """The motion of all outputs over time, which `stickslip decay` reads."""
    motion = dataset["displacement"]
    outputs = {f"{name} [m]": values for name, values in zip(dataset["output"].values, motion.values, strict=True)}
    return {"motion": pd.DataFrame({"time [s]": dataset["time"].values, **outputs})}


def measured_sentences(dataset: xr.Dataset) -> list[str]:
    """The first and the last window and the most damping, with standard errors, and how far the nonlinear modes are from all."""
    amplitude, frequency, ratio = (dataset[key].values for key in ("amplitude", "frequency", "damping_ratio"))
    errors = [dataset[f"{key}_error"].values for key in ("frequency", "damping_ratio")]
    lines = [
        f"{words}: {length_text(float(amplitude[k]), dataset)}, {hertz(frequency[k])} Hz (standard error {errors[0][k]:.2g} Hz), "
        f"damping {percent(ratio[k])} (standard error {in_percent(errors[1][k])})"
        for words, k in (("first window", 0), ("most damping", int(np.argmax(ratio))), ("last window", -1))
    ]
    if np.any(fed := ratio + SURE * errors[1] < 0.0):
        lines.append(
            f"negative damping in {np.count_nonzero(fed)} of {fed.size} windows: the motion grows there, because something feeds "
            "it or another mode moves too"
        )
    if dataset.attrs.get("second_mode", 0.0) > 0.0:
        lines.append(f"a second line of {hertz(dataset.attrs['second_mode'])} Hz in the band is fitted beside the mode")
    if "sensors" in dataset.attrs:
        lines.append(dataset.attrs["sensors"])
    if "window_cycles" in dataset.attrs:
        lines.append(f"windows of {dataset.attrs['window_cycles']:.3g} cycles")
    for mode in range(dataset.sizes.get("mode", 0)):
        x = dataset["mode_amplitude"].values[mode, :, 0]
        known = np.isfinite(x)
        order = np.argsort(x[known])
        along = x[known][order]
        inside = (amplitude >= along.min(initial=np.inf)) & (amplitude <= along.max(initial=0.0))
        if not inside.any():
            continue
        at = [
            np.interp(amplitude[inside], along, dataset[key].values[mode].reshape(x.size, -1)[known, 0][order])
            for key in ("mode_frequency", "mode_damping_ratio")
        ]
        apart = at[0] / frequency[inside] - 1.0, 100.0 * (at[1] - ratio[inside])
        least, most = (in_percent(float(each), "+") for each in (apart[0].min(), apart[0].max()))
        lines.append(
            f"a slow decay along nonlinear mode {int(dataset['mode'].values[mode])} at the same amplitudes: its frequency "
            f"differs from the measured one by {least} to {most}, its damping "
            f"ratio by {apart[1].min():+.2g} to {apart[1].max():+.2g} percentage points"
        )
    return lines


def measured_tables(dataset: xr.Dataset) -> Mapping[str, pd.DataFrame]:
    """Windows at amplitudes in equal ratios, and all windows."""
    keys = [str(key) for key, variable in dataset.variables.items() if variable.dims == ("window",) and str(key) != "window"]
    columns = {f"{key.replace('_', ' ')} [{dataset[key].attrs['units']}]": dataset[key].values for key in keys}
    size, windows = np.log(dataset["amplitude"].values), pd.DataFrame(columns)
    shown = np.unique([int(np.argmin(np.abs(size - at))) for at in np.linspace(size.max(), size.min(), ROWS)])
    answer = windows[[f"{key} [{dataset[key].attrs['units']}]" for key in ("amplitude", "frequency")]].copy()
    answer[f"standard error [{dataset['frequency'].attrs['units']}]"] = dataset["frequency_error"].values
    for key, title in (("damping_ratio", "damping ratio [%]"), ("damping_ratio_error", "standard error [%]")):
        answer[title] = 100.0 * dataset[key].values
    return {ANSWER: answer.iloc[shown].reset_index(drop=True), "windows": windows}


presents("measured_decay", "Measured decay", measured_sentences, {"measured_decay": measured}, measured_tables, answer=ANSWER)
presents("free_decay", "Free decay", sentences, {"decay": decay}, tables, histories=histories)


STEPPED_ANSWER = "highest amplitude at the end of a dwell"

SETTLED = 1e-3
"""Estimated distance from the steady motion below which a dwell counts as long enough."""


def ways(dataset: xr.Dataset) -> list[tuple[str, Index]]:
    """The steps in runs whose frequency goes up or down, each with the step at which it turned; one step alone goes upwards."""
    rising = np.diff(dataset["frequency"].values) > 0.0
    turns = np.flatnonzero(rising[1:] != rising[:-1]) + 1
    ends = [0, *turns.tolist(), dataset.sizes["step"] - 1]
    runs = [np.arange(low, high + 1) for low, high in pairwise(ends)]
    return [("upwards" if run[0] >= rising.size or rising[run[0]] else "downwards", run) for run in runs]


def highest(dataset: xr.Dataset) -> Iterator[tuple[int, str, int]]:
    """Output, way and step of the highest amplitude of every output in every run that goes one way."""
    amplitude = dataset["amplitude"].values
    for output in range(dataset.sizes["output"]):
        for way, run in ways(dataset):
            yield output, way, int(run[np.argmax(amplitude[run, output])])


def stepped_sentences(dataset: xr.Dataset) -> list[str]:
    """How many dwells were long enough, how far the harmonic balance is from them, and the highest amplitudes."""
    frequency, settled = dataset["frequency"].values, dataset["distance"].values < SETTLED
    line = f"{counted(len(frequency), 'dwell')} of {int(dataset.attrs['dwell'])} periods: "
    if settled.all():
        lines = [f"{line}all end within {in_percent(SETTLED)} of the steady motion, by estimate"]
    else:
        lines = [
            f"{line}{int(settled.sum())} end within {in_percent(SETTLED)} of the steady motion, by estimate. The others "
            f"({_places(dataset, ~settled)}) do not: increase `dwell` there"
        ]
    lines += _beside(dataset, settled)
    for output, way, step in highest(dataset):
        size = length_text(float(dataset["amplitude"].values[step, output]), dataset)
        row = f"{dataset['output'].values[output]}: highest amplitude {way} {size} at {hertz(frequency[step])} Hz"
        lines.append(Row(row))
    return lines


def _places(dataset: xr.Dataset, chosen: NDArray[np.bool_]) -> str:
    """The frequencies of some dwells, neighbours as one range; those of each way of the sweep by themselves."""
    ranges = []
    for way, run in ways(dataset):
        at = run[chosen[run]]
        groups = np.split(at, np.flatnonzero(np.diff(at) > 1) + 1) if at.size else []
        ends = [dict.fromkeys(hertz(float(dataset["frequency"].values[k])) for k in (group[0], group[-1])) for group in groups]
        ranges += [f"{way} {first_of([' to '.join(words) for words in ends])} Hz"] if ends else []
    return "; ".join(ranges)


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
                f"harmonic balance: differs from the dwells {which} by up to {in_percent(apart[worst])} of its highest "
                f"amplitude, at {hertz(frequency[worst])} Hz"
            )
    return lines


def stepped_failures(dataset: xr.Dataset) -> list[str]:
    """Frequencies at which the harmonic balance has no solution; a dwell that fails is refused."""
    if "balance_amplitude" not in dataset:
        return []
    unsolved = int(np.isnan(dataset["balance_amplitude"].values).any(axis=1).sum())
    return [f"harmonic balance: {counted(unsolved, 'frequency', 'frequencies')} could not be solved"] if unsolved else []


def stepped_tables(dataset: xr.Dataset) -> Mapping[str, pd.DataFrame]:
    """The highest amplitude of each output and way, and all dwells."""
    columns = {"amplitude [m]": "amplitude"}
    if "balance_amplitude" in dataset:
        columns["harmonic balance [m]"] = "balance_amplitude"
    columns["largest displacement [m]"] = "max_abs"
    end = "estimated distance from the steady motion [%]"

    def listed(step: Any, output: Any, way: Mapping[str, Any]) -> pd.DataFrame:
        """A row for each step and output, with columns between both."""
        distance = np.round(100.0 * dataset["distance"].values[step], 3)
        found = {"output": dataset["output"].values.astype(object)[output], **way}
        found |= {"frequency [Hz]": dataset["frequency"].values[step]}
        found |= {head: dataset[name].values[step, output] for head, name in columns.items()}
        return pd.DataFrame(found | {end: np.where(np.isfinite(distance), distance, np.nan)})

    output, way, step = zip(*highest(dataset), strict=True)
    steps, outputs = (index.ravel() for index in np.indices(dataset["amplitude"].shape))
    top = listed(list(step), list(output), {"sweep direction": way})
    return {STEPPED_ANSWER: top, "dwells": listed(steps, outputs, {})}


presents(
    "stepped_sine",
    "Stepped sine",
    stepped_sentences,
    {"stepped_sine": stepped_sine},
    stepped_tables,
    failures=stepped_failures,
    answer=STEPPED_ANSWER,
)
