"""Damper design: the variables that minimise the worst-case resonance over force, uncertain friction and start states.

Designs are computed on demand and cached; the searches request them: differential evolution, then a simplex.

Sensitivity of the best design: slopes to both sides of every variable, and the range in which it may vary alone.

Selection of the best design over all start states with as few searches as possible.
"""

import time
from collections.abc import Generator, Mapping, Sequence
from dataclasses import KW_ONLY, dataclass, replace
from functools import cached_property
from typing import Annotated, Any, Literal, Protocol, Self, get_args

import numpy as np
from numpy.typing import ArrayLike
from scipy.optimize import differential_evolution, minimize

from stickslip.analyses.forced_response import compile_forced_response
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
from stickslip.results.schema import Result, stacked, tabulated
from stickslip.runs.cases import Arrays, Checkpoint, Progress, Report, Work, Workers, all_cases, silent
from stickslip.solve.balance.fourier import MOST_SAMPLES, attribute
from stickslip.support.checks import Array, InputError, fault, of_kind, positive, vector
from stickslip.support.late import xr
from stickslip.support.machine import one_blas_thread

POPULATION = 5
"""Designs that differential evolution needs; the middle of the box stands in for missing ones."""

ASIDE = 0.12
"""Edge of the first simplex, as a share of the box."""

WORTH = 5.0
"""Processes of this machine are started for cases that take this much longer, s of processor time, one after the other."""

GAIN = 1e-4
"""Less than this share of the worst-case peak is no gain."""


@dataclass(frozen=True, eq=False)
class Record:
    """A design that was computed: variables, its worst-case peak, margins of the constraints, conditions without a peak, and
    what each friction coefficient gives as in `WorstCase`; the processor time it took [s].
    """

    point: Array
    place: Array
    margins: Array
    failed: Array
    each: Array
    seconds: float = np.inf

    @classmethod
    def of(cls, arrays: Arrays) -> Self:
        """From the arrays of a case."""
        found = {name: np.asarray(arrays[name]) for name in ("point", "place", "margins", "failed", "each")}
        return cls(**found, seconds=float(arrays["cpu_seconds"]))

    @property
    def allowed(self) -> bool:
        return bool(np.all(self.margins > 0.0)) and bool(np.isfinite(self.place[0]))

    @property
    def penalised(self) -> float:
        """The worst-case peak, and for a broken constraint far more than any peak."""
        broken = float(np.sum(np.fmax(-self.margins, 0.0)) + np.count_nonzero(self.margins <= 0.0))
        size = self.place[0] if np.isfinite(self.place[0]) else 1e6
        return float(size * (1.0 + 10.0 * broken)) if broken > 0.0 else float(size)

    @property
    def rank(self) -> tuple[bool, bool, float]:
        """What is least for the best design: one without a peak in some condition comes after all that have them all."""
        return not self.allowed, len(self.failed) > 0, self.penalised


REFUSED = 1e6
"""How many times worse than the best design one counts that cannot be made."""


@dataclass(eq=False)
class Designs:
    """The designs computed so far, and more on demand: each of them once, kept by `checkpoint`, several side by side.

    expected: how many cases a search will ask for, about, which `progress` counts.
    """

    work: "DesignWork"
    records: list[Record]
    checkpoint: Checkpoint | None
    workers: Workers
    progress: Progress
    expected: int

    def __post_init__(self) -> None:
        self.low, self.high = np.array(self.work.box).T
        self.done = 0

    @property
    def best(self) -> Record:
        return min(self.records, key=lambda record: record.rank)

    def unit(self, point: Array) -> Array:
        """A design as shares of the box."""
        return np.asarray((point - self.low) / (self.high - self.low))

    def at(self, units: ArrayLike) -> list[float]:
        """Penalised worst-case peaks of designs (designs, variables) given as shares of the box; far more where refused."""
        points = self.low + np.clip(np.asarray(units, dtype=float), 0.0, 1.0) * (self.high - self.low)
        new: list[Array] = []
        for point in points:
            if self._known(point) is None and not any(_same(point, other) for other in new):
                new.append(point)
        self.records += [record for record in self.solved_where_possible(new) if record is not None]
        known = [self._known(point) for point in points]
        return [REFUSED * self.best.penalised if record is None else record.penalised for record in known]

    def solved_where_possible(self, points: Sequence[Array]) -> list[Record | None]:
        """Designs computed; None where a design cannot be made or a constraint of it fails."""
        try:
            return [Record.of(arrays) for arrays in self.computed(self.work.at(points))] if points else []
        except InputError:
            return [None] if len(points) == 1 else [self.solved_where_possible([point])[0] for point in points]

    def computed(self, work: Work) -> list[Arrays]:
        """The cases of a work, side by side, or given back by what keeps them."""
        count = len(work.names)

        def report(fraction: float, text: str) -> None:
            self.progress((self.done + count * fraction) / max(self.expected, self.done + count), text)

        seconds = float(np.mean([record.seconds for record in self.records])) if self.records else np.inf  # of a design, about
        few = count == 1 or (isinstance(self.workers, int) and (count - 1) * seconds < WORTH)
        results = all_cases(work, self.checkpoint, 1 if few else self.workers, report)
        self.done += count
        return results

    def _known(self, point: Array) -> Record | None:
        return next((record for record in self.records if _same(record.point, point)), None)


def _same(point: Array, other: Array) -> bool:
    return bool(np.allclose(point, other, rtol=1e-12, atol=0.0))


def evolve(designs: Designs, generations: int, seed: int) -> None:
    """Differential evolution from the designs known; those of one generation side by side."""
    start = np.array([designs.unit(record.point) for record in designs.records])
    start = np.vstack([start, np.full((max(POPULATION - len(start), 0), start.shape[1]), 0.5)])
    box = [(0.0, 1.0)] * start.shape[1]
    settings: dict[str, Any] = {"maxiter": generations, "polish": False, "seed": seed}
    settings |= {"init": start, "vectorized": True, "updating": "deferred"}
    differential_evolution(lambda units: np.array(designs.at(units.T)), box, **settings)  # type: ignore[arg-type, misc]


def refine(designs: Designs, most: int) -> None:
    """Simplex searches of at most so many designs together, each from the best one known, until one gains nothing."""
    left, before = most, np.inf
    while left > 0 and designs.best.penalised < (1.0 - GAIN) * before:
        before = designs.best.penalised
        best = designs.best
        unit = designs.unit(best.point)
        simplex = np.vstack([unit, *(unit + np.where(unit > 0.5, -ASIDE, ASIDE) * row for row in np.eye(unit.size))])
        options = {"initial_simplex": simplex, "maxfev": left, "xatol": 2e-3, "fatol": GAIN * best.penalised}
        box = [(0.0, 1.0)] * unit.size
        found = minimize(lambda unit: designs.at([unit])[0], unit, method="Nelder-Mead", bounds=box, options=options)  # type: ignore[call-overload]
        left -= int(found.nfev)


NEAR = 0.05
"""A variable may go alone to where the worst-case peak is higher by this share."""

STEP = 0.02
"""The first step to each side, which gives the slope, and the width to which ends of ranges are found, as shares of the box."""

CLOSE = 0.005
"""An end of a range is found, too, where the worst-case peak is higher by `NEAR` to within this share."""

Walk = Generator[float, float, float]


@dataclass(frozen=True, eq=False)
class DesignRanges:
    """slopes (variables, 2): relative rise of the worst-case peak per relative change of a variable that becomes less, and more;
    NaN at the end of the box and beside a design that is not allowed. low, high (variables,): how far each variable may go alone.
    """

    slopes: Array
    low: Array
    high: Array


def design_ranges(designs: Designs, best: Record) -> DesignRanges:
    """Slopes at a design and the range of each variable in which the worst-case peak is at most `NEAR` higher, the others held.

    All sides are walked together: a step of each is one batch of designs.
    """
    unit, size = designs.unit(best.point), float(best.place[0])
    sides = [(k, sign) for k in range(unit.size) for sign in (-1.0, 1.0)]
    room = [float(np.clip(unit[k] if sign < 0.0 else 1.0 - unit[k], 0.0, 1.0)) for k, sign in sides]
    walks = [_walk(end) for end in room]
    slopes, reached = np.full(len(sides), np.nan), np.zeros(len(sides))
    asked = {j: next(walk) for j, walk in enumerate(walks) if room[j] > 1e-9}
    first = dict(asked)
    while asked:
        found = designs.solved_where_possible([_moved(designs, best, *sides[j], way) for j, way in asked.items()])
        onward = {}
        for (j, way), record in zip(asked.items(), found, strict=True):
            rise = float(record.place[0]) / size - 1.0 if record is not None and record.allowed else np.inf
            k, box = sides[j][0], designs.high - designs.low
            if way == first[j] and np.isfinite(rise):
                slopes[j] = rise / (way * box[k]) * abs(best.point[k])
            try:
                onward[j] = walks[j].send(rise)
            except StopIteration as ended:
                reached[j] = ended.value
        asked = onward
    ends = [float(_moved(designs, best, *side, way)[side[0]]) for side, way in zip(sides, reached.tolist(), strict=True)]
    return DesignRanges(slopes.reshape(-1, 2), np.array(ends[::2]), np.array(ends[1::2]))


def _moved(designs: Designs, best: Record, variable: int, sign: float, way: float) -> Array:
    """A design with one variable moved by a share of the box, and within it."""
    low, high = designs.low[variable], designs.high[variable]
    point = best.point.copy()
    point[variable] = np.clip(point[variable] + sign * way * (high - low), low, high)
    return point


def _walk(end: float) -> Walk:
    """How far one may go, at most to `end`: yields ways, is sent the rise of the peak there (infinite where it is refused).

    Steps outwards as the rise predicts, at most threefold, then between the last way within `NEAR` and the first beyond.
    """
    inside, low, way = 0.0, 0.0, min(STEP, end)
    while (rise := (yield way)) <= NEAR:
        if way >= end:
            return end
        inside, low = way, rise
        predicted = 1.1 * NEAR / rise * way if rise > 0.0 else np.inf
        way = min(max(1.5 * way, min(3.0 * way, predicted)), end)
    outside, high = way, rise
    while outside - inside > STEP and min(abs(low - NEAR), abs(high - NEAR)) > CLOSE:
        # By a straight line between small rises, in the middle otherwise.
        share = float(np.clip((NEAR - low) / (high - low), 0.2, 0.8)) if high < 4.0 * NEAR else 0.5
        way = inside + share * (outside - inside)
        rise = yield way
        if rise <= NEAR:
            inside, low = way, rise
        else:
            outside, high = way, rise
    return inside + (NEAR - low) / (high - low) * (outside - inside)


BESIDE = 2
"""Designs that are searched side by side while the best one is looked for."""


@dataclass(frozen=True, eq=False)
class StartsWork:
    """Searches of all start states as independent cases: (design, force level, friction coefficient)."""

    designs: "DesignWork"
    cases: tuple[tuple[float, float], ...]

    @property
    def names(self) -> tuple[str, ...]:
        """Everything that a case depends on."""
        return tuple(
            f"all start states at level {level!r}, friction {mu!r} of {name}"
            for (level, mu), name in zip(self.cases, self.designs.names, strict=True)
        )

    @property
    def words(self) -> tuple[str, ...]:
        return tuple(f"start states of {words}" for words in self.designs.words)

    def prepare(self) -> None:
        """As designs do."""
        self.designs.prepare()

    def solve(self, case: int, report: Report) -> Arrays:
        """The highest resonance over all start states of one case."""
        started = time.process_time()
        found = self.designs.searched(case, *self.cases[case])
        return {"highest": np.array(found), "cpu_seconds": np.array(time.process_time() - started)}


class AllStarts:
    """What a search of all start states finds for designs, at the force level that is worst under each friction coefficient.

    each (designs, frictions, 3) as in `WorstCase`; done (designs, frictions): what is known, or cannot be.
    """

    def __init__(self, designs: Designs, frictions: Sequence[float]) -> None:
        self.designs, self.frictions = designs, frictions
        self.each = np.array([record.each for record in designs.records])
        self.done = np.isfinite(self.each[:, :, 2]) | ~np.isfinite(self.each[:, :, 1])

    def peak(self, design: int) -> float:
        """The highest resonance known of a design, at least the one of its sampled start states; infinite without any."""
        sizes = self.each[design][:, [0, 2]]
        return float(np.nanmax(sizes)) if np.isfinite(sizes).any() else np.inf

    def searches(self, design: int) -> int:
        """Friction coefficients under which a search found something."""
        return int(np.count_nonzero(np.isfinite(self.each[design, :, 2])))

    def best(self, known: int) -> int:
        """The design whose highest resonance over all start states is least; the first `known` ones are searched in any case.

        What is known of a design can only rise: the one that is least and searched under every friction coefficient is the best.
        """
        records = self.designs.records
        self._search([(k, j) for k in range(known) if records[k].allowed for j in np.flatnonzero(~self.done[k]).tolist()])
        first = self.designs.best.rank[:2]
        field = [k for k, record in enumerate(records) if record.rank[:2] == first]
        while True:
            leaders = sorted(field, key=self.peak)
            if self.done[leaders[0]].all():
                return leaders[0]
            self._search([(k, self._next(k)) for k in leaders[:BESIDE] if not self.done[k].all()])

    def _next(self, design: int) -> int:
        """The friction coefficient, not searched yet, under which the sampled start states give most."""
        return int(np.argmax(np.where(self.done[design], -np.inf, self.each[design, :, 0])))

    def _search(self, cases: Sequence[tuple[int, int]]) -> None:
        if not cases:
            return
        points = [self.designs.records[k].point for k, _ in cases]
        places = tuple((float(self.each[k, j, 1]), float(self.frictions[j])) for k, j in cases)
        results = self.designs.computed(StartsWork(self.designs.work.at(points), places))
        for (k, j), arrays in zip(cases, results, strict=True):
            self.each[k, j, 2], self.done[k, j] = float(arrays["highest"]), True


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

    dataset: "xr.Dataset"

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

    def at(self, points: Sequence[Array]) -> "DesignWork":
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
    def work(self) -> "DesignWork":
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
) -> "xr.Dataset":
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


def no_optimum(dataset: "xr.Dataset") -> str:
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


def _dataset(work: "DesignWork", designs: Designs, starts: AllStarts, best: int, near: DesignRanges | None) -> "xr.Dataset":
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

    attrs: dict[str, Any] = {
        "title": "Design of a damper",
        "forces": list(conditions.forces),
        "frictions": list(conditions.frictions),
    }
    attrs |= {"starts": conditions.starts, "harmonics": attribute(conditions.harmonics), "samples": conditions.samples}
    attrs |= replace(conditions.measure, per_force=conditions.per_force).attributes
    attrs |= {"known": work.known, "nearest": records.index(designs.best)}
    return tabulated("damper_design", values, coords, attrs, units)


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
