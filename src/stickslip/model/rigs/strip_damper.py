"""A thin strip under the platforms of neighbouring blades, a seal or damper: slip spreads from the gap along it.

Each sector is a blade with the strip that lies under its platform and the next one's. `strip_energy` is the closed form of the
continuous strip.
"""

from math import sqrt

import numpy as np

from stickslip.model.contact.law import Friction, share_of
from stickslip.model.contact.macroslip import Macroslip
from stickslip.model.contact.point import Contact
from stickslip.model.disks.tuned import TunedDisk
from stickslip.model.loads import Force
from stickslip.model.problem import modal_damping_matrix
from stickslip.model.structure.assembly import Spring
from stickslip.model.structure.cyclic import NEXT, sector_chain
from stickslip.model.structure.matrices import ModalDamping, Structure
from stickslip.model.structure.modes import natural_modes
from stickslip.support.checks import between, not_negative, positive, whole

PIN = 1e4
"""Spring on the mean position of a strip, N/m: the stops that keep it under its gap."""
MOST_POINTS = 200
"""Under a platform."""


def strip_damper(
    pull: float = 600.0,
    mu: Friction = 0.3,
    *,
    engine_order: int = 4,
    sectors: int = 40,
    points: int = 8,
    overlap: float = 8e-3,
    gap: float = 1e-3,
    width: float = 0.03,
    thickness: float = 3e-4,
    kt: float = 2e9,
    youngs_modulus: float = 2e11,
    density: float = 7850.0,
    platform_mass: float = 0.3,
    tip_mass: float = 0.1,
    shank_stiffness: float = 2e7,
    blade_stiffness: float = 1e6,
    damping: float = 1e-3,
    force: float = 1.0,
) -> TunedDisk:
    """Blades of two masses, platform and tip, that move along the circumference t, with a strip under every two platforms.

    pull F_C [N]: centrifugal load of a strip, m r Ω². A strip bends so easily that the load is spread evenly and is constant:
    q = μ F_C/(2ℓ) is the friction per length. mu; kt [N/m]: of the contact with one platform, shared over `points` along it.
    overlap ℓ [m]: length of the strip under each platform, along t; gap g between the platforms; width (along the axis),
    thickness [m], youngs_modulus [Pa], density [kg/m³] of the strip, a chain of bars. engine_order: force F cos(ωt − 2π EO j/N)
    [N] on the tip of blade j; platform_mass, tip_mass [kg]; shank_stiffness between platform and rigid disk, blade_stiffness
    between platform and tip [N/m]; damping: ratio of both modes of a blade alone. A pin holds the mean position of the strip.
    """
    sectors, points = whole("sectors", sectors), between("points", points, 1, MOST_POINTS)
    area = positive("width", width) * positive("thickness", thickness)
    EA = positive("youngs_modulus", youngs_modulus) * area
    count, step = 2 * points, positive("overlap", overlap) / points
    M, C, K = np.zeros((3, count + 2, count + 2))
    shank, blade = positive("shank_stiffness", shank_stiffness), positive("blade_stiffness", blade_stiffness)
    M[:2, :2] = np.diag([positive("platform_mass", platform_mass), positive("tip_mass", tip_mass)])
    K[:2, :2] = [[shank + blade, -blade], [-blade, blade]]
    C[:2, :2] = modal_damping_matrix(M[:2, :2], natural_modes(M[:2, :2], K[:2, :2]), ModalDamping(damping))
    M[2:, 2:] = positive("density", density) * area * (2.0 * overlap + not_negative("gap", gap)) / count * np.eye(count)
    for k in range(count - 1):
        bar = EA / (step + (gap if k == points - 1 else 0.0))
        K[2 + k : 4 + k, 2 + k : 4 + k] += bar * np.array([[1.0, -1.0], [-1.0, 1.0]])
    strip = [f"strip_{k}.t" for k in range(1, count + 1)]
    disk = sector_chain(Structure(M, K, ("platform.t", "tip.t", *strip), C=C), sectors, np.zeros_like(K))
    law = Macroslip(positive("kt", kt) / points, share_of(mu, 1.0 / points), normal_load=not_negative("pull", pull) / count)
    platforms = ["platform.t"] * points + [NEXT + "platform.t"] * points
    contacts = tuple(
        Contact(dof.removesuffix(".t"), law, ({dof: 1.0, platform: -1.0},))
        for dof, platform in zip(strip, platforms, strict=True)
    )
    pin = Spring({strip[points - 1]: 0.5, strip[points]: 0.5}, PIN)
    title = f"Strip dampers, {pull:g} N"
    return TunedDisk(disk, contacts, (Force("tip.t", force),), ("tip.t",), title, (pin,), engine_order)


def strip_energy(motion: float, pull: float, mu: float, stiffness: float, overlap: float, gap: float) -> float:
    """Energy per cycle that a strip dissipates [J] while the two platforms move by D cos ωt relative to each other.

    motion D [m]; pull F_C [N]; mu; stiffness EA of the strip [N]; overlap ℓ, gap g [m]. Coulomb friction q = μ F_C/(2ℓ) per
    length, without elasticity of the contact and inertia of the strip: where it pulls with F, slip reaches F/q from the gap under
    either platform, so D = F g/(EA) + F²/(q EA), and by Masing's rule W = 4 F³/(3 q EA). From F = q ℓ on, at
    D₀ = q ℓ (g + ℓ)/(EA), the whole strip slips, and W grows by 4 q ℓ (D − D₀).
    """
    q = positive("mu", mu) * positive("pull", pull) / (2.0 * positive("overlap", overlap))
    EA, D, most = positive("stiffness", stiffness), not_negative("motion", motion), q * overlap
    half = 0.5 * q * not_negative("gap", gap)
    F = min(sqrt(half**2 + q * EA * D) - half, most)
    return 4.0 * F**3 / (3.0 * q * EA) + 4.0 * most * max(D - most * (gap + overlap) / EA, 0.0)
