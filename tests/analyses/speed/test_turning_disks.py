"""Problems of a disk at two speeds between which its blades turn: in Campbell diagrams and in speed sweeps."""

from dataclasses import replace

import numpy as np
import pytest
from scipy import linalg

import stickslip as ss
from stickslip.analyses.speed.models import ProblemAt, synchronous
from stickslip.model.structure.cyclic import cyclic


def problem(degrees, static):
    """Six sectors of four masses in a line that is 10⁴ times as stiff along one direction, coupled to the next sector."""
    angle, line = np.radians(degrees), 2.0 * np.eye(4) - np.eye(4, k=1) - np.eye(4, k=-1)
    turn = np.array([[np.cos(angle), -np.sin(angle)], [np.sin(angle), np.cos(angle)]])
    K = np.kron(line @ line, turn @ np.diag([1.0, 1e4]) @ turn.T)
    one, other = np.eye(8)[[0, 2]]
    waves = []
    for n in range(4):
        apart = one - np.exp(-2j * np.pi * n / 6) * other
        waves.append(K + np.outer(apart.conj(), apart))
    M = np.kron(np.diag(np.linspace(1.0, 3.0, 4)), np.eye(2))
    names = tuple(f"{node}.{direction}" for node in range(4) for direction in "xy")
    disk = replace(cyclic(6, names, np.array([M] * 4, dtype=complex), np.array(waves)), turns=True)
    return ss.TunedDisk(disk, contacts=(), forces=(ss.Force("3.x", 1.0, static=static),), outputs=("3.x",), engine_order=1)


MODELS = {6000.0: problem(0.0, 1.0), 9000.0: problem(1.0, 2.0)}


def lowest(structure):
    return linalg.eigh(structure.stiffnesses[1], structure.masses[1], eigvals_only=True)[0]


@pytest.mark.parametrize("speed", [0.0, 3000.0, 7500.0, 15000.0])
def test_a_disk_whose_blades_turn_has_a_problem_at_all_speeds(speed):
    """The straight line through both K has a negative stiffness at rest and at 15 000 rev/min, and refused them."""
    share = (speed**2 - 6000.0**2) / (9000.0**2 - 6000.0**2)
    found = ProblemAt(MODELS)(speed)
    assert lowest(found.structure) == pytest.approx(lowest(problem(share, 1.0).structure), rel=0.05)
    assert found.forces[0].static == pytest.approx(1.0 + share)


def test_at_the_speeds_of_the_models_k_is_theirs_to_the_last_bit():
    for speed, model in MODELS.items():
        np.testing.assert_array_equal(ProblemAt(MODELS)(speed).structure.stiffnesses, model.structure.stiffnesses)


def test_in_a_sweep_k_is_the_straight_line_through_both_models():
    """That at rest was the turned one, and its slope the straight one."""
    models = {6000.0: problem(0.0, 0.0), 9000.0: problem(0.05, 0.0)}
    found = synchronous(models)
    for speed, model in models.items():
        K = found.structure.stiffnesses + (2.0 * np.pi * speed / 60.0) ** 2 * found.speed.stiffness
        np.testing.assert_allclose(K, model.structure.stiffnesses, rtol=0.0, atol=1e-9 * np.abs(K).max())
