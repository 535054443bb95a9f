"""Intervals by the profile of the sum of squares, of a linear fit: there they are those of the normal distribution."""

import numpy as np
import pytest
from scipy import stats

from stickslip.laboratory.identification.least_squares import LeastSquares
from stickslip.laboratory.identification.response.intervals import profile_intervals


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

    def widened(self, x):
        return False


A = np.random.default_rng(0).standard_normal((12, 3))
TRUTH = np.array([0.5, -2.0, 3.0])
ERRORS = np.sqrt(np.diag(np.linalg.inv(A.T @ A)))


def test_a_95_percent_interval_is_the_normal_one():
    """x ± 1.960 σ with σ of the parameter while the others adapt: χ² of one degree of freedom."""
    found = profile_intervals(LinearFit(A, A @ TRUTH), TRUTH)
    half = stats.norm.ppf(0.975) * ERRORS
    np.testing.assert_allclose(found.ends, [TRUTH - half, TRUTH + half], rtol=2e-3)


def test_residuals_larger_than_their_standard_errors_widen_it():
    """By the square root of the sum of squares over 12 − 3 degrees of freedom."""
    noise = 5.0 * np.random.default_rng(1).standard_normal(12)
    fit = LinearFit(A, A @ TRUTH + noise)
    best = np.linalg.lstsq(A, fit.b)[0]
    half = stats.norm.ppf(0.975) * ERRORS * np.sqrt(fit.cost(best) / 9.0)
    np.testing.assert_allclose(profile_intervals(fit, best).ends, [best - half, best + half], rtol=2e-3)


def test_an_interval_ends_at_the_bounds():
    ends = profile_intervals(LinearFit(A, A @ TRUTH, (-2.0, 3.0)), TRUTH).ends
    assert ends[0, 1] == pytest.approx(-2.0)
    assert ends[1, 2] == pytest.approx(3.0)
