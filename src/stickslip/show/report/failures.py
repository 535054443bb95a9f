"""Failures grouped by cause: a sentence with count and frequencies for each force level."""

from __future__ import annotations

from collections.abc import Iterable
from typing import TYPE_CHECKING

import numpy as np

from stickslip.analyses.variability.bounds_dataset import detached, has_bounds
from stickslip.results.stability import is_unstable
from stickslip.results.view import higher_end, highest_peak, is_listed, level_text, points
from stickslip.show.report.numbers import hertz, percent
from stickslip.support.checks import counted
from stickslip.support.outcome import Outcome

if TYPE_CHECKING:
    import xarray as xr


def failures_of(dataset: xr.Dataset) -> list[str]:
    """One sentence a cause, one for each curve that has no points or stopped before the end of its band, and one for each
    force level without bounds; empty if none.
    """
    sentences, outcomes = [], dataset.outcome.values
    for code in sorted(set(outcomes.ravel().tolist()) - {int(Outcome.EMPTY), int(Outcome.CONVERGED)}):
        cases = np.flatnonzero(np.any(outcomes == code, axis=1)).tolist()
        where = [f"{level_text(dataset, case)}: {_ranges(dataset, case, code)}" for case in cases]
        count = int(np.count_nonzero(outcomes == code))
        sentences.append(f"{counted(count, 'point')}: {_sentence(code)} ({'; '.join(where)})")
    for case in range(dataset.sizes["case"]):
        if int(dataset.case_outcome[case]) != Outcome.CONVERGED:
            cause = str(dataset.case_message.values[case]).strip() or _sentence(int(dataset.case_outcome[case]))
            sentences.append(f"{level_text(dataset, case)}: the curve did not reach the end of the band. {cause}")
        elif not points(dataset, case).size:
            sentences.append(f"{level_text(dataset, case)}: no point was computed.")
    return sentences + (bounds_failures(detached(dataset)) if has_bounds(dataset) else [])


def bounds_failures(bounds: xr.Dataset) -> list[str]:
    """A sentence for each force level and cause where there are no bounds."""
    sentences, by_frequency = [], bool(np.all(np.isfinite(bounds["frequency"].values)))
    every = counted(bounds.sizes["frequency"], "frequency", "frequencies")
    for case, level in enumerate(bounds["force_level"].values):
        outcomes = bounds["outcome"].values[case]
        for code in sorted(set(outcomes.ravel().tolist()) - {int(Outcome.CONVERGED)}):
            at = np.flatnonzero(np.any(outcomes == code, axis=0))
            where = f"at {at.size} of {every}" if by_frequency else "of the peak"
            sentence, unsolved = f"force {level:g}: no bounds {where}. {_sentence(code)}", _unsolved(bounds, case, at)
            sentences.append(f"{sentence} {unsolved}." if unsolved else sentence)
    return sentences


def bounds_warnings(bounds: xr.Dataset) -> list[str]:
    """A sentence for each force level where bounds were found although some start states have no solution."""
    sentences = []
    for case, level in enumerate(bounds["force_level"].values):
        bounded = np.all(bounds["outcome"].values[case] == Outcome.CONVERGED, axis=0)
        at = np.flatnonzero(bounded & (bounds["unsolved_share"].values[case] > 0.0))
        if at.size:
            sentences.append(f"force {level:g}: {_unsolved(bounds, case, at)}. Bounds are over the others.")
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
            sentences.append(f"{level_text(dataset, case)}: {more}")
        for output, name in enumerate(dataset.output.values):
            peak = highest_peak(dataset, case, output)
            known = not is_listed(dataset) and int(dataset.case_outcome[case]) != Outcome.STOPPED
            if peak is not None and not peak.local and peak.amplitude > 0.0 and known:
                sentences.append(f"{level_text(dataset, case)}: {name} has no peak inside the band.")
            if peak is not None and is_unstable(dataset, case, peak.point) and "Unstable motion" not in more:
                sentences.append(
                    f"{level_text(dataset, case)}: the highest point of {name}, at {hertz(peak.frequency)} Hz, is an unstable "
                    "motion: a vibration does not stay there."
                )
            if end := higher_end(dataset, case, output):
                sentences.append(
                    f"{level_text(dataset, case)}: {name} is larger at an end of its curve, {hertz(end.frequency)} Hz, than at "
                    "any peak: a higher one may lie beyond."
                )
    return sentences + (bounds_warnings(detached(dataset)) if has_bounds(dataset) else [])


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
