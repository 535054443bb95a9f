"""Presentation of run-ups and run-downs in time."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from stickslip.results.view import length_text, level_head, level_text
from stickslip.show.plots.speed_sweep import run_up
from stickslip.show.report.markup import Presentation, always, hertz, presents
from stickslip.support.late import pd, xr

ANSWER, CYCLES = "largest amplitudes", "every cycle"


def _name(dataset: xr.Dataset, case: int) -> str:
    return f"engine order {int(dataset['engine_order'].values[case])}, {level_text(dataset, case)}"


def sentences(dataset: xr.Dataset) -> list[str]:
    """The largest amplitude of the first output in each run, and what a run warns of."""
    lines, warnings = [], []
    for case in range(dataset.sizes["case"]):
        name, (first, _, more) = _name(dataset, case), dataset["message"].values[case].partition(". ")
        warnings += [f"  warning, {name}: {more}"] if more and first == "Complete" else []
        top = _largest(dataset, case, 0)
        size, largest = (length_text(float(top[key]), dataset) for key in ("amplitude", "largest"))
        where = (
            f"{float(top['speed']):.5g} rev/min ({hertz(float(top['frequency']))} Hz), {float(top['time']):.4g} s after the start"
        )
        lines.append(f"{name}: {top['output'].item()} at most {size} at {where}; largest displacement of the run {largest}")
    return [*lines, *warnings]


def _largest(dataset: xr.Dataset, case: int, output: int) -> xr.Dataset:
    """The cycle of a run with the largest amplitude of an output, and the largest displacement of all."""
    run = dataset.isel(case=case, output=output)
    top = run.isel(cycle=int(np.argmax(run["amplitude"].fillna(-1.0).values)))
    return top.assign(largest=run["max_abs"].max())


def failures(dataset: xr.Dataset) -> list[str]:
    """A sentence for each run that ended early."""
    ended = np.flatnonzero(dataset["outcome"].values != "complete").tolist()
    return [f"{_name(dataset, case)}: {dataset['message'].values[case]}" for case in ended]


HEADS = {"engine_order": "engine order", "force_level": "force level", "output": "output", "cycle": "cycle"}
HEADS |= {"amplitude": "amplitude [m]", "speed": "speed [rev/min]", "frequency": "frequency [Hz]", "time": "time [s]"}
HEADS |= {"max_abs": "largest displacement [m]", "largest": "largest displacement [m]"}
"""Columns of the tables by the names of the dataset."""


def tables(dataset: xr.Dataset) -> Mapping[str, pd.DataFrame]:
    """The largest amplitude of every output in each run."""
    names = [name for name in HEADS if name not in ("cycle", "max_abs")]
    tops = [_largest(dataset, *place) for place in np.ndindex(dataset.sizes["case"], dataset.sizes["output"])]
    rows = [[top[name].item() for name in names] for top in tops]
    return {ANSWER: pd.DataFrame(rows, columns=names).rename(columns=HEADS | {"force_level": level_head(dataset)})}


def histories(dataset: xr.Dataset) -> Mapping[str, pd.DataFrame]:
    """Every cycle of every run."""
    names = [name for name in HEADS if name != "largest"]
    table = dataset[["time", "speed", "frequency", "amplitude", "max_abs"]].to_dataframe().reset_index()
    return {CYCLES: table.dropna(subset=["time"])[names].rename(columns=HEADS | {"force_level": level_head(dataset)})}


PRESENTATION = presents(
    "run_up",
    Presentation("Run-up in time", sentences, failures, always({"run_up": run_up}), tables, answer=ANSWER, histories=histories),
)
