"""The referee: the steady state of a direct time integration, with lift-off, friction of varying load and a static load."""

import numpy as np
import pytest

from stickslip.analyses.forced_response import forced_response
from stickslip.model.contact.macroslip import Macroslip
from stickslip.model.contact.point import Contact, between
from stickslip.model.loads import Force
from stickslip.model.problem import Problem
from stickslip.model.structure.matrices import Structure

KT, KN, MU, OMEGA = 1.0, 2.0, 0.4, 0.9
STEPS, PERIODS = 2000, 60
FORCES = (Force("1.x", 0.8 - 0.3j), Force("1.y", {1: 0.6j, 2: 0.1}, static=0.4))


def problem() -> Problem:
    K = np.array([[1.0, 0.2], [0.2, 1.5]])
    structure = Structure(np.eye(2), K, ("1.x", "1.y"), C=0.12 * np.eye(2))
    contact = Contact("c", Macroslip(KT, MU, KN, 0.1), (between("1.x", "ground"),), between("1.y", "ground"))
    return Problem(structure, (contact,), FORCES, ("1.x", "1.y"))


def marched() -> np.ndarray:
    """One steady period (STEPS, 2) by velocity Verlet with the damping taken implicitly, second order."""
    K, dt = problem().structure.K, 2.0 * np.pi / OMEGA / STEPS
    angles = 2.0 * np.pi * np.arange(STEPS) / STEPS
    px = [sum((a * np.exp(1j * h * t)).real for h, a in FORCES[0].amplitudes.items()) for t in angles]
    py = [0.4 + sum((a * np.exp(1j * h * t)).real for h, a in FORCES[1].amplitudes.items()) for t in angles]
    x = y = vx = vy = ax = ay = traction = 0.0
    path = np.empty((STEPS, 2))
    for n in range(1, PERIODS * STEPS + 1):
        new_x, new_y = x + dt * vx + 0.5 * dt * dt * ax, y + dt * vy + 0.5 * dt * dt * ay
        normal = max(KN * new_y + 0.1, 0.0)
        traction = min(max(traction + KT * (new_x - x), -MU * normal), MU * normal)
        x, y = new_x, new_y
        fx = px[n % STEPS] - K[0, 0] * x - K[0, 1] * y - traction
        fy = py[n % STEPS] - K[1, 0] * x - K[1, 1] * y - normal
        vx, vy = vx + 0.5 * dt * ax, vy + 0.5 * dt * ay
        ax, ay = (fx - 0.12 * vx) / (1.0 + 0.06 * dt), (fy - 0.12 * vy) / (1.0 + 0.06 * dt)
        vx, vy = vx + 0.5 * dt * ax, vy + 0.5 * dt * ay
        path[n % STEPS] = x, y
    return path


def test_harmonic_balance_is_the_steady_state_of_time_integration():
    path = marched()
    spectrum = np.fft.rfft(path, axis=0).T / STEPS
    spectrum[:, 1:] *= 2.0
    dataset = forced_response(problem(), [OMEGA / (2.0 * np.pi)], harmonics=31, samples=1024).dataset
    assert 0.05 < float(dataset.share_open[0, 0, 0, 2]) < 0.95, "the contact must lift off, or the test shows less than it says"
    assert float(dataset.share_slip[0, 0, 0, 0]) > 0.1
    found = np.asarray(dataset.response[0, 0, :, :, 0] + 1j * dataset.response[0, 0, :, :, 1])
    scale = np.abs(spectrum[:, 1]).max()
    np.testing.assert_allclose(found[:, :6], spectrum[:, :6], atol=1e-4 * scale)
    assert float(dataset.max_abs[0, 0, 0]) == pytest.approx(np.abs(path[:, 0]).max(), rel=2e-4)
