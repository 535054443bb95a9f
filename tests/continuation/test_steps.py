"""Steps along a curve: the direction of the tangent, the order of the prediction, and the sharpest turn of a step."""

from itertools import pairwise

import numpy as np
import pytest

import stickslip as ss
from stickslip.solve.balance.balance import HarmonicBalance
from stickslip.solve.continuation.continuation import first_point, trace
from stickslip.solve.continuation.steps import StepControl, Steps


def duffing():
    """q̈ + 0.1 q̇ + q + q³/2 = cos ωt: a smooth curve."""
    structure = ss.Structure(np.eye(1), np.eye(1), ("1.x",), C=0.1 * np.eye(1))
    spring = ss.Contact("spring", ss.CubicSpring(0.5), (ss.between("1.x", "ground"),))
    return HarmonicBalance(ss.Problem(structure, (spring,), (ss.Force("1.x", 1.0),), ("1.x",), "Duffing"), 5, 64)


@pytest.mark.parametrize("direction", [1.0, -1.0])
def test_the_tangent_does_not_depend_on_the_side_from_which_planes_are_numbered(direction):
    """The bordered determinant has the other sign where the plane across the curve is that of the opposite tangent."""
    balance = HarmonicBalance(ss.rigs.single_mass(), 3, 64)
    steps = Steps(balance, "omega", 0.1, StepControl())
    point = steps.starting_point(first_point(balance, 1.0, 1.0), direction)
    assert np.sign(point.tangent.parameter) == direction
    assert point.metric.length(point.tangent.motion, point.tangent.parameter) == pytest.approx(1.0, rel=1e-12)
    signs = []
    for across in (point.tangent, point.tangent.turned()):
        factors = balance.factorise(point.evaluation, steps._condition(point.evaluation, across, point.metric, 0.0))
        found = steps._tangent(balance.tangent(point.evaluation, "omega", factors), factors, point.metric)
        assert found.parameter == pytest.approx(point.tangent.parameter, rel=1e-9)
        np.testing.assert_allclose(found.motion, point.tangent.motion, atol=1e-9)
        signs.append(factors.orientation)
    assert signs[0] == -signs[1] != 0.0


def test_a_point_lies_across_the_tangent_and_its_prediction_is_of_third_order():
    """From two points the curvature is known: half the step leaves an eighth of the error; from one point a quarter."""
    balance, errors = duffing(), []
    for distance in (0.1, 0.05):
        steps = Steps(balance, "omega", 0.1, StepControl())
        start = steps.starting_point(first_point(balance, 0.9, 1.0), 1.0)
        first = steps._stepped(start, start.tangent, distance)
        reached = steps._solved(first, distance)
        moved = start.metric.weight * start.tangent.motion * (reached.evaluation.w - start.evaluation.w)
        along = moved.sum() + start.metric.parameter * start.tangent.parameter * (reached.point.omega - start.point.omega)
        assert along == pytest.approx(distance, rel=1e-8)
        errors.append([first.error, steps._stepped(reached, reached.tangent, distance, start).error])
    assert np.log2(np.divide(*errors)) == pytest.approx([2.0, 3.0], abs=0.2)


def test_no_step_turns_by_more_than_the_sharpest_turn_allowed():
    """Steps of at least 1e-3, which a kink does not stop; without that limit one of them turns by 78°."""
    balance = HarmonicBalance(ss.rigs.single_mass(), 3, 64)
    points = list(trace(balance, first_point(balance, 0.5, 1.0), "omega", 2.0, StepControl(cosine=0.9, error=1.0)))
    turns = [before.turn(after) for before, after in pairwise(points) if after.length > 1.001e-3]
    assert len(turns) > 10
    assert min(turns) > 0.9
