"""Centrifugal loads of a structure: static loads Ω² M r⊥ for any axis, from nine loads that a reduction carries along.

The acceleration that a steady rotation takes at a point x is −D (x − p), with D = Ω² (1 − d dᵀ), d the direction of the axis and
p a point of it: it is linear in the six entries of D and in D p.

Centrifugal stress stiffening and spin softening of a rotating body.

Linear about the state of steady rotation at Ω: K(Ω) = K + Ω² S, and Coriolis forces, skew, that go with the velocity.

The axis about which a bladed disk rotates: rotations by whole sectors, and the axes as users write them.
"""

from collections.abc import Collection, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from math import cos, pi, sin
from typing import Any

import numpy as np
from scipy import sparse

from stickslip.model.structure.factor import Factor, Singular
from stickslip.model.structure.solid import Material, ShapeFunctions, Solid, shape_functions, solid
from stickslip.support.checks import Array, Index, fault, vector

AxisLike = str | tuple[Sequence[float], Sequence[float]]
"""An axis through the origin, "x", "y" or "z", or (a point of it [m], its direction)."""


SAME_LINE = 1e-6
"""Share of the size of a body by which two lines may be apart that are one but for the digits in which they are written."""


@dataclass(frozen=True)
class RotationAxis:
    """An axis by a point of it [m] and its unit direction. Sectors are numbered counter-clockwise about it."""

    point: tuple[float, float, float] = (0.0, 0.0, 0.0)
    direction: tuple[float, float, float] = (0.0, 0.0, 1.0)

    @classmethod
    def of(cls, axis: AxisLike) -> "RotationAxis":
        """The axis "x", "y" or "z" through the origin, or that of a point [m] and a direction of any length."""
        if isinstance(axis, str):
            if axis not in ("x", "y", "z"):
                raise fault("The axis of rotation", 'must be "x", "y", "z" or (point, direction)', axis)
            return cls(direction=(float(axis == "x"), float(axis == "y"), float(axis == "z")))
        try:
            point, direction = axis
        except (TypeError, ValueError):
            raise fault("The axis of rotation", 'must be "x", "y", "z" or (point, direction)', axis) from None
        along = vector("The direction of the axis", direction, 3)
        if not along.any():
            raise fault("The direction of the axis", "must not be zero", list(direction))
        along = along / np.abs(along).max()  # squares of tiny entries would vanish
        return cls(tuple(vector("The point of the axis", point, 3).tolist()), tuple((along / np.linalg.norm(along)).tolist()))

    def scaled(self, metres: float) -> "RotationAxis":
        """The axis whose point was given in units of `metres`."""
        x, y, z = self.point
        return RotationAxis((metres * x, metres * y, metres * z), self.direction)

    def is_line_of(self, other: "RotationAxis", size: float) -> bool:
        """Whether both are one line, to rounding of coordinates of this size [m]."""
        apart = self.across @ (np.array(other.point) - self.point)
        turned = size * np.linalg.norm(self.across @ other.direction)
        return bool(np.linalg.norm(apart) + turned <= SAME_LINE * size)

    @property
    def across(self) -> Array:
        """1 − d dᵀ (3, 3): what of a vector is across the axis."""
        return np.eye(3) - np.outer(self.direction, self.direction)

    def turn(self, sectors: int, steps: int = 1) -> Array:
        """R (3, 3), the rotation by `steps` of `sectors` equal sectors."""
        return rotation_about(np.array(self.direction), 2.0 * pi * steps / sectors)

    def turned(self, points: Array, sectors: int, steps: int = 1) -> Array:
        """Points (n, 3) [m] rotated by `steps` sectors about the axis."""
        return np.asarray((points - self.point) @ self.turn(sectors, steps).T + self.point)

    def angles(self, points: Array) -> Array:
        """Azimuths (n,) of points (n, 3) about the axis, counter-clockwise from an arbitrary zero, in rad."""
        d = np.array(self.direction)
        first = np.cross(d, np.eye(3)[np.argmin(np.abs(d))])
        first /= np.linalg.norm(first)
        away = points - self.point
        return np.asarray(np.arctan2(away @ np.cross(d, first), away @ first))

    def distances(self, points: Array) -> Array:
        """Distances (n,) of points (n, 3) from the axis, m."""
        return np.asarray(np.linalg.norm(np.cross(points - self.point, self.direction), axis=1))


Z_AXIS = RotationAxis()
"""The axis z through the origin."""


ENTRIES = ((0, 0), (1, 1), (2, 2), (0, 1), (0, 2), (1, 2))
"""Of a symmetric matrix (3, 3), that are given once."""
UNITS = np.array([[[float((i, j) in ((a, b), (b, a))) for j in range(3)] for i in range(3)] for a, b in ENTRIES])
"""The matrix of each entry alone, (6, 3, 3)."""
DIRECTIONS = ("x", "y", "z", "rx", "ry", "rz")


@dataclass(frozen=True, eq=False)
class CentrifugalLoads:
    """M u over n coordinates: six u = D x of unit entries of D [kg m], and three unit translations [kg].

    table (9, n + 3 + k): of each the load, its resultant, and whatever else is linear in it, such as the stress of a model whose
    coordinates rest.
    """

    table: Array
    size: int

    @classmethod
    def of(
        cls, M: Any, dofs: Sequence[str], nodes: Mapping[str, Sequence[float]], inner: Collection[str] = ()
    ) -> "CentrifugalLoads":
        """Those of all rows of M (n, n), dense or sparse; dofs: "NODE.DIRECTION" of each row; nodes: coordinates, m; inner: nodes
        of incompatible modes of elements, which move relative to the others and have no place.

        A node with six rows whose M joins no other one is a rigid body: it has the moment −Ω × (J Ω), and the force of a mass
        beside its node. Of all others the translations count.
        """
        mass, count = sparse.csr_array(M), len(dofs)
        named = [dof.rpartition(".") for dof in dofs]
        for dof, (node, _, direction) in zip(dofs, named, strict=True):
            if node not in nodes and node not in inner:
                remedy = (
                    "Give the coordinates of all nodes, by a deck or table in `names`, and each part of an assembly by itself."
                )
                raise fault(f"Node {node!r} of a structure with a centrifugal load", "must have coordinates", "none", remedy)
            if direction not in DIRECTIONS:
                raise fault(
                    "A structure with a centrifugal load", "must have rows along x, y, z and rotations of nodes alone", dof
                )
        points = np.array([nodes.get(node, (0.0, 0.0, 0.0)) for node, _, _ in named]).reshape(count, 3)
        along = np.array([[float(direction == axis and node in nodes) for axis in "xyz"] for node, _, direction in named])
        motions = np.hstack([np.einsum("ni,kij,nj->nk", along, UNITS, points), along])
        rows = np.asarray((mass @ motions).T)
        _add_bodies(rows, mass, named)
        return cls(np.hstack([rows, rows @ along]), count)

    def shifted(self, by: Array) -> "CentrifugalLoads":
        """Those of the same structure elsewhere, `by` (3,) [m]."""
        rest = self.table[6:]
        return replace(self, table=np.vstack([self.table[:6] + UNITS @ by @ rest, rest]))

    def on_rows(self, rows: Index) -> "CentrifugalLoads":
        """Those on some of the rows: the others are held."""
        return CentrifugalLoads(np.hstack([self.table[:, rows], self.table[:, self.size :]]), rows.size)

    def projected(self, T: Array, held: Array) -> "CentrifugalLoads":
        """Those on few coordinates y of the motion T y, with more that is linear in them, `held` (k, 9)."""
        return CentrifugalLoads(np.hstack([self.table[:, : self.size] @ T, self.table[:, self.size :], held.T]), T.shape[1])

    def about(self, axis: RotationAxis) -> tuple[Array, Array, Array]:
        """Load (n,), resultant (3,) and what else there is (k,) at Ω = 1 rad/s."""
        weights = np.concatenate([[axis.across[entry] for entry in ENTRIES], -axis.across @ np.array(axis.point)])
        acting = weights @ self.table
        rounding = weights.size * np.finfo(float).eps * (np.abs(weights) @ np.abs(self.table))
        acting[np.abs(acting) <= rounding] = 0.0  # a body on the axis is not pulled
        load, resultant, more = np.split(acting, [self.size, self.size + 3])
        return load, resultant, more


def _add_bodies(rows: Array, mass: sparse.csr_array, named: Sequence[tuple[str, str, str]]) -> None:
    """Add to loads (9, n) what the rotations of nodes that M joins to no other one bring: ε_ijk (D J)_jk and D (m c).

    −Ω × (J Ω) has the components ε_ijk (D J)_jk, since ΩΩᵀ = Ω² 1 − D and J is symmetric. c is the place of the mass centre from
    the node: a velocity v of the node and ω have the energy m v·(ω × c), so that M of rotations and translations is m [c]×.
    """
    for at, block in _bodies(mass, named):
        turned = UNITS @ block[3:, 3:]
        offset = np.array([block[5, 1], block[3, 2], block[4, 0]])
        rows[:6, at[:3]] += UNITS @ offset
        rows[:6, at[3:]] += np.stack([turned[:, i - 2, i - 1] - turned[:, i - 1, i - 2] for i in range(3)], axis=1)


def _bodies(mass: sparse.csr_array, named: Sequence[tuple[str, str, str]]) -> Iterator[tuple[list[int], Array]]:
    """The rows x, y, z, rx, ry, rz of nodes whose M joins no other one, and M among these (6, 6)."""
    of_nodes: dict[str, dict[str, int]] = {}
    for row, (node, _, direction) in enumerate(named):
        of_nodes.setdefault(node, {})[direction] = row
    for own in of_nodes.values():
        if set(DIRECTIONS) <= own.keys():
            at = [own[direction] for direction in DIRECTIONS]
            block = mass[at][:, at].toarray()
            if mass[at].count_nonzero() == np.count_nonzero(block):
                yield at, block


def softening(M: Any, dofs: Sequence[str], axis: RotationAxis) -> sparse.csc_array:
    """M (1 − d dᵀ) [kg] of rows along x, y and z, which times −Ω² is the spin softening; symmetric."""
    nodes = {node: k for k, node in enumerate(dict.fromkeys(dof.rpartition(".")[0] for dof in dofs))}
    columns = [3 * nodes[dof[:-2]] + "xyz".index(dof[-1]) for dof in dofs]
    rows = sparse.csc_array((np.ones(len(dofs)), (np.arange(len(dofs)), columns)), shape=(len(dofs), 3 * len(nodes)))
    P = rows @ sparse.kron(sparse.eye_array(len(nodes)), axis.across) @ rows.T
    return sparse.csc_array(0.5 * (P @ M + M @ P))


def coriolis(M: Any, dofs: Sequence[str], axis: RotationAxis) -> sparse.csc_array:
    """2 M [d]ₓ [kg], which times Ω is the matrix of Coriolis forces 2 ∫ρ Ω × u̇ dV, skew; rows along x, y, z, or of rigid bodies.

    Of a rigid body with the velocity v of its node and ω, S = m [c]ₓ the place of its mass centre and P = ∫ r rᵀ dm = ½ tr J − J:
    force 2 Ω × (m v − S ω), moment 2 S (Ω × v) + 2 (P Ω) × ω.
    """
    mass, named = sparse.csr_array(M), [dof.rpartition(".") for dof in dofs]
    number = {node: k for k, node in enumerate(dict.fromkeys(node for node, _, _ in named))}
    d = np.array(axis.direction)
    moving = np.array([direction in ("x", "y", "z") for _, _, direction in named], dtype=float)
    at = [3 * number[node] + max("xyz".find(direction[-1:]), 0) for node, _, direction in named]
    rows = sparse.csr_array((moving, (np.arange(len(at)), at)), shape=(len(at), 3 * len(number)))
    E = rows @ sparse.kron(sparse.eye_array(len(number)), cross(d)) @ rows.T
    turning = sparse.diags_array(1.0 - moving)
    found = sparse.lil_array(E @ mass + mass @ E + E @ mass @ turning + turning @ mass @ E)
    bodies = list(_bodies(mass, named))
    for own, block in bodies:
        J = block[3:, 3:]
        for row, moments in zip(own[3:], 2.0 * cross((0.5 * np.trace(J) * np.eye(3) - J) @ d), strict=True):
            found[row, own[3:]] = moments
    known = {row for own, _ in bodies for row in own}
    other = next((dofs[row] for row in range(len(dofs)) if not moving[row] and row not in known), None)
    if other is not None:
        rule = "must have rows along x, y and z, and rotations of rigid bodies, alone"
        raise fault("A structure with Coriolis forces", rule, other)
    return sparse.csc_array(0.5 * (found - found.T))


def cross(a: Array) -> Array:
    """[a]ₓ (3, 3): [a]ₓ b = a × b."""
    x, y, z = a
    return np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])


def rotation_about(direction: Array, angle: float) -> Array:
    """R (3, 3), the rotation by an angle φ about a unit vector d: R = d dᵀ + cos φ (1 − d dᵀ) + sin φ [d]ₓ (Rodrigues)."""
    along = np.outer(direction, direction)
    return np.asarray(along + cos(angle) * (np.eye(3) - along) + sin(angle) * cross(direction))


ACROSS = np.diag([1.0, 1.0, 0.0])
"""What of a place is across the axis of rotation."""


def spinning(body: Solid, mesh: Any, material: Material, rate: float, joined: sparse.csc_array | None = None) -> Solid:
    """The body of this mesh and material at steady rotation about z, `rate` Ω in rad/s: K + Ω² S.

    joined: motion of all degrees of freedom from independent ones, (n, independent), as of a sector of which the whole disk
    spins (nodal diameter 0); none unless given.
    """
    if rate == 0.0:
        return body
    K = sparse.csc_array(body.K + rate**2 * spin_stiffness(body, mesh, material, joined))
    if not holds(K if joined is None else sparse.csc_array(joined.T @ K @ joined)):
        rule = "must leave the body its stiffness"
        raise fault("rotation", rule, rate / (2.0 * np.pi), "Its unit is turns a second; beyond a speed softening wins.")
    return replace(body, K=K)


def holds(K: Any) -> bool:
    """Whether a stiffness has positive eigenvalues alone."""
    try:
        factor = Factor(sparse.csc_array(K))
    except Singular:
        return False
    return factor.negative == 0 and factor.weak == 0


def spin_stiffness(body: Solid, mesh: Any, material: Material, joined: sparse.csc_array | None = None) -> sparse.csc_array:
    """S = ∫ δ_ij ∇N_a·σ ∇N_b − ρ N_a N_b P_ij dV, kg: σ the stress that Ω = 1 rad/s builds up, P the part across the axis.

    The stress is that of the static problem K u = ∫ ρ N_a P x dV at small displacements.
    """
    shapes = shape_functions(mesh)
    free = np.flatnonzero(body.numbers.ravel() >= 0)
    M = solid(mesh, material).M
    load = (M @ (shapes.points @ ACROSS).ravel())[free]
    T: Any = sparse.eye_array(free.size, format="csc") if joined is None else joined
    moved = np.zeros(shapes.size)
    moved[free] = T @ Factor(sparse.csc_array(T.T @ body.K @ T)).solve(T.T @ load)
    stiffening = _geometric(shapes, _stress(shapes, moved, material))
    softening = sparse.diags_array(np.tile(np.diag(ACROSS), len(shapes.points))) @ M
    return sparse.csc_array((shapes.assembled(stiffening) - softening)[free][:, free])


def _stress(shapes: ShapeFunctions, moved: Array, material: Material) -> Array:
    """σ = λ tr ε I + 2µ ε at the quadrature points, (3, 3, cells, q)."""
    gradient = np.einsum("cai,ajcq->ijcq", moved[shapes.rows], shapes.gradients, optimize=True)
    lam, shear = material.lame
    dilatation = np.einsum("iicq->cq", gradient)
    return np.asarray(lam * np.eye(3)[:, :, None, None] * dilatation + shear * (gradient + gradient.swapaxes(0, 1)))


def _geometric(shapes: ShapeFunctions, stress: Array) -> Array:
    """δ_ij ∫ ∇N_a·σ ∇N_b dV of each cell, (cells, 3a, 3a)."""
    count, _, cells, _ = shapes.gradients.shape
    pulled = np.einsum("ijcq,bjcq->bicq", stress, shapes.gradients, optimize=True) * shapes.volumes
    blocks = np.einsum("aicq,bicq->cab", shapes.gradients, pulled, optimize=True)
    whole = np.zeros((cells, count, 3, count, 3))
    for axis in range(3):
        whole[:, :, axis, :, axis] = blocks
    return whole.reshape(cells, 3 * count, 3 * count)
