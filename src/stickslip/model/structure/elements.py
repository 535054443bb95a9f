"""Solid elements of decks (Abaqus, CalculiX): shape functions at their integration points, and M and K of a mesh of them.

The integration points are those of CalculiX, of the mass too, so that the matrices are those that it writes: one in C3D4, four in
C3D10, 2 x 2 x 2 in C3D8 and C3D20R, 3 x 3 x 3 in C3D20. (CalculiX CrunchiX User's Manual, chapter Element types; the points of the
mass were found by comparing its matrices.) scikit-fem gives the shape functions.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import cache
from typing import NamedTuple

import numpy as np
from scipy import sparse

from stickslip.model.structure.solid import Indices, Material
from stickslip.support.checks import Array, fault
from stickslip.support.late import skfem

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
"""Elements by name in CalculiX and Abaqus: shape functions, and the degree of polynomials that the integration points integrate
exactly, of bricks in each direction."""
NODES = {"C3D4": 4, "C3D8": 8, "C3D10": 10, "C3D20": 20, "C3D20R": 20}
SMALLEST_VOLUME = 1e-12
"""Determinant of the Jacobian, relative to the size of the element cubed, below which it counts as turned inside out."""


@dataclass(frozen=True, eq=False)
class Element:
    """An element in local coordinates from 0 to 1, its nodes in the order of the deck.

    corners (c, 3); ends (nodes, 2): the corners of the edge of each node, twice itself at a corner; points (q, 3), weights (q,):
    of the integration; values (q, nodes), gradients (q, nodes, 3): of the shape functions there.
    """

    corners: Array
    ends: Indices
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
    order = [int(np.linalg.norm(shape.doflocs - node, axis=1).argmin()) for node in nodes]
    at, weights = skfem.quadrature.get_quadrature(shape.refdom, degree)
    fields = [shape.lbasis(at, k) for k in order]
    gradients = np.array([gradient.T for _, gradient in fields]).swapaxes(0, 1)
    return Element(corners, ends, at.T, weights, np.array([value for value, _ in fields]).T, gradients)


class Group(NamedTuple):
    """Elements of one kind and material: their names, and their nodes (cells, nodes) as places among the points of the mesh."""

    kind: str
    material: Material
    names: Sequence[str]
    nodes: Indices


def mesh_matrices(points: Array, groups: Sequence[Group]) -> tuple[sparse.csc_array, sparse.csc_array, list[float]]:
    """M and K of the free body, rows x, y, z of each point in turn, and the mass of each group.

    K_ab = ∫ λ ∂N_a/∂x_i ∂N_b/∂x_j + μ (∂N_a/∂x_j ∂N_b/∂x_i + δ_ij ∇N_a·∇N_b) dV, M_ab = δ_ij ∫ ρ N_a N_b dV.
    """
    size = len(points)
    # Entries are summed by pairs of nodes, a third of the rows in each direction: much less memory than by pairs of rows.
    pairs = np.concatenate([(size * group.nodes[:, :, None] + group.nodes[:, None, :]).ravel() for group in groups])
    distinct, place = np.unique(pairs, return_inverse=True)
    blocks, masses = np.zeros((len(distinct), 3, 3)), np.zeros(len(distinct))
    totals, start = list[float](), 0
    for group in groups:
        slopes, volumes = _slopes(group, points[group.nodes])
        values = element(group.kind).values
        own = place[start : start + group.nodes.size * group.nodes.shape[1]]
        start += own.size
        products = np.einsum("qa,qb->qab", values, values).reshape(len(values), -1)
        masses += np.bincount(own, (group.material.density * volumes @ products).ravel(), len(distinct))
        totals.append(group.material.density * float(volumes.sum()))
        for (i, j), matrices in _stiffness(slopes, volumes, group.material):
            blocks[:, i, j] += np.bincount(own, matrices.ravel(), len(distinct))
    for i, j in ((1, 0), (2, 0), (2, 1)):  # the pair (b, a) has the transpose of the block of (a, b)
        blocks[:, i, j] = blocks[np.searchsorted(distinct, distinct % size * size + distinct // size), j, i]
    indices, starts = distinct % size, np.searchsorted(distinct, size * np.arange(size + 1))
    M = sparse.bsr_array((masses[:, None, None], indices, starts), shape=(size, size))
    K = sparse.bsr_array((blocks, indices, starts), shape=(3 * size, 3 * size))
    return sparse.csc_array(sparse.kron(M, sparse.eye_array(3), format="csc")), K.tocsc(), totals


def _slopes(group: Group, points: Array) -> tuple[Array, Array]:
    """Slopes of the shape functions along x, y, z (cells, q, 3, nodes) and volumes (cells, q) at the integration points."""
    own = element(group.kind)
    jacobian = np.einsum("qal,cax->cqlx", own.gradients, points)
    determinants = np.linalg.det(jacobian)
    large = determinants.min(axis=1) > SMALLEST_VOLUME * np.ptp(points, axis=1).max(axis=1) ** 3
    if not large.all():
        first = int(np.argmin(large))
        remedy = "Move its nodes, or number them in the order of the manual: mesh the body again, or turn the element round."
        raise fault(
            f"The Jacobian determinant of element {group.names[first]} ({group.kind})",
            "must be positive at its integration points",
            float(determinants[first].min()),
            f"{np.count_nonzero(~large)} of {len(large)} such elements are inverted or flat. {remedy}",
        )
    return np.linalg.solve(jacobian, own.gradients.swapaxes(1, 2)), determinants * own.weights


def _stiffness(slopes: Array, volumes: Array, material: Material) -> Iterator[tuple[tuple[int, int], Array]]:
    """The part of K between directions i and j, (cells, nodes, nodes), of each i <= j."""
    lam, shear = material.lame
    weighted = volumes[:, :, None, None] * slopes
    trace = sum(weighted[:, :, k].swapaxes(1, 2) @ slopes[:, :, k] for k in range(3))
    for i in range(3):
        for j in range(i, 3):
            product = weighted[:, :, i].swapaxes(1, 2) @ slopes[:, :, j]
            yield (i, j), lam * product + shear * product.swapaxes(1, 2) + (shear * trace if i == j else 0.0)
