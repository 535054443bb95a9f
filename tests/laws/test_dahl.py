"""Dahl's law against brute-force marching, differences, its closed forms, and the Jenkins element it goes over to."""

import numpy as np
import pytest
from laws.kernel import cycle, forces, motion_of, random_motion
from laws.marching import harmonics_of, marched_by
from laws.samples import DAHL_SAMPLES

from stickslip.model.contact.dahl import Dahl
from stickslip.model.contact.macroslip import Macroslip
from stickslip.model.contact.point import SliderOffset
from stickslip.solve.balance.energy import cycle_work
from stickslip.support.checks import InputError

H, NT = 3, 64
VIRGIN = SliderOffset()


@pytest.fixture(params=DAHL_SAMPLES, ids=lambda sample: sample.name)
def sample(request):
    return request.param


def stepped(kt, traction, du, before, after, pieces):
    """One step in plain Python: dT = kt (1 − s T/L) du in many small pieces by Heun's rule, L the mean limit; clipped."""
    if after <= 0.0:
        return 0.0
    limit, s = 0.5 * (before + after), np.sign(du)
    for _ in range(pieces):
        first = kt * (1.0 - s * traction / limit) * du / pieces
        second = kt * (1.0 - s * (traction + first) / limit) * du / pieces
        traction += 0.5 * (first + second)
    return min(max(traction, -after), after)


@pytest.mark.parametrize("seed", range(3))
def test_forces_equal_brute_force_marching(sample, seed):
    """Of the ODE in small pieces, second order: extrapolated to none."""
    w = random_motion(sample, H, np.random.default_rng(seed), size=(0.4, 1.0, 4.0)[seed])
    element, motion = sample.elements[0], motion_of(sample, w, NT)
    steps = (lambda *given, pieces=pieces: stepped(element.kt, *given, pieces) for pieces in (80, 160))
    coarse, fine = (marched_by(step, element, motion, 60, 1e-13) for step in steps)
    expected, rows = (4.0 * fine - coarse) / 3.0, slice(0, sample.tangential)
    np.testing.assert_allclose(cycle(sample, VIRGIN, w, NT).force[rows], expected, atol=2e-6)
    np.testing.assert_allclose(forces(sample, VIRGIN, w, NT)[rows], harmonics_of(expected, H), atol=2e-6)


@pytest.mark.parametrize("amplitude", [0.02, 0.3, 1.0, 10.0])
def test_loop_energy_in_closed_form(amplitude):
    """4 L (A − L/kt tanh(kt A/L)): as slip work exactly, samples at both reversals; as work of the force to fourth order."""
    law = DAHL_SAMPLES[0]
    w, expected = np.array([[0.0, amplitude, 0.0]]), law.law.loop_energy(amplitude)
    assert cycle(law, VIRGIN, w, 64).slip_work[0] == pytest.approx(expected, rel=1e-12)
    errors = [cycle_work(forces(law, VIRGIN, w, n), w)[0] / expected - 1.0 for n in (64, 256)]
    assert abs(errors[1]) < 1e-7
    assert np.log2(errors[0] / errors[1]) / 2.0 == pytest.approx(4.0, abs=0.1)


def test_virgin_curve_in_closed_form():
    """T = L (1 − exp(−kt u/L)) by the ODE in small pieces, either way; nothing where no load presses."""
    law = Dahl(2.0, 0.5, 3.0, 0.4)
    for z, limit in ((0.0, 0.2), (0.3, 0.65)):
        for u in (-0.7, 0.05, 0.4):
            assert law.virgin_curve(u, z) == pytest.approx(stepped(2.0, 0.0, u, limit, limit, 20000), rel=1e-8)
    assert law.virgin_curve(1.0, -1.0) == 0.0
    assert law.loop_energy(1.0, -1.0) == 0.0


def test_large_motion_is_that_of_the_jenkins_element():
    """Both lose 4 L (A − L/kt) to a share exp(−2 kt A/L)."""
    dahl, jenkins = Dahl(2.0, 0.5, normal_load=0.4), Macroslip(2.0, 0.5, normal_load=0.4)
    assert dahl.loop_energy(3.0) == pytest.approx(jenkins.loop_energy(3.0), rel=1e-12)
    assert dahl.loop_energy(0.05) > jenkins.loop_energy(0.05) == 0.0


def test_parameters_are_checked():
    for options, said in (
        ({"kt": 0.0, "mu": 0.3, "normal_load": 1.0}, "kt must be positive"),
        ({"kt": 1.0, "mu": 0.3}, "exactly"),
    ):
        with pytest.raises(InputError, match=said):
            Dahl(**options)
