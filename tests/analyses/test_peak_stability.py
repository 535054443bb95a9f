"""Every forced response says where a highest peak, or the end of its curve, is an unstable motion.

One mass with negative damping while it sticks: harmonic balance finds a peak of 0.163 at 1.2246 rad/s; in time the mass swings
with 0.32 (integrated by a Runge-Kutta method of its own, checked here by `time_response` too).
"""

import numpy as np
import pytest

import stickslip as ss
from robustness.problems import random_case
from robustness.run import HARMONICS, SAMPLES
from stickslip.show.report.answer import peaks_at_a_glance, warnings_of
from stickslip.solve.stability.multipliers import Stability


def mass(gas=-0.03):
    """m = k = 1, modal damping 0.002, gas forces c, slider kt 0.5 and μN 0.15, force 0.005."""
    structure = ss.Structure(np.eye(1), np.eye(1), ("q.x",), damping=ss.ModalDamping(0.002))
    contact = ss.Contact("slider", ss.Macroslip(kt=0.5, mu=0.5, normal_load=0.3), ({"q.x": 1.0},))
    dashpots = (ss.AerodynamicDamping({"q.x": 1.0}, gas),)
    return ss.Problem(structure, (contact,), (ss.Force("q.x", 0.005),), ("q.x",), dashpots=dashpots)


BAND = ss.Band(0.8 / (2 * np.pi), 1.6 / (2 * np.pi))


@pytest.fixture(scope="module")
def unstable():
    return ss.forced_response(mass(), BAND, harmonics=5)


def test_an_unstable_peak_is_said(unstable):
    dataset = unstable.dataset
    peak = unstable.peaks().iloc[0]
    assert 2 * np.pi * peak["frequency"] == pytest.approx(1.2246, rel=1e-3)
    assert peak["amplitude"] == pytest.approx(0.163, rel=5e-3)
    assert dataset["highest_stability"].values.tolist() == [[2]]
    assert dataset["end_stability"].values.tolist() == [2]
    assert "Unstable motion at the highest point of q.x (0.1949" in str(dataset["case_message"].values[0])
    assert "the end of the curve (0.254648 Hz)" in str(dataset["case_message"].values[0])


def test_the_first_screen_says_so(unstable):
    assert ", unstable" in str(unstable)
    assert "unstable; " in peaks_at_a_glance("a", unstable.dataset)
    (one,) = [sentence for sentence in warnings_of(unstable.dataset) if "nstable" in sentence]
    assert "the vibration grows into another one" in one


def test_a_stable_curve_says_nothing():
    found = ss.forced_response(mass(gas=0.01), BAND, harmonics=5)
    assert found.dataset["highest_stability"].values.tolist() == [[1]]
    assert found.dataset["end_stability"].values.tolist() == [1]
    assert "nstable" not in str(found) + str(found.dataset["case_message"].values[0])


def test_flags_are_those_of_all_points(unstable):
    """`with_stability` judges every point; the flags of peak and ends are the same."""
    whole = unstable.with_stability().dataset
    at_peak = whole["stability"].values[0, unstable.peak_point()]
    end = whole["stability"].values[0, np.flatnonzero(whole["outcome"].values[0] == 1)[-1]]
    assert [at_peak, end] == [2, 2]


@pytest.mark.nightly
def test_time_integration_leaves_the_peak(unstable):
    """From the state of the peak the mass goes to a motion about twice as large."""
    check = unstable.verify_in_time(0, unstable.peak_point(), periods=2000)
    assert check.unstable


@pytest.mark.parametrize(("kind", "seed", "flag"), [("varying load", 5000, "UNSTABLE"), ("barely pressed", 5008, "STABLE")])
def test_the_motion_is_judged_and_not_its_few_harmonics(kind, seed, flag):
    """A disturbance of the solution with 5 harmonics grows in both. In time that of the first motion grows by a factor of 1.58 a
    period; that of the second decays by 0.91, as of the solution with 15 harmonics."""
    case = random_case(kind, seed)
    response = ss.forced_response(case.problem, case.band, case.level, harmonics=HARMONICS, samples=SAMPLES)
    assert response.dataset["highest_stability"].values[0, 0] == Stability[flag]
    assert ("Unstable motion" in str(response.dataset["case_message"].values[0])) == (flag == "UNSTABLE")
