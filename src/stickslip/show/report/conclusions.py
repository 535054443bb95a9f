"""Conclusions in sentences, computed from the data; failures grouped by cause, with count and frequencies for each force
level."""

from __future__ import annotations

import re
from collections.abc import Iterable

import numpy as np

from stickslip.analyses.isolated import IN_THIS_BAND
from stickslip.analyses.reached import Reached
from stickslip.analyses.truncation import OWN_FORCES
from stickslip.analyses.variability.bounds import detached, has_bounds
from stickslip.results import view
from stickslip.results.quantities import is_unstable, peak_is_unstable, peak_verdict
from stickslip.results.schema import CurveKind, kinds_in, shown_sentence
from stickslip.show.report.markup import hertz, number, percent
from stickslip.support.checks import counted, in_percent
from stickslip.support.late import xr
from stickslip.support.outcome import Outcome

OUTSIDE = "Peaks outside the band, where the curve goes and comes back; they do not count."
"""Caption of their table."""

SAME = 5e-4
"""Relative difference of two frequencies or amplitudes below which a sentence calls them the same."""


def bounds_headline(bounds: xr.Dataset) -> str:
    """Both bounds over all start states, at the force level and frequency where they are furthest apart."""
    low, high = bounds["amplitude"].values[:, 0], bounds["amplitude"].values[:, 1]
    if not np.isfinite(high / low).any():
        return "No bounds of the response were found."
    case, k = np.unravel_index(int(np.nanargmax(high / low)), low.shape)
    ends = [view.size_text(float(values[case, k]), bounds["amplitude"].attrs["units"], bounds) for values in (low, high)]
    what = "peak" if bounds.attrs["objective"] == "peak" else "response"
    at = bounds["resonance"].values[case, :, k]
    where = f"{hertz(at[0])} and {hertz(at[1])} Hz" if what == "peak" else f"{hertz(float(bounds['frequency'].values[k]))} Hz"
    apart = f"{percent(float(high[case, k] / low[case, k]) - 1.0)} apart"
    return unbroken(
        f"Over all start states of the contacts the {what} of {view.level_text(bounds, int(case))} lies between {ends[0]} and "
        f"{ends[1]}, at {where}: {apart}, the widest range found."
    )


def unbroken(sentence: str) -> str:
    """Numbers stay on one line with their units."""
    return re.sub(r"(?<=\d) (?=Hz|%|µm|mm|N\b)|(?<=×) (?=\d)", "\u00a0", sentence)


def further_curves_sentence(dataset: xr.Dataset, output: int = 0) -> str:
    """The highest peak of the sweep and that of the curves that no sweep meets, with its stability, of the force level at which
    these are highest; empty without such curves."""
    kinds, levels = kinds_in(dataset), dataset["force_level"].values.tolist()
    peaks = {case: peak for case in range(len(kinds)) if (peak := view.highest_peak(dataset, case, output)) is not None}
    further = [case for case in peaks if kinds[case] != CurveKind.SWEEP]
    if not further:
        return ""
    highest, unit = max(further, key=lambda case: peaks[case].amplitude), view.peak_unit(dataset)
    # The first harmonic says little of a motion over several periods, whose largest part may be another.
    in_time = view.periods_of(dataset) > 1 and view.measure_in(dataset).kind != "max_abs"

    def height(case: int) -> str:
        largest = f", up to {number(peaks[case].max_abs / unit.metres)} {unit.name} in time," if in_time else ""
        end = view.higher_end(dataset, case, output)
        higher = "" if end is None else f" and {number(end.amplitude / unit.metres)} {unit.name} at its end"
        return f"{number(peaks[case].amplitude / unit.metres)} {unit.name}{largest} at {hertz(peaks[case].frequency)} Hz{higher}"

    own = [case for case in peaks if levels[case] == levels[highest]]
    swept = next((case for case in own if kinds[case] == CurveKind.SWEEP), None)
    alike = sum(kinds[case] == kinds[highest] for case in own)
    one, several = ("detached curve", "detached curves") if kinds[highest] == CurveKind.ISOLATED else ("branch", "branches")
    which = f"a {one}" if alike == 1 else f"the highest of {alike} {several}"
    if str(dataset["case_message"].values[highest]).startswith(IN_THIS_BAND):
        which = f"{IN_THIS_BAND[0].lower()}{IN_THIS_BAND[1:]}"
    names = [view.force_text(dataset, highest)] if len(set(levels)) > 1 else []
    names += [str(dataset["output"].values[output])] if dataset.sizes["output"] > 1 else []
    parts = []
    if swept is not None:
        begin = float(dataset["frequency"].values[swept, view.converged_points(dataset, swept)[0]])
        parts.append(f"{height(swept)} on the curve begun at {hertz(begin)} Hz")
    parts.append(f"{height(highest)} on {which} ({peak_verdict(dataset, highest, output, peaks[highest].point)})")
    return f"{', '.join(names)}{': ' if names else ''}{', '.join(parts)}."


WAYS = {"from_rest": "from rest", "sweep_up": "by a slow sweep up", "sweep_down": "by a slow sweep down"}
"""The questions of `ForcedResponse.reached` in the words of a sentence."""


def reached_sentences(dataset: xr.Dataset) -> list[str]:
    """Of the highest peak of each curve, what leads to it, and what a disturbance has to exceed where nothing else does; empty
    where this was not asked for."""
    if "reached" not in dataset:
        return []
    output = dataset["output"].values.tolist().index(dataset.attrs["output_reached"])
    sentences = []
    for case, flags in enumerate(dataset["reached"].values.tolist()):
        peak = view.highest_peak(dataset, case, output)
        if peak is None:
            continue
        yes, no = (
            [words for flag, words in zip(flags, WAYS.values(), strict=True) if flag == each]
            for each in (Reached.REACHED, Reached.NOT_REACHED)
        )
        neither = f"{'not' if len(no) == 1 else 'neither'} {' nor '.join(no)}" if no else ""
        parts = [f"is reached {', '.join(filter(None, (*yes, neither)))}"] if yes or no else []
        lower, reasons = dataset["next_lower"], str(dataset["reached_unknown"].values[case])
        if not yes and peak_is_unstable(dataset, case, output, peak.point):
            parts.append("is unstable, so no disturbance leads to it either")
        elif len(no) == len(WAYS) and np.isfinite(lower.values[case]):
            smallest = view.size_text(float(lower.values[case]), lower.attrs["units"], dataset)
            parts.append(f"only a disturbance leads to it, of roughly more than {smallest} at this frequency, or less at another")
        no_way = not any(f"{question}:" in reasons for question in WAYS)
        for question, words in WAYS.items():
            reasons = reasons.replace(f"{question}:", f"{words}:")
        parts += [f"{'' if parts else 'is '}not known to be reached{':' if no_way else ''} {reasons}"] if reasons else []
        what = "the peak" if peak.local else "the largest motion, no peak,"
        sentences.append(f"{view.level_text(dataset, case)}: {what} at {hertz(peak.frequency)} Hz {'; '.join(parts)}.")
    return sentences


def reference(dataset: xr.Dataset, which: str, case: int, peak: view.Peak, output: int = 0) -> tuple[float, float] | None:
    """The "free" or "stuck" resonance of the mode of a peak: natural frequency, Hz, and size of the linear curve."""
    linear = view.linear_peak(dataset, which, case, peak.frequency, output, peak.amplitude)
    if linear is None:
        return None
    natural = dataset[f"natural_frequency_{which}"].values
    natural = natural[np.isfinite(natural)]
    near = natural[np.abs(natural / linear[0] - 1.0) < 0.02] if natural.size else natural
    return (float(near[np.argmin(np.abs(near - linear[0]))]) if near.size else linear[0]), linear[1]


def linear_limits(dataset: xr.Dataset) -> tuple[str, ...]:
    """The linear responses to compare with; one where stuck contacts add no stiffness, as cubic springs do."""
    free, stuck = (dataset[f"natural_frequency_{which}"].values for which in ("free", "stuck"))
    same = free.shape == stuck.shape and np.allclose(free, stuck, rtol=1e-9, atol=0.0, equal_nan=True)
    return ("free",) if same else ("stuck", "free")


def failures_of(dataset: xr.Dataset) -> list[str]:
    """One sentence a cause, one for each curve that has no points or stopped before the end of its band, and one for each
    force level without bounds; empty if none.
    """
    sentences, outcomes = [], dataset.outcome.values
    for code in sorted(set(outcomes.ravel().tolist()) - {int(Outcome.EMPTY), int(Outcome.CONVERGED)}):
        cases = np.flatnonzero(np.any(outcomes == code, axis=1)).tolist()
        where = [f"{view.level_text(dataset, case)}: {_ranges(dataset, case, code)}" for case in cases]
        count = int(np.count_nonzero(outcomes == code))
        sentences.append(f"{counted(count, 'point')}: {_sentence(code)} ({'; '.join(where)})")
    for case in range(dataset.sizes["case"]):
        if int(dataset.case_outcome[case]) != Outcome.CONVERGED:
            cause = str(dataset.case_message.values[case]).strip() or _sentence(int(dataset.case_outcome[case]))
            sentences.append(f"{view.level_text(dataset, case)}: the curve did not reach the end of the band. {cause}")
        elif not view.points(dataset, case).size:
            sentences.append(f"{view.level_text(dataset, case)}: no point was computed.")
    sentences += bounds_failures(detached(dataset)) if has_bounds(dataset) else []
    return [shown_sentence(sentence, dataset) for sentence in sentences]


def bounds_failures(bounds: xr.Dataset) -> list[str]:
    """A sentence for each force level and cause where there are no bounds."""
    sentences, by_frequency = [], bool(np.all(np.isfinite(bounds["frequency"].values)))
    every = counted(bounds.sizes["frequency"], "frequency", "frequencies")
    for case in range(bounds.sizes["case"]):
        level, outcomes = view.force_text(bounds, case), bounds["outcome"].values[case]
        for code in sorted(set(outcomes.ravel().tolist()) - {int(Outcome.CONVERGED)}):
            at = np.flatnonzero(np.any(outcomes == code, axis=0))
            where = f"at {at.size} of {every}" if by_frequency else "of the peak"
            sentence, unsolved = f"{level}: no bounds {where}. {_sentence(code)}", _unsolved(bounds, case, at)
            sentences.append(f"{sentence} {unsolved}." if unsolved else sentence)
    return sentences


def bounds_warnings(bounds: xr.Dataset) -> list[str]:
    """A sentence for each force level where bounds were found although some start states have no solution."""
    sentences = []
    for case in range(bounds.sizes["case"]):
        bounded = np.all(bounds["outcome"].values[case] == Outcome.CONVERGED, axis=0)
        at = np.flatnonzero(bounded & (bounds["unsolved_share"].values[case] > 0.0))
        if at.size:
            sentences.append(f"{view.force_text(bounds, case)}: {_unsolved(bounds, case, at)}. Bounds are over the others.")
        errors = np.abs(bounds["modal_error"].values[case]) if "modal_error" in bounds else np.zeros(1)
        largest = float(np.nanmax(errors, initial=0.0))
        if largest > OWN_FORCES.allowed:
            change = in_percent(largest)
            sentences.append(f"{view.force_text(bounds, case)}: bounds change by up to {change} when solved {OWN_FORCES.words}.")
        if np.any(np.isnan(errors) & np.isfinite(bounds["amplitude"].values[case])):
            sentences.append(f"{view.force_text(bounds, case)}: bounds could not all be solved {OWN_FORCES.words}.")
    return sentences


def _unsolved(bounds: xr.Dataset, case: int, at: np.ndarray) -> str:
    """How many of the sampled start states have no solution, at most, and why; empty where all have one."""
    k = int(at[np.argmax(bounds["unsolved_share"].values[case, at])])
    share, count = float(bounds["unsolved_share"].values[case, k]), int(bounds["unsolved"].values[case, k])
    if not count:
        return ""
    of = f"{count} of {bounds.sizes['start']} sampled start states ({percent(share)})"
    frequency = float(bounds["frequency"].values[k])
    where = f", at {hertz(frequency)} Hz" if np.isfinite(frequency) else ""
    why = _sentence(int(bounds["unsolved_outcome"].values[case, k])).rstrip(".")
    return f"{of} have no solution{where}: {why}"


def warnings_of(dataset: xr.Dataset, cases: Iterable[int] | None = None) -> list[str]:
    """What was warned of in the study; messages of completed curves, and levels whose response has no peak inside the band, an
    unstable one or a higher end, of cases in the given order, else of all.
    """
    sentences = [str(words) for words in np.atleast_1d(dataset.attrs.get("study_warnings", ()))]
    for case in range(dataset.sizes["case"]) if cases is None else cases:
        _, _, more = str(dataset.case_message.values[case]).strip().partition(". ")
        if more and int(dataset.case_outcome[case]) == Outcome.CONVERGED:
            sentences.append(f"{view.level_text(dataset, case)}: {more}")
        for output, name in enumerate(dataset.output.values):
            peak = view.highest_peak(dataset, case, output)
            known = not view.is_listed(dataset) and int(dataset.case_outcome[case]) != Outcome.STOPPED
            if peak is not None and not peak.local and peak.amplitude > 0.0 and known:
                sentences.append(f"{view.level_text(dataset, case)}: {name} has no peak inside the band.")
            if peak is not None and is_unstable(dataset, case, peak.point) and "Unstable motion" not in more:
                sentences.append(
                    f"{view.level_text(dataset, case)}: the highest point of {name}, at {hertz(peak.frequency)} Hz, is an "
                    "unstable motion: a vibration does not stay there."
                )
            if end := view.higher_end(dataset, case, output):
                sentences.append(
                    f"{view.level_text(dataset, case)}: {name} is larger at an end of its curve, {hertz(end.frequency)} Hz, than "
                    "at any peak: a higher one may lie beyond."
                )
    sentences += bounds_warnings(detached(dataset)) if has_bounds(dataset) else []
    return [shown_sentence(sentence, dataset) for sentence in sentences]


def _ranges(dataset: xr.Dataset, case: int, code: int) -> str:
    """Neighbouring points as one range of frequencies."""
    where = np.flatnonzero(dataset.outcome.values[case] == code)
    ranges = []
    for run in np.split(where, np.flatnonzero(np.diff(where) > 1) + 1):
        span = dataset.frequency.values[case, run]
        low, high = hertz(float(np.nanmin(span))), hertz(float(np.nanmax(span)))
        ranges.append(f"{low} Hz" if low == high else f"{low} to {high} Hz")
    return ", ".join(ranges)


def _sentence(code: int) -> str:
    try:
        return Outcome(code).sentence
    except ValueError:
        return f"Unknown outcome {code}."
