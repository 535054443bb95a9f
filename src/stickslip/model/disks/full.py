"""A disk with every sector of its own: all sectors together, tuned or mistuned."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from hashlib import sha256

import numpy as np
from numpy.typing import NDArray

from stickslip.model.disks.systems import AllSectorSystems
from stickslip.model.problem import Problem
from stickslip.model.structure.aerodynamics import WaveStiffness
from stickslip.model.structure.cyclic import CyclicStructure, Waves, circulant, of_all_sectors, sector_name
from stickslip.model.structure.matrices import Structure
from stickslip.model.structure.sector_surface import SectorSurface
from stickslip.model.structure.stress import StressRecovery


@dataclass(frozen=True, eq=False, repr=False)
class FullDisk(Problem):
    """A disk with all its sectors, tuned or mistuned: a `Problem` that knows how many there are and what excites them.

    aerodynamics: gas forces that go with the motion, by wave; mistuning leaves them as they are. surface: of a meshed sector, for
    pictures. stresses: at places of one sector, from the motion of its waves.
    """

    sectors: int = 1
    engine_order: int = 0
    aerodynamics: tuple[WaveStiffness, ...] = ()
    surface: SectorSurface | None = None
    stresses: tuple[StressRecovery, ...] = ()

    def __repr__(self) -> str:
        return f"{super().__repr__()}; {self.sectors} sectors, engine order {self.engine_order}"

    @cached_property
    def systems(self) -> AllSectorSystems:
        return AllSectorSystems(self)

    @cached_property
    def fingerprint(self) -> str:
        """As of any problem, with the gas forces that go with the motion."""
        if not self.aerodynamics:
            return super().fingerprint
        return sha256(f"{super().fingerprint} {self.aerodynamics!r}".encode()).hexdigest()[:16]

    @property
    def tuned(self) -> bool:
        """Whether structure, damping and contact stiffness of all sectors are alike, to rounding."""
        return self.systems.uncoupled


def full_structure(
    disk: CyclicStructure, dampings: NDArray[np.complex128] | None = None, shapes: Waves | None = None
) -> Structure:
    """All sectors of a disk as one real structure, names "SECTOR/NODE.DIRECTION"; dampings: C of each nodal diameter; shapes:
    coordinates of each nodal diameter on which the disk is projected, (N//2 + 1, m, k) (`few_waves`)."""
    M, K = (circulant(projected(disk.every(waves), shapes), disk.sectors) for waves in (disk.masses, disk.stiffnesses))
    C = None if dampings is None or not dampings.any() else circulant(projected(dampings, shapes), disk.sectors)
    names = tuple(sector_name(j, dof) for j in range(1, disk.sectors + 1) for dof in disk.dofs)
    return Structure(M, K, names, C, shapes=None if shapes is None else of_all_sectors(shapes, disk.sectors))


def projected(waves: Waves, shapes: Waves | None) -> Waves:
    """Tᴴ A T of each nodal diameter, (N//2 + 1, k, k); A itself without shapes T."""
    return waves if shapes is None else np.asarray(shapes.conj().swapaxes(1, 2) @ waves @ shapes)
