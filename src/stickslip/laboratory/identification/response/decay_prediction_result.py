"""What a predicted decay is given as: the result, measured decays beside it, and the answer in sentences."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

from stickslip.analyses.truncation import ALLOWED
from stickslip.laboratory.identification.response.draws import NORMAL
from stickslip.laboratory.identification.response.prediction_result import (
    ALLOWED_SHIFT,
    damping_text,
    frequency_text,
    held_share,
    remark_on_few_draws,
    remarks_on_draws,
    unexplained,
    what_was_free,
)
from stickslip.laboratory.measurement.decay import MeasuredDecay
from stickslip.results.files import save
from stickslip.results.result import Result
from stickslip.results.schema import stamped
from stickslip.results.view import length_text
from stickslip.support.checks import Array, Index, InputError, fault, of_kind, several
from stickslip.support.late import pd, xr

COMPARED = (("frequency", "Hz", "frequency", 1.0), ("damping ratio", "%", "damping_ratio", 100.0))
"""What a comparison lists: words, unit, variable, and the unit as a number."""

OTHER_MODE = 1.2
"""Ratio of the frequencies of a measured and the predicted decay from which another mode is suspected."""

QUICK = 0.03
"""Damping ratio from which on a decay is too quick: within two cycles its amplitude falls by a third."""

ROWS, LINES = 9, 4
"""Amplitudes of a table, and of the answer in sentences."""


@dataclass(frozen=True, eq=False, repr=False)
class DecayPrediction(Result):
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

    def save(self, path: str | Path) -> Path:
        """Write the dataset as NetCDF, as the command does."""
        return save(stamped(self.dataset, "decay_prediction"), path)


def compared_decays(dataset: xr.Dataset, decays: Sequence[xr.Dataset]) -> xr.Dataset:
    """The dataset with measured decays: the windows of each at the predicted amplitudes, and the share of them inside the
    interval, which is widened by their own errors."""
    if not decays:
        raise fault("decays", "must hold at least one measured decay", [])
    dataset, size = dataset.drop_dims(["decay", "window"], errors="ignore"), dataset["amplitude"].values
    names, which = _names(decays), [windows_between(one, size[0], size[-1]) for one in decays]

    def along(values: Sequence[Array], words: str, unit: str) -> tuple[Any, ...]:
        longest = max(windows.size for windows in which)
        rows = [np.pad(row, (0, longest - row.size), constant_values=np.nan) for row in values]
        return ("decay", "window"), np.array(rows), {"units": unit, "long_name": words}

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
        found[f"inside_{key}"] = "decay", np.array(shares), {"units": "1", "long_name": what}
    return dataset.assign(found).assign_coords(decay=("decay", names, {"units": "1", "long_name": "measured decay"}))


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
    lower, upper = middle - np.hypot(low - middle, NORMAL * error), middle + np.hypot(high - middle, NORMAL * error)
    known = np.isfinite(lower) & np.isfinite(upper)
    return float(np.mean((value >= lower)[known] & (value <= upper)[known])) if known.any() else float("nan")


def _names(decays: Sequence[xr.Dataset]) -> list[str]:
    """The titles of decays, numbered where they are alike."""
    titles = [str(one.attrs.get("title", "")) or "decay" for one in decays]
    return [title if titles.count(title) == 1 else f"{title} ({titles[: k + 1].count(title)})" for k, title in enumerate(titles)]


def decay_table(dataset: xr.Dataset) -> pd.DataFrame:
    """Frequency and damping ratio with their 95 % intervals at amplitudes in equal ratios."""
    at = _shown(dataset["amplitude"].values, ROWS)
    columns: dict[str, Any] = {"amplitude [m]": dataset["amplitude"].values[at]}
    for words, unit, key, factor in COMPARED:
        for end, name in (("", ""), ("_low", "from "), ("_high", "to ")):
            columns[f"{name}{words} [{unit}]"] = factor * dataset[f"{key}{end}"].values[at]
    inside = dataset["interpolated"].values[at] > 0.0
    return pd.DataFrame(columns | {"measured amplitudes": np.where(inside, "interpolated", "extrapolated")})


def whole_tables(dataset: xr.Dataset) -> dict[str, pd.DataFrame]:
    """All amplitudes of the prediction, and all windows of the compared decays."""

    def of(keys: Sequence[str], place: dict[str, Any]) -> pd.DataFrame:
        columns = {f"{key.replace('_', ' ')} [{dataset[key].attrs['units']}]": dataset[key].values.ravel() for key in keys}
        return pd.DataFrame(place | columns)

    ends = [f"{key}{end}" for _, _, key, _ in COMPARED for end in ("", "_low", "_high")]
    found = {"decay": of(["amplitude", *ends], {})}
    if "decay" in dataset.sizes:
        pairs = [
            f"{end}_{key}" for _, _, key, _ in COMPARED for end in ("measured", "predicted", "predicted_low", "predicted_high")
        ]
        names = {"decay": np.repeat(dataset["decay"].values, dataset.sizes["window"])}
        found["windows"] = of(["measured_amplitude", *pairs], names).dropna(ignore_index=True)
    return found


def comparison_table(dataset: xr.Dataset) -> pd.DataFrame:
    """Of each compared decay at amplitudes in equal ratios measured, predicted and interval of frequency and damping ratio, and
    the error in percent of the measured one."""
    rows: dict[str, list[Any]] = {}
    for t, name in enumerate(dataset["decay"].values):
        one = dataset.isel(decay=t)
        size = one["measured_amplitude"].values
        known = np.flatnonzero(np.isfinite(size))
        for k in known[_shown(size[known], ROWS)]:
            values: dict[str, Any] = {"decay": name, "amplitude [m]": float(size[k])}
            for words, unit, key, factor in COMPARED:
                ends = ("measured", "predicted", "predicted_low", "predicted_high")
                measured, predicted, low, high = (factor * float(one[f"{end}_{key}"].values[k]) for end in ends)
                values |= {f"measured {words} [{unit}]": measured, f"predicted {words} [{unit}]": predicted}
                values |= {f"from {words} [{unit}]": low, f"to {words} [{unit}]": high}
                values[f"error of {words} in %"] = 100.0 * (predicted / measured - 1.0)
            for head, value in values.items():
                rows.setdefault(head, []).append(value)
    return pd.DataFrame(rows)


def _shown(size: Array, most: int) -> np.ndarray:
    """The numbers of values nearest to so many in equal ratios, from the largest to the smallest."""
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
    found, share = [], held_share(dataset)
    for k in _shown(dataset["amplitude"].values, LINES):
        f, z = (
            [float(dataset[f"{key}{end}"].values[k]) for end in ("", "_low", "_high")] for key in ("frequency", "damping_ratio")
        )
        where = length_text(float(dataset["amplitude"].values[k]), dataset)
        if not np.isfinite(f[0]):
            found.append(f"{where}: no nonlinear mode was found at this amplitude.")
            continue
        found.append(f"{where}: {frequency_text(f, share)}{damping_text(z)}")
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
        found.append(f"{name}: predicted against measured {', '.join(words)}" if words else f"{name}: nothing is predicted there")
        apart = np.nanmedian(dataset["predicted_frequency"].values[t] / dataset["measured_frequency"].values[t])
        if words and abs(np.log(apart)) > np.log(OTHER_MODE):
            found.append(f"{name}: its frequency is not that of mode {dataset.attrs['mode']}. Is it the decay of another mode?")
    return found


def _remarks(dataset: xr.Dataset) -> list[str]:
    found = remarks_on_draws(dataset.attrs)
    if not dataset["interpolated"].values.all():
        found.append(
            "Beyond the measured amplitudes the prediction rests on the contact law alone, whose error is not in the intervals."
        )
    off, size = (dataset[f"{key}_error"].values for key in ("frequency", "damping_ratio"))
    if not np.any(np.isfinite(off)):
        found.append("The intervals do not include the error due to harmonics, which could not be estimated.")
    elif np.nanmax(size) > ALLOWED or np.nanmax(off) > ALLOWED_SHIFT:
        found.append(
            f"The harmonics of the identification leave errors of up to {100.0 * np.nanmax(off):.2g} % in the frequency and "
            f"{100.0 * np.nanmax(size):.2g} % in the damping ratio, which the intervals include. The parameters carry an error "
            "of the same cause, which they do not: identify again with more harmonics."
        )
    if "decay" in dataset.sizes and np.nanmax(dataset["damping_ratio"].values) > QUICK:
        found.append(
            f"At damping ratios above {100.0 * QUICK:.0f} % a decay is too quick to follow the nonlinear mode, and its windows "
            "average over amplitudes that differ by a third: the intervals do not include this. Compare with `free_decay` there."
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
