"""Stress due to rotation at places of a sector or of a body, from its centrifugal load."""

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
