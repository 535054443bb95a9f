"""Free decays that were not measured, from an identification: frequency and damping over the amplitude, with 95 % intervals.

Each case is the nonlinear mode of one draw (`prediction.py`): a motion that decays slowly is, at every instant, that of the
mode at its amplitude.

What a predicted decay is given as: the result, measured decays beside it, and the answer in sentences.
"""

from __future__ import annotations

import time
from collections.abc import Sequence
from dataclasses import KW_ONLY, dataclass, replace
from functools import cached_property
from typing import Annotated, Any

import numpy as np

from stickslip.analyses.modes.slow_decay import SHARED, slow_decay
from stickslip.analyses.modes.work import Modes
from stickslip.analyses.settings import Setting, Whole, takes
from stickslip.laboratory.identification.least_squares import CERTAINTY
from stickslip.laboratory.identification.response.draws import Draw, of_draws
from stickslip.laboratory.identification.response.prediction import DrawnProblems, within
from stickslip.laboratory.identification.response.prediction_result import (
    FINER,
    against_measured,
    damping_text,
    frequency_text,
    held_share,
    remark_on_few_draws,
    remark_on_harmonics,
    remarks_on_draws,
    unexplained,
    what_was_free,
    with_intervals,
)
from stickslip.laboratory.measurement.decay import MeasuredDecay
from stickslip.results.files import SavedResult
from stickslip.results.schema import Row, named, stacked, tabulated
from stickslip.results.view import length_text
from stickslip.runs.cases import Arrays, Report, all_cases
from stickslip.solve.balance.balance import HarmonicBalance
from stickslip.solve.balance.fourier import highest, of_attribute
from stickslip.solve.curves.mode_curve import solve_mode
from stickslip.support.checks import Array, Index, InputError, fault, of_kind, positive, several, vector
from stickslip.support.late import pd, xr
from stickslip.support.machine import one_blas_thread

COMPARED = (("frequency", "Hz", "frequency", 1.0), ("damping ratio", "%", "damping_ratio", 100.0))
"""What a comparison lists: words, unit, variable, and the unit as a number."""

OTHER_MODE = 1.2
"""Ratio of the frequencies of a measured and the predicted decay from which another mode is suspected."""

QUICK = 0.03
"""Damping ratio from which on a decay is too quick: within two cycles its amplitude falls by a third."""

ROWS, LINES = 9, 4
"""Amplitudes of a table, and of the answer in sentences."""


@dataclass(frozen=True, eq=False, repr=False)
class DecayPrediction(SavedResult):
    """`dataset`: along `amplitude`, that of the displacement in m: frequency [Hz] and damping_ratio, the medians of the draws,
    each with `_low` and `_high` of the 95 % interval and `_drawn` (draw, amplitude); drawn parameters (draw, parameter). Where
    decays are compared, along `decay` and `window` what they measured and what is predicted at their amplitudes.
    """

    dataset: xr.Dataset

    def compare(self, decays: MeasuredDecay | Sequence[MeasuredDecay]) -> DecayPrediction:
        """A copy that holds measured decays too, each beside what is predicted at its amplitudes."""
        found = [decays] if isinstance(decays, MeasuredDecay) else list(several("decays", decays))
        measured = [of_kind("A decay", one, MeasuredDecay).dataset for one in found]
        return replace(self, dataset=compared_decays(self.dataset, measured))

    def comparison(self) -> pd.DataFrame:
        """Measured against predicted frequency and damping ratio at the amplitudes of each compared decay, errors in percent."""
        if "decay" not in self.dataset.sizes:
            raise InputError("A comparison needs measured decays: prediction.compare(decays).comparison().")
        return comparison_table(self.dataset)


def compared_decays(dataset: xr.Dataset, decays: Sequence[xr.Dataset]) -> xr.Dataset:
    """The dataset with measured decays: the windows of each at the predicted amplitudes, and the share of them inside the
    interval, which is widened by their own errors."""
    if not decays:
        raise fault("decays", "must hold at least one measured decay", [])
    dataset, size = dataset.drop_dims(["decay", "window"], errors="ignore"), dataset["amplitude"].values
    names, which = _names(decays), [windows_between(one, size[0], size[-1]) for one in decays]

    def along(values: Sequence[Array], words: str, unit: str) -> tuple[Any, ...]:
        return named(("decay", "window"), stacked(values), words, unit)

    pairs = list(zip(decays, which, strict=True))
    sizes, at = [one["amplitude"].values[windows] for one, windows in pairs], np.log(size)
    found: dict[str, Any] = {"measured_amplitude": along(sizes, "measured amplitude of the displacement", "m")}
    for words, _, key, _ in COMPARED:
        measured, errors = ([one[f"{key}{end}"].values[windows] for one, windows in pairs] for end in ("", "_error"))
        lows, middles, highs = (
            [np.interp(np.log(own), at, dataset[f"{key}{end}"].values) for own in sizes] for end in ("_low", "", "_high")
        )
        for name, rows, what in (
            ("measured", measured, "measured"),
            ("predicted", middles, "predicted"),
            ("predicted_low", lows, "low end of the predicted"),
            ("predicted_high", highs, "high end of the predicted"),
        ):
            found[f"{name}_{key}"] = along(rows, f"{what} {words} at the measured amplitudes", dataset[key].attrs["units"])
        found[f"measured_{key}_error"] = along(errors, f"standard error of the measured {words}", dataset[key].attrs["units"])
        shares = [_share_inside(*one) for one in zip(measured, errors, lows, middles, highs, strict=True)]
        what = f"share of windows whose {words} lies inside the interval"
        found[f"inside_{key}"] = named("decay", np.array(shares), what)
    return dataset.assign(found).assign_coords(decay=named("decay", names, "measured decay"))


def windows_between(decay: xr.Dataset, low: float, high: float) -> Index:
    """The numbers of the windows of a measured decay at amplitudes between two, m; none are refused."""
    size = decay["amplitude"].values
    found = np.flatnonzero((size >= low * (1.0 - 1e-9)) & (size <= high * (1.0 + 1e-9)))
    if not found.size:
        raise fault(
            f"The amplitudes of {decay.attrs.get('title') or 'a decay'}",
            f"must reach into those that are predicted, {low:.4g} to {high:.4g} m",
            f"{size.min():.4g} to {size.max():.4g} m",
            "Predict its amplitudes, or check the unit of its signal.",
        )
    return found


def _share_inside(value: Array, error: Array, low: Array, middle: Array, high: Array) -> float:
    """The share of values inside an interval that is widened by their standard errors; NaN where there is no interval."""
    lower, upper = middle - np.hypot(low - middle, CERTAINTY * error), middle + np.hypot(high - middle, CERTAINTY * error)
    known = np.isfinite(lower) & np.isfinite(upper)
    return float(np.mean((value >= lower)[known] & (value <= upper)[known])) if known.any() else float("nan")


def _names(decays: Sequence[xr.Dataset]) -> list[str]:
    """The titles of decays, numbered where they are alike."""
    titles = [str(one.attrs.get("title", "")) or "decay" for one in decays]
    return [title if titles.count(title) == 1 else f"{title} ({titles[: k + 1].count(title)})" for k, title in enumerate(titles)]


def decay_table(dataset: xr.Dataset, most: int | None = ROWS) -> pd.DataFrame:
    """Frequency and damping ratio with their 95 % intervals at so many amplitudes in equal ratios, or at all."""
    shown = dataset.isel(amplitude=_shown(dataset["amplitude"].values, most))
    return pd.DataFrame({"amplitude [m]": shown["amplitude"].values} | with_intervals(shown, COMPARED, "amplitudes"))


def comparison_table(dataset: xr.Dataset, most: int | None = ROWS) -> pd.DataFrame:
    """Of each compared decay at so many amplitudes in equal ratios, or at all, measured, predicted and interval of frequency and
    damping ratio, and the error in percent of the measured one."""
    tables = []
    for t, name in enumerate(dataset["decay"].values):
        one = dataset.isel(decay=t).dropna("window", subset=["measured_amplitude"])
        one = one.isel(window=_shown(one["measured_amplitude"].values, most))
        place = {"decay": name, "amplitude [m]": one["measured_amplitude"].values}
        tables.append(pd.DataFrame(place | against_measured(one, COMPARED)))
    return pd.concat(tables, ignore_index=True)


def whole_tables(dataset: xr.Dataset) -> dict[str, pd.DataFrame]:
    """All amplitudes of the prediction, and all windows of the compared decays."""
    windows = {"windows": comparison_table(dataset, None)} if "decay" in dataset.sizes else {}
    return {"decay": decay_table(dataset, None), **windows}


def _shown(size: Array, most: int | None) -> np.ndarray:
    """The numbers of values nearest to so many in equal ratios, from the largest to the smallest; of all for None."""
    if most is None:
        return np.arange(size.size)
    wanted = np.geomspace(size.max(), size.min(), most)
    return np.array(list(dict.fromkeys(int(np.argmin(np.abs(np.log(size / one)))) for one in wanted)))


def summary(dataset: xr.Dataset) -> list[str]:
    """What was free and what is interpolated; frequency and damping; decays against them; what the intervals do not include."""
    return [*unexplained(dataset.attrs), _first_line(dataset), *_values(dataset), *_compared_lines(dataset), *_remarks(dataset)]


def _first_line(dataset: xr.Dataset) -> str:
    attrs, size = dataset.attrs, dataset["amplitude"].values
    low, high = (length_text(attrs[f"measured_{end}"], dataset) for end in ("from", "to"))
    inside = dataset["interpolated"].values > 0.0
    ends = f"{length_text(size[0], dataset)} to {length_text(size[-1], dataset)}"
    how = "interpolated" if inside.all() else f"extrapolated {'in part' if inside.any() else 'as a whole'}"
    measured = f"Measured amplitudes from {low} to {high}"
    return f"{what_was_free(attrs)} {measured}: decay of mode {attrs['mode']} of the stuck structure from {ends}, {how}."


def _values(dataset: xr.Dataset) -> list[str]:
    found: list[str] = []
    share = held_share(dataset)
    for k in _shown(dataset["amplitude"].values, LINES):
        f, z = (
            [float(dataset[f"{key}{end}"].values[k]) for end in ("", "_low", "_high")] for key in ("frequency", "damping_ratio")
        )
        where = length_text(float(dataset["amplitude"].values[k]), dataset)
        if not np.isfinite(f[0]):
            found.append(f"{where}: no nonlinear mode was found at this amplitude.")
            continue
        found.append(Row(f"{where}: {frequency_text(f, share)}{damping_text(z)}"))
    return found


def _compared_lines(dataset: xr.Dataset) -> list[str]:
    found = []
    for t, name in enumerate(dataset["decay"].values if "decay" in dataset.sizes else ()):
        words = []
        for what, _, key, _ in COMPARED:
            error = 100.0 * (dataset[f"predicted_{key}"].values[t] / dataset[f"measured_{key}"].values[t] - 1.0)
            if np.any(np.isfinite(error)):
                share = 100.0 * float(dataset[f"inside_{key}"].values[t])
                words.append(f"{what} {np.nanmedian(error):+.2g} % in the median ({share:.0f} % of the windows inside)")
        found.append(f"{name}: predicted against measured {', '.join(words)}" if words else f"{name}: no prediction there")
        apart = np.nanmedian(dataset["predicted_frequency"].values[t] / dataset["measured_frequency"].values[t])
        if words and abs(np.log(apart)) > np.log(OTHER_MODE):
            found.append(f"{name}: its frequency differs from mode {dataset.attrs['mode']}. Is it the decay of another mode?")
    return found


def _remarks(dataset: xr.Dataset) -> list[str]:
    found = remarks_on_draws(dataset.attrs)
    if not dataset["interpolated"].values.all():
        found.append(
            "Beyond the measured amplitudes the prediction relies on the contact law, whose error is not in the intervals."
        )
    off, size = (dataset[f"{key}_error"].values for key in ("frequency", "damping_ratio"))
    if not np.any(np.isfinite(off)):
        found.append("The intervals do not include the error due to harmonics, which could not be estimated.")
    else:
        found += remark_on_harmonics(float(np.nanmax(off)), float(np.nanmax(size)), "damping ratio")
    if "decay" in dataset.sizes and np.nanmax(dataset["damping_ratio"].values) > QUICK:
        found.append(
            f"At damping ratios above {100.0 * QUICK:.0f} % a decay is too quick to follow the nonlinear mode, and its windows "
            "average over amplitudes that differ by a third: the intervals do not include this. Compare with `free_decay` there."
        )
    apart = dataset["amplitude"].values[dataset["uncertain"].values > 0.5]
    if apart.size:
        ends = " and ".join(length_text(each, dataset) for each in (apart.min(), apart.max()))
        found.append(
            f"Between {ends} another mode takes part in a decay, or the static forces of the contacts change faster than it "
            "follows: its damping is uncertain there, and what another mode has taken stays below. The intervals do not "
            "include this."
        )
    return found + remark_on_few_draws(dataset)


def failures(dataset: xr.Dataset) -> list[str]:
    """A sentence where modes of draws do not reach all amplitudes."""
    lost = dataset["unsolved"].values
    if not lost.any():
        return []
    size = dataset["amplitude"].values[lost > 0.0]
    ends = f"{length_text(size.min(), dataset)} and {length_text(size.max(), dataset)}"
    return [f"Up to {int(lost.max())} of {dataset.attrs['draws']} draws have no nonlinear mode at amplitudes between {ends}."]


PER_DECADE = 100
"""Amplitudes in a decade at which a decay is predicted: damping rises within a few per cent where slip begins."""

BEYOND = 1.2
"""Ratio by which a mode goes beyond these amplitudes on either side: they count in the shape of the stuck mode, which changes as
contacts slip."""


def decay_ends(name: str, amplitude: Any) -> tuple[float, float]:
    """The smallest and the largest amplitude."""
    low, high = (positive(name, end) for end in vector(name, amplitude, 2).tolist())
    if not low < high:
        raise fault(name, "must be (low, high) with low below high", amplitude)
    return low, high


@dataclass(frozen=True, eq=False)
class DecayPredictionWork(DrawnProblems):
    """A prediction of a decay as independent cases: the nonlinear mode of the identified parameters and of each draw."""

    amplitude: Annotated[tuple[float, float], Setting(decay_ends)]
    _: KW_ONLY
    mode: Annotated[int | None, Setting(Whole(1))] = None
    frequency: Annotated[float | None, Setting(positive)] = None

    def __post_init__(self) -> None:
        super().__post_init__()
        if self.mode is not None and self.frequency is not None:
            raise InputError("mode and frequency must not be given together, but are: both say which mode decays.")

    @cached_property
    def drawn(self) -> list[Draw]:
        """The identified parameters, and the draws: a decay passes many levels, so that no line over them is followed."""
        return self.drawn_at(np.nan)

    @cached_property
    def names(self) -> tuple[str, ...]:
        """Everything that a mode depends on."""
        about, drawn = f"{self.amplitude}, mode {self.followed}, {self.about_all}", enumerate(self.drawn)
        return tuple(f"predicted decay, {n}, {dict(draw.values)!r}, {draw.gain!r}, {about}" for n, draw in drawn)

    @property
    def words(self) -> tuple[str, ...]:
        return tuple(f"draw {n}" for n in range(len(self.drawn)))

    @cached_property
    def grid(self) -> Array:
        """The amplitudes of the displacement, m."""
        low, high = self.amplitude
        return np.geomspace(low, high, 2 + int(np.ceil(PER_DECADE * np.log10(high / low))))

    @cached_property
    def followed(self) -> int:
        """The number of the stuck mode: the given one, or that nearest to the given frequency, or to the largest measured
        response inside the band of the test with the smallest motion."""
        if self.mode is not None:
            return self.mode
        if self.frequency is not None:
            return self._nearest(self.frequency)
        low, high = self.ends
        test = self.data.isel(test=int(np.argmin(self.tops("response"))))
        size = np.where((test["frequency"] >= low) & (test["frequency"] <= high), test["measured"], np.nan)
        if not np.any(np.isfinite(size)):
            raise fault("band", "must hold measured points, or mode or frequency be given", [low, high])
        at = float(test["frequency"].values[int(np.nanargmax(size))])
        return self._nearest(at)

    def _nearest(self, frequency: float) -> int:
        return Modes(self.problem(self.drawn[0]), frequency=frequency, output=self.output).modes[0]

    @property
    def measured(self) -> tuple[float, float]:
        """Least and largest amplitude of the displacement at the points of the tests, m."""
        data = self.data
        size = data["response"].values / (2.0 * np.pi * data["frequency"].values) ** self.measure.quantity.order
        return float(np.nanmin(size)), float(np.nanmax(size))

    def solve(self, case: int, report: Report) -> Arrays:
        """Frequency and damping ratio of a draw over the amplitude; of the identified parameters their errors too.

        The error of harmonics and samples is estimated as for a predicted response: the change of ln f and ln ζ with `FINER`
        times the harmonics and twice the samples, times 1/(1 − 1/FINER).
        """
        started = time.process_time()
        harmonics, samples = of_attribute(self.data.attrs["harmonics"]), int(self.data.attrs["samples"])
        with one_blas_thread():
            along = self._along(case, harmonics, samples, report)
            arrays: dict[str, Any] = {"found": along[:2], "uncertain": along[2]}
            if case == 0:
                many = FINER * highest(harmonics)
                finer = self._along(case, many, max(2 * samples, 4 * many + 2), lambda share: None)
                with np.errstate(invalid="ignore", divide="ignore"):
                    arrays["errors"] = np.abs(np.log(finer[:2] / along[:2])) / (1.0 - 1.0 / FINER)
        return arrays | {"cpu_seconds": np.array(time.process_time() - started)}

    def _along(self, number: int, harmonics: Any, samples: int, report: Report) -> Array:
        """Frequency and damping ratio of the decay of a draw, and 1 where it does not follow the mode (3, amplitudes), as its
        measuring chain shows the amplitudes; NaN where there is none."""
        draw = self.drawn[number]
        problem, gain = self.problem(draw), float(np.exp(draw.gain))
        low, high = self.amplitude
        ends = low / gain / BEYOND, high / gain * BEYOND
        modes = Modes(problem, self.followed, ends, harmonics, samples, output=self.output)
        balance = modes.balance(0)
        levels = modes.levels(balance)
        if self.starts[0] != "virgin":  # a forced balance is decoupled, which a large structure need not pay for virgin contacts
            forced = HarmonicBalance(problem, harmonics, modes.samples)
            space, variables = self.start_state(forced, float(np.nanmedian(self.data["force"].values)), number)
            balance = balance if space is None else space.balance(balance, variables)  # type: ignore[assignment]
        curve = solve_mode(balance, *levels, report)
        if len(curve.points) < 2:
            return np.full((3, self.grid.size), np.nan)
        row, solved = balance.rows + self.output, [point.evaluation for point in curve.points]
        size = np.array([float(np.hypot(*one.w[row, 1:3])) for one in solved])
        frequency = np.array([balance.omega_of(one.point) / (2.0 * np.pi) for one in solved])
        decay = slow_decay(balance, curve.points)
        leaves = decay.lags | (decay.others[:, self.output] > SHARED)
        rows = frequency, decay.damping_ratio[:, self.output], leaves.astype(float)
        order, at = np.argsort(size, kind="stable"), np.log(self.grid / gain)
        return np.array([np.interp(at, np.log(size[order]), values[order], np.nan, np.nan) for values in rows])

    def gathered(self, results: Sequence[Arrays]) -> DecayPrediction:
        """The prediction from all cases."""
        return DecayPrediction(_dataset(self, results))


@takes(DecayPredictionWork)
def predict_decay(work: DecayPredictionWork) -> DecayPrediction:
    """Predict the frequency and the damping ratio of a free decay over its amplitude, with 95 % intervals, from an identification
    by `identify_response`.

    amplitude: (low, high) of the displacement at the measured output, m. mode: number of the stuck mode that decays, 1 the
    lowest; or frequency [Hz], near which it lies; default: the mode nearest to the largest response in `band` of the test with
    the smallest motion. Frequency and damping are those of a slow decay along the nonlinear mode of each draw: the frequency of
    the mode, and the damping ratio by `analyses/modes/slow_decay.py`. draws, seed, settings and start_states are those of
    `predict_response`, and so is what else the intervals include: parameters, scatter from test to test, of the gain too, start
    states of the contacts, errors of harmonics and samples.
    """
    return work.gathered(all_cases(work, work.checkpoint, work.workers, work.progress))


def _dataset(work: DecayPredictionWork, results: Sequence[Arrays]) -> xr.Dataset:
    drawn = np.array([np.asarray(one["found"]) for one in results[1:]])  # (draws, 2, amplitudes)
    errors = np.asarray(results[0]["errors"])
    whole = np.nan_to_num(errors)
    # Frequency and damping ratio (2, amplitudes) of each draw, with its scatter between tests and its share of the errors.
    changes = [np.array([[draw.shift], [0.0]]) + draw.truncation * whole for draw in work.drawn[1:]]
    shifted = [values * np.exp(change) for values, change in zip(drawn, changes, strict=True)]

    least, most = work.measured
    data: dict[str, Any] = {}
    for k, name in enumerate(("frequency", "damping_ratio")):
        data |= of_draws(name, np.array(shifted)[:, k], axis=0) | {f"{name}_error": errors[k]}
    data["interpolated"] = within(work.grid, work.measured)
    data["uncertain"] = np.mean([np.nan_to_num(one["uncertain"]) for one in results[1:]], axis=0)
    data["unsolved"] = np.sum(~np.isfinite(drawn[:, 0]), axis=0).astype(float)
    data["drawn"] = work.values_of(work.drawn[1:])
    coords = {"amplitude": work.grid, "parameter": list(work.population.free)}
    attrs = work.about_draws | {"title": "Predicted decay", "mode": work.followed, "measured_from": least, "measured_to": most}
    attrs["cpu_seconds"] = sum(float(one["cpu_seconds"]) for one in results)
    return tabulated("decay_prediction", data, coords, attrs)
