"""The search for bounds as independent cases: a stretch of neighbouring frequencies, or the peak, at one force level."""

from __future__ import annotations

import time
from collections.abc import Sequence
from dataclasses import dataclass, fields
from functools import cached_property
from typing import TYPE_CHECKING, Any, Literal

import numpy as np
from numpy.typing import NDArray
from threadpoolctl import threadpool_limits

from stickslip.analyses.forced_response import forced_response
from stickslip.analyses.variability.start_draws import search_cloud
from stickslip.analyses.work import Arrays, Tell
from stickslip.checks import Array, InputError, fault
from stickslip.harmonic.balance import HarmonicBalance
from stickslip.harmonic.cycle import contact_cycle
from stickslip.harmonic.energy import EnergyBalance
from stickslip.outcome import Outcome
from stickslip.problem import Problem
from stickslip.rigs import single_mass
from stickslip.solve.extreme_peak import AtPeak
from stickslip.solve.extremes import AtFrequency, Effort, Extreme, amplitude, extreme, leapt, loss_factor
from stickslip.solve.start_solutions import UnsolvedError
from stickslip.solve.start_space import Rule, Sharing, StartSpace
from stickslip.solve.start_states import explored_space

if TYPE_CHECKING:
    import xarray as xr

Target = Literal["amplitude", "loss_factor", "peak"]
BOUNDS, SIGNS = ("lower", "upper"), (-1.0, 1.0)

STRETCH = 8
"""Frequencies of one case: optima are handed on among them, there and back."""

NEIGHBOUR_GAIN = 1e-5
"""A neighbour's optimum begins another search where it is better by this share."""

PEAK_EFFORT = Effort(iterations=15, tolerance=1e-5, rounds=4, gain=1e-4)
"""At the peak every value takes some five solutions."""


@dataclass(frozen=True, eq=False)
class BoundsWork:
    """What to bound: frequencies in Hz (for the peak only their ends count), force levels, and how to search."""

    problem: Problem
    frequencies: tuple[float, ...]
    levels: tuple[float, ...]
    objective: Target
    output: int
    cloud: int
    starts: int
    rule: Rule
    share: Sharing
    seed: int
    harmonics: int
    samples: int

    def __post_init__(self) -> None:
        refuse_discs(self.problem)
        if self.objective not in ("amplitude", "loss_factor", "peak"):
            raise fault("objective", "must be amplitude, loss_factor or peak", self.objective)
        if not 0 <= self.output < len(self.problem.outputs):
            raise fault("output", f"must be 0 to {len(self.problem.outputs) - 1}", self.output)
        for name in ("cloud", "starts"):
            if getattr(self, name) < 0:
                raise fault(name, "must be at least 0", getattr(self, name))

    def __getstate__(self) -> dict[str, Any]:
        """What travels to a process: the data, not what was built from them."""
        return {field.name: getattr(self, field.name) for field in fields(self)}

    @cached_property
    def balance(self) -> HarmonicBalance:
        with threadpool_limits(1, user_api="blas"):
            return HarmonicBalance(self.problem, self.harmonics, self.samples)

    @property
    def stretches(self) -> list[tuple[float, ...]]:
        """The frequencies of the cases of one level."""
        if self.objective == "peak":
            return [(min(self.frequencies), max(self.frequencies))]
        return [self.frequencies[k : k + STRETCH] for k in range(0, len(self.frequencies), STRETCH)]

    @property
    def cases(self) -> list[tuple[float, tuple[float, ...]]]:
        """Level and frequencies of every case."""
        return [(level, stretch) for level in self.levels for stretch in self.stretches]

    @cached_property
    def names(self) -> tuple[str, ...]:
        """Everything that a case depends on."""
        how = f"{self.objective} of {self.output}, {self.cloud} {self.starts} {self.rule} {self.share} {self.seed}"
        how += f", {self.harmonics} harmonics, {self.samples} samples, problem {self.problem.fingerprint}"
        return tuple(f"bounds, level {level!r}, {stretch!r} Hz, {how}" for level, stretch in self.cases)

    @property
    def words(self) -> tuple[str, ...]:
        return tuple(f"force {level:g}, {stretch[0]:.4g} to {stretch[-1]:.4g} Hz" for level, stretch in self.cases)

    def prepare(self) -> None:
        """Compile the kernels, or load them from disk, with the smallest problem there is."""
        forced_response(single_mass(), [0.1], harmonics=1, samples=8)

    def solve(self, case: int, tell: Tell) -> Arrays:
        """The bounds of one case."""
        started = time.process_time()
        level, stretch = self.cases[case]
        ends = sorted({stretch[0], 0.5 * (stretch[0] + stretch[-1]), stretch[-1]})
        space = explored_space(self.balance, [2.0 * np.pi * f for f in ends], level, self.rule, self.share)
        search = Search(self, space, level)
        if self.objective == "peak":
            arrays = search.peak((2.0 * np.pi * stretch[0], 2.0 * np.pi * stretch[1]), tell)
        else:
            arrays = search.stretch(stretch, tell)
        return arrays | {"cpu_seconds": np.array(time.process_time() - started)}

    def gathered(self, results: Sequence[Arrays]) -> xr.Dataset:
        """All cases as one labelled dataset."""
        import xarray as xr

        per_level = len(self.stretches)
        data = {}
        for name, (dims, units, words) in VARIABLES.items():
            axis = dims.index("frequency")
            levels = [
                np.concatenate([r[name] for r in results[k : k + per_level]], axis=axis)
                for k in range(0, len(results), per_level)
            ]
            data[name] = (("case", *dims), np.stack(levels), {"units": units, "long_name": words})
        rows = [f"{contact.name} {d}" for contact in self.problem.contacts for d in contact.direction_names]
        frequencies = [np.nan] if self.objective == "peak" else list(self.frequencies)
        coords: dict[str, Any] = {"force_level": ("case", list(self.levels)), "bound": list(BOUNDS), "row": rows}
        coords["frequency"] = ("frequency", frequencies, {"units": "Hz", "long_name": "excitation frequency"})
        keys = ("objective", "rule", "share", "seed", "harmonics", "samples", "cloud", "starts")
        attrs: dict[str, Any] = {"title": self.problem.title, "output": self.problem.output_names[self.output]}
        attrs |= {key: getattr(self, key) for key in keys}
        attrs["cpu_seconds"] = sum(float(result["cpu_seconds"]) for result in results)
        return xr.Dataset(data, coords, attrs)


_B = ("bound", "frequency")
VARIABLES: dict[str, tuple[tuple[str, ...], str, str]] = {
    "amplitude": (_B, "m", "amplitude of the first harmonic"),
    "loss_factor": (_B, "1", "loss factor"),
    "resonance": (_B, "Hz", "frequency of the solution"),
    "outcome": (_B, "1", "what came of the search"),
    "start_variable": ((*_B, "variable"), "1", "start variable in [-1, 1]"),
    "start_value": ((*_B, "element"), "SI", "start value of each friction element"),
    "contact_motion": ((*_B, "row", "sample"), "m", "relative displacement of the contact over the period"),
    "contact_force": ((*_B, "row", "sample"), "N", "contact force over the period"),
    "sampled_amplitude": (("start", "frequency"), "m", "amplitude of sampled start states"),
    "sampled_loss_factor": (("start", "frequency"), "1", "loss factor of sampled start states"),
    "solves": (("frequency",), "1", "solutions computed"),
    "unsolved": (("frequency",), "1", "sampled start states without a solution"),
}


def refuse_discs(problem: Problem) -> None:
    """A search goes by the derivative with respect to the start state, which a friction disc does not have in closed form."""
    discs = [contact.name for contact in problem.contacts if contact.elements.coupled]
    if discs:
        raise InputError(
            f"Bounds must be of contacts with independent directions, but {discs[0]!r} is a friction disc: the derivative by its "
            "start state is not available. Use macroslip, or sample start states with response_samples."
        )


class Search:
    """One search: its start space, the cloud of start states it may begin from, and what it has found."""

    def __init__(self, work: BoundsWork, space: StartSpace, level: float) -> None:
        self.work, self.space, self.level = work, space, level
        self.balance = work.balance
        self.cloud = search_cloud(space.size, work.cloud, work.seed)
        self.energy = EnergyBalance(self.balance)
        self.rng = np.random.default_rng(work.seed)
        self.why_not = Outcome.NOT_CONVERGED

    def toward(self, sign: float) -> float:
        """The direction of the objective that a bound asks for: the upper bound of the response has the least loss factor."""
        return -sign if self.work.objective == "loss_factor" else sign

    def stretch(self, frequencies: Sequence[float], tell: Tell) -> dict[str, NDArray[Any]]:
        """Bounds at neighbouring frequencies: there, with the optimum handed on, and back, where a neighbour's is better."""
        target = loss_factor(self.energy) if self.work.objective == "loss_factor" else amplitude(self.work.output)
        places = [AtFrequency(self.balance, self.space, target, 2.0 * np.pi * f, self.level) for f in frequencies]
        clouds = [[self._point(place, variables) for variables in self.cloud] for place in places]
        best: list[list[Extreme | None]] = [[None] * len(places) for _ in BOUNDS]
        for k, place in enumerate(places):
            tell(k / len(places))
            for bound, sign in enumerate(SIGNS):
                before = best[bound][k - 1] if k else None
                begins = [] if before is None else [before.variables]
                best[bound][k] = self._extreme(place, sign, [*begins, *self._promising(clouds[k], sign)])
        for k in range(len(places) - 2, -1, -1):
            for bound, sign in enumerate(SIGNS):
                best[bound][k] = self._mended(places[k], sign, best[bound][k], best[bound][k + 1])
        arrays = self._arrays(best, clouds)
        arrays["solves"] = np.array([place.solves for place in places])
        return arrays

    def peak(self, band: tuple[float, float], tell: Tell) -> dict[str, NDArray[Any]]:
        """The highest and the lowest resonance peak."""
        place = AtPeak(self.balance, self.space, self.work.output, band, self.level)
        cloud: list[Extreme | None] = []
        for k, variables in enumerate(self.cloud):
            tell(0.4 * k / len(self.cloud))
            try:
                cloud.append(place.traced(variables)[0])
            except UnsolvedError as reason:
                self.why_not = reason.outcome
                cloud.append(None)
        best: list[list[Extreme | None]] = []
        for k, sign in enumerate(SIGNS):
            tell(0.4 + 0.3 * k)
            found = self._confirmed(place, self._extreme(place, sign, self._promising(cloud, sign), PEAK_EFFORT))
            solved = [each for each in (found, *cloud) if each is not None]
            best.append([max(solved, key=lambda each: sign * each.value, default=None)])
        arrays = self._arrays(best, [cloud])
        arrays["solves"] = np.array([place.solves])
        return arrays

    def _confirmed(self, place: AtPeak, found: Extreme | None) -> Extreme | None:
        """The peak that a whole curve from these start states has: the one followed may not be the highest."""
        try:
            return None if found is None else place.traced(found.variables)[0]
        except UnsolvedError:
            return found

    def _point(self, place: AtFrequency, variables: Array) -> Extreme | None:
        try:
            return place.point(variables)
        except UnsolvedError as reason:
            self.why_not = reason.outcome
            return None

    def _promising(self, cloud: Sequence[Extreme | None], sign: float) -> list[Array]:
        """The virgin start state and the best of the cloud."""
        others = [sample for sample in cloud[1:] if sample is not None]
        ranked = sorted(others, key=lambda sample: -self.toward(sign) * sample.value)
        return [self.cloud[0], *(sample.variables for sample in ranked[: self.work.starts])]

    def _extreme(
        self, place: AtFrequency | AtPeak, sign: float, begins: Sequence[Array], effort: Effort | None = None
    ) -> Extreme | None:
        try:
            found = extreme(place, self.toward(sign), begins, effort)
        except UnsolvedError:
            return None
        return leapt(place, self.toward(sign), found, self.rng, effort)

    def _mended(self, place: AtFrequency, sign: float, own: Extreme | None, neighbour: Extreme | None) -> Extreme | None:
        """The better one of the optimum and what the search finds from the neighbour's start state, where that looks better."""
        trial = None if neighbour is None else self._point(place, neighbour.variables)
        if trial is None:
            return own
        toward = self.toward(sign)
        if own is not None and toward * (trial.value - own.value) < NEIGHBOUR_GAIN * abs(own.value):
            return own
        found = self._extreme(place, sign, [trial.variables]) or trial
        return found if own is None or toward * (found.value - own.value) > 0.0 else own

    def _arrays(
        self, best: Sequence[Sequence[Extreme | None]], clouds: Sequence[Sequence[Extreme | None]]
    ) -> dict[str, NDArray[Any]]:
        balance, count = self.balance, len(clouds)
        sizes = {"bound": 2, "frequency": count, "variable": self.space.size, "element": self.space.group.size}
        sizes |= {"row": balance.rows, "sample": balance.tables.E.shape[0], "start": len(self.cloud)}
        arrays = {name: np.full([sizes[d] for d in dims], np.nan) for name, (dims, _, _) in VARIABLES.items()}
        arrays["outcome"] = np.full((2, count), Outcome.CONVERGED, dtype=np.int8)
        for bound, row in enumerate(best):
            for k, found in enumerate(row):
                if found is None:
                    arrays["outcome"][bound, k] = self.why_not
                else:
                    self._fill(arrays, (bound, k), found)
        for k, cloud in enumerate(clouds):
            arrays["unsolved"][k] = sum(sample is None for sample in cloud)
            for start, sample in enumerate(cloud):
                if sample is not None:
                    arrays["sampled_amplitude"][start, k] = self._amplitude(sample)
                    cycle = contact_cycle(sample.evaluation.table, balance.tables, sample.evaluation.w)
                    arrays["sampled_loss_factor"][start, k] = self.energy.at(sample.evaluation, cycle).loss_factor
        return arrays

    def _fill(self, arrays: dict[str, NDArray[Any]], at: tuple[int, int], found: Extreme) -> None:
        evaluation = found.evaluation
        cycle = contact_cycle(evaluation.table, self.balance.tables, evaluation.w)
        arrays["amplitude"][at] = self._amplitude(found)
        arrays["loss_factor"][at] = self.energy.at(evaluation, cycle).loss_factor
        arrays["resonance"][at] = evaluation.point.omega / (2.0 * np.pi)
        arrays["start_variable"][at], arrays["start_value"][at] = found.variables, self.space.values(found.variables)
        arrays["contact_motion"][at], arrays["contact_force"][at] = cycle.displacement, cycle.force

    def _amplitude(self, found: Extreme) -> float:
        return float(np.hypot(*found.evaluation.w[self.balance.rows + self.work.output, 1:3]))
