"""The admissible interval of stuck elements in closed form, and the derivative of a response by their start states."""

import numpy as np
import pytest

from stickslip.analyses.forced_response import forced_response
from stickslip.model.contact.point import SliderOffset
from stickslip.model.contact.protocol import OFFSET
from stickslip.model.rigs import single_mass, three_mass_wedge
from stickslip.solve.balance.balance import HarmonicBalance
from stickslip.solve.continuation.sensitivity import mean_slopes, respond, solved_factors
from stickslip.solve.curves.curve import solve_curve
from stickslip.solve.starts.states import element_states


def solved(problem, hertz, force):
    balance = HarmonicBalance(problem, 5, 256)
    curve = solve_curve(balance, [2.0 * np.pi * f for f in hertz], force, True)
    return balance, [point.evaluation for point in curve.points]


def test_constant_load_interval():
    """T0 anywhere in [−μN + T̂, μN − T̂] for a stuck element with dynamic amplitude T̂; none once it slips."""
    balance, evaluations = solved(single_mass(kt=1.0, limit=1.0), [0.05, 0.1], 0.4)
    for evaluation in evaluations:
        states = element_states(balance, evaluation)
        assert states.high[0] == pytest.approx(1.0 - np.hypot(*evaluation.w[0, 1:3]), rel=1e-3)
        assert states.low[0] == pytest.approx(-states.high[0], rel=1e-3)
        assert states.stuck[0]
    balance, (slipping,) = solved(single_mass(kt=1.0, limit=1.0), [0.16], 2.0)
    states = element_states(balance, slipping)
    assert states.low[0] == states.high[0]


def test_slope_is_that_of_the_response():
    """The slope at any start state against differences of slider offsets."""
    sliders = np.array([1e-4, -0.5e-4])

    def wedge(values):
        offsets = iter(values)
        return three_mass_wedge().with_contacts(lambda contact: contact.with_start(SliderOffset(float(next(offsets)))))

    balance, (evaluation,) = solved(wedge(sliders), [222.0], 1.0)
    resting = balance.with_starts(element_states(balance, evaluation).slider, OFFSET)
    evaluation, row = resting.evaluate(evaluation.point), balance.rows
    elements, rows, means = mean_slopes(resting, evaluation)
    slopes = np.zeros((elements.size, resting.rows, resting.columns))
    slopes[np.arange(elements.size), rows, 0] = means
    motion = respond(resting, evaluation, solved_factors(resting, evaluation), slopes).motion[:, row, 1:3]
    found = motion @ evaluation.w[row, 1:3] / np.hypot(*evaluation.w[row, 1:3])
    stuck = int(np.argmax(np.abs(found)))
    step = 1e-9 * (np.arange(2) == elements[stuck])
    high, low = (float(forced_response(wedge(sliders + d), [222.0]).dataset.amplitude[0, 0, 0]) for d in (step, -step))
    assert found[stuck] == pytest.approx((high - low) / 2e-9, rel=1e-5)
