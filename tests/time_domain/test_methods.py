"""Settings of the methods, and the spectral radius that they promise for motions far above the step rate."""

import numpy as np
import pytest

from stickslip.solve.time.period import GeneralisedAlpha, Newmark
from stickslip.support.checks import InputError


def amplification(method, frequency_step: float) -> np.ndarray:
    """One step of an undamped oscillator in (q, h v, h² a), ωh = frequency_step."""
    mass, force, beta, gamma = method.coefficients
    square = frequency_step**2
    implicit = np.array([[1.0, 0.0, -beta], [0.0, 1.0, -gamma], [square * (1 - force), 0.0, 1 - mass]])
    explicit = np.array([[1.0, 1.0, 0.5 - beta], [0.0, 1.0, 1 - gamma], [-square * force, 0.0, -mass]])
    return np.linalg.solve(implicit, explicit)


@pytest.mark.parametrize("radius", [0.0, 0.3, 0.8, 1.0])
def test_unresolved_motions_shrink_by_the_spectral_radius(radius):
    eigenvalues = np.linalg.eigvals(amplification(GeneralisedAlpha(radius), 1e6))
    assert np.max(np.abs(eigenvalues)) == pytest.approx(radius, abs=2e-3)


@pytest.mark.parametrize("method", [GeneralisedAlpha(0.8), GeneralisedAlpha(0.0), Newmark(), Newmark(0.36, 0.7)])
@pytest.mark.parametrize("frequency_step", [0.01, 0.5, 3.0, 100.0])
def test_every_step_is_stable(method, frequency_step):
    assert np.max(np.abs(np.linalg.eigvals(amplification(method, frequency_step)))) <= 1.0 + 1e-9


def test_a_spectral_radius_of_one_is_the_midpoint_rule_and_keeps_energy():
    assert GeneralisedAlpha(1.0).coefficients == (0.5, 0.5, 0.25, 0.5)
    assert np.min(np.abs(np.linalg.eigvals(amplification(GeneralisedAlpha(1.0), 0.5)))[:2]) == pytest.approx(1.0)


@pytest.mark.parametrize("make", [lambda: GeneralisedAlpha(1.2), lambda: Newmark(0.2, 0.5), lambda: Newmark(0.5, 0.4)])
def test_unstable_settings_are_refused(make):
    with pytest.raises(InputError, match="must"):
        make()
