"""A blade in its dovetail: two flanks with contact points along them, pressed on by the centrifugal load.

A split ring in a groove inside the rim of a labyrinth seal, gear or bladed disk: it slides between the nodes of a wave.

The rim bends in its plane and strains the groove, which lies off its neutral axis; friction drags the ring along. Sectors are the
contact points around the rim.

Blades with interlocking shrouds: oblique faces between neighbours, pressed together as centrifugal load untwists them.

The straight Euler-Bernoulli beam element of rigs that are made of beams, and closed rings of such elements.
"""

from collections.abc import Mapping
from math import cos, pi, radians, sin

import numpy as np

from stickslip.model.contact.law import Friction
from stickslip.model.contact.macroslip import Macroslip
from stickslip.model.contact.point import Contact, OnSurface, SliderOffset, Start, difference
from stickslip.model.disks.tuned import TunedDisk
from stickslip.model.loads import Force, Output
from stickslip.model.problem import Problem, modal_damping_matrix
from stickslip.model.structure.assembly import Spring
from stickslip.model.structure.cyclic import MOST_SECTORS, NEXT, CyclicStructure, cyclic, sector_chain
from stickslip.model.structure.matrices import ModalDamping, RayleighDamping, Structure
from stickslip.model.structure.modes import natural_modes
from stickslip.support.checks import Array, between, fault, finite, not_negative, positive, whole


def beam_stiffness(length: float, EA: float, EI: float) -> Array:
    """K of an element, (6, 6): motion along it, across it and rotation φ = dw/dx at either end; EA [N], EI [N m²]."""
    K = np.zeros((6, 6))
    K[np.ix_([0, 3], [0, 3])] = EA / length * np.array([[1.0, -1.0], [-1.0, 1.0]])
    L = length
    bending = [
        [12, 6 * L, -12, 6 * L],
        [6 * L, 4 * L**2, -6 * L, 2 * L**2],
        [-12, -6 * L, 12, -6 * L],
        [6 * L, 2 * L**2, -6 * L, 4 * L**2],
    ]
    K[np.ix_([1, 2, 4, 5], [1, 2, 4, 5])] = EI / L**3 * np.array(bending)
    return K


def beam_mass(length: float, mass: float) -> Array:
    """Consistent M of an element across its axis, (4, 4): motion and rotation at either end; mass [kg]."""
    L = length
    rows = [
        [156, 22 * L, 54, -13 * L],
        [22 * L, 4 * L**2, 13 * L, -3 * L**2],
        [54, 13 * L, 156, -22 * L],
        [-13 * L, -3 * L**2, -22 * L, 4 * L**2],
    ]
    return mass / 420.0 * np.array(rows)


def ring_of_beams(node: str, points: int, radius: float, EA: float, EI: float, masses: Array) -> CyclicStructure:
    """A polygon of beam elements between `points` nodes on a circle: one node NODE.r (out), NODE.t (along), NODE.rz a sector.

    masses (3,): mass for r and t and inertia for rz of a node. rz is dw/ds, w along r and s along t: a point at a distance e
    inside the circle moves by t + e rz along it.
    """
    half = pi / points
    element = beam_stiffness(2.0 * radius * sin(half), EA, EI)
    c, s = cos(half), sin(half)
    near = np.array([[-s, c, 0.0], [c, s, 0.0], [0.0, 0.0, 1.0]])
    far = np.array([[s, c, 0.0], [c, -s, 0.0], [0.0, 0.0, 1.0]])
    own = near.T @ element[:3, :3] @ near + far.T @ element[3:, 3:] @ far
    sector = Structure(np.diag(masses), own, tuple(f"{node}.{direction}" for direction in ("r", "t", "rz")))
    return sector_chain(sector, points, near.T @ element[:3, 3:] @ far)


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
    M, K, nodes = _blade_on_a_root(length, width, thickness, youngs_modulus, density)
    b = 2.0 * positive("damping", damping) / float(np.sqrt(natural_modes(M[3:, 3:], K[3:, 3:]).squares[0]))
    deep = positive("flank_depth", flank_depth) + positive("flank_length", flank_length) * s
    root = positive("root_mass", root_mass)
    middle = np.array([1.0, 0.0, 0.5 * deep])  # x of the middle of the root by root.x, root.y, root.rz
    M[:3, :3] += root * np.outer(middle, middle)
    M[1, 1] += root
    M[2, 2] += root * ((positive("neck", neck) + 2.0 * flank_length * c) ** 2 + deep**2) / 12.0
    dofs = ("root.x", "root.y", "root.rz", *(f"{node}.{name}" for node in nodes for name in ("x", "rz")))
    structure = Structure(M, K, dofs, damping=RayleighDamping(0.0, b))
    law, rule = Macroslip(kt, mu, kn).share(1.0 / points), start or SliderOffset()
    contacts = tuple(
        Contact(f"{name} {k + 1}", law, (_at(place, (side * c, -s)),), _at(place, (side * s, c)), rule, surface=part)
        for name, side in (("left", -1.0), ("right", 1.0))
        for k in range(points)
        for way in [(k + 0.5) / points * flank_length]
        for place, part in [((side * (0.5 * neck + way * c), -flank_depth - way * s), OnSurface(name, 1.0 / points))]
    )
    loads = (Force("tip.x", force), Force("root.y", static=positive("pull", pull), name="centrifugal load"))
    return Problem(structure, contacts, loads, ("tip.x",), f"Blade root, {pull:g} N, {flank_angle:g} degrees")


def _at(place: tuple[float, float], direction: tuple[float, float]) -> dict[str, float]:
    """The motion along a direction of a place (x, y) on the root, which turns about the foot of the blade."""
    x, y = direction
    return {"root.x": x, "root.y": y, "root.rz": place[0] * y - place[1] * x}


def _blade_on_a_root(
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


RIM = ("rim.r", "rim.t", "rim.rz")
RING = ("ring.r", "ring.t")
PIN = 1e9
"""Spring per length of the ring on its mean slip, N/m²: the pin that keeps the ring from turning in its groove. With `kn` the
normal load goes with the wave, which drags the ring along: on a soft pin it turns by many times the slip of the vibration.
"""


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


FLAP, EDGE, TWIST = (0, 1), (2, 3), 4
"""Degrees of freedom of a node: displacement and slope across the thickness and along the chord, rotation about the radius."""
NAMES = ("flap", "rflap", "edge", "redge", "twist")
POISSON = 0.3


def shrouded_blades(
    untwist: float = 20.0,
    face_angle: float = 30.0,
    mu: float = 0.3,
    *,
    engine_order: int = 4,
    sectors: int = 40,
    interference: float = 0.0,
    kt: float = 1.6e7,
    kn: float = 2e7,
    length: float = 0.3,
    chord: float = 0.04,
    thickness: float = 0.008,
    stagger: float = 30.0,
    tip_radius: float = 0.65,
    shroud_mass: float = 0.1,
    youngs_modulus: float = 2.1e11,
    density: float = 7850.0,
    damping: float = 1e-3,
    force: float = 1.0,
    start: Start | None = None,
) -> TunedDisk:
    """Blades clamped in a rigid disk; their tips carry shrouds of one pitch p, which touch at oblique faces: Z shrouds.

    untwist M [N m]: static moment about the radius on each tip, which centrifugal load exerts on a twisted blade: it goes with Ω²
    (`speed_sweep` of the rig at two speeds). Each blade would turn by M L/(G J), but its faces meet those of both neighbours:
    without friction M = N p sin α + G J/L ψ, so that N is solved with the vibration. interference [m] of the faces as assembled,
    along their normal. face_angle α [degrees]: of the normal of the faces from the circumferential direction towards the axial
    one; mu, kt, kn [N/m] of each pair of faces. engine_order: force F cos(ωt − 2π EO j/N) [N] on shroud j, tangential.
    length, chord, thickness [m] of the blades, of rectangular section; stagger [degrees] of the chord from the axis; tip_radius
    [m], p = 2π tip_radius/sectors; shroud_mass [kg]; youngs_modulus [Pa]; density [kg/m³]; damping: ratio of every mode of a
    blade alone; start: of the friction, virgin unless given: the faces have been rubbed by the untwist alone.
    """
    if not 0.0 < finite("face_angle", face_angle) < 90.0:
        raise fault("face_angle", "must lie between 0 and 90 degrees", face_angle)
    sectors = whole("sectors", sectors)
    pitch, half = 2.0 * pi * positive("tip_radius", tip_radius) / max(sectors, 1), pi / max(sectors, 1)
    g, a = radians(finite("stagger", stagger)), radians(face_angle)
    # Axes: circumference t, axis a, radius s = t × a. A blade's flap is across its chord.
    axes = np.array([[cos(g), sin(g), 0.0], [-sin(g), cos(g), 0.0], [0.0, 0.0, 1.0]])
    blade = _shrouded_blade(length, chord, thickness, youngs_modulus, density)
    size = blade.shape[1]
    # The rotation vector (t, a, s) of a node per its five degrees of freedom: a slope along f turns about s × f.
    turning, radial = np.zeros((3, 5)), axes[2]
    turning[:, FLAP[1]], turning[:, EDGE[1]], turning[:, TWIST] = np.cross(radial, axes[0]), np.cross(radial, axes[1]), radial
    inertia = positive("shroud_mass", shroud_mass) / 12.0 * np.array([chord**2, pitch**2, chord**2 + pitch**2])
    tip = slice(size - 5, size)
    M, K = blade
    M[tip, tip] += turning.T @ np.diag(inertia) @ turning
    M[[size - 5, size - 3], [size - 5, size - 3]] += shroud_mass
    nodes = [*(f"node_{k}" for k in range(1, ELEMENTS)), "shroud"]
    dofs = tuple(f"{node}.{name}" for node in nodes for name in NAMES)
    sector = Structure(M, K, dofs, damping=ModalDamping(damping, on="free"))
    disk = sector_chain(sector, sectors, np.zeros((size, size)))

    def face(side: float, direction: Array) -> dict[str, float]:
        """The motion of a face along (t, a, s) in the axes of the middle between two blades."""
        c, s = cos(half), side * sin(half)
        t, axial, radial = direction
        own = np.array([c * t + s * radial, axial, -s * t + c * radial])
        lever = np.cross([0.5 * side * pitch, 0.0, 0.0], own) @ turning
        lever[[0, 2]] += axes[:2] @ own
        return {f"shroud.{name}": float(part) for name, part in zip(NAMES, lever, strict=True) if part}

    def relative(direction: list[float]) -> Mapping[str, float]:
        following = {NEXT + dof: part for dof, part in face(-1.0, np.array(direction)).items()}
        return difference(face(1.0, np.array(direction)), following)

    law = Macroslip(kt, mu, kn, gap=-not_negative("interference", interference))
    along, normal = [-sin(a), cos(a), 0.0], [cos(a), sin(a), 0.0]
    contact = Contact("shroud", law, (relative(along), relative([0.0, 0.0, 1.0])), relative(normal), start or SliderOffset())
    across = {"shroud.flap": float(axes[0, 0]), "shroud.edge": float(axes[1, 0])}
    loads = (Force(across, force, name="engine order"), Force("shroud.twist", static=finite("untwist", untwist), name="untwist"))
    title = f"Shrouded blades, untwist {untwist:g} N m"
    return TunedDisk(disk, (contact,), loads, (Output("shroud.t", across),), title, engine_order=engine_order)


def _shrouded_blade(length: float, chord: float, thickness: float, youngs_modulus: float, density: float) -> Array:
    """M and K of a clamped straight blade, (2, n, n): bending both ways and torsion, J = c t³/3 of a thin section."""
    L, c, t = positive("length", length) / ELEMENTS, positive("chord", chord), positive("thickness", thickness)
    if t > c:
        raise fault("thickness", f"must not exceed the chord, {c:g} m", t)
    E, mass = positive("youngs_modulus", youngs_modulus), positive("density", density) * c * t * L
    GJ = E / (2.0 * (1.0 + POISSON)) * c * t**3 / 3.0
    size = 5 * (ELEMENTS + 1)
    M, K = np.zeros((size, size)), np.zeros((size, size))
    for element in range(ELEMENTS):
        near, far = 5 * element, 5 * element + 5
        for pair, EI in ((FLAP, E * c * t**3 / 12.0), (EDGE, E * t * c**3 / 12.0)):
            rows = np.ix_(*[[near + pair[0], near + pair[1], far + pair[0], far + pair[1]]] * 2)
            K[rows] += beam_stiffness(L, 0.0, EI)[np.ix_([1, 2, 4, 5], [1, 2, 4, 5])]
            M[rows] += beam_mass(L, mass)
        rows = np.ix_([near + TWIST, far + TWIST], [near + TWIST, far + TWIST])
        K[rows] += GJ / L * np.array([[1.0, -1.0], [-1.0, 1.0]])
        M[rows] += mass * (c**2 + t**2) / 72.0 * np.array([[2.0, 1.0], [1.0, 2.0]])
    return np.array([M[5:, 5:], K[5:, 5:]])
