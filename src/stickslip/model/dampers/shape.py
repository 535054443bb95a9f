"""Interface of damper shapes: dimensions that give a rigid body and its contact lines on either side.

The platforms form a roof above the damper: the left one rises to the right at `left_angle`, the right one falls at
`right_angle`. Everything is stated in the plane x (right), y (out, along the pull), from the mass centre; z is the depth.
A contact's frame is t1 down the left platform or up the right one, t2 = −z, n from the platform into the damper, so that
u = t1·(u_platform − u_damper) is how far the damper has moved towards the ridge at the left, away from it at the right.
"""

from __future__ import annotations

import re
from abc import ABC, abstractmethod
from dataclasses import dataclass
from math import cos, radians, sin

import numpy as np
from numpy.typing import ArrayLike

from stickslip.model.dampers.damper import ContactSurface, Damper
from stickslip.model.dampers.section import hull_of
from stickslip.model.structure.rigid_body import RigidBody
from stickslip.support.checks import Array, fault, finite, positive, vector

MIRROR = np.diag([-1.0, 1.0, 1.0])


@dataclass(frozen=True, eq=False)
class Touch:
    """How one side of a damper touches: slope of the platform [degrees], points (k, 3) from the mass centre [m], radius of the
    rounding at the points [m], 0 at a flat."""

    angle: float
    points: ArrayLike
    radius: float = 0.0

    @classmethod
    def on_lines(cls, angle: float, places: ArrayLike, depth: float, radius: float = 0.0) -> Touch:
        """On lines along z through places (k, 2) in the plane, the first lowest: three points each, the middles of its thirds."""
        return cls(angle, [(x, y, z) for x, y in np.asarray(places) for z in (-depth / 3.0, 0.0, depth / 3.0)], radius)


def key_of(shape: type[Shape]) -> str:
    """The name of a shape in a study file: HalfCylinder is half_cylinder."""
    return re.sub("(?<!^)([A-Z])", r"_\1", shape.__name__).lower()


class Shape(ABC):
    """A damper's dimensions. A member is a frozen dataclass with `left_angle`, `right_angle` [degrees] that gives `body` and
    `left`, `right`."""

    left_angle: float
    right_angle: float

    @abstractmethod
    def body(self) -> RigidBody:
        """The rigid body with its mass centre at the origin."""

    @abstractmethod
    def left(self) -> Touch:
        """How it touches the left platform."""

    @abstractmethod
    def right(self) -> Touch:
        """How it touches the right platform."""

    def check(self, *positives: str) -> None:
        """Refuse dimensions by name that are not positive, and slopes of platforms that form no roof."""
        for key in positives:
            positive(key, getattr(self, key))
        for key in ("left_angle", "right_angle"):
            if isinstance(getattr(self, key), str):
                raise fault(key, "must be a number", getattr(self, key))
            if not 0.0 <= finite(key, getattr(self, key)) < 90.0:
                raise fault(key, "must lie in [0, 90) degrees", getattr(self, key))
        if self.left_angle + self.right_angle <= 0.0:
            raise fault("left_angle + right_angle", "must be above 0: two level platforms hold no damper", 0.0)

    def rounded(self) -> Array:
        """The band round all that touches, (k, 3) [m] from the mass centre: the drawing of a shape stated by its contacts."""
        circles = []
        for side, touch in ((-1, self.left()), (1, self.right())):
            places = np.unique(np.asarray(touch.points)[:, :2].round(12), axis=0)
            circles += [(place - touch.radius * outward(touch.angle, side), touch.radius) for place in places]
        return np.pad(hull_of(circles), ((0, 0), (0, 1)))

    def damper(
        self, name: str = "damper", centre: ArrayLike = (0.0, 0.0, 0.0), side: int = 1, pull: float = 0.0, label: str = ""
    ) -> Damper:
        """The damper with its mass centre at `centre` (3,) [m], pulled up (y) by `pull` [N]; side −1: mirrored in x."""
        if side not in (-1, 1):
            raise fault("side", "must be 1, or -1 for the mirror image", side)
        turn = np.eye(3) if side == 1 else MIRROR
        place, body = vector("centre", centre, 3), self.body()
        outline = np.reshape(body.outline, (-1, 3))[::side] @ turn
        placed = RigidBody(body.mass, turn @ np.asarray(body.inertia) @ turn, place, outline=outline)
        sides = {"left": (self.left(), left_frame), "right": (self.right(), right_frame)}
        surfaces = []
        for of_side, (touch, frame) in sides.items():
            count = len(np.asarray(touch.points))
            weights = np.full(count, 1.0 / count)
            surfaces.append(ContactSurface(of_side, touch.points, frame(touch.angle), weights, touch.radius))
        if side == -1:
            surfaces = [_mirrored(surface) for surface in surfaces]
        moved = [ContactSurface(s.name, place + np.asarray(s.points), s.frame, s.weights, s.radius) for s in surfaces]
        return Damper(name, placed, tuple(moved), (0.0, pull, 0.0), label)


def left_frame(angle: float) -> Array:
    """Rows t1, t2, n at the left platform, n into the damper."""
    c, s = cos(radians(angle)), sin(radians(angle))
    return np.array([[-c, -s, 0.0], [0.0, 0.0, -1.0], [s, -c, 0.0]])


def right_frame(angle: float) -> Array:
    """Rows t1, t2, n at the right platform, n into the damper."""
    c, s = cos(radians(angle)), sin(radians(angle))
    return np.array([[-c, s, 0.0], [0.0, 0.0, -1.0], [-s, -c, 0.0]])


def outward(angle: float, side: int) -> Array:
    """The normal (2,) from the damper into the platform at the left (side −1) or right (+1)."""
    return np.array([side * sin(radians(angle)), cos(radians(angle))])


def uphill(angle: float, side: int) -> Array:
    """The direction (2,) along the platform towards the ridge of the roof."""
    return np.array([-side * cos(radians(angle)), sin(radians(angle))])


def _mirrored(surface: ContactSurface) -> ContactSurface:
    """The mirror image in x, on the other side; t1 is turned round, which keeps the frame right-handed."""
    name = {"left": "right", "right": "left"}[surface.name]
    return ContactSurface(
        name,
        np.asarray(surface.points) @ MIRROR,
        np.diag([-1.0, 1.0, 1.0]) @ np.asarray(surface.frame) @ MIRROR,
        surface.weights,
        surface.radius,
    )
