"""Outer surface of a meshed sector and its motion, for pictures of the disk and its modes."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from stickslip.checks import Array
from stickslip.structure.cyclic_reduction import CyclicReduction, Sector


@dataclass(frozen=True, eq=False)
class SectorSurface:
    """points (p, 3) [m] and quads (q, 4) of one sector, in its own axes; motions: per nodal diameter 0..N//2, displacements
    (p, 3, m) of the points per reduced degree of freedom.
    """

    points: Array
    quads: NDArray[np.int64]
    motions: tuple[NDArray[Any], ...]

    def shape(self, q: NDArray[Any], nodal_diameter: int) -> NDArray[Any]:
        """Complex displacements (p, 3) of the surface for the first degrees of freedom of q, at nodal diameter 0..N//2."""
        motion = self.motions[nodal_diameter]
        return np.asarray(motion @ q[: motion.shape[2]])


def sector_surface(mesh: Any, sector: Sector, reduction: CyclicReduction) -> SectorSurface:
    """The boundary of a scikit-fem mesh without the cyclic faces, which lie inside the disk."""
    facets = mesh.facets[:, mesh.boundary_facets()].T
    inside = [np.isin(facets, _vertices(mesh, sector, side)).all(axis=1) for side in (sector.left, sector.right)]
    facets = facets[~(inside[0] | inside[1])]
    used, place = np.unique(facets, return_inverse=True)
    points = np.asarray(mesh.p.T[used])
    numbers = sector.solid.numbers[cKDTree(sector.solid.points).query(points)[1]]
    moving = np.where(numbers[:, :, None] >= 0, 1.0, 0.0)
    motions = tuple(moving * transformation[numbers] for transformation in reduction.transformations)
    return SectorSurface(points, _ordered(place.reshape(facets.shape), points), motions)


def _vertices(mesh: Any, sector: Sector, side: NDArray[np.int64]) -> NDArray[np.int64]:
    distances, _ = cKDTree(sector.solid.points[side]).query(mesh.p.T)
    return np.flatnonzero(distances < 1e-9)


def _ordered(quads: NDArray[np.int64], points: Array) -> NDArray[np.int64]:
    """Corners in the order in which they go round: the one farthest from the first corner stands third."""
    ordered = quads.copy()
    for row, quad in zip(ordered, quads, strict=True):
        opposite = 1 + int(np.linalg.norm(points[quad[1:]] - points[quad[0]], axis=1).argmax())
        others = [k for k in (1, 2, 3) if k != opposite]
        row[:] = quad[[0, others[0], opposite, others[1]]]
    return ordered
