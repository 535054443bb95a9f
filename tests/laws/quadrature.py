"""Brute force: harmonics of a normal force by Gauss quadrature between the roots of k z + c.

Nothing here is shared with the package: it referees the compiled kernels.
"""

from __future__ import annotations

import itertools

import numpy as np
from laws.samples import Element

NODES, WEIGHTS = np.polynomial.legendre.leggauss(60)


def functions(angles: np.ndarray, size: int) -> np.ndarray:
    """1, cos θ, sin θ, cos 2θ, ... (angles, size)."""
    order = np.arange(1, (size + 1) // 2)
    found = np.ones((angles.size, size))
    found[:, 1::2], found[:, 2::2] = np.cos(np.outer(angles, order)), np.sin(np.outer(angles, order))
    return found


def passages(w: np.ndarray, level: float) -> np.ndarray:
    """Angles at which a series w (2H+1,) passes a level: roots on the unit circle of its polynomial in e^{iθ}."""
    half = (w[1::2] - 1j * w[2::2]) / 2.0
    roots = np.roots(np.concatenate([half[::-1], [w[0] - level], half.conj()]))
    return np.sort(np.angle(roots[np.abs(np.abs(roots) - 1.0) < 1e-7]) % (2.0 * np.pi))


def normal_harmonics(element: Element, w: np.ndarray) -> np.ndarray:
    """Harmonics (2H+1,) of the normal force of an element for normal motion w (2H+1,)."""
    ends = np.concatenate([[0.0], passages(w, element.gap - element.preload / element.kn), [2.0 * np.pi]])
    found = np.zeros(w.size)
    for first, last in itertools.pairwise(ends):
        angles = 0.5 * (first + last) + 0.5 * (last - first) * NODES
        basis = functions(angles, w.size)
        found += 0.5 * (last - first) * (WEIGHTS * element.normal(basis @ w)) @ basis
    found /= np.pi
    found[0] /= 2.0
    return found
