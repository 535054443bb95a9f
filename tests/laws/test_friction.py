"""A coefficient of friction that depends on the normal load: its slip limit, derivative and checks, and its use by laws."""

import numpy as np
import pytest

import stickslip as ss
from stickslip.model.contact.law import line_of
from stickslip.model.contact.point import contact_table
from stickslip.solve.platforms.cycle import slip_limits
from stickslip.support.checks import InputError

LOADS, VALUES = np.array([10.0, 40.0, 200.0]), np.array([0.6, 0.45, 0.3])
MU = ss.LoadDependentFriction(tuple(LOADS), tuple(VALUES))


def test_the_slip_limit_is_straight_between_its_values_and_the_coefficient_constant_beyond():
    np.testing.assert_allclose(MU.limit(LOADS), LOADS * VALUES, rtol=1e-14)
    np.testing.assert_allclose(MU.limit([25.0, 120.0]), [0.5 * (6.0 + 18.0), 0.5 * (18.0 + 60.0)], rtol=1e-14)
    np.testing.assert_allclose(MU.coefficient([0.0, 1.0, 10.0, 200.0, 1e4]), [0.6, 0.6, 0.6, 0.3, 0.3], rtol=1e-14)
    assert MU.limit(-1.0) == 0.0


@pytest.mark.parametrize("exponent", [-1.0 / 3.0, -0.5, -0.9, -1.0, 0.3])
def test_a_power_law_is_met_over_four_decades(exponent):
    found = ss.LoadDependentFriction.power(0.5, 50.0, exponent)
    loads = np.geomspace(0.5, 5000.0, 1777)
    exact = 0.5 * (loads / 50.0) ** exponent
    np.testing.assert_allclose(found.coefficient(loads), exact, rtol=0.004 if exponent > 0.0 else 0.002)
    assert found.coefficient(50.0) == pytest.approx(0.5, rel=1e-12)
    assert found.coefficient(5e4) == pytest.approx(exact[-1], rel=1e-12)


def test_the_derivative_of_the_slip_limit_is_that_of_differences():
    law = ss.Macroslip(1e6, MU, kn=2e6, preload=30.0)
    group, normal = law.elements(1, True).friction[0], law.elements(1, True).normal
    for z in (-1.4e-5, -8e-6, 1e-6, 6e-5, 2e-4):
        slope, step = (line_of(MU).slope * (1.0 + group.change.T @ group.passed(normal.forces(z)))).item(), 1e-8
        ahead, behind = (group.limits(normal.forces(z + side * step))[0] for side in (1.0, -1.0))
        closed = float(normal.forces(z)[0] > 0.0)
        assert slope * 2e6 * closed == pytest.approx((ahead - behind) / (2.0 * step), rel=1e-6, abs=1e-3)


def test_a_share_of_a_surface_has_the_coefficient_of_its_share_of_the_load():
    law = ss.Macroslip(1e6, MU, kn=2e6, preload=60.0)
    whole, part = law.elements(1, True), law.share(0.25).elements(1, True)
    for z in (-2.9e-5, 0.0, 5e-5):
        limits = [each.friction[0].limits(each.normal.forces(z))[0] for each in (whole, part)]
        assert limits[1] == pytest.approx(0.25 * limits[0], rel=1e-12)


def test_an_array_loaded_alike_has_the_coefficient_of_the_whole():
    table = ss.MicroslipArray((1e6, 3e6), MU, normal_load=(20.0, 60.0)).elements(1, False).friction[0]
    assert table.limits(np.zeros(0)).sum() == pytest.approx(float(MU.limit(80.0)), rel=1e-12)
    following = ss.MicroslipArray((1e6, 3e6), MU, kn=(1e6, 3e6)).elements(1, True)
    limits = following.friction[0].limits(following.normal.forces(2e-5))
    assert limits.sum() == pytest.approx(float(MU.limit(80.0)), rel=1e-12)


def test_an_iwan_law_slips_as_a_whole_at_the_limit():
    law = ss.Iwan(1e6, MU, kn=2e6, preload=80.0)
    assert law.virgin_curve(1e-3) == pytest.approx(float(MU.limit(80.0)), rel=2e-3)
    constant = ss.Iwan(1e6, MU, normal_load=80.0)
    for u in (1e-5, 3e-5, 1e-3):
        assert law.virgin_curve(u) == pytest.approx(constant.virgin_curve(u), rel=1e-12)


def test_limits_of_a_whole_table_are_those_of_its_laws():
    laws = [ss.Macroslip(1e6, 0.3, kn=2e6), ss.Macroslip(1e6, MU, kn=2e6), ss.Macroslip(1e6, 2.0 * MU, kn=2e6)]
    contacts = [ss.Contact(f"{k}", law, ({"1.x": 1.0},), {"1.y": 1.0}) for k, law in enumerate(laws)]
    found = slip_limits(contact_table(contacts), np.array([50.0, 120.0, 300.0]))
    np.testing.assert_allclose(found, [15.0, MU.limit(120.0), 2.0 * MU.limit(300.0)], rtol=1e-12)


def test_the_points_of_a_strip_share_the_coefficient_of_its_overlap():
    """Each platform carries half of the pull, so friction of the whole is μ(F_C/2) F_C/2, whatever the number of points."""
    for points in (1, 8):
        strip = ss.rigs.strip_damper(pull=160.0, mu=MU, points=points)
        limits = [float(contact.law.mu.limit(contact.law.normal_load)) for contact in strip.contacts[:points]]
        assert sum(limits) == pytest.approx(float(MU.limit(80.0)), rel=1e-12)
    with pytest.raises(InputError, match="mu"):
        ss.rigs.ring_damper(mu=MU)


def test_an_array_under_constant_loads_has_a_loop():
    """5 sliders of 6 N each: 4 μN (X − μN/kt) for all of them together."""
    u = 1e-3 * np.sin(2.0 * np.pi * np.arange(400) / 400.0)
    found = ss.hysteresis_loop(ss.MicroslipArray(kt=[4e4] * 5, mu=0.35, normal_load=[6.0] * 5), u)
    limit = 0.35 * 30.0
    assert found.energy == pytest.approx(4.0 * limit * (1e-3 - limit / 2e5), rel=1e-3)


def test_a_factor_multiplies_every_coefficient():
    np.testing.assert_allclose((np.float64(1.5) * MU).values, 1.5 * VALUES, rtol=1e-14)
    assert (2.0 * MU).over == MU.over


@pytest.mark.parametrize(
    ("over", "values", "words"),
    [
        ((10.0,), (0.5,), "at least two loads"),
        ((10.0, 20.0), (0.5,), "one for each of the 2 loads"),
        ((20.0, 10.0), (0.5, 0.4), "must ascend"),
        ((0.0, 10.0), (0.5, 0.4), "must be positive"),
        ((10.0, 20.0), (0.5, 0.0), "must be positive"),
        ((10.0, 20.0), (0.5, 0.2), "must not fall faster than 1/N"),
        ((10.0, np.nan), (0.5, 0.4), "must be finite"),
    ],
)
def test_what_is_no_coefficient_is_refused(over, values, words):
    with pytest.raises(InputError, match=words):
        ss.LoadDependentFriction(over, values)


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        ({"exponent": -1.1}, "between -1 and 1"),
        ({"exponent": 0.0}, "A constant coefficient is a number"),
        ({"value": 0.0}, "mu, value must be positive"),
        ({"at": -5.0}, "mu, at must be positive"),
        ({"over": (100.0, 10.0)}, "the lower one first"),
    ],
)
def test_what_is_no_power_law_is_refused(arguments, words):
    with pytest.raises(InputError, match=words):
        ss.LoadDependentFriction.power(**{"value": 0.5, "at": 50.0, "exponent": -0.2} | arguments)


def test_laws_of_the_speed_refuse_it():
    with pytest.raises(InputError, match="mu of a lugre contact must be a number"):
        ss.LuGre(1e6, MU, 0.7, 1e-3, normal_load=10.0)
