"""A stuck damper between two platforms: the closed forms of its stiffness by static condensation.

Two platforms at ±α, two equal contacts kt, kn. Rotation blocked: k_H = kt kn/[2(kt sin²α + kn cos²α)],
k_V = kt kn/[2(kt cos²α + kn sin²α)], no cross term. A cylinder that may roll keeps k_H and has k_V = 0.
"""

import numpy as np
import pytest
from scipy import linalg

from stickslip.model.contact.macroslip import Macroslip
from stickslip.model.contact.point import Contact, Motion, difference, node
from stickslip.model.loads import Force
from stickslip.model.problem import Problem
from stickslip.model.structure.assembly import RigidBody
from stickslip.model.structure.matrices import Structure
from stickslip.support.units import N_per_um

PLATFORMS = ("left.x", "left.y", "right.x", "right.y")
KT, KN = 56 * N_per_um, 84 * N_per_um
ANGLES = (10.0, 37.0, 45.0, 60.0)


def problem(angle: float, feet: tuple[Motion, Motion], damper_dofs: tuple[str, ...], kt: float = KT, kn: float = KN) -> Problem:
    """Platforms of 1 kg on springs of 1 N/µm, a massless damper with its left and right foot on them."""
    c, s = np.cos(np.radians(angle)), np.sin(np.radians(angle))
    frames = {"left": ((c, s), (-s, c)), "right": ((c, -s), (s, c))}
    contacts = []
    for (side, frame), foot in zip(frames.items(), feet, strict=True):
        t, n = (difference(foot(axis), node(side)(axis)) for axis in frame)
        contacts.append(Contact(side, Macroslip(kt, 0.3, kn), (t,), n))
    free = len(damper_dofs)
    M = np.diag([1.0] * 4 + [0.0] * free)
    K = N_per_um * np.diag([1.0] * 4 + [0.0] * free)
    return Problem(Structure(M, K, (*PLATFORMS, *damper_dofs)), tuple(contacts), (Force("left.x", 1.0),), ("left.x",))


def condensed(rig: Problem) -> np.ndarray:
    """Stiffness that the stuck damper adds to the platforms, (4, 4): the damper is free of load."""
    K = rig.stuck_stiffness - rig.structure.K
    return K[:4, :4] - K[:4, 4:] @ linalg.solve(K[4:, 4:], K[4:, :4])


def closed_forms(angle: float, kt: float = KT, kn: float = KN) -> tuple[float, float]:
    c2, s2 = np.cos(np.radians(angle)) ** 2, np.sin(np.radians(angle)) ** 2
    return kt * kn / (2 * (kt * s2 + kn * c2)), kt * kn / (2 * (kt * c2 + kn * s2))


@pytest.mark.parametrize("angle", ANGLES)
def test_damper_without_rotation_joins_the_platforms_by_two_springs(angle: float):
    rig = problem(angle, (node("D"), node("D")), ("D.x", "D.y"))
    springs = np.diag(closed_forms(angle))
    expected = np.block([[springs, -springs], [-springs, springs]])
    np.testing.assert_allclose(condensed(rig), expected, rtol=1e-12, atol=1e-12 * KN)


def test_published_example():
    """kt 56, kn 84 N/µm at 37 degrees (independent script of this project)."""
    stiffness = condensed(problem(37.0, (node("D"), node("D")), ("D.x", "D.y"))) / N_per_um
    assert stiffness[0, 0] == pytest.approx(31.8444936, rel=1e-8)
    assert stiffness[1, 1] == pytest.approx(35.5603523, rel=1e-8)


@pytest.mark.parametrize("angle", ANGLES)
def test_a_cylinder_that_rolls_keeps_the_horizontal_stiffness_only(angle: float):
    c, s, radius = np.cos(np.radians(angle)), np.sin(np.radians(angle)), 5e-3
    body = RigidBody(1.0, np.eye(3), node="D")
    places = (body.at((side * radius * s, radius * c, 0.0)) for side in (-1.0, 1.0))
    feet = tuple(lambda axis, place=place: place((*axis, 0.0)) for place in places)
    springs = np.diag([closed_forms(angle)[0], 0.0])
    expected = np.block([[springs, -springs], [-springs, springs]])
    np.testing.assert_allclose(condensed(problem(angle, feet, ("D.x", "D.y", "D.rz"))), expected, atol=1e-10 * KN)


@pytest.mark.parametrize("angle", ANGLES)
def test_frequencies_with_a_massless_damper(angle: float):
    """Platforms in opposition feel twice each spring, in unison none; a singular M is no obstacle."""
    rig = problem(angle, (node("D"), node("D")), ("D.x", "D.y"))
    squares = np.sort([1e6, 1e6, *(1e6 + 2 * k for k in closed_forms(angle))])
    np.testing.assert_allclose(rig.frequencies(stuck=True), np.sqrt(squares) / (2 * np.pi), rtol=1e-9)
    np.testing.assert_allclose(rig.frequencies(stuck=False), np.full(4, 1e3 / (2 * np.pi)), rtol=1e-9)
