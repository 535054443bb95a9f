"""Stress due to rotation at places of a sector or of a body, from its centrifugal load.

The rotor speed that a stiffness matrix belongs to, from its spin softening.
"""

from __future__ import annotations

import numpy as np
from scipy import sparse

from stickslip.model.readers.model import Model
from stickslip.model.readers.node_axes import OWN_AXES
from stickslip.model.readers.stress_places import StressRows
from stickslip.model.structure.cyclic_reduction import Sector, hermitian
from stickslip.model.structure.factor import Factor, Singular
from stickslip.model.structure.rotation_axis import RotationAxis
from stickslip.model.structure.stress import von_mises
from stickslip.support.checks import Array, InputError, fault

UNRESISTED = 1e-9
"""Resistance of a row to a translation along the axis, relative to the sum of the sizes of what acts on it, that is rounding."""
SAME_SPEED = 0.01
"""Relative difference up to which two speeds are one."""
UNEXPLAINED = 0.05
"""Share of the resistance to a translation across the axis that may be something else than spin softening."""


def spin_softening(model: Model, axis: RotationAxis) -> float:
    """Ω in rad/s of the spin softening −Ω² M (1 − d dᵀ) in K, d the axis of rotation; 0 where K has none.

    A rigid translation meets neither elastic nor stress stiffness, at nodes that no fixed node or spring holds: those that do
    not resist a translation along d. There K r = −Ω² M r for r across d.
    """
    d = np.array(axis.direction)
    r = _translation(model, d)
    resisted, size = np.asarray(model.K @ r), np.asarray(abs(model.K) @ np.abs(r))
    first = np.cross(d, np.eye(3)[np.argmin(np.abs(d))])
    across = [first / np.linalg.norm(first), np.cross(d, first / np.linalg.norm(first))]
    _, node = np.unique([dof.rpartition(".")[0] for dof in model.dofs], return_inverse=True)
    held = np.bincount(node, np.abs(resisted) > UNRESISTED * size) > 0.0
    free = ~held[node]  # of a node with some held rows, others may be free of K r by the symmetry of the mesh alone
    force, inertia = (
        np.concatenate([(matrix @ _translation(model, direction))[free] for direction in across]) for matrix in (model.K, model.M)
    )
    moved = float(inertia @ inertia)
    square = -float(force @ inertia) / moved if moved else 0.0
    explained = np.linalg.norm(force + square * inertia) <= UNEXPLAINED * np.linalg.norm(force)
    return float(np.sqrt(square)) if square > 0.0 and explained else 0.0


def _translation(model: Model, direction: Array) -> Array:
    """The rigid translation along a vector, (n,)."""
    return np.array(
        [direction["xyz".index(axis)] if axis in "xyz" else 0.0 for _, _, axis in (dof.rpartition(".") for dof in model.dofs)]
    )


def prestress_note(model: Model, axis: RotationAxis, speed: float | None) -> str:
    """What K holds of the rotation, and whether that fits the speed in rev/min; "" where none is given or found."""
    softened = 60.0 / (2.0 * np.pi) * spin_softening(model, axis)
    if speed is not None and softened and abs(softened - speed) > SAME_SPEED * max(softened, speed):
        raise fault(
            "The speed of a model",
            f"must be that whose spin softening its K contains, {softened:.6g} rev/min",
            speed,
            f"Write {softened:.6g}, or take the matrices of another step.",
        )
    if softened:
        return f"K contains the spin softening of {softened:.6g} rev/min, and is assumed to contain its stress stiffening too"
    if speed:
        return (
            f"K is assumed to be that at {speed:g} rev/min, but contains no spin softening: was it written after a step with "
            "CENTRIF? Programs that leave out spin softening give frequencies that are too high"
        )
    return "K contains no spin softening: it is that of the disk at rest" if speed is not None else ""


def rotation_stress(sector: Sector, rows: sparse.csr_array, axis: RotationAxis, speed: float) -> Array:
    """Stress due to rotation (rows,) from `rows` of the motion of a sector, Pa: K u = Ω² M r at nodal diameter 0.

    r: the distance of each node from the axis, as a vector; speed: the speed of K, in rev/min. If K contains the spin
    softening −Ω² M, the load acts at the deformed position.
    """
    solid = sector.solid
    away = _away(solid.points, axis)
    held = solid.numbers < 0
    r = np.zeros(solid.size)
    r[solid.numbers[~held]] = away[~held]
    T = sector.constraint(0)
    K, load = (T.conj().T @ solid.K @ T).tocsc(), _per_distance(speed) * (T.conj().T @ (solid.M @ r))
    motion = T @ _solved(sparse.csc_array(hermitian(K)), load, "the disk must be held along and about its axis")
    return np.asarray((rows @ motion).real)


def rotation_stress_of_body(model: Model, rows: sparse.csr_array, axis: RotationAxis, speed: float) -> Array:
    """The same of a whole model that its supports hold, from `rows` of its motion: K u = Ω² M r."""
    refuse_own_axes(model)
    nodes, _, directions = zip(*(dof.rpartition(".") for dof in model.dofs), strict=True)
    r = np.zeros(model.size)
    along = np.array(["xyz".find(direction) for direction in directions])
    moved = np.flatnonzero(along >= 0)
    missing = [nodes[row] for row in moved.tolist() if nodes[row] not in model.nodes]
    if missing:
        raise fault("For the stress due to rotation all nodes", "must have coordinates", f"node {missing[0]} without")
    away = _away(np.array([model.nodes[nodes[row]] for row in moved.tolist()]).reshape(-1, 3), axis)
    r[moved] = away[np.arange(moved.size), along[moved]]
    load = _per_distance(speed) * (model.M @ r)
    return np.asarray(rows @ _solved(sparse.csc_array(model.K), load, "the model must be held by its supports"))


def refuse_own_axes(model: Model) -> None:
    """Rows along axes of their own have another part of the centrifugal load."""
    if any(OWN_AXES in note for note in model.notes):
        raise fault(
            "For the stress due to rotation all nodes",
            "must have rows along x, y and z of the model",
            "axes of their own",
            "Write the matrices without the local axes of nodes (*TRANSFORM, CD, NROTAT), or leave out the speed.",
        )


def _away(points: Array, axis: RotationAxis) -> Array:
    """Vectors from the axis to points (n, 3), m."""
    d = np.array(axis.direction)
    away = points - np.array(axis.point)
    return np.asarray(away - np.outer(away @ d, d))


def _per_distance(speed: float) -> float:
    """Ω² [1/s²] of a speed in rev/min."""
    return (2.0 * np.pi * speed / 60.0) ** 2


def _solved(K: sparse.csc_array, load: Array, rule: str) -> Array:
    """K⁻¹ load."""
    try:
        factor = Factor(K)
    except Singular:
        factor = None
    if factor is None or factor.weak:
        raise InputError(
            f"For the stress due to rotation {rule}, but it is free to move there. Fix some of its nodes, or leave out the speed."
        )
    return factor.solve(load)


def rotation_note(stress: StressRows, mean: Array, speed: float) -> str:
    """What is in the mean stress, by place."""
    sizes = von_mises(mean.reshape(-1, 6)) / 1e6
    listed = ", ".join(f"{size:.4g} MPa at {name}" for name, size in list(zip(stress.nodes, sizes, strict=True))[:6])
    more = f", ... ({len(sizes)})" if len(sizes) > 6 else ""
    return f"The mean stress contains the stress due to rotation at {speed:g} rev/min, von Mises {listed}{more}"
