"""The benchmark problems as numbers, plain NumPy: both sides build their own model from these, so neither can differ.

B1: one mass with a Jenkins slider to ground. B2a: chain of 20 masses, sliders of constant load at masses 11 to 20.
B2b: the same chain with a second direction y that loads and unloads friction; y is counted from the preloaded state.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

HARMONICS = 7
SAMPLES = 256


@dataclass(frozen=True)
class Case:
    """A sweep: problem, force level, band in rad/s, number of degrees of freedom and of contacts."""

    name: str
    problem: str
    level: float
    band: tuple[float, float]
    size: int
    contacts: int


CASES = (
    *(Case(f"B1 F={level:g}", "B1", level, (0.5, 2.0), 1, 1) for level in (0.1, 0.5, 1.0, 2.0)),
    Case("B2a", "B2a", 1.0, (0.05, 0.35), 20, 10),
    Case("B2b", "B2b", 1.0, (0.18, 0.30), 40, 10),
)

BY_NAME = {case.name: case for case in CASES}

MASSES = 20
TOUCHING = tuple(range(11, 21))
FORCED = 10

SINGLE_MASS = {"m": 1.0, "k": 1.0, "c": 0.02, "kt": 1.0, "limit": 1.0}
CHAIN = {"kt": 0.5, "limit": 1.0}
VARYING = {"kt": 0.5, "kn": 1.0, "mu": 0.5, "preload": 2.0}
STIFFNESS_DAMPING = 0.01


def chain_stiffness() -> np.ndarray:
    """Unit springs from ground to mass 1 and from mass to mass, the last mass free, (20, 20)."""
    K = 2.0 * np.eye(MASSES) - np.eye(MASSES, k=1) - np.eye(MASSES, k=-1)
    K[-1, -1] = 1.0
    return K


def planar_chain_stiffness() -> np.ndarray:
    """The chain in x and in y, every mass also grounded by a unit spring in y; order x1, y1, x2, y2, ..., (40, 40)."""
    return np.kron(chain_stiffness(), np.eye(2)) + np.kron(np.eye(MASSES), np.diag([0.0, 1.0]))
