"""Designs computed on demand and cached, and the searches that request them: differential evolution, then a simplex.

Sensitivity of the best design: slopes to both sides of every variable, and the range in which it may vary alone.

Selection of the best design over all start states with as few searches as possible.
"""

import time
from collections.abc import Generator, Sequence
from dataclasses import dataclass
from typing import Any, Protocol, Self

import numpy as np
from numpy.typing import ArrayLike
from scipy.optimize import differential_evolution, minimize

from stickslip.runs.cases import all_cases
from stickslip.runs.work import Arrays, Checkpoint, Progress, Report, Work, Workers
from stickslip.support.checks import Array, InputError

POPULATION = 5
"""Designs that differential evolution needs; the middle of the box stands in for missing ones."""

ASIDE = 0.12
"""Edge of the first simplex, as a share of the box."""

WORTH = 5.0
"""Processes of this machine are started for cases that take this much longer, s of processor time, one after the other."""

GAIN = 1e-4
"""Less than this share of the worst-case peak is no gain."""


class DesignCases(Work, Protocol):
    """Designs as cases of a work, which can be asked for others too."""

    @property
    def box(self) -> Sequence[tuple[float, float]]:
        """The ends of every variable."""

    def at(self, points: Sequence[Array]) -> Self:
        """The work of other designs."""

    def searched(self, case: int, level: float, friction: float) -> float:
        """The highest resonance over all start states of a case."""


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

    work: DesignCases
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

    def solved(self, points: Sequence[Array]) -> list[Record]:
        """Designs computed, or given back by what keeps them."""
        return [Record.of(arrays) for arrays in self.computed(self.work.at(points))] if points else []

    def solved_where_possible(self, points: Sequence[Array]) -> list[Record | None]:
        """Designs computed; None where a design cannot be made or a constraint of it fails."""
        try:
            return list(self.solved(points))
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

    designs: DesignCases
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
