"""Parameters of tests whose contacts were put together in ways that nobody knows."""

import numpy as np
import pytest

import stickslip as ss
from stickslip.laboratory.identification.response.fit import FittedTest
from stickslip.solve.balance.balance import HarmonicBalance
from stickslip.solve.continuation.continuation import first_point
from stickslip.solve.starts.states import start_space

KT, MU = 8e5, 0.4
SETTINGS = {"harmonics": 3, "samples": 128, "tries": 0}


def wedge(kt=KT, mu=MU):
    return ss.rigs.blade_and_wedge(kt=kt, mu=mu)


def hidden(force, seed, frequencies, error=2e-3):
    """Amplitudes of the true wedge from a random start state of all its friction elements."""
    clean = ss.MeasuredResponse(frequencies, 1.0, force, np.zeros(len(frequencies)), "displacement")
    first = first_point(HarmonicBalance(wedge(), 3, 128), 2.0 * np.pi * frequencies[0], force).evaluation
    space = start_space(HarmonicBalance(wedge(), 3, 128), first, "traction_ratio")
    starts = np.random.default_rng(seed).uniform(-1.0, 1.0, space.size)
    model = FittedTest(clean, wedge, 3, 128, [None] * len(frequencies), space)
    size = force * np.abs(model.computed({"kt": KT, "mu": MU}, starts, []).per_force)
    return ss.MeasuredResponse(frequencies, size, force, None, "displacement", name=f"{force:g} N", error=error)


@pytest.mark.slow
def test_hidden_start_states_do_not_bias_the_parameters():
    """Three tests, each with its own start state that nobody knows: free ones find the truth where virgin contacts miss it."""
    frequencies = np.linspace(332.0, 366.0, 9)
    tests = [hidden(force, seed, frequencies) for seed, force in enumerate((2.0, 6.0, 15.0))]
    parameters = {"kt": (1.1e6, 2e5, 4e6), "mu": (0.3, 0.1, 1.0)}
    virgin = ss.identify_response(wedge, parameters, tests, **SETTINGS)
    found = ss.identify_response(wedge, parameters, tests, start_states="free", **SETTINGS)
    assert abs(virgin.values["mu"] / MU - 1.0) > 0.02
    assert found.values == pytest.approx({"kt": KT, "mu": MU}, rel=1e-3)
