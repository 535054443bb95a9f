"""Rigid Coulomb friction as the limit of stiff sliders: Den Hartog (1931), motion without stops.

m x'' + k x + Fc sgn x' = P cos ωt, β = ω/ω_n, r = Fc/P: max|x| k/P = √(V² − r²U²), V = 1/(1 − β²),
U = sin(π/β)/(β(1 + cos(π/β))). A slider of stiffness kd yields to the force before it slips, which moves the amplitude by a
multiple of kd^(−1/2): the limit follows from several kd by extrapolation.
"""

import numpy as np
import pytest

from stickslip.analyses.time_response import time_response
from stickslip.model.rigs import single_mass

STIFFNESSES = np.array([1e2, 1e3, 1e4])


def exact(beta, ratio):
    V = 1.0 / (1.0 - beta**2)
    U = np.sin(np.pi / beta) / (beta * (1.0 + np.cos(np.pi / beta)))
    return np.sqrt(V**2 - ratio**2 * U**2)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("beta", "ratio", "amplitude"),
    [
        pytest.param(0.6, 0.2, 1.5506028547, marks=pytest.mark.nightly),
        (1.3, 0.5, 1.0353280077),
        pytest.param(2.0, 0.3, 0.2976761850, marks=pytest.mark.nightly),
    ],
)
def test_stiff_sliders_approach_rigid_friction(beta, ratio, amplitude):
    """Amplitudes: the closed form, evaluated by an independent script of this project too."""
    assert exact(beta, ratio) == pytest.approx(amplitude, rel=1e-9)
    found = []
    for stiffness in STIFFNESSES:
        problem = single_mass(damping=0.0, kt=stiffness, limit=ratio)
        response = time_response(problem, beta / (2.0 * np.pi), steps_per_period=2500, tolerance=1e-5)
        assert response.periodic, response.sentence
        found.append(float(response.dataset.max_abs[0]))
    errors = np.abs(np.array(found) / amplitude - 1.0)
    np.testing.assert_allclose(np.log10(errors[:-1] / errors[1:]), 0.5, atol=0.03)
    limit = np.polynomial.Polynomial.fit(STIFFNESSES**-0.5, found, 2)(0.0)
    assert limit == pytest.approx(amplitude, rel=4e-4)
