"""Conversion of motions relative to a moving base into absolute ones: X + r X_b, X_b = −A/(hω)² for a base acceleration A."""

from __future__ import annotations

import numpy as np

from stickslip.model.loads import BaseMotion
from stickslip.model.problem import Problem
from stickslip.results.view import periods_of
from stickslip.support.late import xr


def absolute(dataset: xr.Dataset, problem: Problem) -> xr.Dataset:
    """`response` and `amplitude` of a result as absolute motions, m: those of the result, which are relative, and the base."""
    found = dataset[["frequency", "outcome", "response", "amplitude"]].copy(deep=True)
    omega, level = 2.0 * np.pi * dataset["frequency"].values, dataset["force_level"].values[:, None]
    values, periods = found["response"].values, periods_of(dataset)
    for base in (force for force in problem.forces if isinstance(force, BaseMotion)):
        along = problem.output_rows @ problem.structure.row(base.coefficients)
        for harmonic, factor in base.factors.items():
            acceleration = level * factor * omega**base.power
            moved = (-acceleration / (harmonic * omega) ** 2)[..., None] * along
            values[:, :, :, periods * harmonic, 0] += moved.real
            values[:, :, :, periods * harmonic, 1] += moved.imag
    found["amplitude"].values[:] = np.hypot(values[:, :, :, periods, 0], values[:, :, :, periods, 1])
    found["response"].attrs["long_name"] = "absolute response"
    found["amplitude"].attrs["long_name"] = "amplitude of the first harmonic of the absolute response"
    return found
