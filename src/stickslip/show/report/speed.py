"""Presentations of what goes over the rotor speed: speed sweeps, Campbell diagrams with the interference diagram of a disk, and
run-ups and run-downs in time."""

from __future__ import annotations

from collections.abc import Iterator, Mapping

import numpy as np

from stickslip.analyses.speed.campbell import UNSOLVED
from stickslip.results.schema import Certainty, Row
from stickslip.results.view import length_text, level_head, level_text, linear_peak
from stickslip.show.plots.paper import Figures
from stickslip.show.plots.speed_sweep import interference, over_speed, resonances, run_up
from stickslip.show.report.answer import error_words, errors_of
from stickslip.show.report.markup import hertz, percent, presents
from stickslip.support.checks import counted, first_of
from stickslip.support.late import pd, xr
from stickslip.support.outcome import Outcome

MOST = 12
"""Curves, or crossings, with a sentence each."""
LINEAR = {"stuck": "with stuck contacts", "free": "without contacts"}
"""The linear responses that peaks are compared with."""


def sentences(dataset: xr.Dataset) -> list[str]:
    """The highest peak of the first output, of all curves and for each engine order and force level, with the estimate of its
    error and beside the linear resonances; what the curves warn of."""
    curves = list(np.ndindex(dataset["outcome"].shape[:2]))
    lines = [_highest(dataset, e, case) for e, case in curves[:MOST]]
    peaks = dataset["peak_amplitude"].values[..., 0] if dataset.sizes["peak"] else np.array([np.nan])
    if len(curves) > 1 and np.isfinite(peaks).any():
        e, case, _ = np.unravel_index(np.nanargmax(peaks), peaks.shape)
        highest = _highest(dataset, int(e), int(case))
        lines = [f"highest peak: {highest}", *(line for line in lines if line != highest)]
    lines += [f"{MOST} of {len(curves)} curves; the report shows all"] if len(curves) > MOST else []
    warnings = []
    for e, case in curves:
        # The message of a curve that arrived warns of what follows its first sentence.
        _, _, more = str(dataset["case_message"].values[e, case]).partition(". ")
        if more.strip() and int(dataset["case_outcome"].values[e, case]) == Outcome.CONVERGED:
            warnings.append(f"  warning, {_name(dataset, e, case)}: {more.strip()}")
    return [*lines, *warnings[:MOST]]


def _name(dataset: xr.Dataset, e: int, case: int) -> str:
    return f"engine order {int(dataset['engine_order'].values[e])}, {level_text(dataset, case)}"


def _highest(dataset: xr.Dataset, e: int, case: int) -> str:
    """The highest peak of a curve with the estimate of its error, beside the linear resonances; else its largest point."""
    name, output = _name(dataset, e, case), str(dataset["output"].values[0])
    solved = dataset["outcome"].values[e, case] == Outcome.CONVERGED
    if not solved.any():
        return f"{name}: no point was found"
    if dataset.sizes["peak"] and np.isfinite(dataset["peak_speed"].values[e, case, 0, 0]):
        names = ("peak_speed", "peak_frequency", "peak_amplitude")
        speed, frequency, size = (float(dataset[name].values[e, case, 0, 0]) for name in names)
        of_order = dataset.isel(engine_order=e)
        error = error_words(of_order, case, 0)
        clauses = [f"{output} {length_text(size, dataset)} at {speed:.5g} rev/min ({hertz(frequency)} Hz)"]
        clauses.append(f"estimated error {error}" if errors_of(of_order, case, 0) else f"error {error}")
        for which, linear in _linear(of_order, case, frequency, 0, size).items():
            change = size / linear - 1.0
            clauses.append(f"{percent(abs(change))} {'lower' if change <= 0.0 else 'higher'} than {LINEAR[which]}")
        return f"{name}: {'; '.join(clauses)}"
    sizes = np.where(solved, dataset["amplitude"].values[e, case, :, 0], -np.inf)
    k = int(np.argmax(sizes))
    speed = float(dataset["speed"].values[e, case, k])
    return f"{name}: no resonance in the range; {output} at most {length_text(float(sizes[k]), dataset)}, at {speed:.5g} rev/min"


def _linear(of_order: xr.Dataset, case: int, frequency: float, output: int, size: float) -> dict[str, float]:
    """The heights of the linear resonances of the mode of a peak of an engine order, with stuck contacts and without contacts;
    empty where both curves are the same, as without contacts, and where they are not known."""
    if np.array_equal(of_order["stuck_amplitude"].values, of_order["free_amplitude"].values, equal_nan=True):
        return {}
    peaks = {which: linear_peak(of_order, which, case, frequency, output, size) for which in LINEAR}
    return {which: peak[1] for which, peak in peaks.items() if peak is not None}


def failures(dataset: xr.Dataset) -> list[str]:
    """A sentence for each curve that did not arrive."""
    outcomes = dataset["case_outcome"].values
    return [
        f"{_name(dataset, e, case)}: {dataset['case_message'].values[e, case]}"
        for e, case in np.argwhere(outcomes != Outcome.CONVERGED)
    ]


def tables(dataset: xr.Dataset) -> Mapping[str, pd.DataFrame]:
    """All peaks, with the estimate of error at the highest of each curve and beside the linear resonances, and every point of
    every curve."""
    outputs = [str(name) for name in dataset["output"].values]
    peaks, points = [], []
    for e, case in np.ndindex(dataset["outcome"].shape[:2]):
        level = float(dataset["force_level"].values[case])
        first = {"engine order": int(dataset["engine_order"].values[e]), level_head(dataset): level}
        for k, o in np.argwhere(np.isfinite(dataset["peak_speed"].values[e, case])):
            names = ("peak_speed", "peak_frequency", "peak_amplitude", "peak_loss_factor")
            speed, frequency, size, loss = (dataset[name].values[e, case, k, o] for name in names)
            row: dict[str, object] = {**first, "output": outputs[o], "speed [rev/min]": speed, "frequency [Hz]": frequency}
            row |= {"amplitude [m]": size, "loss factor": loss}
            of_order = dataset.isel(engine_order=e)
            linear = _linear(of_order, case, float(frequency), int(o), float(size))
            row |= {f"{words} [m]": linear.get(which, np.nan) for which, words in LINEAR.items()}
            errors = errors_of(of_order, case, int(o)).values() if k == 0 else ()
            peaks.append(row | {"estimated error [%]": 100.0 * max(errors, default=np.nan)})
        for k in np.flatnonzero(dataset["outcome"].values[e, case] == Outcome.CONVERGED):
            speed, frequency = (dataset[name].values[e, case, k] for name in ("speed", "frequency"))
            row = {**first, "speed [rev/min]": speed, "frequency [Hz]": frequency}
            row |= {f"{name} [m]": dataset["amplitude"].values[e, case, k, o] for o, name in enumerate(outputs)}
            points.append(row)
    count = counted(dataset.sizes["engine_order"], "engine order")
    return {"peaks": pd.DataFrame(peaks), f"amplitude over the speed, {count}": pd.DataFrame(points)}


presents("speed_sweep", "Speed sweep", sentences, {"speed_sweep": over_speed}, tables, failures=failures)


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
NEAREST, EVERY = "nearest crossings", "all crossings"
CURVES, DIAGRAM = "natural frequencies over the speed", "interference diagram at the operating speed"


def campbell_sentences(dataset: xr.Dataset) -> list[str]:
    """The smallest margin or the crossings, each crossing, what holds of all numbers, and warnings."""
    met = _crossings(dataset).dropna(subset=["crossing_speed"])
    lines = [_smallest_margin(dataset, len(met)), *(_crossing(row) for _, row in met.head(MOST).iterrows())]
    lines += [f"{MOST} of {len(met)} crossings; the report shows all"] if len(met) > MOST else []
    lines += [ROTATING] if "whirl" in dataset else []
    lines.append(Certainty(NO_ERROR))
    if "force_level" in dataset.attrs:
        fineness = f"harmonics = {dataset.attrs['harmonics']} and samples = {dataset.attrs['samples']}"
        lines.append(Certainty(NO_ERROR_OF_RESONANCES.format(fineness)))
    linear = dataset["frequency"].sel(state=["free", "stuck"]).values
    lines += [ALWAYS] if np.nanmax(np.ptp(linear, axis=-1)) == 0.0 else []
    return [*lines, *(f"  warning, {words}" for words, unsolved in _messages(dataset) if unsolved)]


def _smallest_margin(dataset: xr.Dataset, count: int) -> str:
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


def _crossing(row: pd.Series) -> Row:
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


def campbell_failures(dataset: xr.Dataset) -> list[str]:
    """A sentence for each mode without a resonance at some speeds."""
    return [words for words, unsolved in _messages(dataset) if not unsolved]


CAMPBELL_HEADS = {
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
"""Columns of the campbell_tables by the names of the dataset, in their order."""


def _frame(dataset: xr.Dataset, *names: str) -> pd.DataFrame:
    """Variables as columns, a row for each of their coordinates; margins in per cent."""
    of = dataset[[name for name in names if name in dataset]]
    of = of.assign({name: 100.0 * of[name] for name in ("margin", "speed_margin", "disk_margin") if name in of})
    table = of.to_dataframe().reset_index().rename(columns={"disk_state": "state"})
    level = f"force level {dataset.attrs.get('force_level', np.nan):g}"
    table["state"] = table["state"].map({"free": "without contacts", "stuck": "stuck contacts", "nonlinear": level})
    return table[[name for name in CAMPBELL_HEADS if name in table]]


def _crossings(dataset: xr.Dataset) -> pd.DataFrame:
    """Crossings and margins, the smallest margin first, else the slowest crossing."""
    wanted = ("excited_diameter", "crossing_speed", "crossing_frequency", "speed_margin", "operating_frequency", "margin")
    found = _frame(dataset, *wanted)
    nearness = found["margin"].abs() if "margin" in found else found["crossing_speed"]
    return found.loc[nearness.dropna().sort_values(kind="stable").index]


def campbell_tables(dataset: xr.Dataset) -> Mapping[str, pd.DataFrame]:
    """Crossings and margins, frequencies over the speed, and the interference diagram of a disk."""
    found = _crossings(dataset)
    of = dataset.assign(amplitude=dataset["amplitude"].where(dataset["state"] == "nonlinear"))
    if "excited_diameter" not in dataset:  # the curves are the same for all engine orders
        of = of.isel(engine_order=0, drop=True)
    resonances = ["amplitude"] if "force_level" in dataset.attrs else []
    curves = _frame(of, "excited_diameter", "frequency", "whirl", *resonances).dropna(subset=["frequency"])
    shown = {NEAREST: found.head(MOST)} | ({EVERY: found} if len(found) > MOST else {}) | {CURVES: curves}
    if "disk_margin" in dataset:
        names = ("excited_diameter", "wave", "excitation_frequency", "nearest_mode", "disk_margin")
        shown[DIAGRAM] = _frame(dataset, *names)
    return {caption: frame.rename(columns=CAMPBELL_HEADS) for caption, frame in shown.items()}


def campbell_figures(dataset: xr.Dataset) -> Figures:
    """The Campbell diagram, and the interference diagram of a disk."""
    found: Figures = {"campbell": resonances}
    return {**found, "interference": interference} if "disk_margin" in dataset else found


presents(
    "campbell",
    "Campbell diagram",
    campbell_sentences,
    campbell_figures,
    campbell_tables,
    failures=campbell_failures,
    answer=NEAREST,
)


LARGEST, CYCLES = "largest amplitudes", "every cycle"


def _run(dataset: xr.Dataset, case: int) -> str:
    return f"engine order {int(dataset['engine_order'].values[case])}, {level_text(dataset, case)}"


def run_up_sentences(dataset: xr.Dataset) -> list[str]:
    """The largest amplitude of the first output in each run, and what a run warns of."""
    lines, warnings = [], []
    for case in range(dataset.sizes["case"]):
        name, (first, _, more) = _run(dataset, case), dataset["message"].values[case].partition(". ")
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


def run_up_failures(dataset: xr.Dataset) -> list[str]:
    """A sentence for each run that ended early."""
    ended = np.flatnonzero(dataset["outcome"].values != "complete").tolist()
    return [f"{_run(dataset, case)}: {dataset['message'].values[case]}" for case in ended]


RUN_UP_HEADS = {"engine_order": "engine order", "force_level": "force level", "output": "output", "cycle": "cycle"}
RUN_UP_HEADS |= {"amplitude": "amplitude [m]", "speed": "speed [rev/min]", "frequency": "frequency [Hz]", "time": "time [s]"}
RUN_UP_HEADS |= {"max_abs": "largest displacement [m]", "largest": "largest displacement [m]"}
"""Columns of the run_up_tables by the names of the dataset."""


def run_up_tables(dataset: xr.Dataset) -> Mapping[str, pd.DataFrame]:
    """The largest amplitude of every output in each run."""
    names = [name for name in RUN_UP_HEADS if name not in ("cycle", "max_abs")]
    tops = [_largest(dataset, *place) for place in np.ndindex(dataset.sizes["case"], dataset.sizes["output"])]
    rows = [[top[name].item() for name in names] for top in tops]
    return {LARGEST: pd.DataFrame(rows, columns=names).rename(columns=RUN_UP_HEADS | {"force_level": level_head(dataset)})}


def run_up_histories(dataset: xr.Dataset) -> Mapping[str, pd.DataFrame]:
    """Every cycle of every run."""
    names = [name for name in RUN_UP_HEADS if name != "largest"]
    table = dataset[["time", "speed", "frequency", "amplitude", "max_abs"]].to_dataframe().reset_index()
    return {CYCLES: table.dropna(subset=["time"])[names].rename(columns=RUN_UP_HEADS | {"force_level": level_head(dataset)})}


presents(
    "run_up",
    "Run-up in time",
    run_up_sentences,
    {"run_up": run_up},
    run_up_tables,
    failures=run_up_failures,
    answer=LARGEST,
    histories=run_up_histories,
)
