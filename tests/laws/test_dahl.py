"""Dahl's law against brute-force marching, differences, its closed forms, and the Jenkins element it goes over to."""

import numpy as np
import pytest
from laws.conftest import STARTS
from laws.kernel import answer, cycle, forces, motion_of, random_motion
from laws.marching import harmonics_of
from laws.samples import DAHL_SAMPLES

from stickslip.model.contact.dahl import Dahl
from stickslip.model.contact.macroslip import Macroslip
from stickslip.model.contact.period import SLIPPING
from stickslip.model.contact.start import SliderOffset
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


def marched(sample, w, samples, pieces, periods=60):
    """Tractions (directions, Nt) step by step in plain Python, from rest, period after period."""
    element, motion = sample.elements[0], motion_of(sample, w, samples)
    limit, landings = element.mu * element.normal(motion.normal), element.landings(motion.normal)
    rows = []
    for u in motion.tangential:
        traction, found = 0.0, np.empty(samples)
        for _ in range(periods):
            last = traction
            for n in range(samples):
                moved = (1.0 - landings[n]) * (u[n] - u[n - 1])
                traction = stepped(element.kt, traction, moved, limit[n - 1], limit[n], pieces)
                found[n] = traction
            if abs(traction - last) < 1e-13:
                break
        rows.append(found)
    return np.array(rows)


@pytest.mark.parametrize("seed", range(3))
def test_forces_equal_brute_force_marching(sample, seed):
    """Of the ODE in small pieces, second order: extrapolated to none."""
    w = random_motion(sample, H, np.random.default_rng(seed), size=(0.4, 1.0, 4.0)[seed])
    coarse, fine = (marched(sample, w, NT, pieces) for pieces in (80, 160))
    expected, rows = (4.0 * fine - coarse) / 3.0, slice(0, sample.tangential)
    np.testing.assert_allclose(cycle(sample, VIRGIN, w, NT).force[rows], expected, atol=2e-6)
    np.testing.assert_allclose(forces(sample, VIRGIN, w, NT)[rows], harmonics_of(expected, H), atol=2e-6)


@pytest.mark.parametrize("seed", range(5))
def test_derivatives_equal_central_differences(sample, seed):
    w = random_motion(sample, H, np.random.default_rng(seed), size=(0.02, 0.1, 0.3, 1.0, 4.0)[seed])
    here, step = answer(sample, VIRGIN, w, NT), 1e-7
    scale = max(np.abs(here.own).max(), np.abs(here.normal).max())
    for row in range(w.shape[0]):
        for column in range(w.shape[1]):
            change = np.zeros_like(w)
            change[row, column] = step
            ends = [answer(sample, VIRGIN, w + s * change, NT).target for s in (1.0, -1.0)]
            slope = (ends[0] - ends[1]) / (2.0 * step)
            for d in range(sample.tangential):
                block = here.own[d] if row == d else here.normal[d] if row >= sample.tangential else np.zeros_like(here.own[d])
                np.testing.assert_allclose(block[:, column], slope[d], atol=3e-6 * scale)


def test_the_start_is_forgotten_and_every_harmonic_unknown(sample):
    for size in (1e-4, 1e-2, 1.0):
        w = random_motion(sample, H, np.random.default_rng(3), size)
        found = [answer(sample, start, w, NT) for start in STARTS.values()]
        assert np.all(found[0].unknown[: sample.tangential] == SLIPPING)
        for other in found[1:]:
            np.testing.assert_array_equal(other.target, found[0].target)


def test_a_contact_at_rest_carries_nothing(sample):
    """Without travel the traction is undetermined; it is that of the virgin contact, zero."""
    w = np.zeros((len(sample.stiffness), 2 * H + 1))
    w[:, 0] = 0.3
    np.testing.assert_allclose(forces(sample, VIRGIN, w, NT)[: sample.tangential], 0.0, atol=1e-15)


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
