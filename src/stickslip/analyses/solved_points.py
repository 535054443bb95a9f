"""Solved points of a forced response as the solver had them, from what its dataset keeps."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from stickslip.analyses.contact_rows import ContactRows
from stickslip.checks import Array, fault, whole
from stickslip.harmonic.balance import HarmonicBalance, Point
from stickslip.harmonic.fourier import real_harmonics
from stickslip.outcome import Outcome
from stickslip.problem import Problem

if TYPE_CHECKING:
    import xarray as xr


KEPT = ("outcome", "frequency", "force_level", "contact_force", "contact_motion")
"""The variables of a dataset that a point is made of."""


class SolvedPoints:
    """The converged points of a dataset; `balance`: the one that solved them."""

    def __init__(self, dataset: xr.Dataset, problem: Problem) -> None:
        self.kept = {name: dataset[name].to_numpy() for name in KEPT}
        self.rows = ContactRows(problem)
        self.balance = HarmonicBalance(problem, int(dataset.attrs["harmonics"]), int(dataset.attrs["samples"]))

    def point(self, case: int, point: int) -> Point:
        """λ, what contacts carry beyond the springs of the stuck ones, with frequency and force level."""
        place = self._place(case, point)
        springs = self.balance.stiffness[:, None] * self._rows(self.kept["contact_motion"][place])
        forces = self._rows(self.kept["contact_force"][place]) - springs
        return Point(forces, 2.0 * np.pi * float(self.kept["frequency"][place]), float(self.kept["force_level"][case]))

    def converged(self, case: int) -> list[Point]:
        """All converged points of a case, in the order of travel."""
        return [self.point(case, int(k)) for k in np.flatnonzero(self.kept["outcome"][case] == Outcome.CONVERGED)]

    def contact_motion(self, case: int, point: int) -> Array:
        """Relative displacement of every contact row, (rows, 2H+1), m."""
        return self._rows(self.kept["contact_motion"][self._place(case, point)])

    def whole_motion(self, case: int, point: int) -> Array:
        """Displacement of every degree of freedom, (n, 2H+1), m."""
        solved = self.point(case, point)
        return self.balance.linear.whole_motion(solved.forces, solved.omega, solved.level)

    def _place(self, case: int, point: int) -> tuple[int, int]:
        """The two numbers, checked."""
        outcomes = self.kept["outcome"]
        for name, number, size in zip(("case", "point"), (case, point), outcomes.shape, strict=True):
            if not 0 <= whole(name, number) < size:
                raise fault(name, f"must be a whole number from 0 to {size - 1}", number)
        outcome = Outcome(int(outcomes[case, point]))
        if outcome != Outcome.CONVERGED:
            raise fault(f"Point {point} of case {case}", "must have converged", outcome.sentence)
        return int(case), int(point)

    def _rows(self, parts: Array) -> Array:
        """Real storage (rows, 2H+1) from (contact, direction, harmonic, part)."""
        values = self.rows.collected(parts)
        return real_harmonics(values[..., 0] + 1j * values[..., 1])
