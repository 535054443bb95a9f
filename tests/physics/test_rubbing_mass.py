"""A mass that slides on a shaking ground under rigid friction: the work of friction has a closed form, and contacts as stiff as
these need many harmonics.

m = 1 kg, μN = 1 N, base acceleration A sin 2πt: the case SDND104 of code_aster. In steady motion the mass slips twice a period
up to A = √(1 + (π/2)²) m/s², and all the time from there on.
"""

from math import asin, cos, hypot, pi, sin

import numpy as np
import pytest
from scipy.optimize import brentq

import stickslip as ss
from stickslip.solve.balance.balance import HarmonicBalance
from stickslip.solve.continuation import continuation, truncation

FIRST = 2.0 * pi
ALWAYS_SLIPS = hypot(1.0, 0.5 * pi)


def exact_work(A):
    """J per period of rigid friction of 1 N on 1 kg: relative acceleration −A sin 2πt − sign(v)."""
    if A <= 1.0:
        return 0.0
    if A > ALWAYS_SLIPS:
        # The velocity changes its sign every half period, at the angle where cos is π/(2A).
        return 4.0 * A * np.sqrt(1.0 - (pi / (2.0 * A)) ** 2) / FIRST**2
    begin = asin(1.0 / A)
    end = brentq(lambda t: A * (cos(begin) - cos(t)) - (t - begin), begin + 1e-6, begin + pi, xtol=1e-14)
    path = A * cos(begin) * (end - begin) - A * (sin(end) - sin(begin)) - 0.5 * (end - begin) ** 2
    return 2.0 * path / FIRST**2


def rubbing_mass(spring=1e4, kt=1e6):
    """A mean spring, N/m, holds the place about which the mass slides."""
    structure = ss.Structure(np.eye(1), np.zeros((1, 1)), ("1.x",))
    ground = ss.Contact("ground", ss.Macroslip(kt, 0.1, normal_load=10.0), (ss.between("1.x", "ground"),))
    held = (ss.Spring({"1.x": 1.0}, spring),) if spring else ()
    return ss.Problem(structure, (ground,), (ss.BaseMotion({"1.x": 1.0}, -1j),), ("1.x",), mean_springs=held)


def response(A, harmonics, samples=1024, **of):
    return ss.forced_response(rubbing_mass(**of), [1.0], A, harmonics=harmonics, samples=samples).dataset


RIGID = {15.0: 1.5114614, 1.5: 0.04090625, 1.01: 2.261641e-5, 0.99: 0.0}


@pytest.mark.parametrize(("A", "published"), RIGID.items())
def test_the_closed_form_is_the_published_one(A, published):
    assert exact_work(A) == pytest.approx(published, rel=1e-6)


WORK = {
    15.0: {41: 1.512038, 121: 1.512038, 151: 1.512038},
    1.5: {41: 0.0416546, 121: 0.0410382, 151: 0.0409750},
    1.01: {41: 3.764651e-5, 121: 2.632552e-5, 151: 2.309037e-5},
    0.99: {121: 0.0},
}
"""J per period with kt = 1e6 N/m and 1024 samples, the table of docs/choose.md."""


@pytest.mark.parametrize(("A", "harmonics"), [(A, harmonics) for A, row in WORK.items() for harmonics in row])
def test_many_harmonics_find_the_work_of_rigid_friction(A, harmonics):
    found = response(A, harmonics)
    assert float(found.dissipated[0, 0, 0]) == pytest.approx(WORK[A][harmonics], rel=2e-6, abs=1e-15)
    assert float(found.energy_residual[0, 0]) < 1e-6


@pytest.mark.parametrize("A", WORK)
def test_the_work_comes_close_to_that_of_rigid_friction(A):
    """Down to what stiffness and samples leave, at 15 m/s², from the first row on."""
    errors = [abs(work - RIGID[A]) for _, work in sorted(WORK[A].items())]
    assert errors == sorted(errors, reverse=True)
    assert errors[-1] <= 0.022 * RIGID[A]


def test_a_list_without_the_mean_needs_no_spring_and_has_the_same_estimate():
    """Gross slip: with 256 samples friction changes its sign at the same two whatever the harmonics, with 1024 it does not."""
    held, odd = response(15.0, 5, 256), response(15.0, [1, 3, 5], 256, spring=0.0)
    assert float(odd.amplitude[0, 0, 0]) == pytest.approx(float(held.amplitude[0, 0, 0]), rel=1e-9)
    few, many = (float(response(15.0, H, 1024).amplitude[0, 0, 0]) for H in (5, 21))
    for each in (held, odd):
        assert float(each.truncation_error[0, 0]) == pytest.approx(abs(many / few - 1.0), rel=0.01)


@pytest.mark.parametrize("A", [1.01, 1.2, 1.5])
def test_the_first_point_with_many_harmonics_is_that_of_the_ramp_and_takes_fewer_matrices(A):
    carried, ramp = (HarmonicBalance(rubbing_mass(), 45, 512) for _ in range(2))
    first, ramped = continuation.first_point(carried, FIRST, A), continuation._ramped(ramp, FIRST, A)
    assert first.converged
    np.testing.assert_allclose(first.evaluation.w, ramped.evaluation.w, rtol=0.0, atol=1e-9 * np.abs(ramped.evaluation.w).max())
    assert carried.system.effort[1] < ramp.system.effort[1]


def test_a_line_search_stops_where_damped_steps_do_not(monkeypatch):
    few = continuation.first_point(HarmonicBalance(rubbing_mass(), 9, 512), FIRST, 1.5)
    many = HarmonicBalance(rubbing_mass(), 27, 512)
    assert truncation.resolved(many, few.evaluation).converged
    assert not truncation.resolved(many, few.evaluation, steps=0).converged
    monkeypatch.setattr(truncation, "_damped", lambda *_: None)
    assert not truncation.resolved(many, few.evaluation).converged


def test_a_balance_of_fewer_harmonics_keeps_lists_starts_and_periods():
    balance = HarmonicBalance(rubbing_mass(), [0, 1, 3, 5, 7], 64, 1).with_starts(np.array([1e-7]))
    fewer = balance.with_harmonics(4)
    assert fewer.harmonics == (0, 1, 3)
    assert fewer.table.start_value.tolist() == [1e-7]
    doubled = HarmonicBalance(rubbing_mass(), 5, 64, periods=2)
    assert doubled.with_harmonics(6).highest == 6
    assert doubled.with_harmonics(6).first == doubled.first


@pytest.mark.parametrize(("A", "harmonics"), [(1.5, 41), (1.01, 41), (1.01, 121)])
def test_the_work_has_an_estimate_of_its_own(A, harmonics):
    """Of the order of the true error, which is a third larger to three times as large: the estimate sees twice the harmonics."""
    found = response(A, harmonics)
    true = abs(float(found.dissipated[0, 0, 0]) / exact_work(A) - 1.0)
    assert 0.3 < float(found.work_error[0, 0]) / true < 1.1
    if A == 1.5:
        estimates = float(found.truncation_error[0, 0]), float(found.work_error[0, 0]), true
        assert estimates == pytest.approx((0.008, 0.012, 0.018), abs=0.0005)
    assert "The energy dissipated in contacts at the highest peak of 1.x would change" in str(found.case_message.values[0])


@pytest.mark.parametrize("A", [0.99, 15.0])
def test_work_that_is_right_has_no_warning(A):
    """Stuck, and in gross slip, where harmonics and samples change 1e-4 of the work."""
    found = response(A, 41)
    assert float(found.work_error[0, 0]) < 1e-3
    assert "dissipated" not in str(found.case_message.values[0])
