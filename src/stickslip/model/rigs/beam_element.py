"""The straight Euler-Bernoulli beam element of rigs that are made of beams, and closed rings of such elements."""

from __future__ import annotations

from math import cos, pi, sin

import numpy as np

from stickslip.model.structure.cyclic import CyclicStructure, sector_chain
from stickslip.model.structure.matrices import Structure
from stickslip.support.checks import Array


def beam_stiffness(length: float, EA: float, EI: float) -> Array:
    """K of an element, (6, 6): motion along it, across it and rotation φ = dw/dx at either end; EA [N], EI [N m²]."""
    K = np.zeros((6, 6))
    K[np.ix_([0, 3], [0, 3])] = EA / length * np.array([[1.0, -1.0], [-1.0, 1.0]])
    L = length
    bending = [
        [12, 6 * L, -12, 6 * L],
        [6 * L, 4 * L**2, -6 * L, 2 * L**2],
        [-12, -6 * L, 12, -6 * L],
        [6 * L, 2 * L**2, -6 * L, 4 * L**2],
    ]
    K[np.ix_([1, 2, 4, 5], [1, 2, 4, 5])] = EI / L**3 * np.array(bending)
    return K


def beam_mass(length: float, mass: float) -> Array:
    """Consistent M of an element across its axis, (4, 4): motion and rotation at either end; mass [kg]."""
    L = length
    rows = [
        [156, 22 * L, 54, -13 * L],
        [22 * L, 4 * L**2, 13 * L, -3 * L**2],
        [54, 13 * L, 156, -22 * L],
        [-13 * L, -3 * L**2, -22 * L, 4 * L**2],
    ]
    return mass / 420.0 * np.array(rows)


def ring_of_beams(node: str, points: int, radius: float, EA: float, EI: float, masses: Array) -> CyclicStructure:
    """A polygon of beam elements between `points` nodes on a circle: one node NODE.r (out), NODE.t (along), NODE.rz a sector.

    masses (3,): mass for r and t and inertia for rz of a node. rz is dw/ds, w along r and s along t: a point at a distance e
    inside the circle moves by t + e rz along it.
    """
    half = pi / points
    element = beam_stiffness(2.0 * radius * sin(half), EA, EI)
    c, s = cos(half), sin(half)
    near = np.array([[-s, c, 0.0], [c, s, 0.0], [0.0, 0.0, 1.0]])
    far = np.array([[s, c, 0.0], [c, -s, 0.0], [0.0, 0.0, 1.0]])
    own = near.T @ element[:3, :3] @ near + far.T @ element[3:, 3:] @ far
    sector = Structure(np.diag(masses), own, tuple(f"{node}.{direction}" for direction in ("r", "t", "rz")))
    return sector_chain(sector, points, near.T @ element[:3, 3:] @ far)
