"""Stress at the nodes of finite elements of other programs, per displacement of their nodes, as CalculiX gives it.

Stress is computed at the integration points of the element and extrapolated to its corners; a node in the middle of an edge has
the mean of the two corners. (CalculiX CrunchiX User's Manual, chapters Element types and Shape functions.)
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache
from typing import Any

import numpy as np

from stickslip.model.structure.solid import Material
from stickslip.support.checks import Array, fault
from stickslip.support.late import skfem

SMALLEST_VOLUME = 1e-12
"""Determinant of the Jacobian, relative to the size of the element cubed, below which it counts as turned inside out."""
NEAR = 0.25 - 0.05 * np.sqrt(5.0)
"""The three lesser coordinates, from 0 to 1, of the four integration points of a tetrahedron."""

TETRAHEDRON = np.vstack([np.zeros(3), np.eye(3)])
TETRAHEDRON_EDGES = ((0, 1), (1, 2), (2, 0), (0, 3), (1, 3), (2, 3))
BRICK = np.array([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0], [0, 0, 1], [1, 0, 1], [1, 1, 1], [0, 1, 1]], dtype=float)
BRICK_EDGES = ((0, 1), (1, 2), (2, 3), (3, 0), (4, 5), (5, 6), (6, 7), (7, 4), (0, 4), (1, 5), (2, 6), (3, 7))
"""Local coordinates of corners, and the corners of each edge in the order in which decks list the nodes in the middle."""
KINDS = {"C3D4": 4, "C3D8": 8, "C3D10": 10, "C3D20R": 20}
"""Elements whose stress is recovered, by name in CalculiX and Abaqus, and the number of their nodes."""


@dataclass(frozen=True, eq=False)
class Element:
    """gradients (points, nodes, 3): of the shape functions at the integration points, by local coordinates; extrapolation (nodes,
    points): from the integration points to the nodes.
    """

    gradients: Array
    extrapolation: Array


@cache
def element(kind: str) -> Element:
    """The element of one of `KINDS`."""
    if kind not in KINDS:
        remedy = "Choose another place, or model this region with one of them."
        raise fault("An element at a place of stress", f"must be one of {', '.join(KINDS)}", kind, remedy)
    if kind.startswith("C3D4"):
        return _element(skfem.ElementTetP1(), TETRAHEDRON, (), np.full((1, 3), 0.25))
    if kind == "C3D10":
        points = NEAR + (1.0 - 4.0 * NEAR) * TETRAHEDRON
        return _element(skfem.ElementTetP2(), TETRAHEDRON, TETRAHEDRON_EDGES, points)
    points = 0.5 + (BRICK - 0.5) / np.sqrt(3.0)
    if kind == "C3D8":
        return _element(skfem.ElementHex1(), BRICK, (), points)
    return _element(skfem.ElementHexS2(), BRICK, BRICK_EDGES, points)


def _element(shape: Any, corners: Array, edges: tuple[tuple[int, int], ...], points: Array) -> Element:
    ends = np.array([*((k, k) for k in range(len(corners))), *edges])
    nodes = corners[ends].mean(axis=1)
    order = [int(np.linalg.norm(shape.doflocs - node, axis=1).argmin()) for node in nodes]
    gradients = np.array([shape.lbasis(points.T, k)[1].T for k in order]).swapaxes(0, 1)
    to_corners = _polynomial(corners, len(points)) @ np.linalg.inv(_polynomial(points, len(points)))
    return Element(gradients, to_corners[ends].mean(axis=1))


def _polynomial(at: Array, terms: int) -> Array:
    """The terms of the polynomial through 1, 4 or 8 integration points, (places, terms): constant, linear or trilinear."""
    x, y, z = at.T
    return np.column_stack([np.ones(len(at)), x, y, z, x * y, y * z, z * x, x * y * z])[:, :terms]


def nodal_stress(kind: str, points: Array, material: Material) -> Array:
    """Stress at the nodes of one element per displacement of its nodes, (nodes, 6, nodes, 3) [Pa/m]: xx, yy, zz, xy, yz, zx.

    kind: one of `KINDS`; points (nodes, 3) in the order of the deck, m.
    """
    own = element(kind)
    jacobian = np.einsum("pnl,nx->plx", own.gradients, points)
    if not np.linalg.det(jacobian).min() > SMALLEST_VOLUME * float(np.ptp(points, axis=0).max()) ** 3:
        raise fault("An element at a place of stress", "must have a volume", f"a {kind} that is turned inside out")
    slopes = np.linalg.solve(jacobian, own.gradients.swapaxes(1, 2))  # (points, axis, nodes): of the shape functions, 1/m
    lam, shear = material.lame
    stress = np.zeros((len(slopes), 6, len(points), 3))
    for axis in range(3):
        stress[:, :3, :, axis] += lam * slopes[:, None, axis]
        stress[:, axis, :, axis] += 2.0 * shear * slopes[:, axis]
    for component, (one, other) in enumerate(((0, 1), (1, 2), (2, 0)), start=3):
        stress[:, component, :, one] += shear * slopes[:, other]
        stress[:, component, :, other] += shear * slopes[:, one]
    return np.asarray(np.einsum("np,pcmx->ncmx", own.extrapolation, stress))
