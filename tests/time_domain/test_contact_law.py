"""All contacts at one instant of a march: their derivatives by the motion, and steps against many small ones."""

import numpy as np
import pytest
from laws.kernel import contact_of
from laws.samples import DISC_SAMPLES, EVERY_SAMPLE, SAMPLES

import stickslip as ss
from stickslip.model.contact.point import SliderOffset, contact_table
from stickslip.solve.time.contact_law import Earlier, contact_law, no_slopes
from stickslip.support.kernels import uncompiled

RATE = 0.7
"""Velocity after a step by the motion after it, 1/s."""


def after(table, w, before):
    """Slopes after a step to motion w, and what the contacts remember there."""
    slopes, intercept, limit = uncompiled(no_slopes)(table.rows), before.intercept.copy(), before.limit.copy()
    contact_law(table, w, before, intercept, limit, slopes)
    return slopes, Earlier(intercept, w.copy(), limit, -RATE * w, RATE, True, 1.0 / RATE)


def begun(table, rng):
    """Contacts somewhere within a random motion."""
    zeros, nothing = np.zeros(table.rows), np.zeros(table.stiffness.size)
    state = Earlier(nothing, zeros, nothing, zeros, RATE, True, 1.0 / RATE)
    for _ in range(2):
        state = after(table, rng.standard_normal(table.rows), state)[1]
    return state


@pytest.mark.parametrize("sample", EVERY_SAMPLE, ids=lambda sample: sample.name)
def test_derivatives_of_a_step_are_those_of_differences(sample):
    """By the own motion, which the velocity follows, by the normal one, and by the other tangential one, landings included."""
    table, rng = contact_table([contact_of(sample, SliderOffset())]), np.random.default_rng(4)
    step, compared, kinks, landed = 1e-6, 0, 0, 0
    normal = table.rows - 1 if sample.law.has_normal else -1
    for _ in range(60):
        before = begun(table, rng)
        w = before.w + rng.standard_normal(table.rows)
        here = after(table, w, before)[0]
        landed += bool(normal >= 0 and before.w[normal] < 0.0 < w[normal])
        for moved in range(table.rows):
            ahead, behind = (after(table, w + side * step * np.eye(table.rows)[moved], before)[0].target for side in (1.0, -1.0))
            for r in range(table.rows):
                found = here.own if r == moved else here.coupling if moved == normal else here.cross
                one, other = (ahead[r] - here.target[r]) / step, (here.target[r] - behind[r]) / step
                if abs(one - other) > 1e-3:
                    kinks += 1
                    continue
                assert found[r] == pytest.approx(0.5 * (one + other), abs=2e-5 * (1.0 + abs(one)))
                compared += 1
    assert compared > 50
    assert kinks < 0.05 * compared
    assert landed > 5 or normal < 0


def test_a_slider_lands_where_its_load_begins_however_far_the_step_goes_beyond_a_bend():
    """From z = −0.1 to 0.1 m it lands half of the way: T = kt u/2, which is far below its limit."""
    law = ss.Macroslip(2.0, ss.LoadDependentFriction((0.1, 1.0), (50.0, 20.0)), kn=3.0)
    table = contact_table([ss.Contact("c", law, ({"1.x": 1.0},), {"1.y": 1.0})])
    nothing = np.zeros(1)
    before = Earlier(nothing, np.array([0.0, -0.1]), nothing, np.zeros(2), RATE, True, 1.0 / RATE)
    slopes, _ = after(table, np.array([0.2, 0.1]), before)
    assert slopes.target[0] + 2.0 * 0.2 == pytest.approx(0.2, rel=1e-12)


STRAIGHT = [sample for sample in (*SAMPLES, *DISC_SAMPLES) if not any(element.table[0] for element in sample.elements)]
"""Samples whose limit does not bend within a step."""


@pytest.mark.parametrize("sample", STRAIGHT, ids=lambda sample: sample.name)
def test_a_step_along_a_straight_way_is_that_of_many_small_ones(sample):
    """Sliders and discs are exact where motion and limit go straight, also from where they land."""
    table, rng = contact_table([contact_of(sample, SliderOffset())]), np.random.default_rng(5)
    for _ in range(40):
        before = begun(table, rng)
        change, state = rng.standard_normal(table.rows), before
        whole, end = after(table, before.w + change, before)
        for k in range(1, 401):
            small, state = after(table, before.w + k / 400 * change, state)
        np.testing.assert_allclose(whole.target, small.target, atol=1e-9)
        np.testing.assert_allclose(end.limit, state.limit, atol=1e-12)
