"""A bladed disk of 24 lumped sectors with a damper between neighbours, small enough to solve without cyclic symmetry.

Case W: wedges that do not turn. Case R: cylinders that roll. Numbers of this project, computed by an independent script.
"""

from __future__ import annotations

from math import cos, radians, sin
from typing import Literal

import numpy as np

from stickslip.model.contact.macroslip import Macroslip
from stickslip.model.contact.point import Contact
from stickslip.model.contact.start import SliderOffset, Start
from stickslip.model.disks.tuned import TunedDisk
from stickslip.model.loads import Force
from stickslip.model.structure.assembly import Spring
from stickslip.model.structure.cyclic import CyclicStructure, sector_chain
from stickslip.model.structure.matrices import Structure
from stickslip.support.checks import fault, finite

ROLLER_RADIUS = 5e-3
ROLL_STIFFNESS = 1e3
"""Spring on the mean roll of a cylinder, N m/rad: with both contacts in slip any mean roll is in equilibrium."""


def lumped_blisk(
    case: Literal["W", "R"] = "W",
    *,
    engine_order: int = 2,
    sectors: int = 24,
    platform_angle: float = 45.0,
    pull: float = 147.0,
    kt: float = 1.7e7,
    kn: float = 6.3e8,
    mu: float = 0.6,
    damper_mass: float = 0.017,
    force: float = 1.0,
    start: Start | None = None,
) -> TunedDisk:
    """Disk, platform and tip of each blade move tangentially; a damper sits between each platform and the next one.

    case: "W", a wedge without rotation, or "R", a cylinder of 5 mm radius that rolls. engine_order: force F cos(ωt − 2π EO j/N)
    on tip j [N]; platform_angle [degrees]; pull: centrifugal force F_C of each damper [N]; kt, kn [N/m], mu of each contact.
    """
    if case not in ("W", "R"):
        raise fault("case", 'must be "W" (wedge) or "R" (cylinder that rolls)', case)
    if not 0.0 <= finite("platform_angle", platform_angle) < 90.0:
        raise fault("platform_angle", "must lie in [0, 90) degrees", platform_angle)
    rolls = case == "R"
    law, rule = Macroslip(kt, mu, kn), start or SliderOffset()
    lever, radius = (0.2, ROLLER_RADIUS) if rolls else (0.02, 0.0)
    c, s = cos(radians(platform_angle)), sin(radians(platform_angle))
    contacts = (
        Contact("right edge", law, (_along("", -lever, c, s, radius),), _along("", -lever, -s, c), rule),
        Contact("left edge", law, (_along("next/", lever, c, -s, radius),), _along("next/", lever, s, c), rule),
    )
    roll = (Spring({"damper.rz": 1.0}, ROLL_STIFFNESS),) if rolls else ()
    loads = (Force("tip.t", force, name="engine order"), Force("damper.y", static=pull, name="centrifugal pull"))
    title = f"Lumped bladed disk, case {case}"
    return TunedDisk(_structure(sectors, damper_mass, rolls), contacts, loads, ("tip.t",), title, roll, engine_order)


def _structure(sectors: int, damper_mass: float, rolls: bool) -> CyclicStructure:
    """Disk 2 kg, platform 1.2 kg, tip 0.6 kg with C = 2 M + 1e-6 K; the free damper undamped."""
    ground, ring, shank, blade = 1e7, 2e7, 3e6, 5.5e5
    M = np.diag([2.0, 1.2, 0.6])
    K = np.array([[ground + 2 * ring + shank, -shank, 0.0], [-shank, shank + blade, -blade], [0.0, -blade, blade]])
    K_next = np.diag([-ring, 0.0, 0.0])
    damper = np.diag([damper_mass, damper_mass, *([0.5 * damper_mass * ROLLER_RADIUS**2] if rolls else [])])
    dofs = ("disk.t", "platform.t", "tip.t", "damper.x", "damper.y", *(["damper.rz"] if rolls else []))
    size, free = len(dofs), len(dofs) - 3
    whole = np.zeros((3, size, size))
    whole[0, :3, :3], whole[0, 3:, 3:], whole[1, :3, :3], whole[2, :3, :3] = M, damper, K, K_next
    sector = Structure(whole[0], whole[1], dofs)
    chain = sector_chain(sector, sectors, whole[2])
    assert chain.masses is not None
    assert chain.stiffnesses is not None
    keep = np.diag([1.0] * 3 + [0.0] * free)
    return chain.with_damping(2.0 * keep @ chain.masses @ keep + 1e-6 * chain.stiffnesses)


def _along(side: str, lever: float, x: float, y: float, radius: float = 0.0) -> dict[str, float]:
    """The damper's motion along (x, y) relative to a platform edge, which moves (p, lever (t − p)); a roll lessens it."""
    platform = {f"{side}platform.t": -x + y * lever, f"{side}tip.t": -y * lever}
    return {"damper.x": x, "damper.y": y, **platform, **({"damper.rz": -radius} if radius else {})}
