"""Stress at the places of a `StressRecovery`: over the period of one point of a forced response, and along its curves."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from stickslip.checks import Array, fault
from stickslip.harmonic.balance import HarmonicBalance
from stickslip.harmonic.fourier import complex_harmonics, real_harmonics
from stickslip.outcome import Outcome
from stickslip.problem import Problem
from stickslip.structure.stress import COMPONENTS, StressRecovery, von_mises

if TYPE_CHECKING:
    import xarray as xr


def stress(dataset: xr.Dataset, problem: Problem, case: int, point: int, recovery: StressRecovery) -> xr.Dataset:
    """`stress` (place, component, harmonic, part), `amplitude` of the first harmonic (place, component), `largest` (place,
    component) in size over the period, and `von_mises` (place), its largest over the period; all with the mean, Pa."""
    import xarray as xr

    here = degrees_of_freedom(problem, recovery)
    if int(dataset["outcome"].values[case, point]) != Outcome.CONVERGED:
        raise fault("The point", "must have converged", (case, point))
    balance = balance_of(dataset, problem)
    harmonics = recovery.rows @ whole_motion(dataset, balance, case, point)[here]
    over_time = np.einsum("pch,nh->pnc", harmonics, balance.tables.E)
    complex_stress = complex_harmonics(harmonics)
    pascals = {"units": "Pa"}
    sizes = ("place", "component")
    return xr.Dataset(
        {
            "stress": ((*sizes, "harmonic", "part"), np.stack([complex_stress.real, complex_stress.imag], axis=-1), pascals),
            "amplitude": (sizes, np.abs(complex_stress[..., 1]), pascals),
            "largest": (sizes, np.abs(over_time).max(axis=1), pascals),
            "von_mises": (("place",), von_mises(over_time).max(axis=1), pascals),
        },
        coords={
            "place": list(recovery.places),
            "component": list(COMPONENTS),
            "harmonic": np.arange(complex_stress.shape[2]),
            "part": ["re", "im"],
        },
        attrs={
            "frequency": float(dataset["frequency"].values[case, point]),
            "force_level": float(dataset["force_level"].values[case]),
        },
    )


def with_stress(dataset: xr.Dataset, problem: Problem, recovery: StressRecovery) -> xr.Dataset:
    """A forced response with the stress at every converged point of every curve, Pa.

    `stress_von_mises` (case, point, place), its largest over the period, with the mean; `stress_amplitude` and `stress_mean`
    (case, point, place, component), first harmonic and mean of each component.
    """
    here, balance = degrees_of_freedom(problem, recovery), balance_of(dataset, problem)
    sizes = (*dataset["outcome"].shape, len(recovery.places))
    largest = np.full(sizes, np.nan)
    amplitude, mean = np.full((2, *sizes, len(COMPONENTS)), np.nan)
    for case, point in np.argwhere(dataset["outcome"].values == Outcome.CONVERGED):
        harmonics = recovery.rows @ whole_motion(dataset, balance, case, point)[here]
        largest[case, point] = von_mises(np.einsum("pch,nh->pnc", harmonics, balance.tables.E)).max(axis=1)
        amplitude[case, point], mean[case, point] = np.hypot(harmonics[..., 1], harmonics[..., 2]), harmonics[..., 0]
    dims = ("case", "point", "place")
    return dataset.assign(
        stress_von_mises=(dims, largest, {"units": "Pa", "long_name": "largest von Mises stress over the period, with the mean"}),
        stress_amplitude=((*dims, "component"), amplitude, {"units": "Pa", "long_name": "first harmonic of the stress"}),
        stress_mean=((*dims, "component"), mean, {"units": "Pa", "long_name": "mean stress"}),
    ).assign_coords(
        place=("place", list(recovery.places), {"units": "1", "long_name": "place of stress"}),
        component=("component", list(COMPONENTS), {"units": "1", "long_name": "component of stress in the axes of the body"}),
    )


def has_stress(dataset: xr.Dataset) -> bool:
    """Whether a result holds the stress along its curves."""
    return "stress_von_mises" in dataset.variables


def degrees_of_freedom(problem: Problem, recovery: StressRecovery) -> list[int]:
    """Rows of a problem's motion that a recovery goes by."""
    missing = [dof for dof in recovery.dofs if dof not in problem.structure.dofs]
    if missing:
        raise fault("The stress recovery", "must be of a body of this problem", missing[:3], "Give it the body's prefix.")
    return [problem.structure.index(dof) for dof in recovery.dofs]


def balance_of(dataset: xr.Dataset, problem: Problem) -> HarmonicBalance:
    """The balance that a result was computed with."""
    return HarmonicBalance(problem, int(dataset.attrs["harmonics"]), int(dataset.attrs["samples"]))


def whole_motion(dataset: xr.Dataset, balance: HarmonicBalance, case: int, point: int) -> Array:
    """q of every degree of freedom (n, 2H+1) from the contact forces and motions that a result keeps, m."""
    rows = [
        (c, ("t1", "t2", "n").index(name))
        for c, contact in enumerate(balance.problem.contacts)
        for name in contact.direction_names
    ]
    motion, carried = (
        np.array([real_harmonics(parts[c, d, :, 0] + 1j * parts[c, d, :, 1]) for c, d in rows]).reshape(
            len(rows), balance.columns
        )
        for parts in (dataset[name].values[case, point] for name in ("contact_motion", "contact_force"))
    )
    beyond_springs = carried - balance.stiffness[:, None] * motion
    omega = 2.0 * np.pi * float(dataset["frequency"].values[case, point])
    return balance.linear.whole_motion(beyond_springs, omega, float(dataset["force_level"].values[case]))
