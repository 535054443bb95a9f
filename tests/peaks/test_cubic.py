"""Extremes of the cubic between two points of a curve, where its terms cancel."""

import numpy as np
import pytest

from stickslip.solve.peaks.search import Cubic


@pytest.mark.parametrize(
    ("cubic", "trough"),
    [
        (Cubic(302.28, 39.54, -1.32e-18, 1.55e-18), 1.0),  # falls from a level place to a level place, both at a rounding's slope
        (Cubic(302.28, 39.54, -1.0, 1e-6), None),
        (Cubic(39.54, 302.28, -1e-6, 1.0), None),
        (Cubic(1.0, 1.0, 0.0, 3.0), None),
        (Cubic(0.0, 1.0, 0.0, 3.0), 0.0),  # f³: level at its beginning, of no linear term
        (Cubic(1.0, 1.5, -1.0, 2.0), 1.0 / 3.0),  # 1 − f + 1.5 f², of no square term
        (Cubic(1.0, 1.0, -2.0, 2.0), 0.5),
    ],
)
def test_trough(cubic, trough):
    fraction = cubic.trough
    assert 0.0 <= fraction <= 1.0
    if trough is not None:
        assert fraction == pytest.approx(trough, abs=1e-12)
    below = min(cubic.at(f) for f in np.linspace(0.0, 1.0, 2001))
    assert cubic.at(fraction) <= below + 1e-12 * abs(cubic.a - cubic.b)


def test_inner_extremes_keep_their_digits():
    """f³/3 − (s + t) f²/2 + s t f, of slope (f − s)(f − t): the smaller root s is lost where both terms of it cancel."""
    s, t = 1e-13, 0.75
    found = Cubic(0.0, 1.0 / 3.0 - 0.5 * (s + t) + s * t, s * t, (1.0 - s) * (1.0 - t)).inner_extremes
    assert found[1] == pytest.approx(t, rel=1e-12)
    assert found[0] == pytest.approx(s, rel=1e-12)
