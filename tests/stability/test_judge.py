"""The judge of stability: stiff sliders, few harmonics, lift-off, and what keeps a point undecided.

The three cases of the first tests were called unstable before. That they are stable: the energy of the difference of two motions
falls (one and two masses under constant loads); 400 periods of an explicit integration with 1600 steps each, from two starts, end
in one motion (two masses); event-exact integration has a largest multiplier of 0.986 at the peak of the third.
"""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
from stability.test_event_march import sliding_mass
from stability.test_multipliers import lifting

import stickslip as ss
from stickslip.analyses.solved_points import SolvedPoints
from stickslip.solve.stability.judge import Judge, Orbit, _of_orbit
from stickslip.solve.stability.multipliers import TIMES_ERROR, PeriodMap, Stability


def two_stiff_masses():
    """Two masses on sliders 1e4 times as stiff as the springs, damping about 1 %."""
    M = np.diag([1.21397563, 1.10305491])
    K = np.array([[2.407803716408797, -1.8252677904033323], [-1.8252677904033323, 2.525483573184192]])
    structure = ss.Structure(M, K, ("0.x", "1.x"), damping=ss.ModalDamping(0.009785293944826521, on="free"))
    contacts = tuple(
        ss.Contact(f"c{i}", ss.Macroslip(kt=kt, mu=0.5, normal_load=1.0), ({f"{i}.x": 1.0},))
        for i, kt in enumerate((20993.739273871448, 7715.14562597159))
    )
    return ss.Problem(structure, contacts, (ss.Force("0.x", 1.0),), ("0.x", "1.x"))


def two_masses_that_lift_off():
    """Two masses on one contact of a load that varies, drawn with seed 126."""
    r = np.random.default_rng(126)
    M = np.diag(r.uniform(0.5, 1.5, 2))
    K = np.array([[2.0, -1.0], [-1.0, 3.0]]) * r.uniform(0.7, 1.4)
    bt = np.array([1.0, 0.0]) if r.random() < 0.5 else np.array([0.3, 1.0])
    bn = np.array([r.uniform(-1, 1), r.uniform(0.4, 1)])
    mu, N0, kt, kn = r.uniform(0.02, 0.3), r.uniform(0.05, 0.6), r.uniform(1, 4), r.uniform(2, 12)
    along, normal = ({dof: float(c) for dof, c in zip(("a.x", "b.x"), b, strict=True) if c} for b in (bt, bn))
    contact = ss.Contact("c", ss.Macroslip(kt=kt, mu=mu, kn=kn, preload=N0), (along,), normal)
    forces = tuple(ss.Force(dof, float(f)) for dof, f in zip(("a.x", "b.x"), 0.4 * r.standard_normal(2), strict=True))
    return ss.Problem(ss.Structure(M, K, ("a.x", "b.x"), C=0.004 * K), (contact,), forces, ("a.x", "b.x"))


@pytest.mark.parametrize(
    ("kt", "where"),
    [
        (300.0, [1.0 / (2.0 * np.pi)]),
        (300.0, ss.Band(0.13, 0.18)),
        (1e5, [1.0 / (2.0 * np.pi)]),
        pytest.param(1e5, ss.Band(0.08, 0.25), marks=pytest.mark.slow),
    ],
)
def test_a_mass_on_a_stiff_slider_is_stable_on_the_first_screen_and_at_all_points(kt, where):
    found = ss.forced_response(sliding_mass(kt), where, harmonics=5, samples=1024)
    assert found.dataset["highest_stability"].values.tolist() == [[1]]
    assert int(found.dataset["end_stability"].values[0]) == 1
    assert "stable motion" not in str(found)
    stability = found.with_stability().dataset["stability"].values
    assert set(np.unique(stability)) <= {0, 1}


def test_two_masses_on_stiff_sliders_are_stable():
    found = ss.forced_response(two_stiff_masses(), [0.742082 / (2.0 * np.pi)], force=1.6250194377178715)
    assert found.dataset["highest_stability"].values.tolist() == [[1, 1]]
    multiplier = found.with_stability().dataset["multiplier"].values[0, 0]
    assert np.hypot(*multiplier) == pytest.approx(0.9402, abs=1e-4)


@pytest.mark.parametrize("harmonics", [3, 7])
def test_the_multiplier_is_that_of_the_motion_whatever_the_number_of_harmonics(harmonics):
    """Multiplier 0.986 at the peak of b.x near 0.2556 Hz."""
    found = ss.forced_response(two_masses_that_lift_off(), ss.Band(0.25, 0.27), harmonics=harmonics, samples=256)
    assert found.dataset["highest_stability"].values[0, 1] == Stability.STABLE
    assert "Unstable" not in str(found.dataset["case_message"].values[0])


class Search:
    """A search whose disturbances behave as told."""

    def __init__(self, sides, leaves):
        self.sides = lambda orbit: sides
        self.periods_to_leave = lambda orbit, grown: leaves


@pytest.mark.parametrize(
    ("multiplier", "defect", "distance", "sides", "leaves", "expected", "reason"),
    [
        (0.9, 1e-9, 0.02, (0.9, 0.9), None, "STABLE", ""),
        (1.2, 1e-9, 0.02, (1.2, 1.2), 7, "UNSTABLE", ""),
        (0.9, 1e-9, 0.23, (0.9, 0.9), None, "UNDECIDED", "the nearest true motion differs by 23 %"),
        (0.9, 1e-5, 0.02, (0.9, 0.9), None, "UNDECIDED", "no periodic motion"),
        (1.00005, 1e-9, 0.02, (1.2, 1.2), 7, "UNDECIDED", "size of 1.00005"),
        (0.9999, 9e-7, 0.02, (0.9, 0.9), None, "UNDECIDED", "size of 0.9999"),
        (0.9, 1e-9, 0.02, (0.9, 1.3), None, "UNDECIDED", "0.9 to one side and by 1.3"),
        (1.2, 1e-9, 0.02, (1.2, 1.2), None, "UNDECIDED", "stays beside it for 30 periods"),
    ],
)
def test_what_keeps_a_point_undecided_is_said_with_its_number(multiplier, defect, distance, sides, leaves, expected, reason):
    values = np.array([multiplier + 0j])
    orbit = Orbit(SimpleNamespace(), defect, distance, values, 0, np.ones(1), np.ones(1), np.ones(1))
    found = _of_orbit(Search(sides, leaves), orbit)
    assert found.stability == Stability[expected]
    assert reason in found.reason
    assert bool(found.reason) == (expected == "UNDECIDED")


def test_few_harmonics_of_a_mass_that_lands_are_undecided_and_say_how_far_the_motion_is():
    """One harmonic of a mass on a stiff contact that opens for half of the period."""
    contact = replace(lifting().contacts[0], law=ss.Macroslip(5.0, 0.5, 10.0, 0.5))
    problem = replace(lifting(), contacts=(contact,))
    found = ss.forced_response(problem, [0.24], harmonics=1, samples=256)
    points = SolvedPoints(found.dataset, problem)
    evaluation = points.evaluation(0, 0)
    verdict = Judge(points.balance, evaluation.point.omega).verdict(evaluation)
    assert verdict.stability == Stability.UNDECIDED
    assert verdict.distance > 0.1
    assert f"differs by {100.0 * verdict.distance:.2g} %" in str(found.dataset["case_message"].values[0])
    assert "differs by" in str(found.with_stability().dataset["stability_reason"].values[0, 0])


@pytest.mark.parametrize(("highest", "most", "follows"), [(np.inf, 2048, True), (np.inf, 64, False), (24.0, 2048, False)])
def test_the_map_of_a_disturbance_says_whether_it_follows_a_stiff_slider(highest, most, follows):
    """kt/k = 1000: 64 steps are 3.1 radians of the stuck mode; without it, at 24 rad/s, nothing is left that slips."""
    problem = sliding_mass(1e3)
    points = SolvedPoints(ss.forced_response(problem, [0.5 / np.pi], harmonics=3, samples=512).dataset, problem)
    found = PeriodMap(points.balance, highest).multipliers(points.evaluation(0, 0), 16, most)
    assert found.follows_contacts == follows
    assert not follows or abs(abs(found.leading) - 0.73007) <= TIMES_ERROR * found.error


@pytest.mark.parametrize(
    ("kt", "preload", "verdict", "reason"),
    [
        (1.0, 5.0, "STABLE", ""),
        (1.0, 0.5, "UNKNOWN", "contacts lift off"),
        (1e6, 5.0, "UNDECIDED", "contacts as stiff as these"),
    ],
)
def test_a_disc_is_judged_by_the_map_of_a_disturbance_where_that_can_follow_it(kt, preload, verdict, reason):
    structure = ss.Structure(np.eye(3), np.diag([1.0, 1.4, 2.0]), ("1.x", "1.y", "1.z"), C=0.04 * np.eye(3))
    sides = (ss.between("1.x", "ground"), ss.between("1.y", "ground"))
    contact = ss.Contact("c", ss.FrictionDisc(kt, 0.5, kn=1.0, preload=preload), sides, ss.between("1.z", "ground"))
    forces = (ss.Force("1.x", 1.0), ss.Force("1.z", 2.0))
    problem = ss.Problem(structure, (contact,), forces, ("1.x",))
    points = SolvedPoints(ss.forced_response(problem, [0.2], harmonics=5, samples=256).dataset, problem)
    evaluation = points.evaluation(0, 0)
    found = Judge(points.balance, evaluation.point.omega).verdict(evaluation)
    assert found.stability == Stability[verdict]
    assert reason in found.reason
    assert bool(found.reason) == bool(reason)


def test_an_unstable_motion_is_left_within_the_periods_that_are_said():
    """Negative damping while the slider sticks."""
    structure = ss.Structure(np.eye(1), np.eye(1), ("q.x",), damping=ss.ModalDamping(0.002))
    contact = ss.Contact("slider", ss.Macroslip(kt=0.5, mu=0.5, normal_load=0.3), ({"q.x": 1.0},))
    dashpots = (ss.AerodynamicDamping({"q.x": 1.0}, -0.03),)
    problem = ss.Problem(structure, (contact,), (ss.Force("q.x", 0.005),), ("q.x",), dashpots=dashpots)
    found = ss.forced_response(problem, [1.2246 / (2.0 * np.pi)], harmonics=5)
    message = str(found.dataset["case_message"].values[0])
    grows = np.hypot(*found.with_stability().dataset["multiplier"].values[0, 0])
    assert f"grows by a factor of {grows:.4g} per period and leaves it within" in message
