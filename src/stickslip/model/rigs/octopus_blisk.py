"""The bladed disk of "On the choice of contact parameters for the forced response calculation of a bladed disk with
underplatform dampers": 24 blades, a cylinder between all neighbours, travelling-wave excitation.

The paper publishes contact parameters, the damper and stuck resonances, but no geometry. The dimensions of the sector are
this project's own, see `docs/disks.md` for what was fitted and what is predicted.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from math import cos, radians, sin
from typing import Literal

import numpy as np

from stickslip.model.contact.macroslip import Macroslip
from stickslip.model.contact.point import Contact, Direction, Motion, Start, contact_in_space, node
from stickslip.model.contact.stiffness import NORMAL_STIFFNESS, LineContact, static_normal_load
from stickslip.model.dampers.section import hull_of
from stickslip.model.disks.tuned import TunedDisk
from stickslip.model.loads import Force
from stickslip.model.rigs.blisk_sector import POINTS, BliskSector, reduced_sector, surface
from stickslip.model.structure.assembly import Spring
from stickslip.model.structure.cyclic import NEXT, with_bodies
from stickslip.model.structure.cyclic_reduction import rotation
from stickslip.model.structure.damping import ModalDamping
from stickslip.model.structure.rigid_body import RigidBody
from stickslip.support.checks import Array, fault, nearest, of_kind, positive

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
            contacts.append(contact_in_space(f"{side} edge {k}", law, body.at(place, "damper"), opposite, frame, start))
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
