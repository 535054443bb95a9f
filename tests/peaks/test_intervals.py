"""Bounds of the amplitude between solved places: smooth tops, corners, and how many places prove the highest."""

import numpy as np
import pytest

from stickslip.solve.peaks.search import Interval, Sample, SegmentPoint, highest_inside

NOTHING = np.zeros(0)


def sample(x, amplitude, slope):
    """A place of a curve whose arc length is the share of the one segment."""
    return Sample(SegmentPoint(0, x, x, NOTHING, NOTHING, 0.0, None), amplitude, slope)


def smooth(x):
    """A top at 0.4123 between inflections."""
    y = 3.0 * (x - 0.4123)
    return 1.0 / (1.0 + y * y), -6.0 * y / (1.0 + y * y) ** 2


def corner(x):
    """A roof at 0.4123, as where a contact changes state in a sample."""
    return (1.0 + 0.3 * (x - 0.4123), 0.3) if x < 0.4123 else (1.0 - 2.0 * (x - 0.4123), -2.0)


def steps(x):
    """A flat top of small corners, 64 in all: what sampling makes of a smooth one."""
    nodes = np.linspace(0.0, 1.0, 65)
    values = smooth(nodes)[0]
    k = min(int(x * 64.0), 63)
    slope = float(64.0 * (values[k + 1] - values[k]))
    return float(values[k] + slope * (x - nodes[k])), slope


def proven(curve, tolerance=1e-8):
    """The highest place found, and how many were solved: the interval of the highest bound is divided, as in a search."""
    intervals = [Interval(*(sample(x, *curve(x)) for x in (a, b))) for a, b in ((0.0, 0.3), (0.3, 0.7), (0.7, 1.0))]
    for solved in range(300):
        bounds = [highest_inside(intervals, i) for i in range(len(intervals))]
        best = max(end.amplitude for interval in intervals for end in (interval.low, interval.high))
        if max(bounds) <= (1.0 + tolerance) * best:
            return best, solved
        i = bounds.index(max(bounds))
        x = intervals[i].division()
        intervals[i : i + 1] = intervals[i].divided(sample(x, *curve(x)))
    pytest.fail("the highest place is not proven with 300 solutions")


@pytest.mark.parametrize(("curve", "most"), [(smooth, 35), (corner, 65), (steps, 55)])
def test_the_highest_place_is_proven_with_few_solutions(curve, most):
    """Against the highest of a fine grid and the corners, 1e-8. With slopes bounded by their size alone: 59, 58 and 62."""
    grid = np.sort(np.append(np.linspace(0.0, 1.0, 64 * 100 + 1), 0.4123))
    best, solved = proven(curve)
    assert best == pytest.approx(max(curve(x)[0] for x in grid), rel=2e-8)
    assert solved <= most


def test_a_bound_is_the_highest_that_slopes_between_two_allow():
    interval = Interval(sample(0.0, 1.0, 0.0), sample(1.0, 1.2, 0.0))
    assert interval.bound(-1.0, 1.0) == pytest.approx(1.6)
    assert interval.bound(-0.5, 2.0) == pytest.approx(1.0 + 2.0 * 0.28)
    assert interval.bound(0.1, 2.0) == 1.2
    assert interval.bound(-2.0, -0.1) == 1.2


def test_slopes_that_were_badly_predicted_nearby_widen_the_bound():
    """Between two falling places the highest is the first one, unless a division beside them met an unexpected slope."""

    def bound(error, beside):
        first = Interval(sample(0.0, 1.1, -0.1), sample(0.1, 1.09, -0.1), beside)
        return highest_inside([first, Interval(sample(0.1, 1.09, -0.1), sample(0.2, 1.08, -0.1), error)], 1)

    assert bound(0.0, 0.0) == 1.09
    assert bound(0.0, 1.0) > 1.1
    assert bound(1.0, 0.0) > 1.1
    assert bound(None, 0.0) == pytest.approx(0.5 * (1.09 + 1.08) + 0.5 * 0.2 * 0.1)


def test_what_a_division_near_an_end_leaves_is_divided_in_the_middle():
    """The tangents of this corner meet at 0.05; of the rest again near its end, which would take a twentieth off each time."""
    corner = Interval(sample(0.0, 1.0, 1.9), sample(1.0, 1.0, -0.1))
    assert corner.division() == pytest.approx(0.05, rel=1e-12)
    _, rest = corner.divided(sample(0.05, 1.09, 1.9))
    assert rest.division() == pytest.approx(0.525, rel=1e-12)
    halves = corner.divided(sample(0.5, 1.05, 1.9))
    assert not any(half.left for half in halves)
