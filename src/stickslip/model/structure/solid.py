"""Solid bodies: sparse M and K from a mesh, isotropic elastic materials and clamped faces.

The meshed rigs start here, of 20-node hexahedra; `craig_bampton` makes a small `Structure` of the result. So do meshes of decks
(Abaqus, CalculiX). Their integration points are those of CalculiX, of the mass too, so that the matrices are those that it
writes. (CalculiX CrunchiX User's Manual, Element types; the points of the mass were found by comparing its matrices.)
scikit-fem gives the shape functions and is imported on first use only.
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cache
from typing import Any, NamedTuple, TypeVar

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy import sparse

from stickslip.model.structure.matrices import Structure
from stickslip.support.checks import Array, InputError, fault, finite, first_of, positive, vector
from stickslip.support.late import skfem

Indices = NDArray[np.int64]
Placed = TypeVar("Placed", bound=Structure)
TETRAHEDRON = np.vstack([np.zeros(3), np.eye(3)])
TETRAHEDRON_EDGES = ((0, 1), (1, 2), (2, 0), (0, 3), (1, 3), (2, 3))
BRICK = np.array([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0], [0, 0, 1], [1, 0, 1], [1, 1, 1], [0, 1, 1]], dtype=float)
BRICK_EDGES = ((0, 1), (1, 2), (2, 3), (3, 0), (4, 5), (5, 6), (6, 7), (7, 4), (0, 4), (1, 5), (2, 6), (3, 7))
"""Local coordinates of corners, and the corners of each edge in the order in which decks list the nodes in the middle."""
SHAPES = {
    "C3D4": ("ElementTetP1", 1),
    "C3D8": ("ElementHex1", 3),
    "C3D10": ("ElementTetP2", 2),
    "C3D20": ("ElementHexS2", 5),
    "C3D20R": ("ElementHexS2", 3),
}
"""Elements by name in CalculiX and Abaqus: shape functions, and the degree of polynomials that the integration is exact for."""
NODES = {"C3D4": 4, "C3D8": 8, "C3D10": 10, "C3D20": 20, "C3D20R": 20}
SMALLEST_VOLUME = 1e-12
"""Determinant of the Jacobian, relative to the size of the element cubed, below which it counts as inverted or flat."""


@dataclass(frozen=True)
class Material:
    """Isotropic linear elasticity: Young's modulus [Pa], Poisson's ratio [-], density [kg/m³]."""

    young: float = 210e9
    poisson: float = 0.3
    density: float = 7850.0

    def __post_init__(self) -> None:
        positive("Material.young", self.young)
        positive("Material.density", self.density)
        if not -1.0 < finite("Material.poisson", self.poisson) < 0.5:
            raise fault("Material.poisson", "must lie between -1 and 0.5", self.poisson)

    @property
    def lame(self) -> tuple[float, float]:
        """Lamé's λ and μ, Pa."""
        shear = self.young / (2.0 * (1.0 + self.poisson))
        return 2.0 * shear * self.poisson / (1.0 - 2.0 * self.poisson), shear


STEEL = Material()


@dataclass(frozen=True, eq=False)
class Solid:
    """M q̈ + K q = p of a meshed body, sparse.

    M, K: (n, n); points: (nodes, 3) in m, mid-edge nodes included; numbers: (nodes, 3), the row in M and K of the
    displacement of a node along x, y, z, or −1 where it is clamped.
    """

    M: sparse.csc_array
    K: sparse.csc_array
    points: Array
    numbers: Indices

    @property
    def size(self) -> int:
        return int(self.M.shape[0])

    def clamp(self, where: Callable[[Array], NDArray[np.bool_]]) -> "Solid":
        """A copy that is fixed at all nodes for which `where(points)` holds; points is (nodes, 3)."""
        fixed = np.asarray(where(self.points), dtype=bool)
        if fixed.shape != (len(self.points),):
            what = "The value of `where`"
            raise fault(what, f"must have the shape ({len(self.points)},), one for each node", fixed.shape, "x is points[:, 0].")
        if not fixed.any():
            raise fault("The clamped face", "must hold nodes of the mesh", "none", "Check the coordinates and their unit (m).")
        free = np.setdiff1d(np.arange(self.size), self.numbers[fixed])
        new = np.full(self.size + 1, -1, dtype=np.int64)
        new[free] = np.arange(free.size)
        numbers = np.where(fixed[:, None], -1, new[self.numbers])
        return replace(self, M=self.M[free][:, free], K=self.K[free][:, free], numbers=numbers)

    def node(self, point: ArrayLike, within: float | None = None) -> int:
        """The node nearest to `point` [m]; refused farther than `within` [m] (1e-5 of the body's diagonal unless given)."""
        target = vector("point", point, 3)
        distances = np.linalg.norm(self.points - target, axis=1)
        nearest = int(distances.argmin())
        limit = 1e-5 * float(np.linalg.norm(np.ptp(self.points, axis=0))) if within is None else within
        if distances[nearest] > limit:
            raise fault(
                f"The node nearest to {target.tolist()}",
                f"must lie within {limit:g} m of it",
                f"{distances[nearest]:g} m away at {self.points[nearest].tolist()}",
                "Put a mesh line there, or widen `within`.",
            )
        return nearest

    def named(self, places: Mapping[str, ArrayLike], axes: str = "xyz") -> dict[str, int]:
        """{"NAME.AXIS": row in M and K} of named places, for the displacements along `axes`."""
        rows: dict[str, int] = {}
        for name, point in places.items():
            node = self.node(point)
            rows |= {f"{name}.{axis}": int(self.numbers[node, "xyz".index(axis)]) for axis in axes}
        clamped = sorted(name for name, row in rows.items() if row < 0)
        if clamped:
            raise fault("Named places", "must not be clamped", clamped)
        return rows


def located(structure: Placed, body: Solid, places: Mapping[str, ArrayLike]) -> Placed:
    """A reduction of a body with the coordinates of its named places and of the mesh, for drawings and contact surfaces."""
    nodes = {name: (float(x), float(y), float(z)) for name, (x, y, z) in ((n, vector(n, p, 3)) for n, p in places.items())}
    return replace(structure, nodes=nodes, mesh_points=body.points)


def box_mesh(x: ArrayLike, y: ArrayLike, z: ArrayLike) -> Any:
    """A mesh of hexahedra between the grid lines x, y, z [m]."""
    return skfem.MeshHex.init_tensor(*(np.asarray(lines, dtype=float) for lines in (x, y, z)))


def solid(mesh: Any, material: Material = STEEL) -> Solid:
    """The free body of a scikit-fem `MeshHex` with quadratic serendipity elements."""
    shapes = shape_functions(mesh)
    nodes = shapes.rows[:, list(element("C3D20").order), 0] // 3
    if np.linalg.det(shapes.points[nodes[0, [1, 3, 4]]] - shapes.points[nodes[0, 0]]) < 0.0:  # left-handed: the other face first
        nodes = nodes[:, np.r_[4:8, 0:4, 12:16, 8:12, 16:20]]
    M, K = mesh_matrices(shapes.points, [Group("C3D20", material, (), nodes)])
    return Solid(M, K, shapes.points, np.arange(shapes.size).reshape(-1, 3))


@dataclass(frozen=True, eq=False)
class ShapeFunctions:
    """Of all cells at their quadrature points: gradients (a, 3, cells, q), volumes (cells, q) in m³.

    rows: (cells, a, 3), where the nodes of the cells stand among the `size` unknowns of the free body; points: (nodes, 3) in m.
    """

    gradients: Array
    volumes: Array
    rows: Indices
    points: Array

    @property
    def size(self) -> int:
        return int(self.points.size)

    def assembled(self, matrices: Array) -> sparse.csc_array:
        """The sum of the cells' matrices (cells, 3a, 3a) at their rows, (size, size)."""
        rows = self.rows.reshape(matrices.shape[0], -1)
        i = np.broadcast_to(rows[:, :, None], matrices.shape)
        j = np.broadcast_to(rows[:, None, :], matrices.shape)
        # Entries at one place add up; the sum is symmetric to rounding, and is made exactly so.
        total = sparse.coo_array((matrices.ravel(), (i.ravel(), j.ravel())), shape=(self.size, self.size)).tocsc()
        return sparse.csc_array(0.5 * (total + total.T))


def shape_functions(mesh: Any) -> ShapeFunctions:
    """Those of quadratic serendipity elements on a `MeshHex`; inverted cells are refused."""
    basis = skfem.Basis(mesh, skfem.ElementHexS2(), intorder=SHAPES["C3D20"][1])
    places = np.hstack([basis.X, basis.elem.doflocs.T])
    determinants = np.asarray(basis.mapping.detDF(places))  # at the nodes too: a corner can fold over between the other points
    centres = mesh.p[:, mesh.t].mean(axis=1)
    _refuse_inverted(
        determinants / determinants.sum() * determinants.size, lambda k: f"{k} at {centres[:, k].round(6).tolist()} m"
    )
    volumes = np.asarray(basis.dx)
    gradients = np.array([basis.basis[a][0].grad for a in range(basis.Nbfun)])
    rows = 3 * basis.element_dofs.T[:, :, None] + np.arange(3)
    return ShapeFunctions(gradients, volumes, rows, np.asarray(basis.doflocs.T))


def _refuse_inverted(determinants: Array, named: Callable[[int], str]) -> None:
    """Refuse cells of which a Jacobian determinant, (cells, points), relative to their size, is not positive."""
    bad = np.flatnonzero(~np.all(determinants > SMALLEST_VOLUME, axis=1))
    if bad.size:
        raise InputError(
            f"Cells of a mesh must not be inverted or flat (Jacobian determinant of one sign), but {bad.size} are: "
            f"{first_of([named(cell) for cell in bad.tolist()])}. Move their nodes apart, or number them in one sense."
        )


class Element(NamedTuple):
    """An element in local coordinates from 0 to 1, its nodes in the order of the deck.

    corners (c, 3); ends (nodes, 2): the corners of the edge of each node, twice itself at a corner; order (nodes,): its place in
    scikit-fem; points (q, 3), weights (q,): of the integration; values (q, nodes), gradients (q, nodes, 3): of the shapes there.
    """

    corners: Array
    ends: Indices
    order: tuple[int, ...]
    points: Array
    weights: Array
    values: Array
    gradients: Array


@cache
def element(kind: str) -> Element:
    """The element of one of `SHAPES`."""
    name, degree = SHAPES[kind]
    shape = getattr(skfem, name)()
    corners, edges = (TETRAHEDRON, TETRAHEDRON_EDGES) if "Tet" in name else (BRICK, BRICK_EDGES)
    ends = np.array([*((k, k) for k in range(len(corners))), *edges])[: NODES[kind]]
    nodes = corners[ends].mean(axis=1)
    order = tuple(int(np.linalg.norm(shape.doflocs - node, axis=1).argmin()) for node in nodes)
    at, weights = skfem.quadrature.get_quadrature(shape.refdom, degree)
    fields = [shape.lbasis(at, k) for k in order]
    gradients = np.array([gradient.T for _, gradient in fields]).swapaxes(0, 1)
    return Element(corners, ends, order, at.T, weights, np.array([value for value, _ in fields]).T, gradients)


class Group(NamedTuple):
    """Elements of one kind and material: their names, and their nodes (cells, nodes) as places among the points of the mesh."""

    kind: str
    material: Material
    names: Sequence[str]
    nodes: Indices


def mesh_matrices(points: Array, groups: Sequence[Group]) -> tuple[sparse.csc_array, sparse.csc_array]:
    """M and K of the free body, rows x, y, z of each point in turn; summed by pairs of nodes, a ninth of the pairs of rows.

    K_ab = ∫ λ ∂N_a/∂x_i ∂N_b/∂x_j + μ (∂N_a/∂x_j ∂N_b/∂x_i + δ_ij ∇N_a·∇N_b) dV, M_ab = δ_ij ∫ ρ N_a N_b dV.
    """
    size = len(points)
    pairs = [(size * nodes[:, :, None] + nodes[:, None, :]).ravel() for *_, nodes in groups]
    distinct, place = np.unique(np.concatenate(pairs), return_inverse=True)
    blocks, masses = np.zeros((len(distinct), 3, 3)), np.zeros(len(distinct))
    for (kind, material, names, nodes), own in zip(groups, np.split(place, np.cumsum([*map(len, pairs)])[:-1]), strict=True):
        slopes, volumes = slopes_of(kind, names, points[nodes])
        products = np.einsum("qa,qb->qab", element(kind).values, element(kind).values).reshape(volumes.shape[1], -1)
        masses += np.bincount(own, (material.density * volumes @ products).ravel(), len(distinct))
        lam, shear = material.lame
        weighted = (volumes[:, :, None, None] * slopes).transpose(2, 0, 3, 1)  # (axis, cells, nodes, q)
        trace = shear * sum(weighted[k] @ slopes[:, :, k] for k in range(3))
        for i, j in np.ndindex(3, 3):
            product = weighted[i] @ slopes[:, :, j]
            stiffness = lam * product + shear * product.swapaxes(1, 2) + (trace if i == j else 0.0)
            blocks[:, i, j] += np.bincount(own, stiffness.ravel(), len(distinct))
    indices, starts = distinct % size, np.searchsorted(distinct, size * np.arange(size + 1))
    M = sparse.csr_array((masses, indices, starts), shape=(size, size))
    K = sparse.bsr_array((blocks, indices, starts), shape=(3 * size, 3 * size)).tocsc()
    # K is symmetric to rounding, and is made exactly so; the sum leaves zeros out.
    return sparse.csc_array(sparse.kron(M, sparse.eye_array(3), format="csc")), sparse.csc_array(0.5 * (K + K.T))


def slopes_of(kind: str, names: Sequence[str], points: Array) -> tuple[Array, Array]:
    """Slopes of the shape functions along x, y, z (cells, q, 3, nodes) and volumes (cells, q) at the integration points."""
    own = element(kind)
    jacobian = np.einsum("qal,cax->cqlx", own.gradients, points)
    determinants = np.linalg.det(jacobian)
    size = np.ptp(points, axis=1).max(axis=1)
    _refuse_inverted(determinants / size[:, None] ** 3, lambda cell: f"element {names[cell]} ({kind})")
    return np.linalg.solve(jacobian, own.gradients.swapaxes(1, 2)), determinants * own.weights
