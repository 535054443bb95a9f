"""Which of several motions of one force level a machine shows: each highest peak, from rest and by slow sweeps up and down.

A slow sweep follows its curve while the frequency goes on in one direction. At a fold there is no motion beyond: time integration
from the motion at the fold, at a frequency one point further, ends on another one, from which the sweep goes on.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from stickslip.analyses.solved_points import SolvedPoints, response_at
from stickslip.analyses.time_response import harmonics_of, time_response
from stickslip.model.problem import Problem
from stickslip.results.schema import CurveKind, kinds_in
from stickslip.results.view import band_of, converged_points, highest_peak, is_listed, periods_of
from stickslip.solve.time.march import TimeStart, from_harmonics
from stickslip.support.checks import Array, InputError
from stickslip.support.late import pd, xr

SAME = 0.05
"""Relative distance of a motion in time from one of a curve up to which they are one: what harmonics and steps leave."""

SETTLED = 1e-3 * SAME
"""Distance from its periodic motion, relative, at which a motion in time ends."""

TOLERANCE = 1e-3
"""Error with which motions between points are known, as `ForcedResponse.at` has it."""

FURTHER = 1e-3
"""Share of its frequency by which a fold is passed, at least."""

Answer = bool | None
"""Whether a peak is reached; None where time integration did not become periodic, or ended on a motion of no known curve."""


@dataclass(frozen=True)
class Place:
    """A point of the curve of a case."""

    case: int
    point: int


@dataclass(eq=False)
class MotionsOfLevel:
    """The curves of one force level: frequency [Hz] and response X (points, outputs · (H+1)) of each case."""

    dataset: xr.Dataset
    problem: Problem
    cases: list[int]
    steps_per_period: int
    periods: int

    def __post_init__(self) -> None:
        self.solved = SolvedPoints(self.dataset, self.problem)
        low, high = band_of(self.dataset)
        self.ends = {1: high, -1: low}
        self.level = float(self.dataset["force_level"].values[self.cases[0]])
        self.points = {case: converged_points(self.dataset, case) for case in self.cases}
        self.frequency = {case: self.dataset["frequency"].values[case, self.points[case]] for case in self.cases}
        parts = {case: self.dataset["response"].values[case, self.points[case]] for case in self.cases}
        self.response = {case: (each[..., 0] + 1j * each[..., 1]).reshape(len(each), -1) for case, each in parts.items()}

    def settled(self, frequency: float, start: TimeStart | None) -> Array | None:
        """X of the motion that time integration ends on, (outputs · (H+1),); None where it does not become periodic."""
        harmonics = self.dataset.sizes["harmonic"] - 1
        whole = self.problem.at_frequency(2.0 * np.pi * frequency)
        time = time_response(
            whole,
            frequency,
            self.level,
            harmonics,
            steps_per_period=self.steps_per_period,
            tolerance=SETTLED,
            periods=self.periods,
            start=start,
        )
        return harmonics_of(time.cycle.outputs, harmonics).ravel() if time.periodic else None

    def from_rest(self, peak: Place) -> Answer:
        """Whether the motion that begins at rest at the frequency of a peak ends on it."""
        motion = self.settled(float(self.frequency[peak.case][peak.point]), None)
        return None if motion is None else _apart(motion, self.response[peak.case][peak.point]) <= SAME

    def landed(self, frequency: float, motion: Array) -> Place | None:
        """The place of the curves at a frequency that is nearest to a motion; None where none is near."""
        nearest, least = None, SAME
        for place, share in self._at(frequency):
            X, k = self.response[place.case], place.point
            apart = _apart(motion, (1.0 - share) * X[k] + share * X[k + 1])
            if apart <= least:
                nearest, least = Place(place.case, k + round(share)), apart
        return nearest

    def next_lower(self, frequency: float, amplitude: float, output: int) -> float:
        """The largest |X₁| [m] at a frequency below that of a peak there, of all curves; NaN where there is none."""
        found = response_at(self.dataset.isel(case=self.cases), self.problem, [frequency], TOLERANCE)
        known = found["amplitude"].values[..., output].ravel()
        known = np.sort(known[np.isfinite(known)])
        peak = int(np.searchsorted(known, (1.0 + TOLERANCE) * amplitude)) - 1  # at a fold the motion below is next to the peak
        return float(known[peak - 1]) if peak > 0 else np.nan

    def _at(self, frequency: float) -> Iterator[tuple[Place, float]]:
        """The points after which the curves pass a frequency, and by which share of the way to the next one."""
        for case, f in self.frequency.items():
            for k in np.flatnonzero((f[:-1] - frequency) * (f[1:] - frequency) <= 0.0):
                yield Place(case, int(k)), float((frequency - f[k]) / (f[k + 1] - f[k])) if f[k + 1] != f[k] else 0.0

    def swept(self, sign: int) -> tuple[set[Place], float]:
        """The points that a slow sweep through the band, up (1) or down (−1), passes, and the frequency beyond which they are not
        known."""
        sweep = next((case for case in self.cases if kinds_in(self.dataset)[case] == CurveKind.SWEEP), None)
        if sweep is None:
            return set(), -sign * np.inf
        f, passed = self.frequency[sweep], set[Place]()
        place = Place(sweep, 0 if sign * (f[-1] - f[0]) >= 0.0 else f.size - 1)
        while True:
            place = self._followed(place, sign, passed)
            f, k = self.frequency[place.case], place.point
            step = max(abs(f[k] - f[max(k - 1, 0)]), abs(f[k] - f[min(k + 1, f.size - 1)]), FURTHER * f[k])
            beyond = float(f[k] + sign * step)
            if sign * beyond >= sign * self.ends[sign]:
                return passed, sign * np.inf
            solved = self.solved.point(place.case, int(self.points[place.case][k]))
            motion = self.settled(beyond, from_harmonics(self.solved.balance, solved.forces, solved.omega, solved.level))
            landed = None if motion is None else self.landed(beyond, motion)
            if landed is None or landed in passed:
                return passed, beyond
            place = landed

    def _followed(self, place: Place, sign: int, passed: set[Place]) -> Place:
        """The last point of a curve whose frequency goes on in one direction; those on the way are passed."""
        f, X, k = self.frequency[place.case], self.response[place.case], place.point
        closed = f.size > 2 and abs(f[0] - f[-1]) <= FURTHER * f[0] and _apart(X[0], X[-1]) <= SAME

        def goes_on(to: int) -> bool:
            return bool((closed or 0 <= to < f.size) and sign * (f[to % f.size] - f[k % f.size]) > 0.0)

        passed.add(place)
        way = next((way for way in (1, -1) if goes_on(k + way)), 0)
        while way and goes_on(k + way):
            k += way
            passed.add(Place(place.case, k % f.size))
        return Place(place.case, k % f.size)


def reached(dataset: xr.Dataset, problem: Problem, output: int, steps_per_period: int, periods: int) -> pd.DataFrame:
    """As `ForcedResponse.reached`."""
    if is_listed(dataset) or periods_of(dataset) > 1:
        raise InputError(
            "What sweeps reach needs a response over a band whose motion repeats after one period of the excitation."
        )
    rows = []
    levels = dataset["force_level"].values
    for level in dict.fromkeys(levels.tolist()):
        cases = np.flatnonzero(levels == level).tolist()
        motions = MotionsOfLevel(dataset, problem, cases, steps_per_period, periods)
        sweeps = {name: motions.swept(sign) for name, sign in (("sweep_up", 1), ("sweep_down", -1))}
        for case in cases:
            peak = highest_peak(dataset, case, output)
            if peak is None:
                continue
            place = Place(case, int(np.searchsorted(motions.points[case], peak.point)))
            row = {"force_level": level, "curve": kinds_in(dataset)[case].name.lower(), "frequency": peak.frequency}
            own = float(dataset["amplitude"].values[case, peak.point, output])
            row |= {"amplitude": peak.amplitude, "next_lower": motions.next_lower(peak.frequency, own, output)}
            row["from_rest"] = motions.from_rest(place)
            for name, (passed, known) in sweeps.items():
                sign = 1 if name == "sweep_up" else -1
                row[name] = True if place in passed else False if sign * peak.frequency < sign * known else None
            rows.append(row)
    return pd.DataFrame(rows)


def _apart(motion: Array, other: Array) -> float:
    """How far a motion is from another, relative to it."""
    return float(np.linalg.norm(motion - other) / max(float(np.linalg.norm(other)), np.finfo(float).tiny))
