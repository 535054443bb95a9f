"""Sweeps of one slider on many modes, undamped or nearly so, beside the closed form of one harmonic."""

import numpy as np
import pytest

from robustness.one_slider import RATIOS, HighestResult, drawn

MANY = 40


@pytest.mark.parametrize(
    ("seed", "omega", "ratio"),
    [
        pytest.param(3, 1.568405765, 0.0, marks=pytest.mark.nightly),
        pytest.param(25, 3272.393984, 0.0, marks=pytest.mark.nightly),
        (12, 3768.8095, 1e-6),
    ],
    ids=["undamped", "undamped, in rad/s of a blade", "slip begins beside a resonance"],
)
def test_a_peak_that_friction_makes_is_found(seed, omega, ratio):
    """Without damping the linear resonance is infinite and friction makes the peak; where slip begins on a resonance's flank,
    the peak is a corner, here 600 times lower than the highest of the curve."""
    modes = drawn(seed)
    assert modes.ratio == ratio
    (expected,) = modes.amplitudes(omega)
    peaks = modes.sweep().peaks()
    near = peaks.amplitude[(2.0 * np.pi * peaks.frequency / omega - 1.0).abs() < 1e-3]
    assert near.max() == pytest.approx(expected, rel=2e-3)


@pytest.mark.nightly
def test_where_nothing_slips_a_curve_never_turns_back():
    """A linear response has one motion at each frequency; ratios of 1e-6, forty modes."""
    modes = drawn(20)
    assert modes.ratio == 1e-6
    data = modes.sweep().dataset
    frequency, active = data.frequency.values[0], data.active_rows.values[0]
    kept = np.isfinite(frequency)
    frequency, stuck = frequency[kept], active[kept] == 0
    assert stuck.sum() > 1000
    assert np.all(np.diff(frequency)[stuck[:-1] & stuck[1:]] > 0.0)


@pytest.mark.nightly
@pytest.mark.parametrize("ratio", RATIOS)
def test_the_highest_response_of_a_band_is_found(ratio):
    result = HighestResult(ratio)
    for seed in range(MANY):
        if drawn(seed).ratio == ratio:
            result.add(seed)
    assert result.wrong == []
    assert result.arrived >= (1 if ratio == 0.0 else result.cases)
