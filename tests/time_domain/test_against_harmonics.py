"""Time integration against the harmonic balance, from the state of the harmonic solution and from rest."""

import numpy as np
import pytest
from time_domain.systems import damped_wedge, line_contact, orbiting_mass, rubbing_mass, stop

from stickslip.analyses.forced_response import forced_response
from stickslip.analyses.time_response import time_response
from stickslip.rigs import single_mass


def checked(problem, frequencies, harmonics, samples=2048, **options):
    response = forced_response(problem, frequencies, harmonics=harmonics, samples=samples)
    found = response.verify_in_time(0, len(frequencies) - 1, **options)
    assert found.periodic, found.sentence
    return found


def radians(*omega):
    return [w / (2.0 * np.pi) for w in omega]


@pytest.mark.parametrize(
    ("problem", "omega", "harmonics", "tolerance"),
    [
        (single_mass(), 1.1, 31, 2e-5),
        (rubbing_mass(), 0.9, 31, 2e-4),
        (line_contact(), 1.7, 31, 3e-4),
        (orbiting_mass(varying=False), 0.9, 31, 5e-5),
        (orbiting_mass(varying=True), 0.9, 31, 5e-5),
        (stop(), 0.8, 61, 1e-3),
    ],
    ids=["Jenkins", "lift-off", "microslip array", "disc", "disc of varying load", "gap and massless slider"],
)
def test_small_structures(problem, omega, harmonics, tolerance):
    """A massless slider moves by jumps of its velocity: its harmonics fall slowly, 5e-4 of the period is left at 61."""
    found = checked(problem, radians(0.3 * omega, omega), harmonics)
    assert found.agrees(tolerance), found.sentence
    assert float(found.time.dataset.energy_residual) < 5e-5


def test_the_difference_to_few_harmonics_is_that_of_the_harmonics_left_out():
    coarse, fine = (checked(single_mass(), radians(0.3, 1.1), harmonics) for harmonics in (1, 21))
    response = [forced_response(single_mass(), radians(0.3, 1.1), harmonics=h, samples=2048) for h in (1, 21)]
    left_out = float(response[0].dataset.amplitude[0, 1, 0] / response[1].dataset.amplitude[0, 1, 0]) - 1.0
    assert abs(left_out) > 5e-3
    assert coarse.amplitude_difference[0] == pytest.approx(left_out, rel=1e-2)
    assert abs(fine.amplitude_difference[0]) < 1e-2 * abs(left_out)


def test_from_rest_a_unique_response_is_the_same():
    """A slider that slips in every period forgets where it started."""
    problem, frequency = single_mass(), 1.1 / (2.0 * np.pi)
    rest = time_response(problem, frequency).dataset
    balanced = forced_response(problem, [0.05, frequency], harmonics=21, samples=2048).dataset
    harmonics = balanced.response[0, 1, :, :6].to_numpy()
    np.testing.assert_allclose(rest.response[:, :6].to_numpy(), harmonics, atol=2e-5 * float(rest.amplitude[0]))
    force = balanced.contact_force[0, 1, 0, 0, :4].to_numpy()
    np.testing.assert_allclose(rest.contact_force[0, 0, :4].to_numpy(), force, atol=1e-4)
    assert float(rest.dissipated[0]) == pytest.approx(float(balanced.dissipated[0, 1, 0]), rel=1e-4)


def test_the_start_state_decides_which_response_of_the_wedge_it_is():
    """At 222 Hz the three ratios give three responses; each stays what it is when integrated from its own sliders."""
    found = [checked(damped_wedge(ratio), [145.0, 222.0], 21, 1024, tolerance=1e-5) for ratio in (-1.0, 0.0, 1.0)]
    for one in found:
        assert one.agrees(1e-4), one.sentence
    amplitudes = [one.time_amplitude[0] for one in found]
    assert amplitudes[1] / amplitudes[0] > 1.3
    assert amplitudes[2] / amplitudes[1] > 1.2


def test_an_unstable_solution_of_the_harmonic_balance_is_found_out():
    """The line contact at 0.9 rad/s: a solution to rounding in frequency, from which every time integration departs."""
    response = forced_response(line_contact(), radians(0.27, 0.9), harmonics=31, samples=2048)
    assert float(response.dataset.residual[0, 1]) < 1e-10
    found = response.verify_in_time(0, 1, periods=150)
    assert not found.periodic
    assert "the difference has grown: a periodic motion is unstable here" in found.sentence
