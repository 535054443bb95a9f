"""Search for the lowest and highest response at neighbouring frequencies, or of peaks at several force levels."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray

from stickslip.runs.work import Report
from stickslip.solve.balance.balance import Evaluation, HarmonicBalance
from stickslip.solve.balance.energy import EnergyBalance, contact_cycle
from stickslip.solve.balance.measure import Measure
from stickslip.solve.starts.extremes import Effort, Extreme, StartObjective, extreme, leapt
from stickslip.solve.starts.states import UnsolvedError
from stickslip.support.checks import Array
from stickslip.support.outcome import Outcome

BOUNDS, SIGNS = ("lower", "upper"), (-1.0, 1.0)
LOWER, UPPER = 0, 1

NEIGHBOUR_GAIN = 1e-5
"""A neighbour's optimum begins another search where it is better by this share."""

CONFIRMATIONS = 4
"""Searches in a row from one start state, each with the peak that turned out to be the highest in the last."""

SAME_PEAK = 1e-3
"""Relative difference up to which a followed peak is the highest one of the whole curve."""

MOST_UNSOLVED = 0.5
"""Where more than this share of the sampled start states has no solution there are no bounds: the rest are a biased few."""


class Searched(StartObjective, Protocol):
    """A place where start states are sampled too."""

    @property
    def solves(self) -> int:
        """Solutions computed so far."""

    def sample(self, variables: Array) -> Extreme:
        """What a start state gives, whatever is known of others; raises `UnsolvedError`."""

    def confirmed(self, found: Extreme, sign: float) -> Extreme | None:
        """What the start state found gives by itself, for the largest (sign 1) or smallest value; None where unknown."""


class BoundsSearch:
    """The search at neighbouring places, which hand their optima on to each other.

    cloud (starts, variables): start states sampled at every place; the `starts` best of them and the virgin one begin a search
    each. falling: the upper bound of the response is where the objective is least, as the loss factor is.
    """

    def __init__(
        self, places: Sequence[Searched], cloud: Array, starts: int, effort: Effort | None, seed: int, falling: bool = False
    ) -> None:
        self.places, self.cloud, self.starts, self.effort, self.falling = places, cloud, starts, effort, falling
        self.rng = np.random.default_rng(seed)
        self.reasons: list[Counter[Outcome]] = [Counter() for _ in places]
        self.samples: list[list[Extreme | None]] = []
        self.best: list[list[Extreme | None]] = [[None] * len(places) for _ in BOUNDS]

    def run(self, report: Report, bounds: Sequence[int] = (LOWER, UPPER)) -> None:
        """There, with the optimum of one place handed on to the next, and back, where a neighbour's is better."""
        for k in range(len(self.places)):
            self.samples.append([])
            for j, variables in enumerate(self.cloud):
                report((k + 0.4 * j / len(self.cloud)) / len(self.places))
                self.samples[k].append(self._sample(k, variables))
            for bound in bounds:
                report((k + 0.4 + 0.3 * bound) / len(self.places))
                self.best[bound][k] = self._first(k, bound)
        for k in range(len(self.places) - 2, -1, -1):
            for bound in bounds:
                self.best[bound][k] = self._mended(k, bound)

    def _toward(self, bound: int) -> float:
        """The direction of the objective that a bound asks for."""
        return -SIGNS[bound] if self.falling else SIGNS[bound]

    def _first(self, k: int, bound: int) -> Extreme | None:
        """The best of what the searches find from the optimum of the place before, the virgin state and the best of the cloud."""
        before, toward = self.best[bound][k - 1] if k else None, self._toward(bound)
        ranked = sorted((one for one in self.samples[k][1:] if one is not None), key=lambda one: -toward * one.value)
        begins = [] if before is None else [before.variables]
        found = self._found(k, toward, [*begins, self.cloud[0], *(one.variables for one in ranked[: self.starts])])
        return _best(toward, found, *self.samples[k])

    def _mended(self, k: int, bound: int) -> Extreme | None:
        """The better one of the optimum and what the search finds from the next place's start state, where that looks better."""
        own, after, toward = self.best[bound][k], self.best[bound][k + 1], self._toward(bound)
        trial = None if after is None else self._sample(k, after.variables)
        if trial is None or (own is not None and toward * (trial.value - own.value) < NEIGHBOUR_GAIN * abs(own.value)):
            return own
        return _best(toward, own, trial, self._found(k, toward, [trial.variables]))

    def _found(self, k: int, toward: float, begins: Sequence[Array]) -> Extreme | None:
        """What the searches from several start states find, and leaps away from the best of it; all of it confirmed."""
        place = self.places[k]
        best = _best(toward, *(self._confirmed(place, toward, begin) for begin in begins))
        if best is None:
            return None
        leap = leapt(place, toward, best, self.rng, self.effort)
        return best if leap is best else _best(toward, best, place.confirmed(leap, toward))

    def _confirmed(self, place: Searched, toward: float, begin: Array) -> Extreme | None:
        """What the search from a start state finds: where the peak that it followed is not the highest one in the end, the search
        goes on with that."""
        best: Extreme | None = None
        for _ in range(CONFIRMATIONS):
            try:
                found = extreme(place, toward, [begin], self.effort)
            except UnsolvedError:
                break
            known = place.confirmed(found, toward)
            if known is None or (best is not None and toward * (known.value - best.value) <= 0.0):
                break
            best, begin = known, known.variables
            if abs(known.value - found.value) <= SAME_PEAK * abs(found.value):
                break
        return best

    def _sample(self, k: int, variables: Array) -> Extreme | None:
        try:
            return self.places[k].sample(variables)
        except UnsolvedError as reason:
            self.reasons[k][reason.outcome] += 1
            return None

    def why_not(self, k: int) -> Outcome:
        """Why start states have no solution at a place, most often; `CONVERGED` where all have one."""
        return self.reasons[k].most_common(1)[0][0] if self.reasons[k] else Outcome.CONVERGED

    def unsolved_share(self, k: int) -> float:
        """The share of the sampled start states of a place that has no solution."""
        return sum(sample is None for sample in self.samples[k]) / len(self.samples[k])

    def outcome(self, bound: int, k: int) -> Outcome:
        """What came of a bound at a place."""
        if self.unsolved_share(k) > MOST_UNSOLVED:
            return Outcome.MOST_STARTS_UNSOLVED
        return Outcome.NOT_CONVERGED if self.best[bound][k] is None else Outcome.CONVERGED


def _best(toward: float, *found: Extreme | None) -> Extreme | None:
    return max((one for one in found if one is not None), key=lambda one: toward * one.value, default=None)


_B = ("bound", "frequency")
VARIABLES: dict[str, tuple[tuple[str, ...], str, str]] = {
    "amplitude": (_B, "m", "amplitude of the first harmonic"),
    "loss_factor": (_B, "1", "loss factor"),
    "resonance": (_B, "Hz", "frequency of the solution"),
    "outcome": (_B, "1", "outcome of the search"),
    "start_variable": ((*_B, "variable"), "1", "start variable in [-1, 1]"),
    "start_value": ((*_B, "element"), "SI", "start value of each friction element"),
    "contact_motion": ((*_B, "row", "sample"), "m", "relative displacement of the contact over the period"),
    "contact_force": ((*_B, "row", "sample"), "N", "contact force over the period"),
    "sampled_amplitude": (("start", "frequency"), "m", "amplitude of sampled start states"),
    "sampled_loss_factor": (("start", "frequency"), "1", "loss factor of sampled start states"),
    "solves": (("frequency",), "1", "solutions computed"),
    "unsolved": (("frequency",), "1", "sampled start states without a solution"),
    "unsolved_share": (("frequency",), "1", "share of the sampled start states without a solution"),
    "unsolved_outcome": (("frequency",), "1", "why most of them have none"),
}
"""What is found: dimensions, unit and meaning. The places of a search stand along frequency."""


def found_arrays(search: BoundsSearch, balance: HarmonicBalance, output: int, measure: Measure) -> dict[str, NDArray[Any]]:
    """What a search found, for a measure of an output."""

    def size(evaluation: Evaluation) -> float:
        point = evaluation.point
        return measure.size(evaluation.w[row], point.omega) / measure.per(point.level)

    space, count = search.places[0].space, len(search.places)
    sizes = {"bound": len(BOUNDS), "frequency": count, "variable": space.size, "element": space.group.size}
    sizes |= {"row": balance.rows, "sample": balance.tables.E.shape[0], "start": len(search.cloud)}
    arrays = {name: np.full([sizes[d] for d in dims], np.nan) for name, (dims, _, _) in VARIABLES.items()}
    outcomes = [[search.outcome(bound, k) for k in range(count)] for bound in range(len(BOUNDS))]
    arrays["outcome"] = np.array(outcomes, dtype=np.int8)
    arrays["unsolved_share"] = np.array([search.unsolved_share(k) for k in range(count)])
    arrays["unsolved_outcome"] = np.array([search.why_not(k) for k in range(count)], dtype=np.int8)
    arrays["solves"] = np.array([place.solves for place in search.places])
    energy, row = EnergyBalance(balance), balance.rows + output
    for at in np.ndindex(len(BOUNDS), count):
        found = search.best[at[0]][at[1]]
        if found is None or arrays["outcome"][at] != Outcome.CONVERGED:
            continue
        evaluation, values = found.evaluation, search.places[at[1]].space.values(found.variables)
        cycle = contact_cycle(evaluation.table, balance.tables, evaluation.w, evaluation.point.omega)
        arrays["amplitude"][at] = size(evaluation)
        arrays["loss_factor"][at] = energy.loss_factor(evaluation)
        arrays["resonance"][at] = evaluation.point.omega / (2.0 * np.pi)
        arrays["start_variable"][at], arrays["start_value"][at] = found.variables, values
        arrays["contact_motion"][at], arrays["contact_force"][at] = cycle.displacement, cycle.force
    for k, samples in enumerate(search.samples):
        arrays["unsolved"][k] = sum(sample is None for sample in samples)
        for start, sample in enumerate(samples):
            if sample is not None:
                arrays["sampled_amplitude"][start, k] = size(sample.evaluation)
                arrays["sampled_loss_factor"][start, k] = energy.loss_factor(sample.evaluation)
    return arrays
