"""Patches of a contact surface: points with areas divided into parts of about equal area, compact in space.

Recursive inertial bisection: the points are halved across the direction in which they spread furthest, then each half, and so on.
Each cut is straight and placed by area, so that the areas of patches differ by what a node of the mesh carries and patches are
about as wide as long. Clusters around centres (k-means) are rounder, but their areas differ by a factor of two and they depend on
where the centres begin. Points lie in the plane that fits the surface best and count with their areas in space, so that gently
curved surfaces are divided as flat ones. Source: H. D. Simon, Comput. Syst. Eng. 2 (1991) 135-148.
"""

from __future__ import annotations

import numpy as np

from stickslip.support.checks import Array, Index

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
