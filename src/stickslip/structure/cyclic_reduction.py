"""Reduction of a meshed sector: cyclic constraints between its faces, and Craig–Bampton for each nodal diameter.

The right face of a sector is the left face of the following one: u_right = R u_left exp(−i n 2π/N), R the rotation by 2π/N about
z. Degrees of freedom of all sectors stand in the sector's own axes, which turn with it.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from math import cos, pi, sin
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy import linalg, sparse
from scipy.sparse import linalg as sparse_linalg

from stickslip.checks import Array, fault
from stickslip.structure.craig_bampton import Reduction, craig_bampton
from stickslip.structure.cyclic import CyclicStructure, cyclic
from stickslip.structure.solid import Solid

MATCH = 1e-6
"""How far nodes of the two faces may be apart, relative to the sector's diagonal."""

Where = Callable[[Array], NDArray[np.bool_]]


def rotation(sectors: int, steps: int = 1) -> Array:
    """The rotation by `steps` sectors about z, (3, 3)."""
    angle = 2.0 * pi * steps / sectors
    return np.array([[cos(angle), -sin(angle), 0.0], [sin(angle), cos(angle), 0.0], [0.0, 0.0, 1.0]])


def about(axis: str) -> list[int]:
    """The axes x, y, z in the order in which the third is the axis of rotation and all are right-handed."""
    if axis not in ("x", "y", "z"):
        raise fault("The axis of rotation", 'must be "x", "y" or "z"', axis)
    third = "xyz".index(axis)
    return [(third + 1) % 3, (third + 2) % 3, third]


@dataclass(frozen=True, eq=False)
class Sector:
    """A meshed sector with the pairs of nodes of its two faces: right = R left. solid: clamped where the disk is."""

    solid: Solid
    sectors: int
    left: NDArray[np.int64]
    right: NDArray[np.int64]

    def constraint(self, nodal_diameter: int) -> sparse.csc_array:
        """T: motion of all degrees of freedom from those off the right face, (n, independent), numbered as they stand."""
        size = self.solid.size
        followers, leaders = self.solid.numbers[self.right], self.solid.numbers[self.left]
        free = followers[:, 0] >= 0
        followers, leaders = followers[free], leaders[free]
        rows = np.repeat(followers[:, :, None], 3, axis=2).ravel()
        columns = np.repeat(leaders[:, None, :], 3, axis=1).ravel()
        values = np.tile(self.joint(nodal_diameter).ravel(), followers.shape[0])
        independent = np.setdiff1d(np.arange(size), followers)
        rows = np.concatenate([independent, rows])
        columns = np.concatenate([independent, columns])
        values = np.concatenate([np.ones(independent.size), values])
        whole = sparse.coo_array((values, (rows, columns)), shape=(size, size)).tocsc()[:, independent]
        return sparse.csc_array(whole)

    def joint(self, nodal_diameter: int) -> NDArray[Any]:
        """R exp(−i n 2π/N), (3, 3); real for n = 0 and N/2."""
        turns = nodal_diameter / self.sectors
        phase = np.exp(-2j * pi * turns)
        return np.asarray(rotation(self.sectors) * (phase.real if (2.0 * turns).is_integer() else phase))

    def matrices(self, nodal_diameter: int) -> tuple[sparse.csc_array, sparse.csc_array]:
        """M and K of a nodal diameter on the degrees of freedom off the right face, Hermitian (real for 0 and N/2)."""
        T = self.constraint(nodal_diameter)
        return tuple(sparse.csc_array(T.conj().T @ A @ T) for A in (self.solid.M, self.solid.K))  # type: ignore[return-value]


def sector_of(solid: Solid, sectors: int, left: Where, right: Where) -> Sector:
    """Pair the nodes of the faces for which left(points) and right(points) hold; refused unless right = R left, node by node."""
    if sectors < 2:
        raise fault("sectors", "must be at least 2", sectors)
    sides = [np.flatnonzero(np.asarray(where(solid.points))) for where in (left, right)]
    if sides[0].size != sides[1].size or not sides[0].size:
        counts = f"{sides[0].size} on the left and {sides[1].size} on the right"
        raise fault("Nodes on the cyclic faces", "must be the same number on both, at least one", counts)
    turned = solid.points[sides[0]] @ rotation(sectors).T
    distances = np.linalg.norm(turned[:, None] - solid.points[sides[1]][None], axis=2)
    partner = distances.argmin(axis=1)
    limit = MATCH * float(np.linalg.norm(np.ptp(solid.points, axis=0)))
    worst = float(distances.min(axis=1).max())
    if worst > limit or np.unique(partner).size < partner.size:
        rule = f"must match turned by 2π/{sectors}, to {limit:.2g} m"
        raise fault("Nodes on the cyclic faces", rule, f"up to {worst:.3g} m apart", "Mesh both faces alike, check N.")
    return Sector(solid, sectors, sides[0], sides[1][partner])


@dataclass(frozen=True, eq=False)
class CyclicReduction:
    """structure: the reduced disk; transformations: per nodal diameter 0..N//2, motion of all degrees of freedom of the sector
    (full size, reduced size); frequencies: of the fixed-interface modes kept, Hz, (N//2 + 1, modes)."""

    structure: CyclicStructure
    transformations: tuple[NDArray[Any], ...]
    frequencies: Array


def cyclic_craig_bampton(sector: Sector, kept: Mapping[str, int], modes: int, sector_modes: int = 60) -> CyclicReduction:
    """Craig-Bampton of every nodal diameter with the same kept degrees of freedom and number of fixed-interface modes.

    kept: {"NODE.DIRECTION": row of the sector}, none on the faces. In two steps: the sector with both faces and the kept ones
    held and `sector_modes` of its modes (real, once), then the faces joined and condensed for each nodal diameter.
    """
    faces = [sector.solid.numbers[side] for side in (sector.left, sector.right)]
    left, right = (rows[faces[0][:, 0] >= 0].ravel() for rows in faces)
    on_faces = set(left.tolist()) | set(right.tolist())
    missing = [name for name, row in kept.items() if row in on_faces]
    if missing:
        raise fault("Kept degrees of freedom", "must not lie on the cyclic faces", missing)
    held = [(f"{side}/{i}.q", int(row)) for side, rows in (("left", left), ("right", right)) for i, row in enumerate(rows)]
    first = craig_bampton(sector.solid.M, sector.solid.K, dict(held) | dict(kept), sector_modes)
    if not 1 <= modes <= left.size + sector_modes:
        raise fault("modes", f"must lie between 1 and {left.size + sector_modes}", modes)
    parts = [_condensed(first, left.size, len(kept), sector.joint(n), modes) for n in range(sector.sectors // 2 + 1)]
    masses, stiffnesses, transformations, squares = zip(*parts, strict=True)
    names = (*kept, *(f"mode/{index}.q" for index in range(1, modes + 1)))
    structure = cyclic(sector.sectors, names, masses, stiffnesses)
    return CyclicReduction(structure, transformations, np.sqrt(np.array(squares)) / (2.0 * pi))


def _condensed(
    first: Reduction, face: int, kept: int, joint: NDArray[Any], modes: int
) -> tuple[NDArray[Any], NDArray[Any], NDArray[Any], Array]:
    """M, K of kept and modal coordinates, motion of the whole sector from them, and ω² of the fixed-interface modes.

    Coordinates of `first`: left face, right face, kept, modes of the sector.
    """
    size = first.transformation.shape[1]
    joined = np.zeros((size, size - face), dtype=joint.dtype)
    joined[:face, kept : kept + face] = np.eye(face)
    joined[face : 2 * face, kept : kept + face] = np.kron(np.eye(face // 3), joint)
    joined[2 * face : 2 * face + kept, :kept] = np.eye(kept)
    joined[2 * face + kept :, kept + face :] = np.eye(size - 2 * face - kept)
    M, K = (_hermitian(joined.conj().T @ A @ joined) for A in (first.structure.M, first.structure.K))
    squares, shapes = linalg.eigh(K[kept:, kept:], M[kept:, kept:], subset_by_index=[0, modes - 1])
    largest = shapes[np.abs(shapes).argmax(axis=0), np.arange(modes)]
    T = np.zeros((size - face, kept + modes), dtype=joint.dtype)
    T[:kept, :kept] = np.eye(kept)
    T[kept:, :kept] = -linalg.solve(K[kept:, kept:], K[kept:, :kept], assume_a="pos")
    T[kept:, kept:] = shapes * (np.abs(largest) / largest)
    mass, stiffness = (_hermitian(T.conj().T @ A @ T) for A in (M, K))
    return mass, stiffness, first.transformation @ (joined @ T), squares


def cyclic_frequencies(sector: Sector, nodal_diameter: int, number: int) -> Array:
    """The lowest natural frequencies of a nodal diameter of the meshed disk, Hz, without reduction."""
    M, K = sector.matrices(nodal_diameter)
    options = {"SymmetricMode": True}
    factor = sparse_linalg.splu(K, permc_spec="MMD_AT_PLUS_A", diag_pivot_thresh=0.0, options=options)
    inverse = sparse_linalg.LinearOperator(K.shape, matvec=lambda load: factor.solve(load.astype(K.dtype)), dtype=K.dtype)
    start = np.random.default_rng(1).standard_normal(K.shape[0]).astype(K.dtype)
    squares = sparse_linalg.eigsh(K, number, M, sigma=0.0, OPinv=inverse, v0=start, return_eigenvectors=False)
    return np.asarray(np.sqrt(np.sort(np.maximum(squares.real, 0.0))) / (2.0 * pi))


def _hermitian(matrix: NDArray[Any]) -> NDArray[Any]:
    return np.asarray(0.5 * (matrix + matrix.conj().T))
