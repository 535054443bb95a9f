"""Natural frequencies of a disk over the nodal diameters, and what a forced response of a disk keeps for its figures.

Damping of every travelling wave of a bladed disk with gas forces that go with its motion, by nodal diameter.
"""

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy import linalg

from stickslip.model.disks.tuned import FullDisk, TunedDisk
from stickslip.model.problem import Problem
from stickslip.results.schema import Result, named, tabulated
from stickslip.support.checks import between, fault, of_kind
from stickslip.support.late import pd, xr

OF_WAVES = ("damping_ratio", "aerodynamic_damping", "frequency", "frequency_shift")


@dataclass(frozen=True, eq=False, repr=False)
class DampingByNodalDiameter(Result):
    """`dataset` over nodal_diameter, −(N−1)//2 to N//2, negative for waves that run against the numbering of the sectors:
    damping_ratio, aerodynamic_damping, frequency [Hz], frequency_shift, and stiffness (gas_force, nodal_diameter, part) [N/m]."""

    dataset: "xr.Dataset"
    problem: TunedDisk

    def table(self) -> "pd.DataFrame":
        """The numbers by nodal diameter, least damped first."""
        found = self.dataset[list(OF_WAVES)].to_dataframe().reset_index()
        return found.sort_values("damping_ratio", ignore_index=True)


def damping_by_nodal_diameter(disk: TunedDisk, mode: int = 1, stuck: bool = True) -> DampingByNodalDiameter:
    """Damping ratio and frequency of the waves of one family of modes, from the eigenvalues with and without gas forces.

    K_n + Re A_n + s (C_n + Im A_n/ω) + s² M_n, A_n the complex stiffness of the gas forces at ω, has for each wave the eigenvalue
    s = −ζω₀ + iω₀√(1−ζ²); that whose shape is nearest to the mode without gas forces is taken.
    mode: number of the family, 1 the lowest; stuck: with all contacts stuck, else without them. Both are linear: what friction
    adds at an amplitude, `nonlinear_modes` and `limit_cycles` of the disk at that engine order say.
    """
    of_kind("disk", disk, TunedDisk)
    of_kind("stuck", stuck, bool)
    between("mode", mode, 1, disk.structure.size)
    if not disk.aerodynamics:
        raise fault("disk", "must have aerodynamics", "none", "Give it some: disk.with_aerodynamics(...).")
    numbers = np.arange(-((disk.sectors - 1) // 2), disk.sectors // 2 + 1)
    waves = [_wave(disk, int(n), mode, stuck) for n in numbers]
    values = np.array([gas.waves[numbers % disk.sectors] for gas in disk.wave_stiffnesses])
    data = dict(zip(OF_WAVES, np.transpose(waves), strict=True))
    data["stiffness"] = np.stack([values.real, values.imag], axis=-1)
    coords = {"nodal_diameter": numbers, "part": ["re", "im"]}
    attrs = {"sectors": disk.sectors, "mode": mode, "contacts": "stuck" if stuck else "free", "title": disk.title}
    return DampingByNodalDiameter(tabulated("damping_by_nodal_diameter", data, coords, attrs), disk)


def _wave(disk: TunedDisk, nodal_diameter: int, mode: int, stuck: bool) -> tuple[float, float, float, float]:
    """Damping ratio, what gas forces add to it, frequency in Hz and its relative change, of one wave."""
    systems = disk.systems
    M, K, C = systems.matrices(nodal_diameter)
    assert C is not None
    if not stuck:
        K = disk.disk.at(nodal_diameter).K
    modes = disk.modes(nodal_diameter, stuck)
    elastic = np.flatnonzero(modes.squares > 0.0)
    if mode > elastic.size:
        raise fault("mode", f"must lie between 1 and {elastic.size}", mode)
    shape = modes.shapes[:, elastic[mode - 1]]
    gas_stiffness, gas_damping = systems.gas_forces(nodal_diameter)
    with_gas, without = _eigenvalue(M, K + gas_stiffness, C + gas_damping, shape), _eigenvalue(M, K, C, shape)
    ratios, sizes = [-s.real / abs(s) for s in (with_gas, without)], [abs(s) for s in (with_gas, without)]
    return ratios[0], ratios[0] - ratios[1], sizes[0] / (2.0 * np.pi), sizes[0] / sizes[1] - 1.0


def _eigenvalue(M: NDArray[Any], K: NDArray[Any], C: NDArray[Any], shape: NDArray[Any]) -> complex:
    """s of (K + s C + s² M) x = 0 with positive imaginary part whose x is nearest to a mass-normalised shape."""
    size = M.shape[0]
    A = np.block([[np.zeros((size, size)), np.eye(size)], [-linalg.solve(M, K), -linalg.solve(M, C)]])
    values, vectors = linalg.eig(A)
    x = vectors[:size]
    energies = np.einsum("ik,ij,jk->k", x.conj(), M, x).real
    near = np.abs(shape.conj() @ M @ x) / np.sqrt(np.maximum(energies, np.finfo(float).tiny))
    return complex(values[int(np.argmax(np.where(values.imag > 0.0, near, -1.0)))])


MODES = 6
"""Of each nodal diameter, unless given."""
STATES = ("free", "stuck")
OF_DISK = "interference_diagram"
"""The table of `variables.toml` with what results of disks have."""


@dataclass(frozen=True, eq=False, repr=False)
class NodalDiameters(Result):
    """`dataset`: disk_frequency (disk_state, nodal_diameter, disk_mode) [Hz], without contacts and with all of them stuck."""

    dataset: "xr.Dataset"
    problem: TunedDisk


def nodal_diameters(disk: TunedDisk, modes: int = MODES) -> NodalDiameters:
    """Natural frequencies of the first `modes` modes of every nodal diameter 0..N//2; rigid motions of free dampers left out."""
    of_kind("disk", disk, TunedDisk).disk.diameters.require_all()
    return NodalDiameters(_held(disk, modes), disk)


def _held(disk: TunedDisk, modes: int) -> "xr.Dataset":
    """Those of the nodal diameters that the disk holds; NaN at the others."""
    frequencies = np.full((2, disk.sectors // 2 + 1, between("modes", modes, 1)), np.nan)
    for state in range(2):
        for n in disk.disk.diameters.held:
            found = disk.modes(n, stuck=state == 1).frequencies
            lowest = found[found > 0.0][:modes]
            frequencies[state, n, : lowest.size] = lowest
    coords = {"disk_state": list(STATES), "nodal_diameter": np.arange(frequencies.shape[1]), "disk_mode": np.arange(1, modes + 1)}
    attrs: dict[str, Any] = {"sectors": disk.sectors, "engine_order": disk.engine_order, "title": disk.heading}
    attrs["excited_orders"] = list(disk.excited_orders)
    return tabulated(OF_DISK, {"disk_frequency": frequencies}, coords, attrs)


def with_disk(dataset: "xr.Dataset", problem: Problem) -> "xr.Dataset":
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
    found = _held(problem, MODES)
    dataset = dataset.assign(disk_frequency=found["disk_frequency"]).assign_attrs(_static_normal_load(problem))
    if problem.aerodynamics:
        waves = damping_by_nodal_diameter(problem).dataset.rename(nodal_diameter="wave")
        dataset = dataset.assign({f"wave_{name}": waves[name].variable for name in OF_WAVES} | {"wave": waves["wave"].variable})
    if problem.surface is None:
        return dataset
    n = problem.excited_orders[0] % problem.sectors
    folded = min(n, problem.sectors - n)
    shape = problem.surface.shape(problem.modes(folded).shapes[:, 0], folded)
    shape = shape if n == folded else shape.conj()
    shape = shape / np.abs(shape).max()
    return dataset.assign(
        disk_points=named(("disk_node", "axis"), problem.surface.points, "surface of one sector", "m"),
        disk_quads=named(("disk_quad", "corner"), problem.surface.quads, "faces of the surface"),
        disk_shape=named(
            ("disk_node", "axis", "part"),
            np.stack([shape.real, shape.imag], axis=-1),
            "first stuck mode of the (first) excited nodal diameter",
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


def has_disk(dataset: "xr.Dataset") -> bool:
    """Whether a result is that of a disk."""
    return "sectors" in dataset.attrs
