"""Stress due to rotation at places of a sector, from its centrifugal load."""

from __future__ import annotations

import numpy as np
from scipy import sparse

from stickslip.checks import Array, InputError
from stickslip.models.stress_places import StressRows
from stickslip.structure.cyclic_reduction import Sector, hermitian
from stickslip.structure.factor import Factor, Singular
from stickslip.structure.rotation_axis import RotationAxis
from stickslip.structure.stress import von_mises


def rotation_stress(sector: Sector, rows: sparse.csr_array, axis: RotationAxis, speed: float) -> Array:
    """Stress due to rotation (rows,) from `rows` of the motion of a sector, Pa: K u = Ω² M r at nodal diameter 0.

    r: the distance of each node from the axis, as a vector; speed: the speed of K, in rev/min. If K contains the spin
    softening −Ω² M, the load acts at the deformed position.
    """
    d, solid = np.array(axis.direction), sector.solid
    away = solid.points - np.array(axis.point)
    away = away - np.outer(away @ d, d)
    held = solid.numbers < 0
    r = np.zeros(solid.size)
    r[solid.numbers[~held]] = away[~held]
    T = sector.constraint(0)
    K, load = (T.conj().T @ solid.K @ T).tocsc(), (2.0 * np.pi * speed / 60.0) ** 2 * (T.conj().T @ (solid.M @ r))
    try:
        factor = Factor(sparse.csc_array(hermitian(K)))
    except Singular:
        factor = None
    if factor is None or factor.weak:
        raise InputError(
            "For the stress due to rotation the disk must be held along and about its axis, but it is free to move there. "
            "Fix some of its nodes, or leave out the speed."
        )
    return np.asarray((rows @ (T @ factor.solve(load))).real)


def rotation_note(stress: StressRows, mean: Array, speed: float) -> str:
    """What is in the mean stress, by place."""
    sizes = von_mises(mean.reshape(-1, 6)) / 1e6
    listed = ", ".join(f"{size:.4g} MPa at {name}" for name, size in list(zip(stress.nodes, sizes, strict=True))[:6])
    more = f", ... ({len(sizes)})" if len(sizes) > 6 else ""
    return f"The mean stress contains the stress due to rotation at {speed:g} rev/min, von Mises {listed}{more}"
