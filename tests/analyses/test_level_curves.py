"""Detached curves found along the force level: beside their closed form, and the amplitude that a level can sustain."""

import numpy as np
import pytest

import stickslip as ss
from stickslip.analyses.level_curves import sustained
from tests.analyses.closed_form_isolas import BAND, is_found, isolas


def found(cases):
    band = ss.radians_per_second(*BAND)
    results = (ss.forced_response(each.problem, band, each.level, harmonics=1, samples=64, isolated=True) for each in cases)
    return sum(is_found(each, result.dataset) for each, result in zip(cases, results, strict=True))


def test_isolas_in_closed_form_are_found():
    assert found(isolas(5, 3)) == 3


@pytest.mark.nightly
def test_of_a_hundred_isolas_in_closed_form_95_are_found():
    assert found(isolas(2, 100)) >= 95


def oscillator(damping):
    structure = ss.Structure(np.diag([1.0, 2.0]), np.diag([1.0, 4.0]), ("a.x", "b.x"), C=np.diag(damping))
    stop = ss.Contact("stop", ss.Gap(1.0, gap=1.0), (), {"a.x": 1.0})
    return ss.Problem(structure, (stop,), (ss.Force("a.x", 3.0),), ("a.x", "b.x"))


def test_the_bound_is_the_linear_resonance_of_one_mass():
    """At its resonance X = F/(ω c), which no contact can raise; what the force cannot feed does not vibrate by it."""
    np.testing.assert_allclose(sustained(oscillator([0.1, 0.3]), 1.0, 0.5), [15.0, 0.5 * 0.5 * 3.0 / np.sqrt(0.03)])


def test_no_bound_without_damping_of_what_is_driven_or_asked_for():
    np.testing.assert_allclose(sustained(oscillator([0.1, 0.0]), 1.0, 0.5), [15.0, np.inf])
    assert np.isinf(sustained(oscillator([0.0, 0.1]), 1.0, 0.5)).all()
