"""How the climb to a peak chooses where to solve next, on samples of known hills."""

from types import SimpleNamespace

import numpy as np
import pytest

from stickslip.solve.balance.balance import Point
from stickslip.solve.peaks.climb import NoPeakError, SolvedPeak, _bracket, _next, followed


def sample(s, amplitude, slope):
    return SimpleNamespace(s=s, amplitude=amplitude, slope=slope)


def test_the_highest_sample_has_its_neighbour_on_the_side_to_which_it_rises():
    low, high = sample(1.0, 0.5, 0.4), sample(2.0, 0.8, 0.2)
    assert _bracket([low, high]) == (high, None)
    beyond = sample(3.0, 0.7, -0.3)
    assert _bracket([low, high, beyond]) == (high, beyond)
    falling = sample(2.0, 0.8, -0.2)
    assert _bracket([low, falling, beyond]) == (low, falling)
    assert _bracket([falling, beyond]) == (None, falling)


def test_between_samples_of_a_parabola_the_next_one_is_its_top():
    """A = 1 − (s − 2)²/2: the zero of the slope between its values at 1 and 2.5, and where the tangents meet."""
    below, above = (sample(s, 1.0 - 0.5 * (s - 2.0) ** 2, 2.0 - s) for s in (1.0, 2.5))
    assert _next(below, above, -1.0, 1, 1e-6) == pytest.approx(2.0, rel=1e-12)
    assert _next(below, above, -1.0, 3, 1e-6) == pytest.approx(1.75, rel=1e-12)


@pytest.mark.parametrize("slopes", [(0.1, 0.3), (-0.3, 0.1), (0.3, 0.1)])
def test_slopes_without_a_top_between_them_halve_the_way(slopes):
    assert _next(sample(1.0, 0.0, slopes[0]), sample(4.0, 0.0, slopes[1]), -1.0, 1, 1e-6) == pytest.approx(2.5, rel=1e-12)


@pytest.mark.parametrize(("slope", "way"), [(0.02, 0.01), (-0.02, -0.01)])
def test_one_sample_alone_takes_newtons_step_uphill(slope, way):
    assert _next(sample(1.0, 0.0, slope), None, -2.0, 1, 1e-6) == pytest.approx(1.0 + way, rel=1e-12)


def test_a_peak_is_followed_by_a_quarter_first_and_after_a_failure_the_same_step_is_taken_again():
    """The solver arrives where the predicted frequency, of a peak at 1 + share² rad/s, is less than 0.2 rad/s off."""
    tried = []

    def peak(share):
        point = Point(np.zeros((1, 3)), 1.0 + share**2, 1.0)
        return SolvedPeak(SimpleNamespace(point=point), 1.0, -1.0, 0.0, None, 1, 0)

    def solver_at(share):
        def from_near(start, plane):
            tried.append(share)
            if abs(start.omega - 1.0 - share**2) > 0.2:
                raise NoPeakError("too far")
            return peak(share)

        return SimpleNamespace(from_near=from_near)

    assert followed(solver_at, peak(0.0)).omega == 2.0
    assert tried == [0.25, 0.75, 0.5, 0.75, 1.0]
