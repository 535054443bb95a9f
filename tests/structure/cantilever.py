"""A box of finite elements clamped at y = 0 and loaded across at its tip, with beam theory beside it; and as a rig of studies."""

from functools import cache

import numpy as np

import stickslip as ss
from stickslip.model.structure.cyclic_reduction import craig_bampton
from stickslip.model.structure.solid import STEEL, box_mesh, solid
from stickslip.model.structure.stress import stress_recovery

THICKNESS, LENGTH, DEPTH = 0.02, 0.2, 0.03
INERTIA = DEPTH * THICKNESS**3 / 12.0
PLACES = {"middle": (0.5 * THICKNESS, 0.5 * LENGTH, 0.0), "third": (-0.5 * THICKNESS, 0.3 * LENGTH, 0.5 * DEPTH)}
FIRST = 1.87510407
"""βL of the first bending mode of a clamped beam."""


@cache
def cantilever(modes=80):
    """Mesh, body, kept degrees of freedom and the reduction to the tip's motion."""
    mesh = box_mesh(np.linspace(-0.5, 0.5, 3) * THICKNESS, np.linspace(0.0, LENGTH, 11), np.linspace(-0.5, 0.5, 3) * DEPTH)
    body = solid(mesh).clamp(lambda points: points[:, 1] < 1e-9)
    kept = body.named({"tip": (0.0, LENGTH, 0.0)}, "x")
    return mesh, body, kept, craig_bampton(body.M, body.K, kept, modes)


def static_stress(force, place):
    """σ_yy = −F (L − y) x/I."""
    x, y, _ = place
    return -force * (LENGTH - y) * x / INERTIA


def resonant_stress(tip, place):
    """σ_yy = −E x w''(y) of the first bending mode with so large a motion of the tip."""
    x, y, _ = place
    share = (np.cos(FIRST) + np.cosh(FIRST)) / (np.sin(FIRST) + np.sinh(FIRST))
    shape = [
        np.cosh(s) - c * np.cos(s) - share * (np.sinh(s) - c * np.sin(s)) for s, c in ((FIRST, 1.0), (FIRST * y / LENGTH, -1.0))
    ]
    return -STEEL.young * x * (FIRST / LENGTH) ** 2 * shape[1] / shape[0] * tip


def cantilever_rig(push: float = 100.0) -> ss.Problem:
    """The cantilever shaken at its tip, which a slider on the ground holds a little, under a steady push."""
    slider = ss.Contact("tip", ss.Macroslip(2e4, 0.5, normal_load=10.0), (ss.between("tip.x", "ground"),))
    structure = cantilever(20)[3].structure.with_damping(ss.ModalDamping(0.005))
    return ss.Problem(structure, (slider,), (ss.Force("tip.x", 1.0, static=push),), ("tip.x",))


def cantilever_stress(places):
    """The stress recovery of `cantilever_rig`."""
    mesh, body, _, reduction = cantilever(20)
    return stress_recovery(mesh, body, reduction, places)
