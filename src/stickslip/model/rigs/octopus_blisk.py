"""The bladed disk of "On the choice of contact parameters for the forced response calculation of a bladed disk with
underplatform dampers": 24 blades, a cylinder between all neighbours, travelling-wave excitation.

The paper publishes contact parameters, the damper and stuck resonances, but no geometry. The dimensions of the sector are
this project's own, see `docs/disks.md` for what was fitted and what is predicted.

A parametric sector of a bladed disk: disk, shank, platform, blade; mesh, cyclic faces and the nodes that a rig needs.

Axes of the sector: x radial through its middle, y tangential, z axial; sectors are numbered counter-clockwise about z.
Stagger shears the sections of shank and blade: they are shifted tangentially by z tan(stagger). Platform edges and dampers stay
parallel to the axis; the disk, a body of revolution, takes part in its mesh only.
"""

from dataclasses import dataclass, field, replace
from functools import lru_cache
from math import cos, pi, radians, sin, tan
from typing import Any, Literal

import numpy as np
import scipy
from numpy.typing import NDArray

from stickslip.model.contact.macroslip import Macroslip
from stickslip.model.contact.point import Contact, Direction, Motion, OnSurface, Start, contact_in_space, node
from stickslip.model.contact.stiffness import NORMAL_STIFFNESS, LineContact, static_normal_load
from stickslip.model.dampers.damper import hull_of
from stickslip.model.disks.tuned import TunedDisk
from stickslip.model.loads import Force
from stickslip.model.structure.assembly import RigidBody, Spring
from stickslip.model.structure.centrifugal import spinning
from stickslip.model.structure.cyclic import MOST_SECTORS, NEXT, with_bodies
from stickslip.model.structure.cyclic_reduction import CyclicReduction, Sector, cyclic_craig_bampton, rotation, sector_of
from stickslip.model.structure.matrices import ModalDamping
from stickslip.model.structure.mesh_surface import SectorSurface, sector_surface
from stickslip.model.structure.solid import Material, Solid, box_mesh, located, solid
from stickslip.support.checks import Array, InputError, between, fault, finite, nearest, not_negative, of_kind, positive

POINTS = 5
"""Contact points of each line."""
OCTOPUS_STEEL = Material(206e9, 0.3, 7800.0)


@dataclass(frozen=True)
class BliskSector:
    """Dimensions [m] and angles [degrees] of a sector; the hub is clamped.

    shank, platform and blade stand on the rim; width: of their section along the stagger; thicknesses: of
    shank and blade, tangential. damper_radius, damper_length: of the cylinder whose lines touch the lower platform edges;
    platform_angle: of the contact planes. cells: layers of elements in disk, shank and blade. rotation: steady, of the whole disk
    [Hz, turns a second]: the centrifugal load stiffens and softens the structure (`structure.centrifugal`).
    """

    sectors: int = 24
    hub_radius: float = 60e-3
    rim_radius: float = 115.4e-3
    disk_thickness: float = 50e-3
    shank_length: float = 170.0e-3
    shank_thickness: float = 24.085e-3
    width: float = 75.9e-3
    platform_thickness: float = 12e-3
    blade_length: float = 171.5e-3
    root_thickness: float = 33.0e-3
    tip_thickness: float = 23.8e-3
    stagger: float = 25.0
    platform_angle: float = 20.0
    damper_radius: float = 5e-3
    damper_length: float = 27.6e-3
    cells: tuple[int, int, int] = (3, 6, 5)
    rotation: float = 0.0
    material: Material = field(default=OCTOPUS_STEEL)

    def __post_init__(self) -> None:
        lengths = (
            "hub_radius",
            "disk_thickness",
            "shank_length",
            "shank_thickness",
            "width",
            "platform_thickness",
            "blade_length",
        )
        for key in (*lengths, "root_thickness", "tip_thickness", "damper_radius", "damper_length"):
            positive(key, getattr(self, key))
        object.__setattr__(self, "sectors", between("sectors", self.sectors, 3, MOST_SECTORS))
        if not self.hub_radius < self.rim_radius:
            raise fault("rim_radius", f"must lie above the hub radius {self.hub_radius:g} m", self.rim_radius)
        if not 0.0 <= finite("platform_angle", self.platform_angle) < 90.0:
            raise fault("platform_angle", "must lie in [0, 90) degrees", self.platform_angle)
        finite("stagger", self.stagger)
        not_negative("rotation", self.rotation)
        if not abs(self.stagger) < 75.0:
            raise fault("stagger", "must lie between -75 and 75 degrees", self.stagger, "The cells are sheared flat beyond.")
        if self.shank_thickness >= self.pitch(self.rim_radius):
            raise fault(
                "shank_thickness",
                f"must stay below the pitch at the rim, {self.pitch(self.rim_radius):.3g} m",
                self.shank_thickness,
            )
        if self.damper_length >= min(self.disk_thickness, self.axial_width):
            raise fault(
                "damper_length", "must leave the contact nodes on the platform, inside disk and platform", self.damper_length
            )
        if self.edge_angle * self.platform_radius <= 0.5 * max(self.shank_thickness, self.root_thickness):
            raise InputError(
                "The platform must reach beyond shank and blade, but the damper's gap leaves it no room: contact nodes would lie "
                "off the platform. Choose a thinner shank, a smaller damper or fewer sectors."
            )

    @property
    def platform_radius(self) -> float:
        """Radius of the platform's underside."""
        return self.rim_radius + self.shank_length

    @property
    def tip_radius(self) -> float:
        return self.platform_radius + self.platform_thickness + self.blade_length

    @property
    def edge_angle(self) -> float:
        """Angle of the lower platform edges, where the cylinder touches, from the middle of the sector."""
        return pi / self.sectors - self.damper_radius * sin(radians(self.platform_angle)) / self.platform_radius

    @property
    def axial_width(self) -> float:
        """Extent of shank, platform and blade along z."""
        return self.width * cos(radians(self.stagger))

    def pitch(self, radius: float) -> float:
        """Tangential width of a sector at a radius, m."""
        return 2.0 * pi / self.sectors * radius

    def place(self, angle: float, radius: float, z: float) -> Array:
        """The point at an angle from the middle, (3,)."""
        return np.array([radius * cos(angle), radius * sin(angle), z])

    def _lean(self, radius: Array, z: Array) -> Array:
        """The angle by which the stagger shifts a section: none at the hub, the whole from the rim on."""
        share = np.clip((radius - self.hub_radius) / (self.rim_radius - self.hub_radius), 0.0, 1.0)
        return np.asarray(share * z * tan(radians(self.stagger)) / radius)

    @property
    def line(self) -> Array:
        """z of the contact points along a platform edge, (5,)."""
        return np.linspace(-0.5, 0.5, POINTS) * self.damper_length

    def mesh(self) -> Any:
        """Hexahedra in columns −3..3 (±3 cyclic faces or platform edges, ±1 sides of shank and blade) and radial layers."""
        radii = self._radii()
        block = box_mesh(np.arange(-3.0, 4.0), np.arange(radii.size, dtype=float), self._heights())
        column, layer, height = block.p[:, block.t].mean(axis=1)
        disk, shank, _ = self.cells
        in_disk, in_platform = layer < disk, np.floor(layer) == disk + shank
        thin = (np.abs(column) < 1.0) | in_platform
        inside = np.where(in_disk, np.abs(height) < 0.5 * self.disk_thickness, thin)
        inside &= in_disk | (np.abs(height) < 0.5 * self.axial_width)
        kept = block.remove_elements(np.flatnonzero(~inside))
        radius = radii[np.round(kept.p[1]).astype(int)]
        angle = self._angles(np.round(kept.p[0]), kept.p[1], radius, kept.p[2])
        return type(kept)(np.stack([radius * np.cos(angle), radius * np.sin(angle), kept.p[2]]), kept.t)

    def _radii(self) -> Array:
        """The radius of each layer of nodes, from the hub to the tip."""
        disk, shank, blade = self.cells
        bottom, top = self.platform_radius, self.platform_radius + self.platform_thickness
        parts = [
            np.linspace(self.hub_radius, self.rim_radius, disk + 1),
            np.linspace(self.rim_radius, bottom, shank + 1)[1:],
            np.linspace(top, self.tip_radius, blade + 1),
        ]
        return np.concatenate(parts)

    def _heights(self) -> Array:
        """Lines along the axis: through the contact points, the faces of the disk and of the blade."""
        edges = 0.5 * np.outer([self.disk_thickness, self.axial_width], [-1.0, 1.0])
        return np.unique(np.concatenate([self.line[::2], edges.ravel()]))

    def _angles(self, column: Array, layer: Array, radius: Array, z: Array) -> Array:
        """Angle of each node by its column, layer, radius and height."""
        lean = self._lean(radius, z)
        inner = lean + np.clip(column, -1.0, 1.0) * 0.5 * self._thickness(radius) / radius
        outer = np.where(layer <= self.cells[0], np.sign(column) * pi / self.sectors + lean, np.sign(column) * self.edge_angle)
        share = np.clip((np.abs(column) - 1.0) / 2.0, 0.0, 1.0)
        return np.asarray((1.0 - share) * inner + share * outer)

    def _thickness(self, radius: Array) -> Array:
        """Tangential thickness of what stands in the middle columns; in the disk in proportion to the radius."""
        top = self.platform_radius + self.platform_thickness
        stations = [self.hub_radius, self.rim_radius, self.platform_radius, top, self.tip_radius]
        shank, root, tip = self.shank_thickness, self.root_thickness, self.tip_thickness
        return np.interp(radius, stations, [shank * self.hub_radius / self.rim_radius, shank, shank, root, tip])

    def body(self) -> Solid:
        """The meshed sector at rest, clamped at the hub."""
        inner = self.hub_radius
        return solid(self.mesh(), self.material).clamp(lambda p: np.hypot(p[:, 0], p[:, 1]) < inner * (1.0 + 1e-9))

    def sector(self) -> Sector:
        """The clamped sector with its cyclic faces paired, at its rotation."""
        left, right = (self._face(side) for side in (-1, 1))
        body = self.body()
        low, high = (np.flatnonzero(among(body.points, face)) for face in (left, right))
        still = sector_of(body, self.sectors, low, high)
        rate = 2.0 * pi * self.rotation
        return replace(still, solid=spinning(still.solid, self.mesh(), self.material, rate, still.constraint(0)))

    def _face(self, side: int) -> Array:
        """Nodes of the left (−1) or right (1) face of the disk: corners of cells and middles of their edges, (nodes, 3)."""
        radii = self._radii()[: self.cells[0] + 1]
        heights = self._heights()
        z = heights[np.abs(heights) <= 0.5 * self.disk_thickness * (1.0 + 1e-9)]
        angle = side * pi / self.sectors
        grid = np.array([[self.place(angle + float(self._lean(r, height)), r, height) for height in z] for r in radii])
        middles = (0.5 * (grid[1:] + grid[:-1]), 0.5 * (grid[:, 1:] + grid[:, :-1]))
        return np.concatenate([part.reshape(-1, 3) for part in (grid, *middles)])

    def contact_nodes(self) -> dict[str, Array]:
        """{"right_1": point, ..., "left_5": point} on the lower platform edges; sides as seen from the blade."""
        nodes: dict[str, Array] = {}
        for name, side in (("right", 1), ("left", -1)):
            first, second, third = (self.place(side * self.edge_angle, self.platform_radius, z) for z in self.line[::2])
            # Nodes of the mesh, and the middles of the straight lines between them.
            edge = (first, 0.5 * (second + first), second, 0.5 * (third + second), third)
            nodes |= {f"{name}_{k}": point for k, point in enumerate(edge, start=1)}
        return nodes

    def tip(self) -> Array:
        """The middle of the blade's tip."""
        return self.place(0.0, self.tip_radius, 0.0)

    def damper_axes(self) -> Array:
        """Rows: across the gap, outwards, along the damper: the axes of the damper between this sector and the next, (3, 3)."""
        middle = pi / self.sectors
        outwards = np.array([cos(middle), sin(middle), 0.0])
        around = np.array([-sin(middle), cos(middle), 0.0])
        return np.array([around, outwards, [0.0, 0.0, 1.0]])

    def damper_centre(self) -> Array:
        """The damper's axis, at the middle of its length: below the platform edges, (3,)."""
        right = self.place(self.edge_angle, self.platform_radius, 0.0)
        left = rotation(self.sectors) @ self.place(-self.edge_angle, self.platform_radius, 0.0)
        return np.asarray(0.5 * (right + left) - self.damper_radius * cos(radians(self.platform_angle)) * self.damper_axes()[1])


def among(points: Array, chosen: Array) -> NDArray[np.bool_]:
    """Which of the points (n, 3) are one of those chosen, (n,)."""
    return np.asarray(scipy.spatial.cKDTree(chosen).query(points)[0] < 1e-9)


def reduced_sector(sector: BliskSector, modes: int) -> CyclicReduction:
    """Cyclic Craig-Bampton that keeps all contact nodes and the tip (x, y, z); kept in memory."""
    return _reduced(sector, modes)[1]


@lru_cache(maxsize=8)
def surface(sector: BliskSector, modes: int) -> SectorSurface:
    """The outer surface of the reduced sector, for pictures."""
    return sector_surface(sector.mesh(), *_reduced(sector, modes))


@lru_cache(maxsize=8)
def _reduced(sector: BliskSector, modes: int) -> tuple[Sector, CyclicReduction]:
    meshed = sector.sector()
    places = sector.contact_nodes() | {"tip": sector.tip()}
    reduction = cyclic_craig_bampton(meshed, meshed.solid.named(places), modes)
    return meshed, replace(reduction, structure=located(reduction.structure, meshed.solid, places))


ROLL_STIFFNESS, AXIAL_STIFFNESS = 1.0, 1e4
"""Springs on the mean roll [N m/rad] and the mean axial position [N/m] of a damper, which nothing else holds once it slips."""


@dataclass(frozen=True)
class TangentialStiffness:
    """Total stiffness of one contact line, N/m: across the damper (k_tx) and along its axis (k_ty)."""

    across: float
    along: float


PUBLISHED = {"measured": TangentialStiffness(1.70e7, 1.70e7), "analytic": TangentialStiffness(5.71e8, 6.07e8)}
"""Table 2 of the paper. Its column of k_n is lost: it is computed from the formula the paper names, Brändlein's."""


def octopus_blisk(
    contact: Literal["measured", "analytic"] = "measured",
    *,
    ktx: float | None = None,
    kty: float | None = None,
    kn: float | None = None,
    normal_stiffness: str = "Brändlein",
    mu: float = 0.6,
    pull: float = 147.0,
    engine_order: int = 2,
    platform_angle: float = 20.0,
    rotation: float | None = None,
    stagger: float | None = None,
    damper_mass: float = 16.9e-3,
    damping: float = 5.43e-4,
    force: float = 1.0,
    modes: int = 20,
    start: Start | None = None,
    sector: BliskSector | None = None,
) -> TunedDisk:
    """24 sectors of 20-node hexahedra, reduced for each nodal diameter; load and output tangential at the middle of the tip.

    contact: the published set of tangential stiffness, "measured" or "analytic"; ktx, kty: totals of a line in its place
    [N/m]; kn: total of a line [N/m], or from the formula `normal_stiffness` at F_C/(2 cos α). pull: centrifugal force F_C of
    each damper [N], which does not follow the rotation; platform_angle α, stagger [degrees]; rotation: of the disk, which
    stiffens it [Hz]; damping: ratio of every stuck mode; modes: fixed-interface modes of each nodal diameter.
    """
    if contact not in PUBLISHED:
        raise fault("contact", "must be a known set", contact, nearest(str(contact), PUBLISHED))
    if normal_stiffness not in NORMAL_STIFFNESS:
        raise fault("normal_stiffness", "must be a known formula", normal_stiffness, nearest(normal_stiffness, NORMAL_STIFFNESS))
    if contact != "measured" and (ktx, kty) != (None, None):
        raise fault("ktx and kty", f"must be left out beside the published set {contact!r}", {"ktx": ktx, "kty": kty})
    base = BliskSector() if sector is None else of_kind("sector", sector, BliskSector)
    shape = replace(base, platform_angle=platform_angle)
    shape = shape if rotation is None else replace(shape, rotation=rotation)
    shape = shape if stagger is None else replace(shape, stagger=stagger)
    tangential = PUBLISHED[contact]
    line = LineContact(shape.damper_length, shape.damper_radius)
    total_kn = kn if kn is not None else float(NORMAL_STIFFNESS[normal_stiffness](line, static_normal_load(pull, platform_angle)))
    share = 1.0 / POINTS
    across, along = (tangential.across if ktx is None else ktx), (tangential.along if kty is None else kty)
    law = Macroslip(share * positive("ktx", across), mu, share * positive("kn", total_kn), kt2=share * positive("kty", along))
    body = cylinder(shape, positive("damper_mass", damper_mass))
    structure = with_bodies(reduced_sector(shape, modes).structure, {"damper": body.structure()})
    outwards = shape.damper_axes()[1]
    return TunedDisk(
        structure.with_damping(ModalDamping(damping, on="stuck")),
        line_contacts(shape, body, law, start),
        (
            Force("tip.y", force, name="engine order"),
            Force({"damper/centre.x": outwards[0], "damper/centre.y": outwards[1]}, static=pull, name="centrifugal pull"),
        ),
        ("tip.y",),
        f"Octopus bladed disk, {contact} contact stiffness",
        gauge_springs(shape),
        engine_order,
        surface(shape, modes),
    )


def cylinder(shape: BliskSector, mass: float) -> RigidBody:
    """The damper between a sector and the next as a rigid cylinder, its inertia in the axes of the sector."""
    R, L = shape.damper_radius, shape.damper_length
    axes = shape.damper_axes()
    slim = mass * (3.0 * R**2 + L**2) / 12.0
    circle = np.pad(hull_of([((0.0, 0.0), R)]), ((0, 0), (0, 1))) @ axes
    return RigidBody(mass, axes.T @ np.diag([slim, slim, 0.5 * mass * R**2]) @ axes, shape.damper_centre(), outline=circle)


def line_contacts(shape: BliskSector, body: RigidBody, law: Macroslip, start: Start | None) -> tuple[Contact, ...]:
    """Five points on this platform's right edge and five on the next one's left edge: w = frame (u_damper − u_blade)."""
    nodes = shape.contact_nodes()
    turn = rotation(shape.sectors)
    across, outwards, along = shape.damper_axes()
    contacts = []
    for side, sense in (("right", 1.0), ("left", -1.0)):
        c, s = cos(radians(shape.platform_angle)), sense * sin(radians(shape.platform_angle))
        # Rows t1 across, t2 along the damper, n into the platform.
        frame = np.array([c * across + s * outwards, along, c * outwards - s * across])
        for k in range(1, POINTS + 1):
            name = f"{side}_{k}"
            place = nodes[name] if side == "right" else turn @ nodes[name]
            opposite = node(name) if side == "right" else following_node(name, turn)
            contact = contact_in_space(f"{side} edge {k}", law, body.at(place, "damper"), opposite, frame, start)
            contacts.append(replace(contact, surface=OnSurface(f"{side} edge", 1.0 / POINTS, places=place[None])))
    return tuple(contacts)


def following_node(name: str, turn: Array) -> Motion:
    """A node of the following sector: its degrees of freedom stand in axes turned by `turn`."""

    def motion(direction: Direction | Array) -> Direction:
        own = turn.T @ np.asarray(direction)
        return {f"{NEXT}{name}.{axis}": float(c) for axis, c in zip("xyz", own, strict=True) if c != 0.0}

    return motion  # type: ignore[return-value]


def gauge_springs(shape: BliskSector) -> tuple[Spring, ...]:
    """What holds the mean roll and the mean axial position of a damper."""
    axis = shape.damper_axes()[2]
    roll = {f"damper/centre.r{name}": float(c) for name, c in zip("xyz", axis, strict=True)}
    axial = {f"damper/centre.{name}": float(c) for name, c in zip("xyz", axis, strict=True)}
    return Spring(roll, ROLL_STIFFNESS), Spring(axial, AXIAL_STIFFNESS)
