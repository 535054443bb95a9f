"""Lumped rigs for hand calculation: one mass, chains of masses, two blades with a wedge damper.

The chains and the single mass are the problems on which harmonic balance codes are compared and timed.

A bladed disk of 24 lumped sectors with a damper between neighbours, small enough to solve without cyclic symmetry.

Case W: wedges that do not turn. Case R: cylinders that roll. Numbers of this project, computed by an independent script.

One mode of a jointed structure, such as a bolted beam, with a joint by Segalman's four parameters.

One blade mode with a wedge damper between its platform and a fixed one: the smallest rig for damper design.

A thin strip under the platforms of neighbouring blades, a seal or damper: slip spreads from the gap along it. Each sector is a
blade with the strip that lies under its platform and the next one's.
"""

from collections.abc import Sequence
from math import cos, radians, sin
from typing import Literal

import numpy as np

from stickslip.model.contact.law import Friction, share_of
from stickslip.model.contact.macroslip import Macroslip
from stickslip.model.contact.microslip import FourParameter, Iwan
from stickslip.model.contact.point import Contact, SliderOffset, Start, TractionRatio, between
from stickslip.model.dampers.wedge import wedge_outline
from stickslip.model.disks.tuned import TunedDisk
from stickslip.model.loads import Force
from stickslip.model.problem import Problem, modal_damping_matrix
from stickslip.model.structure.assembly import Spring
from stickslip.model.structure.cyclic import NEXT, CyclicStructure, sector_chain
from stickslip.model.structure.matrices import ModalDamping, Structure
from stickslip.model.structure.modes import natural_modes
from stickslip.support import checks
from stickslip.support.checks import Array, fault, finite, not_negative, positive, whole


def single_mass(
    mass: float = 1.0, damping: float = 0.02, stiffness: float = 1.0, kt: float = 1.0, limit: float = 1.0, force: float = 1.0
) -> Problem:
    """One mass with spring and viscous damper to ground and a Jenkins element (kt, slip limit μN) beside them.

    mass [kg], damping [N s/m], stiffness, kt [N/m], limit, force amplitude (cosine) [N]. The defaults are the benchmark.
    """
    M, K, C = (np.array([[value]], dtype=float) for value in (mass, stiffness, damping))
    structure = Structure(M, K, ("1.x",), C=C)
    return Problem(structure, (_slider("1.x", "ground", kt, limit),), (Force("1.x", force),), ("1.x",), "Single mass")


def chain(
    masses: int = 20,
    sliders: Sequence[int] = tuple(range(11, 21)),
    kt: float = 0.5,
    limit: float = 1.0,
    forced: int = 10,
    force: float = 1.0,
) -> Problem:
    """Unit masses in a row, springs 1 from ground to mass 1 and on to the free last mass, C = 0.01 K.

    sliders: masses with a Jenkins element to ground (kt [N/m], slip limit μN [N]); forced: the mass that carries the
    cosine force [N] and is reported.
    """
    _check_masses(masses, (*sliders, forced))
    K = chain_stiffness(masses)
    dofs = tuple(f"{i}.x" for i in range(1, masses + 1))
    contacts = tuple(_slider(f"{i}.x", "ground", kt, limit) for i in sliders)
    structure = Structure(np.eye(masses), K, dofs, C=0.01 * K)
    return Problem(structure, contacts, (Force(f"{forced}.x", force),), (f"{forced}.x",), f"Chain of {masses} masses")


def chain_varying_load(
    masses: int = 20,
    touching: Sequence[int] = tuple(range(11, 21)),
    kt: float = 0.5,
    kn: float = 1.0,
    mu: float = 0.5,
    preload: float = 2.0,
    forced: int = 10,
    force: float = 1.0,
    normal_force: float = 1.0,
) -> Problem:
    """The chain with a second direction y per mass (grounded by a spring 1), which loads and unloads friction along x.

    touching: masses on friction contacts to ground (kt, kn [N/m], mu, preload N0 [N], counted from the preloaded
    equilibrium); force: cosine force along x on mass `forced`; normal_force: in phase along y on all touching masses [N].
    """
    _check_masses(masses, (*touching, forced))
    Kx = chain_stiffness(masses)
    K = np.kron(Kx, np.eye(2)) + np.kron(np.eye(masses), np.diag([0.0, 1.0]))
    dofs = tuple(f"{i}.{axis}" for i in range(1, masses + 1) for axis in "xy")
    law = Macroslip(kt, mu, kn, preload)
    contacts = [
        Contact(f"{i}", law, (between(f"{i}.x", "ground"),), between(f"{i}.y", "ground"), balanced=True) for i in touching
    ]
    loads = (Force(f"{forced}.x", force), *(Force(f"{i}.y", normal_force) for i in touching))
    structure = Structure(np.eye(2 * masses), K, dofs, C=0.01 * K)
    return Problem(structure, tuple(contacts), loads, (f"{forced}.x",), f"Chain of {masses} masses, varying normal load")


def chain_of_three(kt: float = 20.0, limit: float = 1.0, damping: float = 0.02, force: float = 1.0) -> Problem:
    """Three unit masses between two walls, springs 1, a viscous damper beside each; sliders wall-1 and 1-2 (kt, limit μN).

    The cosine force acts on mass 2. NLvib (Krack and Gross) gives reference curves for it.
    """
    K = 2.0 * np.eye(3) - np.eye(3, k=1) - np.eye(3, k=-1)
    structure = Structure(np.eye(3), K, ("1.x", "2.x", "3.x"), C=damping * K)
    contacts = (_slider("1.x", "ground", kt, limit), _slider("1.x", "2.x", kt, limit))
    return Problem(structure, contacts, (Force("2.x", force),), ("1.x", "2.x", "3.x"), "Chain of three masses")


def three_mass_wedge(
    traction_ratio: float | Start = 0.0,
    *,
    platform_angle: float = 30.0,
    pull: float = 120.0,
    excitation: tuple[float, float] = (-20.0, 5.0),
    kt: float = 3e5,
    kn: float = 3e5,
    mu: float = 0.5,
) -> Problem:
    """Two planar blades and a wedge damper D, all of two degrees of freedom: the smallest case of non-unique friction.

    traction_ratio: start state m of both contacts at the last sample, or any start rule; platform_angle [degrees];
    pull: static force on D.y [N]; excitation: sine amplitudes on 1.y and 2.x [N]; kt, kn [N/m], mu of both contacts.
    Source: the three-mass planar oscillator of the literature on non-unique friction forces, numbers of this project.
    """
    # Blades: ground springs k, x and y coupled by k, blade to blade by k12; damper: x and y coupled by k, else free.
    k, k12, couple = 3e5, 7e5, np.array([[1.0, -1.0], [-1.0, 1.0]])
    K = np.zeros((6, 6))
    K[:4, :4] = k * np.eye(4) + k * np.kron(np.eye(2), couple) + k12 * np.kron(couple, np.eye(2))
    K[4:, 4:] = k * couple
    M, C = np.diag([1.0] * 4 + [0.1] * 2), np.diag([20.0] * 4 + [0.0] * 2)
    outlines = {"D": wedge_outline(platform_angle)} if 0.0 < platform_angle < 90.0 else {}
    structure = Structure(M, K, ("1.x", "1.y", "2.x", "2.y", "D.x", "D.y"), C=C, outlines=outlines)
    start = TractionRatio(traction_ratio) if isinstance(traction_ratio, int | float) else traction_ratio
    c, s = cos(radians(platform_angle)), sin(radians(platform_angle))
    law = Macroslip(kt, mu, kn)
    contacts = (
        Contact("blade 1", law, (_relative("1", c, s),), _relative("1", -s, c), start),
        Contact("blade 2", law, (_relative("2", c, -s),), _relative("2", s, c), start),
    )
    loads = (Force("1.y", -1j * excitation[0]), Force("2.x", -1j * excitation[1]), Force("D.y", static=pull))
    return Problem(structure, contacts, loads, ("2.y", "1.y", "1.x", "2.x"), "Two blades and a wedge damper")


def _relative(blade: str, x: float, y: float) -> dict[str, float]:
    """The displacement of the damper relative to a blade along (x, y)."""
    return {"D.x": x, "D.y": y, f"{blade}.x": -x, f"{blade}.y": -y}


def chain_stiffness(masses: int) -> Array:
    """Springs 1 from ground to mass 1 and from mass to mass, the last one free, (masses, masses)."""
    K = 2.0 * np.eye(masses) - np.eye(masses, k=1) - np.eye(masses, k=-1)
    K[-1, -1] = 1.0
    return np.asarray(K)


def _slider(a: str, b: str, kt: float, limit: float) -> Contact:
    """A Jenkins element of constant slip limit μN between two degrees of freedom."""
    return Contact(f"{a.split('.')[0]}-{b.split('.')[0]}", Macroslip(kt, 1.0, normal_load=limit), (between(a, b),))


def _check_masses(masses: int, used: Sequence[int]) -> None:
    """Refuse numbers of masses that a chain does not have."""
    outside = sorted({i for i in used if not 1 <= i <= masses})
    if outside:
        raise fault("Numbers of masses", f"must lie between 1 and {masses}", outside)


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


def jointed_mode(
    frequency: float = 80.3,
    damping: float = 1.4e-3,
    mass: float = 2.0,
    kt: float = 1e5,
    slip_force: float = 46.0,
    chi: float = 0.66,
    beta: float = 0.0,
    *,
    count: int | None = None,
) -> Problem:
    """m q̈ + 2 ζ m ω0 q̇ + (m ω0² − kt) q + T(q) = F cos ωt, T an Iwan law: ω0 = 2π frequency with the joint stuck.

    frequency [Hz], damping ζ and mass [kg] of the mode where nothing slips, as seen at the output; kt [N/m] of the joint, its
    force in full slip [N], chi and beta of `FourParameter`; count: number of its elements, as for `Iwan`. The force is 1 N.
    Far from full slip the joint dissipates 4 R A^(χ+3)/((χ+2)(χ+3)), so that its damping ratio goes by A^(χ+1).
    """
    whole = positive("mass", mass) * (2.0 * np.pi * positive("frequency", frequency)) ** 2
    if positive("kt", kt) > whole:
        raise fault("kt", f"must not exceed the stiffness of the mode, {whole:.4g} N/m", kt)
    C = 2.0 * positive("damping", damping) * np.sqrt(whole * mass)
    structure = Structure(np.array([[mass]]), np.array([[whole - kt]]), ("1.x",), C=np.array([[C]]))
    law = Iwan(kt, 1.0, normal_load=positive("slip_force", slip_force), spectrum=FourParameter(chi, beta), count=count)
    joint = Contact("joint", law, (between("1.x", "ground"),))
    return Problem(structure, (joint,), (Force("1.x", 1.0),), ("1.x",), "One mode with a joint")


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
    sectors, points = whole("sectors", sectors), checks.between("points", points, 1, MOST_POINTS)
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
