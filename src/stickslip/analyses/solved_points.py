"""Solved points of a forced response as the solver had them, from what its dataset keeps."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from stickslip.checks import Array, fault, whole
from stickslip.contact.point import DIRECTION_NAMES
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
        self.kept, self.problem = dataset[list(KEPT)], problem
        self.balance = HarmonicBalance(problem, int(dataset.attrs["harmonics"]), int(dataset.attrs["samples"]))

    def point(self, case: int, point: int) -> Point:
        """λ, what contacts carry beyond the springs of the stuck ones, with frequency and force level."""
        place = self._place(case, point)
        carried = self._rows(place["contact_force"].to_numpy())
        forces = carried - self.balance.stiffness[:, None] * self._rows(place["contact_motion"].to_numpy())
        return Point(forces, 2.0 * np.pi * float(place["frequency"]), float(place["force_level"]))

    def contact_motion(self, case: int, point: int) -> Array:
        """Relative displacement of every contact row, (rows, 2H+1), m."""
        return self._rows(self._place(case, point)["contact_motion"].to_numpy())

    def whole_motion(self, case: int, point: int) -> Array:
        """Displacement of every degree of freedom, (n, 2H+1), m."""
        solved = self.point(case, point)
        return self.balance.linear.whole_motion(solved.forces, solved.omega, solved.level)

    def _place(self, case: int, point: int) -> xr.Dataset:
        place = {"case": whole("case", case), "point": whole("point", point)}
        for name, number in place.items():
            if not 0 <= number < self.kept.sizes[name]:
                raise fault(name, f"must be a whole number from 0 to {self.kept.sizes[name] - 1}", number)
        found = self.kept.isel(place)
        if int(found["outcome"]) != Outcome.CONVERGED:
            raise fault(f"Point {point} of case {case}", "must have converged", Outcome(int(found["outcome"])).sentence)
        return found

    def _rows(self, parts: Array) -> Array:
        """Real storage (rows, 2H+1) from (contact, direction, harmonic, part)."""
        contacts = enumerate(self.problem.contacts)
        present = [(c, DIRECTION_NAMES.index(name)) for c, contact in contacts for name in contact.direction_names]
        values = np.array([parts[c, d, :, 0] + 1j * parts[c, d, :, 1] for c, d in present])
        return real_harmonics(values.reshape(len(present), parts.shape[2]))
