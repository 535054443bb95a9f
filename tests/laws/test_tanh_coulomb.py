"""Tanh-regularised Coulomb friction against its formula, differences by motion and frequency, and its two limits."""

import numpy as np
import pytest
from laws.kernel import OMEGA, answer, cycle, forces, random_motion
from laws.marching import harmonics_of, sampled
from laws.samples import TANH_SAMPLES

from stickslip.model.contact.point import Contact, SliderOffset, between
from stickslip.model.contact.protocol import SLIPPING
from stickslip.model.contact.tanh_coulomb import TanhCoulomb
from stickslip.solve.balance.energy import cycle_work
from stickslip.support.checks import InputError

H, NT = 3, 64
VIRGIN = SliderOffset()


@pytest.fixture(params=TANH_SAMPLES, ids=lambda sample: sample.name)
def sample(request):
    return request.param


def velocity_of(w, samples, omega):
    """Samples of dw/dt (rows, Nt): a cos + b sin becomes ω h (b cos − a sin)."""
    order, turned = np.arange(1, (w.shape[1] + 1) // 2), np.zeros_like(w)
    turned[:, 1::2], turned[:, 2::2] = omega * order * w[:, 2::2], -omega * order * w[:, 1::2]
    return sampled(turned, samples)


@pytest.mark.parametrize("omega", [0.3, OMEGA, 5.0])
def test_forces_are_those_of_the_formula(sample, omega):
    w, rows = random_motion(sample, H, np.random.default_rng(1)), slice(0, sample.tangential)
    element, signals = sample.elements[0], sampled(w, NT)
    limit = element.limit(signals[-1] if sample.law.has_normal else np.zeros(NT))
    expected = limit * np.tanh(velocity_of(w, NT, omega)[rows] / sample.law.v0)
    found = answer(sample, VIRGIN, w, NT, omega)
    np.testing.assert_allclose(found.target[rows], harmonics_of(expected, H), atol=1e-13)
    assert np.all(found.unknown[rows] == SLIPPING)
    if omega == OMEGA:
        np.testing.assert_allclose(cycle(sample, VIRGIN, w, NT).force[rows], expected, atol=1e-13)


@pytest.mark.parametrize("seed", range(3))
def test_derivatives_equal_central_differences(sample, seed):
    """By both motions and by ω."""
    w, step = random_motion(sample, H, np.random.default_rng(seed), size=(0.05, 0.3, 2.0)[seed]), 1e-6
    here = answer(sample, VIRGIN, w, NT)
    scale = max(np.abs(here.own).max(), np.abs(here.normal).max())
    for row in range(w.shape[0]):
        for column in range(w.shape[1]):
            change = np.zeros_like(w)
            change[row, column] = step
            slope = (forces(sample, VIRGIN, w + change, NT) - forces(sample, VIRGIN, w - change, NT)) / (2.0 * step)
            for d in range(sample.tangential):
                block = here.own[d] if row == d else here.normal[d] if row >= sample.tangential else np.zeros_like(here.own[d])
                np.testing.assert_allclose(block[:, column], slope[d], atol=1e-7 * scale)
    ends = [forces(sample, VIRGIN, w, NT, OMEGA + s * step) for s in (1.0, -1.0)]
    np.testing.assert_allclose(here.by_omega, (ends[0] - ends[1]) / (2.0 * step), atol=1e-8 * scale)


def test_a_slow_motion_is_that_of_a_dashpot():
    """|v| << v0: T = L/v0 v, work π c ω A²."""
    law = TANH_SAMPLES[0]
    w = np.array([[0.0, 1e-4, 0.0]])
    viscous = law.elements[0].mu * law.elements[0].load / law.law.v0
    work = cycle_work(forces(law, VIRGIN, w, NT), w)[0]
    assert work == pytest.approx(np.pi * viscous * OMEGA * 1e-8, rel=1e-6)


def test_a_fast_motion_is_that_of_a_slider_without_spring():
    """v0 -> 0: the loop is a rectangle, 4 L A."""
    law = TanhCoulomb(0.5, 1e-5, normal_load=1.2)
    fast = type(TANH_SAMPLES[0])("fast", law, 1, TANH_SAMPLES[0].elements)
    w = np.array([[0.0, 0.7, 0.0]])
    assert cycle_work(forces(fast, VIRGIN, w, 4096), w)[0] == pytest.approx(4.0 * 0.6 * 0.7, rel=1e-5)


def test_faulty_parameters_and_questions_without_a_velocity_are_refused():
    with pytest.raises(InputError, match="v0 must be positive"):
        TanhCoulomb(0.5, 0.0, normal_load=1.0)
    with pytest.raises(InputError, match="exactly one of the two"):
        TanhCoulomb(0.5, 0.1)
    with pytest.raises(InputError, match="exactly when kn is given"):
        Contact("c", TanhCoulomb(0.5, 0.1, normal_load=1.0), (between("1.x", "ground"),), between("1.y", "ground"))
    law = TanhCoulomb(0.5, 0.1, normal_load=1.0)
    for ask in (lambda: law.loop_energy(1.0), lambda: law.virgin_curve(1.0)):
        with pytest.raises(InputError, match="tanh_coulomb contact must be asked for at a"):
            ask()
