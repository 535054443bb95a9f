"""A tuned disk on few coordinates of each nodal diameter against itself on all of them."""

import numpy as np
import pytest

from stickslip.model.rigs.octopus_blisk import BliskSector, octopus_blisk
from stickslip.solve.balance.balance import HarmonicBalance
from stickslip.solve.balance.linear_part import LinearPart
from stickslip.solve.continuation.finer_peak import solved_on_all_modes
from stickslip.solve.continuation.newton import correct, fixed
from stickslip.solve.curves.curve import solve_curve

COARSE = BliskSector(sectors=6, cells=(1, 1, 1))
H = 3


@pytest.fixture(scope="module")
def whole():
    return octopus_blisk(sector=COARSE, engine_order=2, modes=8)


@pytest.fixture(scope="module")
def few(whole):
    return whole.truncated(3.0 * H * float(whole.frequencies(stuck=True)[0]))


def test_all_modes_of_every_nodal_diameter_give_the_disk_itself(whole):
    every = whole.truncated(1e9)
    assert every.systems.coordinates == whole.structure.size
    rng, forces = np.random.default_rng(1), np.zeros((len(whole.B), 2 * H + 1))
    forces[:] = rng.standard_normal(forces.shape)
    for omega in (900.0, 1530.0, 2400.0):
        found, expected = (LinearPart(disk, H).motion(forces, omega, 2.0) for disk in (every, whole))
        np.testing.assert_allclose(found, expected, atol=1e-9 * np.abs(expected).max())


def test_each_nodal_diameter_has_modes_and_shapes_of_its_own(whole, few):
    assert few.systems.coordinates < 0.6 * whole.structure.size
    assert few.fingerprint != whole.fingerprint
    for h in range(H + 1):
        shapes, modes = few.systems.kept(h)
        system = whole.systems.at(h)
        stored = shapes.conj().T @ system.K @ shapes
        np.testing.assert_allclose(stored, np.eye(len(stored)), atol=1e-8)
        squares = np.sort(np.linalg.eigvals(np.linalg.solve(system.K, system.M)).real)[::-1][:modes]
        np.testing.assert_allclose(np.diag(shapes.conj().T @ system.M @ shapes).real[:modes][::-1], squares, rtol=1e-6)


@pytest.mark.parametrize("level", [1.0, 100.0])
def test_the_peak_is_close_and_all_modes_give_that_of_the_disk(whole, few, level):
    balances = [HarmonicBalance(disk, H, 128) for disk in (whole, few)]
    resonance = 2.0 * np.pi * float(whole.frequencies(stuck=True)[0])
    curve = solve_curve(balances[1], [0.9 * resonance, 1.05 * resonance], level, exactly=False)
    peak = max(curve.peaks[0], key=lambda point: np.hypot(*point.evaluation.w[balances[1].rows, 1:3]))
    held = fixed("omega", peak.point.omega)
    solved, direct = solved_on_all_modes(*balances, peak.point, held), correct(balances[0], peak.point, held)
    assert direct.converged
    np.testing.assert_allclose(solved.w, direct.evaluation.w, atol=1e-6 * np.abs(direct.evaluation.w).max())
    amplitudes = [np.hypot(*w[balances[0].rows, 1:3]) for w in (peak.evaluation.w, solved.w)]
    assert amplitudes[0] == pytest.approx(amplitudes[1], rel=2e-3)
    assert amplitudes[0] != amplitudes[1]
