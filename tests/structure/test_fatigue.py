"""The fatigue limit of a material against hand calculation, and what is refused.

Strengths of a titanium alloy: S = 400 MPa, R_m = 1000 MPa, R_p = 900 MPa.
"""

import numpy as np
import pytest

import stickslip as ss
from stickslip.support.checks import InputError

MPA = 1e6
STRENGTHS = {"fatigue_strength": 400.0 * MPA, "ultimate_strength": 1000.0 * MPA}


@pytest.mark.parametrize(
    ("limit", "mean", "allowed"),
    [
        (ss.FatigueLimit(**STRENGTHS), 250.0, 300.0),  # 400 (1 - 250/1000)
        (ss.FatigueLimit(**STRENGTHS), -250.0, 400.0),
        (ss.FatigueLimit(**STRENGTHS), 1000.0, 0.0),
        (ss.FatigueLimit(**STRENGTHS), 1500.0, 0.0),
        (ss.FatigueLimit(**STRENGTHS, criterion="gerber"), 250.0, 375.0),  # 400 (1 - 1/16)
        (ss.FatigueLimit(**STRENGTHS, criterion="gerber"), 500.0, 300.0),
        (ss.FatigueLimit(**STRENGTHS, criterion="gerber"), -500.0, 400.0),
        (ss.FatigueLimit(fatigue_strength=400.0 * MPA, yield_strength=800.0 * MPA, criterion="soderberg"), 200.0, 300.0),
        (ss.FatigueLimit(**STRENGTHS, yield_strength=600.0 * MPA), 400.0, 200.0),  # yields: 600 - 400 < 400 (1 - 0.4)
        (ss.FatigueLimit(**STRENGTHS, yield_strength=600.0 * MPA), -300.0, 300.0),
        (ss.FatigueLimit(points=[[-100.0 * MPA, 300.0 * MPA], [100.0 * MPA, 200.0 * MPA], [500.0 * MPA, 0.0]]), 300.0, 100.0),
        (ss.FatigueLimit(points=[[-100.0 * MPA, 300.0 * MPA], [100.0 * MPA, 200.0 * MPA]]), 101.0, 0.0),
        (ss.FatigueLimit(points=[[-100.0 * MPA, 300.0 * MPA], [100.0 * MPA, 200.0 * MPA]]), -500.0, 300.0),
    ],
)
def test_the_allowed_amplitude_is_that_by_hand(limit, mean, allowed):
    assert float(limit.amplitude(mean * MPA)) == pytest.approx(allowed * MPA, rel=1e-12, abs=1e-3)


def test_no_line_ends_before_its_largest_mean():
    """Above zero just before it, zero from it on."""
    for criterion in ("goodman", "gerber"):
        limit = ss.FatigueLimit(**STRENGTHS, criterion=criterion)
        assert limit.amplitude(np.array([0.999, 1.0]) * limit.largest_mean).tolist() == [pytest.approx(0.4 * MPA, rel=1.1), 0.0]


@pytest.mark.parametrize(
    ("given", "words"),
    [
        ({}, "fatigue_strength must be given"),
        ({"fatigue_strength": 4e8}, 'ultimate_strength must go with criterion = "goodman"'),
        ({**STRENGTHS, "criterion": "soderberg"}, "yield_strength must go with"),
        ({"fatigue_strength": 1e9, "ultimate_strength": 4e8}, "Are they exchanged"),
        ({**STRENGTHS, "criterion": "smith"}, "criterion"),
        ({"fatigue_strength": -1.0, "ultimate_strength": 4e8}, "positive"),
        ({**STRENGTHS, "points": [[0.0, 1.0], [1.0, 0.0]]}, "must stand alone"),
        ({"points": [[0.0, 1.0], [0.0, 0.0]]}, "rising mean stresses"),
        ({"points": [[0.0, 1.0], [1.0, -1.0]]}, "no negative amplitude"),
        ({"points": [[0.0, 1.0]]}, "two or more pairs"),
    ],
)
def test_what_states_no_limit_is_refused(given, words):
    with pytest.raises(InputError, match=words):
        ss.FatigueLimit(**given)
