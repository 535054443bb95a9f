"""Outer surface of a meshed sector and its motion, for pictures of the disk and its modes."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from stickslip.model.structure.cyclic_reduction import CyclicReduction, Sector
from stickslip.model.structure.mesh_surface import boundary, recovery_rows
from stickslip.support.checks import Array


@dataclass(frozen=True, eq=False)
class SectorSurface:
    """points (p, 3) [m] and quads (q, 4) of one sector, in its own axes; motions: per nodal diameter 0..N//2, displacements
    (p, 3, m) of the points per reduced degree of freedom, in single precision.
    """

    points: Array
    quads: NDArray[np.int64]
    motions: tuple[NDArray[Any], ...]

    def shape(self, q: NDArray[Any], nodal_diameter: int) -> NDArray[Any]:
        """Complex displacements (p, 3) of the surface for the first degrees of freedom of q, at nodal diameter 0..N//2."""
        motion = self.motions[nodal_diameter]
        return np.asarray(motion @ q[: motion.shape[2]])

    def wave(self, q: NDArray[Any], n: int, sectors: int) -> NDArray[Any]:
        """The same at any whole number n: n and n + N are one wave, that of N − n runs the other way, its matrices conjugates."""
        n %= sectors
        return self.shape(q, n) if n <= sectors // 2 else self.shape(q.conj(), sectors - n).conj()

    def shapes(self, q: NDArray[Any]) -> NDArray[Any]:
        """Complex displacements (N, p, 3) of all sectors, each in its own axes, for the motions q (N, m) of the reduced sectors.

        q_j = Σ_n q̂_n exp(−i n 2π j/N), u_j = Σ_n T_n q̂_n exp(−i n 2π j/N), the sums over n = 0..N−1.
        """
        waves = np.fft.ifft(q, axis=0)
        return np.fft.fft(np.array([self.wave(wave, n, len(q)) for n, wave in enumerate(waves)]), axis=0)


def sector_surface(mesh: Any, sector: Sector, reduction: CyclicReduction) -> SectorSurface:
    """The boundary of a scikit-fem mesh without the cyclic faces, which lie inside the disk."""
    points, quads, numbers = boundary(mesh, sector.solid, (sector.left, sector.right))
    motions = tuple(recovery_rows(T, numbers).reshape(*points.shape, -1) for T in reduction.transformations)
    return SectorSurface(points, quads, motions)
