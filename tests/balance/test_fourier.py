"""Fourier tables: signs of the convention, exact round trips, and the running sums that build Jacobians."""

import numpy as np
import pytest

from stickslip.solve.balance.fourier import (
    add_product_sums,
    add_run,
    complex_harmonics,
    fourier,
    largest_absolute,
    real_harmonics,
)
from stickslip.support.checks import InputError


def test_convention():
    """x(t) = Re Σ X_h exp(i h ω t): cosine F is [F, 0], sine F is [0, −F] in real and imaginary part."""
    E = fourier(2, 64).E
    time = 2.0 * np.pi * np.arange(64) / 64
    X = np.array([0.5, 1.0 - 2.0j, 0.3j])
    expected = sum((X[h] * np.exp(1j * h * time)).real for h in range(3))
    np.testing.assert_allclose(E @ real_harmonics(X), expected, atol=1e-14)
    np.testing.assert_allclose(E @ [0, 0, 1, 0, 0], np.sin(time), atol=1e-15)
    np.testing.assert_allclose(complex_harmonics(real_harmonics(X)), X)


@pytest.mark.parametrize(("harmonics", "samples"), [(1, 6), (5, 22), (7, 256), (7, 255), (21, 1000)])
def test_analysis_inverts_synthesis(harmonics, samples):
    tables = fourier(harmonics, samples)
    np.testing.assert_allclose(tables.P @ tables.E, np.eye(2 * harmonics + 1), atol=1e-13)


@pytest.mark.parametrize(("harmonics", "samples"), [(1, 8), (4, 40), (6, 101)])
def test_running_sums_are_the_sums_over_samples(harmonics, samples):
    """Σ_n g_n P_n E_nᵀ for piecewise constant g."""
    tables, rng = fourier(harmonics, samples), np.random.default_rng(1)
    edges = np.sort(rng.integers(0, samples + 1, 4))
    weights = rng.standard_normal(3)
    sums, matrix = np.zeros((2, 2 * harmonics + 1)), np.zeros((2 * harmonics + 1,) * 2)
    g = np.zeros(samples)
    for weight, first, last in zip(weights, edges[:-1], edges[1:], strict=True):
        add_run(sums, weight, int(first), int(last), tables.cosines, tables.sines)
        g[first:last] += weight
    add_product_sums(matrix, sums, samples)
    np.testing.assert_allclose(matrix, (tables.P * g) @ tables.E, atol=1e-13)


def test_too_few_samples_are_refused():
    with pytest.raises(InputError, match="at least 4 H \\+ 2 = 22"):
        fourier(5, 21)


@pytest.mark.parametrize("seed", range(20))
def test_largest_value_is_the_true_one_in_time(seed):
    """Against 200 000 samples, whose spacing allows an error of 1e-8."""
    motion = np.random.default_rng(seed).standard_normal(15)
    time = 2.0 * np.pi * np.arange(200_000) / 200_000
    order = np.arange(1, 8)[:, None]
    dense = motion[0] + motion[1::2] @ np.cos(order * time) + motion[2::2] @ np.sin(order * time)
    found, gradient = largest_absolute(motion)
    assert found >= np.abs(dense).max() - 1e-12
    assert found == pytest.approx(np.abs(dense).max(), rel=1e-7)
    step = 1e-6 * np.eye(15)
    slopes = [(largest_absolute(motion + d)[0] - largest_absolute(motion - d)[0]) / 2e-6 for d in step]
    np.testing.assert_allclose(gradient, slopes, atol=1e-5)
