"""One element round one period: the composed clamps against marching, and the friction interval they give."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays
from laws.marching import marched, reachable

from stickslip.model.contact.protocol import MEAN, OFFSET, RATIO, SLIPPING, friction_period, start_intercept, stick_interval

number = st.floats(-8.0, 8.0, width=32)
not_negative = st.floats(0.0, 4.0, width=32)


@st.composite
def periods(draw):
    """kt u and limits, some of them zero (open contact), of one period."""
    size = draw(st.integers(1, 24))
    return draw(arrays(float, size, elements=number)), draw(arrays(float, size, elements=not_negative))


@settings(deadline=None, max_examples=300)
@given(periods())
def test_interval_equals_the_reachable_tractions(period):
    ku, limit = period
    low, high = stick_interval(ku, limit, np.zeros(ku.size))
    expected = np.array(reachable(1.0, ku, limit)) - ku[-1]
    np.testing.assert_allclose([low, high], expected, atol=1e-13)
    assert low <= high


@settings(deadline=None, max_examples=300)
@given(periods(), number)
def test_one_period_is_a_projection(period, wanted):
    """Marching one period from any traction gives its clip to [LO, HI]; a second period changes nothing."""
    ku, limit = period
    low, high = stick_interval(ku, limit, np.zeros(ku.size))
    once = marched(1.0, ku, limit, wanted + ku[-1])
    twice = marched(1.0, ku, limit, wanted + ku[-1], periods=2)
    assert once[-1] - ku[-1] == pytest.approx(min(max(wanted, low), high), abs=1e-12)
    assert twice[-1] == pytest.approx(once[-1], abs=1e-12)


@settings(deadline=None, max_examples=300)
@given(periods(), st.sampled_from([OFFSET, RATIO, MEAN]), st.floats(-1.0, 1.0))
def test_steady_period_is_periodic_within_limits_and_from_its_start(period, kind, value):
    ku, limit = period
    y, event = np.empty(ku.size), np.empty(ku.size, dtype=np.int64)
    mean = float(ku.mean())
    state, _, _ = friction_period(kind, value, 1.0, ku, limit, np.zeros(ku.size), mean, y, event)
    low, high = stick_interval(ku, limit, np.zeros(ku.size))
    wanted = start_intercept(kind, value, 1.0, ku, limit, mean)
    assert y[-1] == min(max(wanted, low), high)
    traction = y + ku
    assert np.all(np.abs(traction) <= limit + 1e-13)
    np.testing.assert_allclose(marched(1.0, ku, limit, traction[-1]), traction, atol=1e-12)
    assert (state == SLIPPING) == bool(np.any(event))


@settings(deadline=None, max_examples=200)
@given(periods())
def test_the_interval_of_an_element_that_slips_is_one_value(period):
    """LO = HI exactly, in floating point, once a slip has merged the sweeps; the steady force is then the same for all starts."""
    ku, limit = period
    y, event = np.empty((3, ku.size)), np.empty(ku.size, dtype=np.int64)
    states = [
        friction_period(OFFSET, s, 1.0, ku, limit, np.zeros(ku.size), 0.0, y[i], event)[0]
        for i, s in enumerate((-50.0, 0.0, 50.0))
    ]
    low, high = stick_interval(ku, limit, np.zeros(ku.size))
    if low == high:
        np.testing.assert_array_equal(y[0], y[1])
        np.testing.assert_array_equal(y[0], y[2])
    else:
        assert SLIPPING not in states
        assert np.all(np.ptp(y, axis=1) == 0.0)


def test_path_of_a_jenkins_element():
    """kt 2, limit 3, largest motion 5: u = 0, 5, 3.5, 2, −5, −3.5, −2, 0 gives f = 0, 3, 0, −3, −3, 0, 3, 3 (worked example)."""
    ku = 2.0 * np.array([5.0, 3.5, 2.0, -5.0, -3.5, -2.0, 0.0])
    y, event = np.empty(7), np.empty(7, dtype=np.int64)
    friction_period(OFFSET, 0.0, 2.0, ku, np.full(7, 3.0), np.zeros(7), float(ku.mean()), y, event)
    np.testing.assert_allclose(y + ku, [3.0, 0.0, -3.0, -3.0, 0.0, 3.0, 3.0], atol=1e-15)
    np.testing.assert_array_equal(event != 0, [True, False, False, True, False, False, True])


def test_closed_form_of_the_interval():
    """Where LO < HI: HI = min(L − kt u), LO = max(−L − kt u) over the samples."""
    rng = np.random.default_rng(3)
    for _ in range(100):
        ku, limit = rng.uniform(-1.0, 1.0, 20), rng.uniform(0.8, 2.0, 20)
        low, high = stick_interval(ku, limit, np.zeros(ku.size))
        if low < high:
            assert (low, high) == (np.max(-limit - ku), np.min(limit - ku))
