"""What all laws have in common that yield from the smallest motion on (`Yielding`): derivatives, forgotten starts, and rest."""

import numpy as np
import pytest
from laws.conftest import STARTS
from laws.kernel import OMEGA, answer, forces, random_motion
from laws.samples import DAHL_SAMPLES, LUGRE_SAMPLES, VALANIS_SAMPLES

from stickslip.model.contact.point import SliderOffset
from stickslip.model.contact.protocol import SLIPPING

H, NT = 3, 64
VIRGIN = SliderOffset()
SAMPLES = (*DAHL_SAMPLES, *VALANIS_SAMPLES, *LUGRE_SAMPLES)


@pytest.fixture(params=SAMPLES, ids=lambda sample: f"{sample.law.name}, {sample.name}")
def sample(request):
    return request.param


@pytest.mark.parametrize("seed", range(5))
def test_derivatives_equal_central_differences(sample, seed):
    """By the motion, and by ω, on which the force depends at fixed harmonics where it depends on the velocity."""
    w = random_motion(sample, H, np.random.default_rng(seed), size=(0.02, 0.1, 0.3, 1.0, 4.0)[seed])
    here, step, rows = answer(sample, VIRGIN, w, NT), 1e-7, slice(0, sample.tangential)
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
    ends = [answer(sample, VIRGIN, w, NT, OMEGA + s * 1e-6).target[rows] for s in (1.0, -1.0)]
    slope = (ends[0] - ends[1]) / 2e-6
    np.testing.assert_allclose(here.by_omega[rows], slope, atol=1e-6 * np.abs(slope).max() + 1e-9)


def test_the_start_is_forgotten_and_every_harmonic_unknown(sample):
    for size in (1e-4, 1e-2, 1.0):
        w = random_motion(sample, H, np.random.default_rng(3), size)
        answers = [answer(sample, start, w, NT) for start in STARTS.values()]
        assert np.all(answers[0].unknown[: sample.tangential] == SLIPPING)
        for other in answers[1:]:
            np.testing.assert_array_equal(other.target, answers[0].target)


def test_a_contact_at_rest_carries_nothing(sample):
    """Without travel the traction is undetermined; it is that of the virgin contact, zero."""
    w = np.zeros((len(sample.stiffness), 2 * H + 1))
    w[:, 0] = 0.3
    np.testing.assert_allclose(forces(sample, VIRGIN, w, NT)[: sample.tangential], 0.0, atol=1e-15)
