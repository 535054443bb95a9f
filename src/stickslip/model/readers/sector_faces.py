"""Pairs of nodes on the two faces of a sector by their coordinates, why they do not match, and interpolation between them."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np
import scipy
from scipy import sparse

from stickslip.model.structure.cyclic_reduction import MATCH, Sector, lowest_frequencies, partners, sector_of, spacing
from stickslip.model.structure.solid import Solid
from stickslip.support.checks import Array, Index, InputError, counted, fault

if TYPE_CHECKING:
    from stickslip.model.readers.sector import Faces

ON_AXIS = 1e-6
"""Distance from the axis, relative to that of the farthest node of a face, at which a node is its own neighbour."""
COMPARED = 4
"""Frequencies of a nodal diameter by which an interpolation is judged."""
NEIGHBOURS = 12
"""Nodes between which a displacement is interpolated: twice the six coefficients of a quadratic polynomial."""
OFF = 0.25
"""How far a node may lie off the surface of the other face, relative to the distance of the nodes there."""


def paired(solid: Solid, faces: Faces, low: Index, high: Index) -> Sector:
    """The sector with the nodes of its faces paired, or interpolated."""
    for name, nodes in ((faces.low, low), (faces.high, high)):
        away = faces.axis.distances(solid.points[nodes])
        if not nodes.size or away.min() <= ON_AXIS * away.max():
            what = "on the axis" if nodes.size else "empty"
            raise fault(f"The face {name}", "must have nodes, all of them off the axis", what, "Cut a hole at the axis.")
    common = np.intersect1d(low, high)
    if common.size:
        what, remedy = f"The faces {faces.low} and {faces.high}", "Leave these nodes out of one of the sets."
        remedy = "low and high are one set." if faces.low == faces.high else remedy
        raise fault(what, "must have no node in common", counted(common.size, "node"), remedy)
    if faces.interpolated:
        return _interpolated(solid, faces, low, high)
    if low.size != high.size:
        raise InputError(
            f"The faces of the sector must have the same number of nodes, but {faces.low} has {low.size} and {faces.high} "
            f'{high.size}. Mesh both faces alike, or write faces = "interpolated" (in Python: interpolated=True).'
        )
    try:
        return sector_of(solid, faces.sectors, low, high, faces.axis)
    except InputError as error:
        raise _reason(solid.points, faces, low, high) or error from None


def _reason(points: Array, faces: Faces, low: Index, high: Index) -> InputError | None:
    """Why the faces do not match: exchanged, or of another number of sectors."""
    limit = MATCH * spacing(points[high])

    def match(sectors: int, steps: int) -> bool:
        return bool(partners(points, low, high, faces.axis, sectors, steps)[0].max() <= limit)

    what = f"The face {faces.high} must be {faces.low} turned by 360°/{faces.sectors} about the axis"
    if match(faces.sectors, -1):
        return InputError(
            f"{what}, but is turned by −360°/{faces.sectors}. Exchange low and high, or reverse the direction of the axis."
        )
    middles = [np.exp(1j * faces.axis.angles(points[side])) * faces.axis.distances(points[side]) for side in (low, high)]
    angle = float(np.angle(middles[1].sum() / middles[0].sum()))
    fits = round(2.0 * np.pi / abs(angle)) if angle else 0
    if fits >= 2 and match(fits, 1 if angle > 0.0 else -1):
        exchanged = "" if angle > 0.0 else ", with low and high exchanged"
        return InputError(f"{what}, but they match for sectors = {fits}{exchanged}. Check sectors and the axis.")
    distances = partners(points, low, high, faces.axis, faces.sectors)[0]
    lonely = int(np.sum(distances > limit))
    return InputError(
        f"{what}, to {1e3 * limit:.2g} mm, but {counted(lonely, 'node')} of {low.size} have no partner, the farthest "
        f"{1e3 * distances.max():.3g} mm away. The middles of the faces are {np.degrees(angle):.4g}° apart. Check the axis, mesh "
        'both faces alike, or write faces = "interpolated" (in Python: interpolated=True).'
    )


def interpolation_error(sector: Sector) -> float:
    """The largest relative change of the four lowest frequencies of nodal diameters 0 and N/2 if the other face follows.

    The right face, with more nodes, follows more closely; so this is an upper estimate of the error of the interpolation.
    """
    weights, _ = _weights(
        sector.axis.turned(sector.solid.points[sector.right], sector.sectors, 1 if sector.mirrored else -1),
        sector.solid.points[sector.left],
    )
    other = replace(sector, left=sector.right, right=sector.left, weights=weights, mirrored=not sector.mirrored)
    waves = (0, sector.sectors // 2)
    own, exchanged = (np.array([lowest_frequencies(each, n, COMPARED) for n in waves]) for each in (sector, other))
    return float(np.abs(exchanged / own - 1.0).max())


def _interpolated(solid: Solid, faces: Faces, low: Index, high: Index) -> Sector:
    """The face with more nodes follows the other, whose nodes carry a quadratic polynomial around each of its nodes."""
    mirrored = low.size > high.size
    left, right = (high, low) if mirrored else (low, high)
    turned = faces.axis.turned(solid.points[left], faces.sectors, -1 if mirrored else 1)
    weights, apart = _weights(turned, solid.points[right])
    distance = float(np.median(np.asarray(scipy.spatial.KDTree(turned).query(turned, k=2)[0])[:, 1]))
    away = float(np.max(scipy.spatial.KDTree(turned).query(solid.points[right])[0]))
    # A point between nodes is nearer to one of them than the widest distance of a node from the third of its neighbours.
    widest = float(np.max(np.asarray(scipy.spatial.KDTree(turned).query(turned, k=min(4, len(turned)))[0])[:, -1]))
    if apart > OFF * distance or away > widest:
        raise fault(
            f"The face {faces.high}",
            f"must lie on {faces.low} turned by 360°/{faces.sectors} about the axis",
            f"up to {1e3 * max(apart, away):.3g} mm away, where its nodes are {1e3 * distance:.3g} mm apart",
            "Check N, the axis, and which face is low.",
        )
    return Sector(solid, faces.sectors, left, right, faces.axis, weights, mirrored, apart)


def _weights(nodes: Array, points: Array) -> tuple[sparse.csr_array, float]:
    """Weights (points, nodes) of a displacement at points from those at nodes, and the largest distance [m] of a point from the
    surface through the nodes.

    Moving least squares: a quadratic polynomial in the tangent plane of the nearest nodes, weighted by exp(−(d/s)²), d the
    distance and s that of the middle one. Linear fields, and with them rigid motions, are exact. (Lancaster and Salkauskas 1981.)
    """
    number = min(NEIGHBOURS, len(nodes))
    distances, nearest = scipy.spatial.KDTree(nodes).query(points, k=number)
    distances, nearest = np.reshape(distances, (-1, number)), np.reshape(nearest, (-1, number))
    shares, apart = np.zeros((len(points), number)), 0.0
    for k, (point, away, around) in enumerate(zip(points, distances, nearest, strict=True)):
        scale = float(away[number // 2]) or 1.0
        if away[0] <= MATCH * scale:
            shares[k, 0] = 1.0
            continue
        centre = nodes[around].mean(axis=0)
        axes = np.linalg.svd(nodes[around] - centre)[2]
        x, y, height = ((nodes[around] - point) @ axes.T / scale).T
        weight = np.exp(-0.5 * (away / scale) ** 2)
        polynomial = np.column_stack([np.ones(number), x, y, x * x, x * y, y * y])
        inverse = np.linalg.pinv(weight[:, None] * polynomial, rcond=1e-8)
        shares[k] = inverse[0] * weight
        apart = max(apart, abs(float(shares[k] @ height)) * scale)
    rows = np.repeat(np.arange(len(points)), number)
    return sparse.csr_array((shares.ravel(), (rows, nearest.ravel())), shape=(len(points), len(nodes))), apart
