"""A straight blade with an underplatform: parametric mesh, clamped root, reduction to the nodes that a rig needs.

Axes: x lateral (bending), y radial outward from the root, z depth. Steel.

The force separator of the single-blade rig: an L-shaped rigid body between a damper's cylinder side and two load cells.

Its arms start behind the cylinder line, one outwards (x), one upwards (y), so that the contact force splits into one force
along each arm; at the end of each arm sits a load cell, fixed on its far side. The paper shows the principle and gives no
dimension: those here are this project's choice (docs/single_blade.md says what they change).
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from functools import lru_cache
from itertools import pairwise
from math import cos, radians, sin, tan
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from stickslip.model.structure.assembly import Spring, prefixed
from stickslip.model.structure.cyclic_reduction import Reduction, craig_bampton
from stickslip.model.structure.matrices import Structure
from stickslip.model.structure.mesh_surface import body_surface
from stickslip.model.structure.rigid_body import Motion, RigidBody, box_inertia
from stickslip.model.structure.solid import STEEL, Material, Solid, box_mesh, located, solid
from stickslip.support.checks import Array, fault, finite, not_negative, positive, vector
from stickslip.support.units import N_per_um

Place = tuple[float, float, float]


@dataclass(frozen=True)
class PlatformBlade:
    """A box t × b × L clamped at y = 0, with a platform that reaches beyond it on both sides in x. Lengths in m.

    thickness t (x), depth b (z), length L (y); platform_bottom, platform_height (y), platform_reach (x) and platform_angle
    [degrees]: the underside of the platform rises outwards; force_height: y of the load, a mesh line; element_size along y;
    elements_in_depth along z.
    """

    thickness: float = 24e-3
    depth: float = 40e-3
    length: float = 222.388e-3
    platform_bottom: float = 79e-3
    platform_height: float = 26e-3
    platform_reach: float = 12e-3
    platform_angle: float = 45.0
    force_height: float = 39e-3
    element_size: float = 12e-3
    elements_in_depth: int = 4
    material: Material = STEEL

    def __post_init__(self) -> None:
        for key in ("thickness", "depth", "length", "platform_height", "platform_reach", "element_size"):
            positive(key, getattr(self, key))
        if not 0.0 < self.force_height < self.platform_bottom < self.platform_top < self.length:
            heights = [self.force_height, self.platform_bottom, self.platform_top, self.length]
            raise fault("Force, bottom and top of the platform, tip", "must lie above each other (y in m)", heights)
        if not 0.0 <= finite("platform_angle", self.platform_angle) < 90.0 or self.rise >= self.platform_height:
            remedy = f"At its outer edge {(self.platform_height - self.rise) * 1e3:.3g} mm of platform would be left."
            raise fault("platform_angle", "must leave the platform some height (degrees)", self.platform_angle, remedy)
        if self.elements_in_depth < 2 or self.elements_in_depth % 2:
            raise fault("elements_in_depth", "must be an even number", self.elements_in_depth, "The middle needs a mesh line.")

    @property
    def platform_top(self) -> float:
        return self.platform_bottom + self.platform_height

    @property
    def rise(self) -> float:
        """How far the underside rises over the reach, m."""
        return self.platform_reach * tan(radians(self.platform_angle))

    def underside(self, fraction: float, z: float, side: int) -> Place:
        """The point of the platform's underside at this fraction of its reach, on the right (side = 1) or left (−1)."""
        x = side * (0.5 * self.thickness + fraction * self.platform_reach)
        return (x, self.platform_bottom + fraction * self.rise, z)

    def mesh(self) -> Any:
        """Hexahedra between the mesh lines, the platform's underside raised (a scikit-fem `MeshHex`)."""
        half = 0.5 * self.thickness
        side = half + self.platform_reach * np.array([1 / 3, 2 / 3, 1.0])
        x = np.concatenate([-side[::-1], [-half, 0.0, half], side])
        y = _pieces([0.0, self.force_height, self.platform_bottom, self.platform_top, self.length], self.element_size)
        z = np.linspace(-0.5 * self.depth, 0.5 * self.depth, self.elements_in_depth + 1)
        block = box_mesh(x, y, z)
        centres = block.p[:, block.t].mean(axis=1)
        beside = np.abs(centres[0]) > half
        off_platform = (centres[1] < self.platform_bottom) | (centres[1] > self.platform_top)
        mesh = block.remove_elements(np.flatnonzero(beside & off_platform))
        # The underside of the platform rises outwards, its top stays.
        overhang = np.maximum(np.abs(mesh.p[0]) - 0.5 * self.thickness, 0.0)
        slope = overhang * tan(radians(self.platform_angle)) / self.platform_height
        inclined = mesh.p.copy()
        inclined[1] = self.platform_top - (self.platform_top - mesh.p[1]) * (1.0 - slope)
        return type(mesh)(np.where(overhang > 0.0, inclined, mesh.p), mesh.t)

    def clamped(self) -> Solid:
        """The meshed blade, clamped at its root y = 0."""
        return solid(self.mesh(), self.material).clamp(lambda points: points[:, 1] < 1e-9)


@lru_cache(maxsize=8)
def reduced_blade(blade: PlatformBlade, pads: tuple[tuple[str, Place], ...], modes: int) -> Reduction:
    """Craig-Bampton reduction that keeps the named pad nodes (x, y, z), "force.x" and "tip.x"; kept in memory."""
    body = blade.clamped()
    force = (0.5 * blade.thickness, blade.force_height, 0.0)
    others = {"force": force, "tip": (0.0, blade.length, 0.0)}
    kept = body.named(dict(pads)) | body.named(others, "x")
    reduction = craig_bampton(body.M, body.K, kept, modes)
    structure = located(reduction.structure, body, dict(pads) | others)
    surface = body_surface(blade.mesh(), body, structure.dofs, reduction.transformation)
    return replace(reduction, structure=replace(structure, surfaces=(surface,)))


def _pieces(stations: Sequence[float], size: float) -> Array:
    """Grid lines through all stations, in equal pieces of about `size` between them."""
    lines = [np.array([stations[0]])]
    for low, high in pairwise(stations):
        lines.append(np.linspace(low, high, max(1, round((high - low) / size)) + 1)[1:])
    return np.concatenate(lines)


@dataclass(frozen=True)
class ForceSeparator:
    """Dimensions [m], mass [kg] and load cells of a separator.

    arm, thickness, depth: of each of the two equal arms; pad: from the cylinder line to the axes of the arms; mass: of both
    arms together; cell_stiffness k along the cell's axis [N/m]; cell_shear: lateral stiffness as a share of k; cell_radius r:
    the cell is a disc of springs, with k r²/4 against bending and share k r²/2 against torsion [N m/rad].
    """

    arm: float = 40e-3
    thickness: float = 12e-3
    depth: float = 40e-3
    pad: float = 5e-3
    mass: float = 0.3
    cell_stiffness: float = 500 * N_per_um
    cell_shear: float = 0.3
    cell_radius: float = 10e-3

    def __post_init__(self) -> None:
        for key in ("arm", "thickness", "depth", "mass", "cell_stiffness", "cell_shear", "cell_radius"):
            positive(key, getattr(self, key))
        not_negative("pad", self.pad)

    def placed(self, name: str, line_centre: ArrayLike, side: int, platform_angle: float) -> "Separator":
        """The separator behind a cylinder line (3,) [m] on the right (side 1) or left (−1) of the blade; angle in degrees."""
        if side not in (-1, 1):
            raise fault("side", "must be 1 (right) or -1 (left)", side)
        angle = radians(platform_angle)
        normal = np.array([side * sin(angle), cos(angle), 0.0])
        return Separator(name, self, vector("line_centre", line_centre, 3) + self.pad * normal, side)


@dataclass(frozen=True, eq=False)
class Separator:
    """A separator in place, named as its body is in the assembly; corner (3,) [m]: where the axes of its arms meet."""

    name: str
    shape: ForceSeparator
    corner: Array
    side: int

    @property
    def arms(self) -> Array:
        """Unit vectors along the arm in x and the arm in y, (2, 3)."""
        return np.array([[float(self.side), 0.0, 0.0], [0.0, 1.0, 0.0]])

    @property
    def body(self) -> RigidBody:
        """Both arms as boxes of half the mass each."""
        s = self.shape
        centre = self.corner + 0.25 * s.arm * self.arms.sum(axis=0)
        inertia = np.zeros((3, 3))
        for along in self.arms:
            sides = np.where(along != 0.0, s.arm, s.thickness)
            sides[2] = s.depth
            lever = self.corner + 0.5 * s.arm * along - centre
            inertia += box_inertia(0.5 * s.mass, sides) + 0.5 * s.mass * (lever @ lever * np.eye(3) - np.outer(lever, lever))
        return RigidBody(s.mass, inertia, centre)

    @property
    def structure(self) -> Structure:
        """The free body, to be assembled under the separator's name."""
        return self.body.structure()

    def at(self, point: ArrayLike) -> Motion:
        """The motion of a point of the separator [m], in the names of the assembly."""
        return self.body.at(point, self.name)

    def cells(self) -> Iterator[Spring]:
        """The load cells as springs to ground: axial, lateral, bending and torsion, six each."""
        s, body = self.shape, self.body
        for along in self.arms:
            seat = body.at(self.corner + s.arm * along, self.name)
            for axis, letter in zip(np.eye(3), "xyz", strict=True):
                axial = bool(axis @ along)
                yield Spring(seat(axis.tolist()), s.cell_stiffness * (1.0 if axial else s.cell_shear))
                turning = 0.5 * s.cell_shear if axial else 0.25
                rotation = prefixed(self.name, f"{body.node}.r{letter}")
                yield Spring({rotation: 1.0}, turning * s.cell_stiffness * s.cell_radius**2)
