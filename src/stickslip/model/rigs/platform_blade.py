"""A straight blade with an underplatform: parametric mesh, clamped root, reduction to the nodes that a rig needs.

Axes: x lateral (bending), y radial outward from the root, z depth. Steel.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import lru_cache
from itertools import pairwise
from math import radians, tan
from typing import Any

import numpy as np

from stickslip.model.structure.cyclic_reduction import Reduction, craig_bampton
from stickslip.model.structure.mesh_surface import body_surface
from stickslip.model.structure.solid import STEEL, Material, Solid, box_mesh, located, solid
from stickslip.support.checks import Array, fault, finite, positive

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
