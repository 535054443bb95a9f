"""The exact march of sliders and springs, its derivative, and the orbit beside a solution of the balance."""

import numpy as np
import pytest
from stability.hybrid import of_problem
from stability.test_multipliers import SLIDERS, assert_same, solved, start

import stickslip as ss
from stickslip.analyses.solved_points import SolvedPoints
from stickslip.solve.stability.event_march import EventMarch, LostMotionError, State, coordinates
from stickslip.solve.stability.orbit import OrbitSearch


def sliding_mass(kt, limit=0.5, damping=0.1):
    """m = k = 1 on a slider."""
    structure = ss.Structure(np.eye(1), np.eye(1), ("1.x",), C=damping * np.eye(1))
    contact = ss.Contact("rub", ss.Macroslip(kt=kt, mu=1.0, normal_load=limit), ({"1.x": 1.0},))
    return ss.Problem(structure, (contact,), (ss.Force("1.x", 1.0),), ("1.x",))


def searched(problem, frequency, level=1.0, harmonics=15, samples=512, highest=np.inf):
    """The orbit beside the solution at a frequency [Hz], the search and the solution."""
    response = ss.forced_response(problem, [frequency], force=level, harmonics=harmonics, samples=samples)
    points = SolvedPoints(response.dataset, problem)
    evaluation = points.evaluation(0, 0)
    search = OrbitSearch(EventMarch(problem, highest, 40, evaluation.point.omega), points.balance)
    return search.beside(evaluation), search, evaluation


@pytest.mark.parametrize("name", [name if "one mass" in name else pytest.param(name, marks=pytest.mark.slow) for name in SLIDERS])
def test_multipliers_are_those_of_integration_from_event_to_event(name):
    problem, frequency, level, count, stuck = SLIDERS[name]
    orbit, _, evaluation = searched(problem, frequency, level)
    state, modes = start(*reversed(solved_one(problem, frequency, level)))
    exact = np.linalg.eigvals(of_problem(problem, level).periodic(state, modes, evaluation.point.omega))
    assert orbit.closed
    assert orbit.exact_ones == stuck
    assert_same(np.append(orbit.multipliers, np.ones(stuck)), exact, count + stuck, tolerance=3e-5)


def solved_one(problem, frequency, level):
    map_, (evaluation,) = solved(problem, [frequency], level)
    return evaluation, map_


@pytest.mark.parametrize("kt", [30.0, 300.0, 1e3, 1e4, 1e5])
@pytest.mark.parametrize("harmonics", [3, 21])
def test_the_multiplier_does_not_depend_on_how_stiff_the_slider_is(kt, harmonics):
    """exp(−c T/2) = 0.7304 of a mass that slips all the time; at its two turning points the slider sticks for an instant."""
    orbit, _, _ = searched(sliding_mass(kt), 0.5 / np.pi, harmonics=harmonics, samples=1024)
    assert abs(orbit.leading) == pytest.approx(0.7301, abs=1e-4)


def test_a_linear_mass_has_its_own_decay_and_amplitude():
    """A slider that never slips is a spring: |μ| = exp(−c T/2m), and the orbit is the linear response."""
    orbit, search, evaluation = searched(sliding_mass(2.0, limit=1e3), 0.3, harmonics=1)
    omega = evaluation.point.omega
    assert np.abs(orbit.multipliers) == pytest.approx(np.exp(-0.05 * search.march.period) * np.ones(2), rel=1e-10)
    assert orbit.exact_ones == 1
    amplitude = 1.0 / (3.0 - omega**2 + 0.1j * omega)
    assert orbit.begin.motion == pytest.approx([amplitude.real, -omega * amplitude.imag], rel=1e-8)


@pytest.mark.parametrize("name", ["one mass, long slip", "lands and slips", "lands and sticks", "friction falls with the load"])
def test_the_derivative_is_that_of_differences(name):
    problem, frequency, level, *_ = SLIDERS[name]
    orbit, search, _ = searched(problem, frequency, level, harmonics=7)
    march = search.march
    passage, size = march.travel(orbit.begin, derivative=True), 1e-6
    x = np.concatenate(orbit.begin)
    moved = 2 * march.coordinates.size
    for k in range(moved):
        ends = []
        for sign in (1.0, -1.0):
            pushed = x.copy()
            pushed[k] += sign * size
            ends.append(np.concatenate(march.travel(State(pushed[:moved], pushed[moved:])).end))
        difference = (ends[0] - ends[1]) / (2.0 * size)
        assert passage.derivative[:, k] == pytest.approx(difference, abs=2e-4 * (1.0 + np.abs(difference).max()))


def test_modes_that_are_left_out_leave_the_motion_in_slip():
    """With no mode of the stuck structure below the cut, the static shape of the contact carries the mass that slips."""
    found = coordinates(sliding_mass(1e6), 10.0, 40)
    assert found.size == 1
    assert found.rows[0, 0] ** 2 == pytest.approx(1.0)
    assert found.stiffness[0, 0] == pytest.approx(1.0)


def test_more_coordinates_than_allowed_are_refused():
    with pytest.raises(ss.InputError, match="at most 1 coordinates"):
        EventMarch(ss.rigs.chain(), np.inf, 1, 1.0)


def test_a_slider_too_stiff_for_its_steps_is_given_up():
    march = EventMarch(sliding_mass(1e14), np.inf, 40, 1.0)
    march.at(1.0, 1.0, np.ones(1))
    with pytest.raises(LostMotionError):
        march.travel(State(np.array([1.0, 0.0]), np.array([-1e14])))
