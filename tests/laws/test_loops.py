"""Closed forms that the laws give of themselves against marching at constant normal load."""

import numpy as np
import pytest
from each import each
from laws.samples import SAMPLES

RUBBING = [sample for sample in SAMPLES if sample.tangential]
LOADS = (-1.0, 0.1, 0.45, 2.0)


def loop(sample, path: np.ndarray, z: float) -> np.ndarray:
    """Tractions along a path from the virgin state, every element of its own."""
    total = np.zeros(path.size)
    for element in sample.elements:
        limit, traction = float(element.limit(np.array(z))), 0.0
        for n, step in enumerate(np.diff(path, prepend=0.0).tolist()):
            traction = min(max(traction + element.kt * step, -limit), limit)
            total[n] += traction
    return total


@each("sample", RUBBING, ids=lambda sample: sample.name)
@each("z", LOADS)
def test_virgin_curve(sample, z):
    path = np.linspace(0.0, 3.0, 50)
    for sign in (-1.0, 1.0):
        curve = [sample.law.virgin_curve(sign * u, z) for u in path]
        np.testing.assert_allclose(curve, loop(sample, sign * path, z), atol=1e-13)


@each("sample", RUBBING, ids=lambda sample: sample.name)
@each("z", LOADS)
@each("amplitude", [0.05, 0.4, 1.0, 5.0])
def test_loop_energy_and_masing(sample, z, amplitude):
    """Σ 4 L (A − L/kt): area of the steady loop; its branches are the virgin curve doubled (Masing)."""
    down = np.linspace(amplitude, -amplitude, 2001)
    path = np.concatenate([[amplitude], down, down[::-1]])
    traction = loop(sample, path, z)
    area = float(np.sum(0.5 * (traction[2002:] + traction[2001:-1]) * np.diff(path)[2001:]))
    area += float(np.sum(0.5 * (traction[1:2002] + traction[:2001]) * np.diff(path)[:2001]))
    assert area == pytest.approx(sample.law.loop_energy(amplitude, z), rel=1e-5, abs=1e-6)
    masing = sample.law.virgin_curve(amplitude, z) - 2.0 * np.array(
        [sample.law.virgin_curve(0.5 * (amplitude - u), z) for u in down[::20]]
    )
    np.testing.assert_allclose(traction[1:2002:20], masing, atol=1e-12)
