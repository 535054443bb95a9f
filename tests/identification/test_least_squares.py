"""The core of the fits, on linear residuals whose least squares are known in closed form."""

import numpy as np
import pytest

from stickslip.laboratory.identification.least_squares import FreeParameter, LeastSquares


class Line(LeastSquares):
    """Residuals A x − b of two variables, much larger beyond a wall."""

    A, b = np.array([[2.0, 1.0], [0.5, 3.0], [1.0, -1.0]]), np.array([0.3, -0.2, 0.1])

    def __init__(self, wall=np.inf, high=1.0):
        self.wall, self.high = wall, high

    @property
    def bounds(self):
        return np.array([-1.0, -1.0]), np.array([self.high, 1.0])

    def residuals(self, x):
        return self.A @ x - self.b if x[0] < self.wall else np.full(3, 1e3)


CLOSED = np.linalg.lstsq(Line.A, Line.b)[0]


def test_the_least_squares_and_its_derivatives_are_those_in_closed_form():
    found = Line().solved(np.zeros(2))
    np.testing.assert_allclose(found.x, CLOSED, atol=1e-7)
    np.testing.assert_allclose(found.jacobian, Line.A, atol=1e-6)
    assert found.cost == pytest.approx(np.sum((Line.A @ CLOSED - Line.b) ** 2), rel=1e-9)
    assert found.moved


def test_derivatives_at_the_upper_bound_do_not_leave_it():
    at_bound = Line(wall=0.1 + 1e-12, high=0.1)
    np.testing.assert_allclose(at_bound.jacobian(np.array([0.1, 0.0])), Line.A, atol=1e-6)


def test_held_variables_stay_and_the_others_are_adapted_to_them():
    found = Line().solved(np.array([0.4, 0.0]), held=[0])
    rest = Line.b - 0.4 * Line.A[:, 0]
    assert found.x == pytest.approx([0.4, Line.A[:, 1] @ rest / np.sum(Line.A[:, 1] ** 2)], abs=1e-7)
    assert Line().solved(CLOSED, held=[0, 1]).x.tolist() == CLOSED.tolist()


def test_a_search_that_finds_no_way_down_says_so():
    assert Line().solved(CLOSED).moved  # at its end at once
    assert not Line(wall=-0.5 + 2e-7).solved(np.array([-0.5, -0.06]), held=[1], xtol=1e-4).moved


def test_starts_are_tried_until_they_are_enough():
    starts = [np.array([0.9, 0.0]), np.zeros(2), np.full(2, 0.5)]
    found = Line(wall=0.8).solutions(starts, lambda some: some[-1].cost < 1.0)
    assert len(found) == 2
    assert found[0].cost < 1.0 < found[1].cost


@pytest.mark.parametrize(("bounds", "variable"), [((1.0, 100.0), np.log(10.0)), ((-10.0, 30.0), 0.5)])
def test_a_parameter_is_the_inverse_of_its_variable_and_has_its_slope(bounds, variable):
    free = FreeParameter(10.0, *bounds)
    assert free.variable(10.0) == pytest.approx(variable)
    assert free.value(variable) == pytest.approx(10.0)
    assert free.slope(10.0) == pytest.approx((free.value(variable + 1e-6) - free.value(variable - 1e-6)) / 2e-6)
