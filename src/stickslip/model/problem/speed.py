"""How a problem goes with the time of its excitation: in steady rotation, with the rotor speed that it follows, and over several
of its periods."""

from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from stickslip.model.loads import BaseMotion, Force
from stickslip.model.structure.assembly import prefixed
from stickslip.model.structure.centrifugal import DIRECTIONS, AxisLike, CentrifugalLoads, RotationAxis, coriolis
from stickslip.model.structure.cyclic import CyclicStructure
from stickslip.model.structure.matrices import Point, Structure
from stickslip.support.checks import Array, InputError, between, fault, not_negative, of_kind, several

if TYPE_CHECKING:
    from stickslip.model.problem.problem import Problem


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


@dataclass(frozen=True, eq=False)
class SpeedDependence:
    """An engine order excites at ω = EO Ω; stiffness and constant loads vary with the speed Ω [rad/s], K + Ω² K₁, p + Ω² p₁.

    stiffness: K₁ [N s²/m], symmetric: (n, n), of a cyclic structure one for each nodal diameter as its `stiffnesses`; None if
    only loads vary with the speed. loads: forces whose `static` is the load per Ω², N s² (m r of a damper whose pull is m r Ω²),
    without a harmonic part. Structure, C and static loads of the problem itself are those at rest, Ω = 0. Coriolis terms are
    neglected. Harmonic h of the motion, h ω = h EO Ω, sees the dynamic stiffness K + i h ω C − (h ω)² (M − K₁/(h EO)²), and the
    mean K + (ω/EO)² K₁.
    """

    engine_order: int
    stiffness: NDArray[Any] | None = None
    loads: tuple[Force, ...] = ()

    def __post_init__(self) -> None:
        between("speed.engine_order", self.engine_order, 1)
        object.__setattr__(self, "loads", several("speed.loads", self.loads))
        for load in self.loads:
            of_kind("speed.loads, a load", load, Force)
            if isinstance(load, BaseMotion) or any(load.amplitudes.values()):
                raise fault("speed.loads, a load", "must be a Force with its static part alone", load)
        if self.stiffness is not None:
            object.__setattr__(self, "stiffness", np.asarray(self.stiffness))

    def check(self, shape: tuple[int, ...]) -> None:
        """Refuse a K₁ that does not fit the stiffness of a structure."""
        if self.stiffness is None:
            return
        if self.stiffness.shape != shape:
            raise fault("speed.stiffness", f"must have the shape of K, {shape}", self.stiffness.shape)
        if not np.all(np.isfinite(self.stiffness)):
            raise fault("speed.stiffness", "must hold finite numbers", "NaN or infinite ones")
        gap = np.abs(self.stiffness - np.swapaxes(self.stiffness, -1, -2).conj()).max(initial=0.0)
        if gap > 1e-8 * np.abs(self.stiffness).max(initial=0.0):
            raise fault("speed.stiffness", "must be symmetric", f"a difference of {gap:.3g} to its transpose")

    def at(self, omega: float) -> float:
        """The rotor speed Ω, rad/s, at a frequency of the excitation, rad/s."""
        return omega / self.engine_order


def refuse_speed(problem: "Problem", what: str) -> None:
    """Refuse a problem of many speeds where one is needed."""
    if problem.speed is not None:
        raise InputError(
            f"{what} must be of a problem at one rotor speed, but stiffness and loads of this one go with it. "
            "Use problem.at_speed(speed), in rad/s."
        )


MOST_PERIODS = 16


def over_periods(problem: "Problem", periods: int) -> "Problem":
    """The problem over p periods of its excitation as one period of its own, of angular frequency ω/p: harmonic h of a load
    becomes harmonic p h. Refused for tuned disks, whose waves of a fraction of the engine order do not exist."""
    if between("periods", periods, 1, MOST_PERIODS) == 1:
        return problem
    if problem.speed is not None:
        raise fault("periods", "must be 1 where the frequency stands for the rotor speed", periods, "Use problem.at_speed(...).")
    if not problem.systems.one_for_vibration:
        raise InputError(
            "A motion over several periods must be asked for a structure that all harmonics share, but this disk is one sector "
            "that moves in waves of the engine order. Ask it of `disk.full()`."
        )
    forces = []
    for force in problem.forces:
        factor = float(periods) ** force.omega_power  # of a load that goes by ω^k, now counted in ω/p
        amplitude = {periods * harmonic: factor * amplitude for harmonic, amplitude in force.amplitudes.items()}
        forces.append(replace(force, amplitude=amplitude))
    return problem.with_forces(forces)
