"""The curved-flat damper: a flat towards the left platform, a cylinder towards the right one."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from stickslip.model.dampers.shape import Section, Shape, Touch, outward, rounded_hull, uphill
from stickslip.model.structure.rigid_body import RigidBody
from stickslip.support.checks import Array


@dataclass(frozen=True)
class CurvedFlat(Shape):
    """The hull of a flat and a cylinder. flat: its length along the slope; radius of the cylinder; span: from the middle of the
    flat to the axis of the cylinder, along x; depth along z [m]; density [kg/m³]; slopes of the platforms [degrees].

    The flat touches at both its ends.
    """

    flat: float = 14e-3
    radius: float = 5e-3
    span: float = 12e-3
    depth: float = 27.6e-3
    density: float = 7800.0
    left_angle: float = 45.0
    right_angle: float = 45.0

    def __post_init__(self) -> None:
        self.check("flat", "radius", "span", "depth", "density")
        self.section()

    def feet(self) -> Array:
        """The lower and the upper end of the flat, (2, 2), from its middle."""
        return np.outer([-0.5, 0.5], self.flat * uphill(self.left_angle, -1))

    def section(self) -> Section:
        """The hull, the middle of the flat at the origin."""
        lower, upper = self.feet()
        return Section.bounded_by(rounded_hull([(lower, 0.0), ((self.span, 0.0), self.radius), (upper, 0.0)]))

    def body(self) -> RigidBody:
        return self.section().prism(self.depth, self.density, np.zeros(3))

    def left(self) -> Touch:
        return Touch.on_lines(self.left_angle, self.feet() - self.section().centroid, self.depth)

    def right(self) -> Touch:
        point = np.array([self.span, 0.0]) + self.radius * outward(self.right_angle, 1) - self.section().centroid
        return Touch.on_lines(self.right_angle, [point], self.depth, self.radius)
