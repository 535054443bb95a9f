"""The headline: CPU seconds of a sweep that is right, for both codes, each at the best of several settings, timed in turn.

Right: the highest of its points within 1e-3 of the peak, and the points joined by one interpolation rule within 1e-2 of the
peak's height of the exact curve everywhere in the band. Every setting that is tried is run on the whole band.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

import numpy as np
from accuracy import Errors, Reference, amplitudes, errors
from cases import CASES, Case
from channel import Side

ROUNDS = 3
SLOW = 20.0
"""CPU seconds of a sweep beyond which it is timed once more, not three times."""
REFERENCE_POINTS = 800
COMPARED = 40

STICKSLIP_SETTINGS: tuple[dict[str, Any], ...] = (
    {},
    {"largest": 0.4},
    {"largest": 0.3},
    {"largest": 0.2},
    {"largest": 0.1},
    {"error": 0.1},
    {"error": 0.06},
    {"error": 0.01},
    {"error": 0.005},
    {"error": 0.01, "largest": 0.3},
    {"error": 0.1, "largest": 1.0},
    {"cosine": 0.0},
    {"cosine": 0.0, "largest": 1.0},
    {"cosine": 0.0, "largest": 0.4},
    {"cosine": 0.0, "largest": 0.3},
    {"cosine": 0.0, "largest": 0.2},
    {"cosine": 0.0, "error": 0.01},
    {"cosine": 0.0, "error": 0.01, "largest": 0.3},
    {"cosine": 0.0, "error": 0.005},
)
"""Largest step, prediction error aimed at, and the cosine of the sharpest turn that one step may take."""

PYHARM_STEPS: dict[str, tuple[dict[str, Any], ...]] = {
    "B1 F=0.1": tuple({"ds": ds} for ds in (0.05, 0.07, 0.1, 0.12, 0.15, 0.2)),
    "B1 F=0.5": tuple({"ds": ds} for ds in (0.05, 0.1, 0.15, 0.2, 0.25, 0.3)),
    "B1 F=1": (*({"ds": ds} for ds in (0.15, 0.2, 0.25, 0.3)), *({"ds": ds, "length": 3.5} for ds in (0.05, 0.08, 0.1, 0.12))),
    "B1 F=2": (
        *({"ds": ds, "length": 37.0} for ds in (0.05, 0.07, 0.1, 0.12, 0.15)),
        *({"ds": ds, "length": 10.0} for ds in (0.2, 0.3)),
        {"ds": 1.0},
    ),
    "B2a": (*({"ds": ds} for ds in (0.8, 1.0, 1.2, 4.0)), *({"ds": ds, "length": 30.0} for ds in (0.05, 0.06, 0.08, 0.1))),
    "B2b": tuple({"ds": ds} for ds in (1.2, 1.5, 1.8)),
}
"""Largest steps; length: pyHarm's characteristic length, by which it divides displacements before it measures arc length."""

PYHARM_CORRECTORS = {"B1": ("arc_length", "pseudo_arc_length"), "B2a": ("arc_length",), "B2b": ("arc_length",)}

PYHARM_VARIANTS: dict[str, tuple[dict[str, Any], ...]] = {
    "B1": ({"solver": "NewtonRaphson"}, {"predictor": "secant"}, {"reductor": "NLdofs"}),
    "B2a": ({"solver": "NewtonRaphson"}, {"corrector": "pseudo_arc_length"}, {"predictor": "secant"}, {"reductor": "NLdofs"}),
    "B2b": ({"solver": "NewtonRaphson"},),
}
"""Tried on top of the best step. On B2b the pseudo-arc-length corrector and the secant predictor cost the same, the reduction
to nonlinear degrees of freedom 70 % more; a sweep takes half a minute there, so they are left out."""

LIMITS = {"B1": 4, "B2a": 40, "B2b": 150}
"""CPU seconds after which a sweep counts as not completed."""


@dataclass
class Trial:
    """One setting and what came of it."""

    settings: dict[str, Any]
    answer: dict[str, Any]
    errors: Errors = field(default_factory=lambda: Errors(np.inf, np.inf, np.inf, np.inf))

    @property
    def cpu(self) -> float:
        return float(self.answer.get("cpu", np.inf))

    @property
    def right(self) -> bool:
        return bool(self.answer.get("reached")) and self.errors.right

    def summary(self) -> dict[str, Any]:
        kept = ("cpu", "points", "iterations", "evaluations", "factorisations", "active", "refused", "failed", "reached")
        return {"settings": self.settings, **{k: v for k, v in self.answer.items() if k in kept}, **self.errors.as_dict()}


def headline(stickslip: Side, pyharm: Side, cases: tuple[Case, ...] = CASES) -> dict[str, Any]:
    """All cases: tune each code, time the best settings in turn, compare the answers."""
    return {case.name: _case(stickslip, pyharm, case) for case in cases}


def _case(stickslip: Side, pyharm: Side, case: Case) -> dict[str, Any]:
    reference = _reference(stickslip, case)
    warm_up(stickslip, pyharm, case)
    ours = [_try(stickslip, case, settings, reference) for settings in STICKSLIP_SETTINGS]
    theirs = [
        _try(pyharm, case, {**settings, "corrector": corrector}, reference)
        for settings in PYHARM_STEPS[case.name]
        for corrector in PYHARM_CORRECTORS[case.problem]
    ]
    step = _best(theirs).settings
    theirs += [
        _try(pyharm, case, step | variant, reference) for variant in PYHARM_VARIANTS[case.problem] if step | variant != step
    ]
    chosen = [_best(ours), _best(theirs)]
    times: list[list[float]] = [[], []]
    for _ in range(ROUNDS if chosen[1].cpu < SLOW else 1):
        for side, trial, found in zip((stickslip, pyharm), chosen, times, strict=True):
            found += [_try(side, case, trial.settings, reference).cpu for _ in range(ROUNDS if side is stickslip else 1)]
    return {
        "band": case.band,
        "peak": reference.peak,
        "peak_omega": reference.peak_omega,
        "stickslip": _side(chosen[0], times[0], ours) | {"whole_analysis": _whole(stickslip, case)},
        "pyHarm": _side(chosen[1], times[1], theirs) | {"difference": _difference(stickslip, case, chosen[1])},
        "ratio_of_sweeps": min(times[1]) / min(times[0]),
        "ratio_per_point": (min(times[1]) / chosen[1].answer["points"]) / (min(times[0]) / chosen[0].answer["points"]),
        "both_right": chosen[0].right and chosen[1].right,
        "curves": {
            "reference": [reference.omega.tolist(), reference.amplitude.tolist()],
            "stickslip": [chosen[0].answer["omega"], amplitudes(chosen[0].answer["motion"]).tolist()],
            "pyHarm": [chosen[1].answer["omega"], amplitudes(chosen[1].answer["motion"]).tolist()],
        },
    }


def warm_up(stickslip: Side, pyharm: Side, case: Case) -> None:
    """Compile before anything is timed."""
    stickslip.ask("sweep", case=case.name, settings={})
    low, high = case.band
    pyharm.ask("sweep", case=case.name, settings={"ds": 0.5}, band=(low, low + 0.02 * (high - low)), seconds=120)


def _reference(side: Side, case: Case) -> Reference:
    answer = side.ask("reference", case=case.name, count=REFERENCE_POINTS)
    if "failed" in answer:
        raise RuntimeError(f"No reference for {case.name}: {answer['failed']}")
    return Reference(np.array(answer["omega"]), np.array(answer["amplitude"]), answer["peak"], answer["peak_omega"])


def _try(side: Side, case: Case, settings: dict[str, Any], reference: Reference) -> Trial:
    answer = side.ask("sweep", case=case.name, settings=settings, seconds=LIMITS[case.problem])
    if not answer.get("motion"):
        return Trial(settings, answer)
    return Trial(settings, answer, errors(answer["omega"], amplitudes(answer["motion"]), reference))


def _best(trials: list[Trial]) -> Trial:
    """The cheapest right one; where none is right, the one with the smallest error of the curve."""
    right = [trial for trial in trials if trial.right]
    if right:
        return min(right, key=lambda trial: trial.cpu)
    return min(trials, key=lambda trial: max(trial.errors.of_peak, trial.errors.peak))


def _side(chosen: Trial, times: list[float], trials: list[Trial]) -> dict[str, Any]:
    points = chosen.answer["points"]
    peak_right = [trial.answer["points"] for trial in trials if trial.errors.peak <= 1e-3 and trial.answer.get("reached")]
    return {
        **chosen.summary(),
        "right": chosen.right,
        "cpu": min(times),
        "cpu_of_rounds": times,
        "cpu_per_point": min(times) / points,
        "points_for_peak": min(peak_right, default=None),
        "tried": [trial.summary() for trial in trials],
    }


def _whole(side: Side, case: Case) -> dict[str, Any]:
    """The second run of `forced_response` in a process: nothing left to compile."""
    side.ask("whole", case=case.name)
    return side.ask("whole", case=case.name)


def _difference(stickslip: Side, case: Case, trial: Trial) -> dict[str, Any]:
    """Largest difference of any harmonic, relative to the motion, at pyHarm's frequencies, solved exactly by stickslip."""
    omega, motion = np.array(trial.answer["omega"]), np.array(trial.answer["motion"])
    inside = np.flatnonzero((omega >= case.band[0]) & (omega <= case.band[1]))
    chosen = inside[np.unique(np.linspace(0, inside.size - 1, COMPARED).round().astype(int))]
    answer = stickslip.ask("exact", case=case.name, omega=omega[chosen].tolist())
    if "failed" in answer:
        return answer
    found = dict(zip(np.round(answer["omega"], 12), np.array(answer["motion"]), strict=True))
    pairs = [(motion[i], found[round(omega[i], 12)]) for i in chosen if round(omega[i], 12) in found]
    differences = [float(np.max(np.abs(a - b)) / np.max(np.abs(b))) for a, b in pairs]
    return {"frequencies": len(pairs), "largest": max(differences), "median": float(np.median(differences))}
