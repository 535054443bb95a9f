"""The axis about which a bladed disk rotates: rotations by whole sectors, and the axes as users write them."""

from collections.abc import Sequence
from dataclasses import dataclass
from math import cos, pi, sin

import numpy as np

from stickslip.support.checks import Array, fault, vector

AxisLike = str | tuple[Sequence[float], Sequence[float]]
"""An axis through the origin, "x", "y" or "z", or (a point of it [m], its direction)."""


SAME_LINE = 1e-6
"""Share of the size of a body by which two lines may be apart that are one but for the digits in which they are written."""


@dataclass(frozen=True)
class RotationAxis:
    """An axis by a point of it [m] and its unit direction. Sectors are numbered counter-clockwise about it."""

    point: tuple[float, float, float] = (0.0, 0.0, 0.0)
    direction: tuple[float, float, float] = (0.0, 0.0, 1.0)

    @classmethod
    def of(cls, axis: AxisLike) -> "RotationAxis":
        """The axis "x", "y" or "z" through the origin, or that of a point [m] and a direction of any length."""
        if isinstance(axis, str):
            if axis not in ("x", "y", "z"):
                raise fault("The axis of rotation", 'must be "x", "y", "z" or (point, direction)', axis)
            return cls(direction=(float(axis == "x"), float(axis == "y"), float(axis == "z")))
        try:
            point, direction = axis
        except (TypeError, ValueError):
            raise fault("The axis of rotation", 'must be "x", "y", "z" or (point, direction)', axis) from None
        along = vector("The direction of the axis", direction, 3)
        if not along.any():
            raise fault("The direction of the axis", "must not be zero", list(direction))
        along = along / np.abs(along).max()  # squares of tiny entries would vanish
        return cls(tuple(vector("The point of the axis", point, 3).tolist()), tuple((along / np.linalg.norm(along)).tolist()))

    def scaled(self, metres: float) -> "RotationAxis":
        """The axis whose point was given in units of `metres`."""
        x, y, z = self.point
        return RotationAxis((metres * x, metres * y, metres * z), self.direction)

    def is_line_of(self, other: "RotationAxis", size: float) -> bool:
        """Whether both are one line, to rounding of coordinates of this size [m]."""
        apart = self.across @ (np.array(other.point) - self.point)
        turned = size * np.linalg.norm(self.across @ other.direction)
        return bool(np.linalg.norm(apart) + turned <= SAME_LINE * size)

    @property
    def across(self) -> Array:
        """1 − d dᵀ (3, 3): what of a vector is across the axis."""
        return np.eye(3) - np.outer(self.direction, self.direction)

    def turn(self, sectors: int, steps: int = 1) -> Array:
        """R (3, 3), the rotation by `steps` of `sectors` equal sectors: R = d dᵀ + cos φ (1 − d dᵀ) + sin φ [d]ₓ."""
        angle = 2.0 * pi * steps / sectors
        x, y, z = self.direction
        along = np.outer(self.direction, self.direction)
        across = np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])
        return np.asarray(along + cos(angle) * (np.eye(3) - along) + sin(angle) * across)

    def turned(self, points: Array, sectors: int, steps: int = 1) -> Array:
        """Points (n, 3) [m] rotated by `steps` sectors about the axis."""
        return np.asarray((points - self.point) @ self.turn(sectors, steps).T + self.point)

    def angles(self, points: Array) -> Array:
        """Azimuths (n,) of points (n, 3) about the axis, counter-clockwise from an arbitrary zero, in rad."""
        d = np.array(self.direction)
        first = np.cross(d, np.eye(3)[np.argmin(np.abs(d))])
        first /= np.linalg.norm(first)
        away = points - self.point
        return np.asarray(np.arctan2(away @ np.cross(d, first), away @ first))

    def distances(self, points: Array) -> Array:
        """Distances (n,) of points (n, 3) from the axis, m."""
        return np.asarray(np.linalg.norm(np.cross(points - self.point, self.direction), axis=1))


Z_AXIS = RotationAxis()
"""The axis z through the origin."""
