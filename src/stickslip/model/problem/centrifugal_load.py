"""A structure in steady rotation: its centrifugal load as a static force of a problem."""

from dataclasses import dataclass, field, replace

import numpy as np

from stickslip.model.loads import Force
from stickslip.model.structure.assembly import prefixed
from stickslip.model.structure.centrifugal import DIRECTIONS, AxisLike, CentrifugalLoads, RotationAxis, coriolis
from stickslip.model.structure.cyclic import CyclicStructure
from stickslip.model.structure.matrices import Point, Structure
from stickslip.support.checks import Array, fault, not_negative


@dataclass(frozen=True)
class CentrifugalLoad(Force):
    """A static force on all of a structure along its own direction (`in_rotation`); resultant (3,): what it is as a whole, N."""

    resultant: Point = field(default=(0.0, 0.0, 0.0), kw_only=True)


def in_rotation(
    structure: Structure, speed: float, axis: AxisLike | RotationAxis = "z", *, part: str = "", with_coriolis: bool = False
) -> tuple[Structure, CentrifugalLoad]:
    """The structure, and the load Ω² M r⊥ of its steady rotation; r⊥ (n,): vectors from the axis to the nodes, m.

    speed: in rev/min, not negative, since the load is the same either way round; axis: "x", "y" or "z" through the origin, or
    (point [m], direction); part: name of the structure in an assembly, whose problem takes the load. A rigid body gets m Ω² r⊥ at
    its mass centre and the moment −Ω × (J Ω). The mean stress of a reduced model includes the part that its modes lack. The
    stiffness is not changed: spin softening and stress stiffening are those of K. with_coriolis: whether to add the Coriolis
    forces 2 ∫ρ Ω × u̇ dV of an unreduced structure, Ω right-handed about `axis`. A sector of a disk rotates only about the axis
    of the disk. Raises `InputError` for another axis, and if coordinates of nodes are not known.
    """
    square = (2.0 * np.pi * not_negative("speed", speed) / 60.0) ** 2
    about = axis if isinstance(axis, RotationAxis) else RotationAxis.of(axis)
    if isinstance(structure, CyclicStructure):
        about = _axis_of(structure, about)
    if any(recovery.rotation is not None for recovery in structure.stresses):
        raise fault("A model with a centrifugal load", "must be read without speed", "one whose mean stress has the rotation")
    loads = structure.centrifugal or CentrifugalLoads.of(structure.M, structure.dofs, structure.nodes)
    load, resultant, lacking = loads.about(about)
    size = float(np.linalg.norm(load))
    along = {prefixed(part, structure.dofs[row]): float(load[row]) / size for row in np.flatnonzero(load)}
    x, y, z = (square * resultant).tolist()
    whole = "a sector" if isinstance(structure, CyclicStructure) else part
    name = f"centrifugal load of {whole}" if whole else "centrifugal load"
    stresses = [
        replace(each, rotation=(square * lacking if lacking.size else np.zeros(6 * len(each.places))).reshape(-1, 6))
        for each in structure.stresses
    ]
    turning = replace(structure, stresses=tuple(stresses)) if stresses else structure
    if with_coriolis:
        if isinstance(structure, CyclicStructure):
            raise fault("with_coriolis", "must be False for a sector, whose Coriolis forces are neglected", True)
        turning = replace(turning, coriolis=np.sqrt(square) * coriolis(structure.M, structure.dofs, about).toarray())
    return turning, CentrifugalLoad(along, static=square * size, name=name, resultant=(x, y, z))


def _axis_of(disk: CyclicStructure, axis: RotationAxis) -> RotationAxis:
    """The axis of a disk, about which it must rotate for all sectors to have the same load."""
    if disk.centrifugal is None:
        remedy = "Read the sector from a model, or state its load by static forces."
        raise fault("A sector with a centrifugal load", "must know the coordinates of all its nodes", "one without", remedy)
    size = max((float(np.linalg.norm(np.subtract(point, disk.axis.point))) for point in disk.nodes.values()), default=1.0)
    if not disk.axis.is_line_of(axis, size):
        given = f"point {axis.point} m, direction {axis.direction}"
        own = f"point {disk.axis.point} m, direction {disk.axis.direction}"
        raise fault("The axis of rotation", "must be that of the disk", given, f"Take that of the disk: {own}.")
    return disk.axis


def inertia_along(structure: Structure, row: Array) -> Array:
    """M r, kg, of a motion r (n,) of a structure as a whole.

    Of a reduced one TᵀM r with the r of all its rows, which T does not make of the rows that are kept where supports hold it: of
    translations alone, whose loads the reduction carries along."""
    inside = np.array([dof.endswith(".q") and "mode/" in dof for dof in structure.dofs])
    if not inside.any():
        return np.asarray(structure.M @ row)
    named = [row[[dof.rpartition(".")[2] == axis for dof in structure.dofs]] for axis in DIRECTIONS]
    shares = np.array([of_axis[0] if of_axis.size else 0.0 for of_axis in named])
    whole = all(np.all(of_axis == share) for of_axis, share in zip(named, shares, strict=True)) and not shares[3:].any()
    if structure.centrifugal is None or not whole:
        remedy = "Take the model whole, without `keep`, where the base turns or where several models are joined."
        given = "another motion" if structure.centrifugal is not None else "a model of which more is not known"
        raise fault("A moving base", "must move a reduced model as a whole along x, y and z", given, remedy)
    return np.asarray(shares[:3] @ structure.centrifugal.table[6:, : structure.size])
