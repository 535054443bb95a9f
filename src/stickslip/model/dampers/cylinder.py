"""Cylinder and half cylinder: round towards both platforms.

The curved-flat damper: a flat towards the left platform, a cylinder towards the right one.

The flat-cylinder damper: a flat side under the blade's inclined platform, a cylindrical side on the other neighbour.

The damper of "An Experimental and Computational Comparison of the Dynamic Response Variability in a Turbine Blade with
Under-Platform Dampers". The flat touches at its four corners and its middle, the cylinder line at three points. The paper
gives no dimensions: the default ones are this project's, calibrated with its rig (see `stickslip.model.rigs.single_blade`).
"""

from dataclasses import dataclass, replace
from itertools import product
from math import pi

import numpy as np
from numpy.typing import ArrayLike

from stickslip.model.dampers.damper import Arc, Damper, Line, Section, Shape, Touch, outward, rounded_hull, uphill
from stickslip.model.structure.assembly import RigidBody, box_inertia
from stickslip.support.checks import Array, fault, not_negative, vector


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

    def section(self) -> Section:
        """The disc, its axis at the origin."""
        return Section.bounded_by([Arc((0.0, 0.0), self.radius, 0.0, 2.0 * pi)])

    def body(self) -> RigidBody:
        return self.section().prism(self.depth, self.density, np.zeros(3))

    def left(self) -> Touch:
        return self._touch(self.left_angle, -1)

    def right(self) -> Touch:
        return self._touch(self.right_angle, 1)

    def _touch(self, angle: float, side: int) -> Touch:
        point = self.radius * outward(angle, side) - np.asarray(self.section().centroid)
        return Touch.on_lines(angle, [point], self.depth, self.radius)


@dataclass(frozen=True)
class HalfCylinder(Cylinder):
    """Half a cylinder, its round side out: mass centre 4R/(3π) beyond the flat. Dimensions are those of `Cylinder`."""

    radius: float = 6e-3

    def section(self) -> Section:
        """The half disc, the axis at the origin."""
        r = self.radius
        return Section.bounded_by([Arc((0.0, 0.0), r, 0.0, pi), Line((-r, 0.0), (r, 0.0))])


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
