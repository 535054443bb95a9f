"""A blade in its dovetail: two flanks with contact points along them, pressed on by the centrifugal load."""

from __future__ import annotations

from math import cos, radians, sin

import numpy as np

from stickslip.model.contact.friction import Friction
from stickslip.model.contact.macroslip import Macroslip
from stickslip.model.contact.point import Contact, SliderOffset, Start
from stickslip.model.loads import Force
from stickslip.model.problem import Problem
from stickslip.model.rigs.beam_element import beam_mass, beam_stiffness
from stickslip.model.structure.damping import RayleighDamping
from stickslip.model.structure.matrices import Structure
from stickslip.model.structure.modes import natural_modes
from stickslip.support.checks import between, fault, finite, positive

ELEMENTS = 6
"""Along the blade."""
MOST_POINTS = 1000
"""Along a flank."""


def blade_root(
    pull: float = 5e3,
    flank_angle: float = 45.0,
    mu: Friction = 0.3,
    *,
    points: int = 8,
    kt: float = 8e8,
    kn: float = 1e9,
    length: float = 0.2,
    width: float = 0.04,
    thickness: float = 6e-3,
    neck: float = 0.012,
    flank_depth: float = 0.01,
    flank_length: float = 8e-3,
    root_mass: float = 0.08,
    youngs_modulus: float = 2.1e11,
    density: float = 7850.0,
    damping: float = 1e-3,
    force: float = 1.0,
    start: Start | None = None,
) -> Problem:
    """A blade that bends in the plane (x along the circumference, y outwards), its rigid root between two flanks of a rigid disk.

    pull F [N]: centrifugal load of blade and root, along y; it goes with Ω² (`speed_sweep` of the rig at two speeds), the
    stiffening of the blade by it is left out. flank_angle a [degrees]: of the normal of a flank from y, so that each flank bears
    N = F/(2 cos a) without friction and F/(2 (cos a + μ sin a)) where it slips outwards. mu, kt, kn [N/m]: of each flank, shared
    over `points` contacts along it, at least two, since the root could roll on one. length, width (out of the plane), thickness
    [m] of the blade; the flanks begin at ± neck/2, flank_depth below the foot of the blade, and are flank_length long [m];
    root_mass [kg]; youngs_modulus [Pa]; density [kg/m³];
    damping: ratio of the first mode of the clamped blade, C = b K of the blade; force: cosine on the tip along x [N]; start: of
    the friction, virgin unless given.
    """
    if not 0.0 < finite("flank_angle", flank_angle) < 90.0:
        raise fault("flank_angle", "must lie between 0 and 90 degrees", flank_angle)
    points = between("points", points, 2, MOST_POINTS)
    c, s = cos(radians(flank_angle)), sin(radians(flank_angle))
    M, K, nodes = _blade(length, width, thickness, youngs_modulus, density)
    b = 2.0 * positive("damping", damping) / float(np.sqrt(natural_modes(M[3:, 3:], K[3:, 3:]).squares[0]))
    deep = positive("flank_depth", flank_depth) + positive("flank_length", flank_length) * s
    root = positive("root_mass", root_mass)
    middle = np.array([1.0, 0.0, 0.5 * deep])  # x of the middle of the root by root.x, root.y, root.rz
    M[:3, :3] += root * np.outer(middle, middle)
    M[1, 1] += root
    M[2, 2] += root * ((positive("neck", neck) + 2.0 * flank_length * c) ** 2 + deep**2) / 12.0
    dofs = ("root.x", "root.y", "root.rz", *(f"{node}.{name}" for node in nodes for name in ("x", "rz")))
    structure = Structure(M, K, dofs, damping=RayleighDamping(0.0, b))
    law = Macroslip(kt, mu, kn).share(1.0 / points)
    contacts = tuple(
        Contact(f"{name} {k + 1}", law, (_at(place, (side * c, -s)),), _at(place, (side * s, c)), start or SliderOffset())
        for name, side in (("left", -1.0), ("right", 1.0))
        for k in range(points)
        for way in [(k + 0.5) / points * flank_length]
        for place in [(side * (0.5 * neck + way * c), -flank_depth - way * s)]
    )
    loads = (Force("tip.x", force), Force("root.y", static=positive("pull", pull), name="centrifugal load"))
    return Problem(structure, contacts, loads, ("tip.x",), f"Blade root, {pull:g} N, {flank_angle:g} degrees")


def _at(place: tuple[float, float], direction: tuple[float, float]) -> dict[str, float]:
    """The motion along a direction of a place (x, y) on the root, which turns about the foot of the blade."""
    x, y = direction
    return {"root.x": x, "root.y": y, "root.rz": place[0] * y - place[1] * x}


def _blade(
    length: float, width: float, thickness: float, youngs_modulus: float, density: float
) -> tuple[np.ndarray, np.ndarray, list[str]]:
    """M, K and nodes of a blade on root.x, root.y, root.rz: it bends along x and moves along y as a rigid body."""
    L = positive("length", length) / ELEMENTS
    area = positive("width", width) * positive("thickness", thickness)
    EI, mass = positive("youngs_modulus", youngs_modulus) * area * thickness**2 / 12.0, positive("density", density) * area * L
    size = 2 * (ELEMENTS + 1) + 1
    M, K = np.zeros((size, size)), np.zeros((size, size))
    place = [0, 2, *range(3, size)]
    turn = np.diag([1.0, -1.0, 1.0, -1.0])  # x falls with y where the blade turns by rz
    for element in range(ELEMENTS):
        rows = np.ix_(*[place[2 * element : 2 * element + 4]] * 2)
        K[rows] += turn @ beam_stiffness(L, 0.0, EI)[np.ix_([1, 2, 4, 5], [1, 2, 4, 5])] @ turn
        M[rows] += turn @ beam_mass(L, mass) @ turn
    M[1, 1] = ELEMENTS * mass
    return M, K, [*(f"node_{k}" for k in range(1, ELEMENTS)), "tip"]
