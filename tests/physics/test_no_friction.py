"""A slider without load or friction is not there: every curve is the linear one, at every force level."""

import numpy as np
import pytest

import stickslip as ss
from stickslip.model.rigs import single_mass


@pytest.mark.parametrize("level", [1.9, 2.0, 4.0, 16.0])
@pytest.mark.parametrize("band", [ss.hertz(0.08, 0.32), (0.08, 0.2, 0.32)], ids=["band", "listed"])
def test_the_whole_curve_is_there(level, band):
    """A first point a few bits inside the band once lost the curve without a word."""
    dataset = ss.forced_response(single_mass(damping=0.02, kt=1.0, limit=0.0), band, level, harmonics=7).dataset
    solved = dataset["outcome"].values[0] == 1
    omega = 2.0 * np.pi * dataset["frequency"].values[0, solved]
    assert omega[0] == 2.0 * np.pi * 0.08
    assert omega[-1] == pytest.approx(2.0 * np.pi * 0.32, rel=1e-12)
    exact = level / np.abs(1.0 - omega**2 + 0.02j * omega)
    assert dataset["amplitude"].values[0, solved, 0] == pytest.approx(exact, rel=1e-9)
