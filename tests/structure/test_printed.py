"""What large objects print: their sizes on one line, not their matrices and all their names."""

from dataclasses import replace

import numpy as np
import pytest

import stickslip as ss
from stickslip.model.readers.model import Model
from stickslip.model.structure.matrices import symmetric_sparse
from stickslip.model.structure.stress import StressRecovery

CHAIN = ss.Structure(np.eye(300), np.eye(300), tuple(f"{k}.x" for k in range(300)))
MASS, DISK = ss.rigs.single_mass(), ss.rigs.lumped_blisk(sectors=6)


@pytest.mark.parametrize(
    ("thing", "said"),
    [
        (MASS, "Problem 'Single mass': 1 degree of freedom, 1 contact (1 row), 1 force, outputs 1.x"),
        (CHAIN, "Structure: 300 degrees of freedom (0.x, 1.x, ..., 299.x), undamped"),
        (CHAIN.with_damping(ss.ModalDamping(np.full(300, 0.01))), "299.x), ModalDamping"),
        (MASS.structure, "Structure: 1 degree of freedom (1.x), with C"),
        (DISK.structure, "CyclicStructure: 5 degrees of freedom (disk.t, platform.t, ..., damper.y), with C, 6 sectors"),
        (DISK, "5 degrees of freedom, 2 contacts (4 rows), 2 forces, outputs tip.t; one of 6 sectors, engine order 2"),
        (DISK.full(), "12 forces, outputs 1/tip.t, 2/tip.t, 3/tip.t, 4/tip.t, ...; 6 sectors, engine order 2"),
        (
            Model(*[symmetric_sparse("M", np.eye(300), 300)] * 2, CHAIN.dofs, nodes={"1": (0.0, 0.0, 0.0)}, file="a.inp"),
            "Model 'a.inp': 300 degrees of freedom (0.x, 1.x, ..., 299.x), 1 node with coordinates",
        ),
        (
            StressRecovery(("root",), np.zeros((1, 6, 300)), CHAIN.dofs),
            "StressRecovery: 1 place from 300 degrees of freedom (0.x",
        ),
    ],
)
def test_a_large_object_is_one_line(thing, said):
    assert said in repr(thing)
    assert repr(thing) == str(thing)
    assert len(repr(thing)) < 250
    assert "\n" not in repr(thing)


def test_what_tells_problems_apart_is_not_what_they_print():
    retitled, heavier = (
        replace(MASS, title="another"),
        MASS.with_structure(replace(MASS.structure, M=2.0 * MASS.structure.M)),
    )
    assert repr(heavier) == repr(MASS) != repr(retitled)
    assert heavier.fingerprint != MASS.fingerprint == retitled.fingerprint
