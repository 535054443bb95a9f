"""One blade between two flat-cylinder dampers: the rig of "An Experimental and Computational Comparison of the Dynamic
Response Variability in a Turbine Blade with Under-Platform Dampers".

The paper publishes contact parameters, preloads, damping and the free frequency (410 Hz), but no geometry. The dimensions
here were calibrated with two of its numbers: the free frequency and the resonance at 80 N and 4.6 kg (529 Hz).

One blade between two semi-cylindrical dampers, dry or oiled: the rig of "Effect of Variation in Contact Friction on the
Performance of the Under-Platform Dampers".

The paper publishes its loads (26, 56 and 206 N on each damper) and measured trends, but neither the blade nor the dampers nor
contact parameters. All dimensions here are this project's choice: a straight steel blade and half cylinders of 8 mm radius, flat
side on the blade, round side on a fixed platform, pulled (by wires, as there) midway between the two contacts, so that both sides
carry the same load; contact stiffness after the published values of the same laboratory.

The blade of both: parametric mesh, clamped root, reduction to the nodes that a rig needs. Axes: x lateral (bending), y radial
outward from the root, z depth.
"""

from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass, replace
from functools import lru_cache
from itertools import pairwise
from math import hypot, pi, radians, tan
from typing import Any

import numpy as np

from stickslip.model.contact.macroslip import Macroslip
from stickslip.model.contact.microslip import MicroslipArray
from stickslip.model.contact.point import Contact, Start, ground, node
from stickslip.model.contact.stiffness import static_normal_load
from stickslip.model.dampers.cylinder import FlatCylinder
from stickslip.model.dampers.damper import Damper
from stickslip.model.loads import Force
from stickslip.model.problem import Problem
from stickslip.model.structure.assembly import assemble
from stickslip.model.structure.cyclic_reduction import Reduction, craig_bampton
from stickslip.model.structure.matrices import ModalDamping, Structure
from stickslip.model.structure.mesh_surface import body_surface
from stickslip.model.structure.solid import STEEL, Material, Solid, box_mesh, located, solid
from stickslip.model.structure.stress import StressRecovery, stress_recovery
from stickslip.support.checks import Array, fault, finite, not_negative, positive
from stickslip.support.units import STANDARD_GRAVITY, N_per_um

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


ELEMENTS_PER_POINT = 5
"""Macroslip elements in parallel at each point of the cylinder line."""


@dataclass(frozen=True)
class ContactParameters:
    """Totals of one damper: kt, kn [N/m] of the flat and of the cylinder side, friction coefficients."""

    flat_kt: float
    flat_kn: float
    flat_mu: float
    cylinder_kt: float
    cylinder_kn: float
    cylinder_mu: float

    def __post_init__(self) -> None:
        for key in ("flat_kt", "flat_kn", "cylinder_kt", "cylinder_kn"):
            positive(key, getattr(self, key))
        for key in ("flat_mu", "cylinder_mu"):
            not_negative(key, getattr(self, key))


PUBLISHED = {
    2.6: ContactParameters(20 * N_per_um, 50 * N_per_um, 0.6, 45 * N_per_um, 260 * N_per_um, 0.4),
    4.6: ContactParameters(25 * N_per_um, 65 * N_per_um, 0.6, 45 * N_per_um, 260 * N_per_um, 0.4),
    6.6: ContactParameters(35 * N_per_um, 75 * N_per_um, 0.6, 35 * N_per_um, 260 * N_per_um, 0.4),
}
"""Contact parameters by preload mass in kg (Table 1 of the paper)."""


def single_blade(
    preload_mass: float = 4.6,
    *,
    flat_kt: float | None = None,
    flat_kn: float | None = None,
    flat_mu: float | None = None,
    cylinder_kt: float | None = None,
    cylinder_kn: float | None = None,
    cylinder_mu: float | None = None,
    gap_factor: float = 0.9,
    damping: float = 0.008,
    force: float = 1.0,
    platform_angle: float = 45.0,
    length: float = 222.388e-3,
    damper_mass: float = 50e-3,
    centre_offset: float = 8e-3,
    cylinder_offset: float = 16e-3,
    modes: int = 150,
    flat_points: int = 5,
    cylinder_elements: int = ELEMENTS_PER_POINT,
    start: Start | None = None,
) -> Problem:
    """The blade, clamped at its root, with a damper under each side of its platform; output is the lateral motion of the tip.

    preload_mass: dead weight that pulls each damper up [kg]: 2.6, 4.6 or 6.6, or any with all six contact parameters given
    (totals per surface: kt, kn in N/m, friction coefficient mu).
    gap_factor g: the gaps of the five elements at a cylinder point reach 2 g N̄/kn; damping: ratio of every stuck mode;
    force: amplitude at (t/2, 39 mm, 0) along x [N]; platform_angle [degrees]; length of the blade [m]; damper_mass [kg];
    centre_offset, cylinder_offset: x from pad middle to mass centre and cylinder line [m]; modes: fixed-interface modes
    kept; flat_points: 4, 5, 9 or 15 on each flat; cylinder_elements: in parallel at a point, 1 for macroslip; start: one start
    rule for all contacts (virgin unless given).
    """
    names = ("flat_kt", "flat_kn", "flat_mu", "cylinder_kt", "cylinder_kn", "cylinder_mu")
    values = (flat_kt, flat_kn, flat_mu, cylinder_kt, cylinder_kn, cylinder_mu)
    parameters = contact_parameters(positive("preload_mass", preload_mass), dict(zip(names, values, strict=True)))
    blade, pull = PlatformBlade(length=length, platform_angle=platform_angle), preload_mass * STANDARD_GRAVITY
    offsets = {"centre_offset": centre_offset, "cylinder_offset": cylinder_offset}
    dampers = placed_dampers(blade, damper_shape(blade, **offsets, mass=damper_mass, flat_points=flat_points), pull)
    largest_gap = 2.0 * gap_factor * static_normal_load(pull, platform_angle) / parameters.cylinder_kn
    contacts = all_contacts(dampers, parameters, largest_gap, start, cylinder_elements)
    title = f"Single blade with two dampers, {preload_mass:g} kg"
    return rig_problem(assembled(blade, dampers, modes), damping, contacts, dampers, force, title)


def single_blade_stress(
    places: Mapping[str, Place],
    *,
    platform_angle: float = 45.0,
    length: float = 222.388e-3,
    modes: int = 150,
    flat_points: int = 5,
) -> StressRecovery:
    """Stress recovery of the blade of `single_blade` at places {name: (x, y, z)} in m; geometry and modes as given there.

    Axes: x lateral, y radial from the clamped root, z depth. Linear steel without notches: at the clamped root and in the corners
    under the platform stress is singular, and grows with every refinement of the mesh.
    """
    blade = PlatformBlade(length=length, platform_angle=platform_angle)
    dampers = placed_dampers(blade, damper_shape(blade, flat_points=flat_points), STANDARD_GRAVITY)
    reduction = reduced_blade(blade, tuple(pad for damper in dampers for pad in pads(damper)), modes)
    return stress_recovery(blade.mesh(), blade.clamped(), reduction, places, "blade/", blade.material)


def contact_parameters(preload_mass: float, given: Mapping[str, float | None]) -> ContactParameters:
    """The published parameters of this preload mass with those given put in their place; all six given: any mass."""
    explicit = {key: value for key, value in given.items() if value is not None}
    published = next((p for mass, p in PUBLISHED.items() if abs(mass - preload_mass) < 1e-9), None)
    base = {} if published is None else asdict(published)
    missing = [key for key in given if key not in base and key not in explicit]
    if missing:
        raise fault(
            "preload_mass",
            "must be 2.6, 4.6 or 6.6 kg, the masses with published contact parameters",
            preload_mass,
            f"Take one of them, or give {', '.join(missing)}; nothing is interpolated.",
        )
    return ContactParameters(**(base | explicit))


def damper_shape(blade: PlatformBlade, **dimensions: Any) -> FlatCylinder:
    """The damper under a blade's platform: its flat covers two thirds of the reach, unless `dimensions` say otherwise."""
    width, slope = 2.0 / 3.0 * hypot(blade.platform_reach, blade.rise), blade.platform_angle
    return replace(FlatCylinder(width, blade.depth, left_angle=slope, right_angle=slope), **dimensions)


def placed_dampers(blade: PlatformBlade, shape: FlatCylinder, pull: float) -> tuple[Damper, Damper]:
    """The left and the right damper, each with the middle of its flat at 2/3 of the platform's reach."""
    return (
        shape.beside_blade("damper_left", blade.underside(2.0 / 3.0, 0.0, -1), -1, pull, "left"),
        shape.beside_blade("damper_right", blade.underside(2.0 / 3.0, 0.0, 1), 1, pull, "right"),
    )


def pads(damper: Damper) -> tuple[tuple[str, Place], ...]:
    """The blade's nodes opposite the flat: (name, place), "left_pad_1", ..."""
    points = np.asarray(damper.surface("flat").points)
    return tuple((f"{damper.label}_pad_{i}", (float(x), float(y), float(z))) for i, (x, y, z) in enumerate(points, start=1))


def assembled(blade: PlatformBlade, dampers: Sequence[Damper], modes: int) -> Structure:
    """Reduced blade and dampers."""
    reduction = reduced_blade(blade, tuple(pad for damper in dampers for pad in pads(damper)), modes)
    return assemble({"blade": reduction.structure} | {damper.name: damper.structure for damper in dampers})


def rig_problem(
    structure: Structure, damping: float, contacts: Sequence[Contact], dampers: Sequence[Damper], force: float, title: str
) -> Problem:
    """The rig under its shaker and the pull of its dampers, every stuck mode damped; output is the lateral motion of the tip."""
    forces = (Force("blade/force.x", force, name="shaker"), *(load for damper in dampers for load in damper.forces()))
    damped = structure.with_damping(ModalDamping(damping, on="stuck"))
    return Problem(damped, tuple(contacts), forces, ("blade/tip.x",), title)


def all_contacts(
    dampers: Sequence[Damper],
    parameters: ContactParameters,
    largest_gap: float,
    start: Start | None = None,
    cylinder_elements: int = ELEMENTS_PER_POINT,
) -> tuple[Contact, ...]:
    """Of every damper macroslip at the points of the flat against the blade; at the cylinder line, against a rigid support,
    microslip arrays of so many elements, or macroslip for one.
    """
    p = parameters

    def flat(share: float) -> Macroslip:
        return Macroslip(share * p.flat_kt, p.flat_mu, share * p.flat_kn)

    def cylinder(share: float) -> Macroslip | MicroslipArray:
        kt, kn = share * p.cylinder_kt, share * p.cylinder_kn
        if cylinder_elements == 1:
            return Macroslip(kt, p.cylinder_mu, kn)
        return MicroslipArray.from_totals(kt, kn, p.cylinder_mu, largest_gap, cylinder_elements)

    found: list[Contact] = []
    for damper in dampers:
        opposite = [node(f"blade/{name}") for name, _ in pads(damper)]
        found += damper.contacts("flat", flat, opposite, start) + damper.contacts("cylinder", cylinder, ground, start)
    return tuple(found)


DRY, OILED = 0.5, 0.2
"""Friction coefficients that stand for the dry and the oiled contacts: ours, the paper gives none."""

RADIUS, DEPTH = 8e-3, 40e-3
HALF_CYLINDER_MASS = 0.5 * pi * RADIUS**2 * DEPTH * STEEL.density

GROWTH = {"flat_kt": 0.60, "flat_kn": 0.44, "cylinder_kn": 0.075}
"""Exponents with which stiffness grows with the normal load: of a power law through the flats of 2.6 and 6.6 kg (Table 1 of the
paper on response variability), and Brändlein's for a line contact. The tangential stiffness of the line stays.
"""


def two_semi_cylinders(
    pull: float = 56.0,
    friction: float = DRY,
    *,
    platform_angle: float = 45.0,
    damper_mass: float = HALF_CYLINDER_MASS,
    stiffness_factor: float = 1.0,
    damping: float = 0.003,
    force: float = 1.0,
    gap_factor: float = 0.7,
    length: float = 240e-3,
    modes: int = 40,
    start: Start | None = None,
) -> Problem:
    """The blade, clamped at its root, with a semi-cylinder under each side of its platform; output is the tip, laterally.

    pull: static load F_C on each damper [N], published 26, 56, 206; friction: of all contacts, say DRY 0.5 or OILED 0.2;
    platform_angle [degrees]; damper_mass [kg]; stiffness_factor: on all contact stiffnesses, which follow the normal load
    F_C/(2 cos α) as `GROWTH` says; damping: ratio of every stuck mode; force: amplitude near the root along x [N]; gap_factor:
    as of `single_blade`; length of the blade [m]; modes: fixed-interface modes kept; start: one start rule for all contacts.
    """
    blade = PlatformBlade(length=length, platform_angle=platform_angle)
    offsets = {"centre_offset": RADIUS / 2.0**0.5, "cylinder_offset": RADIUS * 2.0**0.5, "radius": RADIUS}
    shape = damper_shape(blade, **offsets, depth=DEPTH, mass=damper_mass, sides=(2.0 * RADIUS, RADIUS, DEPTH))
    load = static_normal_load(positive("pull", pull), platform_angle)
    parameters, dampers = contact_stiffness(load, friction, stiffness_factor), placed_dampers(blade, shape, pull)
    contacts = all_contacts(dampers, parameters, 2.0 * gap_factor * load / parameters.cylinder_kn, start)
    title = f"Blade with two semi-cylinders, {pull:g} N, friction {friction:g}"
    return rig_problem(assembled(blade, dampers, modes), damping, contacts, dampers, force, title)


def contact_stiffness(load: float, friction: float, factor: float = 1.0) -> ContactParameters:
    """Totals of one damper at a normal load [N] on each side, scaled from those of 4.6 kg at 45 degrees."""
    mass = 4.6
    published = PUBLISHED[mass]
    share = load / (mass * STANDARD_GRAVITY / 2.0**0.5)
    mu = not_negative("friction", friction)
    positive("stiffness_factor", factor)
    grown = {name: factor * getattr(published, name) * share**exponent for name, exponent in GROWTH.items()}
    return ContactParameters(**grown, cylinder_kt=factor * published.cylinder_kt, flat_mu=mu, cylinder_mu=mu)
