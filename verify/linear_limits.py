"""The linear limits of frictional problems: stuck, without friction, and the stiffness of a stuck damper."""

from __future__ import annotations

from collections.abc import Iterator
from math import cos, radians, sin

import numpy as np

from stickslip.analyses.forced_response import forced_response
from stickslip.model.contact.macroslip import Macroslip
from stickslip.model.contact.point import Contact
from stickslip.model.loads import Force
from stickslip.model.problem import Problem
from stickslip.model.rigs import chain, chain_of_three, single_blade, single_mass
from stickslip.model.structure.matrices import Structure
from stickslip.support.units import Band, hertz
from verify.row import CLOSED, INDEPENDENT, Row, at_most, relative

TITLE = "Linear limits"
ABOUT = (
    "Small forces leave every contact stuck: the curve is the linear response with the contact springs. Without "
    "friction it is the response without contacts. A stuck damper between platforms at 37 degrees (kt 56, kn 84 N/µm) "
    "is two springs."
)


def linear(problem: Problem, stiffness: np.ndarray, frequency: float) -> np.ndarray:
    """|X_1| of the outputs, dense complex solution."""
    omega, load = 2.0 * np.pi * frequency, problem.load(1) - problem.load(1, 0.0)
    dynamic = stiffness + 1j * omega * problem.C - omega**2 * problem.structure.M
    return np.abs(problem.output_rows @ np.linalg.solve(dynamic, load[:, 1] - 1j * load[:, 2]))


def deviation(problem: Problem, reference: Problem, stiffness: np.ndarray, band: Band, level: float) -> float:
    """Largest deviation of a curve from a linear one, relative to the highest amplitude."""
    dataset = forced_response(problem, band, level, harmonics=3).dataset
    expected = np.array([level * linear(reference, stiffness, float(f)) for f in dataset.frequency[0]])
    return float(np.max(np.abs(dataset.amplitude[0] - expected)) / expected.max())


def stuck_damper() -> tuple[float, float]:
    """k_H and k_V of a massless damper free in x and y, rotation blocked."""
    c, s = cos(radians(37.0)), sin(radians(37.0))
    law = Macroslip(56e6, 0.3, 84e6)
    left = Contact("L", law, ({"D.x": c, "D.y": s, "L.x": -c, "L.y": -s},), {"D.x": -s, "D.y": c, "L.x": s, "L.y": -c})
    right = Contact("R", law, ({"D.x": c, "D.y": -s},), {"D.x": s, "D.y": c})
    structure = Structure(np.diag([1.0, 1.0, 0, 0]), np.zeros((4, 4)), ("L.x", "L.y", "D.x", "D.y"))
    K = Problem(structure, (left, right), (Force("L.x", 1.0),), ("L.x",)).stuck_stiffness
    condensed = K[:2, :2] - K[:2, 2:] @ np.linalg.solve(K[2:, 2:], K[2:, :2])
    return float(condensed[0, 0]), float(condensed[1, 1])


def rows() -> Iterator[Row]:
    cases = {
        "one mass": (single_mass(), (0.1, 0.3)),
        "three masses": (chain_of_three(), (0.1, 0.3)),
        "twenty masses": (chain(), (0.02, 0.06)),
    }
    for name, (problem, ends) in cases.items():
        stuck = deviation(problem, problem, problem.stuck_stiffness, hertz(*ends), 1e-4)
        yield at_most(f"Stuck curve of {name}: deviation from the linear response", stuck, 1e-10, CLOSED)
        smooth = problem.with_contacts(lambda c: c.with_law(Macroslip(c.law.kt, 0.0, normal_load=1.0)))  # type: ignore[attr-defined]
        free = deviation(smooth, problem, problem.structure.K, hertz(*ends), 1.0)
        yield at_most(f"Curve of {name} without friction: deviation from the linear response", free, 1e-8, CLOSED)
    blade = single_blade(4.6, gap_factor=0.0)
    stuck = deviation(blade, blade, blade.stuck_stiffness, hertz(480.0, 600.0), 1e-3)
    yield at_most("Stuck curve of the single blade without gaps: deviation from the linear response", stuck, 1e-9, CLOSED)
    horizontal, vertical = stuck_damper()
    yield relative("Stuck damper: k_H, N/m", horizontal, 31.8444936e6, 1e-8, INDEPENDENT)
    yield relative("Stuck damper: k_V, N/m", vertical, 35.5603523e6, 1e-8, INDEPENDENT)
