"""A damper: a rigid body, the surfaces with which it touches its neighbours, and its centrifugal pull.

A shape (one file each) makes a `Damper` from a few dimensions; a rig places it and gives each surface a law and the places
that lie opposite. Normals point from the neighbour into the damper: contact point A is the neighbour, B the damper.

Interface of damper shapes: dimensions that give a rigid body and its contact lines on either side.

The platforms form a roof above the damper: the left one rises to the right at `left_angle`, the right one falls at
`right_angle`. Everything is stated in the plane x (right), y (out, along the pull), from the mass centre; z is the depth.
A contact's frame is t1 down the left platform or up the right one, t2 = −z, n from the platform into the damper, so that
u = t1·(u_platform − u_damper) is how far the damper has moved towards the ridge at the left, away from it at the right.

Plane sections of straight lines and arcs: area, centroid and second moments; mass and inertia of a prism.

Green's theorem turns each integral over the section into one along its boundary, run counter-clockwise: A = ½ ∮ (x dy − y dx),
∫x = ½ ∮ x² dy, ∫y = −½ ∮ y² dx, ∫x² = ⅓ ∮ x³ dy, ∫y² = −⅓ ∮ y³ dx, ∫xy = ½ ∮ x² y dy. Gauss points along each piece are
exact for lines and exact to rounding for arcs.
"""

import re
from abc import ABC, abstractmethod
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace
from math import atan2, ceil, cos, pi, radians, sin

import numpy as np
import scipy
from numpy.typing import ArrayLike

from stickslip.model.contact.law import Law
from stickslip.model.contact.point import Contact, Motion, OnSurface, Start, contact_in_space
from stickslip.model.loads import Force
from stickslip.model.structure.assembly import RigidBody
from stickslip.model.structure.matrices import Structure
from stickslip.support.checks import Array, InputError, fault, finite, nearest, not_negative, positive, square, vector

LawOfShare = Callable[[float], Law]
"""The law of a contact point that carries this share of its surface's stiffness: `lambda share: Macroslip(share * kt, ...)`."""


@dataclass(frozen=True, eq=False)
class ContactSurface:
    """A line or area contact as a set of points.

    points: (k, 3) [m], on the undeformed damper; frame: (3, 3), rows t1, t2, n, n into the damper;
    weights: (k,), the share of each point in the stiffness of the whole surface, sum 1; radius of the damper's rounding where
    it touches [m], on which it rolls; 0 where it cannot roll.
    """

    name: str
    points: ArrayLike
    frame: ArrayLike
    weights: ArrayLike
    radius: float = 0.0

    def __post_init__(self) -> None:
        points = np.asarray(self.points, dtype=float)
        if points.ndim != 2 or points.shape[1] != 3 or not points.size or not np.all(np.isfinite(points)):
            raise fault(f"Points of surface {self.name!r}", "must be finite, of shape (points, 3)", points.tolist())
        weights = vector(f"Weights of surface {self.name!r}", self.weights, points.shape[0])
        if np.any(weights <= 0.0) or abs(weights.sum() - 1.0) > 1e-9:
            raise fault(f"Weights of surface {self.name!r}", "must be positive with sum 1", weights.tolist())
        frame = square(f"Frame of surface {self.name!r}", self.frame, 3)
        not_negative(f"Radius of surface {self.name!r}", self.radius)
        for key, value in (("points", points), ("weights", weights), ("frame", frame)):
            object.__setattr__(self, key, value)


@dataclass(frozen=True, eq=False)
class Damper:
    """A rigid damper, named as its body is in the assembly.

    body: rigid body; surfaces: where it touches; pull: centrifugal force vector (3,) [N] at its mass centre.
    label: a readable name, in front of the names of its contacts (the name itself unless given).
    """

    name: str
    body: RigidBody
    surfaces: tuple[ContactSurface, ...]
    pull: ArrayLike = (0.0, 0.0, 0.0)
    label: str = ""

    def __post_init__(self) -> None:
        object.__setattr__(self, "surfaces", tuple(self.surfaces))
        object.__setattr__(self, "pull", vector("pull", self.pull, 3))
        names = [surface.name for surface in self.surfaces]
        if not names or len(set(names)) < len(names):
            raise fault(f"Surfaces of damper {self.name!r}", "must be at least one, with different names", names)

    @property
    def structure(self) -> Structure:
        """The free body, to be assembled under the damper's name."""
        return self.body.structure()

    def surface(self, name: str) -> ContactSurface:
        """The contact surface of this name."""
        for surface in self.surfaces:
            if surface.name == name:
                return surface
        known = nearest(name, [surface.name for surface in self.surfaces])
        raise InputError(f"Damper {self.name!r} has no contact surface {name!r}. {known}")

    def at(self, point: ArrayLike) -> Motion:
        """The motion of a point of the damper [m], in the names of the assembly."""
        return self.body.at(point, self.name)

    def contacts(
        self, surface: str, law: LawOfShare, neighbour: Motion | Sequence[Motion], start: Start | None = None
    ) -> tuple[Contact, ...]:
        """Contacts of a surface, named "LABEL SURFACE 1", ...: w = frame (u_neighbour − u_damper).

        neighbour: the place opposite each point, or one rigid place (such as `ground`) for all.
        """
        place = self.surface(surface)
        points = np.asarray(place.points)
        opposite = [neighbour] * len(points) if callable(neighbour) else list(neighbour)
        if len(opposite) != len(points):
            raise fault(f"Places opposite surface {surface!r}", f"must be one, or {len(points)}, one per point", len(opposite))
        title = f"{self.label or self.name} {surface}"
        shares = np.asarray(place.weights).tolist()
        contacts = (
            contact_in_space(f"{title} {i + 1}", law(share), there, self.at(point), place.frame, start)
            for i, (share, there, point) in enumerate(zip(shares, opposite, points, strict=True))
        )
        return tuple(replace(contact, surface=OnSurface(title, share)) for contact, share in zip(contacts, shares, strict=True))

    def forces(self) -> tuple[Force, ...]:
        """The centrifugal pull as static forces at the mass centre."""
        pull = np.asarray(self.pull)
        node = f"{self.name}/{self.body.node}"
        return tuple(
            Force(f"{node}.{axis}", static=finite("pull", f), name=f"{self.label or self.name} centrifugal pull")
            for axis, f in zip("xyz", pull, strict=True)
            if f != 0.0
        )


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
    def bounded_by(cls, boundary: Sequence[Line | Arc]) -> "Section":
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


MIRROR = np.diag([-1.0, 1.0, 1.0])


@dataclass(frozen=True, eq=False)
class Touch:
    """How one side of a damper touches: slope of the platform [degrees], points (k, 3) from the mass centre [m], radius of the
    rounding at the points [m], 0 at a flat."""

    angle: float
    points: ArrayLike
    radius: float = 0.0

    @classmethod
    def on_lines(cls, angle: float, places: ArrayLike, depth: float, radius: float = 0.0) -> "Touch":
        """On lines along z through places (k, 2) in the plane, the first lowest: three points each, the middles of its thirds."""
        return cls(angle, [(x, y, z) for x, y in np.asarray(places) for z in (-depth / 3.0, 0.0, depth / 3.0)], radius)


def key_of(shape: "type[Shape]") -> str:
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
        surfaces = []
        for name_of_side, at, touch in (("left", -1, self.left()), ("right", 1, self.right())):
            count = len(np.asarray(touch.points))
            weights = np.full(count, 1.0 / count)
            surfaces.append(ContactSurface(name_of_side, touch.points, frame(touch.angle, at), weights, touch.radius))
        if side == -1:
            surfaces = [_mirrored(surface) for surface in surfaces]
        moved = [ContactSurface(s.name, place + np.asarray(s.points), s.frame, s.weights, s.radius) for s in surfaces]
        return Damper(name, placed, tuple(moved), (0.0, pull, 0.0), label)


def frame(angle: float, side: int) -> Array:
    """Rows t1, t2, n at the left (side −1) or right (+1) platform, n into the damper."""
    c, s = cos(radians(angle)), side * sin(radians(angle))
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
