"""The rotor speed that a stiffness matrix belongs to, from its spin softening."""

from __future__ import annotations

import numpy as np

from stickslip.model.readers.model import Model
from stickslip.model.structure.rotation_axis import RotationAxis
from stickslip.support.checks import Array, fault

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
