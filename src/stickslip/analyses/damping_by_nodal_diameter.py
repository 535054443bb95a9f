"""Damping of every travelling wave of a bladed disk with gas forces that go with its motion, by nodal diameter."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy import linalg

from stickslip.model.disks.tuned import TunedDisk
from stickslip.results.result import Result
from stickslip.support.checks import between, fault, of_kind
from stickslip.support.late import pd, xr

VARIABLES = {
    "damping_ratio": ("1", "damping ratio of the wave, with gas forces"),
    "aerodynamic_damping": ("1", "aerodynamic damping ratio: what gas forces add to it"),
    "frequency": ("Hz", "natural frequency of the wave, with gas forces"),
    "frequency_shift": ("1", "change of the natural frequency by gas forces, relative"),
}


@dataclass(frozen=True, eq=False, repr=False)
class DampingByNodalDiameter(Result):
    """`dataset` over nodal_diameter, −(N−1)//2 to N//2, negative for waves that run against the numbering of the sectors:
    damping_ratio, aerodynamic_damping, frequency [Hz], frequency_shift, and stiffness (gas_force, nodal_diameter, part) [N/m]."""

    dataset: xr.Dataset
    problem: TunedDisk

    def table(self) -> pd.DataFrame:
        """The numbers by nodal diameter, least damped first."""
        found = self.dataset[list(VARIABLES)].to_dataframe().reset_index()
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
    data: dict[str, Any] = {
        name: ("nodal_diameter", [wave[k] for wave in waves], {"units": units, "long_name": words})
        for k, (name, (units, words)) in enumerate(VARIABLES.items())
    }
    values = np.array([gas.waves[numbers % disk.sectors] for gas in disk.wave_stiffnesses])
    words = {"units": "N/m", "long_name": "complex stiffness of the gas forces along their direction"}
    data["stiffness"] = (("gas_force", "nodal_diameter", "part"), np.stack([values.real, values.imag], axis=-1), words)
    coords: dict[str, Any] = {"nodal_diameter": numbers, "part": ["re", "im"]}
    attrs = {"sectors": disk.sectors, "mode": mode, "contacts": "stuck" if stuck else "free", "title": disk.title}
    return DampingByNodalDiameter(xr.Dataset(data, coords, attrs), disk)


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
