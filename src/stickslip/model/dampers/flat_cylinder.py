"""The flat-cylinder damper: a flat side under the blade's inclined platform, a cylindrical side on the other neighbour.

The damper of "An Experimental and Computational Comparison of the Dynamic Response Variability in a Turbine Blade with
Under-Platform Dampers". The flat touches at its four corners and its middle, the cylinder line at three points. The paper
gives no dimensions: the default ones are this project's, calibrated with its rig (see `stickslip.model.rigs.single_blade`).
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from itertools import product

import numpy as np
from numpy.typing import ArrayLike

from stickslip.model.dampers.damper import Damper
from stickslip.model.dampers.shape import Shape, Touch, uphill
from stickslip.model.structure.rigid_body import RigidBody, box_inertia
from stickslip.support.checks import fault, not_negative, vector

_CORNERS = ((-0.5, -0.5), (-0.5, 0.5), (0.5, -0.5), (0.5, 0.5))
FLAT_POINTS: dict[int, tuple[tuple[float, float], ...]] = {
    4: _CORNERS,
    5: (*_CORNERS, (0.0, 0.0)),
    9: tuple(product((-0.5, 0.0, 0.5), (-0.5, 0.0, 0.5))),
    15: tuple(product((-0.5, 0.0, 0.5), (-0.5, -0.25, 0.0, 0.25, 0.5))),
}
"""Points of the flat by their number: shares of its width along the slope and of its depth along z."""


@dataclass(frozen=True)
class FlatCylinder(Shape):
    """A flat at the left, a cylinder at the right, both lines of action at one height.

    flat_width: length of the flat along the slope [m]; depth: length along z [m]; centre_offset, cylinder_offset: from the
    middle of the flat to the mass centre and to the cylinder line, along x [m]; mass [kg]; sides: of the box (x, y, z) whose
    inertia it has [m]; flat_points: 4 (corners), 5 (corners and middle), 9 or 15 (three lines along the slope with three or five
    points along z); radius of the cylinder, on which it rolls [m]; slopes of the platforms [degrees].
    """

    flat_width: float = 11.313708498984761e-3
    depth: float = 40e-3
    centre_offset: float = 8e-3
    cylinder_offset: float = 16e-3
    mass: float = 50e-3
    sides: tuple[float, float, float] = (16e-3, 10e-3, 40e-3)
    flat_points: int = 5
    radius: float = 5e-3
    left_angle: float = 45.0
    right_angle: float = 45.0

    def __post_init__(self) -> None:
        self.check("flat_width", "depth", "cylinder_offset", "mass", "radius")
        not_negative("centre_offset", self.centre_offset)
        if self.flat_points not in FLAT_POINTS:
            raise fault("flat_points", f"must be one of {', '.join(map(str, FLAT_POINTS))}", self.flat_points)

    def body(self) -> RigidBody:
        return RigidBody(self.mass, box_inertia(self.mass, self.sides), outline=self.rounded())

    def left(self) -> Touch:
        x, y = uphill(self.left_angle, -1)
        half = np.array(FLAT_POINTS[self.flat_points]) * [self.flat_width, self.depth]
        return Touch(self.left_angle, half @ [[x, y, 0.0], [0.0, 0.0, 1.0]] - [self.centre_offset, 0.0, 0.0])

    def right(self) -> Touch:
        return Touch.on_lines(self.right_angle, [(self.cylinder_offset - self.centre_offset, 0.0)], self.depth, self.radius)

    def beside_blade(self, name: str, pad_centre: ArrayLike, side: int, pull: float, label: str = "") -> Damper:
        """The damper at a blade's right (side = +1: blade at smaller x) or left (−1), pulled up (y) by `pull` [N].

        pad_centre: (3,) [m], the middle of the flat on the platform. Its surfaces are "flat" and "cylinder"; t1 points away from
        the blade and t2 along z at both sides, so that mirrored motions of two dampers have equal signs.
        """
        centre = vector("pad_centre", pad_centre, 3) + np.array([side * self.centre_offset, 0.0, 0.0])
        damper, turned = self.damper(name, centre, side, pull, label), np.diag([-float(side), -1.0, 1.0])
        surfaces = [
            replace(surface, name=called, frame=turned @ np.asarray(surface.frame))
            for surface, called in zip(damper.surfaces, ("flat", "cylinder"), strict=True)
        ]
        return replace(damper, surfaces=tuple(surfaces))
