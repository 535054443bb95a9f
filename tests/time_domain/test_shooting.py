"""The periodic motion of the time steps by shooting and its multipliers, against SciPy's integration from event to event."""

import numpy as np
import pytest
from stability.hybrid import of_problem
from stability.test_multipliers import SLIDERS, lifting, start
from stability.test_multipliers import duffing as duffing_of

import stickslip as ss
from stickslip.analyses.solved_points import SolvedPoints
from stickslip.solve.stability.multipliers import PeriodMap
from stickslip.solve.time.march import March, PeriodMarch, from_harmonics, shoot


def shot(problem, frequency, level, steps=2000, harmonics=15):
    """Shooting from the solved point, the point, and the exact multipliers of the masses and sliders."""
    response = ss.forced_response(problem, [frequency], force=level, harmonics=harmonics, samples=512)
    points = SolvedPoints(response.dataset, problem)
    evaluation = points.evaluation(0, 0)
    point = evaluation.point
    begin = from_harmonics(points.balance, point.forces, point.omega, point.level)
    found = shoot(problem, point.omega, level, begin, points.whole_motion(0, 0), March(steps))
    return found, evaluation, PeriodMap(points.balance)


@pytest.mark.parametrize(
    "name",
    [
        "one mass, long slip",
        pytest.param("wedge", marks=pytest.mark.nightly),
        pytest.param("lands and slips", marks=pytest.mark.nightly),
        "lands and sticks",
    ],
)
def test_shooting_finds_the_largest_multiplier_of_integration_from_event_to_event(name):
    """A slider that lands and sticks knows when it landed, to a part of a step: else its multiplier errs by more than 0.01."""
    problem, frequency, level, _, stuck = SLIDERS[name]
    steps = 8000 if name == "one mass, long slip" else 2000  # the instants of slip are those of steps
    found, evaluation, map_ = shot(problem, frequency, level, steps)
    state, modes = start(map_, evaluation)
    exact = np.abs(np.linalg.eigvals(of_problem(problem, level).periodic(state, modes, evaluation.point.omega)))
    assert found.closed
    assert abs(found.leading) == pytest.approx(np.sort(exact)[-1 - stuck], abs=1e-3)


def test_a_disturbance_of_an_unstable_motion_grows_by_its_multiplier():
    """Marched on from the middle branch of Duffing's oscillator, which shooting has found."""
    problem = duffing_of()
    response = ss.forced_response(problem, ss.Band(0.1, 0.5), harmonics=9)
    frequency = response.dataset.frequency.to_numpy()[0]
    high, low = np.flatnonzero(np.diff(np.sign(np.diff(frequency)))) + 1
    points, middle = SolvedPoints(response.dataset, problem), int((high + low) // 2)
    point, settings = points.point(0, middle), March(1000)
    begin = from_harmonics(points.balance, point.forces, point.omega, point.level)
    found = shoot(problem, point.omega, point.level, begin, points.whole_motion(0, middle), settings)
    assert found.defect < 1e-7
    assert abs(found.leading) > 1.5
    march = PeriodMarch(problem, point.omega, point.level, settings)
    closed = march.packed(found.start)
    x, distances = closed + 1e-5 * np.array([1.0, 0.3]), []
    for _ in range(4):
        x = march(x)
        distances.append(np.linalg.norm(x - closed))
    assert distances[3] / distances[2] == pytest.approx(abs(found.leading), rel=0.02)


def test_a_point_with_too_few_harmonics_differs_from_the_motion_in_time():
    """One harmonic of a mass that lifts off: the motion in time differs by what the harmonics left out."""
    differences = []
    for harmonics in (1, 21):
        response = ss.forced_response(lifting(), [0.24], harmonics=harmonics, samples=512)
        check = response.verify_in_time(0, 0, steps_per_period=1000, periods=2)
        assert np.isfinite(check.multiplier)
        differences.append(float(check.motion_difference.max()))
    assert differences[0] > 5.0 * differences[1]
    assert differences[1] < 5e-3
