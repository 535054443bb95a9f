"""Models of the single-blade rig with what its test rig has besides: force separators behind the dampers, and a stinger.

A force separator is an L-shaped rigid body between a damper's cylinder side and two load cells. Its arms start behind the
cylinder line, one outwards (x), one upwards (y), so that the contact force splits into one force along each arm; at the end of
each arm sits a load cell, fixed on its far side. The paper shows the principle and gives no dimension: those here are this
project's choice (docs/variability.md says what they change).
"""

from collections.abc import Iterator
from dataclasses import dataclass, replace
from math import cos, radians, sin

import numpy as np
from numpy.typing import ArrayLike

from stickslip.model.problem import Problem
from stickslip.model.rigs import single_blade
from stickslip.model.rigs.single_blade import PlatformBlade, damper_shape, placed_dampers
from stickslip.model.structure.assembly import Motion, RigidBody, Spring, assemble, box_inertia, prefixed
from stickslip.model.structure.matrices import Structure
from stickslip.support.checks import Array
from stickslip.support.units import STANDARD_GRAVITY, N_per_um

MASS = 4.6
"""Preload of the rig [kg]."""
ARMATURE = "shaker/armature.x"
"""The moving mass of a shaker that pushes through a stinger."""


def with_separators(mass: float = 0.3, cell_stiffness: float = 500 * N_per_um, modes: int = 150) -> Problem:
    """The rig whose cylinder sides press against separators, five bodies in all, instead of a rigid support."""
    rig, blade = single_blade(MASS, modes=modes), PlatformBlade()
    separator = ForceSeparator(mass=mass, cell_stiffness=cell_stiffness)
    contacts, parts = {contact.name: contact for contact in rig.contacts}, dict[str, Separator]()
    shape = damper_shape(blade, mass=50e-3, centre_offset=8e-3, cylinder_offset=16e-3, flat_points=5)
    for damper in placed_dampers(blade, shape, MASS * STANDARD_GRAVITY):
        line = np.asarray(damper.surface("cylinder").points)
        part = separator.placed(f"separator_{damper.label}", line.mean(axis=0), -1 if damper.label == "left" else 1, 45.0)
        parts[part.name] = part
        law = contacts[f"{damper.label} cylinder 1"].law
        behind = damper.contacts("cylinder", lambda share, law=law: law, [part.at(point) for point in line])  # type: ignore[misc]
        contacts |= {each.name: replace(each, law=contacts[each.name].law) for each in behind}
    bodies = {"": rig.structure.with_damping(None)} | {name: part.structure for name, part in parts.items()}
    structure = assemble(bodies, [cell for part in parts.values() for cell in part.cells()])
    return replace(rig, structure=structure.with_damping(rig.structure.damping), contacts=tuple(contacts.values()))


def with_stinger(stiffness: float, mass: float = 0.2, modes: int = 150) -> Problem:
    """The rig whose shaker has a moving mass [kg], which pushes the blade through a spring [N/m]."""
    rig = single_blade(MASS, modes=modes)
    armature = Structure(np.array([[mass]]), np.zeros((1, 1)), (ARMATURE.partition("/")[2],))
    stinger = Spring({ARMATURE: 1.0, "blade/force.x": -1.0}, stiffness)
    structure = assemble({"": rig.structure.with_damping(None), "shaker": armature}, [stinger])
    shaker, *pulls = rig.forces
    return replace(
        rig, structure=structure.with_damping(rig.structure.damping), forces=(replace(shaker, direction=ARMATURE), *pulls)
    )


@dataclass(frozen=True)
class ForceSeparator:
    """Dimensions [m], mass [kg] and load cells of a separator.

    arm, thickness, depth: of each of the two equal arms; pad: from the cylinder line to the axes of the arms; mass: of both
    arms together; cell_stiffness k along the cell's axis [N/m]; cell_shear: lateral stiffness as a share of k; cell_radius r:
    the cell is a disc of springs, with k r²/4 against bending and share k r²/2 against torsion [N m/rad].
    """

    arm: float = 40e-3
    thickness: float = 12e-3
    depth: float = 40e-3
    pad: float = 5e-3
    mass: float = 0.3
    cell_stiffness: float = 500 * N_per_um
    cell_shear: float = 0.3
    cell_radius: float = 10e-3

    def placed(self, name: str, line_centre: ArrayLike, side: int, platform_angle: float) -> "Separator":
        """The separator behind a cylinder line (3,) [m] on the right (side 1) or left (−1) of the blade; angle in degrees."""
        angle = radians(platform_angle)
        normal = np.array([side * sin(angle), cos(angle), 0.0])
        return Separator(name, self, np.asarray(line_centre) + self.pad * normal, side)


@dataclass(frozen=True, eq=False)
class Separator:
    """A separator in place, named as its body is in the assembly; corner (3,) [m]: where the axes of its arms meet."""

    name: str
    shape: ForceSeparator
    corner: Array
    side: int

    @property
    def arms(self) -> Array:
        """Unit vectors along the arm in x and the arm in y, (2, 3)."""
        return np.array([[float(self.side), 0.0, 0.0], [0.0, 1.0, 0.0]])

    @property
    def body(self) -> RigidBody:
        """Both arms as boxes of half the mass each."""
        s = self.shape
        centre = self.corner + 0.25 * s.arm * self.arms.sum(axis=0)
        inertia = np.zeros((3, 3))
        for along in self.arms:
            sides = np.where(along != 0.0, s.arm, s.thickness)
            sides[2] = s.depth
            lever = self.corner + 0.5 * s.arm * along - centre
            inertia += box_inertia(0.5 * s.mass, sides) + 0.5 * s.mass * (lever @ lever * np.eye(3) - np.outer(lever, lever))
        return RigidBody(s.mass, inertia, centre)

    @property
    def structure(self) -> Structure:
        """The free body, to be assembled under the separator's name."""
        return self.body.structure()

    def at(self, point: ArrayLike) -> Motion:
        """The motion of a point of the separator [m], in the names of the assembly."""
        return self.body.at(point, self.name)

    def cells(self) -> Iterator[Spring]:
        """The load cells as springs to ground: axial, lateral, bending and torsion, six each."""
        s, body = self.shape, self.body
        for along in self.arms:
            seat = body.at(self.corner + s.arm * along, self.name)
            for axis, letter in zip(np.eye(3), "xyz", strict=True):
                axial = bool(axis @ along)
                yield Spring(seat(axis.tolist()), s.cell_stiffness * (1.0 if axial else s.cell_shear))
                turning = 0.5 * s.cell_shear if axial else 0.25
                rotation = prefixed(self.name, f"{body.node}.r{letter}")
                yield Spring({rotation: 1.0}, turning * s.cell_stiffness * s.cell_radius**2)
