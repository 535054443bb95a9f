"""What a start value does to the force of an element that sticks, against differences; nothing where its start is clipped."""

import numpy as np
import pytest

from stickslip.model.contact.protocol import MEAN, OFFSET, RATIO, friction_period
from stickslip.solve.continuation.sensitivity import _start_slope

KT = 2.0


def period(kind, value):
    """State and y of a stuck element whose limit varies, 0.7 at the last sample."""
    angles = 2.0 * np.pi * np.arange(1, 17) / 16
    u, limit = 0.05 * np.sin(angles), 1.0 - 0.3 * np.cos(angles)
    y, event = np.empty(16), np.empty(16, dtype=np.int64)
    state = friction_period(kind, value, KT, KT * u, limit, np.zeros(16), KT * float(u.mean()), y, event)
    return state, y, limit


@pytest.mark.parametrize(("kind", "value"), [(OFFSET, 0.1), (RATIO, 0.4), (MEAN, 0.2)])
def test_the_slope_by_a_start_value_is_that_of_differences(kind, value):
    state, y, limit = period(kind, value)
    assert np.ptp(y) == 0.0
    difference = (period(kind, value + 1e-6)[1][0] - period(kind, value - 1e-6)[1][0]) / 2e-6
    assert _start_slope(state, kind, KT, limit) == pytest.approx(difference, rel=1e-6)


@pytest.mark.parametrize("kind", [OFFSET, MEAN])
def test_a_clipped_start_has_no_slope(kind):
    state, y, limit = period(kind, 50.0)
    assert y[0] == period(kind, 51.0)[1][0]
    assert _start_slope(state, kind, KT, limit) is None
