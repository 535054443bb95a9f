"""The two laboratory dampers with three contact lines: the three-point damper and the crossed curved-flat damper.

Both are stated by where their contacts lie about the mass centre, as measured on a rig, not by an outline. The sources publish
the radii (5 mm) and the distance of the feet (14 mm); masses and the other distances are this project's.
"""

from dataclasses import dataclass

import numpy as np

from stickslip.model.dampers.damper import Shape, Touch, outward, uphill
from stickslip.model.structure.rigid_body import RigidBody, box_inertia
from stickslip.support.checks import finite

SIDES = (0.0134164, 0.0134164, 0.03)
"""Box (x, y, z) [m] with the inertia of the laboratory dampers: 0.6 kg mm² about z at 20 g."""


@dataclass(frozen=True)
class ThreePoint(Shape):
    """Two round feet towards the left platform, one cylinder towards the right one.

    left_distance, right_distance: from the mass centre to the lines of contact, along the normals; foot_distance between the
    feet; foot_shift of their middle uphill; radius of all three roundings; depth along z [m]; mass [kg]; sides (x, y, z) of the
    box whose inertia it has [m]; slopes of the platforms [degrees]. Source of radius and foot_distance: Gola and Gastaldi,
    ASME GT2014-25240.
    """

    left_distance: float = 6e-3
    right_distance: float = 12e-3
    foot_distance: float = 14e-3
    foot_shift: float = 0.0
    radius: float = 5e-3
    depth: float = 30e-3
    mass: float = 0.02
    sides: tuple[float, float, float] = SIDES
    left_angle: float = 45.0
    right_angle: float = 45.0

    def __post_init__(self) -> None:
        self.check("left_distance", "right_distance", "foot_distance", "radius", "depth", "mass")
        finite("foot_shift", self.foot_shift)

    def body(self) -> RigidBody:
        return RigidBody(self.mass, box_inertia(self.mass, self.sides), outline=self.rounded())

    def left(self) -> Touch:
        middle = self.left_distance * outward(self.left_angle, -1) + self.foot_shift * uphill(self.left_angle, -1)
        feet = np.outer([-0.5, 0.5], self.foot_distance * uphill(self.left_angle, -1))
        return Touch.on_lines(self.left_angle, middle + feet, self.depth, self.radius)

    def right(self) -> Touch:
        point = self.right_distance * outward(self.right_angle, 1)
        return Touch.on_lines(self.right_angle, [point], self.depth, self.radius)


@dataclass(frozen=True)
class CrossedCurvedFlat(Shape):
    """A flat at the left and a cylinder at the right whose contacts coincide in the plane: the platforms cross.

    height of the common contact above the mass centre; foot_distance between the ends of the flat; radius of the cylinder;
    depth along z [m]; mass [kg]; sides (x, y, z) of the box whose inertia it has [m]; slopes of the platforms [degrees]. All
    forces then pass through one point: the load on the flat does not wander and the damper does not turn.
    Sources: Gola and Gastaldi, ASME GT2014-25240; Li, Xu, Gola and Botto (2020), figure 2.
    """

    height: float = 4e-3
    foot_distance: float = 14e-3
    radius: float = 5e-3
    depth: float = 30e-3
    mass: float = 0.02
    sides: tuple[float, float, float] = SIDES
    left_angle: float = 45.0
    right_angle: float = 45.0

    def __post_init__(self) -> None:
        self.check("foot_distance", "radius", "depth", "mass")
        finite("height", self.height)

    def body(self) -> RigidBody:
        return RigidBody(self.mass, box_inertia(self.mass, self.sides), outline=self.rounded())

    def left(self) -> Touch:
        feet = np.outer([-0.5, 0.5], self.foot_distance * uphill(self.left_angle, -1))
        return Touch.on_lines(self.left_angle, np.array([0.0, self.height]) + feet, self.depth)

    def right(self) -> Touch:
        return Touch.on_lines(self.right_angle, [(0.0, self.height)], self.depth, self.radius)
