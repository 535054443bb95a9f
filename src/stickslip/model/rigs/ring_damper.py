"""A split ring in a groove inside the rim of a labyrinth seal, gear or bladed disk: it slides between the nodes of a wave.

The rim bends in its plane and strains the groove, which lies off its neutral axis; friction drags the ring along. Sectors are the
contact points around the rim. `ring_energy` is the closed form of the continuous ring.
"""

from __future__ import annotations

from math import asin, cos, hypot, pi, sin, sqrt
from typing import Literal

import numpy as np
import scipy

from stickslip.model.contact.macroslip import Macroslip
from stickslip.model.contact.point import Contact
from stickslip.model.disks.tuned import TunedDisk
from stickslip.model.loads import Force
from stickslip.model.problem import modal_damping_matrix
from stickslip.model.rigs.beam_element import ring_of_beams
from stickslip.model.structure.assembly import Spring
from stickslip.model.structure.cyclic import MOST_SECTORS, CyclicStructure, cyclic
from stickslip.model.structure.damping import ModalDamping
from stickslip.model.structure.modes import natural_modes
from stickslip.support.checks import between, fault, finite, not_negative, positive

RIM = ("rim.r", "rim.t", "rim.rz")
RING = ("ring.r", "ring.t")
PIN = 1e9
"""Spring per length of the ring on its mean slip, N/m²: the pin that keeps the ring from turning in its groove. With `kn` the
normal load goes with the wave, which drags the ring along: on a soft pin it turns by many times the slip of the vibration.
"""
FULL_SLIP = hypot(1.0, 0.5 * pi)
"""Strain over that at which slip begins where, under a travelling wave, the whole ring slips."""


def ring_damper(
    nodal_diameter: int = 4,
    speed: float = 600.0,
    mu: float = 0.2,
    *,
    points: int = 64,
    radius: float = 0.25,
    rim_height: float = 0.01,
    rim_width: float = 0.03,
    ring_height: float = 2e-3,
    ring_width: float = 4e-3,
    offset: float | None = None,
    youngs_modulus: float = 2e11,
    density: float = 7850.0,
    support: float = 2e6,
    line_load: float = 0.0,
    kt: float = 5e10,
    kn: float | None = None,
    damping: float = 1e-3,
    force: float = 10.0,
) -> TunedDisk:
    """A rim that bends in its plane under a wave travelling round it, and a split ring in a groove on its inner side.

    nodal_diameter n: the force along r is force cos(ωt − nθ) [N/m]; speed Ω [rad/s]: it presses the ring on with ρ A r Ω² beside
    `line_load` [N/m], the spring of the ring itself; mu, and kt, kn [N/m²] per length of the contact; points: of contact, around.
    kn None: the ring follows the rim along r, under a constant line load, as closed forms have it; else its pressure is solved
    with the vibration, hoop force and inertia included.
    radius [m] of the neutral axis of the rim; rim_height, ring_height (radial), rim_width, ring_width (axial) [m]; offset e of
    the ring from the neutral axis, towards the centre [m], unless given where the ring touches the rim from inside;
    youngs_modulus [Pa], density [kg/m³] of both; support [N/m²]: springs of the web on the rim along r and t, per length;
    damping: ratio of every mode of the rim without its ring.

    The mean hoop force of a split ring is zero; what else its gap does nearby is left out. A pin holds its mean slip.
    """
    n, points = between("nodal_diameter", nodal_diameter, 1), between("points", points, 1, MOST_SECTORS)
    if points < 4 * n:
        raise fault("points", f"must be at least four to a wave, {4 * n}", points)
    h, b = positive("rim_height", rim_height), positive("rim_width", rim_width)
    area = positive("ring_height", ring_height) * positive("ring_width", ring_width)
    e = 0.5 * (rim_height + ring_height) if offset is None else finite("offset", offset)
    E, rho, inner = positive("youngs_modulus", youngs_modulus), positive("density", density), positive("radius", radius) - e
    step = 2.0 * pi * positive("radius - offset", inner) / points
    rim_mass = rho * b * h * 2.0 * pi * radius / points
    masses = np.array([rim_mass, rim_mass, rim_mass * h**2 / 12.0])
    rim = ring_of_beams("rim", points, radius, E * b * h, E * b * h**3 / 12.0, masses)
    ring = ring_of_beams("ring", points, inner, E * area, 0.0, np.array([rho * area * step] * 2 + [0.0]))
    web = positive("support", support) * 2.0 * pi * radius / points
    disk = _together(rim, ring, web, ModalDamping(damping), follows=kn is None)

    sliding = {"ring.t": 1.0, "rim.t": -1.0, "rim.rz": -e}
    pressing = rho * area * inner * step * finite("speed", speed) ** 2 + step * not_negative("line_load", line_load)
    forces = [Force("rim.r", positive("force", force) * 2.0 * pi * radius / points, name="wave")]
    friction, stiffness = not_negative("mu", mu), positive("kt", kt) * step
    if kn is None:
        contact = Contact("groove", Macroslip(stiffness, friction, normal_load=pressing), (sliding,))
    else:
        law = Macroslip(stiffness, friction, positive("kn", kn) * step)
        contact = Contact("groove", law, (sliding,), {"ring.r": 1.0, "rim.r": -1.0})
        forces.append(Force("ring.r", static=pressing, name="pressure"))
    title = f"Rim with a ring damper, nodal diameter {n}"
    pin = (Spring(sliding, PIN * step),)
    return TunedDisk(disk, (contact,), tuple(forces), ("rim.r",), title, pin, n)


def _together(rim: CyclicStructure, ring: CyclicStructure, web: float, damping: ModalDamping, follows: bool) -> CyclicStructure:
    """Rim on its web, with its damping, and ring side by side; `follows`: ring.r is rim.r."""
    assert rim.masses is not None
    assert rim.stiffnesses is not None
    assert ring.masses is not None
    assert ring.stiffnesses is not None
    dofs = (*RIM, *(RING[1:] if follows else RING))
    of_rim = np.eye(3, len(dofs))
    of_ring = np.zeros((2, len(dofs)))
    of_ring[0, 0 if follows else 3] = of_ring[1, -1] = 1.0
    held = rim.stiffnesses + np.diag([web, web, 0.0])
    hoop = ring.stiffnesses[:, :2, :2].copy()
    hoop[0] = 0.0  # at nodal diameter 0 the gap takes the hoop strain
    masses = of_rim.T @ rim.masses @ of_rim + of_ring.T @ ring.masses[:, :2, :2] @ of_ring
    stiffnesses = of_rim.T @ held @ of_rim + of_ring.T @ hoop @ of_ring
    of_waves = [modal_damping_matrix(M, natural_modes(M, K), damping) for M, K in zip(rim.masses, held, strict=True)]
    dampings = of_rim.T @ np.array(of_waves) @ of_rim
    return cyclic(rim.sectors, dofs, masses, stiffnesses, dampings)


def ring_energy(
    strain: float,
    nodal_diameter: int,
    line_friction: float,
    stiffness: float,
    radius: float,
    wave: Literal["travelling", "standing"] = "travelling",
) -> float:
    """Energy per cycle that a ring under a constant line load dissipates [J], on a groove strained by ε(θ, t), a wave of n.

    strain ε₀: ε = ε₀ cos(nθ − ωt), or ε₀ cos nθ cos ωt of a standing wave; line_friction μp [N/m]; stiffness EA of the ring [N];
    radius r [m]. Coulomb friction without elasticity of the contact: with k = n/r and a = EA ε₀ k/(μp) the ring sticks up to
    a = 1. The hoop force N follows EA ε with the slope μp/k at most, and W = (μp/k) Σ ∫ |N/EA − ε| d(ks) over the waves.
    Travelling wave beyond a = √(1 + π²/4): W = 4 μp (ε₀/k) √(1 − π²/(4a²)) 2πr. Standing wave: slip in |ks − π/2| < β,
    β/sin β = a, W = 16 n μp (ε₀/k²) (sin β − β cos β − β³/(3a)), and β = π/2 from a = π/2 on.
    """
    k = between("nodal_diameter", nodal_diameter, 1) / positive("radius", radius)
    limit = positive("line_friction", line_friction)
    a = positive("stiffness", stiffness) * not_negative("strain", strain) * k / limit
    if wave not in ("travelling", "standing"):
        raise fault("wave", 'must be "travelling" or "standing"', wave)
    unit = nodal_diameter * limit * strain / k**2
    if a <= 1.0:
        return 0.0
    if wave == "standing":
        beta = 0.5 * pi
        if a < 0.5 * pi:
            beta = float(scipy.optimize.brentq(lambda angle: angle - a * sin(angle), 1e-9, 0.5 * pi, xtol=1e-15))
        return 16.0 * unit * (sin(beta) - beta * cos(beta) - beta**3 / (3.0 * a))
    if a >= FULL_SLIP:
        return 8.0 * pi * unit * sqrt(1.0 - (0.5 * pi / a) ** 2)
    first = asin(1.0 / a)
    top = cos(first)
    last = float(scipy.optimize.brentq(lambda angle: top - (angle - first) / a - cos(angle), pi - first, pi + first, xtol=1e-15))
    width = last - first
    return 4.0 * pi * unit * (top * width - width**2 / (2.0 * a) - (sin(last) - sin(first)))
