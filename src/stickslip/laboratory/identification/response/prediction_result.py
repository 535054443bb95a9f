"""What a prediction of responses is given as: the result, measured tests beside it, and the answer in sentences."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from stickslip.analyses.truncation import ALLOWED
from stickslip.laboratory.identification.least_squares import CERTAINTY
from stickslip.laboratory.identification.response.draws import interval
from stickslip.laboratory.identification.response.mistakes import POOR, named_gain
from stickslip.laboratory.measurement.measured_response import THOUSAND, MeasuredResponse, assumed_units, joined, measured_peak
from stickslip.results.files import SavedResult
from stickslip.results.schema import Row, named
from stickslip.results.view import size_text
from stickslip.support.checks import Array, Index, InputError, counted, digits_between, fault, of_kind, rounded, several
from stickslip.support.late import pd, xr

SAME_LEVEL = 0.05
"""Relative distance of a test's level from a predicted one up to which they are compared."""

ALLOWED_SHIFT = 1e-3
"""Relative error of a peak's frequency up to which nothing is said of it."""

NOISE = 1000
"""Noisy curves, over all draws, of which the median is compared: of one a draw it would change from seed to seed."""

FINER = 3
"""Times the harmonics of the identification, of the curve that shows their error."""

FAR = 2.0
"""Ratio of a predicted and a measured value from which on it is shown in place of an error in percent."""

WHOLE = 39
"""Draws from which percentiles 2.5 and 97.5 lie inside the draws."""

COMPARED = (("frequency", "Hz", "peak_frequency"), ("amplitude", "", "peak_amplitude"), ("damping ratio", "1", "damping_ratio"))
"""What a comparison lists: words, unit, and variable."""

Compared = tuple[str, str, str, float]
"""The same, with the unit as a number."""

PREDICTED = ("predicted", "predicted_low", "predicted_high")
"""How the variables of a predicted value and of the ends of its interval begin."""


@dataclass(frozen=True, eq=False, repr=False)
class ResponsePrediction(SavedResult):
    """`dataset`: along `level`, the forces or held amplitudes: peak_frequency, peak_amplitude and damping_ratio, the medians of
    the draws, each with `_low` and `_high` of the 95 % interval and `_drawn` (level, draw); amplitude with `_low` and `_high`
    over frequency (level, point), the largest where a curve is folded; drawn parameters (level, draw, parameter). Where tests are
    compared, along `measured` what they measured and the share of their points inside the band.
    """

    dataset: xr.Dataset

    def compare(self, tests: MeasuredResponse | Sequence[MeasuredResponse]) -> ResponsePrediction:
        """A copy that holds measured tests too, each beside the level that was predicted for it."""
        found = [tests] if isinstance(tests, MeasuredResponse) else list(several("tests", tests))
        return replace(self, dataset=compared(self.dataset, found))

    def comparison(self) -> pd.DataFrame:
        """Measured against predicted peak of each compared test: frequency, amplitude, damping ratio, errors in percent, share of
        points inside the band."""
        if "measured" not in self.dataset.sizes:
            raise InputError("A comparison needs measured tests: prediction.compare(tests).comparison().")
        return comparison_table(self.dataset)


def level_of(test: MeasuredResponse, held: bool) -> float:
    """The level of a test where its response per force, or its response, is largest: the force, or the held amplitude."""
    top = int(np.argmax(np.abs(test.per_force) if held else np.asarray(test.amplitude)))
    return float(np.asarray(test.amplitude if held else test.force)[top])


def compared(dataset: xr.Dataset, tests: Sequence[MeasuredResponse]) -> xr.Dataset:
    """The dataset with measured tests: what each measured and what is predicted for it at its frequencies; both peaks found in
    the same way from points at these frequencies, the drawn ones with the error of a point; and the share of points inside the
    band, which is widened by that error.
    """
    dataset = dataset.drop_dims(["measured", "measured_point"], errors="ignore")
    held, levels = dataset.attrs["held"] == "response", dataset["level"].values
    if not tests:
        raise fault("tests", "must hold at least one measured response", [])
    longest, error = max(np.size(test.frequency) for test in tests), float(dataset.attrs["point_error"])
    points, peaks = np.full((5, len(tests), longest), np.nan), np.full((len(tests), 4, 3), np.nan)
    digits, gains = np.full((len(tests), 3), np.nan), np.full(len(tests), np.nan)
    at = np.array([level_for(test, levels.tolist(), held, dataset.attrs["quantity"]) for test in tests])
    for t, (test, k) in enumerate(zip(tests, at, strict=True)):
        grid, curves = dataset["frequency"].values[k], dataset["amplitude_drawn"].values[k]
        known = np.isfinite(grid)
        which = points_in_band(test, grid[known].min(), grid[known].max())
        f, size = np.asarray(test.frequency)[which], np.abs(test.per_force)[which]
        size = size if held else size * levels[k]
        rows = np.array([np.interp(f, grid[known], row[known]) for row in curves])
        low, middle, high = interval(rows, axis=0)
        low, high = (
            middle * np.exp(sign * np.hypot(np.log(end / middle), CERTAINTY * error)) for sign, end in ((-1.0, low), (1.0, high))
        )
        points[:, t, : f.size] = f, size, low, middle, high
        peaks[t, 0] = measured_peak(f, size)
        noisy = with_noise(rows, float(dataset.attrs.get("point_noise", error)))  # earlier versions kept the error alone
        drawn = np.array([[measured_peak(f, row) for row in each] for each in noisy])
        peaks[t, 1:] = interval(drawn[0], axis=0)
        peaks[t, 2], digits[t] = np.transpose([steady_median(drawn[:, :, j]) for j in range(3)])
        gains[t] = np.exp(interval(np.log(size / middle))[1])
    inside = (points[1] >= points[2]) & (points[1] <= points[4])
    unit = dataset["peak_amplitude"].attrs["units"]

    along = zip(("frequency", "amplitude", "low", "middle", "high"), points, strict=True)
    found = {
        f"measured_{key}": named(("measured", "measured_point"), values, f"at the measured points: {key}", unit if k else "Hz")
        for k, (key, values) in enumerate(along)
    }
    for j, (words, units, key) in enumerate(COMPARED):
        for k, end in enumerate(("measured", "predicted_low", "predicted", "predicted_high")):
            what = f"{words} of the peak at the measured points, {end.replace('_', ' ')}"
            found[f"{end}_{key}"] = named("measured", peaks[:, k, j], what, units or unit)
        what = f"standard error of the predicted {words} that is due to the number of draws"
        found[f"predicted_{key}_deviation"] = named("measured", digits[:, j], what, units or unit)
    found["gain"] = named("measured", gains, "measured over predicted response per force, median of the points")
    share = inside.sum(axis=1) / np.maximum(np.isfinite(points[2]).sum(axis=1), 1)
    found["inside"] = named("measured", share, "share of measured points inside the band")
    found["predicted_level"] = named("measured", at.astype(float), "number of the level that was predicted for the test")
    names = [test.name or f"test {k}" for k, test in enumerate(tests, start=1)]
    notes = joined([(test.name, note) for test in tests for note in test.notes])
    said = {"notes_on_tests": "\n".join([*assumed_units(tests), *notes])}
    return dataset.assign(found).assign_coords(measured=named("measured", names, "measured test")).assign_attrs(said)


def with_noise(rows: Array, error: float) -> Array:
    """Curves of draws (draws, points) with the noise of points, several times (times, draws, points). The noise is the same for
    each test and each seed of the draws: the same files then have the same errors."""
    times = -(-NOISE // len(rows))
    return np.asarray(rows * np.exp(error * np.random.default_rng(0).normal(size=(times, *rows.shape))))


def steady_median(drawn: Array) -> tuple[float, float]:
    """Median over noise and draws (times, draws), and its standard error √(π/2) s/√draws, from the means of each draw; NaN of no
    numbers."""
    means = np.array([row[np.isfinite(row)].mean() for row in drawn.T if np.isfinite(row).any()])
    if not means.size:
        return float("nan"), float("nan")
    return float(np.nanmedian(drawn)), float(np.sqrt(0.5 * np.pi / means.size) * means.std())


def level_for(test: MeasuredResponse, levels: Sequence[float], held: bool, quantity: str) -> int:
    """The number of the predicted level of a test, a force or a held amplitude; refused where none is near."""
    of_kind("A test", test, MeasuredResponse)
    if test.quantity != quantity:
        rule = f"must be {quantity}, as in the identification"
        raise fault(f"The quantity of {test.name}", rule, test.quantity, f"Compare with a measured {quantity}.")
    level = level_of(test, held)
    k = int(np.argmin(np.abs(np.log(np.asarray(levels) / level))))
    if abs(levels[k] / level - 1.0) > SAME_LEVEL:
        option = "amplitude" if held else "force"
        rule = f"must be one that is predicted, {', '.join(f'{each:g}' for each in levels)}"
        remedy = f"Add {level:.6g} to these (--{option} {level:.6g})."
        low, high = THOUSAND
        if low <= max(level / levels[k], levels[k] / level) <= high:
            remedy = f"Is the unit of its {quantity if held else 'force'} right? If so, add {level:.6g} (--{option} {level:.6g})."
        raise fault(f"The {option} of {test.name}", rule, level, remedy)
    return k


def points_in_band(test: MeasuredResponse, low: float, high: float) -> Index:
    """The numbers of the points of a test in a band in Hz, at ascending frequencies; fewer than three are refused."""
    frequency = np.asarray(test.frequency)
    order = np.argsort(frequency, kind="stable")
    inside = order[(frequency[order] >= low * (1.0 - 1e-12)) & (frequency[order] <= high * (1.0 + 1e-12))]
    if inside.size < 3:
        ends = f"{frequency.min():.6g} to {frequency.max():.6g} Hz"
        remedy = f"Measured are {ends}. Is the unit of the frequency right (--unit frequency=kHz), and the band wide enough?"
        raise fault(
            f"The points of {test.name} in the band, {low:.6g} to {high:.6g} Hz,", "must be at least three", inside.size, remedy
        )
    return inside


def comparison_table(dataset: xr.Dataset) -> pd.DataFrame:
    """Of each compared test measured, predicted and interval of peak frequency, amplitude and damping ratio, error in percent
    of the measured one; share of points inside."""
    at = dataset["predicted_level"].values.astype(int)
    columns = {"test": dataset["measured"].values, level_head(dataset): dataset["level"].values[at]}
    columns |= against_measured(dataset, compared_in(dataset))
    return pd.DataFrame(columns | {"points inside in %": 100.0 * dataset["inside"].values})


def compared_in(dataset: xr.Dataset) -> list[Compared]:
    """What is compared, responses in their unit."""
    return [(words, unit or dataset["peak_amplitude"].attrs["units"], key, 1.0) for words, unit, key in COMPARED]


def against_measured(dataset: xr.Dataset, compared: Sequence[Compared]) -> dict[str, Any]:
    """Columns of what was measured, what is predicted with its interval, and the error in percent."""
    columns: dict[str, Any] = {}
    for words, unit, key, factor in compared:
        for end, name in (("measured", "measured"), *zip(PREDICTED, ("predicted", "from", "to"), strict=True)):
            columns[f"{name} {words} [{unit}]"] = factor * dataset[f"{end}_{key}"].values
        ratio = dataset[f"predicted_{key}"].values / dataset[f"measured_{key}"].values
        columns[f"error of {words} in %"] = 100.0 * (ratio - 1.0)
    return columns


def with_intervals(dataset: xr.Dataset, compared: Sequence[Compared], place: str) -> dict[str, Any]:
    """Columns of what is predicted with its interval, and whether it lies among the measured ones of a place."""
    columns = {
        f"{name}{words} [{unit}]": factor * dataset[f"{key}{end}"].values
        for words, unit, key, factor in compared
        for end, name in (("", ""), ("_low", "from "), ("_high", "to "))
    }
    return columns | {f"measured {place}": np.where(dataset["interpolated"].values > 0.0, "interpolated", "extrapolated")}


def peak_table(dataset: xr.Dataset) -> pd.DataFrame:
    """Of each level the predicted peak with its 95 % interval."""
    levels = {level_head(dataset): dataset["level"].values}
    return pd.DataFrame(levels | with_intervals(dataset, compared_in(dataset), "levels"))


def curve_table(dataset: xr.Dataset) -> pd.DataFrame:
    """The predicted curves with their bands."""
    unit, known = dataset["amplitude"].attrs["units"], np.isfinite(dataset["frequency"].values)
    columns: dict[str, Any] = {level_head(dataset): np.repeat(dataset["level"].values, known.sum(axis=1))}
    columns["frequency [Hz]"] = dataset["frequency"].values[known]
    for end, name in (("", "amplitude"), ("_low", "from amplitude"), ("_high", "to amplitude")):
        columns[f"{name} [{unit}]"] = dataset[f"amplitude{end}"].values[known]
    return pd.DataFrame(columns)


def level_head(dataset: xr.Dataset) -> str:
    """The head of a column of levels: "force level [N]"."""
    return f"{dataset['level'].attrs['long_name']} [{dataset['level'].attrs['units']}]"


def summary(dataset: xr.Dataset) -> list[str]:
    """What was free and what is interpolated; peaks with intervals; tests against them; what the intervals do not include."""
    return [*unexplained(dataset.attrs), _first_line(dataset), *_peaks(dataset), *_compared_lines(dataset), *_remarks(dataset)]


def unexplained(attrs: Mapping[str, Any]) -> list[str]:
    """A sentence where the identification has not explained its tests."""
    worst = float(attrs.get("worst_misfit", 0.0))  # earlier versions did not keep it
    if worst < POOR:
        return []
    return [
        f"The identification did not explain its tests: the misfit is {rounded(100.0 * worst, 2)} % of the largest response. The "
        "prediction is no better than that. Find the cause first."
    ]


def what_was_free(attrs: Mapping[str, Any]) -> str:
    """The parameters that the identification found, as a sentence."""
    line = str(attrs.get("free_over_level", "")).split(", ")  # earlier versions knew none
    each = [f"{name} (along a line over the levels)" if name in line else name for name in attrs["free_of_each_test"].split(", ")]
    own = f"; separately for each test: {', '.join(each)}" if attrs["free_of_each_test"] else ""
    return f"Free: {attrs['free'] or 'nothing'}{own}."


def _first_line(dataset: xr.Dataset) -> str:
    attrs, unit = dataset.attrs, dataset["level"].attrs["units"]
    what = "held amplitudes" if attrs["held"] == "response" else "forces"
    measured = f"Measured {what} from {attrs['measured_from']:.4g} to {attrs['measured_to']:.4g} {unit}"
    inside = dataset["interpolated"].values > 0.0
    parts = [
        f"{', '.join(f'{level:.4g}' for level in dataset['level'].values[which])} {unit} {words}"
        for which, words in ((inside, "interpolated"), (~inside, "extrapolated"))
        if which.any()
    ]
    return f"{what_was_free(attrs)} {measured}: {', '.join(parts)}."


def _peaks(dataset: xr.Dataset) -> list[str]:
    found: list[str] = []
    unit, share = dataset["peak_amplitude"].attrs["units"], held_share(dataset)
    for k, level in enumerate(dataset["level"].values):
        one = {key: [float(dataset[f"{key}{end}"].values[k]) for end in ("", "_low", "_high")] for _, _, key in COMPARED}
        if not np.isfinite(one["peak_frequency"][0]):
            where = "the part of the band that the curves reach" if dataset["unsolved"].values[k] else "the band"
            why = "" if dataset.attrs["held"] == "force" else ", because force and displacement are not at 90° anywhere"
            remedy = "" if dataset["unsolved"].values[k] else " Give another or a wider band."
            found.append(f"{level:.4g} {dataset['level'].attrs['units']}: no peak in {where}{why}.{remedy}")
            continue
        f, a, z = one.values()
        level_name = f"{level:.4g} {dataset['level'].attrs['units']}"
        size, low, high = (size_text(each, unit, dataset, digits=digits_between(a[1], a[2], 4)) for each in a)
        found.append(Row(f"{level_name}: peak at {frequency_text(f, share)}, {size} ({low} to {high}){damping_text(z)}"))
    return found


def frequency_text(values: Sequence[float], share: float) -> str:
    """A frequency with its interval, from value and ends."""
    f, low, high = (f"{each:.{digits_between(values[1], values[2], 6)}g}" for each in values)
    return f"{f} Hz ({share:.0f} % interval {low} to {high} Hz)"


def damping_text(values: Sequence[float]) -> str:
    """A damping ratio with its interval in percent, from value and ends; empty where there is none."""
    if not np.isfinite(values[0]):
        return ""
    z, low, high = (f"{100.0 * each:.{digits_between(values[1], values[2], 3)}g}" for each in values)
    return f", damping ratio {z} % ({low} to {high} %)"


def held_share(dataset: xr.Dataset) -> float:
    """Percentage that the intervals hold: 95, or less where few draws make them go from the lowest to the highest draw."""
    draws = int(dataset.attrs["draws"])
    return 95.0 if draws >= WHOLE else 100.0 * (draws - 1.0) / (draws + 1.0)


def _compared_lines(dataset: xr.Dataset) -> list[str]:
    if "measured" not in dataset.sizes:
        return []
    found = []
    for t, name in enumerate(dataset["measured"].values):
        words = []
        for what, _, key in COMPARED:
            measured, predicted, low, high = (float(dataset[f"{end}_{key}"].values[t]) for end in ("measured", *PREDICTED))
            if np.isfinite(measured) and np.isfinite(predicted):
                where = "inside" if low <= measured <= high else "outside"
                known = dataset.get(f"predicted_{key}_deviation")  # earlier versions did not keep it, nor the gain
                deviation = 0.0 if known is None else float(known.values[t])
                words.append(f"{what} {_error_text(predicted, measured, deviation)} ({where})")
        share = 100.0 * float(dataset["inside"].values[t])
        said = f"predicted against measured {', '.join(words)}" if words else "its points in the band show no peak"
        found.append(f"{name}: {said}; {share:.0f} % of its points lie inside the band")
        if mistake := _mistake(dataset, t):
            found.append(mistake)
    return found + [note for note in str(dataset.attrs.get("notes_on_tests", "")).split("\n") if note]


def _error_text(predicted: float, measured: float, deviation: float) -> str:
    """The error of a prediction in percent of the measured value, to the digits that another seed leaves; far from it their
    ratio."""
    ratio = predicted / measured
    if max(ratio, 1.0 / ratio) >= FAR:
        return f"{rounded(ratio, 3)} times as large"
    step = max(2.0 * 100.0 * deviation / measured, 0.01 * abs(100.0 * (ratio - 1.0)), 1e-3)
    decimals = max(0, -math.ceil(math.log10(step)))
    return f"{round(100.0 * (ratio - 1.0), decimals) + 0.0:+.{decimals}f} %"


def _mistake(dataset: xr.Dataset, t: int) -> str:
    """A sentence where the gain of a test is that of a known mistake and explains its points; empty where none is seen."""
    gain = float(dataset["gain"].values[t]) if "gain" in dataset else np.nan
    if not np.isfinite(gain) or float(dataset["inside"].values[t]) > 0.5:
        return ""
    words, sure = named_gain(gain)
    ratio = dataset["measured_amplitude"].values[t] / dataset["measured_middle"].values[t]
    left = float(interval(np.abs(np.log(ratio / gain)))[1])
    if not words or not (sure or left < POOR):
        return ""
    return f"{dataset['measured'].values[t]}: its responses per force are {gain:.3g} times the predicted ones, {words}."


def remarks_on_draws(attrs: Mapping[str, Any]) -> list[str]:
    """What the tests leave open, and how far they scatter."""
    found = []
    if attrs["unknown"]:
        found.append(f"Not determined by the tests, so drawn between their bounds: {attrs['unknown']}.")
    if not attrs["scatter_known"]:
        found.append("With only one test, the scatter from mounting to mounting is unknown and not in the intervals.")
    elif attrs["gain_scatter"] or attrs["frequency_scatter"]:
        found.append(
            f"The tests scatter more than parameters and noise explain, by {100.0 * attrs['gain_scatter']:.2g} % in response and "
            f"{100.0 * attrs['frequency_scatter']:.2g} % in frequency (standard deviations), which the intervals include."
        )
    return found


def remark_on_few_draws(dataset: xr.Dataset) -> list[str]:
    """What intervals of few draws hold."""
    if int(dataset.attrs["draws"]) >= WHOLE:
        return []
    share = held_share(dataset)
    return [
        f"{dataset.attrs['draws']} draws are too few: the intervals cover {share:.0f} %, not 95 %. Use {WHOLE} draws or more."
    ]


def remark_on_harmonics(off: float, size: float, what: str) -> list[str]:
    """Relative errors of the frequency and of something else by the harmonics of the identification, where they matter."""
    if not (size > ALLOWED or off > ALLOWED_SHIFT):
        return []
    return [
        f"The number of harmonics of the identification causes errors of up to {100.0 * off:.2g} % in the frequency and "
        f"{100.0 * size:.2g} % in the {what}, which the intervals include. It also shifts the identified parameters, which they "
        "do not include: identify again with more harmonics."
    ]


def _remarks(dataset: xr.Dataset) -> list[str]:
    found = remarks_on_draws(dataset.attrs)
    if not dataset["interpolated"].values.all():
        found.append("Beyond the measured levels the prediction relies on the contact law, whose error is not in the intervals.")
    off, size = (dataset[f"peak_{key}_error"].values for key in ("frequency", "amplitude"))
    peaks = np.isfinite(dataset["peak_frequency"].values)
    known = peaks & np.isfinite(size)
    if (peaks & ~known).any():
        at = ", ".join(f"{level:.4g}" for level in dataset["level"].values[peaks & ~known])
        found.append(
            f"{at} {dataset['level'].attrs['units']}: the intervals do not include the error due to harmonics, since the curve "
            f"of the identified parameters has no peak in the band, with these harmonics or with {FINER} times as many. Give a "
            "wider band, or identify again with more harmonics."
        )
    off, size = off[known], size[known]
    if known.any():
        found += remark_on_harmonics(float(off.max()), float(size.max()), "response of a peak")
    return found + remark_on_few_draws(dataset)


def failures(dataset: xr.Dataset) -> list[str]:
    """A sentence for each level with draws whose curve does not reach the end of the band."""
    levels, lost = dataset["level"], dataset["unsolved"].values.astype(int)
    words = "do not reach the end of the band"
    return [
        f"{levels.values[k]:.4g} {levels.attrs['units']}: the curves of {counted(int(lost[k]), 'draw')} {words}"
        for k in np.flatnonzero(lost)
    ]
