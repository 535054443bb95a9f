"""Contacts at the nodes of a mesh surface, against a rigid body, another surface or the ground."""

from collections.abc import Callable, Sequence
from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from stickslip.model.contact.law import Law
from stickslip.model.contact.point import Contact, Motion, OnSurface, PatchNode, Start, contact_in_space, ground, mean
from stickslip.model.interfaces.node_surface import NodeSurface
from stickslip.support.checks import Array, Index, InputError, between, fault, of_kind, vector

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
