"""Which of several motions of one force level a machine shows: each highest peak, from rest and by slow sweeps up and down.

A slow sweep follows its curve while the frequency goes on in one direction. At a fold there is no motion beyond: time integration
from the motion at the fold, at a frequency one point further, ends on another one, from which the sweep goes on.
"""

from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from enum import IntEnum
from typing import Any, NamedTuple

import numpy as np

from stickslip.analyses.response_dataset import of_parts
from stickslip.analyses.solved_points import SolvedPoints, relative_distance, response_at
from stickslip.analyses.stability import flags_of
from stickslip.analyses.time_response import harmonics_of, time_response
from stickslip.model.problem import Problem
from stickslip.results.quantities import words_of_flags
from stickslip.results.schema import CurveKind, described, kinds_in, named
from stickslip.results.view import band_of, converged_points, highest_peak, is_listed, periods_of
from stickslip.solve.time.march import TimeStart, from_harmonics
from stickslip.support.checks import InputError
from stickslip.support.late import pd, xr
from stickslip.support.outcome import Outcome

SAME = 0.2
"""Relative distance of a motion in time from the nearest one of a curve up to which they are one: in resonance 500 steps a period
turn its phase by a tenth."""

SETTLED = 1e-3 * SAME
"""Distance from its periodic motion, relative, at which a motion in time ends."""

TOLERANCE = 1e-3
"""Error with which motions between points are known, as `ForcedResponse.at` has it; a fold is passed by that share of its
frequency at least."""

SWEEPS = {"sweep_up": 1, "sweep_down": -1}
"""Directions of the frequency."""


class Reached(IntEnum):
    """Whether a machine shows the highest peak of a curve; not known of a curve without one, either."""

    NOT_KNOWN = 0
    REACHED = 1
    NOT_REACHED = 2


class Place(NamedTuple):
    """A point of the curve of a case."""

    case: int
    point: int


@dataclass(eq=False)
class MotionsOfLevel:
    """The curves of one force level: frequency [Hz] and response X (points, outputs · (H+1)) of each case.

    unknown: by question ("from_rest", "sweep_up", "sweep_down"), why what follows is not known."""

    dataset: "xr.Dataset"
    problem: Problem
    cases: list[int]
    steps_per_period: int
    periods: int
    unknown: dict[str, str] = field(default_factory=dict)

    def __post_init__(self) -> None:
        self.solved = SolvedPoints(self.dataset, self.problem)
        self.level = float(self.dataset["force_level"].values[self.cases[0]])
        self.points = {case: converged_points(self.dataset, case) for case in self.cases}
        self.frequency = {case: self.dataset["frequency"].values[case, self.points[case]] for case in self.cases}
        parts = {case: self.dataset["response"].values[case, self.points[case]] for case in self.cases}
        self.response = {case: of_parts(each).reshape(len(each), -1) for case, each in parts.items()}

    def settled(self, question: str, frequency: float, start: TimeStart | None = None) -> Place | None:
        """The place of the curves on which time integration at a frequency ends, from rest unless a start is given; None where it
        does not become periodic, or ends on no curve."""
        harmonics = self.dataset.sizes["harmonic"] - 1
        time = time_response(
            self.problem.at_frequency(2.0 * np.pi * frequency),
            frequency,
            self.level,
            harmonics,
            steps_per_period=self.steps_per_period,
            tolerance=SETTLED,
            periods=self.periods,
            start=start,
        )
        if not time.periodic:
            repeats, after = time.cycle.repeats, f"not periodic after {time.cycle.periods} periods"
            self.unknown[question] = f"{f'a motion of {repeats} periods' if repeats else after} at {frequency:.5g} Hz"
            return None
        motion, nearest, least = harmonics_of(time.cycle.outputs, harmonics).ravel(), None, SAME
        for place, share in self._at(frequency):
            X, k = self.response[place.case], place.point
            apart = relative_distance(motion, (1.0 - share) * X[k] + share * X[min(k + 1, len(X) - 1)])
            if apart <= least:
                nearest, least = Place(place.case, k + round(share)), apart
        if nearest is None:
            self.unknown[question] = f"a motion of no curve at {frequency:.5g} Hz"
        return nearest

    def from_rest(self, peak: Place) -> bool | None:
        """Whether the motion that begins at rest at the frequency of a peak ends on it, or next to it on its curve."""
        place = self.settled("from_rest", float(self.frequency[peak.case][peak.point]))
        beside = place is not None and place.case == peak.case and abs(place.point - peak.point) <= 1
        return None if place is None else beside or self.passes({place}, peak)

    def passes(self, passed: set[Place], peak: Place) -> bool:
        """Whether the points that a sweep passes have the motion of a peak, which a curve may pass more than once."""
        f, X = self.frequency[peak.case], self.response[peak.case]
        own = (k for case, k in passed if case == peak.case and abs(f[k] - f[peak.point]) <= TOLERANCE * f[peak.point])
        return any(relative_distance(X[k], X[peak.point]) <= TOLERANCE for k in own)

    def next_lower(self, frequency: float, amplitude: float, output: int) -> float:
        """The largest |X₁| [m] at a frequency below that of a peak there, of all curves; NaN where there is none."""
        found = response_at(self.dataset.isel(case=self.cases), self.problem, [frequency], TOLERANCE)
        known = found["amplitude"].values[..., output].ravel()
        known = np.sort(known[np.isfinite(known)])
        # At a fold the motion below is next to the peak; a curve may also pass the peak again, to rounding.
        known = known[known <= (1.0 + TOLERANCE) * amplitude]
        lower = known[known < (1.0 - TOLERANCE**2) * known.max(initial=0.0)]
        return float(lower.max()) if lower.size else np.nan

    def swept(self, question: str) -> tuple[set[Place], float]:
        """The points that a slow sweep through the band passes, and the frequency beyond which they are not known.

        The solved curve begins at rest; where a sweep begins at its other end, time integration from rest says with which motion.
        """
        sign, passed = SWEEPS[question], set[Place]()
        begin, end = band_of(self.dataset)[::sign]
        sweep = next((case for case in self.cases if kinds_in(self.dataset)[case] == CurveKind.SWEEP), None)
        if sweep is None:
            self.unknown[question] = "no swept curve"
            return passed, begin
        f = self.frequency[sweep]
        broken = int(self.dataset["case_outcome"].values[sweep]) != Outcome.CONVERGED
        lost = f"the curve broke off at {f[-1]:.5g} Hz"
        place, reached = Place(sweep, 0) if abs(f[0] - begin) <= TOLERANCE * begin else None, begin
        if place is None and broken:
            self.unknown[question] = lost
        elif place is None:
            place = self.settled(question, begin)
        while place is not None and place not in passed:
            place = self._followed(place, sign, passed)
            f, k = self.frequency[place.case], place.point
            if broken and place == Place(sweep, f.size - 1):
                self.unknown[question] = lost
                return passed, float(f[k])
            step = max(abs(f[k] - f[max(k - 1, 0)]), abs(f[k] - f[min(k + 1, f.size - 1)]), TOLERANCE * f[k])
            reached = float(f[k] + sign * step)
            if sign * reached >= sign * end:
                return passed, sign * np.inf
            solved = self.solved.point(place.case, int(self.points[place.case][k]))
            start = from_harmonics(self.solved.balance, solved.forces, solved.omega, solved.level)
            place = self.settled(question, reached, start)
        return passed, reached

    def _at(self, frequency: float) -> Iterator[tuple[Place, float]]:
        """The points after which the curves pass a frequency, and by which share of the way to the next one."""
        for case, f in self.frequency.items():
            for k in np.flatnonzero((f[:-1] - frequency) * (f[1:] - frequency) <= 0.0):
                yield Place(case, int(k)), float((frequency - f[k]) / (f[k + 1] - f[k])) if f[k + 1] != f[k] else 0.0

    def _followed(self, place: Place, sign: int, passed: set[Place]) -> Place:
        """The last point of a curve whose frequency goes on in one direction; those on the way are passed."""
        f, X, k = self.frequency[place.case], self.response[place.case], place.point
        closed = f.size > 2 and abs(f[0] - f[-1]) <= TOLERANCE * f[0] and relative_distance(X[0], X[-1]) <= TOLERANCE

        def goes_on(to: int) -> bool:
            return bool((closed or 0 <= to < f.size) and sign * (f[to % f.size] - f[k % f.size]) > 0.0)

        passed.add(place)
        way = next((way for way in (1, -1) if goes_on(k + way)), 0)
        while way and goes_on(k + way):
            k += way
            passed.add(Place(place.case, k % f.size))
        return Place(place.case, k % f.size)


def reached(
    dataset: "xr.Dataset",
    problem: Problem,
    output: int,
    steps_per_period: int,
    periods: int,
    progress: Callable[[float, str], None] | None,
) -> "pd.DataFrame":
    """As `ForcedResponse.reached`."""
    if is_listed(dataset):
        raise InputError("`reached` needs a response over a band, but this one is at listed frequencies.")
    if periods_of(dataset) > 1:
        own = periods_of(dataset)
        raise InputError(f"`reached` needs a response with `periods` = 1, but the motion of this one may last {own} periods.")
    rows: list[dict[str, Any]] = []
    report = progress or (lambda fraction, text: None)
    levels = dataset["force_level"].values
    for level in dict.fromkeys(levels.tolist()):
        cases = np.flatnonzero(levels == level).tolist()
        motions = MotionsOfLevel(dataset, problem, cases, steps_per_period, periods)
        report(len(rows) / levels.size, f"sweeps at force level {level:g}")
        sweeps = {question: motions.swept(question) for question in SWEEPS}
        for case in cases:
            report(len(rows) / levels.size, f"peak at force level {level:g}")
            peak = highest_peak(dataset, case, output)
            if peak is None:
                continue
            place = Place(case, int(np.searchsorted(motions.points[case], peak.point)))
            amplitude = float(dataset["amplitude"].values[case, peak.point, output])
            row = {
                "case": case,
                "force_level": level,
                "curve": kinds_in(dataset)[case].name.lower(),
                "frequency": peak.frequency,
                "amplitude": amplitude,
                "next_lower": motions.next_lower(peak.frequency, amplitude, output),
                "stability": words_of_flags(dataset["highest_stability"], dataset["highest_stability"].values[case, [output]])[0],
            }
            if not peak.local and int(dataset["case_outcome"].values[case]) != Outcome.CONVERGED:
                rows.append(row | dict.fromkeys(("from_rest", *SWEEPS)) | {"unknown": "the curve ends before a peak"})
                continue
            row["from_rest"] = motions.from_rest(place)
            for question, (passed, known) in sweeps.items():
                before = SWEEPS[question] * peak.frequency < SWEEPS[question] * known
                row[question] = True if motions.passes(passed, place) else False if before else None
            if row["stability"] == "unstable":  # no motion stays there, though a curve leads to it
                row |= {question: False for question in ("from_rest", *SWEEPS) if row[question]}
            asked = [question for question in ("from_rest", *SWEEPS) if row[question] is None]
            row["unknown"] = "; ".join(f"{question}: {motions.unknown[question]}" for question in asked)
            rows.append(row)
    return pd.DataFrame(rows)


def with_reached(dataset: "xr.Dataset", table: "pd.DataFrame", output: int) -> "xr.Dataset":
    """A dataset with the table of `reached` for an output."""
    flag = {None: Reached.NOT_KNOWN, True: Reached.REACHED, False: Reached.NOT_REACHED}
    questions = ["from_rest", *SWEEPS]
    flags = np.zeros((dataset.sizes["case"], len(questions)), dtype=np.int8)
    lower, unknown = np.full(len(flags), np.nan), np.full(len(flags), "", dtype=object)
    for row in table.to_dict("records"):
        flags[row["case"]] = [flag[row[question]] for question in questions]
        lower[row["case"]], unknown[row["case"]] = row["next_lower"], row["unknown"]
    variables = {
        "reached": (("case", "question"), flags, flags_of("whether the highest peak is reached", Reached)),
        "question": named("question", questions, "how the highest peak may be reached"),
        **described("reached", {"next_lower": lower, "reached_unknown": unknown.astype(str)}),
    }
    return dataset.assign(variables).assign_attrs(output_reached=str(dataset["output"].values[output]))
