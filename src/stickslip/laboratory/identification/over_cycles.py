"""Contact parameters of a damper over the cycles of its records: the fit to all cycles, repeated on groups of neighbours."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from stickslip.laboratory.identification.damper_fit import DamperFit
from stickslip.laboratory.identification.refits import COARSE, refitted, slopes
from stickslip.support.checks import Array, Index, between, fault

if TYPE_CHECKING:
    import xarray as xr

FEWEST = 2
"""Cycles of a group: their scatter shows which harmonics of the motion are noise."""


def parameters_over_cycles(fit: DamperFit, theta: Array, points: int) -> xr.Dataset:
    """Parameters (point, parameter) of a fit to consecutive groups of cycles, from those of all cycles, theta (logarithms).

    Group k holds the kth part of the cycles of every record. NaN where no steady cycle was found.
    """
    import xarray as xr

    fewest = min(len(case.harmonics) for case in fit.cases)
    between("points", points, 2)
    if fewest < FEWEST * points:
        rule = f"must be at most {fewest // FEWEST}, for groups of at least {FEWEST} cycles"
        raise fault("points", rule, points, "Record more cycles, or ask for fewer points.")
    jacobian, found, numbers = slopes(fit.steps(COARSE), theta), np.full((points, theta.size), np.nan), np.empty((points, 2))
    parts = [np.array_split(np.arange(len(case.harmonics)), points) for case in fit.cases]
    for k in range(points):
        own = _of_cycles(fit, [part[k] for part in parts]).steps(COARSE)
        numbers[k] = parts[0][k][0] + 1, parts[0][k][-1] + 1
        end = refitted(own, theta, jacobian).theta
        if own.predicted(end) is not None:
            found[k] = np.exp(end)
    units = {"kt": "N/m", "kn": "N/m"}
    variables = {
        p.name: ("point", found[:, i], {"units": units.get(p.part, "1"), "long_name": f"{p.name} of a group of cycles"})
        for i, p in enumerate(fit.unknowns)
    }
    about = {"units": "1", "long_name": "first and last cycle of the group, of the first record"}
    return xr.Dataset({**variables, "cycles": (("point", "end"), numbers, about)}, attrs={"title": "Parameters over the cycles"})


def _of_cycles(fit: DamperFit, parts: list[Index]) -> DamperFit:
    """A copy of a fit with some of the cycles of each case."""
    cases = [replace(case, harmonics=case.harmonics[part]) for case, part in zip(fit.cases, parts, strict=True)]
    return fit.with_cases(cases, np.stack([[case.channel(name) for name in fit.channels] for case in cases]))
