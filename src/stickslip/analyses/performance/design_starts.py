"""Selection of the best design over all start states with as few searches as possible."""

from __future__ import annotations

import time
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from stickslip.analyses.performance.design_search import DesignCases, Designs
from stickslip.runs.work import Arrays, Report

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
