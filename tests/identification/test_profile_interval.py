"""Intervals by the profile of the sum of squares, of a linear fit: there they are those of the normal distribution."""

import numpy as np
import pytest
from scipy import stats

from stickslip.laboratory.identification.least_squares import LeastSquares
from stickslip.laboratory.identification.response.intervals import LIMIT, profile_end


class LinearFit(LeastSquares):
    """Residuals A x − b, in standard errors, of parameters that all tests share."""

    def __init__(self, A, b, bounds=(-50.0, 50.0)):
        self.A, self.b = A, b
        self.shared, self.ends = range(A.shape[1]), bounds

    @property
    def bounds(self):
        return np.full(self.A.shape[1], self.ends[0]), np.full(self.A.shape[1], self.ends[1])

    def residuals(self, x):
        return self.A @ x - self.b


A = np.random.default_rng(0).standard_normal((12, 3))
TRUTH = np.array([0.5, -2.0, 3.0])
ERRORS = np.sqrt(np.diag(np.linalg.inv(A.T @ A)))


def ends(fit):
    """Both ends of the interval of each parameter."""
    limit = fit.cost(TRUTH) + LIMIT
    return np.array([[profile_end(fit, TRUTH, k, side, limit)[0] for k in fit.shared] for side in (-1.0, 1.0)])


def test_a_95_percent_interval_is_the_normal_one():
    """x ± 1.960 σ with σ of the parameter while the others adapt: χ² of one degree of freedom."""
    half = stats.norm.ppf(0.975) * ERRORS
    np.testing.assert_allclose(ends(LinearFit(A, A @ TRUTH)), [TRUTH - half, TRUTH + half], rtol=2e-3)


def test_an_interval_ends_at_the_bounds():
    found = ends(LinearFit(A, A @ TRUTH, (-2.0, 3.0)))
    assert found[0, 1] == pytest.approx(-2.0)
    assert found[1, 2] == pytest.approx(3.0)
