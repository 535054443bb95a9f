"""Exact derivatives by the start states against central differences of solutions."""

import numpy as np
import pytest
from balance.problems import everything

from stickslip.model.rigs import single_blade, three_mass_wedge
from stickslip.solve.balance.balance import HarmonicBalance
from stickslip.solve.balance.energy import EnergyBalance
from stickslip.solve.balance.measure import DISPLACEMENT_AMPLITUDE, measure_of
from stickslip.solve.starts.extremes import AtFrequency, AtPeak, loss_factor, size_of
from stickslip.solve.starts.states import explored_space

STEP = 1e-6


@pytest.fixture(scope="module")
def problems():
    blade = single_blade(4.6, modes=20)
    return {"wedge": (three_mass_wedge(), 222.0, 1.0), "random": (everything(), 0.25, 0.5), "rig": (blade, 535.0, 20.0)}


def place_at(problem, frequency, level, rule, objective):
    balance = HarmonicBalance(problem, 3, 128)
    omega = 2.0 * np.pi * frequency
    space = explored_space(balance, [omega], level, rule)
    target = loss_factor(EnergyBalance(balance)) if objective == "loss_factor" else size_of(0, measure_of(*objective.split()))
    return AtFrequency(balance, space, target, omega, level)


@pytest.mark.parametrize("objective", ["displacement amplitude", "acceleration rms", "velocity max_abs", "loss_factor"])
@pytest.mark.parametrize(
    ("name", "rule"),
    [
        ("wedge", "slider_offset"),
        ("wedge", "traction_ratio"),
        ("wedge", "mean_traction"),
        ("random", "slider_offset"),
        ("random", "traction_ratio"),
        ("random", "mean_traction"),
        ("rig", "slider_offset"),
    ],
)
def test_gradient_along_random_directions(problems, name, rule, objective):
    place = place_at(*problems[name], rule, objective)
    rng = np.random.default_rng(3)
    variables = rng.uniform(-0.1, 0.1, place.space.size)
    found, gradient = place.value(variables)
    assert np.linalg.norm(gradient) > 1e-4 * abs(found.value)
    for _ in range(3):
        direction = rng.standard_normal(variables.size)
        high, low = (place.value(variables + side * STEP * direction)[0].value for side in (1.0, -1.0))
        expected = (high - low) / (2.0 * STEP)
        assert gradient @ direction == pytest.approx(expected, abs=1e-6 * np.linalg.norm(gradient) * np.linalg.norm(direction))


@pytest.mark.parametrize("measure", [DISPLACEMENT_AMPLITUDE, measure_of("acceleration", "rms")], ids=lambda one: one.words)
def test_gradient_at_the_peak(measure):
    """At a maximum over frequency the derivative of the peak is the one at fixed frequency, whatever it is a maximum of.

    The differences are coarse, since cusps of the samples make the peak rough in the sixth digit.
    """
    balance = HarmonicBalance(three_mass_wedge(), 5, 256)
    band = (2.0 * np.pi * 200.0, 2.0 * np.pi * 235.0)
    space = explored_space(balance, band, 1.0)
    place = AtPeak(balance, space, 0, measure, band, 1.0)
    variables = np.array([0.3, 0.2])
    _, gradient = place.value(variables)
    differences = [
        (place.value(variables + 0.01 * unit)[0].value - place.value(variables - 0.01 * unit)[0].value) / 0.02
        for unit in np.eye(2)
    ]
    np.testing.assert_allclose(gradient, differences, atol=0.04 * np.linalg.norm(gradient))
