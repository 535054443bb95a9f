"""Contacts at the nodes of a mesh surface, against a rigid body, another surface or the ground."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from stickslip.checks import Array, InputError, fault, of_kind, vector
from stickslip.contact.law import Law
from stickslip.contact.point import Contact, Motion, contact_in_space, ground, node
from stickslip.contact.start import Start
from stickslip.interfaces.node_surface import NodeSurface

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
) -> tuple[Contact, ...]:
    """One contact at each node of a surface, named "NAME NODE": w = frame (u_node - u_opposite), frame rows t1, t2, n.

    law: that of the whole surface; its stiffnesses and loads (kt, kn, preload, normal_load) are shared over the nodes by area
    (`Law.share`). n is the normal of each node, t1 the direction `tangent` (x, y, z) as far as it lies in the surface; unless
    given, that in which the surface is longest. start, balanced: of every contact, as of `Contact`. mesh_gap: the distance of a
    node from the surface opposite, along its normal, adds to the gap of the law; where meshes overlap it is an interference.

    Meshes need not match: what lies opposite a node is interpolated between the three nodes around it. A node that has nothing
    opposite gets no contact, and the others share what the law says by their areas in the whole surface.
    """
    of_kind("law", law, Law)  # type: ignore[type-abstract]
    of_kind("surface", surface, NodeSurface)
    given: object = against
    if not (given is None or isinstance(given, NodeSurface) or callable(given)):
        remedy = 'Of a rigid body give `lambda point: body.at(point, "NAME")`, NAME as in `assemble`.'
        raise fault("against", "must be a NodeSurface, the motion of a point, or None", type(given).__name__, remedy)
    if mesh_gap and not (isinstance(against, NodeSurface) and law.has_normal and hasattr(law, "gap")):
        raise fault("mesh_gap", "must go with a surface opposite and a law that has a gap and kn", type(law).__name__)
    along = surface.long_axis if tangent is None else vector("tangent", tangent, 3)
    contacts = []
    for each, point, normal, weight in zip(surface.nodes, surface.points, surface.normals, surface.weights, strict=True):
        opposite = _opposite(against, point)
        if opposite is None:
            continue
        title = f"{name} {each.rpartition('/')[2]}"
        own = law.share(float(weight))
        if mesh_gap and isinstance(against, NodeSurface):
            own = _with_gap(own, against.gap(point.tolist(), normal.tolist()))
        contact = contact_in_space(title, own, node(each), opposite, _frame(name, normal, along), start)
        contacts.append(replace(contact, balanced=balanced))
    if not contacts:
        raise InputError(f"Surface {surface.name!r} must touch what lies opposite, but none of its nodes does.")
    if len({contact.name for contact in contacts}) < len(contacts):
        contacts = [replace(contact, name=f"{name} {number}") for number, contact in enumerate(contacts, start=1)]
    return tuple(contacts)


def _with_gap(law: Law, distance: float) -> Law:
    """The law with a distance added to its gap."""
    whole: Any = law
    apart: Law = replace(whole, gap=whole.gap + distance)
    return apart


def _opposite(against: Opposite, point: Array) -> Motion | None:
    if against is None:
        return ground
    return against.at(point.tolist()) if isinstance(against, NodeSurface) else against(point)


def _frame(name: str, normal: Array, along: Array) -> Array:
    """Rows t1, t2, n."""
    t1 = along - (along @ normal) * normal
    size = float(np.linalg.norm(t1))
    if size < 1e-3 * float(np.linalg.norm(along)) or not size:
        raise fault(f"The tangent of {name}", "must be a direction that is not the normal", along.tolist())
    return np.stack([t1 / size, np.cross(normal, t1 / size), normal])
