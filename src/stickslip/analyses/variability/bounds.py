"""Bounds of response variability: the highest and lowest response over all admissible start states.

At every frequency the amplitude itself is maximised and minimised, or the loss factor as its proxy; or the resonance peak, which
is what a designer needs: at a fixed frequency the lowest response is often only a resonance moved elsewhere.

The loss factor is the objective of "An Experimental and Computational Comparison of the Dynamic Response Variability in a
Turbine Blade with Under-Platform Dampers", equations 7 to 11.

The search at neighbouring frequencies, or of peaks at several force levels, as independent cases.

Bounds and nominal response in one dataset, for one results file and one report.
"""

import time
from collections import Counter
from collections.abc import Sequence
from dataclasses import KW_ONLY, dataclass
from functools import cached_property, partial
from typing import Annotated, Any, Literal, get_args

import numpy as np
from numpy.typing import NDArray

from stickslip.analyses.forced_response import compile_forced_response
from stickslip.analyses.peak_shapes import SETTLED, own_shapes_change, scaled
from stickslip.analyses.response_dataset import levels_are_newtons
from stickslip.analyses.settings import (
    AtLevels,
    Execution,
    ForceLevels,
    MeasuredOutput,
    OneBalance,
    OneOf,
    ProblemWithShapes,
    Rule,
    Sampled,
    Seed,
    Setting,
    Share,
    Whole,
    output_of,
    takes,
)
from stickslip.analyses.variability.samples import search_cloud
from stickslip.model.problem import Problem
from stickslip.model.problem.meshed import with_forces
from stickslip.results.schema import ATTRIBUTE, Result, named, variables_in
from stickslip.runs.cases import Arrays, Report, all_cases
from stickslip.solve.balance.balance import Evaluation, HarmonicBalance
from stickslip.solve.balance.energy import EnergyBalance, contact_cycle
from stickslip.solve.balance.fourier import attribute
from stickslip.solve.balance.measure import Measure
from stickslip.solve.peaks.search import SAME_PEAK
from stickslip.solve.starts.extremes import AtFrequency, AtPeak, Effort, Extreme, Place, extreme, leapt, loss_factor, size_of
from stickslip.solve.starts.states import UnsolvedError, explored_space, refuse_forgetful, rule_words
from stickslip.support.checks import Array, InputError, fault
from stickslip.support.late import xr
from stickslip.support.outcome import Outcome
from stickslip.support.units import Band, listed

BOUNDS, SIGNS = ("lower", "upper"), (-1.0, 1.0)
LOWER, UPPER = 0, 1

NEIGHBOUR_GAIN = 1e-5
"""A neighbour's optimum begins another search where it is better by this share."""

CONFIRMATIONS = 4
"""Searches in a row from one start state, each with the peak that turned out to be the highest in the last."""

MOST_UNSOLVED = 0.5
"""Where more than this share of the sampled start states has no solution there are no bounds: the rest are a biased few."""


class BoundsSearch:
    """The search at neighbouring places, which hand their optima on to each other.

    cloud (starts, variables): start states sampled at every place; the `starts` best of them and the virgin one begin a search
    each. falling: the upper bound of the response is where the objective is least, as the loss factor is.
    """

    def __init__(
        self, places: Sequence[Place], cloud: Array, starts: int, effort: Effort | None, seed: int, falling: bool = False
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

    def _confirmed(self, place: Place, toward: float, begin: Array) -> Extreme | None:
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


VARIABLES = variables_in("response_bounds")
"""What is found: dimensions, unit and meaning. The places of a search stand along frequency."""


def found_arrays(search: BoundsSearch, balance: HarmonicBalance, output: int, measure: Measure) -> dict[str, NDArray[Any]]:
    """What a search found, for a measure of an output."""

    def size(evaluation: Evaluation) -> float:
        point = evaluation.point
        return measure.size(evaluation.w[row], point.omega) / measure.per(point.level)

    space, count = search.places[0].space, len(search.places)
    sizes = {"bound": len(BOUNDS), "frequency": count, "variable": space.size, "element": space.group.size}
    sizes |= {"row": balance.rows, "sample": balance.tables.E.shape[0], "start": len(search.cloud)}
    known = [name for name in VARIABLES if name != "modal_error" or balance.problem.mesh is not None]
    arrays = {name: np.full([sizes[d] for d in VARIABLES[name][0]], np.nan) for name in known}
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
        if balance.problem.mesh is not None:
            place = search.places[at[1]]
            started, at_peak = partial(place.space.balance, variables=found.variables), isinstance(place, AtPeak)
            arrays["modal_error"][at] = own_shapes_change(found.balance, evaluation, output, measure, started, at_peak)
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


Target = Literal["amplitude", "loss_factor", "peak"]

STRETCH = 8
"""Frequencies of one case: optima are handed on among them, there and back."""

PEAK_EFFORT = Effort(iterations=15, tolerance=1e-5, rounds=4, gain=1e-4)
"""At the peak every value takes some five solutions."""

LEVELS = 3
"""Force levels of one case of the peak: there they are the neighbours that optima are handed on among."""


def _upwards(name: str, band: Any) -> Band | tuple[float, ...]:
    return band if isinstance(band, Band) else tuple(sorted(listed(band)))


@dataclass(frozen=True, eq=False)
class BoundsWork(OneBalance, AtLevels, Sampled, MeasuredOutput, Execution):
    """The search for bounds as independent cases: neighbouring frequencies at one level, or the peak at neighbouring levels."""

    problem: ProblemWithShapes
    band: Annotated[Band | Sequence[float], Setting(_upwards)]
    force: ForceLevels = 1.0
    objective: Annotated[
        Target, Setting(OneOf(get_args(Target)), "quantity that is bounded: at each frequency, or at the resonance")
    ] = "amplitude"
    _: KW_ONLY
    points: Annotated[int, Setting(Whole(2), "number of frequencies in the band")] = 25
    cloud: Annotated[int, Setting(Whole(0), "number of start states sampled at each frequency")] = 60
    starts: Annotated[int, Setting(Whole(0), "number of the best of these states, from each of which a search begins")] = 3
    rule: Rule = "slider_offset"
    share: Share = "element"
    seed: Seed = 0

    def __post_init__(self) -> None:
        super().__post_init__()
        refuse_discs(self.problem)
        output_of(self.problem, self.output)
        if self.objective == "peak" and len(self.frequencies) < 2:
            raise fault("band", "must be a band for the peak", self.band)

    @cached_property
    def frequencies(self) -> tuple[float, ...]:
        """In Hz, upwards; for the peak only their ends count."""
        if isinstance(self.band, Band):
            return tuple(np.linspace(self.band.low, self.band.high, self.points).tolist())
        return tuple(self.band)

    @property
    def cases(self) -> list[tuple[tuple[float, ...], tuple[float, ...]]]:
        """Force levels and frequencies of every case: neighbouring frequencies at one level, or a band at neighbouring levels."""
        if self.objective == "peak":
            band = (min(self.frequencies), max(self.frequencies))
            return [(self.levels[k : k + LEVELS], band) for k in range(0, len(self.levels), LEVELS)]
        stretches = [self.frequencies[k : k + STRETCH] for k in range(0, len(self.frequencies), STRETCH)]
        return [((level,), stretch) for level in self.levels for stretch in stretches]

    @cached_property
    def names(self) -> tuple[str, ...]:
        """Everything that a case depends on."""
        others = self.identity("band", "force")
        return tuple(f"bounds, levels {levels!r}, {stretch!r} Hz, {others}" for levels, stretch in self.cases)

    @property
    def words(self) -> tuple[str, ...]:
        return tuple(
            f"force {', '.join(f'{level:g}' for level in levels)}, {stretch[0]:.4g} to {stretch[-1]:.4g} Hz"
            for levels, stretch in self.cases
        )

    prepare = staticmethod(compile_forced_response)

    def solve(self, case: int, report: Report) -> Arrays:
        """The bounds of one case; on a mesh searched again with the shapes of the contact forces at the bounds, until these
        change by at most `SETTLED`, or no shapes are left that halve their error."""
        started, balance, before = time.process_time(), self.balance, np.inf
        while True:
            search = self.search(case, balance)
            search.run(report)
            arrays = found_arrays(search, balance, self.output, self.measured)
            error = np.nanmax(np.abs(arrays.get("modal_error", np.zeros(1))), initial=0.0)
            if error <= SETTLED or error > 0.5 * before:
                return arrays | {"cpu_seconds": np.array(time.process_time() - started)}
            before, found = error, [each for bound in search.best for each in bound if each is not None]
            problem = with_forces(balance.problem, np.hstack([scaled(each.evaluation.point.forces) for each in found]))
            if problem.structure.size == balance.problem.structure.size:
                return arrays | {"cpu_seconds": np.array(time.process_time() - started)}
            balance = HarmonicBalance(problem, self.harmonics, self.samples)

    def search(self, case: int, balance: HarmonicBalance) -> BoundsSearch:
        """The search of one case with a balance, before it runs."""
        levels, frequencies = self.cases[case]
        low, high = frequencies[0], frequencies[-1]
        three = [2.0 * np.pi * f for f in sorted({low, 0.5 * (low + high), high})]
        explored = partial(explored_space, balance, three, rule=self.rule, share=self.share)
        places: Sequence[Place]
        if self.objective == "peak":
            ends = (2.0 * np.pi * frequencies[0], 2.0 * np.pi * frequencies[1])
            places = [AtPeak(balance, explored(level=level), self.output, self.measured, ends, level) for level in levels]
        else:
            loss = self.objective == "loss_factor"
            target = loss_factor(EnergyBalance(balance)) if loss else size_of(self.output, self.measured)
            space, level = explored(level=levels[0]), levels[0]
            places = [AtFrequency(balance, space, target, 2.0 * np.pi * f, level) for f in frequencies]
        cloud = search_cloud(places[0].space.size, self.cloud, self.seed)
        effort = PEAK_EFFORT if self.objective == "peak" else None
        return BoundsSearch(places, cloud, self.starts, effort, self.seed, falling=self.objective == "loss_factor")

    def gathered(self, results: Sequence[Arrays]) -> "xr.Dataset":
        """All cases as one labelled dataset."""
        data, measured = {}, {"units": self.measured.reported_units(levels_are_newtons(self.problem))}
        for name in (each for each in VARIABLES if each in results[0]):
            dims, units, words = VARIABLES[name]
            axis = dims.index("frequency")
            places = np.concatenate([result[name] for result in results], axis=axis)
            data[name] = named(("case", *dims), np.stack(np.split(places, len(self.levels), axis)), words, units)
        for name, words in (
            ("amplitude", self.measured.words),
            ("sampled_amplitude", f"{self.measured.words}, of sampled start states"),
        ):
            data[name][2].update(measured, long_name=words)
        rows = [f"{contact.name} {d}" for contact in self.problem.contacts for d in contact.direction_names]
        frequencies = [np.nan] if self.objective == "peak" else list(self.frequencies)
        coords: dict[str, Any] = {"force_level": ("case", list(self.levels)), "bound": list(BOUNDS), "row": rows}
        coords["frequency"] = named("frequency", frequencies, "excitation frequency", "Hz")
        keys = ("objective", "share", "seed", "samples", "cloud", "starts")
        attrs: dict[str, Any] = {"title": self.problem.heading, "output": self.problem.output_names[self.output]}
        attrs["harmonics"] = attribute(self.harmonics)
        attrs |= {"rule": rule_words(self.rule)} | {key: getattr(self, key) for key in keys} | self.measured.attributes
        attrs["cpu_seconds"] = sum(float(result["cpu_seconds"]) for result in results)
        return xr.Dataset(data, coords, attrs)


def refuse_discs(problem: Problem) -> None:
    """A search goes by the derivative with respect to the start state, which a friction disc does not have in closed form, and
    which is nothing where a law forgets its start."""
    refuse_forgetful(problem)
    discs = [contact.name for contact in problem.contacts if contact.law.couples_directions]
    if discs:
        raise InputError(
            f"Bounds must be of contacts with independent directions, but {discs[0]!r} is a friction disc: the derivative by its "
            "start state is not available. Use macroslip, or sample start states with response_samples."
        )


@dataclass(frozen=True, eq=False, repr=False)
class ResponseBounds(Result):
    """`dataset`: amplitude, loss_factor, resonance, start states and contact forces by (case, bound, frequency), one case per
    force level; sampled_amplitude (case, start, frequency): the cloud that the search began with; unsolved_share (case,
    frequency): how much of it has no solution; solves spent. Where most has none, `outcome` says so and there are no bounds.

    For the peak there is one entry along frequency, and `resonance` says where the peak is.
    """

    dataset: "xr.Dataset"
    problem: Problem


@takes(BoundsWork)
def response_bounds(work: BoundsWork) -> ResponseBounds:
    """Highest and lowest response over the start states, at each frequency or at the peak, for one or several force levels.

    band: a `Band`, with `points` frequencies spread over it (for the peak: continued over), or frequencies in Hz.
    objective: "amplitude" of the output; "loss_factor", least for the upper and largest for the lower bound; "peak", the
    amplitude at the resonance. quantity, measure: what the amplitude is of, as for `forced_response`.
    cloud: start states sampled at every frequency, half of them corners; the `starts` best begin a search each, besides the
    virgin state and the optima of neighbouring frequencies, or force levels for the peak; leaps from what was found follow.
    rule: what a start variable sets, "slider_offset", "traction_ratio" or "mean_traction", or one for each tangential direction
    t1, t2: ("traction_ratio", "virgin") varies the ratio in the plane of a damper and leaves the sliders along its axis, where
    only friction holds it, at rest at 0.
    share: one variable per friction "element", per "direction", per "contact", or for "all" with the same rule.
    Gradients are exact; extremes are multimodal, so a bound is the best found.
    """
    return ResponseBounds(work.gathered(all_cases(work, work.checkpoint, work.workers, work.progress)), work.problem)


PREFIX = "bounds_"
_SHARED = {"case", "force_level"}


def attached(response: "xr.Dataset", bounds: "xr.Dataset") -> "xr.Dataset":
    """The response with the bounds of the same force levels; names and dimensions of the bounds begin with bounds_."""
    names = {str(name) for name in (*bounds.variables, *bounds.dims)} - _SHARED
    renamed = bounds.rename({name: PREFIX + name for name in names}).drop_vars("force_level")
    attrs = {PREFIX + str(key): value for key, value in bounds.attrs.items()}
    return response.assign(renamed.variables).assign_attrs(attrs)


def has_bounds(dataset: "xr.Dataset") -> bool:
    """Whether bounds are attached."""
    return PREFIX + "amplitude" in dataset.variables


def detached(dataset: "xr.Dataset") -> "xr.Dataset":
    """The bounds of a dataset, as `response_bounds` gives them."""
    names = [name for name in dataset.variables if str(name).startswith(PREFIX)]
    bounds = dataset[names]
    every = {str(name) for name in (*bounds.variables, *bounds.dims) if str(name).startswith(PREFIX)}
    bounds = bounds.rename({name: name.removeprefix(PREFIX) for name in every})
    bounds = bounds.assign_coords(force_level=("case", dataset["force_level"].values))
    bounds.attrs = {str(k).removeprefix(PREFIX): v for k, v in dataset.attrs.items() if str(k).startswith(PREFIX)}
    bounds.attrs |= {ATTRIBUTE: dataset.attrs[ATTRIBUTE]} if ATTRIBUTE in dataset.attrs else {}
    return bounds
