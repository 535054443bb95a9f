"""Cylinder and half cylinder: round towards both platforms."""

from __future__ import annotations

from dataclasses import dataclass
from math import pi

import numpy as np

from stickslip.model.dampers.shape import Arc, Line, Section, Shape, Touch, outward
from stickslip.model.structure.rigid_body import RigidBody


@dataclass(frozen=True)
class Cylinder(Shape):
    """A full cylinder. radius, depth along z [m]; density [kg/m³]; slopes of the platforms [degrees].

    Defaults: the damper of "An Experimental and Computational Comparison ... Bladed Disk" (R 5 mm, L 27.6 mm); its platform
    angle is not published.
    """

    radius: float = 5e-3
    depth: float = 27.6e-3
    density: float = 7800.0
    left_angle: float = 45.0
    right_angle: float = 45.0

    def __post_init__(self) -> None:
        self.check("radius", "depth", "density")

    def body(self) -> RigidBody:
        return Section.bounded_by([Arc((0.0, 0.0), self.radius, 0.0, 2.0 * pi)]).prism(self.depth, self.density, np.zeros(3))

    def left(self) -> Touch:
        return Touch.on_lines(self.left_angle, [self.radius * outward(self.left_angle, -1)], self.depth, self.radius)

    def right(self) -> Touch:
        return Touch.on_lines(self.right_angle, [self.radius * outward(self.right_angle, 1)], self.depth, self.radius)


@dataclass(frozen=True)
class HalfCylinder(Shape):
    """Half a cylinder, its round side out: mass centre 4R/(3π) beyond the flat. radius, depth [m]; density [kg/m³];
    slopes of the platforms [degrees]."""

    radius: float = 6e-3
    depth: float = 27.6e-3
    density: float = 7800.0
    left_angle: float = 45.0
    right_angle: float = 45.0

    def __post_init__(self) -> None:
        self.check("radius", "depth", "density")

    def section(self) -> Section:
        """The half disc, its axis at the origin."""
        r = self.radius
        return Section.bounded_by([Arc((0.0, 0.0), r, 0.0, pi), Line((-r, 0.0), (r, 0.0))])

    def body(self) -> RigidBody:
        return self.section().prism(self.depth, self.density, np.zeros(3))

    def left(self) -> Touch:
        return self._touch(self.left_angle, -1)

    def right(self) -> Touch:
        return self._touch(self.right_angle, 1)

    def _touch(self, angle: float, side: int) -> Touch:
        point = self.radius * outward(angle, side) - np.asarray(self.section().centroid)
        return Touch.on_lines(angle, [point], self.depth, self.radius)
