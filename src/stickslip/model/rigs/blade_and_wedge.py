"""One blade mode with a wedge damper between its platform and a fixed one: the smallest rig for damper design."""

from __future__ import annotations

from math import cos, radians, sin

import numpy as np

from stickslip.model.contact.macroslip import Macroslip
from stickslip.model.contact.point import Contact
from stickslip.model.dampers.wedge import wedge_outline
from stickslip.model.loads import Force
from stickslip.model.problem import Problem
from stickslip.model.structure.damping import ModalDamping
from stickslip.model.structure.matrices import Structure
from stickslip.support.checks import fault, finite, positive


def blade_and_wedge(
    pull: float = 60.0,
    platform_angle: float = 35.0,
    mu: float = 0.4,
    *,
    damper_mass: float = 0.02,
    kt: float = 8e5,
    kn: float = 1.2e6,
    mass: float = 0.5,
    stiffness: float = 2e6,
    damping: float = 2e-3,
    force: float = 1.0,
) -> Problem:
    """A mass on a spring, moving along x, and a wedge D that its pull along y presses against two platforms at ± the angle.

    pull: F_C on the damper [N]; platform_angle α [degrees], the same on both sides; mu, kt, kn [N/m] of each contact, so that
    stuck the damper adds k_H = kt kn/(2 (kt sin²α + kn cos²α)) to the blade; mass, damper_mass [kg]; stiffness of the blade
    [N/m]; damping: ratio of every stuck mode; force: cosine amplitude on blade.mode, which moves along x [N].
    """
    if not 0.0 < finite("platform_angle", platform_angle) < 90.0:
        raise fault("platform_angle", "must lie between 0 and 90 degrees", platform_angle)
    positive("pull", pull)
    c, s = cos(radians(platform_angle)), sin(radians(platform_angle))
    light = positive("damper_mass", damper_mass)
    M = np.diag([positive("mass", mass), light, light])
    K = np.diag([positive("stiffness", stiffness), 0.0, 0.0])
    rule = ModalDamping(damping, on="stuck")
    structure = Structure(M, K, ("blade.mode", "D.x", "D.y"), damping=rule, outlines={"D": wedge_outline(platform_angle)})
    law = Macroslip(kt, mu, kn)
    on_blade = {"D.x": c, "D.y": s, "blade.mode": -c}, {"D.x": -s, "D.y": c, "blade.mode": s}
    on_ground = {"D.x": c, "D.y": -s}, {"D.x": s, "D.y": c}
    sides = {"blade side": on_blade, "fixed side": on_ground}
    contacts = tuple(Contact(name, law, (tangential,), normal) for name, (tangential, normal) in sides.items())
    forces = (Force("blade.mode", force), Force("D.y", static=pull))
    return Problem(structure, contacts, forces, ("blade.mode",), f"Blade and wedge, {pull:g} N, {platform_angle:g} degrees")
