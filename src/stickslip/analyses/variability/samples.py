"""Response variability: the responses of one problem for many start states, which differ only in their loading history.

Percentiles of the response over start states with a given distribution.

Sampling of start variables in [−1, 1]: Latin hypercube, random, corners, or a user's distribution.

A loading history as it is run: a sequence of force levels that carries the sliders from point to point, as in a test campaign.
"""

from __future__ import annotations

import time
import warnings
from collections.abc import Mapping, Sequence
from dataclasses import KW_ONLY, dataclass, field
from functools import cached_property, partial
from typing import Annotated, Any, Literal, Protocol, get_args

import numpy as np

from stickslip.analyses.forced_response import compile_forced_response
from stickslip.analyses.peak_shapes import own_shapes_error
from stickslip.analyses.response_dataset import curve_arrays, parts, response_dataset
from stickslip.analyses.settings import (
    AtLevels,
    Execution,
    ForceLevels,
    Measured,
    OneBalance,
    OneOf,
    OverBand,
    ProblemWithShapes,
    Rule,
    Sampled,
    Seed,
    Setting,
    Share,
    takes,
)
from stickslip.analyses.truncation import OWN_FORCES
from stickslip.model.problem import Problem
from stickslip.results.schema import Result, tabulated
from stickslip.results.view import measure_in, sizes
from stickslip.runs.cases import Arrays, Progress, Report, all_cases, checked_progress
from stickslip.solve.balance.balance import HarmonicBalance
from stickslip.solve.balance.energy import contact_cycle
from stickslip.solve.balance.fourier import attribute, complex_harmonics
from stickslip.solve.balance.measure import DISPLACEMENT_AMPLITUDE, Measure
from stickslip.solve.continuation.newton import Correction
from stickslip.solve.curves.curve import Curve, solve_curve, through_peaks
from stickslip.solve.starts import states
from stickslip.support.checks import Array, InputError, among, between, fault, nearest, numbers, of_kind, positive, seed_of
from stickslip.support.late import pd, xr
from stickslip.support.machine import one_blas_thread
from stickslip.support.outcome import Outcome
from stickslip.support.units import Band, in_order, listed

Method = Literal["latin", "random", "corners"]
MOST_CORNERS = 12
"""Up to so many variables all 2ⁿ corners are taken; beyond, a seeded subset."""


class Law(Protocol):
    """A distribution, as scipy.stats freezes them: a finite support is mapped onto [−1, 1], of others the part there counts."""

    def cdf(self, x: float) -> float:
        """The distribution function."""

    def ppf(self, q: Array) -> Array:
        """The inverse of the distribution function."""

    def support(self) -> tuple[float, float]:
        """Between which values it lies."""


def draw(size: int, starts: int | Array, method: Method = "latin", seed: int = 0, law: Law | None = None) -> Array:
    """Start variables (samples, size) in [−1, 1]; a number draws them, without a law the first one zero (virgin)."""
    among("method", method, get_args(Method))
    rng = np.random.default_rng(seed_of(seed))
    if not isinstance(starts, int | str) and isinstance(starts, np.ndarray | Sequence):
        given = numbers("starts", starts)
        if given.ndim != 2 or given.shape[1] != size or not len(given):
            raise fault("starts", f"must have shape (samples, {size}), with one sample at least", given.shape)
        outside = np.argwhere(~(np.abs(given) <= 1.0))
        if len(outside):
            row, column = outside[0].tolist()
            raise fault(f"starts[{row}, {column}]", "must lie in [-1, 1]", float(given[row, column]))
        return given
    starts = between("starts", starts, 1)
    if law is not None:
        if method == "corners":
            raise fault("method", "must be latin or random with a distribution", method)
        return _by_law(law, _shares(rng, size, starts, method))
    count = starts - 1
    drawn = _corners(rng, size, count) if method == "corners" else 2.0 * _shares(rng, size, count, method) - 1.0
    return np.vstack([np.zeros((1, size)), drawn])


def search_cloud(size: int, count: int, seed: int = 0) -> Array:
    """Start variables that a search may begin from (count + 1, size): virgin, half of them spread evenly, half at corners, where
    extremes often are.
    """
    corners = draw(size, count // 2 + 1, "corners", seed)[1:]
    return np.vstack([draw(size, count - len(corners) + 1, "latin", seed), corners])


def _shares(rng: np.random.Generator, size: int, count: int, method: Method) -> Array:
    """Numbers in [0, 1), (count, size): random ones, or a Latin hypercube, which has one of each column in each of `count` equal
    parts: McKay, Beckman and Conover, Technometrics 21 (1979) 239. scipy.stats has one too, but takes half a second to import.
    """
    if method != "latin":
        return rng.random((count, size))
    (own,) = rng.spawn(1)
    shares, parts = own.random((count, size)), np.tile(np.arange(1, count + 1), (size, 1))
    for column in parts:
        own.shuffle(column)
    return np.asarray((parts.T - shares) / count)


def _by_law(law: Law, shares: Array) -> Array:
    """Values in [−1, 1] at shares of a distribution."""
    if not all(callable(getattr(law, name, None)) for name in ("cdf", "ppf", "support")):
        raise fault("distribution", "must be a law as scipy.stats freezes them, say stats.beta(0.5, 0.5)", law)
    low, high = (float(end) for end in law.support())
    if not low < high:
        raise fault("distribution", "must have valid parameters and a support", (low, high))
    if np.isfinite(low) and np.isfinite(high):
        return np.asarray(np.clip(2.0 * (law.ppf(shares) - low) / (high - low) - 1.0, -1.0, 1.0))
    below, above = law.cdf(-1.0), law.cdf(1.0)
    if not above > below:
        raise fault("distribution", "must have weight between -1 and 1", f"one from {low:g} to {high:g} with none there")
    return np.asarray(np.clip(law.ppf(below + (above - below) * shares), -1.0, 1.0))


def named_law(name: str, parameters: Mapping[str, float]) -> Law:
    """A continuous distribution of scipy.stats by its name and its parameters there: "beta", {"a": 0.5, "b": 0.5}."""
    from scipy import stats

    known = [key for key, value in vars(stats).items() if isinstance(value, stats.rv_continuous)]
    if name not in known:
        raise fault("law", "must be a continuous distribution of scipy.stats", name, nearest(name, known))
    maker = getattr(stats, name)
    shapes = [shape.strip() for shape in (maker.shapes or "").split(",") if shape.strip()]
    missing, unknown = set(shapes) - set(parameters), set(parameters) - {*shapes, "loc", "scale"}
    if missing or unknown:
        raise fault("parameters", f"must be {', '.join([*shapes, 'loc, scale (with defaults)'])}", dict(parameters))
    law: Law = maker(**parameters)
    _by_law(law, np.array([0.5]))
    return law


def _corners(rng: np.random.Generator, size: int, count: int) -> Array:
    """All corners of the cube where they fit into `count`, else a seeded subset without repetition."""
    if size <= MOST_CORNERS:
        numbers = np.arange(2**size)
        numbers = numbers if len(numbers) <= count else np.sort(rng.choice(numbers, count, replace=False))
        return np.asarray(2.0 * ((numbers[:, None] >> np.arange(size)) & 1) - 1.0)
    return np.asarray(np.unique(rng.choice([-1.0, 1.0], (count, size)), axis=0))


PERCENT = (5.0, 25.0, 50.0, 75.0, 95.0)


def percentiles(dataset: xr.Dataset, percent: Sequence[float] = PERCENT, output: int = 0) -> xr.DataArray:
    """Percentiles of the amplitude of samples at each frequency, (force_level, percent, frequency), in m, m/s or m/s² as peaks
    are; `solved` (force_level, frequency) is how many start states they are of.

    Only of samples that were solved exactly at given frequencies: nothing is interpolated. NaN where no curve has a point.
    """
    if not has_percentiles(dataset):
        raise InputError(
            "Percentiles must be of curves at common frequencies, but these were continued over a band. "
            "Give response_samples a list of frequencies instead of a band; in a study, [response_samples] points."
        )
    if not all(0.0 <= p <= 100.0 for p in percent):
        raise fault("percent", "must lie between 0 and 100", list(percent))
    levels, wanted = np.unique(dataset["force_level"].values), dataset["wanted"].values
    amplitude = np.stack([_at(dataset, frequency, output) for frequency in wanted], axis=1)
    cases = [dataset["force_level"].values == level for level in levels]
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", RuntimeWarning)  # of a frequency at which no start state was solved
        table = np.stack([np.nanpercentile(amplitude[which], percent, axis=0) for which in cases])
    solved = np.stack([np.isfinite(amplitude[which]).sum(axis=0) for which in cases])
    coords = {"force_level": levels, "percent": list(percent), "frequency": wanted}
    coords["solved"] = (("force_level", "frequency"), solved)
    attrs = {"units": measure_in(dataset).units}
    return xr.DataArray(table, coords, ("force_level", "percent", "frequency"), "amplitude", attrs)


def has_percentiles(dataset: xr.Dataset) -> bool:
    """Whether the samples of a dataset were solved at common frequencies."""
    return "wanted" in dataset.variables and "start_variable" in dataset.variables


def _at(dataset: xr.Dataset, frequency: float, output: int) -> Array:
    """The amplitude of every case at a frequency, (case,); the largest where there are several, NaN where there is none."""
    here = np.abs(dataset["frequency"].values - frequency) <= 1e-9 * frequency
    measure, largest = measure_in(dataset), np.full(len(here), np.nan)
    for case, near in enumerate(here & (dataset["outcome"].values == Outcome.CONVERGED)):
        if near.any():
            largest[case] = np.max(sizes(dataset, case, output, measure, np.flatnonzero(near)))
    return largest


@dataclass(frozen=True, eq=False, repr=False)
class ResponseSamples(Result):
    """One curve per force level and start state: `dataset` as of a forced response, case = (level, start), with the coordinate
    start(case), and start_variable (case, variable), start_value (case, element).
    """

    dataset: xr.Dataset
    problem: Problem

    def percentiles(self, percent: Sequence[float] = PERCENT, output: int = 0) -> xr.DataArray:
        """Percentiles of the amplitude, see `stickslip.analyses.variability.samples`."""
        return percentiles(self.dataset, percent, output)

    def peaks(self, output: int = 0) -> pd.DataFrame:
        """The highest peak of every curve: force level, start, frequency [Hz], size, loss factor; the size in the column
        `amplitude`, `rms` or `max_abs`, as of `ForcedResponse.peaks`.
        """
        first = self.dataset.isel(peak=slice(0, 1), output=output)
        columns = {"force_level": first["force_level"].values, "start": first["start"].values}
        names = {"frequency": "frequency", "amplitude": measure_in(self.dataset).kind, "loss_factor": "loss_factor"}
        columns |= {name: first[f"peak_{key}"].values[:, 0] for key, name in names.items()}
        return pd.DataFrame(columns).dropna(ignore_index=True)


def _band_or_list(name: str, band: Any) -> Band | tuple[float, ...]:
    return band if isinstance(band, Band) else tuple(listed(band))


def _starts(name: str, starts: Any) -> int | Array:
    return numbers(name, starts) if isinstance(starts, np.ndarray | Sequence) else between(name, starts, 1)


@dataclass(frozen=True, eq=False)
class SamplesWork(OneBalance, AtLevels, OverBand, Sampled, Measured, Execution):
    """Samples as independent cases, one force level and start state each."""

    problem: ProblemWithShapes
    band: Annotated[Band | Sequence[float], Setting(_band_or_list)]
    force: ForceLevels = 1.0
    starts: Annotated[
        int | Array, Setting(_starts, "number of start states; the first is virgin unless `law` is given", key="count")
    ] = 20
    _: KW_ONLY
    method: Annotated[Method, Setting(OneOf(get_args(Method)), "method of drawing the start states")] = "latin"
    distribution: Law | None = None
    rule: Rule = "slider_offset"
    share: Share = "element"
    seed: Seed = 0
    variables: Array = field(init=False, repr=False)
    """Of all start states, in [−1, 1]."""
    explored: dict[float, tuple[states.StartSpace, Array | None]] = field(default_factory=dict, init=False, repr=False)
    """What was found of the start states, by level; it travels with the work."""

    def __post_init__(self) -> None:
        super().__post_init__()
        drawn = draw(self.size, self.starts, self.method, self.seed, self.distribution)
        object.__setattr__(self, "variables", drawn)

    @property
    def size(self) -> int:
        """Number of variables of a start state."""
        return states.number_of_variables(self.balance, self.rule, self.share)

    def explored_at(self, level: float) -> tuple[states.StartSpace, Array | None]:
        """The start states at a level, and the contact forces of the solution at the first frequency whose variables are zero, if
        it was found: the first point of each case is reached from there.
        """
        if level not in self.explored:
            ends = (self.frequencies[0], 0.5 * (self.frequencies[0] + self.frequencies[-1]), self.frequencies[-1])
            omegas = [2.0 * np.pi * frequency for frequency in ends]
            with one_blas_thread():
                virgin = states.virgin_solutions(self.balance, omegas, level)
                space = states.space_around(self.balance, virgin, self.rule, self.share)
            at_first = not space.prescribes and virgin[0].point.omega == omegas[0]
            self.explored[level] = space, virgin[0].point.forces if at_first else None
        return self.explored[level]

    @property
    def cases(self) -> list[tuple[float, int]]:
        """Level and start state of every case."""
        return [(level, start) for level in self.levels for start in range(len(self.variables))]

    @cached_property
    def names(self) -> tuple[str, ...]:
        """Everything that a curve depends on."""
        others = self.identity("force", "starts", "method", "distribution", "seed", "variables", "explored")
        return tuple(f"sample {self.variables[k].tolist()!r}, level {level!r}, {others}" for level, k in self.cases)

    @property
    def words(self) -> tuple[str, ...]:
        return tuple(f"force {level:g}, start state {k + 1}" for level, k in self.cases)

    def prepare(self) -> None:
        """Load the kernels and explore the start states, once for all processes."""
        for level in self.levels:
            self.explored_at(level)
        compile_forced_response()

    def solve(self, case: int, report: Report) -> Arrays:
        """The arrays of the curve of one level and start state."""
        started = time.process_time()
        level, start = self.cases[case]
        space, virgin = self.explored_at(level)
        where = (self.frequencies, level, self.listed)
        curve = start_curve(self.balance, space, self.variables[start], *where, report, self.measured, virgin)
        arrays = curve_arrays(self.balance, through_peaks(curve))
        if self.problem.mesh is not None:
            here = partial(space.balance, variables=self.variables[start])
            arrays["modal_error"] = own_shapes_error(here(self.balance), curve, self.measured, here)
        arrays["start_value"] = space.values(self.variables[start])
        return arrays | {"cpu_seconds": np.array(time.process_time() - started)}

    def gathered(self, curves: Sequence[Arrays]) -> ResponseSamples:
        """The samples of all cases."""
        attrs: dict[str, Any] = {
            "rule": states.rule_words(self.rule),
            "share": self.share,
            "seed": self.seed,
            "method": self.method,
            "title": self.problem.heading,
            "study": "",
            "harmonics": attribute(self.harmonics),
            "samples": self.samples,
        }
        attrs["cpu_seconds"] = sum(float(curve["cpu_seconds"]) for curve in curves)
        ends = (min(self.frequencies), max(self.frequencies))
        ends = ends if ends[0] < ends[1] else (0.9 * ends[0], 1.1 * ends[0])
        with one_blas_thread():
            dataset = response_dataset(self.balance, [level for level, _ in self.cases], curves, ends, attrs, self.measured)
        numbers = [start for _, start in self.cases]
        values = np.array([curve["start_value"] for curve in curves])
        dataset = with_starts(dataset, "case", self.variables[numbers], values).assign_coords(start=("case", numbers))
        if self.problem.mesh is not None:
            errors = np.array([curve["modal_error"] for curve in curves])
            dataset["modal_error"] = ("case", "output"), errors, OWN_FORCES.attributes
        return ResponseSamples(dataset.assign(wanted=list(self.frequencies)) if self.listed else dataset, self.problem)


@takes(SamplesWork)
def response_samples(work: SamplesWork) -> ResponseSamples:
    """Curves over a band, or at frequencies in Hz, for many start states, at one or several force levels.

    Each start state is the same along its curve.

    starts: number of start states to draw, or variables in [−1, 1] as an array (samples, variables); the first drawn one is
    virgin (zeros) unless a distribution is given.
    method: "latin" hypercube, "random", or "corners" (beyond 12 variables a seeded subset).
    distribution: a frozen distribution of scipy.stats for every variable; default uniform. A finite support, as of
    beta(0.5, 0.5), is mapped onto [−1, 1]; of other laws, such as norm(0, 0.4), only the part between −1 and 1 is used.
    rule: what a variable sets (see `model/contact/point.py`), or one rule for each tangential direction, of which "virgin" sets
    nothing; an offset of ±1 is the largest that any solution allows.
    share: one variable per friction "element", per "direction", per "contact", or for "all".
    quantity, measure: what the peaks are of, as for `forced_response`.
    """
    return work.gathered(all_cases(work, work.checkpoint, work.workers, work.progress))


def start_curve(
    balance: HarmonicBalance,
    space: states.StartSpace,
    variables: Array,
    frequencies: Sequence[float],
    level: float,
    exactly: bool,
    report: Report = lambda fraction: None,
    measure: Measure = DISPLACEMENT_AMPLITUDE,
    virgin: Array | None = None,
) -> Curve:
    """The curve of one start state, its first point reached from that of variables 0: far-off states have no other way in.

    virgin: contact forces of that point, if they are known; else it is solved.
    """
    omegas = [2.0 * np.pi * frequency for frequency in frequencies]
    begin = states.StartSolutions(balance, space, omegas[0], level)
    try:
        if virgin is None:
            begin.solve(np.zeros(space.size))
        else:
            begin.remember(np.zeros(space.size), virgin)
        point = begin.solve(variables)[1].point
    except states.UnsolvedError as reason:
        if reason.outcome == Outcome.BODY_HELD_BY_NOTHING:
            return Curve(level, (), reason.outcome, str(reason), omegas[0], measure=measure)
        return solve_curve(space.balance(balance, variables), omegas, level, exactly, report, measure=measure)
    return solve_curve(space.balance(balance, variables), omegas, level, exactly, report, begin=point, measure=measure)


def with_starts(dataset: xr.Dataset, axis: str, variables: Array, values: Array) -> xr.Dataset:
    """The dataset with the start states that made it."""
    dataset = dataset.assign(start_variable=((axis, "variable"), variables), start_value=((axis, "element"), values))
    dataset["start_variable"].attrs = {"units": "1", "long_name": "start variable in [-1, 1]"}
    dataset["start_value"].attrs = {"units": "SI", "long_name": "start value of each friction element"}
    return dataset


UP_AND_DOWN = (1.0, 5.0, 20.0, 50.0, 80.0, 100.0, 80.0, 50.0, 20.0, 5.0, 1.0)
"""The history of the published experiment, N: from 1 to 100 N and back."""


@dataclass(frozen=True, eq=False, repr=False)
class ResponseHistory(Result):
    """`dataset`: one run per force level in the order of time: amplitude, response and contact cycles of every point by
    (run, frequency, ...), the frequency and amplitude of each run's largest point, slider positions at its end.
    """

    dataset: xr.Dataset
    problem: Problem

    def runs_at(self, level: float) -> list[int]:
        """The runs at a force level, in order of time."""
        found = np.flatnonzero(np.isclose(self.dataset["force_level"].values, level))
        if not found.size:
            raise fault("level", f"must be one of {sorted(set(self.dataset['force_level'].values.tolist()))}", level)
        return [int(run) for run in found]

    def change(self, level: float, output: int = 0) -> dict[str, float]:
        """What a history does to a level: relative change of its largest amplitude, change of its frequency [Hz], and largest
        change of a mean tangential contact force [N], from the first run at that level to the last.
        """
        first, *_, last = self.runs_at(level) * (1 if len(self.runs_at(level)) > 1 else 2)
        d = self.dataset
        amplitudes, hertz = d["largest_amplitude"].values[:, output], d["largest_frequency"].values[:, output]
        mean = d["largest_contact_force"].values.mean(axis=-1)
        return {
            "amplitude": float(amplitudes[last] / amplitudes[first] - 1.0),
            "frequency": float(hertz[last] - hertz[first]),
            "mean_force": float(np.nanmax(np.abs(mean[last] - mean[first]))),
        }


def response_history(
    problem: Problem,
    band: Band | Sequence[float],
    force: Sequence[float] = UP_AND_DOWN,
    *,
    points: int = 61,
    harmonics: int | Sequence[int] = 5,
    samples: int = 256,
    progress: Progress = lambda fraction, text: None,
) -> ResponseHistory:
    """Sweeps over frequency at force levels in the order of time; sliders are carried from point to point and run to run.

    band: a `Band`, in `points` equal steps from its start to its stop in every run; or frequencies in Hz in the order of the
    sweep. A point that does not converge is marked and leaves the sliders as they were.
    """
    of_kind("problem", problem, Problem)
    levels = [positive("force", level) for level in np.atleast_1d(numbers("force", force))]
    if isinstance(band, Band):
        frequencies = np.linspace(band.start, band.stop, between("points", points, 1))
    else:
        frequencies = np.array(in_order(band))
    if not levels:
        raise InputError("force must hold at least one level, but is empty.")
    checked_progress(progress)
    started = time.process_time()
    with one_blas_thread():
        balance = HarmonicBalance(problem, harmonics, samples)
        table = _Table(balance, levels, frequencies)
        for k, (level, correction) in enumerate(states.march(balance, (2.0 * np.pi * frequencies).tolist(), levels)):
            progress(k / (len(levels) * frequencies.size), f"force {level:g}, {frequencies[k % frequencies.size]:.4g} Hz")
            table.fill(*divmod(k, frequencies.size), correction)
    attrs = {"harmonics": attribute(balance.harmonics), "samples": samples, "cpu_seconds": time.process_time() - started}
    return ResponseHistory(table.dataset({"title": problem.heading} | attrs), problem)


class _Table:
    """The arrays of a history, filled point by point; contact cycles are kept at the largest point of each run only."""

    def __init__(self, balance: HarmonicBalance, levels: Sequence[float], frequencies: Array) -> None:
        self.balance, self.levels, self.frequencies = balance, levels, frequencies
        outputs, samples = balance.problem.output_rows.shape[0], balance.tables.E.shape[0]
        runs, steps = len(levels), frequencies.size
        self.outcome = np.full((runs, steps), Outcome.NOT_CONVERGED, dtype=np.int8)
        self.response = np.full((runs, steps, outputs, balance.highest + 1, 2), np.nan)
        self.amplitude = np.full((runs, steps, outputs), np.nan)
        self.slider = np.full((runs, balance.table.stiffness.size), np.nan)
        self.force, self.motion = (np.full((runs, balance.rows, samples), np.nan) for _ in range(2))
        self.largest: dict[int, float] = {}

    def fill(self, run: int, step: int, correction: Correction) -> None:
        """Note a point."""
        if not correction.converged:
            return
        evaluation, rows = correction.evaluation, self.balance.rows
        self.outcome[run, step] = Outcome.CONVERGED
        values = complex_harmonics(evaluation.w[rows:])
        self.response[run, step] = parts(values)
        self.amplitude[run, step] = np.hypot(evaluation.w[rows:, 1], evaluation.w[rows:, 2])
        size = float(self.amplitude[run, step, 0])
        cycle = contact_cycle(evaluation.table, self.balance.tables, evaluation.w, evaluation.point.omega)
        self.slider[run] = cycle.slider
        if size > self.largest.get(run, -1.0):
            self.largest[run] = size
            self.force[run], self.motion[run] = cycle.force, cycle.displacement

    def dataset(self, attrs: dict[str, Any]) -> xr.Dataset:
        """The labelled dataset."""
        problem = self.balance.problem
        names = [f"{contact.name} {d}" for contact in problem.contacts for d in contact.direction_names]
        where = np.nanargmax(np.where(np.isnan(self.amplitude), -1.0, self.amplitude), axis=1)
        top = np.take_along_axis(self.amplitude, where[:, None, :], axis=1)[:, 0]
        variables = {
            "outcome": self.outcome,
            "amplitude": self.amplitude,
            "response": self.response,
            "largest_amplitude": top,
            "largest_frequency": self.frequencies[where],
            "largest_contact_force": self.force,
            "largest_contact_motion": self.motion,
            "slider": self.slider,
        }
        coords = {
            "force_level": list(self.levels),
            "frequency": self.frequencies,
            "output": list(problem.output_names),
            "row": names,
            "part": ["re", "im"],
        }
        return tabulated("load_history", variables, coords, attrs)
