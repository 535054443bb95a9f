"""Designs computed on demand and cached, and the searches that request them: differential evolution, then a simplex."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, Protocol

import numpy as np
from numpy.typing import ArrayLike
from scipy.optimize import differential_evolution, minimize

from stickslip.runs.cases import all_cases
from stickslip.runs.work import Arrays, Checkpoint, Progress, Work, Workers
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

    def at(self, points: Sequence[Array]) -> DesignCases:
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
    def of(cls, arrays: Arrays) -> Record:
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
