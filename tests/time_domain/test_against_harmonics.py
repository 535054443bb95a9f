"""Time integration against the harmonic balance, from the state of the harmonic solution and from rest."""

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from time_domain.systems import damped_wedge, line_contact, orbiting_mass, rubbing_mass, stop

from stickslip.analyses.forced_response import forced_response
from stickslip.analyses.time_response import time_response
from stickslip.model.contact.cubic import CubicSpring
from stickslip.model.contact.point import Contact, between
from stickslip.model.loads import Force
from stickslip.model.problem import Problem
from stickslip.model.rigs import single_mass
from stickslip.model.structure.matrices import Structure
from stickslip.support.units import radians_per_second


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
        pytest.param(line_contact(), 1.7, 31, 3e-4, marks=pytest.mark.nightly),
        (orbiting_mass(varying=False), 0.9, 31, 5e-5),
        pytest.param(orbiting_mass(varying=True), 0.9, 31, 5e-5, marks=pytest.mark.nightly),
        (stop(), 0.8, 61, 1e-3),
    ],
    ids=["Jenkins", "lift-off", "microslip array", "disc", "disc of varying load", "gap and massless slider"],
)
def test_small_structures(problem, omega, harmonics, tolerance):
    """A massless slider moves by jumps of its velocity: its harmonics fall slowly, 5e-4 of the period is left at 61."""
    found = checked(problem, radians(0.3 * omega, omega), harmonics)
    assert found.agrees(tolerance), found.sentence
    assert float(found.time.dataset.energy_residual) < 5e-5


@pytest.mark.nightly
def test_the_difference_to_few_harmonics_is_that_of_the_harmonics_left_out():
    coarse, fine = (checked(single_mass(), radians(0.3, 1.1), harmonics) for harmonics in (1, 21))
    response = [forced_response(single_mass(), radians(0.3, 1.1), harmonics=h, samples=2048) for h in (1, 21)]
    truncation_error = float(response[0].dataset.amplitude[0, 1, 0] / response[1].dataset.amplitude[0, 1, 0]) - 1.0
    assert abs(truncation_error) > 5e-3
    assert coarse.amplitude_difference[0] == pytest.approx(truncation_error, rel=1e-2)
    assert abs(fine.amplitude_difference[0]) < 1e-2 * abs(truncation_error)


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


@pytest.mark.nightly
def test_the_start_state_decides_which_response_of_the_wedge_it_is():
    """At 222 Hz the three ratios give three responses; each stays what it is when integrated from its own sliders."""
    found = [checked(damped_wedge(ratio), [145.0, 222.0], 21, 1024, tolerance=1e-5) for ratio in (-1.0, 0.0, 1.0)]
    for one in found:
        assert one.agrees(1e-4), one.sentence
    amplitudes = [one.time_amplitude[0] for one in found]
    assert amplitudes[1] / amplitudes[0] > 1.3
    assert amplitudes[2] / amplitudes[1] > 1.2


@pytest.mark.slow
def test_an_unstable_solution_of_the_harmonic_balance_is_found_out():
    """The line contact at 0.9 rad/s: a solution to rounding in frequency, from which every time integration departs."""
    response = forced_response(line_contact(), radians(0.27, 0.9), harmonics=31, samples=2048)
    assert float(response.dataset.residual[0, 1]) < 1e-10
    found = response.verify_in_time(0, 1, periods=60)
    assert not found.periodic
    assert found.unstable
    assert not found.agrees(1.0)
    assert np.max(found.first_period_difference) < 2e-4
    assert "gives a periodic motion, which the first period in time repeats within" in found.sentence
    assert "the difference has grown: a periodic motion is unstable here" in found.sentence


def state_after(settings, omega, state):
    """x, ẋ of ẍ + c ẋ + x + x³ = F cos(ω t) after one period."""
    damping, force = settings

    def rates(t, y):
        return y[1], force * np.cos(omega * t) - damping * y[1] - y[0] - y[0] ** 3

    return solve_ivp(rates, (0.0, 2.0 * np.pi / omega), state, rtol=1e-11, atol=1e-12).y[:, -1]


def largest_multiplier(settings, omega, state):
    """|μ| of the map over a period, its derivative by central differences."""
    step = 1e-5
    columns = [state_after(settings, omega, state + step * e) - state_after(settings, omega, state - step * e) for e in np.eye(2)]
    return float(np.max(np.abs(np.linalg.eigvals(np.column_stack(columns) / (2.0 * step)))))


@pytest.mark.nightly
def test_the_middle_branch_of_duffing_is_right_and_unstable():
    """SciPy's integration of the same state returns to it within a period, with a multiplier that the march measures, too."""
    settings = damping, force = 0.05, 0.2
    structure = Structure(np.eye(1), np.eye(1), ("1.x",), C=damping * np.eye(1))
    spring = Contact("spring", CubicSpring(1.0), (between("1.x", "ground"),))
    problem = Problem(structure, (spring,), (Force("1.x", force),), ("1.x",))
    response = forced_response(problem, radians_per_second(0.6, 3.0), harmonics=9)
    omega = 2.0 * np.pi * response.dataset.frequency[0].to_numpy()
    folds = np.flatnonzero(np.diff(np.sign(np.diff(omega))))
    for point, stable in ((int(folds.mean()), False), (folds[0] - 4, True), (folds[1] + 4, True)):
        X = response.dataset.response[0, point, 0].to_numpy() @ [1.0, 1.0j]
        start = np.array([X.sum().real, (1j * omega[point] * np.arange(10) * X).sum().real])
        np.testing.assert_allclose(state_after(settings, omega[point], start), start, atol=1e-5)
        check, multiplier = response.verify_in_time(0, int(point)), largest_multiplier(settings, omega[point], start)
        assert check.unstable == (not stable) == (multiplier > 1.0)
        assert check.agrees(1e-4) == stable
        assert np.max(check.first_period_difference) < 2e-5
        if not stable:
            assert check.periodic
            assert np.max(check.period_difference) > 1.0
            assert check.time.cycle.growth == pytest.approx(multiplier, rel=0.1)
            assert "but not a stable one: departures grow by a factor of" in check.sentence
