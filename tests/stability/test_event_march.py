"""The exact march of sliders and springs, its derivative, and the orbit beside a solution of the balance."""

import numpy as np
import pytest
from stability.hybrid import of_problem
from stability.test_multipliers import SLIDERS, assert_same, solved, start

import stickslip as ss
from stickslip.analyses.solved_points import SolvedPoints
from stickslip.solve.stability.event_march import EventMarch, LostMotionError, State, coordinates
from stickslip.solve.stability.judge import OrbitSearch


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


def test_a_slider_that_lands_sticks_and_yields_within_a_step():
    """Behind the landing its guard begins at zero and rises before it falls. With light masses and Coriolis forces; a Runge-Kutta
    method with bisected events has a multiplier of −1.230336, from differences of 1e-4 to 1e-8."""
    C = (0.01 * np.eye(2) + 0.5 * np.array([[0.0, 1.0], [-1.0, 0.0]])) * 1e-3
    structure = ss.Structure(1e-6 * np.eye(2), np.diag([1.0, 1.4]), ("1.x", "2.x"), C=C)
    law = ss.Macroslip(kt=3.0, mu=0.6, kn=2.0, preload=1e-4)
    contact = ss.Contact("c", law, ({"1.x": 1.0},), {"1.x": 0.3, "2.x": 1.0})
    forces = (ss.Force("1.x", 1e-4), ss.Force("2.x", 0.5e-4j))
    problem = ss.Problem(structure, (contact,), forces, ("1.x", "2.x"))
    orbit, search, _ = searched(problem, 700.0 / (2.0 * np.pi), harmonics=21, samples=1024)
    assert orbit.leading.real == pytest.approx(-1.230336, abs=1e-5)
    assert search.sides(orbit) == pytest.approx((1.230336, 1.230336), rel=1e-4)


def test_the_distance_from_a_motion_that_bounces_is_that_of_displacements():
    """A mass at a stop a thousand times as stiff: 3.2 % with 21 harmonics and 0.43 % with 41 by a Runge-Kutta method, and
    multipliers of 0.94706 and, at the other frequency, 0.74639."""
    structure = ss.Structure([[1.03663333]], [[0.98834135]], ("1.x",), C=[[0.02024975]])
    stop = ss.Contact("g", ss.Gap(1e3, gap=5.4725874e-4), normal={"1.x": 1.0})
    slider = ss.Contact("s", ss.Macroslip(kt=3.0, mu=0.5, normal_load=0.2), ({"1.x": 1.0},))
    problem = ss.Problem(structure, (stop, slider), (ss.Force("1.x", 0.4),), ("1.x",))
    for omega, harmonics, distance, multiplier in (
        (1.0740724672440476, 21, 0.032, 0.94706),
        (1.2205368945955086, 41, 0.0035, 0.74639),
    ):
        orbit, _, _ = searched(problem, omega / (2.0 * np.pi), harmonics=harmonics, samples=1024)
        assert orbit.closed
        assert orbit.distance == pytest.approx(distance, rel=0.1)
        assert abs(orbit.leading) == pytest.approx(multiplier, abs=1e-4)


def test_a_massless_row_is_not_marched():
    """Its motion is infinitely fast; one of 1e-4 of the other mass is."""

    def held(mass):
        structure = ss.Structure(np.diag([1.0, mass]), [[2.0, -1.0], [-1.0, 1.0]], ("1.x", "2.x"), C=np.diag([0.04, 0.04]))
        contact = ss.Contact("c", ss.Macroslip(kt=2.0, mu=0.5, normal_load=60.0), ({"2.x": 1.0},))
        return ss.Problem(structure, (contact,), (ss.Force("1.x", 0.5),), ("1.x",))

    orbit, _, _ = searched(held(1e-4), 0.7 / (2.0 * np.pi), harmonics=3, highest=16.8)
    assert abs(orbit.leading) == pytest.approx(0.819163, abs=1e-6)
    assert orbit.distance < 1e-9
    with pytest.raises(ss.InputError, match="with mass"):
        EventMarch(held(1e-12), 16.8, 40, 0.7)


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
    with pytest.raises(ss.InputError, match="with mass"):
        EventMarch(sliding_mass(1e14), np.inf, 40, 1.0)
    march = EventMarch(sliding_mass(1e6), np.inf, 40, 1.0)
    march.at(0.01, 1.0, np.ones(1))
    with pytest.raises(LostMotionError):
        march.travel(State(np.array([1.0, 0.0]), np.array([-1e6])))
