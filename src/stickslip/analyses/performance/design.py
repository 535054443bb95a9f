"""Damper design: the variables that minimise the worst-case resonance over force, uncertain friction and start states."""

from __future__ import annotations

import time
from collections.abc import Mapping, Sequence
from dataclasses import KW_ONLY, dataclass, replace
from functools import cached_property
from typing import Annotated, Any, Literal, Protocol, get_args

import numpy as np

from stickslip.analyses.forced_response import compile_forced_response
from stickslip.analyses.performance.design_search import AllStarts, DesignRanges, Designs, Record, design_ranges, evolve, refine
from stickslip.analyses.performance.worst_case import Conditions, Constraint, WorstCase, searched_peak, worst_case
from stickslip.analyses.settings import (
    Execution,
    Measured,
    OfKind,
    OneOf,
    Seed,
    Setting,
    Whole,
    fineness_of,
    harmonic_numbers,
    made,
    maker,
    measure_name,
    output_of,
    point_of,
    quantity_name,
    ranges_of,
    takes,
)
from stickslip.model.problem import Problem
from stickslip.results.schema import Result, named, stacked, variables_in
from stickslip.runs.cases import all_cases
from stickslip.runs.work import Arrays, Checkpoint, Progress, Report, Workers, silent
from stickslip.solve.balance.fourier import MOST_SAMPLES, attribute
from stickslip.support.checks import Array, InputError, fault, of_kind, positive, vector
from stickslip.support.late import xr
from stickslip.support.machine import one_blas_thread

FACTOR = 2.0
"""Default uncertainty of the friction coefficient, which evolves with wear (Gola and Gastaldi, ASME GT2014-25240)."""


Objective = Literal["amplitude", "amplitude_per_force"]


class ProblemOf(Protocol):
    """The problem of a design: `problem_of(friction=0.3, mass=0.02, angle=45.0)`."""

    def __call__(self, *, friction: float, **variables: float) -> Problem: ...


@dataclass(frozen=True, eq=False, repr=False)
class DamperDesign(Result):
    """`dataset`: every design computed: variables, worst-case peak and place, margins of the constraints, whether they hold; and
    the optimum, NaN where no design meets all, with its slopes to both sides and the range of every variable alone.
    """

    dataset: xr.Dataset

    @property
    def optimum(self) -> dict[str, float]:
        """The variables of the best design; refused where none meets the constraints."""
        if message := no_optimum(self.dataset):
            raise InputError(message)
        names = [str(name) for name in self.dataset["variable"].values]
        return dict(zip(names, self.dataset["optimum"].values.tolist(), strict=True))


@dataclass(frozen=True, eq=False)
class DesignWork:
    """Designs as independent cases, of which the first `known` were asked for; fingerprint: of the problem amid the box."""

    problem_of: ProblemOf
    _: KW_ONLY
    variables: tuple[str, ...]
    box: tuple[tuple[float, float], ...]
    points: tuple[tuple[float, ...], ...]
    conditions: Conditions
    limits: tuple[str, ...]
    constraints: tuple[Constraint, ...]
    known: int = 0
    fingerprint: str = ""

    def at(self, points: Sequence[Array]) -> DesignWork:
        """The work of other designs."""
        return replace(self, points=tuple(tuple(point.tolist()) for point in points), known=0)

    @property
    def names(self) -> tuple[str, ...]:
        """Everything that a case depends on, as far as a function can say what it does."""
        what = [_named(self.problem_of), *map(_named, self.constraints)]
        how = f"{self.variables} in {self.box}, {self.conditions}, {self.limits}, {what}, in the middle {self.fingerprint}"
        return tuple(f"design at {point!r} of {how}" for point in self.points)

    @property
    def words(self) -> tuple[str, ...]:
        return tuple(", ".join(f"{n} {v:.4g}" for n, v in zip(self.variables, point, strict=True)) for point in self.points)

    prepare = staticmethod(compile_forced_response)

    def solve(self, case: int, report: Report) -> Arrays:
        """The worst-case peak of one design."""
        started = time.process_time()
        worst = self.worst(self.points[case], report)
        place = [worst.size, worst.frequency, worst.force, worst.friction, worst.start]
        found = {
            "point": self.points[case],
            "place": place,
            "margins": worst.margins,
            "each": worst.each,
            "cpu_seconds": time.process_time() - started,
        }
        return {name: np.array(value) for name, value in found.items()} | {"failed": np.array(worst.failed).reshape(-1, 3)}

    def problem(self, point: Sequence[float], friction: float) -> Problem:
        """The problem of a point of the design space."""
        return made(self.problem_of, friction=friction, **dict(zip(self.variables, map(float, point), strict=True)))

    def worst(self, point: Sequence[float], report: Report = lambda fraction: None) -> WorstCase:
        """The worst-case peak of any point of the design space."""
        values = dict(zip(self.variables, map(float, point), strict=True))
        with one_blas_thread():
            limits = dict(zip(self.limits, self.constraints, strict=True))
            return worst_case(lambda mu: self.problem(point, mu), values, self.conditions, limits, report)

    def searched(self, case: int, level: float, friction: float) -> float:
        """The highest resonance over all start states of a design at one force level and friction, as `worst` counts it."""
        with one_blas_thread():
            return searched_peak(self.problem(self.points[case], friction), level, self.conditions)


def _named(function: object) -> str:
    """A function by where it stands, anything else by what it says of itself: equal in every process."""
    name = getattr(function, "__qualname__", "")
    return f"{getattr(function, '__module__', '')}.{name}" if name else repr(function)


def _variables(name: str, variables: Any) -> dict[str, tuple[float, float]]:
    named = ranges_of(name, variables)
    if "friction" in named:
        remedy = "Contacts have any friction within `friction_factor` of the argument `friction`; name other variables."
        raise fault(name, "must not hold friction, which no designer chooses", list(named), remedy)
    return named


def _levels_between(name: str, force: Any) -> tuple[float, float]:
    ends = vector(name, force).tolist()
    if len(ends) != 2 or not 0.0 < ends[0] <= ends[1]:
        raise fault(name, "must be (low, high) with 0 < low <= high", force)
    return positive(name, ends[0]), positive(name, ends[1])


def _constraints(name: str, constraints: Any) -> Mapping[str, Constraint]:
    for each, constraint in of_kind(name, constraints, Mapping).items():  # type: ignore[type-abstract]
        if not callable(constraint):
            raise fault(f"Constraint {each!r}", "must be a function of a Trial", constraint)
    return dict(constraints)


def _factor(name: str, factor: Any) -> float:
    if positive(name, factor) < 1.0:
        raise fault(name, "must be at least 1", float(factor))
    return float(factor)


@dataclass(frozen=True, eq=False)
class DesignSettings(Measured, Execution):
    """What a design is sought among, what it has to stand, and how far the search goes."""

    problem_of: Annotated[ProblemOf, Setting(maker)]
    variables: Annotated[Mapping[str, tuple[float, float]], Setting(_variables, "{argument = [low, high]}")]
    force: Annotated[tuple[float, float], Setting(_levels_between, "[low, high] of the force level")]
    friction: Annotated[float, Setting(positive, "nominal coefficient, put at every contact")]
    objective: Annotated[Objective, Setting(OneOf(get_args(Objective)), "what is least")] = "amplitude"
    constraints: Annotated[Mapping[str, Constraint] | None, Setting(_constraints)] = None
    _: KW_ONLY
    known: Annotated[
        Sequence[Mapping[str, float]],
        Setting(OfKind(Sequence), "designs to compute first, such as the damper as built: [{argument = value}]"),
    ] = ()
    friction_factor: Annotated[float, Setting(_factor, "from the least to the largest coefficient")] = FACTOR
    starts: Annotated[int, Setting(Whole(0), "sampled start states beside virgin contacts; 0: virgin ones alone")] = 2
    search: Annotated[
        bool,
        Setting(
            OfKind(bool), "search all start states in the worst case of every design, not only of those that may be the best"
        ),
    ] = True
    levels: Annotated[int, Setting(Whole(1), "force levels between them, in equal ratios; 1 for equal ends")] = 4
    designs: Annotated[int, Setting(Whole(4), "points of the first look at the design space")] = 24
    generations: Annotated[int, Setting(Whole(0), "of differential evolution from them")] = 0
    refinements: Annotated[int, Setting(Whole(0), "designs of the simplex search that follows")] = 30
    output: Annotated[int, Setting(Whole(0))] = 0
    quantity: Annotated[str, Setting(quantity_name, "quantity of the resonances")] = "displacement"
    measure: Annotated[
        str,
        Setting(measure_name, "how the signal becomes one number: first-harmonic amplitude, RMS, or largest value in the period"),
    ] = "amplitude"
    seed: Seed = 0
    harmonics: Annotated[int | Sequence[int], Setting(harmonic_numbers, "H, or a list that holds 1")] = 3
    samples: Annotated[int, Setting(Whole(1, MOST_SAMPLES), "samples of a period")] = 256

    def __post_init__(self) -> None:
        super().__post_init__()
        low, high = self.force
        if (self.levels == 1) != (low == high):
            remedy = "One level has (F, F); several need different ends."
            raise fault("levels", "must be 1 where both ends of force are the same, else at least 2", self.levels, remedy)

    @cached_property
    def conditions(self) -> Conditions:
        """What a design has to stand."""
        (low, high), mu, factor = self.force, self.friction, self.friction_factor
        H, Nt = fineness_of(self.harmonics, self.samples)
        return Conditions(
            forces=tuple(np.geomspace(low, high, self.levels).tolist()) if low < high else (low,),
            frictions=(mu / factor**0.5, mu, mu * factor**0.5) if factor > 1.0 else (mu,),
            starts=self.starts,
            seed=self.seed,
            output=self.output,
            per_force=self.objective == "amplitude_per_force" or self.measured.per_force,
            harmonics=H,
            samples=Nt,
            search=self.search and self.starts > 0,
            measure=replace(self.measured, per_force=False),
        )

    @cached_property
    def work(self) -> DesignWork:
        """The first look at the design space: known designs, and points of a Sobol' sequence in the box of the variables."""
        box, limits = tuple(self.variables.values()), self.constraints or {}
        low, high = np.array(box).T
        from scipy.stats import qmc  # takes half a second, which only those who draw shall wait for

        unit = qmc.Sobol(len(box), seed=self.seed).random_base2((self.designs - 1).bit_length())[: self.designs]
        known = (point_of(f"known[{k}]", one, self.variables) for k, one in enumerate(self.known))
        first = tuple(dict.fromkeys(known))
        work = DesignWork(
            self.problem_of,
            variables=tuple(self.variables),
            box=box,
            points=(*first, *(tuple(float(v) for v in row) for row in low + unit * (high - low))),
            conditions=self.conditions,
            limits=tuple(limits),
            constraints=tuple(limits.values()),
            known=len(first),
        )
        middle = work.problem((0.5 * (low + high)).tolist(), self.conditions.frictions[0])
        output_of(middle, self.output)
        return replace(work, fingerprint=middle.fingerprint)


@takes(DesignSettings)
def damper_design(settings: DesignSettings) -> DamperDesign:
    """Design in a box of variables with the lowest worst-case resonance, min over v of max over (F, μ, start) of the peak.

    problem_of(friction=μ, **variables) makes the problem; with several `workers` it must be a function of a module.
    variables: {name: (low, high)}. force: range of force levels, of which `levels` in equal ratios are computed. friction:
    nominal coefficient μ; the range from μ/√`friction_factor` to μ√`friction_factor` is covered by its ends and its middle.
    starts: number of sampled start states in addition to the virgin one; with 0 only the virgin state is used, without a search.
    search: in the worst case of every design all start states are searched as `response_bounds` does at the peak, for two to
    four times the time (`searched_peak`); a sample may miss the worst. Either way the designs computed compete over all start
    states: each that may be the best, and each known one, is searched under every friction coefficient; the optimum is the best.
    objective: the peak itself, or per force level. constraints: {name: function of a `Trial` that is positive where met},
    such as `NoJamming`, `NoLiftOff`, `LargestForce`; a design that breaks one in any case is not allowed.
    quantity, measure: what the peak is of, as for `forced_response`; receptance, mobility and inertance are per force level.
    known: designs {name: value} to compute first, such as the damper as built.

    First `designs` points of a Sobol' sequence, which also draw the design space; then `generations` of differential evolution
    from all, each generation by all `workers`; then a simplex search from the best one, of at most `refinements` designs. From
    the optimum one variable after the other is moved, for its slopes to both sides and the range in which the worst-case peak, as
    this search counts it, is at most 5 % higher. Designs in the `checkpoint` are not computed again.
    """
    results = all_cases(settings.work, settings.checkpoint, settings.workers, settings.progress)
    return DamperDesign(finished_design(settings, results, settings.checkpoint, settings.workers, settings.progress))


def finished_design(
    settings: DesignSettings,
    results: Sequence[Arrays],
    checkpoint: Checkpoint | None = None,
    workers: Workers = 1,
    progress: Progress = silent,
) -> xr.Dataset:
    """Generations and a simplex from the sampled designs, the best of all over all start states, then everything as a dataset."""
    work, generations, refinements = settings.work, settings.generations, settings.refinements
    expected = refinements + generations * len(results) + 16 * len(work.box)
    designs = Designs(work, [Record.of(arrays) for arrays in results], checkpoint, workers, progress, expected)
    if generations:
        evolve(designs, generations, work.conditions.seed)
    if refinements:
        refine(designs, refinements)
    starts = AllStarts(designs, work.conditions.frictions)
    if not designs.best.allowed:
        return _dataset(work, designs, starts, -1, None)
    best = starts.best(work.known) if work.conditions.starts else designs.records.index(designs.best)
    return _dataset(work, designs, starts, best, design_ranges(designs, designs.records[best]))


def no_optimum(dataset: xr.Dataset) -> str:
    """Why there is no best design, which design comes nearest, and what to do; "" where there is one."""
    if np.isfinite(float(dataset["optimum_peak"])):
        return ""
    nearest = dataset.isel(design=int(dataset.attrs["nearest"]))
    broken = [str(name) for name in dataset["constraint"].values[nearest["margin"].values <= 0.0]] if "margin" in dataset else []
    where = ", ".join(
        f"{name} = {value:.4g}" for name, value in zip(dataset["variable"].values, nearest["value"].values, strict=True)
    )
    return (
        f"At least one of {dataset.sizes['design']} designs must meet all constraints, but none does; the nearest, {where}, "
        f"breaks {', '.join(broken) or 'none, but has no peak'}. Widen the variables or the constraints."
    )


def _dataset(work: DesignWork, designs: Designs, starts: AllStarts, best: int, near: DesignRanges | None) -> xr.Dataset:
    conditions, records = work.conditions, designs.records
    nothing = np.full(designs.low.size, np.nan)
    values = _of_designs(designs, starts) | {
        "optimum": nothing if near is None else designs.records[best].point,
        "optimum_design": best,
        "optimum_peak": np.nan if near is None else starts.peak(best),
        "sensitivity": np.column_stack([nothing, nothing]) if near is None else near.slopes,
        "near_low": nothing if near is None else near.low,
        "near_high": nothing if near is None else near.high,
        "low": designs.low,
        "high": designs.high,
    }
    coords: dict[str, Any] = {"variable": list(work.variables), "side": ["less", "more"]}
    if work.limits:
        values["margin"] = np.array([record.margins for record in records]).reshape(len(records), len(work.limits))
        coords["constraint"] = list(work.limits)
    units = conditions.measure.units + (" per unit level" if conditions.per_force else "")

    def described(name: str, value: Any) -> tuple[Any, Any, dict[str, str]]:
        dims, unit, words = VARIABLES[name]
        return named(dims, value, words, unit or units)

    attrs: dict[str, Any] = {
        "title": "Design of a damper",
        "forces": list(conditions.forces),
        "frictions": list(conditions.frictions),
    }
    attrs |= {"starts": conditions.starts, "harmonics": attribute(conditions.harmonics), "samples": conditions.samples}
    attrs |= replace(conditions.measure, per_force=conditions.per_force).attributes
    attrs |= {"known": work.known, "nearest": records.index(designs.best)}
    data, labels = ({name: described(name, value) for name, value in part.items()} for part in (values, coords))
    return xr.Dataset(data, labels, attrs)


def _of_designs(designs: Designs, starts: AllStarts) -> dict[str, Any]:
    """What is known of every design, in the order in which they were computed."""
    records = designs.records
    sampled = [record.each[:, 0] for record in records]
    failed = stacked([np.reshape(record.failed, (-1, 3)) for record in records])
    searches = np.array([starts.searches(k) for k in range(len(records))])
    place = np.array([record.place for record in records]).T
    worst = ("worst_peak", "worst_frequency", "worst_force", "worst_friction", "worst_start")
    return {
        "value": np.array([record.point for record in records]),
        **dict(zip(worst, place, strict=True)),
        "sampled_peak": [np.nanmax(sizes) if np.isfinite(sizes).any() else np.inf for sizes in sampled],
        "searched_peak": np.where(searches > 0, [starts.peak(k) for k in range(len(records))], np.nan),
        "searches": searches,
        "failed": [len(record.failed) for record in records],
        **dict(zip(("failed_force", "failed_friction", "failed_start"), np.moveaxis(failed, 2, 0), strict=True)),
        "allowed": np.array([record.allowed for record in records], dtype=np.int8),
    }


VARIABLES = variables_in("damper_design")
"""Dimensions, unit ("" for that of the objective) and meaning of the variables of a design."""
