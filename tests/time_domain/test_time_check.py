"""What a user meets: `verify_in_time`, its sentences and refusals, and motions that are not periodic."""

import numpy as np
import pytest
from time_domain.systems import landing_foot

from stickslip.analyses.forced_response import forced_response
from stickslip.analyses.time_response import time_response
from stickslip.model.contact.cubic import CubicSpring
from stickslip.model.contact.point import Contact, between
from stickslip.model.loads import Force
from stickslip.model.problem import Problem
from stickslip.model.rigs import single_mass, three_mass_wedge
from stickslip.model.structure.matrices import Structure
from stickslip.solve.time.march import distance, growth
from stickslip.solve.time.period import Newmark
from stickslip.support.checks import InputError
from stickslip.support.units import hertz, radians_per_second

FREQUENCY = 1.1 / (2.0 * np.pi)


@pytest.fixture(scope="module")
def response():
    return forced_response(single_mass(), [0.05, FREQUENCY], [0.5, 1.0], harmonics=7)


def test_a_check_says_what_it_compared(response):
    check = response.verify_in_time(1, 1, steps_per_period=1000)
    assert check.agrees(1e-3)
    assert not check.agrees(1e-6)
    assert "harmonic balance with 7 harmonics and time integration with 1000 steps a period differ by" in str(check)
    assert f"Periodic after {check.periods} periods" in str(check)
    np.testing.assert_allclose(check.harmonic_amplitude, response.dataset.amplitude[1, 1], rtol=1e-14)
    assert check.time.dataset.attrs["force_level"] == 1.0


@pytest.fixture(scope="module")
def swept():
    """A curve with three peaks, on two outputs."""
    return forced_response(three_mass_wedge(), hertz(145.0, 235.0), [0.5, 1.0], harmonics=5)


def test_every_peak_is_a_point_of_its_curve(swept):
    """Whatever is asked of a point can be asked of a peak: the table's numbers are the point's to the last digit."""
    dataset, peaks = swept.dataset, swept.peaks()
    outputs = list(dataset.output.to_numpy())
    for row in peaks.itertuples():
        case, output = int(np.argmax(dataset.force_level.to_numpy() == row.force_level)), outputs.index(row.output)
        place = dataset.isel(case=case, output=output, point=swept.peak_point(case, output, row.peak))
        assert [float(place[name]) for name in ("frequency", "amplitude", "max_abs", "loss_factor")] == [
            row.frequency,
            row.amplitude,
            row.max_abs,
            row.loss_factor,
        ]
    assert len(peaks) >= 12


def test_points_stay_in_the_order_of_travel(swept):
    """Peaks, and points between those of the continuation, stand where the curve passes them: this one does not turn back."""
    for frequencies in swept.dataset.frequency.to_numpy():
        assert np.all(np.diff(frequencies[np.isfinite(frequencies)]) > 0.0)


@pytest.mark.slow
def test_a_peak_in_time(swept):
    """Five harmonics and time integration at the highest peak of the second mass."""
    assert swept.verify_in_time(1, swept.peak_point(1, output=2)).agrees(5e-3)


@pytest.mark.parametrize("options", [{"case": 2}, {"case": -1}, {"output": 9}, {"output": "1.x"}, {"peak": 5}, {"peak": 0.5}])
def test_a_peak_that_is_not_there(swept, options):
    with pytest.raises(InputError, match=f"{next(iter(options))} must be"):
        swept.peak_point(**options)


def test_a_curve_without_peak_has_no_point_of_it(response):
    with pytest.raises(
        InputError, match="The curve of case 1 and output 0 must have a peak inside the band, but is 'one without'"
    ):
        response.peak_point(1)


@pytest.mark.nightly
def test_the_trapezoidal_rule_agrees_where_nothing_lands(response):
    one, other = (response.verify_in_time(0, 1, **method) for method in ({}, {"method": Newmark()}))
    np.testing.assert_allclose(one.time_amplitude, other.time_amplitude, rtol=1e-5)


def test_histories_harmonics_and_energies_belong_together(response):
    dataset = response.verify_in_time(1, 1).time.dataset
    turns = np.outer(np.arange(22), np.arange(2000)) / 2000
    for name, history in (("response", dataset.displacement[0]), ("contact_force", dataset.force_history[0, 0])):
        parts = dataset[name].to_numpy().reshape(-1, 22, 2)[0]
        rebuilt = np.real((parts[:, 0] + 1j * parts[:, 1]) @ np.exp(2j * np.pi * turns))
        truncation_error = float(np.sqrt(np.mean((rebuilt - history.to_numpy()) ** 2)))
        assert truncation_error < {"response": 1e-4, "contact_force": 1e-2}[name] * float(np.abs(history).max())
    force, motion = dataset.force_history[0, 0].to_numpy(), dataset.motion_history[0, 0].to_numpy()
    loop = float(np.sum(0.5 * (force + np.roll(force, -1)) * (np.roll(motion, -1) - motion)))
    assert loop == pytest.approx(float(dataset.dissipated[0]), rel=1e-4)
    assert float(dataset.input_work) == pytest.approx(float(dataset.dissipated[0] + dataset.viscous_work), rel=1e-5)
    assert all({"units", "long_name"} <= set(dataset[name].attrs) for name in dataset.data_vars)


def test_a_motion_that_is_not_yet_periodic_is_named_and_verifies_nothing():
    response = forced_response(single_mass(damping=1e-4), [0.05, FREQUENCY], 0.1, harmonics=3)
    check = response.verify_in_time(0, 1, periods=3, tolerance=1e-12)
    assert not check.periodic
    assert not check.agrees(1.0)
    assert "Not periodic within 3 periods" in check.sentence


@pytest.mark.slow
def test_what_is_hardly_damped_agrees_as_far_as_it_has_settled():
    """The undamped wedge rings on its stuck contacts: 1000 periods leave 3e-6, above the default tolerance and far below 1e-3."""
    response = forced_response(three_mass_wedge(0.0), [145.0, 175.48], harmonics=15)
    check = response.verify_in_time(0, 1, periods=60, steps_per_period=1000)
    assert not check.periodic
    assert 1e-6 < check.distance < 1e-4
    assert check.agrees(1e-3)
    assert not check.agrees(float(np.max(check.period_difference)) + 0.5 * check.distance)
    assert f"at most about {check.distance:.1e} from a periodic motion, more than `tolerance`" in check.sentence
    suggested = float(check.sentence.split("tolerance=")[1].split(". ")[0])
    assert response.verify_in_time(0, 1, periods=60, steps_per_period=1000, tolerance=suggested).periodic


@pytest.mark.nightly
def test_the_error_of_the_steps_is_reported(response):
    """Second order: what N steps leave is a third of what half of them change; 16 N are taken for exact."""
    check = response.verify_in_time(1, 1, steps_per_period=500)
    exact = response.verify_in_time(1, 1, steps_per_period=8000).time.dataset.response
    error = np.hypot(*(check.time.dataset.response - exact)[0, 1].to_numpy()) / check.time_amplitude[0]
    assert check.step_error[0] / 3.0 == pytest.approx(error, rel=0.3)
    assert f"Half the steps change the first harmonic by {check.step_error[0]:.1e}." in check.sentence


def test_steps_too_few_to_be_halved_tell_no_error():
    """44 steps resolve a load of harmonic 8, 22 do not."""
    problem = single_mass().with_forces((Force("1.x", {1: 1.0, 8: 0.1}),))
    response = forced_response(problem, [0.05, FREQUENCY], harmonics=9)
    check = response.verify_in_time(0, 1, steps_per_period=44)
    assert check.periodic
    assert np.isnan(check.step_error[0])
    assert "Half the steps" not in check.sentence


def test_a_point_that_did_not_converge_cannot_be_verified(response):
    dataset = response.dataset.copy(deep=True)
    dataset.outcome[0, 1] = 2
    with pytest.raises(InputError, match="Point 1 of case 0 must have converged"):
        type(response)(dataset, response.problem).verify_in_time(0, 1)


@pytest.mark.parametrize(
    ("case", "point", "said"),
    [(9, 0, "case must be a whole number from 0 to"), (0, -1, "point must be .* from 0 to"), ("a", 0, "case"), (0, 1.5, "point")],
)
def test_a_point_that_is_not_there_cannot_be_verified(response, case, point, said):
    for asked in (response.verify_in_time, response.cycle):
        with pytest.raises(InputError, match=said):
            asked(case, point)


@pytest.mark.parametrize("options", [{"steps_per_period": 2}, {"periods": 1}, {"tolerance": 0.0}, {"harmonics": 500}])
def test_bad_settings_are_refused(options):
    with pytest.raises(InputError, match="must be"):
        time_response(single_mass(), 0.1, **({"steps_per_period": 400} | options))


def test_the_distance_from_the_limit_follows_from_the_rate_of_decay():
    changes = [0.9**k for k in range(20)]
    assert distance(changes) == pytest.approx(0.9**20 / 0.1)
    assert distance([1.0, 1.0, 1.0]) == np.inf
    assert distance([]) == np.inf


def test_growth_is_the_factor_per_period_after_the_least_change():
    assert growth([0.3**k for k in range(4)] + [0.3**3 * 2.0**k for k in range(1, 9)]) == pytest.approx(2.0)
    assert growth([1.0, 0.01, 0.99]) == 1.0
    assert growth([1e-5] * 200) == 1.0
    assert growth([]) == 1.0


def test_numerical_damping_quiets_a_landing():
    """A light foot on a stiff stop: without numerical damping what the steps cannot resolve makes up forces."""

    def largest_force(mass, **method):
        found = time_response(landing_foot(mass), 0.8 / (2.0 * np.pi), steps_per_period=400, tolerance=1e-4, periods=60, **method)
        return float(found.dataset.force_history.sel(direction="n").max())

    massless = largest_force(0.0)
    assert largest_force(0.0, method=Newmark()) == pytest.approx(massless, rel=1e-3)
    assert largest_force(1e-5) == pytest.approx(massless, rel=1e-3)
    assert largest_force(1e-5, method=Newmark()) > 1.3 * massless


def test_steps_that_gain_energy_are_given_up():
    found = time_response(landing_foot(1e-3), 0.8 / (2.0 * np.pi), steps_per_period=400, method=Newmark())
    assert "grew without bound" in found.sentence
    assert not found.periodic


def with_a_resting_output(damping, force):
    """A Duffing mass, and one apart from it that a static force pushes aside: at rest."""
    structure = Structure(np.eye(2), np.diag([1.0, 2.0]), ("1.x", "2.x"), C=np.diag([damping, 0.3]))
    spring = Contact("spring", CubicSpring(k3=1.0), tangential=(between("1.x", "ground"),))
    forces = (Force("1.x", force), Force("2.x", static=1.0))
    return Problem(structure, (spring,), forces, ("1.x", "2.x"))


@pytest.mark.nightly
def test_an_output_at_rest_is_no_difference_and_hides_no_instability():
    """Rounding over rounding was a difference of 0.5, and made the motion that leaves the middle branch look like an error."""
    response = forced_response(with_a_resting_output(0.05, 0.2), radians_per_second(0.8, 3.5), harmonics=9)
    frequencies = 2.0 * np.pi * response.dataset.frequency.to_numpy()[0]
    turns = np.flatnonzero(np.diff(frequencies) < 0.0)
    right = response.verify_in_time(0, 2, steps_per_period=1000)
    assert right.agrees(1e-3)
    assert np.max(right.period_difference) < 1e-4
    middle = response.verify_in_time(0, int(turns[turns.size // 2]), steps_per_period=1000)
    assert middle.unstable
    assert not middle.agrees(1e-3)
