"""What is stated in rad/s enters wherever Hz is taken, and messages are in Hz."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

import stickslip as ss
from stickslip.solve.balance.balance import HarmonicBalance
from stickslip.solve.continuation import curve_points
from stickslip.solve.continuation.continuation import first_point, trace
from stickslip.support.checks import InputError

WANTED = [0.9, 1.0, 1.2]


def test_one_frequency_a_list_and_a_band():
    assert ss.radians_per_second(2.0 * np.pi) == 1.0
    assert ss.radians_per_second(np.float64(2.0 * np.pi)) == 1.0
    for several in (WANTED, tuple(WANTED), np.array(WANTED), iter(WANTED)):
        found = ss.radians_per_second(several)
        assert type(found) is list
        assert found == [value / (2.0 * np.pi) for value in WANTED]
    assert ss.radians_per_second(np.pi, 2.0 * np.pi) == ss.hertz(0.5, 1.0)


@pytest.mark.parametrize("wrong", ["x", None, float("nan"), ["a"], [[1.0]], 1j])
def test_what_is_no_frequency_is_refused(wrong):
    with pytest.raises(InputError, match="frequency must be"):
        ss.radians_per_second(wrong)


def test_lists_and_single_places_of_every_kind():
    """A linear mass of 1 kg and 1 N/m with c = 0.1: |X| = F/|1 − ω² + 0.1iω| at each ω in rad/s."""
    linear = ss.Problem(ss.Structure([[1.0]], [[1.0]], ("1.x",), C=[[0.1]]), (), (ss.Force("1.x", 1.0),), ("1.x",))
    omega = np.array(WANTED)
    expected = 1.0 / np.abs(1.0 - omega**2 + 0.1j * omega)
    found = ss.forced_response(linear, ss.radians_per_second(WANTED)).dataset
    np.testing.assert_allclose(found.amplitude.values[0, : omega.size, 0], expected, rtol=1e-9)
    curve = ss.forced_response(linear, ss.radians_per_second(0.5, 2.0))
    between = curve.at(ss.radians_per_second(WANTED))
    np.testing.assert_allclose(np.hypot(*between.response.values[0, 0, :, 0, 1].T), expected, rtol=1e-6)


@pytest.mark.parametrize(
    ("parameter", "value", "where"), [("omega", 0.2 * np.pi, "at 0.1 Hz"), ("level", 0.5, "at force level 0.5")]
)
def test_a_lost_place_is_named_in_hertz(monkeypatch, parameter, value, where):
    balance = HarmonicBalance(ss.rigs.single_mass(), 1, 16)
    curve = list(trace(balance, first_point(balance, 0.5, 1.0), "omega", 1.0))
    monkeypatch.setattr(curve_points, "correct", lambda *_, **__: SimpleNamespace(converged=False))
    ends = curve[0], replace(curve[1], evaluation=replace(curve[1].evaluation, point=replace(curve[1].point, level=0.4)))
    with pytest.raises(curve_points.LostCurveError, match=f"Newton's method failed {where}"):
        curve_points.solve_at(balance, *ends, parameter, value)
