"""Patches of a contact surface: points with areas divided into parts of about equal area, compact in space.

Recursive bisection: the points are halved across the direction in which they spread furthest, then each half, and so on. Each
cut is placed by area, so that the areas of patches differ by what a node of the mesh carries, and is straight, so that patches
are about as wide as long. (Clusters around centres, k-means, are rounder, but their areas differ by a factor of two and they
depend on where the centres begin.) Points lie in the plane that fits the surface best, whose axes turn with the surface, and
count with their areas in space: gently curved surfaces are divided as flat ones.
Source: M. J. Berger, S. H. Bokhari, IEEE Trans. Comput. C-36 (1987) 570-580.
"""

from __future__ import annotations

import numpy as np

from stickslip.checks import Array, Index

ALIKE = 1e-6
"""Relative difference up to which two spreads, or two places relative to the size, are equal: rounding chooses nothing."""


def bisected(places: Array, areas: Array, count: int) -> list[Index]:
    """Indices of points, part by part; places (n, 2), areas (n,), 1 <= count <= n. Every part has at least one point."""
    step = ALIKE * float(np.ptp(places, axis=0).max(initial=0.0)) or 1.0
    return _parts(np.round(places / step), areas, np.arange(len(places)), count)


def _parts(places: Array, areas: Array, points: Index, count: int) -> list[Index]:
    if count == 1:
        return [np.sort(points)]
    own = areas[points]
    away = places[points] - np.average(places[points], axis=0, weights=own)
    first_spread, second_spread = np.average(away**2, axis=0, weights=own)
    along = 1 if second_spread > (1.0 + ALIKE) * first_spread else 0
    ordered = points[np.lexsort((places[points, 1 - along], places[points, along]))]
    first = count // 2
    shares = np.cumsum(areas[ordered])[first - 1 : len(points) - (count - first)] / own.sum()
    cut = first + int(np.argmin(np.round(np.abs(shares - first / count) / ALIKE)))
    return [*_parts(places, areas, ordered[:cut], first), *_parts(places, areas, ordered[cut:], count - first)]
