"""How the climb to a peak chooses where to solve next, on samples of known hills."""

from types import SimpleNamespace

import pytest

from stickslip.solve.peaks.climb import _bracket, _next


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
