"""The linear systems of bladed disks by harmonic: of one sector of a tuned disk, and of all sectors together."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from functools import cached_property
from math import gcd
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray
from scipy import linalg

from stickslip.model.problem import modal_damping_matrix
from stickslip.model.problem.systems import HarmonicSystems, LinearSystem, Wave
from stickslip.model.problem.truncation import kept_shapes, load_and_output_rows
from stickslip.model.structure.cyclic import WaveMatrices, sector_name
from stickslip.model.structure.matrices import ModalDamping, RayleighDamping
from stickslip.model.structure.modes import Modes, natural_modes
from stickslip.support.checks import Array

if TYPE_CHECKING:
    from stickslip.model.disks.tuned import FullDisk, TunedDisk

SAME = 1e-10
"""How far the blocks of a circulant matrix may differ, relative to its largest entry: rounding."""


def repeats(sectors: int, engine_order: int) -> int:
    """After how many sectors the motion under an engine order is in phase again, N / gcd(N, EO)."""
    return sectors // gcd(sectors, engine_order)


class SectorSystems(HarmonicSystems):
    """Systems of one sector of a tuned disk: harmonic h sees nodal diameter h EO mod N."""

    alike = False
    one_frame = False
    one_for_vibration = False

    def __init__(self, disk: TunedDisk) -> None:
        super().__init__(disk)
        self.disk, self.engine_order, self.sectors, self.gas = disk.disk, disk.engine_order, disk.sectors, disk.wave_stiffnesses
        self.repeats = self.sample_multiple = repeats(disk.sectors, disk.engine_order)
        self._known: dict[int, LinearSystem] = {}
        self._modes: dict[tuple[int, bool], Modes] = {}
        self._kept: dict[int, tuple[NDArray[Any], int]] = {}

    def key(self, harmonic: int) -> int:
        """The nodal diameter of a harmonic; −1 for harmonic 0 where springs act on the mean alone, or gas forces on vibration."""
        if self.stiffens:
            return harmonic
        return -1 if harmonic == 0 and (self.problem.mean_springs or self.gas) else harmonic * self.engine_order % self.sectors

    def at(self, harmonic: int) -> LinearSystem:
        """The system of a harmonic, computed once for all that share it."""
        key = self.key(harmonic)
        if key not in self._known:
            n = harmonic * self.engine_order
            M, stuck, C = self.matrices(n)
            assert C is not None
            if harmonic == 0:
                stuck = stuck + self.problem.mean_stiffness
            else:
                gas_stiffness, gas_damping = self.gas_forces(n)
                stuck, C = stuck + gas_stiffness, C + gas_damping
            system = LinearSystem(M, C, stuck, self.relative_rows(n), self.problem.output_rows)
            self._known[key] = self.stiffened(system, harmonic, self._added(n)) if self.stiffens else system
        return self._known[key]

    def kept(self, harmonic: int) -> tuple[NDArray[Any], int] | None:
        """Those of the nodal diameter of a harmonic, found once."""
        problem = self.problem
        if problem.modes_to is None:
            return None
        key = self.key(harmonic)
        if key not in self._kept:
            system = self.at(harmonic)
            M, K, B = (part if np.any(part.imag) else part.real for part in (system.M, system.K, system.B))
            squares, scaled = linalg.eigh(M, K)
            directions = load_and_output_rows(problem)
            self._kept[key] = kept_shapes(squares, scaled, B, problem.contact_stiffness, directions, problem.modes_to)
        return self._kept[key]

    def _added(self, nodal_diameter: int) -> NDArray[np.complex128]:
        """K₁ of a nodal diameter."""
        assert self.problem.speed is not None
        assert self.problem.speed.stiffness is not None
        return self.disk.diameters.pick(self.problem.speed.stiffness, nodal_diameter)

    def mass(self, harmonic: int) -> NDArray[np.complex128]:
        return self.disk.at(harmonic * self.engine_order).M

    def vibrating(self) -> Iterator[tuple[str, LinearSystem]]:
        """Waves of every nodal diameter that the disk holds, which gas forces may feed whatever the excitation is."""
        for n in [*(-n for n in reversed(self.disk.diameters.held) if 0 < 2 * n < self.sectors), *self.disk.diameters.held]:
            M, stuck, C = self.matrices(n)
            assert C is not None
            stiffness, damping = self.gas_forces(n)
            rows = self.relative_rows(n), self.problem.output_rows
            yield f" of nodal diameter {n}", LinearSystem(M, C + damping, stuck + stiffness, *rows)

    def without_contacts(self) -> Iterator[tuple[NDArray[Any], NDArray[Any], NDArray[Any]]]:
        """Those of every nodal diameter that the disk holds; N − n has the conjugates of n."""
        for n in self.disk.diameters.held:
            M, _, C = self.matrices(n)
            assert C is not None
            yield M, self.disk.at(n).K, C

    def free_stiffness(self, harmonic: int) -> NDArray[np.complex128]:
        return self.disk.at(harmonic * self.engine_order).K

    def gas_forces(self, nodal_diameter: int) -> tuple[Array, Array]:
        """What gas forces that go with the motion add to K and C of a nodal diameter, (n, n)."""
        stiffness, damping = np.zeros((2, self.disk.size, self.disk.size))
        for gas in self.gas:
            parts = gas.matrices(nodal_diameter, self.disk.row(gas.direction))
            stiffness, damping = stiffness + parts[0], damping + parts[1]
        return stiffness, damping

    def relative_rows(self, nodal_diameter: int) -> NDArray[np.complex128]:
        """B of a nodal diameter: relative contact displacements per motion of the sector, (rows, n)."""
        phase = np.exp(-2j * np.pi * (nodal_diameter % self.sectors) / self.sectors)
        rows = [self.disk.phased_row(d, phase) for contact in self.problem.contacts for d in contact.directions]
        return np.array(rows, dtype=complex).reshape(len(rows), self.disk.size)

    def matrices(self, nodal_diameter: int) -> WaveMatrices:
        """M, K + BᴴK_cB and C (the damping rule applied) of a nodal diameter, (n, n) complex."""
        bare, stuck = self.disk.at(nodal_diameter), self.stuck_stiffness(nodal_diameter)
        C = np.zeros_like(bare.M) if bare.C is None else bare.C
        match self.disk.damping:
            case RayleighDamping(mass_factor=a, stiffness_factor=b):
                C = np.asarray(a * bare.M + b * bare.K)
            case ModalDamping() as rule:
                C = np.asarray(modal_damping_matrix(bare.M, self.modes(nodal_diameter, rule.on == "stuck"), rule))  # type: ignore[arg-type]
        return WaveMatrices(bare.M, stuck, C)

    def stuck_stiffness(self, nodal_diameter: int) -> NDArray[np.complex128]:
        """K + BᴴK_cB of a nodal diameter."""
        B = self.relative_rows(nodal_diameter)
        return np.asarray(self.disk.at(nodal_diameter).K + B.conj().T @ (self.problem.contact_stiffness[:, None] * B))

    def modes(self, nodal_diameter: int, stuck: bool = True) -> Modes:
        """Natural modes of a nodal diameter with all contacts stuck, or without them; complex shapes of one sector."""
        n = nodal_diameter % self.sectors
        if (n, stuck) not in self._modes:
            bare = self.disk.at(n)
            self._modes[n, stuck] = natural_modes(bare.M, self.stuck_stiffness(n) if stuck else bare.K)  # type: ignore[arg-type]
        return self._modes[n, stuck]

    def frequencies(self, stuck: bool) -> Array:
        """Natural frequencies of all nodal diameters that the engine orders excite, Hz, ascending."""
        folded = {h: h * self.engine_order % self.sectors for h in self.excited}
        diameters = {h if self.stiffens else min(n, self.sectors - n): h for h, n in folded.items()}
        return np.sort(np.concatenate([self.frequencies_of(h, stuck) for h in diameters.values()]))

    def frequencies_of(self, harmonic: int, stuck: bool) -> Array:
        """Natural frequencies of the nodal diameter of a harmonic, Hz, ascending; where the speed stiffens them, those at which
        this harmonic meets them."""
        if self.stiffens:
            return self.synchronous(stuck, harmonic)
        return self.modes(harmonic * self.engine_order, stuck).frequencies


class AllSectorSystems(HarmonicSystems):
    """Systems of all sectors of a disk: N uncoupled waves of a sector's size where they are equal, else one large system."""

    one_frame = False

    def __init__(self, disk: FullDisk) -> None:
        super().__init__(disk)
        self.sectors, self.gas = disk.sectors, disk.aerodynamics
        self.sample_multiple = repeats(disk.sectors, disk.engine_order)

    @property
    def alike(self) -> bool:
        """Whether one real system serves every harmonic: gas forces that go with the motion do not act on the mean."""
        return super().alike and not self.gas

    def at(self, harmonic: int) -> LinearSystem:
        """The system of a harmonic; complex Hermitian where gas forces go with the motion."""
        system = super().at(harmonic)
        if harmonic == 0 or not self.gas:
            return system
        stiffness, damping = self.gas_forces
        return system._replace(K=system.K + stiffness, C=system.C + damping)

    @cached_property
    def gas_forces(self) -> tuple[NDArray[np.complex128], NDArray[np.complex128]]:
        """What gas forces that go with the motion add to K and C of the whole disk, (n, n)."""
        structure, size = self.problem.structure, self.problem.structure.size
        stiffness, damping = np.zeros((2, size, size), dtype=complex)
        for gas in self.gas:
            named = [{sector_name(j, dof): c for dof, c in gas.direction.items()} for j in range(1, self.sectors + 1)]
            rows = structure.rows(named)
            parts = gas.between_sectors()
            stiffness, damping = stiffness + rows.T @ parts[0] @ rows, damping + rows.T @ parts[1] @ rows
        return stiffness, damping

    @cached_property
    def uncoupled(self) -> bool:
        """Whether structure, damping and contact stiffness of all sectors are alike, to rounding."""
        problem = self.problem
        matrices = [problem.structure.M, problem.C, problem.stuck_stiffness]
        if problem.speed is not None and problem.speed.stiffness is not None:
            matrices.append(problem.speed.stiffness)
        return all(_is_circulant(matrix, self.sectors) for matrix in matrices)

    def waves(self, harmonic: int) -> Sequence[Wave]:
        """N small systems, one for each nodal diameter, instead of a large one; of a mistuned disk the large one."""
        if not self.uncoupled:
            return super().waves(harmonic)
        whole = self.at(harmonic)
        N = self.sectors
        # Blocks (j, 0) of a circulant matrix times exp(+i n 2π j/N), summed; rows of B and outputs times exp(−i n 2π j/N)/√N.
        M, C, K = (N * np.fft.ifft(matrix.reshape(N, -1, N, matrix.shape[1] // N)[:, :, 0], axis=0) for matrix in whole[:3])
        B, outputs = (np.fft.fft(rows.reshape(rows.shape[0], N, rows.shape[1] // N), axis=1) / np.sqrt(N) for rows in whole[3:])
        turns = np.exp(-2j * np.pi * np.outer(np.arange(N), np.arange(N)) / N) / np.sqrt(N)
        M, C, K = (0.5 * (blocks + blocks.conj().swapaxes(1, 2)) for blocks in (M, C, K))
        return [Wave(turns[n], LinearSystem(M[n], C[n], K[n], B[:, n], outputs[:, n])) for n in range(N)]


def _is_circulant(matrix: Array, sectors: int) -> bool:
    """Whether block (j, k) of a matrix depends on j − k alone, to rounding."""
    size, rest = divmod(matrix.shape[0], sectors)
    if rest:
        return False
    blocks = matrix.reshape(sectors, size, sectors, size)
    turned = np.roll(blocks, (1, 1), axis=(0, 2))
    return bool(np.abs(turned - blocks).max() <= SAME * np.abs(blocks).max(initial=1e-300))
