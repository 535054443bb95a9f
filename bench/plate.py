"""A plate on modes, pressed on the ground over many nodes, each with a normal and two tangential directions.

Modes of unit mass: products of cosines over the unit square, three for each pair of wave numbers a, b with turned directions of
motion, of stiffness 1 + (a² + b²)/2. The nodes lie at random places and share one contact stiffness and one preload, so the
motion hardly depends on how many they are.
"""

from __future__ import annotations

import numpy as np

from stickslip import Problem
from stickslip.model.contact.friction_disc import FrictionDisc
from stickslip.model.contact.macroslip import Macroslip
from stickslip.model.contact.point import Contact
from stickslip.model.loads import Force
from stickslip.model.structure.matrices import ModalDamping, Structure
from stickslip.support.checks import Array

LAWS = {"friction disc": FrictionDisc, "macroslip": Macroslip}
TANGENTIAL, NORMAL, PRELOAD, FRICTION = 0.5, 1.0, 1.0, 0.5
"""Stiffnesses and preload of all nodes together; friction coefficient."""
DAMPING = 0.01


def plate(nodes: int, modes: int, law: str) -> Problem:
    """The plate with a law of `LAWS` at every node; modes: a multiple of 3."""
    rng = np.random.default_rng(7)
    orders = _orders(modes // 3)
    names = tuple(f"{k}.x" for k in range(modes))
    shapes = _shapes(orders, rng.uniform(0.0, 1.0, (nodes, 2)), rng)
    shares = rng.uniform(0.5, 1.5, nodes) / nodes
    contacts = tuple(
        Contact(
            f"node {i}",
            LAWS[law](kt=TANGENTIAL / nodes, mu=FRICTION, kn=NORMAL / nodes, preload=PRELOAD * float(shares[i])),
            (dict(zip(names, t1, strict=True)), dict(zip(names, t2, strict=True))),
            dict(zip(names, n, strict=True)),
        )
        for i, (t1, t2, n) in enumerate(shapes)
    )
    stiffness = np.repeat([1.0 + 0.5 * (a * a + b * b) for a, b in orders], 3)
    structure = Structure(np.eye(modes), np.diag(stiffness), names, damping=ModalDamping(DAMPING, on="stuck"))
    pushes = {0: 0.6, 1: 0.4j, 2: 0.3, 4: 0.5, 8: 0.5j}
    return Problem(structure, contacts, tuple(Force(names[k], push) for k, push in pushes.items()), names[:1])


def _orders(count: int) -> list[tuple[int, int]]:
    """The lowest pairs of wave numbers."""
    return sorted(((a, b) for a in range(count) for b in range(count)), key=lambda pair: (pair[0] ** 2 + pair[1] ** 2, pair))[
        :count
    ]


def _shapes(orders: list[tuple[int, int]], places: Array, rng: np.random.Generator) -> Array:
    """Motion of the nodes along x, y and z in each mode, (nodes, 3, modes)."""
    cosines = [
        np.cos(np.pi * order * places[:, axis]) * np.sqrt(1 + (order > 0)) for pair in orders for axis, order in enumerate(pair)
    ]
    turns = [np.linalg.qr(rng.standard_normal((3, 3)))[0] for _ in orders]
    turns[0] = np.eye(3)
    fields = [x * y for x, y in zip(cosines[::2], cosines[1::2], strict=True)]
    return np.concatenate([field[:, None, None] * turn for field, turn in zip(fields, turns, strict=True)], axis=2)
