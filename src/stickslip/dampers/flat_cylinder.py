"""The flat-cylinder damper: a flat side under the blade's inclined platform, a cylindrical side on the other neighbour.

The damper of "An Experimental and Computational Comparison of the Dynamic Response Variability in a Turbine Blade with
Under-Platform Dampers". The flat touches at its four corners and its middle, the cylinder line at three points. The paper
gives no dimensions: the default ones are this project's, calibrated with its rig (see `stickslip.rigs.single_blade`).
"""

from __future__ import annotations

from dataclasses import dataclass
from itertools import product
from math import cos, radians, sin

import numpy as np
from numpy.typing import ArrayLike

from stickslip.checks import Array, fault, not_negative, positive, vector
from stickslip.dampers.damper import ContactSurface, Damper
from stickslip.structure.rigid_body import RigidBody, box_inertia

_CORNERS = ((-0.5, -0.5), (-0.5, 0.5), (0.5, -0.5), (0.5, 0.5))
FLAT_POINTS: dict[int, tuple[tuple[float, float], ...]] = {
    4: _CORNERS,
    5: (*_CORNERS, (0.0, 0.0)),
    9: tuple(product((-0.5, 0.0, 0.5), (-0.5, 0.0, 0.5))),
    15: tuple(product((-0.5, 0.0, 0.5), (-0.5, -0.25, 0.0, 0.25, 0.5))),
}
"""Points of the flat by their number: shares of its width along the slope and of its depth along z."""


@dataclass(frozen=True)
class FlatCylinder:
    """Dimensions of a flat-cylinder damper.

    platform_angle: slope of both contact planes against x [degrees]; flat_width: length of the flat along the slope [m];
    depth: length along z [m]; centre_offset, cylinder_offset: from the middle of the flat to the mass centre and to the
    cylinder line, along x away from the blade [m]; mass [kg]; sides: of the box (x, y, z) whose inertia it has [m];
    flat_points: 4 (corners), 5 (corners and middle), 9 or 15 (three lines along the slope with three or five points along z).
    """

    platform_angle: float = 45.0
    flat_width: float = 11.313708498984761e-3
    depth: float = 40e-3
    centre_offset: float = 8e-3
    cylinder_offset: float = 16e-3
    mass: float = 50e-3
    sides: tuple[float, float, float] = (16e-3, 10e-3, 40e-3)
    flat_points: int = 5

    def __post_init__(self) -> None:
        for key in ("flat_width", "depth", "cylinder_offset", "mass"):
            positive(key, getattr(self, key))
        not_negative("centre_offset", self.centre_offset)
        if not 0.0 <= self.platform_angle < 90.0:
            raise fault("platform_angle", "must lie in [0, 90) degrees", self.platform_angle)
        if self.flat_points not in FLAT_POINTS:
            raise fault("flat_points", f"must be one of {', '.join(map(str, FLAT_POINTS))}", self.flat_points)

    def normal_load(self, pull: float) -> float:
        """Static normal load of each side in the symmetric case, F_C/(2 cos α), N."""
        return pull / (2.0 * cos(radians(self.platform_angle)))

    def damper(self, name: str, pad_centre: ArrayLike, side: int, pull: float, label: str = "") -> Damper:
        """The damper at the blade's right (side = +1: blade at smaller x) or left (−1), pulled up (y) by `pull` [N].

        pad_centre: (3,) [m], the middle of the flat on the platform.
        """
        if side not in (-1, 1):
            raise fault("side", "must be 1 (right) or -1 (left)", side)
        middle = vector("pad_centre", pad_centre, 3)
        away = np.array([float(side), 0.0, 0.0])
        body = RigidBody(self.mass, box_inertia(self.mass, self.sides), middle + self.centre_offset * away)
        return Damper(name, body, (self._flat(middle, side), self._cylinder(middle, side)), (0.0, pull, 0.0), label)

    def _flat(self, middle: Array, side: int) -> ContactSurface:
        """Points of equal weight, inner ones first; n from the platform into the damper."""
        frame, count = self._frame(side, 1.0), self.flat_points
        half = np.array(FLAT_POINTS[count]) * [self.flat_width, self.depth]
        return ContactSurface("flat", middle + half @ frame[:2], frame, np.full(count, 1.0 / count))

    def _cylinder(self, middle: Array, side: int) -> ContactSurface:
        """Three points at −1/3, 0, 1/3 of the depth; n from the separator into the damper."""
        line = middle + np.array([side * self.cylinder_offset, 0.0, 0.0])
        along = np.array([0.0, 0.0, self.depth / 3.0])
        return ContactSurface(
            "cylinder", line + np.outer([-1.0, 0.0, 1.0], along), self._frame(side, -1.0), np.full(3, 1.0 / 3.0)
        )

    def _frame(self, side: int, sense: float) -> Array:
        """Rows t1, t2, n of a plane rising away from the blade (sense = 1) or falling (−1)."""
        c, s = cos(radians(self.platform_angle)), sin(radians(self.platform_angle))
        return np.array([[side * c, sense * s, 0.0], [0.0, 0.0, 1.0], [sense * side * s, -c, 0.0]])
