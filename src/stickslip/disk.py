"""Bladed disks: a tuned disk under engine-order excitation as one sector, and the same disk with every sector of its own.

Engine order EO forces sector j (0..N−1) by F cos(ωt − 2π EO j/N). The steady motion travels along: sector j is late by j EO/N
periods. So harmonic h has nodal diameter h EO mod N, and the far side of a damper sees the neighbour's motion times
exp(−i h 2π EO/N).
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from hashlib import sha256
from math import gcd

import numpy as np
from numpy.typing import NDArray

from stickslip.checks import Array, InputError, fault, several, unique, whole
from stickslip.contact.point import Contact
from stickslip.contact.start import TractionRatio
from stickslip.loads import BaseMotion, Force, Output
from stickslip.problem import LinearSystem, Problem, modal_damping_matrix
from stickslip.structure.cyclic import NEXT, CyclicStructure, WaveMatrices, circulant, sector_name
from stickslip.structure.damping import ModalDamping, RayleighDamping
from stickslip.structure.matrices import Structure
from stickslip.structure.modes import Modes, natural_modes
from stickslip.structure.sector_surface import SectorSurface


@dataclass(frozen=True, eq=False, repr=False)
class TunedDisk(Problem):
    """A disk of equal sectors and dampers under engine-order excitation, solved as one sector.

    structure: a `CyclicStructure`. Contacts, forces and outputs are those of the first sector; a contact between a sector and the
    following one names the latter's degrees of freedom with the prefix "next/". Its `load` is that on the first sector.
    surface: of a meshed sector, for pictures.
    """

    engine_order: int = 1
    surface: SectorSurface | None = None

    def __post_init__(self) -> None:
        if not isinstance(self.structure, CyclicStructure):
            raise InputError("A tuned disk must have a cyclic structure. Make it by `cyclic` or `sector_chain`.")
        if not _is_whole(self.engine_order) or not 0 <= self.engine_order <= self.sectors:
            rule = f"must be a whole number and lie between 0 and the number of sectors, {self.sectors}"
            raise fault("engine_order", rule, self.engine_order, "Engine order EO + N acts as EO does, turn by turn.")
        if self.dashpots or any(isinstance(force, BaseMotion) for force in self.forces):
            raise InputError("A tuned disk must be without dashpots and base motion. Put dampers into the sector's C.")
        for what, names in (("A force", [f.coefficients for f in self.forces]), ("An output", self._output_directions())):
            beyond = sorted(dof for direction in names for dof in direction if dof.startswith(NEXT))
            if beyond:
                raise fault(what, "must act on the sector itself", beyond)
        super().__post_init__()

    def __repr__(self) -> str:
        return f"{super().__repr__()}; one of {self.sectors} sectors, engine order {self.engine_order}"

    def _output_directions(self) -> list[Mapping[str, float]]:
        return [Output.of(output).direction for output in self.outputs]

    @property
    def disk(self) -> CyclicStructure:
        """The structure, as what it is."""
        assert isinstance(self.structure, CyclicStructure)
        return self.structure

    @property
    def sectors(self) -> int:
        return self.disk.sectors

    @property
    def repeats(self) -> int:
        return self.sectors // gcd(self.sectors, self.engine_order)

    @property
    def sample_multiple(self) -> int:
        return self.repeats

    @property
    def differs_by_harmonic(self) -> bool:
        return True

    def wave(self, harmonic: int) -> int:
        """The nodal diameter of a harmonic, h EO mod N; −1 for harmonic 0 where springs act on the mean alone."""
        return -1 if harmonic == 0 and self.mean_springs else harmonic * self.engine_order % self.sectors

    def relative_rows(self, nodal_diameter: int) -> NDArray[np.complex128]:
        """B of a nodal diameter: relative contact displacements per motion of the sector, (rows, n)."""
        phase = np.exp(-2j * np.pi * (nodal_diameter % self.sectors) / self.sectors)
        rows = [self.disk.phased_row(d, phase) for contact in self.contacts for d in contact.directions]
        return np.array(rows, dtype=complex).reshape(len(rows), self.structure.size)

    def matrices(self, nodal_diameter: int) -> WaveMatrices:
        """M, K + BᴴK_cB and C (the damping rule applied) of a nodal diameter, (n, n) complex."""
        bare = self.disk.at(nodal_diameter)
        B = self.relative_rows(nodal_diameter)
        stuck = bare.K + B.conj().T @ (self.contact_stiffness[:, None] * B)
        return WaveMatrices(bare.M, stuck, self._damping(bare, stuck))

    def _damping(self, bare: WaveMatrices, stuck: NDArray[np.complex128]) -> NDArray[np.complex128]:
        if bare.C is not None:
            return bare.C
        match self.structure.damping:
            case RayleighDamping(mass_factor=a, stiffness_factor=b):
                return np.asarray(a * bare.M + b * bare.K)
            case ModalDamping() as rule:
                return np.asarray(modal_damping_matrix(bare.M, stuck if rule.on == "stuck" else bare.K, rule))  # type: ignore[arg-type]
        return np.zeros_like(bare.M)

    def system(self, harmonic: int) -> LinearSystem:
        n = harmonic * self.engine_order
        M, stuck, C = self.matrices(n)
        assert C is not None
        stiffness = stuck + (self.mean_stiffness if harmonic == 0 else 0.0)
        return LinearSystem(M, C, stiffness, self.relative_rows(n), self.output_rows)

    def modes(self, nodal_diameter: int, stuck: bool = True) -> Modes:
        """Natural modes of a nodal diameter with all contacts stuck, or without them; complex shapes of one sector."""
        bare = self.disk.at(nodal_diameter)
        return natural_modes(bare.M, self.matrices(nodal_diameter).K if stuck else bare.K)  # type: ignore[arg-type]

    def frequencies(self, stuck: bool) -> Array:
        """Natural frequencies of the nodal diameter that the first harmonic excites, Hz, ascending."""
        return self.modes(self.engine_order, stuck).frequencies

    @cached_property
    def fingerprint(self) -> str:
        """As of any problem, with the matrices of every nodal diameter and the engine order."""
        digest = sha256(super().fingerprint.encode())
        disk = self.disk
        for waves in (disk.masses, disk.stiffnesses, disk.dampings, self.relative_rows(1)):
            digest.update(b"" if waves is None else np.ascontiguousarray(waves).tobytes())
        digest.update(f"engine order {self.engine_order} of {self.sectors}".encode())
        return digest.hexdigest()[:16]

    def with_engine_order(self, engine_order: int) -> TunedDisk:
        """A copy under another engine order."""
        return replace(self, engine_order=engine_order)

    def full(self, reported: Sequence[int] | None = None) -> FullDisk:
        """The whole disk, every sector and damper of its own, names "SECTOR/NODE.DIRECTION", sectors from 1 on.

        reported: sectors whose outputs are reported, all unless given. The structure, damping and loads are those of the tuned
        disk; `with_structure` and `with_contacts` then detune it.
        """
        sectors = range(1, self.sectors + 1)
        chosen = sectors if reported is None else sectors_of("reported", reported, self.sectors) or sectors
        waves = [self.matrices(n).C for n in range(self.sectors // 2 + 1)]
        structure = full_structure(self.disk, np.array(waves))
        return FullDisk(
            structure,
            tuple(self._contact(contact, j) for j in sectors for contact in self.contacts),
            tuple(self._force(force, j) for j in sectors for force in self.forces),
            tuple(self._output(output, j) for j in chosen for output in self.outputs),
            f"{self.title}, all {self.sectors} sectors",
            tuple(replace(spring, direction=self._named(spring.direction, j)) for j in sectors for spring in self.mean_springs),
            self.sectors,
            self.engine_order,
        )

    def _named(self, direction: Mapping[str, float], sector: int) -> dict[str, float]:
        """A direction of the first sector in the names of another one and of the one that follows it."""
        following = sector % self.sectors + 1
        return {
            sector_name(following if dof.startswith(NEXT) else sector, dof.removeprefix(NEXT)): coefficient
            for dof, coefficient in direction.items()
        }

    def _contact(self, contact: Contact, sector: int) -> Contact:
        if sector > 1 and any(isinstance(start, TractionRatio) for start in contact.starts):
            raise InputError(
                "Start states of a full disk must be slider offsets or mean tractions, but contact "
                f"{contact.name!r} has a traction ratio, which is tied to the last sample of the first sector, not of the others."
            )
        tangential = tuple(self._named(direction, sector) for direction in contact.tangential)
        normal = None if contact.normal is None else self._named(contact.normal, sector)
        return replace(contact, name=f"{sector} {contact.name}", tangential=tangential, normal=normal)

    def _force(self, force: Force, sector: int) -> Force:
        turn = np.exp(-2j * np.pi * self.engine_order * (sector - 1) / self.sectors)
        amplitudes = {h: amplitude * turn**h for h, amplitude in force.amplitudes.items()}
        return replace(force, direction=self._named(force.coefficients, sector), amplitude=amplitudes)

    def _output(self, output: str | Output, sector: int) -> Output:
        given = Output.of(output)
        return Output(f"{sector}/{given.name}", self._named(given.direction, sector))


@dataclass(frozen=True, eq=False, repr=False)
class FullDisk(Problem):
    """A disk with all its sectors, tuned or mistuned: a `Problem` that knows how many there are and what excites them."""

    sectors: int = 1
    engine_order: int = 0

    def __repr__(self) -> str:
        return f"{super().__repr__()}; {self.sectors} sectors, engine order {self.engine_order}"

    @property
    def sample_multiple(self) -> int:
        return self.sectors // gcd(self.sectors, self.engine_order)

    @cached_property
    def tuned(self) -> bool:
        """Whether structure, damping and contact stiffness of all sectors are alike, to rounding."""
        return all(_is_circulant(matrix, self.sectors) for matrix in (self.structure.M, self.C, self.stuck_stiffness))

    @property
    def has_uncoupled_waves(self) -> bool:
        return self.tuned

    def waves(self, harmonic: int) -> Sequence[tuple[NDArray[np.complex128], LinearSystem]]:
        """N small systems, one for each nodal diameter, instead of a large one; of a mistuned disk the large one."""
        if not self.tuned:
            return super().waves(harmonic)
        whole = self.system(harmonic)
        N = self.sectors
        # Blocks (j, 0) of a circulant matrix times exp(+i n 2π j/N), summed; rows of B and outputs times exp(−i n 2π j/N)/√N.
        M, C, K = (N * np.fft.ifft(matrix.reshape(N, -1, N, matrix.shape[1] // N)[:, :, 0], axis=0) for matrix in whole[:3])
        B, outputs = (np.fft.fft(rows.reshape(rows.shape[0], N, rows.shape[1] // N), axis=1) / np.sqrt(N) for rows in whole[3:])
        turns = np.exp(-2j * np.pi * np.outer(np.arange(N), np.arange(N)) / N) / np.sqrt(N)
        M, C, K = (0.5 * (blocks + blocks.conj().swapaxes(1, 2)) for blocks in (M, C, K))
        return [(turns[n], LinearSystem(M[n], C[n], K[n], B[:, n], outputs[:, n])) for n in range(N)]


def sectors_of(what: str, given: Sequence[int], sectors: int) -> tuple[int, ...]:
    """Sectors of a disk, each from 1 to `sectors` and given once."""
    found = tuple(whole(what, sector) for sector in several(what, given))
    unknown = [sector for sector in found if not 1 <= sector <= sectors]
    if unknown:
        raise fault(what, f"must hold sectors from 1 to {sectors}", unknown)
    unique(what, found)
    return found


def full_structure(disk: CyclicStructure, dampings: NDArray[np.complex128] | None = None) -> Structure:
    """All sectors of a disk as one real structure, names "SECTOR/NODE.DIRECTION"; dampings: C of each nodal diameter."""
    assert disk.masses is not None
    assert disk.stiffnesses is not None
    M, K = (circulant(waves, disk.sectors) for waves in (disk.masses, disk.stiffnesses))
    C = None if dampings is None or not dampings.any() else circulant(dampings, disk.sectors)
    return Structure(M, K, tuple(sector_name(j, dof) for j in range(1, disk.sectors + 1) for dof in disk.dofs), C)


def _is_whole(value: object) -> bool:
    return isinstance(value, int | np.integer) and not isinstance(value, bool)


def _is_circulant(matrix: Array, sectors: int) -> bool:
    """Whether block (j, k) of a matrix depends on j − k alone, to rounding."""
    size, rest = divmod(matrix.shape[0], sectors)
    if rest:
        return False
    blocks = matrix.reshape(sectors, size, sectors, size)
    turned = np.roll(blocks, (1, 1), axis=(0, 2))
    return bool(np.abs(turned - blocks).max() <= 1e-10 * np.abs(blocks).max(initial=1e-300))
