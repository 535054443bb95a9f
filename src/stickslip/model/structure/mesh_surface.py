"""The outer surface of a meshed body or sector and its motion from the reduced degrees of freedom, for deformed shapes.

Corner nodes alone are drawn. Of a fine mesh, nodes that lie close together are drawn as one, so that pictures, results and the
rows of the reduction that are kept stay small.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any, Self

import numpy as np
import scipy
from numpy.typing import NDArray
from scipy import sparse

from stickslip.model.structure.cyclic_reduction import CyclicReduction, Sector
from stickslip.model.structure.solid import Indices, Solid
from stickslip.support.checks import Array, counted

Cells = Mapping[str, Indices]
"""Corner nodes of the cells of each kind, (cells, corners), numbered as in `FACES`."""

FACES: Mapping[str, tuple[tuple[int, ...], ...]] = {
    "tetrahedron": ((0, 2, 1), (0, 1, 3), (1, 2, 3), (0, 3, 2)),
    "pyramid": ((0, 3, 2, 1), (0, 1, 4), (1, 2, 4), (2, 3, 4), (3, 0, 4)),
    "wedge": ((0, 2, 1), (3, 4, 5), (0, 1, 4, 3), (1, 2, 5, 4), (2, 0, 3, 5)),
    "hexahedron": ((0, 3, 2, 1), (4, 5, 6, 7), (0, 1, 5, 4), (1, 2, 6, 5), (2, 3, 7, 6), (3, 0, 4, 7)),
    "triangle": ((0, 1, 2),),
    "quadrilateral": ((0, 1, 2, 3),),
}
"""Faces of a cell, outwards by the right-hand rule; the numbering is that of Abaqus, CalculiX, Nastran and Ansys."""
CORNERS = {"tetrahedron": 4, "pyramid": 5, "wedge": 6, "hexahedron": 8, "triangle": 3, "quadrilateral": 4}
SHELLS = ("triangle", "quadrilateral")
"""Cells that are faces themselves."""
HEXAHEDRON_OF_SKFEM = (0, 3, 6, 2, 1, 5, 7, 4)
"""Corners of a `MeshHex` of scikit-fem in the order of `FACES`."""
MOST_POINTS = 6000
"""Points of a surface; of a finer mesh, about as many."""


@dataclass(frozen=True, eq=False, repr=False)
class MeshSurface:
    """u = recovery q at the points of a surface: recovery (3 p, m), x, y, z of one point after another, dense or sparse.

    points: (p, 3) at rest, m; triangles: (t, 3), places among the points, seen from outside against the clock; dofs: names of q.
    """

    points: Array
    triangles: Indices
    recovery: Any
    dofs: tuple[str, ...]

    def __repr__(self) -> str:
        return f"MeshSurface: {counted(len(self.points), 'point')}, {counted(len(self.triangles), 'triangle')}"

    def motion(self, q: NDArray[Any]) -> NDArray[Any]:
        """Displacements (p, 3) for the degrees of freedom q (m,), real or complex, in the unit of q."""
        return np.asarray(self.recovery @ q).reshape(-1, 3)

    def prefixed(self, body: str) -> Self:
        """The same within an assembly, where its degrees of freedom are named "BODY/NODE.DIRECTION"."""
        return replace(self, dofs=tuple(f"{body}/{dof}" for dof in self.dofs)) if body else self

    def shifted(self, step: Array) -> Self:
        """The same elsewhere, by `step` (3,) [m]."""
        return replace(self, points=self.points + step)


def body_surface(mesh: Any, body: Solid, dofs: Sequence[str], transformation: Array) -> MeshSurface:
    """That of a scikit-fem `MeshHex` and what `solid` made of it, clamped as it was reduced: u = transformation q."""
    points, faces, numbers = boundary(mesh, body)
    return MeshSurface(points, triangulated(faces), recovery_rows(transformation, numbers), tuple(dofs))


def boundary(mesh: Any, body: Solid, inside: Sequence[Indices] = ()) -> tuple[Array, Indices, Indices]:
    """Points (p, 3) [m] and faces (f, 4) around a `MeshHex`, and the rows (p, 3) of the points, −1 where they are clamped.

    inside: sets of nodes of the body, (k,); faces of which all corners belong to one of them are no part of the surface.
    """
    faces = outer_faces({"hexahedron": mesh.t.T[:, HEXAHEDRON_OF_SKFEM]})
    nodes = np.asarray(scipy.spatial.cKDTree(body.points).query(mesh.p.T)[1], dtype=np.int64)
    for chosen in inside:
        faces = faces[~np.isin(nodes[faces], chosen).all(axis=1)]
    used = np.unique(faces)
    return mesh.p.T[used], np.searchsorted(used, faces), body.numbers[nodes[used]]


def recovery_rows(transformation: NDArray[Any], numbers: Indices) -> NDArray[Any]:
    """The rows `numbers` (p, 3) of a transformation (n, m), (3 p, m) in single precision; 0 where a number is negative."""
    rows = numbers.ravel()
    kept = np.where(rows[:, None] >= 0, transformation[rows], 0.0)
    return kept.astype(np.complex64 if np.iscomplexobj(kept) else np.float32)


def selection(numbers: Indices, size: int) -> Any:
    """The recovery of a body that is not reduced: sparse (3 p, size), 0 where a number is negative."""
    rows = np.flatnonzero(numbers.ravel() >= 0)
    entries = np.ones(rows.size), (rows, numbers.ravel()[rows])
    return sparse.csr_array(entries, shape=(numbers.size, size))


def outer_faces(cells: Cells) -> Indices:
    """The faces (f, 4) that belong to one cell alone, and all shells; a triangle repeats its last corner."""
    solids = [_faces(kind, nodes) for kind, nodes in cells.items() if kind not in SHELLS]
    shells = [_faces(kind, nodes) for kind, nodes in cells.items() if kind in SHELLS]
    none = np.zeros((0, 4), dtype=np.int64)
    faces = np.concatenate([none, *solids])
    corners = np.sort(faces, axis=1)
    # A face that has collapsed to three corners is the same triangle, whichever of them it repeats.
    corners[:, 1:][np.diff(corners, axis=1) == 0] = -1
    corners.sort(axis=1)
    _, first, times = np.unique(corners, axis=0, return_index=True, return_counts=True)
    return np.concatenate([none, faces[np.sort(first[times == 1])], *shells])


def triangulated(faces: Indices) -> Indices:
    """Two triangles (t, 3) of each face, without those that have collapsed."""
    triangles = np.concatenate([faces[:, [0, 1, 2]], faces[:, [0, 2, 3]]])
    return triangles[np.all(triangles != np.roll(triangles, 1, axis=1), axis=1)]


def thinned(points: Array, triangles: Indices, most: int = MOST_POINTS) -> tuple[Indices, Indices]:
    """Which points are kept, and the triangles between them: of the points in one cell of a grid, that nearest to their middle.

    Source: Rossignac and Borrel, Multi-resolution 3D approximations for rendering complex scenes (1993).
    """
    if len(points) <= most:
        return np.arange(len(points)), triangles
    low, size = points.min(axis=0), float(np.ptp(points, axis=0).max())
    divisions = int(4.0 * most**0.5)  # of the longest side; a slender body has few points across
    while True:
        cell = np.floor((points - low) / size * divisions).astype(np.int64)
        _, group = np.unique(cell, axis=0, return_inverse=True)
        group = group.ravel()
        if group.max() < most:
            break
        divisions = int(0.85 * divisions)
    middle = np.stack([np.bincount(group, axis) for axis in points.T], axis=1) / np.bincount(group)[:, None]
    order = np.lexsort((np.linalg.norm(points - middle[group], axis=1), group))
    kept = order[np.unique(group[order], return_index=True)[1]]
    merged = group[triangles]
    merged = merged[np.all(merged != np.roll(merged, 1, axis=1), axis=1)]
    _, first = np.unique(np.sort(merged, axis=1), axis=0, return_index=True)
    merged = merged[np.sort(first)]
    used = np.unique(merged)
    return kept[used], np.searchsorted(used, merged)


def _faces(kind: str, nodes: Indices) -> Indices:
    """All faces of cells of one kind, (cells × faces, 4)."""
    corners = np.array([(*face, face[-1])[:4] for face in FACES[kind]])
    return np.asarray(nodes, dtype=np.int64)[:, corners].reshape(-1, 4)


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
