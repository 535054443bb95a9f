"""Presentation of run-ups and run-downs in time."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from stickslip.results.view import length_text, level_text
from stickslip.show.plots.speed_sweep import run_up
from stickslip.show.report.markup import Presentation, always, hertz, presents
from stickslip.support.late import pd, xr

NO_ERROR = (
    "The error of the time steps is not estimated: double steps_per_period to see it. Stiffness and constant loads are those at "
    "the middle of each cycle"
)
ANSWER, CYCLES = "largest amplitudes", "every cycle"


def _name(dataset: xr.Dataset, case: int) -> str:
    return f"engine order {int(dataset['engine_order'].values[case])}, {level_text(dataset, case)}"


def sentences(dataset: xr.Dataset) -> list[str]:
    """The largest amplitude of the first output in each run, and what a run warns of."""
    lines, warnings = [], []
    for case in range(dataset.sizes["case"]):
        run, name = dataset.isel(case=case, output=0), _name(dataset, case)
        sizes = run["amplitude"].values
        if np.isfinite(sizes).any():
            top = run.isel(cycle=int(np.nanargmax(sizes)))
            where = f"{float(top['speed']):.5g} rev/min ({hertz(float(top['frequency']))} Hz), {float(top['time']):.4g} s after"
            size, largest = length_text(float(top["amplitude"]), dataset), length_text(np.nanmax(run["max_abs"].values), dataset)
            output = str(dataset["output"].values[0])
            lines.append(f"{name}: {output} at most {size} at {where} the start; largest displacement of the run {largest}")
        _, _, more = str(run["message"].item()).partition(". ")
        warnings += [f"  warning, {name}: {more}"] if more and str(run["outcome"].item()) == "complete" else []
    return [*lines, NO_ERROR, *warnings]


def failures(dataset: xr.Dataset) -> list[str]:
    """A sentence for each run that ended early."""
    ended = np.flatnonzero(dataset["outcome"].values != "complete")
    return [f"{_name(dataset, case)}: {dataset['message'].values[case]}" for case in ended]


def tables(dataset: xr.Dataset) -> Mapping[str, pd.DataFrame]:
    """The largest amplitude of every output in each run."""
    rows = []
    for case, output in np.ndindex(dataset.sizes["case"], dataset.sizes["output"]):
        run = dataset.isel(case=case, output=output)
        if np.isfinite(run["amplitude"].values).any():
            top = run.isel(cycle=int(np.nanargmax(run["amplitude"].values)))
            first = int(top["engine_order"]), float(top["force_level"]), str(top["output"].values)
            values = [float(top[name]) for name in ("amplitude", "speed", "frequency", "time")]
            rows.append((*first, *values, float(np.nanmax(run["max_abs"].values))))
    heads = ["engine order", "force level", "output", "amplitude [m]", "speed [rev/min]", "frequency [Hz]", "time [s]"]
    return {ANSWER: pd.DataFrame(rows, columns=[*heads, "largest displacement [m]"])}


def histories(dataset: xr.Dataset) -> Mapping[str, pd.DataFrame]:
    """Every cycle of every run."""
    table = dataset[["time", "speed", "frequency", "amplitude", "max_abs"]].to_dataframe().reset_index().dropna(subset=["time"])
    units = {"time": "s", "speed": "rev/min", "frequency": "Hz", "amplitude": "m", "max_abs": "m"}
    table["cycle"] += 1
    first = ["engine_order", "force_level", "output", "cycle"]
    heads = {"max_abs": "largest displacement"} | {name: name.replace("_", " ") for name in first}
    named = {name: f"{heads.get(name, name)} [{unit}]" for name, unit in units.items()}
    return {CYCLES: table[[*first, *units]].rename(columns=heads | named)}


PRESENTATION = presents(
    "run_up",
    Presentation("Run-up in time", sentences, failures, always({"run_up": run_up}), tables, answer=ANSWER, histories=histories),
)
