"""The two laboratory dampers with three contact lines, the three-point damper and the crossed curved-flat damper, and their rig.

Both are stated by where their contacts lie about the mass centre, as measured on a rig, not by an outline. The sources publish
the radii (5 mm) and the distance of the feet (14 mm); masses and the other distances are this project's.

The rig of Gola and Gastaldi (ASME GT2014-25240), a damper between two platforms moved by actuators. Published: contact stiffness,
friction, radii, foot distance, the motion. Not published: platform angles, the places of the contacts and the mass; those here
are this project's, with 45 degrees (G45) and 37 degrees (G37) as the two geometries.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from stickslip.model.dampers.between_platforms import BetweenPlatforms, ElasticPlatform
from stickslip.model.dampers.damper import Shape, Touch, outward, uphill
from stickslip.model.structure.assembly import RigidBody, box_inertia
from stickslip.support.checks import fault, finite
from stickslip.support.units import N_per_um

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


FRICTION = (0.18, 0.199, 0.45)
"""Published friction coefficients of L1, L2 and R, tuned to a measured cycle."""

KT, KN = 56.0 * N_per_um, 84.0 * N_per_um
"""Published contact stiffness of every line."""

RIG_STIFFNESS, RIG_MASS = 30.0 * N_per_um, 1.0
"""Right platform on its load cells: this project's choice."""


def laboratory_damper(
    platform_angle: float = 45.0,
    pull: float = 80.0,
    friction: ArrayLike = FRICTION,
    shape: str = "three_point",
    kt: ArrayLike = KT,
    kn: ArrayLike = KN,
    elastic: bool = False,
) -> BetweenPlatforms:
    """The three-point damper ("three_point") or the crossed curved-flat one ("crossed_curved_flat") between two platforms.

    platform_angle [degrees] of both; pull: weight on the damper [N]; friction of L1, L2, R; kt, kn [N/m], each a number or one
    entry a line of contact; elastic: the right platform on the stiffness of the rig instead of rigid.
    """
    dimensions = {"three_point": ThreePoint, "crossed_curved_flat": CrossedCurvedFlat}
    if shape not in dimensions:
        raise fault("shape", f"must be one of {', '.join(dimensions)}", shape)
    damper = dimensions[shape](left_angle=platform_angle, right_angle=platform_angle).damper(pull=pull)
    right = ElasticPlatform([[RIG_STIFFNESS, 0.0], [0.0, RIG_STIFFNESS]], RIG_MASS) if elastic else None
    title = f"{shape.replace('_', ' ').capitalize()} damper, {platform_angle:g} degrees, {pull:g} N"
    return BetweenPlatforms.macroslip(damper, kt, kn, friction, right, title)
