"""Presentation of speed sweeps."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from stickslip.results.view import length_text, level_head, level_text, linear_peak
from stickslip.show.plots.speed_sweep import over_speed
from stickslip.show.report.answer import error_words, errors_of
from stickslip.show.report.markup import Presentation, always, hertz, percent, presents
from stickslip.support.checks import counted
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


PRESENTATION = presents(
    "speed_sweep", Presentation("Speed sweep", sentences, failures, always({"speed_sweep": over_speed}), tables)
)
