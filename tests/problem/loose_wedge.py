"""A wedge between two blades, which friction alone holds along its axis."""

import numpy as np

import stickslip as ss
from stickslip.model.contact.macroslip import Macroslip
from stickslip.model.contact.point import Contact
from stickslip.model.problem import Problem
from stickslip.model.structure.matrices import Structure

KT, KN = 200.0, 500.0


def wedge_between(stiffness=(1000.0, 1200.0, 900.0), scale=1.0):
    """A body between two faces at ±45°: pressed along x and y, free along z but for friction; stiffness of the two blades."""
    names = ("left.x", "left.y", "left.z", "right.x", "right.y", "right.z", "body.x", "body.y", "body.z")
    K = scale * np.diag([*stiffness, *stiffness, 0.0, 0.0, 0.0])
    s, contacts = np.sqrt(0.5), []
    for side, sign in (("left", 1.0), ("right", -1.0)):
        normal = {f"{side}.x": -sign * s, "body.x": sign * s, f"{side}.y": s, "body.y": -s}
        normal = {dof: -value for dof, value in normal.items()}
        along = {f"{side}.x": s, "body.x": -s, f"{side}.y": sign * s, "body.y": -sign * s}
        law = Macroslip(kt=scale * KT, mu=0.3, kn=scale * KN, preload=scale * 4.0)
        contacts.append(Contact(side, law, (along, {f"{side}.z": 1.0, "body.z": -1.0}), normal, balanced=True))
    forces = (ss.Force("left.x", scale * 1.0), ss.Force("left.z", scale * 0.8j))
    structure = Structure(scale * np.eye(9), K, names, damping=ss.ModalDamping(0.02))
    return Problem(structure, tuple(contacts), forces, ("left.x", "left.z"))
