"""What a result says of the stability of its points, in words."""

from __future__ import annotations

import numpy as np

from stickslip.results.view import band_of, in_band, level_text, points
from stickslip.support.checks import Array, counted, first_of
from stickslip.support.late import xr

UNSTABLE = 2
"""The flag of an unstable point."""

NOT_JUDGED = "The stability of the highest peaks was not judged; [stability] or `with_stability()` judges all points."

ONE_MOTION = "Friction under constant loads and damping leave one periodic motion at each frequency, and it is stable."

LISTED = 6
"""Changes of stability of a curve that are listed."""


def has_stability(dataset: xr.Dataset) -> bool:
    """Whether a result holds the stability of its points."""
    return "stability" in dataset.variables


def is_unstable(dataset: xr.Dataset, case: int, point: int) -> bool:
    """Whether the stability of a point is known, and it is unstable."""
    return has_stability(dataset) and int(dataset["stability"].values[case, point]) == UNSTABLE


def peak_is_unstable(dataset: xr.Dataset, case: int, output: int, point: int) -> bool:
    """Whether the highest peak of an output, a point of its curve, is known to be unstable: by the stability of all points, or by
    that of the highest peaks alone.
    """
    if has_stability(dataset):
        return is_unstable(dataset, case, point)
    return "highest_stability" in dataset and int(dataset["highest_stability"].values[case, output]) == UNSTABLE


def peak_unjudged(dataset: xr.Dataset, case: int, output: int) -> str:
    """Why a result that judges its highest peaks does not say whether one is stable, in two words; empty where it does."""
    if has_stability(dataset) or "highest_stability" not in dataset:
        return ""
    return {0: "not judged", 3: "undecided"}.get(int(dataset["highest_stability"].values[case, output]), "")


def none_is_judged(dataset: xr.Dataset) -> bool:
    """Whether the stability of no highest peak was asked for, as where that takes too long; one sentence then says it for all."""
    return not has_stability(dataset) and "highest_stability" in dataset and not dataset["highest_stability"].values.any()


def about_all(dataset: xr.Dataset) -> str:
    """The sentence on the stability of all highest peaks: that there is one motion only, or that none was judged."""
    if dataset.attrs.get("one_motion"):
        return ONE_MOTION
    return NOT_JUDGED if none_is_judged(dataset) else ""


def words(variable: xr.DataArray, flags: np.ndarray) -> list[str]:
    """The meanings of flags of a variable, "branch point" for branch_point."""
    attributes = variable.attrs
    names = dict(zip(np.atleast_1d(attributes["flag_values"]).tolist(), str(attributes["flag_meanings"]).split(), strict=True))
    return [names[int(flag)].replace("_", " ").replace("neimark sacker", "Neimark-Sacker") for flag in flags]


def unstable_steps(dataset: xr.Dataset, case: int) -> np.ndarray:
    """Which steps from one of `points` to the next have an unstable point at an end, (points − 1,)."""
    unstable = dataset["stability"].values[case, points(dataset, case)] == UNSTABLE
    return np.asarray(unstable[1:] | unstable[:-1])


def split(values: Array, unstable: np.ndarray) -> tuple[Array, Array]:
    """A curve as its stable and its unstable steps, NaN at points that no step of the kind reaches."""
    kept = []
    for wanted in (~unstable, unstable):
        reached = np.append(wanted, False) | np.append(False, wanted)
        kept.append(np.where(reached, values, np.nan))
    return kept[0], kept[1]


def stability_sentences(dataset: xr.Dataset) -> list[str]:
    """How many points of each force level are unstable or undecided, and where and how stability changes."""
    lines, flags = ["stability"], dataset["stability"].values
    changes, frequencies = dataset["stability_change"], dataset["stability_change_frequency"].values
    for case in range(dataset.sizes["case"]):
        inside, (low, high) = in_band(dataset, case, np.arange(flags.shape[1])), band_of(dataset)
        counts = [int(np.count_nonzero(flags[case, inside] == flag)) for flag in (1, UNSTABLE, 3)]
        found = (frequencies[case] >= low) & (frequencies[case] <= high)
        kinds = words(changes, changes.values[case, found])
        each = [f"{kind} at {hertz:.6g} Hz" for kind, hertz in zip(kinds, frequencies[case, found], strict=True)]
        places = first_of(each, LISTED)
        undecided = f", {counts[2]} undecided" if counts[2] else ""
        where = f"; {places}" if places else ""
        lines.append(f"  {level_text(dataset, case)}: {counts[0]} points stable, {counts[1]} unstable{undecided}{where}")
    if unresolved := int(np.count_nonzero(dataset["multiplier_resolved"].values == 0)):
        lines.append(
            f"  {counted(unresolved, 'point')} undecided, because the true motion is far from the solution or was not found: "
            "take more harmonics"
        )
    stuck, dropped = int(np.nanmax(dataset["stuck_sliders"].values, initial=0)), int(dataset.attrs["stability_dropped_modes"])
    if stuck:
        lines.append(
            f"  up to {stuck} sliders never slip: their multipliers of exactly 1 say that forces are not unique, no more"
        )
    if dropped:
        error = float(dataset.attrs["stability_mode_error"])
        lines.append(
            f"  {dropped} high modes follow at once, which changes the largest multiplier by {error:.1g} where it matters most"
        )
    return lines
