"""The error of time integration falls with the square of the step: on linear motions, and observed with friction and lift-off."""

import numpy as np
import pytest
from time_domain.systems import rubbing_mass, three_masses

from stickslip.analyses.time_response import time_response
from stickslip.solve.time.period import GeneralisedAlpha, Newmark

OMEGA = 0.9


def harmonics(problem, steps, method, tolerance=1e-9, start=None):
    """X_0 .. X_3 of the outputs, and the state at the end."""
    settings = {"steps_per_period": steps, "method": method, "tolerance": tolerance, "start": start}
    response = time_response(problem, OMEGA / (2.0 * np.pi), harmonics=3, **settings)
    assert response.periodic
    parts = response.dataset["response"].to_numpy()
    return parts[..., 0] + 1j * parts[..., 1], response.cycle.end


def stuck_response(problem, harmonic):
    load = problem.load(3)
    force = load[:, 0] if harmonic == 0 else load[:, 2 * harmonic - 1] - 1j * load[:, 2 * harmonic]
    s = 1j * harmonic * OMEGA
    return np.linalg.solve(problem.stuck_stiffness + s * problem.C + s * s * problem.structure.M, force)


def orders(errors):
    return np.log2(np.array(errors[:-1]) / np.array(errors[1:]))


@pytest.mark.parametrize(
    ("method", "order"),
    [(GeneralisedAlpha(0.8), 2.0), (GeneralisedAlpha(0.0), 2.0), (Newmark(), 2.0), (Newmark(0.36, 0.7), 1.0)],
    ids=repr,
)
def test_order_on_a_stuck_structure_with_a_massless_node(method, order):
    problem = three_masses(limit=100.0)
    exact = np.stack([stuck_response(problem, h) for h in (0, 1, 3)], axis=1)
    errors = [np.max(np.abs(harmonics(problem, steps, method)[0][:, [0, 1, 3]] - exact)) for steps in (200, 400, 800)]
    np.testing.assert_allclose(orders(errors), order, atol=0.1)
    assert errors[-1] < 1e-2


@pytest.mark.slow
@pytest.mark.parametrize(
    "problem", [three_masses(limit=0.4), pytest.param(rubbing_mass(), marks=pytest.mark.nightly)], ids=["friction", "lift-off"]
)
def test_order_observed_with_contacts(problem):
    """Events fall between the steps, so single orders scatter about 2; over a factor of 16 the mean order is 2."""
    found, start = [], None
    for steps in (250, 4000, 32000):
        values, start = harmonics(problem, steps, GeneralisedAlpha(0.8), 1e-7, start)
        found.append(values)
    errors = [np.max(np.abs(values - found[-1])) for values in found[:-1]]
    assert np.log2(errors[0] / errors[1]) / 4.0 == pytest.approx(2.0, abs=0.25)
