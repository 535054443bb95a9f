"""Blades with interlocking shrouds: oblique faces between neighbours, pressed together as centrifugal load untwists them."""

from __future__ import annotations

from collections.abc import Mapping
from math import cos, pi, radians, sin

import numpy as np

from stickslip.model.contact.macroslip import Macroslip
from stickslip.model.contact.point import Contact, SliderOffset, Start, difference
from stickslip.model.disks.tuned import TunedDisk
from stickslip.model.loads import Force, Output
from stickslip.model.rigs.beam_element import beam_mass, beam_stiffness
from stickslip.model.structure.cyclic import NEXT, sector_chain
from stickslip.model.structure.damping import ModalDamping
from stickslip.model.structure.matrices import Structure
from stickslip.support.checks import Array, fault, finite, not_negative, positive, whole

ELEMENTS = 6
"""Along a blade."""
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
    blade = _blade(length, chord, thickness, youngs_modulus, density)
    size = blade.shape[1]
    turning = _turning(axes)
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


def _turning(axes: Array) -> Array:
    """The rotation vector (t, a, s) of a node per its five degrees of freedom, (3, 5): a slope along f turns about s × f."""
    radial = axes[2]
    columns = np.zeros((3, 5))
    columns[:, FLAP[1]], columns[:, EDGE[1]] = np.cross(radial, axes[0]), np.cross(radial, axes[1])
    columns[:, TWIST] = radial
    return columns


def _blade(length: float, chord: float, thickness: float, youngs_modulus: float, density: float) -> Array:
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
