"""The damper routine in a blade against the same blade with the damper's body and contacts in the problem."""

import numpy as np

from stickslip.analyses.damper_alone.cycle_dataset import blade_with_routine
from stickslip.analyses.forced_response import forced_response
from stickslip.model.contact.point import Contact
from stickslip.model.loads import Force
from stickslip.model.problem import Problem
from stickslip.model.rigs import laboratory_damper
from stickslip.model.structure.matrices import Structure


def blade() -> Structure:
    """A platform of 1 kg at 200 Hz in x and 260 Hz in y, weakly coupled, 1 % damping."""
    K = np.array([[1.58e6, 2e5], [2e5, 2.67e6]])
    return Structure(np.eye(2), K, ("left.x", "left.y"), C=np.diag([25.0, 33.0]))


def with_body(rig, forces) -> Problem:
    """The damper's body, nearly without mass, and its contacts in one problem with the blade."""
    M, K, C = (np.zeros((5, 5)) for _ in range(3))
    M[:2, :2], K[:2, :2], C[:2, :2] = blade().M, blade().K, blade().C
    M[2:, 2:] = 1e-6 * rig.matrices[0]
    structure = Structure(M, K, ("left.x", "left.y", "damper.x", "damper.y", "damper.rz"), C=C)
    contacts = [Contact(c.name, c.law, tuple(grounded(d) for d in c.tangential), grounded(c.normal)) for c in rig.contacts]
    return Problem(structure, tuple(contacts), (*forces, Force("damper.y", static=50.0)), ("left.x", "left.y"))


def grounded(direction):
    """The direction with the right platform at rest."""
    return {dof: value for dof, value in direction.items() if not dof.startswith("right")}


def test_the_routine_stands_for_the_body():
    """At 11 µm, in gross slip: what differs is the truncated motion of the damper's body, which the routine does not truncate."""
    rig, forces = laboratory_damper(45.0, 50.0, (0.14, 0.13, 0.13)), (Force("left.x", 60.0),)
    routine = blade_with_routine(blade(), ("left.x", "left.y"), rig, forces, 420.0, harmonics=15, steps=1024)
    first, missed = routine.platform[:, 1:3] * [1.0, -1.0], {}
    for harmonics in (5, 41):
        balance = forced_response(with_body(rig, forces), [420.0], [1.0], harmonics=harmonics, samples=1024).dataset
        assert int(balance.outcome[0, 0]) == 1
        assert float(balance.share_slip.max()) > 0.9
        missed[harmonics] = np.abs(first - balance.response.values[0, 0, :, 1]).max() / np.abs(first).max()
    assert missed[5] < 4e-3
    assert missed[41] < 1e-4
