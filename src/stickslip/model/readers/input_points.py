"""Where the nodes of an input deck lie: in axes of *SYSTEM, in cylindrical coordinates, on lines and arcs, in instances."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import NamedTuple

import numpy as np

from stickslip.model.readers.deck import radial
from stickslip.model.structure.matrices import Point
from stickslip.support.checks import Array, fault


class Frame(NamedTuple):
    """Origin and axes (columns) of the coordinates of nodes, in those of the part."""

    origin: Array
    axes: Array

    def place(self, point: Point) -> Point:
        """A point of the frame in the axes of the part; in these themselves it keeps its digits."""
        return point if self is GLOBAL else _point(self.origin + self.axes @ np.array(point))


GLOBAL = Frame(np.zeros(3), np.eye(3))


def frame(numbers: Sequence[float]) -> Frame:
    """The frame of *SYSTEM: origin a, point b on the first axis, point c of the plane of the first and the second axis.

    a alone moves the origin; without c the third axis stays and the first is that of b in the (x, y) plane; nothing at all means
    the axes of the part.
    """
    if len(numbers) not in (0, 3, 6, 9):
        raise fault("*SYSTEM", "must hold one, two or three points", list(numbers))
    if not numbers:
        return GLOBAL
    origin, *points = np.array(numbers).reshape(-1, 3)
    if not points:
        return Frame(origin, np.eye(3))
    first, plane = points[0] - origin, points[-1] - origin
    if len(points) == 1:
        first, plane = first * [1.0, 1.0, 0.0], np.array([-first[1], first[0], 0.0])
    across = np.cross(first, plane)
    if not np.linalg.norm(across) > 1e-12 * np.linalg.norm(first) * np.linalg.norm(plane):
        raise fault("The points of *SYSTEM", "must not lie on one line", list(numbers))
    e1, e3 = first / np.linalg.norm(first), across / np.linalg.norm(across)
    return Frame(origin, np.column_stack([e1, np.cross(e3, e1), e3]))


def turning_points(numbers: Sequence[float]) -> tuple[Point, Point]:
    """The points a and b of *TRANSFORM; numbers left out at the end are zero."""
    if not 1 <= len(numbers) <= 6:
        raise fault("*TRANSFORM", "must hold two points", list(numbers))
    whole = np.array([*numbers, *6 * [0.0]][:6])
    return _point(whole[:3]), _point(whole[3:])


class Turning(NamedTuple):
    """*TRANSFORM of a set of nodes. R: a on the first axis, b on the plane of the first and the second, seen from the origin; C:
    r, θ, z about the axis from a to b. Of S, the manual leaves the sign of two axes open."""

    nset: str
    kind: str
    a: Point
    b: Point
    origin: Point = (0.0, 0.0, 0.0)

    def moved(self, motion: Callable[[Point], Point]) -> Turning:
        """With the instance that it stands in."""
        return self._replace(a=motion(self.a), b=motion(self.b), origin=motion(self.origin))

    def axes_at(self, node: Point) -> Array | None:
        """The axes (columns) of the rows of a node, None where the deck does not give them."""
        a, b, origin = np.array(self.a), np.array(self.b), np.array(self.origin)
        if self.kind == "R":
            return frame([*origin, *a, *b]).axes
        length = np.linalg.norm(b - a)
        if self.kind != "C" or not length:
            return None
        z = (b - a) / length
        return radial(np.array(node), a, np.column_stack([z, z, z]))


def cartesian(system: str, point: Point) -> Point:
    """Coordinates of *NODE, SYSTEM=R (x, y, z) or C (r, θ in degrees, z) as x, y, z."""
    if system == "R":
        return point
    if system != "C":
        raise fault("SYSTEM of *NODE", "must be R or C", system, "Write Cartesian coordinates.")
    r, angle, z = point
    return _point(np.array([r * np.cos(np.radians(angle)), r * np.sin(np.radians(angle)), z]))


def between(first: Point, last: Point, intervals: int) -> list[Point]:
    """Points at equal distances from the first to the last, both included."""
    share = np.arange(intervals + 1)[:, None] / intervals
    return [_point(row) for row in (1.0 - share) * np.array(first) + share * np.array(last)]


def on_line(kind: str, first: Point, last: Point, extra: Point | None, normal: tuple[float, ...], intervals: int) -> list[Point]:
    """Points at equal distances of *NGEN: on a straight line, or with LINE=C on an arc about `extra`, less than half a turn
    unless its normal is given."""
    if not kind or extra is None:
        return between(first, last, intervals)
    if kind != "C":
        raise fault("LINE of *NGEN", "must be C, or left out", kind, "Write the nodes out.")
    centre = np.array(extra)
    a, b = np.array(first) - centre, np.array(last) - centre
    axis = np.array(normal) if any(normal) else np.cross(a, b)
    radius, length = np.linalg.norm(a), np.linalg.norm(axis)
    if abs(radius - np.linalg.norm(b)) > 1e-3 * radius or (not any(normal) and not length > 1e-9 * radius**2):
        raise fault("The ends of an arc of *NGEN", "must be equally far from its centre, not opposite", [first, last, extra])
    axis = axis / length
    angle = np.arctan2(np.cross(a, b) @ axis, a @ b) % (2.0 * np.pi)
    return [_point(centre + _rotation(axis, angle * k / intervals) @ a) for k in range(intervals + 1)]


def turned_about(shift: Array, turn: Sequence[float]) -> Callable[[Point], Point]:
    """The motion of an instance: `shift` (3,), then `turn`: a point, another that makes an axis with it, degrees about that."""
    if not turn:
        return (lambda point: _point(np.array(point) + shift)) if np.any(shift) else (lambda point: point)
    start, end, angle = np.array(turn[:3]), np.array(turn[3:6]), np.radians(turn[6])
    if not np.linalg.norm(end - start):
        raise fault("The axis of an instance", "must be given by two points", turn)
    rotation = _rotation((end - start) / np.linalg.norm(end - start), angle)
    return lambda point: _point(start + rotation @ (np.array(point) + shift - start))


def _rotation(axis: Array, angle: float) -> Array:
    """The rotation about a unit vector (Rodrigues)."""
    x, y, z = axis
    cross = np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])
    return np.asarray(np.eye(3) + np.sin(angle) * cross + (1.0 - np.cos(angle)) * cross @ cross)


def _point(values: Array) -> Point:
    x, y, z = map(float, values)
    return x, y, z
