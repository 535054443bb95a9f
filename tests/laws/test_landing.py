"""Contacts that lift off and land between samples: every law is of second order in the samples, whether it sticks then or slips.

From the sample after the landing on, the force would be of first order: 1e-2 at 256 samples where it sticks.
"""

from dataclasses import replace

import numpy as np
import pytest
from laws.kernel import forces, random_motion
from laws.samples import DAHL_SAMPLES, EVERY_SAMPLE, LUGRE_SAMPLES, VALANIS_SAMPLES
from stability.hybrid import of_problem
from stability.test_multipliers import SLIDERS, solved, start

import stickslip as ss
from stickslip.model.contact.point import SliderOffset

ROUGH = 4.0
"""A coefficient of friction with which contacts stick soon after they land."""
FEWEST, MOST, REFERENCE = 64, 4096, 65536
LANDING = [s for s in EVERY_SAMPLE if s.law.has_normal and s.law.has_friction]


def errors(sample, counts):
    """Relative errors of the tangential forces under ten motions, rms, by the number of samples."""
    found = []
    for seed in range(10):
        w = random_motion(sample, 2, np.random.default_rng(seed), 2.0)
        *few, many = (forces(sample, SliderOffset(), w, n)[: sample.tangential] for n in (*counts, REFERENCE))
        found.append([np.abs(each - many).max() / np.abs(many).max() for each in few])
    return np.sqrt(np.mean(np.square(found), axis=0))


@pytest.mark.parametrize("sample", LANDING, ids=lambda sample: sample.name)
def test_forces_are_of_second_order_where_contacts_land_and_stick(sample):
    """Dahl's, Valanis' and the LuGre law, whose limit begins at nothing, are of order 1.5."""
    faster = {"mu_static": 1.3 * ROUGH} if sample in LUGRE_SAMPLES else {}
    mu = sample.law.mu
    mu = ROUGH / max(mu.values) * mu if isinstance(mu, ss.LoadDependentFriction) else ROUGH
    rough = replace(sample, law=replace(sample.law, mu=mu, **faster))
    few, some, many = errors(rough, (FEWEST, 256, MOST))
    assert some < 8e-4
    order = np.log2(few / many) / np.log2(MOST / FEWEST)
    assert order > (1.3 if sample in (*DAHL_SAMPLES, *VALANIS_SAMPLES, *LUGRE_SAMPLES) else 1.7)


def event_exact(name):
    """First harmonic [m] of the outputs of a lifting mass, integrated by SciPy from event to event."""
    problem, frequency, level, *_ = SLIDERS[name]
    map_, (evaluation,) = solved(problem, [frequency], level)
    state, modes = start(map_, evaluation)
    exact, omega = of_problem(problem, level), evaluation.point.omega
    motion = exact.motion(exact.settled(state, modes, omega)[1], modes, omega, REFERENCE)
    rows = [problem.structure.dofs.index(output) for output in problem.outputs]
    return np.abs(2.0 * np.fft.rfft(motion[rows], axis=1)[:, 1]) / REFERENCE


@pytest.mark.parametrize(
    ("name", "order"), [pytest.param("lands and sticks", 2.0, marks=pytest.mark.nightly), ("lands and slips", 2.0)]
)
def test_responses_with_landings_are_of_second_order(name, order):
    """Of a mass that is open for half of the period, against integration from event to event: 2e-4 at 64 samples, of a law that
    begins at samples 2e-3; 6e-4 at 256."""
    problem, frequency, level, *_ = SLIDERS[name]
    exact = event_exact(name)

    def error(samples, harmonics):
        found = ss.forced_response(problem, [frequency], level, harmonics=harmonics, samples=samples).dataset
        return float(np.max(np.abs(found.amplitude.values[0, 0] / exact - 1.0)))

    assert error(256, 41) < 2e-5
    assert np.log2(error(64, 9) / error(4096, 81)) / 6.0 > order - 0.3
