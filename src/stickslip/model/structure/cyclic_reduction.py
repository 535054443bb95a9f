"""Reduction of meshed bodies and sectors: a large M, K with a few kept degrees of freedom becomes a small `Structure`.

Craig and Bampton (1968): interior motion = static modes of the kept (boundary) motion + fixed-interface modes. The static
response to loads on the kept degrees of freedom is exact with any number of modes; with all of them everything is exact.

A sector has cyclic constraints between its faces, and a reduction for each nodal diameter: sparse, for faces of any number of
nodes, matching or not. The right face is the left face of the following sector: u_right = R u_left exp(−i n 2π/N), R the
rotation by 2π/N about the axis. Degrees of freedom of all sectors stand in the sector's own axes, which turn with it.
"""

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from math import pi
from typing import Any, NamedTuple

import numpy as np
import scipy
from numpy.typing import NDArray
from scipy import linalg, sparse

from stickslip.model.structure.centrifugal import Z_AXIS, RotationAxis
from stickslip.model.structure.cyclic import CyclicStructure, cyclic
from stickslip.model.structure.factor import Pencil, Singular, solver
from stickslip.model.structure.matrices import Structure, symmetric_sparse
from stickslip.model.structure.modes import ROUNDING, ModeCount, held_modes, longest, orthonormal
from stickslip.model.structure.solid import Solid
from stickslip.support.checks import Array, Index, InputError, fault, first_of

Progress = Callable[[float, str], None]


@dataclass(frozen=True, eq=False)
class Reduction:
    """q_full = transformation @ q, with q the degrees of freedom of `structure`: kept ones first, then "mode/1.q", ...

    transformation: (full size, reduced size), for the recovery of motion and stress inside; frequencies: of the
    fixed-interface modes kept, Hz; count: how many of those there are these are. beyond: (full size, k), what given loads
    deform beyond `transformation`.
    """

    structure: Structure
    transformation: Array
    frequencies: Array
    count: ModeCount
    beyond: Array


def craig_bampton(
    M: sparse.csc_array | Array,
    K: sparse.csc_array | Array,
    kept: Mapping[str, int],
    modes: int | None = None,
    progress: Progress = lambda share, text: None,
    loads: Array | None = None,
) -> Reduction:
    """The reduction of M, K (n, n; sparse or dense) with mass-normalised fixed-interface modes.

    kept: {"NODE.DIRECTION": row in M and K}; they must hold the body (interior stiffness positive definite).
    modes: number of fixed-interface modes, lowest first, with those equal to the last of them; None: all (dense; massless
    interior motions have none).
    progress(share, text) is called with what is being done and the memory that the factor takes. loads (n, k): static ones on
    the whole body, whose motion the modes describe in part: (K_ii⁻¹ − Φ Λ⁻¹ Φᵀ) p_i is what they lack.
    """
    stiffness, mass = symmetric_sparse("K", K), symmetric_sparse("M", M)
    size = stiffness.shape[0]
    if mass.shape != stiffness.shape:
        raise fault("M", f"must have the shape of K, {stiffness.shape}", mass.shape)
    names, boundary = list(kept), np.array(list(kept.values()), dtype=int)
    outside = boundary[(boundary < 0) | (boundary >= size)]
    if outside.size:
        raise fault("Rows of kept degrees of freedom", f"must lie between 0 and {size - 1}", outside.tolist())
    if np.unique(boundary).size < boundary.size:
        raise fault("Rows of kept degrees of freedom", "must be different", sorted(boundary.tolist()))
    interior = np.setdiff1d(np.arange(size), boundary)
    if modes is not None and not 0 <= modes <= interior.size:
        raise fault("modes", f"must lie between 0 and {interior.size}, the interior degrees of freedom", modes)
    progress(0.05, f"ordering the stiffness of {interior.size} rows for {solver(interior.size).name}")
    body = Pencil(stiffness[interior][:, interior], mass[interior][:, interior], lambda text: progress(0.1, text))
    acting = np.zeros((size, 0)) if loads is None else loads
    static = np.hstack([-stiffness[interior][:, boundary].toarray(), acting[interior]])
    if interior.size:
        _hold(body)
        memory = f"the factor takes {body.megabytes:.0f} MiB"
        progress(0.3, f"static modes; {memory}")
        static = body.solve(static)
        progress(0.5, f"fixed-interface modes; {memory}")
    found = held_modes(body, modes)
    squares, shapes = found.squares, found.shapes
    progress(0.9, "projecting the matrices")
    T = np.zeros((size, boundary.size + squares.size))
    T[boundary, np.arange(boundary.size)] = 1.0
    T[interior] = np.hstack([static[:, : boundary.size], shapes])
    beyond = np.zeros_like(acting)
    beyond[interior] = static[:, boundary.size :] - shapes @ ((shapes.T @ acting[interior]) / squares[:, None])
    # K of kept and modal coordinates has blocks that vanish or are diagonal by construction: they are written exactly.
    reduced = linalg.block_diag(_projected(stiffness, T[:, : boundary.size]), np.diag(squares))
    structure = Structure(_projected(mass, T), reduced, (*names, *mode_names(squares.size)))
    return Reduction(structure, T, np.sqrt(squares) / (2.0 * np.pi), found.count, beyond)


def mode_names(modes: int) -> tuple[str, ...]:
    """The names of the modal coordinates."""
    return tuple(f"mode/{index}.q" for index in range(1, modes + 1))


def _projected(matrix: sparse.csc_array, T: Array) -> Array:
    """TᵀAT of a symmetric matrix, exactly symmetric."""
    reduced = T.T @ (matrix @ T)
    return np.asarray(0.5 * (reduced + reduced.T))


def _hold(body: Pencil) -> None:
    """The factor of the body with its kept degrees of freedom held, which must be positive definite."""
    if np.any(body.K.diagonal() <= 0.0):
        raise _not_held()
    try:
        body.at(0.0)
    except Singular:
        raise _not_held() from None
    if body.negative or body.weak:
        raise _not_held()


def _not_held() -> InputError:
    return InputError(
        "The interior stiffness of a Craig-Bampton reduction must be positive definite, but it is singular: with the kept "
        "degrees of freedom held, some motion stays free. Keep more of them, or check the supports and the mesh."
    )


MATCH = 1e-3
"""How far nodes of the two faces may be apart, relative to the smallest distance of neighbours on a face: coordinates are printed
with six digits in some formats."""


def rotation(sectors: int, steps: int = 1) -> Array:
    """The rotation by `steps` sectors about z, (3, 3)."""
    return Z_AXIS.turn(sectors, steps)


@dataclass(frozen=True, eq=False)
class Sector:
    """A meshed sector with its two faces, by the numbers of their nodes, of which the right ones follow the left ones.

    solid: clamped where the disk is. weights (right, left): displacement of each right node, turned back, from those of the left
    nodes; None where node k of one face is node k of the other. mirrored: whether "right" is the low face, that is, whether the
    right face belongs to the preceding sector.
    """

    solid: Solid
    sectors: int
    left: Index
    right: Index
    axis: RotationAxis = Z_AXIS
    weights: sparse.csr_array | None = None
    mirrored: bool = False
    apart: float = 0.0
    """The largest distance of a right node from its partner, or from the nodes between which it is interpolated, m."""

    @property
    def dependent(self) -> Index:
        """The rows of the right face, which follow those of the left one, (k,)."""
        numbers = self.solid.numbers[self.right]
        return numbers[numbers[:, 0] >= 0].ravel()

    def constraint(self, nodal_diameter: int) -> sparse.csc_array:
        """T: motion of all degrees of freedom from those off the right face, (n, independent), numbered as they stand."""
        size, dependent = self.solid.size, self.dependent
        free = self.solid.numbers[self.right][:, 0] >= 0
        weights = sparse.csr_array(sparse.eye_array(self.right.size)) if self.weights is None else self.weights
        shares = sparse.coo_array(weights[np.flatnonzero(free)])
        to, source = shares.coords
        leaders = self.solid.numbers[self.left][source]
        values = shares.data[:, None, None] * self.joint(nodal_diameter)
        rows = np.broadcast_to(dependent.reshape(-1, 3)[to][:, :, None], values.shape)
        columns = np.broadcast_to(leaders[:, None, :], values.shape)
        moving = columns >= 0  # a leader that is clamped moves nothing
        independent = np.setdiff1d(np.arange(size), dependent)
        number = np.full(size, -1)
        number[independent] = np.arange(independent.size)
        rows = np.concatenate([independent, rows[moving]])
        columns = np.concatenate([np.arange(independent.size), number[columns[moving]]])
        values = np.concatenate([np.ones(independent.size), values[moving]])
        return sparse.csc_array(sparse.coo_array((values, (rows, columns)), shape=(size, independent.size)))

    def joint(self, nodal_diameter: int) -> NDArray[Any]:
        """R exp(−i n 2π/N), (3, 3), or its inverse where mirrored; real for n = 0 and N/2."""
        steps = -1 if self.mirrored else 1
        turns = nodal_diameter * steps / self.sectors
        phase = np.exp(-2j * pi * turns)
        return np.asarray(self.axis.turn(self.sectors, steps) * (phase.real if (2.0 * turns).is_integer() else phase))

    def matrices(self, nodal_diameter: int) -> tuple[sparse.csc_array, sparse.csc_array]:
        """M and K of a nodal diameter on the degrees of freedom off the right face, Hermitian (real for 0 and N/2)."""
        T = self.constraint(nodal_diameter)
        return tuple(sparse.csc_array(hermitian(T.conj().T @ A @ T)) for A in (self.solid.M, self.solid.K))  # type: ignore[return-value]


def sector_of(solid: Solid, sectors: int, left: Index, right: Index, axis: RotationAxis = Z_AXIS) -> Sector:
    """Pair the nodes of two faces, given by their numbers; refused unless right = R left, node by node."""
    if sectors < 2:
        raise fault("sectors", "must be at least 2", sectors)
    if left.size != right.size or not left.size:
        counts = f"{left.size} on the left and {right.size} on the right"
        raise fault("Nodes on the cyclic faces", "must be the same number on both, at least one", counts)
    limit = MATCH * spacing(solid.points[right])
    distances, partner = partners(solid.points, left, right, axis, sectors)
    if distances.max() > limit or np.unique(partner).size < partner.size:
        rule = f"must match turned by 2π/{sectors}, to {limit:.2g} m"
        raise fault("Nodes on the cyclic faces", rule, f"up to {distances.max():.3g} m apart", "Mesh both faces alike, check N.")
    return Sector(solid, sectors, left, right[partner], axis, apart=float(distances.max()))


def partners(points: Array, left: Index, right: Index, axis: RotationAxis, sectors: int, steps: int = 1) -> tuple[Array, Index]:
    """The distance [m] of each left node, turned by `steps` sectors, from the nearest right one, and the number of that one."""
    turned = axis.turned(points[left], sectors, steps)
    distances, partner = scipy.spatial.KDTree(points[right]).query(turned)
    return np.asarray(distances), np.asarray(partner)


def spacing(points: Array) -> float:
    """The smallest distance of two of the points (n, 3), m; the distance from the origin of a single one."""
    if len(points) < 2:
        return float(np.linalg.norm(points))
    return float(np.asarray(scipy.spatial.KDTree(points).query(points, k=2)[0])[:, 1].min())


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
    held and `sector_modes` of its modes (real, once), then the faces joined and condensed for each nodal diameter. For matching
    faces of few nodes, whose static shapes are dense columns; `reduced_waves` takes any.
    """
    faces = [sector.solid.numbers[side] for side in (sector.left, sector.right)]
    left, right = (rows[faces[0][:, 0] >= 0].ravel() for rows in faces)
    refuse_on_faces(sector, kept)
    held = [(f"{side}/{i}.q", int(row)) for side, rows in (("left", left), ("right", right)) for i, row in enumerate(rows)]
    first = craig_bampton(sector.solid.M, sector.solid.K, dict(held) | dict(kept), sector_modes)
    if not 1 <= modes <= left.size + sector_modes:
        raise fault("modes", f"must lie between 1 and {left.size + sector_modes}", modes)
    parts = [_condensed(first, left.size, len(kept), sector.joint(n), modes) for n in range(sector.sectors // 2 + 1)]
    masses, stiffnesses, transformations, squares = zip(*parts, strict=True)
    structure = cyclic(sector.sectors, (*kept, *mode_names(modes)), masses, stiffnesses, axis=sector.axis)
    return CyclicReduction(structure, transformations, np.sqrt(np.array(squares)) / (2.0 * pi))


def refuse_on_faces(sector: Sector, kept: Mapping[str, int]) -> None:
    """Nodes of the faces cannot be kept: those of the right face follow others, and contacts would count twice."""
    on_faces = {row for side in (sector.left, sector.right) for row in sector.solid.numbers[side].ravel().tolist()}
    missing = [name for name, row in kept.items() if row in on_faces]
    if missing:
        shown = first_of(missing)
        remedy = "Keep nodes beside the faces, and take theirs out of the contact surfaces."
        raise fault("Kept degrees of freedom", "must not lie on the cyclic faces", shown, remedy)


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
    M, K = (hermitian(joined.conj().T @ A @ joined) for A in (first.structure.M, first.structure.K))
    squares, shapes = linalg.eigh(K[kept:, kept:], M[kept:, kept:], subset_by_index=[0, modes - 1])
    largest = shapes[np.abs(shapes).argmax(axis=0), np.arange(modes)]
    T = np.zeros((size - face, kept + modes), dtype=joint.dtype)
    T[:kept, :kept] = np.eye(kept)
    T[kept:, :kept] = -linalg.solve(K[kept:, kept:], K[kept:, :kept], assume_a="pos")
    T[kept:, kept:] = shapes * (np.abs(largest) / largest)
    mass, stiffness = (hermitian(T.conj().T @ A @ T) for A in (M, K))
    return mass, stiffness, first.transformation @ (joined @ T), squares


def hermitian(matrix: Any) -> Any:
    """The Hermitian part of a matrix, which rounding has left a little unsymmetric."""
    return 0.5 * (matrix + matrix.conj().T)


class ReducedWave(NamedTuple):
    """One nodal diameter on its kept and modal coordinates: M, K (m, m), motion of the whole sector from them (n, m), ω² of the
    fixed-interface modes [1/s²], (modes,), and how many of those there are up to the last these are, with its equals. beyond
    (n, k): what given loads deform beyond `transformation`.
    """

    M: NDArray[Any]
    K: NDArray[Any]
    transformation: NDArray[Any]
    squares: Array
    counted: ModeCount
    beyond: NDArray[Any]


def reduced_waves(
    sector: Sector,
    kept: Mapping[str, int],
    modes: int,
    nodal_diameters: Sequence[int],
    progress: Progress = lambda share, text: None,
    loads: Array | None = None,
) -> Iterator[ReducedWave]:
    """The reduction of each of the nodal diameters, one after the other, since each may take as much memory as the sector.

    loads (n, k): static ones on all rows of the sector, none unless given.
    """
    acting = np.zeros((sector.solid.size, 0)) if loads is None else loads
    refuse_on_faces(sector, kept)
    inside = sector.solid.size - sector.dependent.size - len(kept)
    if not 1 <= modes <= inside:
        raise fault("modes", f"must lie between 1 and {inside}", modes)
    for done, n in enumerate(nodal_diameters):
        which = f"nodal diameter {n}, {done + 1} of {len(nodal_diameters)}"
        progress(done / len(nodal_diameters), f"reducing {which}, {sector.solid.size} rows")
        yield _reduced_wave(sector, np.array(list(kept.values()), dtype=int), modes, n, acting)


def shared_modes(kept: Mapping[str, int], modes: int) -> int:
    """The number of modal coordinates of `shared_waves`."""
    return 2 * modes + min(modes, len(kept))


def shared_waves(
    ends: Sequence[Sector],
    kept: Mapping[str, int],
    modes: int,
    nodal_diameters: Sequence[int],
    progress: Progress = lambda share, text: None,
    loads: Array | None = None,
) -> Iterator[ReducedWave]:
    """The reduction of each nodal diameter, with the first of two K, in the shapes that the sector has with either.

    Kept rows move as with the first K. Modal coordinates are the fixed-interface modes of both, and what static shapes with the
    second K have beyond: of that the motions which, left out, raise its stiffness by the largest share. Where both K have
    the same shapes, further modes of the first fill the number.
    """
    size, number = len(kept), shared_modes(kept, modes)
    M, K, other_K = ends[0].solid.M, *(end.solid.K for end in ends)
    both = zip(*(reduced_waves(end, kept, modes, nodal_diameters, progress, loads) for end in ends), strict=True)
    for n, waves in zip(nodal_diameters, both, strict=True):
        (static, inside), (other, beside) = (np.split(wave.transformation, [size], axis=1) for wave in waves)
        changed = other - static
        values, order = linalg.eigh(waves[1].K[:size, :size])
        order /= np.sqrt(np.maximum(values, ROUNDING * values.max(initial=0.0)))  # free disks have motions without stiffness
        raised = order.conj().T @ hermitian(changed.conj().T @ (other_K @ changed)) @ order
        order = order @ linalg.eigh(raised)[1][:, ::-1][:, :modes]
        for more, was in ((beside, beside), (changed @ order, other @ order)):
            inside = np.hstack([inside, orthonormal(more, M, inside, longest(was, M @ was))[0]])
        if inside.shape[1] < number:
            more = next(reduced_waves(ends[0], kept, number, [n])).transformation[:, size + modes :]
            inside = np.hstack([inside, orthonormal(more, M, inside, 1.0)[0]])[:, :number]
        T = np.hstack([static, inside])
        mass, stiffness = (hermitian(T.conj().T @ (A @ T)) for A in (M, K))
        lacking = waves[0].beyond
        solved = np.linalg.solve(stiffness[size:, size:], inside.conj().T @ (K @ lacking))
        counted = next((w.counted for w in waves if not w.counted.there == w.counted.found == modes), waves[0].counted)
        yield ReducedWave(mass, stiffness, T, waves[0].squares, counted, lacking - inside @ solved)


def _reduced_wave(sector: Sector, kept: Index, modes: int, nodal_diameter: int, acting: Array) -> ReducedWave:
    """Craig–Bampton of one nodal diameter on its independent degrees of freedom, then the motion of the whole sector."""
    T = sector.constraint(nodal_diameter)
    M, K = (sparse.csc_array(hermitian(T.conj().T @ A @ T)) for A in (sector.solid.M, sector.solid.K))
    independent = np.setdiff1d(np.arange(sector.solid.size), sector.dependent)
    boundary = np.searchsorted(independent, kept)
    interior = np.setdiff1d(np.arange(independent.size), boundary)
    body = Pencil(K[interior][:, interior], M[interior][:, interior])
    try:
        held = not (body.at(0.0).negative or body.weak)
    except Singular:
        held = False
    if not held:
        raise InputError(
            f"The sector must be held by its supports and the kept nodes, but at nodal diameter {nodal_diameter} some motion "
            "stays free or has negative stiffness. Check the supports, and that K is not prestressed beyond buckling."
        )
    basis = np.zeros((independent.size, kept.size + modes), dtype=K.dtype)
    basis[boundary, np.arange(kept.size)] = 1.0
    inside = (T.conj().T @ acting)[interior]
    # Before the modes, whose count leaves the factor of a shifted K.
    static = body.solve(np.hstack([-K[interior][:, boundary].toarray(), inside]))
    basis[interior, : kept.size] = static[:, : kept.size]
    found = held_modes(body, modes)
    if found.squares.size < modes:
        raise fault("modes", f"must be at most {found.squares.size}, the modes that the sector has with mass", modes)
    shapes, squares = found.shapes[:, :modes], found.squares[:modes]
    basis[interior, kept.size :] = shapes
    beyond = np.zeros((independent.size, acting.shape[1]), dtype=K.dtype)
    beyond[interior] = static[:, kept.size :] - shapes @ ((shapes.conj().T @ inside) / squares[:, None])
    mass_of_basis, stiffness = (hermitian(basis.conj().T @ (A @ basis)) for A in (M, K))
    return ReducedWave(mass_of_basis, stiffness, T @ basis, squares, found.count, T @ beyond)


def lowest_frequencies(sector: Sector, nodal_diameter: int, number: int) -> Array:
    """The lowest natural frequencies of a nodal diameter of a sector that its supports hold, Hz, without reduction."""
    M, K = sector.matrices(nodal_diameter)
    squares = held_modes(Pencil(K, M).at(0.0), number).squares[:number]
    return np.asarray(np.sqrt(np.maximum(squares, 0.0)) / (2.0 * np.pi))
