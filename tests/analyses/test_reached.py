"""Which of several motions a machine shows, of a hardening oscillator and of one with an absorber that has a detached curve."""

import numpy as np
import pytest

import stickslip as ss
from stickslip.support.checks import InputError


def oscillator(sign=1.0, stiffness=1.0):
    structure = ss.Structure(np.eye(1), np.eye(1), ("1.x",), C=0.1 * np.eye(1))
    spring = ss.Contact("spring", ss.CubicSpring(sign * stiffness), (ss.between("1.x", "ground"),))
    return ss.Problem(structure, (spring,), (ss.Force("1.x", 1.0),), ("1.x",))


def response(problem, ends, level, **how):
    return ss.forced_response(problem, ss.radians_per_second(*ends), level, harmonics=5, samples=64, **how)


@pytest.fixture(scope="module")
def hardening():
    return response(oscillator(), (0.5, 2.2), [0.02, 0.2])


def test_a_hardening_peak_is_reached_by_a_sweep_up_alone(hardening):
    """Under 0.02 the curve has no fold, and everything leads to its peak; the motion above the fold needs a sweep up."""
    table = hardening.reached(steps_per_period=200)
    assert table[["from_rest", "sweep_up", "sweep_down"]].values.tolist() == [[True, True, True], [False, True, False]]
    assert np.isnan(table.next_lower[0])
    # The unstable motion at the frequency of the peak, which is the next lower one there.
    at = hardening.at([table.frequency[1]]).isel(case=1, frequency=0, output=0)
    amplitudes = np.sort(at.amplitude.values[np.isfinite(at.amplitude.values)])
    assert amplitudes.size == 3
    np.testing.assert_allclose(table.next_lower[1], amplitudes[1], rtol=0.05)


def test_at_the_frequency_of_a_solved_point_no_other_motion_is_lost():
    """A curve that is begun below a fold and ended above passes each frequency an odd number of times, a fold itself apart."""
    found = response(oscillator(-1.0, 0.1), (0.4, 1.5), 0.17, isolated=False)
    frequency = found.dataset.frequency.values[0]
    inner = [f for f in frequency[1:-1] if frequency[0] < f < frequency[-1]]
    counts = np.isfinite(found.at(inner).amplitude.values[0, :, :, 0]).sum(axis=0)
    turns = np.flatnonzero(np.diff(np.sign(np.diff(frequency))))
    assert turns.size == 2
    assert np.isin(counts, (1, 3)).all()
    assert (counts == 3).sum() > 10


def test_a_softening_peak_is_reached_by_a_sweep_down_alone():
    table = response(oscillator(-1.0, 0.1), (0.4, 1.5), 0.16).reached(steps_per_period=200)
    assert table[["sweep_up", "sweep_down"]].values.tolist() == [[False, True]]


def test_a_sweep_begins_at_rest_where_the_curve_ends_on_its_upper_part():
    """The band ends below the fold: a sweep down begins on the lower motion, which the curve does not reach."""
    problem = oscillator()
    up = response(problem, (0.5, 1.5), 0.2, quantity="receptance", isolated=False).reached(steps_per_period=200)
    down = response(problem, (1.5, 0.5), 0.2, isolated=False).reached(steps_per_period=200)
    assert up[["sweep_up", "sweep_down"]].values.tolist() == [[True, None]]
    assert up.unknown[0].endswith("sweep_down: a motion of no curve at 0.23873 Hz")
    assert down[["sweep_up", "sweep_down"]].values.tolist()[0][1] is False
    assert up.amplitude[0] < 5.0  # a displacement, not a receptance


def test_no_sweep_reaches_a_detached_curve():
    m, k, c = 0.05, 0.0454, 0.0073
    structure = ss.Structure(np.diag([1.0, m]), np.array([[1.0 + k, -k], [-k, k]]), ("1.x", "2.x"), C=[[0.0005 + c, -c], [-c, c]])
    problem = ss.Problem(structure, oscillator().contacts, (ss.Force("1.x", 1.0),), ("1.x",))
    found = response(problem, (0.7, 2.0), 0.038)
    table = found.reached(steps_per_period=200)
    assert table.curve.tolist() == ["sweep", "isolated"]
    assert table[["sweep_up", "sweep_down"]].values.tolist() == [[True, False], [False, False]]
    assert not table.from_rest[1]
    assert table.next_lower[1] < table.amplitude[1]


def test_what_time_integration_does_not_settle_is_not_known(hardening):
    table = hardening.reached(steps_per_period=200, periods=2)
    assert table.from_rest.tolist() == [None, None]
    assert table.unknown[0].startswith("from_rest: not periodic after 2 periods at 0.16107 Hz")
    assert table.sweep_up.tolist() == [True, True]  # no fold comes before the peak
    assert table.sweep_down.tolist() == [None, None]  # where it begins is not known


def test_listed_frequencies_are_refused():
    listed = ss.forced_response(oscillator(), [0.16], 0.1, harmonics=3, samples=64)
    with pytest.raises(InputError, match="must be asked of a response over a band"):
        listed.reached()
