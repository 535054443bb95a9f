"""Presentation of Campbell diagrams, with the interference diagram of a disk."""

from __future__ import annotations

from collections.abc import Iterator, Mapping

import numpy as np

from stickslip.analyses.speed.campbell import UNSOLVED
from stickslip.results.schema import Certainty, Row
from stickslip.show.plots.paper import Figures
from stickslip.show.plots.speed_sweep import interference, resonances
from stickslip.show.report.markup import Presentation, hertz, presents
from stickslip.show.report.speed_sweep import MOST
from stickslip.support.checks import counted, first_of
from stickslip.support.late import pd, xr

NO_ERROR = (
    "Natural frequencies and crossings are exact for the matrices of the study: errors of the mesh and of its reduction are not "
    "included. Modes are numbered by frequency at each speed"
)
NO_ERROR_OF_RESONANCES = "The error of resonances at a force level due to {} is not estimated: increase both to see it"
ALWAYS = (
    "  warning, natural frequencies: they are the same at all speeds, since the study has K at one speed only. Rotation "
    "stiffens blades: give K at rest or at another speed too (`stiffness_at_rest`, `at_speeds`, [rotation])."
)
ROTATING = (
    "Coriolis forces are included, and frequencies are those in the rotating frame. Whirl is 1 for forward whirl (a circular "
    "motion in the direction of rotation), −1 for backward whirl, and 0 if they have no effect"
)
ANSWER, ALL = "nearest crossings", "all crossings"
CURVES, DIAGRAM = "natural frequencies over the speed", "interference diagram at the operating speed"


def sentences(dataset: xr.Dataset) -> list[str]:
    """The smallest margin or the crossings, each crossing, what holds of all numbers, and warnings."""
    met = _crossings(dataset).dropna(subset=["crossing_speed"])
    lines = [_first(dataset, len(met)), *(_line(row) for _, row in met.head(MOST).iterrows())]
    lines += [f"{MOST} of {len(met)} crossings; the report shows all"] if len(met) > MOST else []
    lines += [ROTATING] if "whirl" in dataset else []
    lines.append(Certainty(NO_ERROR))
    if "force_level" in dataset.attrs:
        fineness = f"harmonics = {dataset.attrs['harmonics']} and samples = {dataset.attrs['samples']}"
        lines.append(Certainty(NO_ERROR_OF_RESONANCES.format(fineness)))
    linear = dataset["frequency"].sel(state=["free", "stuck"]).values
    lines += [ALWAYS] if np.nanmax(np.ptp(linear, axis=-1)) == 0.0 else []
    return [*lines, *(f"  warning, {words}" for words, unsolved in _messages(dataset) if unsolved)]


def _first(dataset: xr.Dataset, count: int) -> str:
    """The smallest margin at the operating speed, of resonances with friction where these are known; else how many crossings."""
    speeds, orders = dataset["speed"].values, dataset["engine_order"].values
    between = f"from {speeds[0]:g} to {speeds[-1]:g} rev/min"
    if "margin" in dataset:
        of = dataset.sel(state=["nonlinear"]) if np.isfinite(dataset["margin"].sel(state="nonlinear")).any() else dataset
        row = _crossings(of).iloc[0]
        way, lies = "above" if row["margin"] >= 0.0 else "below", f"lies at {hertz(row['operating_frequency'])} Hz"
        return (
            f"smallest margin at {dataset.attrs['operating_speed']:g} rev/min: mode {row['mode']} ({row['state']}) {lies}, "
            f"{abs(row['margin']):.2g} % {way} engine order {row['engine_order']}"
        )
    if count:
        return f"{counted(count, 'crossing')} of engine orders and modes {between}, by speed"
    ends = f"{hertz(orders.min() * speeds[0] / 60.0)} to {hertz(orders.max() * speeds[-1] / 60.0)} Hz"
    lowest = hertz(float(np.nanmin(dataset["frequency"].values)))
    return f"no engine order crosses a mode {between}: they excite at {ends}, and the lowest mode is at {lowest} Hz"


def _line(row: pd.Series) -> Row:
    """One crossing."""
    where = f"{row['crossing_speed']:.5g} rev/min, {hertz(row['crossing_frequency'])} Hz"
    margin = f", {row['speed_margin']:+.2g} % from the operating speed" if "speed_margin" in row else ""
    return Row(f"engine order {row['engine_order']}, mode {row['mode']} ({row['state']}): crossing at {where}{margin}")


def _messages(dataset: xr.Dataset) -> Iterator[tuple[str, bool]]:
    """What is said of resonances, and whether it is of the mode alone; without a disk all engine orders have the same."""
    of = dataset if "excited_diameter" in dataset else dataset.isel(engine_order=[0])
    for m, o in np.ndindex(of["message"].shape[:2]):
        said, speeds = of["message"].values[m, o], of["speed"].values
        order = f", engine order {int(of['engine_order'][o])}" if of is dataset else ""
        for message in dict.fromkeys(said[said != ""].tolist()):
            where = first_of([f"{speed:.5g}" for speed in speeds[said == message]])
            yield f"mode {int(of['mode'][m])}{order}, at {where} rev/min: {message}", message == UNSOLVED


def failures(dataset: xr.Dataset) -> list[str]:
    """A sentence for each mode without a resonance at some speeds."""
    return [words for words, unsolved in _messages(dataset) if not unsolved]


HEADS = {
    "engine_order": "engine order",
    "excited_diameter": "nodal diameter",
    "wave": "wave",
    "excitation_frequency": "excitation [Hz]",
    "mode": "mode",
    "state": "contacts",
    "speed": "speed [rev/min]",
    "frequency": "frequency [Hz]",
    "whirl": "whirl",
    "amplitude": "amplitude [m]",
    "crossing_speed": "crossing [rev/min]",
    "crossing_frequency": "frequency there [Hz]",
    "speed_margin": "speed to the operating one [%]",
    "operating_frequency": "frequency at the operating speed [Hz]",
    "nearest_mode": "nearest mode",
    "margin": "frequency to the engine order [%]",
    "disk_margin": "its frequency to the excitation [%]",
}
"""Columns of the tables by the names of the dataset, in their order."""


def _frame(dataset: xr.Dataset, *names: str) -> pd.DataFrame:
    """Variables as columns, a row for each of their coordinates; margins in per cent."""
    of = dataset[[name for name in names if name in dataset]]
    of = of.assign({name: 100.0 * of[name] for name in ("margin", "speed_margin", "disk_margin") if name in of})
    table = of.to_dataframe().reset_index().rename(columns={"disk_state": "state"})
    level = f"force level {dataset.attrs.get('force_level', np.nan):g}"
    table["state"] = table["state"].map({"free": "without contacts", "stuck": "stuck contacts", "nonlinear": level})
    return table[[name for name in HEADS if name in table]]


def _crossings(dataset: xr.Dataset) -> pd.DataFrame:
    """Crossings and margins, the smallest margin first, else the slowest crossing."""
    wanted = ("excited_diameter", "crossing_speed", "crossing_frequency", "speed_margin", "operating_frequency", "margin")
    found = _frame(dataset, *wanted)
    nearness = found["margin"].abs() if "margin" in found else found["crossing_speed"]
    return found.loc[nearness.dropna().sort_values(kind="stable").index]


def tables(dataset: xr.Dataset) -> Mapping[str, pd.DataFrame]:
    """Crossings and margins, frequencies over the speed, and the interference diagram of a disk."""
    found = _crossings(dataset)
    of = dataset.assign(amplitude=dataset["amplitude"].where(dataset["state"] == "nonlinear"))
    if "excited_diameter" not in dataset:  # the curves are the same for all engine orders
        of = of.isel(engine_order=0, drop=True)
    resonances = ["amplitude"] if "force_level" in dataset.attrs else []
    curves = _frame(of, "excited_diameter", "frequency", "whirl", *resonances).dropna(subset=["frequency"])
    shown = {ANSWER: found.head(MOST)} | ({ALL: found} if len(found) > MOST else {}) | {CURVES: curves}
    if "disk_margin" in dataset:
        names = ("excited_diameter", "wave", "excitation_frequency", "nearest_mode", "disk_margin")
        shown[DIAGRAM] = _frame(dataset, *names)
    return {caption: frame.rename(columns=HEADS) for caption, frame in shown.items()}


def figures(dataset: xr.Dataset) -> Figures:
    """The Campbell diagram, and the interference diagram of a disk."""
    found: Figures = {"campbell": resonances}
    return {**found, "interference": interference} if "disk_margin" in dataset else found


PRESENTATION = presents("campbell", Presentation("Campbell diagram", sentences, failures, figures, tables, answer=ANSWER))
