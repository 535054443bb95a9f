"""How often the warnings of a forced response are right, and how often their absence is, over the robustness classes.

    python -m robustness.calibration 12

Each random problem is computed as by default and with twice the harmonics and samples. A warning of
harmonics or samples is right where the highest peak changes by more than 0.2 %, half of what it warns from; its absence where it
changes by less than 1 %. A warning of the energy dissipated is right where that changes by more than 0.5 %, its absence below
4 %. An unstable highest peak is right where the multiplier of the finer solution, with all steps, lies outside the unit circle.
"""

from __future__ import annotations

import sys
import time
from collections import Counter
from typing import Any

import numpy as np

import stickslip as ss
from robustness.problems import CLASSES, Case, random_case
from stickslip.results.view import highest_peak

FEW, MANY = (5, 256), (11, 512)
RIGHT, ABSENT = {"peak": 0.002, "work": 0.005}, {"peak": 0.01, "work": 0.04}


def computed(case: Case, fineness: tuple[int, int]) -> ss.ForcedResponse:
    harmonics, samples = fineness
    return ss.forced_response(case.problem, case.band, case.level, harmonics=harmonics, samples=samples)


def of_peak(response: ss.ForcedResponse) -> tuple[float, float, int] | None:
    """Amplitude and dissipated energy of the highest peak, and its point; None without one inside the band."""
    peak = highest_peak(response.dataset, 0, 0)
    if peak is None or not peak.local or int(response.dataset["case_outcome"].values[0]) != 1:
        return None
    return peak.amplitude, float(np.nansum(response.dataset["dissipated"].values[0, peak.point])), peak.point


def counted(case: Case, counts: Counter[tuple[str, bool, bool]]) -> None:
    """Adds, for each warning, whether it was given and whether that was right."""
    few, many = computed(case, FEW), computed(case, MANY)
    ends = of_peak(few), of_peak(many)
    if ends[0] is None or ends[1] is None:
        return
    (size, work, _), (true_size, true_work, point) = ends
    said = str(few.dataset["case_message"].values[0])
    change = abs(size / true_size - 1.0)
    given = "harmonics would change" in said or "samples would change" in said
    counts.update([judged("harmonics or samples", given, change, "peak")])
    if max(work, true_work) > 1e-9 * true_size**2:
        of_work = abs(work - true_work) / max(work, true_work)
        counts.update([judged("dissipated energy", "The energy dissipated" in said, of_work, "work")])
    flag = int(few.dataset["highest_stability"].values[0, 0])
    if flag in (1, 2) and change < 0.02:
        whole = many.with_stability().dataset["stability"].values[0, point]
        counts[("unstable peak", flag == 2, int(whole) == flag)] += 1 if int(whole) in (1, 2) else 0
    unsolved = "could not be solved" in said
    counts[("places beside peaks", unsolved, (true_size > 1.01 * size) == unsolved)] += 1


def judged(name: str, given: bool, change: float, kind: str) -> tuple[str, bool, bool]:
    return name, given, change > RIGHT[kind] if given else change < ABSENT[kind]


def main(count: int, seconds: float = 1e9) -> None:
    counts: Counter[tuple[str, bool, bool]] = Counter()
    began, problems = time.process_time(), 0
    for seed in range(count):
        for kind in CLASSES:
            if time.process_time() - began > seconds:
                continue
            counted(random_case(kind, 5000 + seed), counts)
            problems += 1
            print(f"{problems} problems, {time.process_time() - began:.0f} CPU s", flush=True)
    print(f"{problems} problems, {time.process_time() - began:.0f} CPU s")
    for row in rows(counts):
        print(row)


def rows(counts: Counter[tuple[str, bool, bool]]) -> list[str]:
    """A Markdown table: given and right, absent and right."""
    found = ["| warning of | given, right | absent, right |", "| --- | --- | --- |"]
    for name in dict.fromkeys(key[0] for key in counts):
        cells: list[Any] = []
        for given in (True, False):
            right, wrong = counts[(name, given, True)], counts[(name, given, False)]
            cells.append(f"{right} of {right + wrong}" if right + wrong else "–")
        found.append(f"| {name} | {cells[0]} | {cells[1]} |")
    return found


if __name__ == "__main__":
    main(int(sys.argv[1]), *map(float, sys.argv[2:]))
