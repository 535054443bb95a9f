"""A disk with every sector of its own: all sectors together, tuned or mistuned."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from math import gcd

import numpy as np
from numpy.typing import NDArray

from stickslip.checks import Array
from stickslip.problem import LinearSystem, Problem
from stickslip.structure.cyclic import CyclicStructure, circulant, sector_name
from stickslip.structure.matrices import Structure


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


def full_structure(disk: CyclicStructure, dampings: NDArray[np.complex128] | None = None) -> Structure:
    """All sectors of a disk as one real structure, names "SECTOR/NODE.DIRECTION"; dampings: C of each nodal diameter."""
    assert disk.masses is not None
    assert disk.stiffnesses is not None
    M, K = (circulant(waves, disk.sectors) for waves in (disk.masses, disk.stiffnesses))
    C = None if dampings is None or not dampings.any() else circulant(dampings, disk.sectors)
    return Structure(M, K, tuple(sector_name(j, dof) for j in range(1, disk.sectors + 1) for dof in disk.dofs), C)


def _is_circulant(matrix: Array, sectors: int) -> bool:
    """Whether block (j, k) of a matrix depends on j − k alone, to rounding."""
    size, rest = divmod(matrix.shape[0], sectors)
    if rest:
        return False
    blocks = matrix.reshape(sectors, size, sectors, size)
    turned = np.roll(blocks, (1, 1), axis=(0, 2))
    return bool(np.abs(turned - blocks).max() <= 1e-10 * np.abs(blocks).max(initial=1e-300))
