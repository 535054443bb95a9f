"""Centrifugal loads of a structure: static loads Ω² M r⊥ for any axis, from nine loads that a reduction carries along.

The acceleration that a steady rotation takes at a point x is −D (x − p), with D = Ω² (1 − d dᵀ), d the direction of the axis and
p a point of it: it is linear in the six entries of D and in D p.
"""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from scipy import sparse

from stickslip.model.structure.rotation_axis import RotationAxis
from stickslip.support.checks import Array, Index, fault

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
    ) -> CentrifugalLoads:
        """Those of all rows of M (n, n), dense or sparse; dofs: "NODE.DIRECTION" of each row; nodes: coordinates, m; inner: nodes
        of incompatible modes of elements, which move relative to the others and have no place.

        A node with six rows whose M joins no other one is a rigid body: it has the moment −Ω × (J Ω), and the force of a mass
        beside its node. Of all others the translations count.
        """
        mass, count = sparse.csr_array(M), len(dofs)
        named = [dof.rpartition(".") for dof in dofs]
        for dof, (node, _, direction) in zip(dofs, named, strict=True):
            if (node not in nodes and node not in inner) or direction not in DIRECTIONS:
                raise fault(
                    "A structure with a centrifugal load",
                    "must have rows along x, y, z and rotations of nodes with coordinates alone",
                    dof,
                    "Give the coordinates of all nodes, by a deck or table in `names`, and each part of an assembly by itself.",
                )
        points = np.array([nodes.get(node, (0.0, 0.0, 0.0)) for node, _, _ in named]).reshape(count, 3)
        along = np.array([[float(direction == axis and node in nodes) for axis in "xyz"] for node, _, direction in named])
        motions = np.hstack([np.einsum("ni,kij,nj->nk", along, UNITS, points), along])
        rows = np.asarray((mass @ motions).T)
        _add_bodies(rows, mass, named)
        return cls(np.hstack([rows, rows @ along]), count)

    def shifted(self, by: Array) -> CentrifugalLoads:
        """Those of the same structure elsewhere, `by` (3,) [m]."""
        rest = self.table[6:]
        return replace(self, table=np.vstack([self.table[:6] + UNITS @ by @ rest, rest]))

    def on_rows(self, rows: Index) -> CentrifugalLoads:
        """Those on some of the rows: the others are held."""
        return CentrifugalLoads(np.hstack([self.table[:, rows], self.table[:, self.size :]]), rows.size)

    def projected(self, T: Array, held: Array) -> CentrifugalLoads:
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
    of_nodes: dict[str, dict[str, int]] = {}
    for row, (node, _, direction) in enumerate(named):
        of_nodes.setdefault(node, {})[direction] = row
    for own in of_nodes.values():
        if len(own) < len(DIRECTIONS):
            continue
        at = [own[direction] for direction in DIRECTIONS]
        block = mass[at][:, at].toarray()
        if mass[at].count_nonzero() > np.count_nonzero(block):
            continue
        turned = UNITS @ block[3:, 3:]
        offset = np.array([block[5, 1], block[3, 2], block[4, 0]])
        rows[:6, at[:3]] += UNITS @ offset
        rows[:6, at[3:]] += np.stack([turned[:, i - 2, i - 1] - turned[:, i - 1, i - 2] for i in range(3)], axis=1)


def softening(M: Any, dofs: Sequence[str], axis: RotationAxis) -> sparse.csc_array:
    """M (1 − d dᵀ) [kg] of rows along x, y and z, which times −Ω² is the spin softening; symmetric."""
    nodes = {node: k for k, node in enumerate(dict.fromkeys(dof.rpartition(".")[0] for dof in dofs))}
    columns = [3 * nodes[dof[:-2]] + "xyz".index(dof[-1]) for dof in dofs]
    rows = sparse.csc_array((np.ones(len(dofs)), (np.arange(len(dofs)), columns)), shape=(len(dofs), 3 * len(nodes)))
    P = rows @ sparse.kron(sparse.eye_array(len(nodes)), axis.across) @ rows.T
    return sparse.csc_array(0.5 * (P @ M + M @ P))
