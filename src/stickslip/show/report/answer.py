"""What came out, at a glance: the first screen of responses, and what `print` and notebooks show of any result in a few lines.

The first screen: the highest peak of each force level, how it compares and how sure it is, and every warning.

Conclusions in sentences, computed from the data; failures grouped by cause, with count and frequencies for each force
level.
"""

from __future__ import annotations

import re
from collections.abc import Iterable, Mapping, Sequence

import numpy as np

from stickslip.analyses.isolated import IN_THIS_BAND
from stickslip.analyses.reached import Reached
from stickslip.analyses.stress import Margin, has_fatigue, smallest_margins
from stickslip.analyses.truncation import ALL_MODES, ALL_NODES, OWN_FORCES, SEATED
from stickslip.analyses.variability.bounds import detached, has_bounds
from stickslip.results import quantities, view
from stickslip.results.quantities import is_unstable, peak_is_unstable, peak_verdict
from stickslip.results.schema import CurveKind, Result, analysis_named, kinds_in, shown_sentence
from stickslip.show.report.markup import cell, hertz, number, percent, picture, presentations, table, text
from stickslip.support.checks import counted, in_percent, listed
from stickslip.support.late import xr
from stickslip.support.outcome import Outcome
from stickslip.support.renderers import SENTENCES

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


MOST_LEVELS, MOST_PEAKS, MOST_WARNINGS = 6, 4, 2
"""Force levels, and peaks of all outputs, in the table, so that the first chart is on the first screen too; the section on peaks
has all. Warnings whose first sentence is shown.
"""
SOURCES = {
    "truncation_error": "harmonics",
    "sampling_error": "samples",
    ALL_MODES.variable: "coordinates",
    ALL_NODES.variable: "contact points",
}
"""What can be too few for a peak, by the variable with its relative change by more of them."""
FINER = (ALL_MODES.variable, ALL_NODES.variable)
"""Those that are found by solving the peak once more, and unknown where that fails."""
AGAINST = {"stuck": "Against stuck contacts", "free": "Against no contacts"}
"""Heads of the columns that compare with the linear responses."""
PERCENT = re.compile(r"(\d[\d.]*) %")
"""An error in a warning."""
WORDLESS = re.compile(r"\W+")
"""What an identifier of the page cannot hold."""
LEVEL = 24
"""Characters of the words for a force level, which stand in front of its warnings."""
BESIDE = 4
"""Columns that stand beside each other on a narrow screen."""
NOTHING = "–"
"""What stands in a cell without anything to say."""
LEAST = 1e-3
"""Relative error below which its size does not matter to a reader."""
SIZE = re.compile(r"[+−-]?\d\S*( \S+)?")
"""A number with its sign and unit: warnings of one kind differ in these alone."""


def comparison(datasets: Mapping[str, xr.Dataset]) -> str:
    """One table of several results, a row each, below the sentence which of them has the lowest peak at each force level; empty
    where they have no force level in common, or their peaks are not of one quantity of one output.
    """
    results, first = list(datasets.values()), next(iter(datasets.values()))
    kinds = {(str(data["output"].values[0]), view.measure_in(data), view.levels_in_newtons(data)) for data in results}
    cases = [{level: case for case, level in enumerate(data["force_level"].values.tolist())} for data in results]
    common = sorted(set.intersection(*map(set, cases)))
    single = all(len(at) == data.sizes["case"] for at, data in zip(cases, results, strict=True))
    if len(results) < 2 or len(kinds) > 1 or not common or not single:
        return ""
    shown, unit = [common[place] for place in view.spread(len(common), MOST_LEVELS)], view.peak_unit(*results)
    rows, lowest = [], {label: list[str]() for label in datasets}
    for (label, data), at in zip(datasets.items(), cases, strict=True):
        cells = "".join(_height(data, at[level], unit) for level in shown)
        least = max((at[level] for level in shown), key=lambda case: max(errors_of(data, case, 0).values(), default=np.inf))
        rows.append(f"<tr>{cell(label)}{cells}{cell(unbroken(error_words(data, least, 0)))}</tr>")
    names, undecided = [view.force_text(first, cases[0][level]) for level in shown], list[str]()
    for level, name in zip(shown, names, strict=True):
        low, high = np.array([_range(data, at[level]) for data, at in zip(results, cases, strict=True)]).T
        best = int(np.argmin(high))
        nearest = float(np.delete(low, best).min())
        apart = nearest > high[best] and number(nearest) != number(high[best])  # by a digit that the table shows
        (lowest[list(datasets)[best]] if apart else undecided).append(name)
    output = first["output"].values[0]
    decided = ", ".join(f"{label} at {listed(at)}" for label, at in lowest.items() if at)
    said = [f"Lowest peak of {output}: {decided}."] if decided else []
    why = "the order of the peaks is open: see their estimated errors and warnings"
    said += [f"At {listed(undecided)} {why}."] if undecided else []
    said += [f"{len(shown)} of {len(common)} force levels are shown."] if len(shown) < len(common) else []
    heads = [f"{output} in {unit.name}", *names, "Estimated error"]
    answer = table("answer-compared", "Highest peak of each result at each force level.", heads, rows, stacked=True)
    return f'<p class="headline">{text(unbroken(" ".join(said)))}</p>{answer}'


def _height(dataset: xr.Dataset, case: int, unit: view.Length) -> str:
    """The highest peak of the first output of a curve as a cell: its size and frequency."""
    peak = view.highest_peak(dataset, case)
    if peak is None:
        return cell(NOTHING)
    unstable = "unstable" if peak_is_unstable(dataset, case, 0, peak.point) else ""
    words = f"{number(peak.amplitude / unit.metres)} at {hertz(peak.frequency)} Hz"
    return cell(unbroken(words), peak.amplitude, _note(dataset, case, peak) or unstable)


def _range(dataset: xr.Dataset, case: int) -> tuple[float, float]:
    """Between which sizes the highest peak of the first output lies, by its estimated errors and the history of the static load;
    from 0 to infinity where this is not known."""
    peak, errors = view.highest_peak(dataset, case), errors_of(dataset, case, 0)
    if peak is None or _note(dataset, case, peak) or not errors or peak_is_unstable(dataset, case, 0, peak.point):
        return 0.0, np.inf
    if int(dataset["case_outcome"].values[case]) != Outcome.CONVERGED or view.higher_end(dataset, case) is not None:
        return 0.0, np.inf
    error = sum(errors.values())
    seated = float(np.nan_to_num(dataset[SEATED.variable].values[case, 0])) if SEATED.variable in dataset else 0.0
    ends = [1.0 - error, 1.0 + error, 1.0 + seated]
    return peak.amplitude * min(ends), peak.amplitude * max(ends)


def peaks_at_a_glance(label: str, dataset: xr.Dataset) -> str:
    """A table of the highest peaks, and below it what is incomplete and all warnings, of the least certain curve first."""
    return highest_peaks(label, dataset) + warnings_at_a_glance({"": least_certain_first(dataset)})


def highest_peaks(label: str, dataset: xr.Dataset) -> str:
    """A table of the highest peaks, and why small vibrations are not those of stuck contacts where this is so."""
    cases = view.representatives(dataset, MOST_LEVELS).cases if dataset.sizes["case"] > 1 else [0]
    outputs = range(dataset.sizes["output"] if len(cases) * dataset.sizes["output"] <= MOST_PEAKS else 1)
    shown = [(case, output) for case in cases for output in outputs]
    linear = linear_limits(dataset) if dataset.sizes["contact"] else ()  # a structure without contacts is one itself
    limits = [which for which in linear if any(_change(dataset, which, *place) != NOTHING for place in shown)]
    name = "" if len(outputs) > 1 else f" of {dataset['output'].values[0]}"
    measure = view.measure_in(dataset)
    size = {"amplitude": "Amplitude", "rms": "Rms", "max_abs": "Largest"}[measure.kind]
    size += "" if measure.quantity.name == "displacement" else f" of the {measure.quantity.name}"
    heads = ["Force level", *(["Output"] if len(outputs) > 1 else []), "Frequency in Hz"]
    if engine_order(dataset):
        orders = np.atleast_1d(dataset.attrs.get("excited_orders", engine_order(dataset))).tolist()
        heads.append(f"Rotor speed in rev/min, engine order{'' if len(orders) == 1 else 's'} {', '.join(map(str, orders))}")
    heads += [f"{size}{name} in {view.peak_unit(dataset).name}", "Estimated error", *(AGAINST[which] for which in limits)]
    heads += ["Fatigue margin"] if has_fatigue(dataset) else []
    margins = smallest_margins(dataset) if has_fatigue(dataset) else {}
    rows = [_row(dataset, case, output, len(outputs) > 1, limits, margins) for case, output in shown]
    count = dataset.sizes["case"]
    which = "each force level" if len(cases) == count else f"{len(cases)} of {count} curves, spread over the force levels"
    answer = table(
        "answer-" + WORDLESS.sub("-", label), f"Highest peak{name} at {which}.", heads, rows, stacked=len(heads) > BESIDE
    )
    said = " ".join(filter(None, (str(dataset.attrs.get("static_history", "")), quantities.peaks_stability(dataset))))
    return answer + (f'<p class="note">{text(said)}</p>' if said else "")


def least_certain_first(dataset: xr.Dataset) -> list[str]:
    """What is incomplete, and all warnings, of the curve with the largest estimate of error first."""

    def certainty(case: int) -> float:
        errors = (error for k in range(dataset.sizes["output"]) for error in errors_of(dataset, case, k).values())
        return -max(errors, default=0.0)

    return [*failures_of(dataset), *warnings_of(dataset, sorted(range(dataset.sizes["case"]), key=certainty))]


def warnings_at_a_glance(warnings: Mapping[str, Sequence[str]]) -> str:
    """The first warnings of results by their labels, and the others folded; those that differ in numbers alone are one."""
    alike: dict[str, list[tuple[str, str]]] = {}
    for label, sentences in warnings.items():
        for words in sentences:
            of, colon, rest = words.partition(": ")
            of, rest = (of, rest) if colon and len(of) < LEVEL else ("", words[:1].upper() + words[1:])
            alike.setdefault(SIZE.sub("", rest), []).append((", ".join(filter(None, (label, of))), rest))
    shown = [_warning(group) for group in alike.values()]
    first, more = "".join(shown[:MOST_WARNINGS]), "".join(shown[MOST_WARNINGS:])
    count = counted(len(shown) - MOST_WARNINGS, "more warning")
    return first + (f"<details><summary>{count}</summary>{more}</details>" if more else "")


def _largest_percent(words: str) -> float:
    return max(map(float, PERCENT.findall(words)), default=0.0)


def _warning(group: Sequence[tuple[str, str]]) -> str:
    """The warning with the largest error by its sentence with it, else by its first one; behind it its other sentences, and the
    warnings that are like it."""
    (of, rest), *others = sorted(group, key=lambda warning: -_largest_percent(warning[1]))
    sentences = re.split(r"(?<=\.) (?=[A-Z])", rest)
    head = f"{of}: " if of else ""
    first = head + sentences.pop(max(range(len(sentences)), key=lambda k: _largest_percent(sentences[k])))
    if not sentences and not others:
        return f'<p class="warning">{text(first)}</p>'
    less = ", with smaller changes" if _largest_percent(rest) else ""
    first += (
        f" {counted(len(others), 'more curve')} {'have' if len(others) > 1 else 'has'} the same warning{less}." if others else ""
    )
    more = "".join(f"<li>{text(f'{of}: {words}')}</li>" for of, words in others)
    listing = f"<ul>{more}</ul>" if more else ""
    return f'<details class="warning"><summary>{text(first)}</summary>{text(" ".join(sentences))}{listing}</details>'


def errors_of(dataset: xr.Dataset, case: int, output: int) -> dict[str, float]:
    """The known estimates of error of a peak, relative, by what causes them."""
    errors = {source: float(dataset[name].values[case, output]) for name, source in SOURCES.items() if name in dataset}
    return {source: abs(error) for source, error in errors.items() if np.isfinite(error)}


def engine_order(dataset: xr.Dataset) -> int:
    """Cycles of the excitation in a turn of the rotor, 0 where it is not that of a disk."""
    return abs(int(dataset.attrs.get("engine_order", 0)))


def _row(dataset: xr.Dataset, case: int, output: int, named: bool, limits: Sequence[str], margins: Mapping[int, Margin]) -> str:
    """The highest peak of one curve and output, or why there is none; named: with the name of the output."""
    peak, unit, order = view.highest_peak(dataset, case, output), view.peak_unit(dataset), engine_order(dataset)
    begin = cell(view.level_text(dataset, case), float(dataset["force_level"][case]))
    begin += cell(str(dataset["output"].values[output])) if named else ""
    if peak is None:
        none = "not computed." if int(dataset["case_outcome"].values[case]) == Outcome.STOPPED else "no point converged."
        width = 3 + (order > 0) + len(limits) + has_fatigue(dataset)
        return f'<tr>{begin}<td colspan="{width}">{text(none)}</td></tr>'
    cells = [begin, cell(hertz(peak.frequency), peak.frequency, _note(dataset, case, peak))]
    if order:
        speed = 60.0 * peak.frequency / order
        cells.append(cell(f"{speed:.0f}", speed))
    cells += [cell(number(peak.amplitude / unit.metres), peak.amplitude), cell(unbroken(_sure(dataset, case, output, peak)))]
    cells += [cell(unbroken(_change(dataset, which, case, output))) for which in limits]
    if has_fatigue(dataset):
        margin = margins.get(case)
        cells.append(
            cell(number(margin.size, 3), margin.size, "" if margin.size >= 1.0 else "fails") if margin else cell(NOTHING)
        )
    return f"<tr>{''.join(cells)}</tr>"


def _note(dataset: xr.Dataset, case: int, peak: view.Peak) -> str:
    """Why the largest point of a curve is no peak."""
    if peak.local:
        return ""
    if view.is_listed(dataset):
        return "largest listed"
    ended = {Outcome.CONVERGED: "no peak in the band", Outcome.STOPPED: "not finished"}
    return ended.get(Outcome(int(dataset["case_outcome"].values[case])), "the curve broke off")


def _change(dataset: xr.Dataset, which: str, case: int, output: int) -> str:
    """Change of the amplitude and shift of the frequency against a linear resonance; of a peak, not of a largest point."""
    peak = view.highest_peak(dataset, case, output)
    linear = reference(dataset, which, case, peak, output) if peak is not None and peak.local else None
    if peak is None or linear is None:
        return NOTHING
    change, shift = peak.amplitude / linear[1] - 1.0, peak.frequency - linear[0]
    if abs(change) < SAME and abs(shift) < SAME * linear[0]:
        return "the same"
    sign, to = ("+" if value > 0.0 else "−" for value in (change, shift))
    moved = f"{to}{number(abs(shift), 3)} Hz" if abs(shift) >= SAME * linear[0] else "same frequency"
    return f"{sign}{percent(abs(change))}, {moved}"


def _sure(dataset: xr.Dataset, case: int, output: int, peak: view.Peak) -> str:
    """The largest estimate of error and what causes it; none of the last point of a curve that broke off on its way up."""
    if not peak.local and not view.is_listed(dataset) and int(dataset["case_outcome"].values[case]) != Outcome.CONVERGED:
        return "cannot be judged"
    unstable = "unstable; " if peak_is_unstable(dataset, case, output, peak.point) else ""
    return unstable + error_words(dataset, case, output)


def error_words(dataset: xr.Dataset, case: int, output: int) -> str:
    """The largest estimate of error of the highest peak of a curve, and what causes it."""
    errors = errors_of(dataset, case, output)
    if not errors:
        return "not estimated"
    source = max(errors, key=lambda name: errors[name])
    words = f"{percent(errors[source])}, {source}" if errors[source] >= LEAST else f"below {percent(LEAST)}"
    unknown = [SOURCES[name] for name in FINER if name in dataset and SOURCES[name] not in errors]
    return words + (f"; that of {' and '.join(unknown)} is unknown" if unknown else "")


MOST_FAILURES = 5
"""Failures listed in a summary."""


@SENTENCES.of("Result")
def summary(result: Result) -> list[str]:
    """The title, what came out in sentences, and what failed; where the analysis has no report, its table or what it
    holds."""
    dataset: xr.Dataset | None = getattr(result, "dataset", None)
    analysis = analysis_named(type(result).__name__)
    if dataset is None or analysis not in presentations():
        head = _titled(type(result).__name__, dataset)
        if dataset is None:
            return [head]
        variables = (f"{name} ({', '.join(map(str, variable.dims))})" for name, variable in dataset.data_vars.items())
        held = f"dataset: {', '.join(variables)}"
        if hasattr(result, "table"):
            units = {name: variable.attrs.get("units", "1") for name, variable in dataset.variables.items()}
            named = result.table().rename(columns={name: f"{name} [{unit}]" for name, unit in units.items() if unit != "1"})
            held = named.to_string(index=False, na_rep="", float_format="{:.6g}".format)
        return [head, *filter(None, (held, str(dataset.attrs.get("message", ""))))]
    presentation = presentations()[analysis]
    sentences = list(presentation.sentences(dataset))
    failures = [failure for failure in presentation.failures(dataset) if failure not in sentences]
    more = len(failures) - MOST_FAILURES
    return [
        _titled(presentation.title, dataset),
        *sentences,
        *(f"failed: {failure}" for failure in failures[:MOST_FAILURES]),
        *([f"failed: {more} more; the report has them"] if more > 0 else []),
    ]


@SENTENCES.of("Result", "page")
def summary_page(result: Result) -> str:
    """The same as HTML, with the figure of the result."""
    head, *lines = summary(result)
    return f"<p><b>{text(head)}</b></p><pre>{text(chr(10).join(lines))}</pre>{picture(result.plot(), head, 'png')}"


def _titled(name: str, dataset: xr.Dataset | None) -> str:
    title = "" if dataset is None else str(dataset.attrs.get("title", ""))
    return f"{name}: {title}" if title not in ("", name) else name
