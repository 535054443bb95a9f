"""Stress over the period of one point of a forced response, at the places of a `StressRecovery`."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from stickslip.checks import Array, fault
from stickslip.harmonic.balance import HarmonicBalance
from stickslip.harmonic.fourier import complex_harmonics, real_harmonics
from stickslip.problem import Problem
from stickslip.structure.stress import COMPONENTS, StressRecovery, von_mises

if TYPE_CHECKING:
    import xarray as xr


def stress(dataset: xr.Dataset, problem: Problem, case: int, point: int, recovery: StressRecovery) -> xr.Dataset:
    """`stress` (place, component, harmonic, part), `amplitude` of the first harmonic (place, component), `largest` (place,
    component) in size over the period, and `von_mises` (place), its largest over the period; all with the mean, Pa."""
    import xarray as xr

    missing = [dof for dof in recovery.dofs if dof not in problem.structure.dofs]
    if missing:
        raise fault("The stress recovery", "must be of a body of this problem", missing[:3], "Give it the body's prefix.")
    if int(dataset["outcome"].values[case, point]) != 1:
        raise fault("The point", "must have converged", (case, point))
    balance = HarmonicBalance(problem, int(dataset.attrs["harmonics"]), int(dataset.attrs["samples"]))
    q = whole_motion(dataset, balance, case, point)
    here = [problem.structure.index(dof) for dof in recovery.dofs]
    harmonics = recovery.rows @ q[here]
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
