"""Plane sections of straight lines and arcs: area, centroid and second moments; mass and inertia of a prism.

Green's theorem turns each integral over the section into one along its boundary, run counter-clockwise: A = ½ ∮ (x dy − y dx),
∫x = ½ ∮ x² dy, ∫y = −½ ∮ y² dx, ∫x² = ⅓ ∮ x³ dy, ∫y² = −⅓ ∮ y³ dx, ∫xy = ½ ∮ x² y dy. Gauss points along each piece are
exact for lines and exact to rounding for arcs.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from math import atan2, ceil, pi

import numpy as np
import scipy
from numpy.typing import ArrayLike

from stickslip.model.structure.rigid_body import RigidBody
from stickslip.support.checks import Array, InputError, fault, positive

GAUSS_POINTS = 40
"""On each piece of a boundary."""

DRAWN_ANGLE = pi / 24.0
"""Angle between the points by which an arc is drawn, at most [rad]: the polygon lies 0.2 % of the radius inside."""


@dataclass(frozen=True, eq=False)
class Line:
    """A straight piece of a boundary, from `start` to `end`, (2,) [m]."""

    start: ArrayLike
    end: ArrayLike

    def sampled(self, s: Array) -> tuple[Array, Array]:
        """Points (k, 2) and derivatives (k, 2) by s in [0, 1]."""
        start, change = np.asarray(self.start, float), np.subtract(self.end, self.start)
        return start + s[:, None] * change, np.broadcast_to(change, (s.size, 2))


@dataclass(frozen=True, eq=False)
class Arc:
    """An arc about `centre` (2,) [m], counter-clockwise from angle `first` to angle `last` [rad]."""

    centre: ArrayLike
    radius: float
    first: float
    last: float

    def sampled(self, s: Array) -> tuple[Array, Array]:
        """Points (k, 2) and derivatives (k, 2) by s in [0, 1]."""
        span = self.last - self.first
        angle = self.first + s * span
        direction = np.stack([np.cos(angle), np.sin(angle)], axis=1)
        across = np.stack([-direction[:, 1], direction[:, 0]], axis=1)
        return np.asarray(self.centre, float) + self.radius * direction, self.radius * span * across


@dataclass(frozen=True)
class Section:
    """Area [m²], centroid (x, y) [m] and second moments about it: xx = ∫x², yy = ∫y², xy = ∫xy [m⁴]; outline: points of the
    boundary (k, 2) [m], for drawings."""

    area: float
    centroid: tuple[float, float]
    xx: float
    yy: float
    xy: float
    outline: Array = field(default_factory=lambda: np.zeros((0, 2)), compare=False)

    @classmethod
    def bounded_by(cls, boundary: Sequence[Line | Arc]) -> Section:
        """The section inside a boundary, given piece by piece counter-clockwise."""
        nodes, weights = np.polynomial.legendre.leggauss(GAUSS_POINTS)
        total = np.zeros(6)
        for piece in boundary:
            (x, y), (dx, dy) = (part.T for part in piece.sampled(0.5 * (nodes + 1.0)))
            integrands = [x * dy - y * dx, x * x * dy, -y * y * dx, x**3 * dy * 2 / 3, -(y**3) * dx * 2 / 3, x * x * y * dy]
            total += 0.5 * (0.5 * weights) @ np.stack(integrands, axis=1)
        area, first_x, first_y, xx, yy, xy = (float(value) for value in total)
        if area <= 0.0:
            raise InputError("The boundary of a section must run counter-clockwise round a positive area. Check the dimensions.")
        x, y = first_x / area, first_y / area
        drawn = np.concatenate([_drawn(piece) for piece in boundary if not isinstance(piece, Arc) or piece.radius])
        return cls(area, (x, y), xx - area * x * x, yy - area * y * y, xy - area * x * y, drawn)

    def prism(self, depth: float, density: float, centre: ArrayLike) -> RigidBody:
        """A prism of this section along z, `depth` m long, of `density` kg/m³, with its mass centre at `centre` (3,) [m]."""
        line = positive("density", density) * positive("depth", depth)
        along = self.area * depth**2 / 12.0
        inertia = line * np.array(
            [[self.yy + along, -self.xy, 0.0], [-self.xy, self.xx + along, 0.0], [0.0, 0.0, self.xx + self.yy]]
        )
        corners = np.pad(self.outline - self.centroid, ((0, 0), (0, 1)))
        return RigidBody(line * self.area, inertia, centre, outline=corners)


def polygon(corners: ArrayLike) -> tuple[Line, ...]:
    """The boundary of a polygon from its corners (k, 2), counter-clockwise."""
    points = np.asarray(corners, dtype=float)
    return tuple(Line(a, b) for a, b in zip(points, np.roll(points, -1, axis=0), strict=True))


def rounded_hull(circles: Sequence[tuple[ArrayLike, float]]) -> tuple[Line | Arc, ...]:
    """The band drawn round circles (centre, radius) given counter-clockwise, each of which it must touch; radius 0: a corner."""
    angles = [_outer_tangent(*circles[i - 1], *circles[i]) for i in range(len(circles))]
    pieces: list[Line | Arc] = []
    for i, (centre, radius) in enumerate(circles):
        first = angles[i]
        last = first + (angles[(i + 1) % len(circles)] - first) % (2.0 * pi)
        arc = Arc(centre, radius, first, last)
        if pieces:
            pieces.append(Line(_end(pieces[-1]), arc.sampled(np.zeros(1))[0][0]))
        pieces.append(arc)
    pieces.append(Line(_end(pieces[-1]), pieces[0].sampled(np.zeros(1))[0][0]))
    return tuple(pieces)


def hull_of(circles: Sequence[tuple[ArrayLike, float]]) -> Array:
    """The band round circles (centre, radius) as a polygon (k, 2), counter-clockwise; some may lie inside; radius 0: a point."""
    points = [_drawn(Arc(centre, radius, 0.0, 2.0 * pi)) for centre, radius in circles]
    cloud = np.concatenate(points)
    try:
        return np.asarray(cloud[scipy.spatial.ConvexHull(cloud).vertices])
    except scipy.spatial.QhullError:
        width, height = np.ptp(cloud, axis=0)
        size = f"{width:.3g} m by {height:.3g} m"
        raise fault("The section of a damper", "must have a width and a height", size) from None


def _drawn(piece: Line | Arc) -> Array:
    """Points of a piece but its last one, which the next piece begins with."""
    count = max(1, ceil(abs(piece.last - piece.first) / DRAWN_ANGLE)) if isinstance(piece, Arc) and piece.radius else 1
    return piece.sampled(np.arange(count) / count)[0]


def _end(piece: Line | Arc) -> Array:
    """The last point of a piece, (2,)."""
    return np.asarray(piece.sampled(np.ones(1))[0][0])


def _outer_tangent(a: ArrayLike, radius_a: float, b: ArrayLike, radius_b: float) -> float:
    """Angle of the normal, outwards, of the tangent that has both circles on its left on the way from a to b."""
    x, y = np.subtract(b, a)
    sine = (radius_a - radius_b) / float(np.hypot(x, y))
    if not -1.0 < sine < 1.0:
        raise InputError("Circles of a damper's outline must not lie inside each other. Check its radii and distances.")
    return atan2(y, x) - pi / 2.0 + float(np.arcsin(sine))
