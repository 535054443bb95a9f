"""Natural frequencies of a disk over the nodal diameters, and what a forced response of a disk keeps for its figures."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from stickslip.analyses.damping_by_nodal_diameter import VARIABLES as WAVE_VARIABLES
from stickslip.analyses.damping_by_nodal_diameter import damping_by_nodal_diameter
from stickslip.model.disks.full import FullDisk
from stickslip.model.disks.tuned import TunedDisk
from stickslip.model.problem import Problem
from stickslip.results.result import Result
from stickslip.support.checks import between, of_kind
from stickslip.support.late import xr

MODES = 6
"""Of each nodal diameter, unless given."""
STATES = ("free", "stuck")


@dataclass(frozen=True, eq=False, repr=False)
class NodalDiameters(Result):
    """`dataset`: disk_frequency (state, nodal_diameter, mode) [Hz], without contacts and with all of them stuck."""

    dataset: xr.Dataset
    problem: TunedDisk


def nodal_diameters(disk: TunedDisk, modes: int = MODES) -> NodalDiameters:
    """Natural frequencies of the first `modes` modes of every nodal diameter 0..N//2; rigid motions of free dampers left out."""
    of_kind("disk", disk, TunedDisk).disk.diameters.require_all()
    return NodalDiameters(_held(disk, modes), disk)


def _held(disk: TunedDisk, modes: int) -> xr.Dataset:
    """Those of the nodal diameters that the disk holds; NaN at the others."""
    frequencies = np.full((2, disk.sectors // 2 + 1, between("modes", modes, 1)), np.nan)
    for state in range(2):
        for n in disk.disk.diameters.held:
            found = disk.modes(n, stuck=state == 1).frequencies
            lowest = found[found > 0.0][:modes]
            frequencies[state, n, : lowest.size] = lowest
    variable = (("state", "nodal_diameter", "mode"), frequencies, {"units": "Hz", "long_name": "natural frequency"})
    coords: dict[str, Any] = {"state": list(STATES), "nodal_diameter": np.arange(frequencies.shape[1])}
    attrs: dict[str, Any] = {"sectors": disk.sectors, "engine_order": disk.engine_order, "title": disk.heading}
    attrs["excited_orders"] = list(disk.excited_orders)
    return xr.Dataset({"disk_frequency": variable}, coords, attrs)


def with_disk(dataset: xr.Dataset, problem: Problem) -> xr.Dataset:
    """A forced response with what the figures of its disk need; of any other problem as it is.

    disk_frequency, NaN at nodal diameters that a reduced sector does not hold; where the rig has a surface, disk_points (node,
    axis) [m], disk_quads (quad, corner) and disk_shape (node, axis, part), the first stuck mode at the nodal diameter of the
    first excited order, largest motion 1; attributes sectors, engine_order (g of several), excited_orders and, where dampers
    are pulled at, static_normal_load F_C/(2 cos α) [N].
    """
    if isinstance(problem, FullDisk | TunedDisk):
        dataset = dataset.assign_attrs(sectors=problem.sectors, engine_order=problem.engine_order)
    if not isinstance(problem, TunedDisk):
        return dataset
    dataset = dataset.assign_attrs(excited_orders=list(problem.excited_orders))
    found = _held(problem, MODES).rename(state="disk_state", mode="disk_mode")
    dataset = dataset.assign(disk_frequency=found["disk_frequency"]).assign_attrs(_static_normal_load(problem))
    if problem.aerodynamics:
        waves = damping_by_nodal_diameter(problem).dataset.rename(nodal_diameter="wave")
        dataset = dataset.assign(
            {f"wave_{name}": waves[name].variable for name in WAVE_VARIABLES} | {"wave": waves["wave"].variable}
        )
    if problem.surface is None:
        return dataset
    n = problem.excited_orders[0] % problem.sectors
    folded = min(n, problem.sectors - n)
    shape = problem.surface.shape(problem.modes(folded).shapes[:, 0], folded)
    shape = shape if n == folded else shape.conj()
    shape = shape / np.abs(shape).max()
    return dataset.assign(
        disk_points=(("disk_node", "axis"), problem.surface.points, {"units": "m", "long_name": "surface of one sector"}),
        disk_quads=(("disk_quad", "corner"), problem.surface.quads, {"units": "1", "long_name": "faces of the surface"}),
        disk_shape=(
            ("disk_node", "axis", "part"),
            np.stack([shape.real, shape.imag], axis=-1),
            {"units": "1", "long_name": "first stuck mode of the (first) excited nodal diameter"},
        ),
    )


def _static_normal_load(disk: TunedDisk) -> dict[str, float]:
    """N̄ = F_C/(2 cos α) of a contact line [N], by the equilibrium of a damper between two equal lines that one force pulls at."""
    pulls = [force for force in disk.forces if force.static]
    normals = [contact.normal for contact in disk.contacts]
    if len(pulls) != 1 or not normals or any(normal is None for normal in normals):
        return {}
    along = sum(n.get(dof, 0.0) * c for n in normals if n is not None for dof, c in pulls[0].coefficients.items())
    return {"static_normal_load": float(0.5 * pulls[0].static * len(normals) / along)} if along > 0.0 else {}


def has_disk(dataset: xr.Dataset) -> bool:
    """Whether a result is that of a disk."""
    return "sectors" in dataset.attrs
