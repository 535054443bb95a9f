"""Small structures on which time integration is judged."""

import numpy as np

from stickslip.model.contact.cubic import Gap
from stickslip.model.contact.friction_disc import FrictionDisc
from stickslip.model.contact.macroslip import Macroslip
from stickslip.model.contact.microslip import MicroslipArray
from stickslip.model.contact.point import Contact, between
from stickslip.model.loads import Force
from stickslip.model.problem import Problem
from stickslip.model.rigs import three_mass_wedge
from stickslip.model.structure.matrices import Structure


def three_masses(limit: float) -> Problem:
    """Two masses and a massless node, loads of harmonics 1 and 3 and a static one, damping not proportional, one slider."""
    M, K = np.diag([1.0, 2.0, 0.0]), np.array([[3.0, -1.0, 0.0], [-1.0, 4.0, -2.0], [0.0, -2.0, 3.0]])
    C = np.array([[0.1, -0.05, 0.0], [-0.05, 0.2, 0.0], [0.0, 0.0, 0.05]])
    dofs = ("1.x", "2.x", "3.x")
    slider = Contact("slider", Macroslip(kt=2.0, mu=1.0, normal_load=limit), (between("1.x", "2.x"),))
    forces = (Force("1.x", {1: 1.0 - 0.5j, 3: 0.3}), Force("3.x", 0.2, static=1.0))
    return Problem(Structure(M, K, dofs, C=C), (slider,), forces, dofs)


def rubbing_mass(law=None) -> Problem:
    """One mass in the plane that bounces on and rubs against the ground: open for 55 % of the period at 0.9 rad/s."""
    law = law or Macroslip(kt=3.0, mu=0.5, kn=4.0, preload=0.2)
    structure = Structure(np.eye(2), np.eye(2), ("1.x", "1.y"), C=0.05 * np.eye(2))
    contact = Contact("ground", law, (between("1.x", "ground"),), between("1.y", "ground"))
    forces = (Force("1.x", 1.0), Force("1.y", 0.3 - 0.6j, static=0.4))
    return Problem(structure, (contact,), forces, ("1.x", "1.y"))


def line_contact() -> Problem:
    """The bouncing mass on a microslip array that closes and slips piece by piece."""
    return rubbing_mass(MicroslipArray.from_totals(kt=3.0, kn=4.0, mu=0.5, largest_gap=0.4))


def stop() -> Problem:
    """One mass between a spring and a stop 0.5 m away, and a massless node on springs that rubs."""
    structure = Structure(np.diag([1.0, 0.0]), np.array([[2.0, -1.0], [-1.0, 1.5]]), ("1.x", "2.x"), C=np.diag([0.05, 0.0]))
    contacts = (
        Contact("stop", Gap(kn=5.0, gap=0.5), normal=between("1.x", "ground")),
        Contact("slider", Macroslip(kt=1.0, mu=1.0, normal_load=0.2), (between("2.x", "ground"),)),
    )
    return Problem(structure, contacts, (Force("1.x", 1.0),), ("1.x", "2.x"))


def orbiting_mass(varying: bool) -> Problem:
    """One mass that moves in two tangential directions at once on a friction disc, of constant or varying normal load."""
    K = np.array([[1.0, 0.1, 0.0], [0.1, 1.4, 0.0], [0.0, 0.0, 1.0]])
    structure = Structure(np.eye(3), K, ("1.x", "1.y", "1.z"), C=0.05 * np.eye(3))
    law = FrictionDisc(kt=3.0, mu=0.5, kn=4.0, preload=1.0) if varying else FrictionDisc(kt=3.0, mu=0.5, normal_load=1.0)
    tangential = (between("1.x", "ground"), between("1.y", "ground"))
    contact = Contact("disc", law, tangential, between("1.z", "ground") if varying else None)
    forces = (Force("1.x", 1.0), Force("1.y", -0.8j), Force("1.z", 0.6, static=0.5))
    return Problem(structure, (contact,), forces, ("1.x", "1.y"))


def landing_foot(mass: float) -> Problem:
    """A mass on a spring with a foot of small or no mass that lands on a stiff stop once a period."""
    M, K = np.diag([1.0, mass]), np.array([[3.0, -2.0], [-2.0, 2.0]])
    stop = Contact("stop", Gap(kn=100.0, gap=0.3), normal=between("foot.y", "ground"))
    structure = Structure(M, K, ("1.y", "foot.y"), C=np.diag([0.1, 0.0]))
    return Problem(structure, (stop,), (Force("1.y", 1.0),), ("1.y", "foot.y"))


def damped_wedge(ratio: float) -> Problem:
    """The three-mass wedge with a viscous damper of 2 N s/m on the damper's coordinates as well.

    Without it the damper rings on its stuck contacts for ever and no motion becomes periodic.
    """
    problem = three_mass_wedge(ratio)
    C = problem.C.copy()
    C[4, 4] = C[5, 5] = 2.0
    return problem.with_damping(C)
