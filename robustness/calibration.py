"""How often the warnings of a forced response are right, and how often their absence is, over the robustness classes.

python -m robustness.calibration [CASES PER CLASS] [CPU SECONDS]: computes cases until the seconds are spent, keeps each in
results/calibration.jsonl, and writes docs/calibration.md from all that are kept there: a run goes on where the last one ended.
Without the file it begins anew.

Each warning has a judge that does not use what the warning was made from:

* harmonics: a curve over the whole band with three times as many, both with four times as many samples;
* samples: a curve over the whole band with four times as many;
* energy dissipated: the curve with more of both;
* unstable motions: time integration begun on the motion, and the multiplier of the periodic motion that its steps have;
* places that could not be solved: a continuation of the same equations in steps a twentieth as long;
* listed peaks: whether the curve with four times as many samples has them too;
* another motion, in the whole band: integration in time from rest;
* another motion, in a narrow band around the highest peak of the whole one: that peak.
"""

from __future__ import annotations

import json
import re
import signal
import sys
import time
from collections import Counter
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass, replace
from functools import cached_property, partial
from pathlib import Path
from string import Template
from typing import Any

import numpy as np
from threadpoolctl import threadpool_limits

import stickslip as ss
from robustness.limits import TooLongError
from robustness.problems import CLASSES, Case, random_case
from robustness.run import HARMONICS, SAMPLES
from stickslip.results.view import converged_points, highest_peak, nearest_point
from stickslip.solve.balance.balance import HarmonicBalance
from stickslip.solve.continuation.steps import StepControl
from stickslip.solve.continuation.sweep import Sweep, sweep
from stickslip.solve.stability.multipliers import Stability
from stickslip.support.checks import Array
from stickslip.support.console import NOTICE
from stickslip.support.files import write_text
from stickslip.support.outcome import Outcome
from tools.commits import commit

ROOT = Path(__file__).parents[1]
KEPT = ROOT / "results" / "calibration.jsonl"
FIRST = 5000
"""Seeds from here on; other runs use those below."""

MORE_HARMONICS, MORE_SAMPLES = 15, 1024
PATIENCE = 15.0
"""CPU seconds after which a judge gives no judgement."""

NEAR, SAME_HEIGHT, LISTED = 0.03, 0.05, 0.01
"""Relative distances in frequency and height of two peaks that are the same; share of the highest from which one counts."""

PEAK, WORK = (0.002, 0.01), (0.005, 0.025)
"""Relative changes above which a warning is right, and below which its absence is."""

HIGHER = 1e-3
"""Share by which a peak must be higher than reported."""

ELSEWHERE = 0.1
"""Relative difference of amplitudes from which a motion in time is another one."""

WARNINGS = {
    "harmonics": ("more harmonics would change the highest peak", "whole band with 15 harmonics"),
    "samples": ("more samples would change the highest peak", "whole band with 1024 samples"),
    "energy dissipated": ("the energy dissipated would change", "whole band with both"),
    "places beside peaks": ("a peak may be higher where points could not be solved", "steps a twentieth as long"),
    "unstable at the highest peak": ("unstable motion at the highest peak", "time integration from that motion"),
    "unstable at the end": ("unstable motion at the end of the curve", "time integration from that motion"),
    "a listed peak": ("a peak is listed (absent: none is missing)", "whole band with 1024 samples"),
    "another motion, narrow band": ("another motion enters a narrow band", "the peak of the whole band"),
    "another motion": ("another motion enters the whole band", "time integration from rest, three frequencies"),
    "the curve ends where contacts open: more samples": ("the curve ended; more samples may help", "1024 samples"),
}
"""What each warning says, and its judge."""

STEPS, PERIODS = 500, 200
FINE = StepControl(largest=0.03, points=40000)

TEXT = Template("""\
# How reliable the warnings are

A forced response warns where its numbers may be wrong. A warning should be right in nine of ten cases; where there is no
warning, nothing should be wrong in 99 of 100 cases. `python -m robustness.calibration` measures both on the random problems of
[Robustness](robustness.md), with 5 harmonics and 256 samples, and writes this page. Each warning is judged by a computation
that does not use the numbers from which the warning was derived.

| warning | judge | given and right | absent and right |
| --- | --- | --- | --- |
$rows

Measured: $measured.

A warning about harmonics or samples counts as right if the judge finds that the height of the highest peak changes by more than
0.2 %; its absence counts as right if the change is below 1 %. For the energy dissipated these limits are 0.5 % and 2.5 %. The
warnings are given from estimated changes of 0.4 % and 1 % on. A peak counts as another one if it lies more than 3 % away in
frequency or 5 % in height; peaks below 1 % of the highest are not counted. A warning about a point beside a peak counts as right
if the curve is higher there by 0.1 %. Judges that took more than 15 s of processor time, and time integrations that did not
settle, gave no judgement.

Two rows are below the aim. An unstable highest peak is reported only if twice the harmonics confirm it. The remaining wrong
reports are those of motions in which a contact barely touches: there the multiplier of the integration does not exist, and the
integration settled on the reported motion. Other motions that no part of the curve passes are found only by searching for them,
for example with [samples of the start state](variability.md) or by [time integration](time.md) from other initial conditions.

The error along a curve, `point_truncation_error`, has a judge of its own: 41 harmonics on the same plane across the curve. It was
asked at 20 points of each curve, of all robustness classes and with sliders 10 to 1e5 times as stiff, for 3 and for 5 harmonics.
Of 719 points with an error above 0.4 % the estimate missed 9, of which one was above 2 % (a contact that barely touches). Of 741
points that it reported, 31 had no such error. `tests/robustness/test_point_errors.py` repeats it.
""")


@dataclass(frozen=True)
class Judgement:
    """One warning, or its absence, and whether that was right."""

    warning: str
    given: bool
    right: bool


@dataclass(frozen=True)
class Listed:
    """A peak: Hz, height, and energy dissipated in a period there."""

    frequency: float
    height: float
    work: float


class Judged:
    """A case with the response that is judged, and what judges it."""

    def __init__(self, case: Case) -> None:
        self.case = case
        self.response = self.computed(HARMONICS, SAMPLES)
        self.dataset = self.response.dataset
        self.message = str(self.dataset["case_message"].values[0])
        self.arrived = int(self.dataset["case_outcome"].values[0]) == Outcome.CONVERGED
        self.peak = highest_peak(self.dataset, 0, 0)

    def computed(self, harmonics: int, samples: int) -> ss.ForcedResponse:
        case = self.case
        return ss.forced_response(case.problem, case.band, case.level, harmonics=harmonics, samples=samples)

    @cached_property
    def sampled(self) -> ss.ForcedResponse | None:
        """With more samples alone."""
        return patiently(lambda: self.computed(HARMONICS, MORE_SAMPLES))

    @cached_property
    def finer(self) -> ss.ForcedResponse | None:
        """With more harmonics and samples."""
        return patiently(lambda: self.computed(MORE_HARMONICS, MORE_SAMPLES))

    def judgements(self) -> Iterator[Judgement]:
        """All that could be judged."""
        if self.arrived and self.peak is not None and self.peak.local:
            yield from self._of_harmonics()
            yield from self._of_samples()
            yield from self._of_work()
            yield from self._of_peaks()
            yield from self._of_stability("highest_stability", "unstable at the highest peak", self.peak.point)
        points = converged_points(self.dataset, 0)
        if points.size:
            yield from self._of_stability("end_stability", "unstable at the end", int(points[-1]))
            yield from self._of_places()
        if self.arrived:
            yield from self._of_other_motions()
        elif points.size and self.sampled is not None:
            advised = "Contacts open and close where it ended" in self.message
            arrives = int(self.sampled.dataset["case_outcome"].values[0]) == Outcome.CONVERGED
            yield Judgement("the curve ends where contacts open: more samples", advised, arrives == advised)

    @cached_property
    def own(self) -> Listed:
        """The highest peak."""
        return next(peak for peak in listed(self.dataset) if peak.frequency == self.peak.frequency)

    def same(self, response: ss.ForcedResponse | None) -> Listed | None:
        """The highest peak of a response near the highest of this one; None where its curve did not get there."""
        if response is None or int(response.dataset["case_outcome"].values[0]) != Outcome.CONVERGED:
            return None
        near = [peak for peak in listed(response.dataset) if abs(peak.frequency / self.own.frequency - 1.0) <= NEAR]
        return max(near, key=lambda peak: peak.height, default=Listed(self.own.frequency, 0.0, 0.0))

    def _of_harmonics(self) -> Iterator[Judgement]:
        few, many = self.same(self.sampled), self.same(self.finer)
        if few is not None and many is not None:
            change = apart(few.height, many.height)
            yield from by_change("harmonics", "harmonics would change" in self.message, change, PEAK)

    def _of_samples(self) -> Iterator[Judgement]:
        many = self.same(self.sampled)
        if many is not None:
            yield from by_change("samples", "samples would change" in self.message, apart(self.own.height, many.height), PEAK)

    def _of_work(self) -> Iterator[Judgement]:
        many = self.same(self.finer)
        if many is not None and max(many.work, self.own.work) > 1e-9 * self.case.level * self.own.height:
            change = apart(self.own.work, many.work)
            yield from by_change("energy dissipated", "The energy dissipated" in self.message, change, WORK)

    def _of_peaks(self) -> Iterator[Judgement]:
        if self.sampled is None or int(self.sampled.dataset["case_outcome"].values[0]) != Outcome.CONVERGED:
            return
        mine, finer = listed(self.dataset), listed(self.sampled.dataset)
        yield from (Judgement("a listed peak", True, among(peak, finer)) for peak in counted(mine))
        yield from (Judgement("a listed peak", False, False) for peak in counted(finer) if not among(peak, mine))

    def _of_stability(self, variable: str, warning: str, point: int) -> Iterator[Judgement]:
        flag = int(np.ravel(self.dataset[variable].values[0])[0])
        if flag in (Stability.STABLE, Stability.UNSTABLE):
            check = patiently(lambda: self.response.verify_in_time(0, point, steps_per_period=STEPS, periods=PERIODS))
            if check is not None and (np.isfinite(check.multiplier) or check.periodic):
                yield Judgement(warning, flag == Stability.UNSTABLE, check.unstable == (flag == Stability.UNSTABLE))

    def _of_places(self) -> Iterator[Judgement]:
        found = patiently(self._in_small_steps)
        if not isinstance(found, Sweep) or found.lost is not None or not self.arrived:
            return
        omegas = np.array([point.point.omega for point in found.points]) / (2.0 * np.pi)
        heights = np.array([np.hypot(*point.evaluation.w[-1, 1:3]) for point in found.points])
        places = re.search(r"could not be solved, near ([^H]*) Hz", self.message)
        if places is None:
            highest = float(np.nanmax(self.dataset["amplitude"].values[0, :, 0]))
            yield Judgement("places beside peaks", False, bool(heights.max() <= (1.0 + HIGHER) * highest))
            return
        where = [float(word) for word in places.group(1).replace(" ", "").split(",") if word != "..."]
        yield Judgement("places beside peaks", True, any(self._higher(omegas, heights, place) for place in where))

    def _in_small_steps(self) -> Any:
        balance = HarmonicBalance(self.case.problem, HARMONICS, SAMPLES)
        return sweep(
            balance, *(2.0 * np.pi * f for f in (self.case.band.start, self.case.band.stop)), self.case.level, control=FINE
        )

    def _higher(self, frequencies: Array, heights: Array, place: float) -> bool:
        """Whether the curve in small steps is higher near a place than the reported one."""
        near = [np.abs(each / place - 1.0) <= NEAR for each in (frequencies, self.dataset["frequency"].values[0])]
        known = np.nanmax(self.dataset["amplitude"].values[0, near[1], 0], initial=0.0)
        return bool(heights[near[0]].max(initial=0.0) > (1.0 + HIGHER) * known)

    def _of_other_motions(self) -> Iterator[Judgement]:
        frequency = self.dataset["frequency"].values[0]
        low, high = np.nanmin(frequency), np.nanmax(frequency)
        places = [low + share * (high - low) for share in (0.3, 0.7)]
        places += [self.peak.frequency] if self.peak is not None and self.peak.local else []
        given = "Another motion" in self.message
        tried = [patiently(partial(self._is_elsewhere, place)) for place in places]
        ended = [elsewhere for elsewhere in tried if elsewhere is not None]
        if ended:
            yield Judgement("another motion", given, given == any(ended))

    def _is_elsewhere(self, frequency: float) -> bool | None:
        """Whether time integration from rest ends in a periodic motion that the curve does not pass; None where it does not."""
        time_motion = ss.time_response(self.case.problem, frequency, self.case.level, steps_per_period=STEPS, periods=PERIODS)
        if not time_motion.periodic:
            return None
        amplitude = float(time_motion.dataset["amplitude"].values[0])
        known = self.response.at([frequency])["amplitude"].values[0, :, 0, 0]
        known = known[np.isfinite(known)]
        return bool(known.size) and bool(np.min(np.abs(known - amplitude)) > ELSEWHERE * max(amplitude, known.min()))


def listed(dataset: Any) -> list[Listed]:
    """The peaks of the first output."""
    found = []
    for frequency, height in zip(
        dataset["peak_frequency"].values[0, :, 0], dataset["peak_amplitude"].values[0, :, 0], strict=True
    ):
        if np.isfinite(frequency):
            point = nearest_point(dataset, 0, 0, float(frequency), float(height))
            found.append(Listed(float(frequency), float(height), float(np.nansum(dataset["dissipated"].values[0, point]))))
    return found


def counted(peaks: list[Listed]) -> list[Listed]:
    """Those of a height that matters."""
    highest = max((peak.height for peak in peaks), default=0.0)
    return [peak for peak in peaks if peak.height >= LISTED * highest]


def among(peak: Listed, others: list[Listed]) -> bool:
    """Whether a peak is among others."""
    return any(
        abs(other.frequency / peak.frequency - 1.0) <= NEAR and apart(other.height, peak.height) <= SAME_HEIGHT
        for other in others
    )


def apart(one: float, other: float) -> float:
    return abs(one - other) / max(abs(one), abs(other), 1e-300)


def by_change(warning: str, given: bool, change: float, limits: tuple[float, float]) -> Iterator[Judgement]:
    """Right where a change is more than the first limit; its absence where it is less than the second."""
    yield Judgement(warning, given, bool(change > limits[0] if given else change < limits[1]))


def patiently(compute: Callable[[], Any]) -> Any:
    """What a judge finds, or None where that takes too long."""
    try:
        with limited(PATIENCE):
            return compute()
    except (TooLongError, ss.InputError):
        return None


@contextmanager
def limited(seconds: float) -> Iterator[None]:
    """Raises `TooLongError` after so many CPU seconds; a kernel that is being compiled is waited for, as it cannot be left half
    done."""

    def stop(*_: object) -> None:
        if NOTICE.compiling:
            signal.setitimer(signal.ITIMER_VIRTUAL, 1.0)
        else:
            raise TooLongError

    before = signal.signal(signal.SIGVTALRM, stop)
    signal.setitimer(signal.ITIMER_VIRTUAL, seconds)
    try:
        yield
    finally:
        signal.setitimer(signal.ITIMER_VIRTUAL, 0.0)
        signal.signal(signal.SIGVTALRM, before)


def of_narrow_bands(case: Case) -> Iterator[Judgement]:
    """A band of 3 % on either side of the highest peak of the whole band: is a higher motion there told where there is one?"""
    whole = patiently(lambda: Judged(case))
    if whole is None or not whole.arrived or whole.peak is None or not whole.peak.local:
        return
    band = ss.Band((1.0 - NEAR) * whole.peak.frequency, (1.0 + NEAR) * whole.peak.frequency)
    narrow = patiently(lambda: Judged(replace(case, band=band)))
    if narrow is not None and narrow.arrived:
        higher = whole.peak.amplitude > 1.05 * float(np.nanmax(narrow.dataset["amplitude"].values[0, :, 0]))
        given = "Another motion" in narrow.message
        yield Judgement("another motion, narrow band", given, higher == given)


PARTS: dict[str, Callable[[Case], Iterator[Judgement]]] = {
    "narrow bands": of_narrow_bands,
    "curves": lambda case: Judged(case).judgements(),
}


def main(count: int, seconds: float) -> None:
    KEPT.parent.mkdir(exist_ok=True)
    now = commit("src", "robustness")
    known = {(row["part"], row["kind"], row["seed"]) for row in stored()}
    for part, judgements in PARTS.items():
        began = time.process_time()
        for seed in range(FIRST, FIRST + count):
            for kind in CLASSES:
                if (part, kind, seed) in known or time.process_time() - began > seconds / len(PARTS):
                    continue
                started = time.process_time()
                found = [vars(judgement) for judgement in judgements(random_case(kind, seed))]
                row = {"commit": now, "part": part, "kind": kind, "seed": seed, "seconds": time.process_time() - started}
                with KEPT.open("a") as file:
                    file.write(json.dumps(row | {"judgements": found}) + "\n")
    write_text(ROOT / "docs" / "calibration.md", page(stored()))


def stored() -> list[dict[str, Any]]:
    """All rows that are kept, of this and of earlier commits."""
    return [json.loads(line) for line in KEPT.read_text().splitlines()] if KEPT.is_file() else []


def page(rows: list[dict[str, Any]]) -> str:
    """The page of the documentation."""
    counts = Counter((each["warning"], each["given"], each["right"]) for row in rows for each in row["judgements"])
    lines = []
    for name, (meaning, judge) in WARNINGS.items():
        cells = [meaning, judge]
        for given in (True, False):
            right, wrong = counts[(name, given, True)], counts[(name, given, False)]
            if name == "a listed peak" and not given:  # those of the finer curve that are listed
                right = counts[(name, True, True)]
            cells.append(f"{right} of {right + wrong}" if right + wrong else "–")
        lines.append(f"| {' | '.join(cells)} |")
    problems = Counter((row["part"], row["commit"]) for row in rows)
    measured = "; ".join(f"{part}, {count} problems at commit `{name}`" for (part, name), count in problems.items())
    return TEXT.substitute(rows="\n".join(lines), measured=measured)


if __name__ == "__main__":
    with threadpool_limits(1, user_api="blas"):
        main(int(sys.argv[1]) if len(sys.argv) > 1 else 25, float(sys.argv[2]) if len(sys.argv) > 2 else 1e9)
