"""Contacts at the nodes of a mesh surface, against a rigid body, another surface or the ground.

The surface is the nodes of a set with their areas and normals, from the coordinates alone.

The nodes are projected onto the plane that fits them best. There each has its Voronoi cell within their convex hull, and the
Delaunay triangles between them carry normals and interpolation. Triangles far larger than those around their corners span
holes or recesses, which are cut out. That suits surfaces that are flat or gently curved, whatever elements lie beneath.

A line of nodes, straight, bent or closed, has no area: they share its length. It is refused unless it is declared.

Patches of a contact surface: points with areas divided into parts of about equal area, compact in space.

Recursive inertial bisection: the points are halved across the direction in which they spread furthest, then each half, and so on.
Each cut is straight and placed by area, so that the areas of patches differ by what a node of the mesh carries and patches are
about as wide as long. Clusters around centres (k-means) are rounder, but their areas differ by a factor of two and they depend on
where the centres begin. Points lie in the plane that fits the surface best and count with their areas in space, so that gently
curved surfaces are divided as flat ones. Source: H. D. Simon, Comput. Syst. Eng. 2 (1991) 135-148.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

import numpy as np
import scipy
from numpy.typing import ArrayLike, NDArray
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components, depth_first_order, minimum_spanning_tree
from scipy.spatial.distance import pdist, squareform

from stickslip.model.contact.law import Law
from stickslip.model.contact.point import Contact, Motion, OnSurface, PatchNode, Start, contact_in_space, ground, mean, node
from stickslip.model.structure.cyclic import NEXT, CyclicStructure
from stickslip.model.structure.matrices import Structure
from stickslip.support.checks import Array, Index, InputError, between, fault, nearest, of_kind, vector

ALIKE = 1e-6
"""Difference relative to the size up to which places, or shares of an area, are equal, so that rounding chooses nothing."""

SQUARE = 1.1
"""Ratio of the mean squares of two spreads up to which no direction is the longest: the first axis of the surface is taken."""


def bisected(places: Array, areas: Array, count: int) -> list[Index]:
    """Indices of points, part by part; places (n, 2), areas (n,), 1 <= count <= n. Every part has at least one point."""
    size = float(np.ptp(places, axis=0).max(initial=0.0)) or 1.0
    return _parts(places / (ALIKE * size), areas, np.arange(len(places)), count)


def _parts(places: Array, areas: Array, points: Index, count: int) -> list[Index]:
    """The parts of some of the points, halved again and again."""
    if count == 1:
        return [np.sort(points)]
    own = areas[points]
    away = places[points] - np.average(places[points], axis=0, weights=own)
    squares, axes = np.linalg.eigh((own[:, None] * away).T @ away)
    longest = axes[:, 1] if squares[1] > SQUARE * squares[0] else np.array([1.0, 0.0])
    longest = longest * np.sign(longest[np.argmax(np.abs(longest))])
    along, across = np.round(away @ longest), np.round(away @ [-longest[1], longest[0]])
    ordered = points[np.lexsort((across, along))]
    first = count // 2
    shares = np.cumsum(areas[ordered])[first - 1 : len(points) - (count - first)] / own.sum()
    cut = first + int(np.argmin(np.round(np.abs(shares - first / count) / ALIKE)))
    return [*_parts(places, areas, ordered[:cut], first), *_parts(places, areas, ordered[cut:], count - first)]


FLAT = 1e-9
"""Extent relative to the largest below which points lie on one line, or in one place."""

TILT = 1e-3
"""Component of an axis from which its sign counts: coordinates are printed with few digits."""

STEEPEST = 0.2
"""Cosine between a normal and that of the best plane below which a surface is too curved to be projected onto it."""

OUTSIDE = 0.01
"""How far beyond the edge of a surface, relative to its size, a point still lies opposite it: edges that do not quite meet."""

TOUCHING = 1e-3
"""Distance, relative to the size of a surface, up to which a point does not say on which side of it it lies."""

LEVEL = 0.1
"""Cosine up to which a direction lies in a surface."""

LARGER = 3.0
"""Ratio of the longest edge of a triangle to those around its corners from where on it spans a hole or a recess."""

BESIDE = 1.5
"""Ratio of the diameter of the circle through its corners to the same, from where on a triangle beside a hole belongs to it."""

SEVERAL = 4.0
"""Area of a hole over that of the usual triangle beside it, up to which it is none: nodes are scattered unevenly."""

CLOSING = 1.25
"""Distance of the ends of a line over its longest step up to which it is closed, unless a node lies in the sphere on it."""

GIVE = "Give it as `towards`, in a study as `facing`."

SMALLEST_RING = 5
"""Nodes of a closed line; three or four are the corners of a face."""

SLIVER = 1e-3
"""Height of a triangle over its longest side below which its corners lie on one line."""

PAIRS = ((1, 2), (2, 0), (0, 1))
"""The corners of the side opposite each corner."""

ROUNDING = 1e-9
"""Share of a corner that counts as none."""


@dataclass(frozen=True, eq=False)
class NodeSurface:
    """The nodes of a contact surface: names; points (n, 3) [m]; normals (n, 3), unit, out of the body to which the nodes belong;
    weights (n,), the share of each node in the surface, sum 1; area [m²], 0 of a line. turn (3, 3): of the axes of the nodes,
    None where these are those of the points.
    """

    name: str
    nodes: tuple[str, ...]
    points: Array
    normals: Array
    weights: Array
    area: float
    turn: Array | None = None

    @classmethod
    def of(
        cls,
        structure: Structure,
        name: str,
        towards: Sequence[float] | None = None,
        opposite: ArrayLike | None = None,
        line: bool | None = None,
    ) -> NodeSurface:
        """The surface of a set of nodes of a structure; `name` as in `Structure.sets`.

        towards: a direction (x, y, z) to the outside, which says on which side of the nodes the body does not lie; or opposite: a
        point [m] on the outside, such as the mass centre of what it touches.

        line: whether the nodes are a line, straight, bent or closed, and no surface. The share of a node is half the way to the
        nodes beside it over its length, its normal the direction to the outside as far as that lies across the
        circle through these three nodes. None: what the coordinates say; nodes that form a line are refused. A single node needs
        no word.

        Nodes form a line where their Gabriel graph closes no cell, or a single one round all of them: two nodes are joined
        where no third lies in the sphere on their distance as a diameter. On a surface each element is a cell. Source: Gabriel
        and Sokal, Syst. Zool. 18 (1969) 259-278.
        """
        nodes = nodes_of(structure, name)
        points = np.array([structure.nodes[each] for each in nodes])
        return cls._of_points(name, nodes, points, towards, opposite, line)

    @classmethod
    def _of_points(
        cls,
        name: str,
        nodes: tuple[str, ...],
        points: Array,
        towards: Sequence[float] | None,
        opposite: ArrayLike | None,
        line: bool | None,
    ) -> NodeSurface:
        plane = _Plane.of(points)
        out = None if towards is None else vector("towards", towards, 3)
        if out is not None and out.any():
            out = out / np.abs(out).max()  # squares of tiny entries would vanish
        if len(nodes) == 1 or line:
            beyond = None if opposite is None else vector("opposite", opposite, 3) - points
            return cls._on_a_line(name, nodes, points, beyond if out is None else np.tile(out, (len(nodes), 1)))
        if plane.rank < 2 or (line is None and plane.is_line):
            raise line_as_surface(name, len(nodes))
        if out is None and opposite is not None:
            out = vector("opposite", opposite, 3) - points.mean(axis=0)
            if abs(plane.axes[2] @ out) < TOUCHING * np.ptp(points, axis=0).max():
                raise InputError(
                    f"The direction out of surface {name!r} must be given, since what lies opposite touches it. {GIVE}"
                )
        once = np.unique(plane.triangles).size == len(plane.flat)  # no two points lie in one place of the plane
        normals = plane.normals(points) if once else np.zeros_like(points)
        steepness = normals @ plane.axes[2]
        if steepness.min() < STEEPEST:
            rule, remedy = "must be flat or gently curved", "Divide it into several sets."
            raise fault(f"Surface {name!r}", rule, "too steep for one plane", remedy)
        areas = plane.cells() / steepness
        sign = 1.0
        if out is not None:
            across = float(plane.axes[2] @ out)
            if abs(across) <= LEVEL * np.linalg.norm(out):
                raise _no_way_out(name, out)
            sign = float(np.sign(across))
        return cls(name, nodes, points, sign * normals, areas / areas.sum(), float(areas.sum()))

    @classmethod
    def _on_a_line(cls, name: str, nodes: tuple[str, ...], points: Array, out: Array | None) -> NodeSurface:
        """The nodes of a line, or a single one, with the directions out of each, (n, 3)."""
        if out is None:
            raise InputError(f"Surface {name!r}, a line or one node, has no normal of its own. {GIVE}")
        along = _Line.of(name, points)
        across = out - np.sum(out * along.tangents, axis=1)[:, None] * along.tangents
        sizes = np.linalg.norm(across, axis=1)
        if np.any(sizes <= TOUCHING * np.linalg.norm(out, axis=1)):
            raise _no_way_out(name, out[int(np.argmin(sizes))])
        return cls(name, nodes, points, across / sizes[:, None], along.shares, 0.0)

    def facing(self, point: Sequence[float]) -> NodeSurface:
        """The same with normals to the side on which a point [m] lies, such as the mass centre of a body opposite."""
        return replace(self._of_points(self.name, self.nodes, self.points, None, point, not self.area), turn=self.turn)

    def following(self, disk: CyclicStructure) -> NodeSurface:
        """Return the same surface of the following sector of a disk, rotated by 2π/N about the axis of the disk.

        Its nodes are named "next/NODE", as in contacts of a `TunedDisk`, and move in axes that are rotated with the sector.
        """
        of_kind("disk", disk, CyclicStructure)
        turn = disk.axis.turn(disk.sectors)
        nodes = tuple(f"{NEXT}{name}" for name in self.nodes)
        points, normals = disk.axis.turned(self.points, disk.sectors), self.normals @ turn.T
        return NodeSurface(self.name, nodes, points, normals, self.weights, self.area, turn)

    def motion(self, number: int) -> Motion:
        """The motion of a node of the surface, by its number, along directions in the axes of the points."""
        own = node(self.nodes[number])
        if self.turn is None:
            return own
        back = self.turn.T
        return lambda direction: own(back @ np.asarray(direction))

    @property
    def kind(self) -> str:
        """What it is where it has no area: "a node", "a line" or "a closed line"; else "a surface"."""
        steps = 0 if self.area else _Line.of(self.name, self.points).steps.size
        return "a surface" if self.area else ("a node", "a line", "a closed line")[(steps > 0) + (steps == len(self.nodes))]

    @property
    def size(self) -> float:
        """The largest extent of the surface along an axis [m]."""
        return float(np.ptp(self.points, axis=0).max())

    @property
    def has_holes(self) -> bool:
        """Whether the nodes leave out part of their convex hull, which does not count: holes, recesses, the space between parts.

        They are known by triangles between nodes three times as large as others at their corners. From each corner of a hole the
        half of one cell of the mesh still counts.
        """
        return bool(self.area) and bool(self._plane.spanning.any())

    def at(self, point: Sequence[float]) -> Motion | None:
        """The motion of the surface opposite a point [m], by interpolation between three nodes; None beyond its edge."""
        shares = self._shares(point)
        if shares is None:
            return None
        return mean([self.motion(corner) for corner in shares], list(shares.values()))

    def gap(self, point: Sequence[float], normal: Sequence[float]) -> float:
        """How far the surface stands off a point along a direction [m]; negative where it has passed it, NaN beyond its edge."""
        shares = self._shares(point)
        if shares is None:
            return float("nan")
        away = sum(share * self.points[corner] for corner, share in shares.items()) - vector("point", point, 3)
        return float(vector("normal", normal, 3) @ away)

    def _shares(self, point: Sequence[float]) -> dict[int, float] | None:
        """The nodes around a place opposite a point with their shares; None beyond the edge."""
        if not self.area:
            raise InputError(f"Surface {self.name!r} must have nodes that do not lie on a line, to have places between them.")
        return self._plane.shares(vector("point", point, 3))

    def patches(self, count: int, among: Index | None = None) -> list[Index]:
        """The nodes, or those `among` them, in so many patches of about equal area, compact in space: their numbers, patch by
        patch."""
        chosen = np.arange(len(self.nodes)) if among is None else among
        axes = self._plane.axes[:2]
        first = np.argmax(np.abs(axes) > TILT, axis=1)
        flat = self._plane.flat * np.sign(axes[[0, 1], first])  # a decomposition turns its axes as the order of the nodes has it
        if not self.area:
            flat = _Line.of(self.name, self.points).places
        return [chosen[part] for part in bisected(flat[chosen], self.weights[chosen], count)]

    @cached_property
    def _plane(self) -> _Plane:
        return _Plane.of(self.points)

    @cached_property
    def along(self) -> Array:
        """At each node the direction in which the surface is longest, or the tangent of a line, (n, 3)."""
        if self.area or len(self.nodes) == 1:
            return np.tile(self._plane.axes[0], (len(self.nodes), 1))
        return _Line.of(self.name, self.points).tangents

    @property
    def mean_normal(self) -> Array | None:
        """The mean of the normals by area, (3,), unit; None where they cancel, as round a closed line."""
        mean = self.weights @ self.normals
        size = float(np.linalg.norm(mean))
        return np.asarray(mean / size) if size > ALIKE else None


def mean_motion(structure: Structure, name: str, direction: Sequence[float], line: bool | None = None) -> dict[str, float]:
    """Coefficients of the mean displacement of a set of nodes along (x, y, z), each with its share w_k of the area, Σ w_k = 1.

    As the direction of a `Force` it spreads the force evenly over the surface; as that of an `Output` it reports the mean.
    Nodes on a straight line share its length, those on a bent one with `line`, as in `NodeSurface.of`. Contact surfaces have the
    same shares.
    """
    along, nodes = vector("direction", direction, 3), nodes_of(structure, name)
    if not along.any():
        raise fault("direction", "must not be zero", direction)
    points = np.array([structure.nodes[each] for each in nodes])
    if line or (line is None and _Plane.of(points).rank < 2):
        weights = _Line.of(name, points).shares
    else:
        weights = NodeSurface._of_points(name, nodes, points, None, None, line).weights
    return {
        dof: float(share * coefficient)
        for each, share in zip(nodes, weights, strict=True)
        for dof, coefficient in node(each)(along.tolist()).items()
        if coefficient
    }


def line_as_surface(name: str, count: int) -> InputError:
    """The error for a line of nodes that nobody declared one."""
    remedy = (
        "Add `line = true` if an edge touches, as `surface` and not as `against`: its nodes share its length. Else select all "
        "nodes of the faces that touch; `line = false` takes the nodes as a surface as they are."
    )
    return fault(f"Surface {name!r}", "must cover an area", f"a line of {count} nodes", remedy)


def _no_way_out(name: str, out: Array) -> InputError:
    return fault(f"The direction out of surface {name!r}", "must not be zero or lie in it", np.round(out, 6).tolist(), GIVE)


def nodes_of(structure: Structure, name: str) -> tuple[str, ...]:
    """The nodes of a set of a structure; each must have coordinates and three displacements."""
    if name not in structure.sets:
        known = nearest(name, structure.sets) if structure.sets else "The structure has none: keep the set, or read its names."
        raise InputError(f"Set of nodes {name!r} does not exist. {known}")
    nodes, dofs = tuple(dict.fromkeys(structure.sets[name])), set(structure.dofs)
    if not nodes:
        raise fault(f"Set of nodes {name!r}", "must have nodes that can move", "empty, or all of them are fixed")
    for each in nodes:
        if each not in structure.nodes:
            remedy = "Give them with the model, or in a file of names."
            raise fault(f"Nodes of the surface {name!r}", "must have coordinates", f"{each} without", remedy)
        missing = [axis for axis in "xyz" if f"{each}.{axis}" not in dofs]
        if missing:
            raise fault(f"Nodes of the surface {name!r}", "must have displacements x, y, z", f"{each} without {missing[0]}")
    places = {structure.nodes[each]: each for each in reversed(nodes)}
    twice = [each for each in nodes if places[structure.nodes[each]] != each]
    if twice:
        raise fault(f"Nodes of the surface {name!r}", "must have different places", f"{twice[0]} where another one is")
    return nodes


@dataclass(frozen=True, eq=False)
class _Plane:
    """The plane that fits points best: centre (3,), axes (3, 3) with the normal last, points in it (n, 2); rank 0 for one place,
    1 for a line.
    """

    centre: Array
    axes: Array
    flat: Array
    rank: int

    @classmethod
    def of(cls, points: Array) -> _Plane:
        centre = points.mean(axis=0)
        _, extents, axes = np.linalg.svd(points - centre, full_matrices=len(points) < 3)
        if np.linalg.det(axes) < 0.0:
            axes = axes * np.array([[1.0], [1.0], [-1.0]])
        sizes = np.zeros(2)
        sizes[: min(extents.size, 2)] = extents[:2]
        rank = int(np.sum(sizes > FLAT * max(sizes[0], np.finfo(float).tiny))) if len(points) > 1 else 0
        return cls(centre, axes, (points - centre) @ axes[:2].T, rank)

    @cached_property
    def delaunay(self) -> scipy.spatial.Delaunay:
        return scipy.spatial.Delaunay(self.flat)

    @property
    def is_line(self) -> bool:
        """Whether the points follow one another along a line, open or closed: their Gabriel graph has at most one cell.

        The rows of a sheared mesh, which no cell joins either, follow one another in a zigzag: both ends of a step turn by more
        than half a right angle, to opposite sides.
        """
        triangles = self.flat[self.delaunay.simplices]
        to = [np.roll(triangles, -k, axis=1) - triangles for k in (1, 2)]
        sizes = np.linalg.norm(to, axis=3).prod(axis=0)
        inside = np.sum(to[0] * to[1], axis=2) <= TILT * sizes  # whether a corner lies in the circle on the opposite side
        sides = np.sort(self.delaunay.simplices[:, np.array(PAIRS)], axis=2).reshape(-1, 2)
        sides, which = np.unique(sides, axis=0, return_inverse=True)
        joined = np.bincount(which.ravel(), inside.ravel()) == 0
        cells = int(joined.sum()) - len(self.flat) + 1
        order = _path(self.flat) if cells <= (len(self.flat) >= SMALLEST_RING) else None
        if order is None:
            return False
        ahead = np.diff(self.flat[order], axis=0)
        x, y = ahead.T
        sine, cosine = x[:-1] * y[1:] - y[:-1] * x[1:], np.sum(ahead[1:] * ahead[:-1], axis=1)
        side = np.sign(sine) * (np.abs(sine) > cosine)
        return not np.any(side[1:] * side[:-1] < 0.0)

    @cached_property
    def solid(self) -> Index:
        """Delaunay triangles (t,), by their numbers, without the slivers that rounding makes along straight edges."""
        corners = self.delaunay.simplices.astype(np.int64)
        return np.flatnonzero(np.abs(_twice_area(self.flat[corners])) > SLIVER * self._longest(corners) ** 2)

    @cached_property
    def spanning(self) -> NDArray[np.bool_]:
        """Which of them span a hole, a recess, the space between parts: the largest, and those of large circles beside them."""
        corners = self.delaunay.simplices[self.solid].astype(np.int64)
        longest = self._longest(corners)
        around = np.full(len(self.flat), np.inf)
        for corner in corners.T:
            np.minimum.at(around, corner, longest)
        usual = (1.0 + ROUNDING) * around[corners].max(axis=1)
        sides = np.linalg.norm(self.flat[corners] - np.roll(self.flat[corners], 1, axis=1), axis=2)
        areas = np.abs(_twice_area(self.flat[corners]))
        diameter = sides.prod(axis=1) / areas
        large = (longest > usual) & (diameter > BESIDE * usual)
        place = np.full(len(self.delaunay.simplices), -1)
        place[self.solid[large]] = np.flatnonzero(large)
        beside = self.delaunay.neighbors[self.solid]
        first, side = np.nonzero(large[:, None] & (beside >= 0) & (place[beside] >= 0))
        pairs = coo_array((np.ones(first.size), (first, place[beside[first, side]])), shape=2 * large.shape)
        _, part = connected_components(pairs)
        found = np.zeros(large.size, bool)
        for one in np.unique(part[large & (longest > LARGER * usual)]):
            inside = part == one
            beside_it = ~large & np.isin(corners, corners[inside]).any(axis=1)
            found |= inside & bool(areas[inside].sum() > SEVERAL * np.median(areas[beside_it]))
        return found

    @cached_property
    def triangles(self) -> Index:
        """Corners of the triangles (t, 3) that the surface consists of."""
        return np.asarray(self.delaunay.simplices[self.solid[~self.spanning]], np.int64)

    @cached_property
    def edge(self) -> Index:
        """The sides (e, 2) that belong to one triangle only."""
        sides = np.sort(np.concatenate([self.triangles[:, pair] for pair in ([0, 1], [1, 2], [2, 0])]), axis=1)
        single, count = np.unique(sides, axis=0, return_counts=True)
        return np.asarray(single[count == 1])

    def _longest(self, corners: Index) -> Array:
        """The longest side of each triangle."""
        points = self.flat[corners]
        return np.asarray(np.linalg.norm(points - np.roll(points, 1, axis=1), axis=2).max(axis=1))

    def normals(self, points: Array) -> Array:
        """Unit normals of the nodes, on the side of the plane's normal: the mean of the triangles around, by their area."""
        corners = points[self.triangles]
        across = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
        across *= np.sign(across @ self.axes[2])[:, None]
        total = np.zeros_like(points)
        for corner in range(3):
            np.add.at(total, self.triangles[:, corner], across)
        return np.asarray(total / np.linalg.norm(total, axis=1)[:, None])

    def cells(self) -> Array:
        """Areas of the Voronoi cells within the convex hull, without holes, (n,) [m²].

        They do not depend on how a rectangle is divided into triangles, which rounding decides.
        """
        hull = self.flat[np.unique(self.delaunay.convex_hull)]
        away = hull - hull.mean(axis=0)
        hull = hull[np.argsort(np.arctan2(away[:, 1], away[:, 0]))]  # counter-clockwise
        first, others = self.delaunay.vertex_neighbor_vertices
        cells = [_cell(self.flat, k, hull, self.flat[others[first[k] : first[k + 1]]]) for k in range(len(self.flat))]
        areas = np.array([_area(cell) for cell in cells])
        low, high = (np.array([end(cell, axis=0) for cell in cells]) for end in (np.min, np.max))
        for hole in self.flat[self.delaunay.simplices[self.solid[self.spanning]]]:
            for k in np.flatnonzero(np.all((low < hole.max(axis=0)) & (high > hole.min(axis=0)), axis=1)):
                areas[k] -= _area(_within(cells[k], hole))
        return areas

    def shares(self, point: Array) -> dict[int, float] | None:
        """The corners of the triangle at a point's projection, or the edge near it, with their shares; None beyond it."""
        place = (point - self.centre) @ self.axes[:2].T
        corners, shares = self._around(place)
        if shares.min() < -ROUNDING:
            first, second = (self.flat[side] for side in self.edge.T)
            along = second - first
            f = np.clip(np.sum((place - first) * along, axis=1) / np.sum(along**2, axis=1), 0.0, 1.0)
            away = np.linalg.norm(first + f[:, None] * along - place, axis=1)
            best = int(np.argmin(away))
            if away[best] > OUTSIDE * np.ptp(self.flat, axis=0).max():
                return None
            corners, shares = self.edge[best], np.array([1.0 - f[best], f[best]])
        return {int(corner): float(share) for corner, share in zip(corners, shares, strict=True) if share > ROUNDING}

    def _around(self, place: Array) -> tuple[Index, Array]:
        """The triangle at a place (2,), or the one that it is least outside of, with the shares of its corners."""
        at = int(self.delaunay.find_simplex(place))
        known = at >= 0 and self.kept[at]
        triangles = self.delaunay.simplices[[at]] if known else self.triangles
        points = self.flat[triangles]
        opposite = [np.stack([np.broadcast_to(place, points[:, 0].shape), points[:, i], points[:, j]], axis=1) for i, j in PAIRS]
        every = np.column_stack([_twice_area(part) for part in opposite]) / _twice_area(points)[:, None]
        best = int(np.argmax(every.min(axis=1)))
        return triangles[best], every[best]

    @cached_property
    def kept(self) -> NDArray[np.bool_]:
        """Whether each Delaunay triangle is one of `triangles`."""
        kept = np.zeros(len(self.delaunay.simplices), bool)
        kept[self.solid[~self.spanning]] = True
        return kept


def _twice_area(corners: Array) -> Array:
    """Twice the signed areas of triangles (t, 3, 2), positive counter-clockwise."""
    (x1, y1), (x2, y2) = (corners[:, 1] - corners[:, 0]).T, (corners[:, 2] - corners[:, 0]).T
    return np.asarray(x1 * y2 - y1 * x2)


def _cell(points: Array, k: int, hull: Array, neighbours: Array) -> Array:
    """The part of the hull that is nearer to point k than to its neighbours (m, 2), as corners."""
    far = 4.0 * np.ptp(hull, axis=0).max()
    polygon = points[k] + far * np.array([(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)])
    for other in neighbours:
        middle, across = 0.5 * (points[k] + other), other - points[k]
        polygon = _clipped(polygon, (polygon - middle) @ across)
    return _within(polygon, hull)


def _within(polygon: Array, corners: Array) -> Array:
    """The part of a convex polygon that lies in another, whose corners go round once."""
    along = np.roll(corners, -1, axis=0) - corners
    x, y = corners.T
    turn = np.sign(float(x @ np.roll(y, -1) - y @ np.roll(x, -1)))
    outwards = turn * np.stack([along[:, 1], -along[:, 0]], axis=1)
    beyond = ((polygon[:, None] - corners) * outwards).sum(axis=2)
    for side in np.flatnonzero(beyond.max(axis=0) > 0.0):
        polygon = _clipped(polygon, (polygon - corners[side]) @ outwards[side])
    return polygon


def _area(polygon: Array) -> float:
    """Area of a polygon of any number of corners."""
    x, y = polygon.T
    return 0.5 * abs(float(x @ np.roll(y, -1) - y @ np.roll(x, -1)))


def _clipped(polygon: Array, beyond: Array) -> Array:
    """The part of a convex polygon where `beyond`, given at its corners, is not positive."""
    kept = []
    for k in range(len(polygon)):
        following = (k + 1) % len(polygon)
        if beyond[k] <= 0.0:
            kept.append(polygon[k])
        if beyond[k] * beyond[following] < 0.0:
            part = beyond[k] / (beyond[k] - beyond[following])
            kept.append(polygon[k] + part * (polygon[following] - polygon[k]))
    return np.array(kept).reshape(-1, 2)


def _path(points: Array) -> Index | None:
    """The order in which the shortest tree visits points one after another; None where it branches."""
    away = pdist(points)
    tree = minimum_spanning_tree(squareform(away / away.max()))
    joined = np.bincount(np.concatenate(tree.nonzero()), minlength=len(points))
    return depth_first_order(tree, int(np.argmin(joined)), directed=False)[0].astype(np.int64) if joined.max() < 3 else None


@dataclass(frozen=True, eq=False)
class _Line:
    """A line of points: their order along it, lengths of the steps from each to the following one, with one more where it is
    closed, and unit tangents (n, 3), those of the circle through a point and its two neighbours; 0 of a point alone."""

    order: Index
    steps: Array
    tangents: Array

    @classmethod
    def of(cls, name: str, points: Array) -> _Line:
        n = len(points)
        if n == 1:
            return cls(np.array([0]), np.zeros(0), np.zeros((1, 3)))
        order = _path(points)
        if order is None:
            raise fault(f"Line {name!r}", "must be one line of nodes", "branched", "Divide it into several sets.")
        ring = points[np.append(order, order[0])]
        ahead = np.diff(ring, axis=0)
        steps = np.linalg.norm(ahead, axis=1)
        ahead /= steps[:, None]
        if n == 2:
            return cls(order, steps[:1], ahead[:1].repeat(2, axis=0))
        beside = np.sum((ring[1 : n - 1] - ring[0]) * (ring[1 : n - 1] - ring[n - 1]), axis=1)
        closed = n >= SMALLEST_RING and beside.min() > 0.0 and steps[-1] < CLOSING * steps[:-1].max()
        tangents = np.zeros((n, 3))
        tangents[order] = np.roll(steps, 1)[:, None] * ahead + steps[:, None] * np.roll(ahead, 1, axis=0)
        tangents /= np.linalg.norm(tangents, axis=1)[:, None]
        if not closed:  # at its ends, the circle through the last three points: mirrored at the chord
            for end, inner, chord in ((0, 1, ahead[0]), (-1, -2, ahead[-2])):
                beside_it = tangents[order[inner]]
                tangents[order[end]] = 2.0 * (chord @ beside_it) * chord - beside_it
        return cls(order, steps if closed else steps[:-1], tangents)

    @property
    def shares(self) -> Array:
        """Of the length, half the way to each neighbour, (n,); 1 of a point alone."""
        n, shares = len(self.order), np.zeros(len(self.order))
        np.add.at(shares, self.order[np.arange(self.steps.size)], self.steps)
        np.add.at(shares, self.order[np.arange(1, self.steps.size + 1) % n], self.steps)
        return shares / shares.sum() if self.steps.size else np.ones(1)

    @property
    def places(self) -> Array:
        """Lengths along it from its first point, and 0, (n, 2)."""
        places = np.zeros((len(self.order), 2))
        places[self.order, 0] = np.append(0.0, np.cumsum(self.steps))[: len(self.order)]
        return places


Opposite = NodeSurface | Callable[[ArrayLike], Motion] | None
"""What lies opposite a surface: another surface, the motion of a body's point, `lambda point: body.at(point, "damper")`, or
None for the ground."""


def surface_contacts(
    name: str,
    law: Law,
    surface: NodeSurface,
    against: Opposite = None,
    *,
    tangent: Sequence[float] | None = None,
    start: Start | tuple[Start, ...] | None = None,
    balanced: bool = False,
    mesh_gap: bool = False,
    points: int | None = None,
) -> tuple[Contact, ...]:
    """One contact at each node of a surface, named "NAME NODE": w = frame (u_node - u_opposite), frame rows t1, t2, n.

    law: that of the whole surface; its stiffnesses and loads (kt, kn, preload, normal_load) are shared over the nodes by area
    (`Law.share`). n is the normal of each node, t1 the direction `tangent` (x, y, z) as far as it lies in the surface; unless
    given, that in which the surface is longest, or the tangent of a line. start, balanced: of every contact, as of `Contact`.
    mesh_gap: the distance of a node from the surface opposite, along its normal, adds to the gap of the law; where meshes overlap
    it is an interference.

    Meshes need not match: what lies opposite a node is interpolated between the three nodes around it. A node that has nothing
    opposite gets no contact, and the others share what the law says by their areas in the whole surface.

    points: so many contacts, "NAME 1", "NAME 2", ..., in place of one at each node. Each stands for a patch of nodes, all of
    about the same area (`NodeSurface.patches`), and moves as their mean, w = frame Σ share_k (u_k - u_opposite,k) with
    share_k = area_k / area of the patch; its force acts on the nodes in the same shares. Its law has the share of the patch in
    the surface, its normal and gap are the means of those of its nodes. `forced_response` says how far the highest peaks are from
    those with a contact at each node. Where there are as many points as nodes, or more, each node has its contact.
    """
    of_kind("law", law, Law)  # type: ignore[type-abstract]
    of_kind("surface", surface, NodeSurface)
    given: object = against
    if not (given is None or isinstance(given, NodeSurface) or callable(given)):
        remedy = 'Of a rigid body give `lambda point: body.at(point, "NAME")`, NAME as in `assemble`.'
        raise fault("against", "must be a NodeSurface, the motion of a point, or None", type(given).__name__, remedy)
    if mesh_gap and not (isinstance(against, NodeSurface) and law.has_normal and hasattr(law, "gap")):
        raise fault("mesh_gap", "must go with a surface opposite and a law that has a gap and kn", type(law).__name__)
    most = len(surface.nodes) if points is None else between("points", points, 1)
    along = surface.along if tangent is None else np.tile(vector("tangent", tangent, 3), (len(surface.nodes), 1))
    places = [surface.motion(k) for k in range(len(surface.nodes))]
    opposites: dict[int, Motion] = {}
    for k, point in enumerate(surface.points):
        motion = ground if against is None else against.at(point.tolist()) if isinstance(against, NodeSurface) else against(point)
        if motion is not None:  # another surface may have nothing there
            opposites[k] = motion
    if not opposites:
        raise InputError(f"Surface {surface.name!r} must touch what lies opposite, but none of its nodes does.")
    touching = np.array(list(opposites))
    gaps = np.zeros(len(surface.nodes))
    if mesh_gap and isinstance(against, NodeSurface):
        gaps[touching] = [against.gap(surface.points[k].tolist(), surface.normals[k].tolist()) for k in touching]

    def together(title: str, members: Index) -> Contact:
        """The contact of nodes that move as their mean."""
        shares = _shares(surface, members)
        normal = shares @ surface.normals[members]
        part = float(surface.weights[members].sum())
        own: Any = law.share(part)
        further = float(shares @ gaps[members])
        own = replace(own, gap=own.gap + further) if mesh_gap else own
        a, b = (mean([side[k] for k in members], shares) for side in (places, opposites))
        contact = contact_in_space(
            title, own, a, b, _frame(name, normal / np.linalg.norm(normal), shares @ along[members]), start
        )
        place = OnSurface(name, part, further, surface.points[members])
        return replace(contact, balanced=balanced, area=part * surface.area, surface=place)

    titles = [f"{name} {surface.nodes[k].rpartition('/')[2]}" for k in touching]
    if len(set(titles)) < len(titles):
        titles = [f"{name} {number}" for number in range(1, len(titles) + 1)]
    nodal = {k: together(title, np.array([k])) for title, k in zip(titles, touching, strict=True)}
    if most >= len(nodal):
        return tuple(nodal.values())
    patches = []
    for number, members in enumerate(surface.patches(most, touching), start=1):
        shares = _shares(surface, members)
        further = gaps[members] - shares @ gaps[members]
        nodes = [
            PatchNode(nodal[k].name, float(share), nodal[k].tangential, nodal[k].normal, float(gap), nodal[k].surface)
            for k, share, gap in zip(members, shares, further, strict=True)
        ]
        patches.append(replace(together(f"{name} {number}", members), nodes=tuple(nodes)))
    return tuple(patches)


def _shares(surface: NodeSurface, members: Index) -> Array:
    """The share of each of some nodes in their area."""
    areas = surface.weights[members]
    return np.asarray(areas / areas.sum())


def _frame(name: str, normal: Array, along: Array) -> Array:
    """Rows t1, t2, n: t1 is the part of a direction that lies in the surface."""
    t1 = along - (along @ normal) * normal
    size = float(np.linalg.norm(t1))
    if size < 1e-3 * float(np.linalg.norm(along)) or not size:
        raise fault(f"The tangent of {name}", "must be a direction that is not the normal", along.tolist())
    return np.stack([t1 / size, np.cross(normal, t1 / size), normal])
