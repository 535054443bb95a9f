"""Small problems with every kind of contact for the tests of the harmonic balance."""

from __future__ import annotations

import numpy as np

from stickslip.model.contact.cubic import Gap
from stickslip.model.contact.macroslip import Macroslip
from stickslip.model.contact.microslip import MicroslipArray
from stickslip.model.contact.point import Contact, MeanTraction, SliderOffset, Start, TractionRatio, between
from stickslip.model.loads import Force
from stickslip.model.problem import Problem
from stickslip.model.structure.matrices import Structure

DOFS = ("1.x", "1.y", "2.x", "2.y", "3.x", "3.y")


def structure(C: np.ndarray | None = None) -> Structure:
    """Three masses in the plane, coupled and grounded; a little proportional damping unless C is given."""
    rng = np.random.default_rng(8)
    coupling = rng.uniform(-0.2, 0.2, (6, 6))
    K = np.diag([1.0, 2.0, 1.5, 2.5, 1.2, 1.8]) + coupling + coupling.T
    M = np.diag([1.0, 1.0, 0.8, 0.8, 1.3, 1.3])
    return Structure(M, K, DOFS, C=0.02 * K + 0.01 * M if C is None else C)


def everything(start: Start | None = None, C: np.ndarray | None = None) -> Problem:
    """Macroslip of constant and of varying load, a plane array with gaps, and a stop, each with its own start rule."""
    own = (SliderOffset(0.1), TractionRatio(0.3), (MeanTraction(0.05), SliderOffset(-0.1)))
    starts = own if start is None else (start,) * 3
    contacts = (
        Contact("constant", Macroslip(0.8, 0.5, normal_load=1.0), (between("1.x", "ground"),), None, starts[0]),
        Contact("varying", Macroslip(1.0, 0.4, 1.5, 1.0), (between("2.x", "1.x"),), between("2.y", "1.y"), starts[1]),
        Contact(
            "array",
            MicroslipArray.from_totals(0.9, 2.0, 0.3, 0.4, 3),
            (between("3.x", "ground"), between("3.x", "2.x")),
            between("3.y", "ground"),
            starts[2],
        ),
        Contact("stop", Gap(2.0, 0.2), normal=between("1.y", "ground")),
    )
    forces = (Force("1.x", 1.0 - 0.5j), Force("3.y", {1: 0.4j, 2: 0.3}, static=1.0), Force("2.y", static=0.5))
    return Problem(structure(C), contacts, forces, ("1.x", "2.y", "3.x"), "Every kind of contact")
