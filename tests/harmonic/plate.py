"""A plate on modes, pressed on the ground over many nodes, each with a normal and two tangential directions."""
import numpy as np
from stickslip import Problem
from stickslip.contact.macroslip import Macroslip
from stickslip.contact.friction_disc import FrictionDisc
from stickslip.contact.point import Contact
from stickslip.loads import Force
from stickslip.structure.damping import ModalDamping
from stickslip.structure.matrices import Structure

def plate(nodes, modes=300, law="macroslip"):
    patterns = modes // 3
    orders = sorted(((a, b) for a in range(30) for b in range(30)), key=lambda o: (o[0]**2 + o[1]**2, o))[:patterns]
    rng = np.random.default_rng(7)
    places = rng.uniform(0.0, 1.0, (nodes, 2))
    field = np.stack([np.cos(np.pi*a*places[:,0])*np.cos(np.pi*b*places[:,1])*np.sqrt((1+(a>0))*(1+(b>0))) for a, b in orders], axis=1)
    turns = [np.linalg.qr(rng.standard_normal((3, 3)))[0] for _ in orders]
    turns[0] = np.eye(3)
    names = tuple(f"{k}.x" for k in range(3*patterns))
    K = np.diag(np.repeat([1.0 + 0.5*(a*a+b*b) for a, b in orders], 3))
    # shapes[node, axis, mode]
    shapes = np.einsum("np,pad->napd", field, np.array(turns)).reshape(nodes, 3, 3*patterns)
    limits = rng.uniform(0.5, 1.5, nodes)
    Law = Macroslip if law == "macroslip" else FrictionDisc
    contacts = tuple(
        Contact(f"node {i}", Law(kt=0.5/nodes, mu=0.5, preload=float(limits[i])/nodes, kn=1.0/nodes),
                tuple(dict(zip(names, shapes[i, axis])) for axis in (0, 1)), dict(zip(names, shapes[i, 2])))
        for i in range(nodes))
    forces = (Force(names[0], 0.6), Force(names[1], 0.4j), Force(names[2], 0.3), Force(names[4], 0.5), Force(names[8], 0.5j))
    structure = Structure(np.eye(3*patterns), K, names, damping=ModalDamping(0.01, on="stuck"))
    return Problem(structure, contacts, forces, (names[0],))
