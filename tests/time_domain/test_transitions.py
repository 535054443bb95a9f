"""When a Jenkins element goes from stick to slip and back at constant load.

The criteria are those of table 1 of "Effect of Variation in Contact Friction on the Performance of the Under-Platform Dampers".

x = A sin θ, limit μN, spring kt, steady motion: positive slip ends where ẋ = 0 with ẍ < 0; negative slip begins with ẋ < 0 where
the spring has been relaxed by 2 μN, x = A − 2 μN/kt; it ends where ẋ = 0 with ẍ > 0; positive slip begins at x = −A + 2 μN/kt.
"""

import numpy as np
import pytest

from stickslip.model.contact.macroslip import Macroslip
from stickslip.model.contact.point import Contact, between, contact_table
from stickslip.solve.balance.energy import contact_cycle
from stickslip.solve.balance.fourier import fourier

SAMPLES = 4096


@pytest.mark.parametrize(("kt", "load", "mu", "amplitude"), [(2.0, 6.0, 0.5, 3.0), (5.0, 1.0, 0.3, 0.7), (1.0, 2.0, 0.4, 0.85)])
def test_transitions_come_at_their_instants(kt, load, mu, amplitude):
    contact = Contact("c", Macroslip(kt, mu, normal_load=load), (between("1.x", "ground"),))
    cycle = contact_cycle(contact_table([contact]), fourier(1, SAMPLES), np.array([[0.0, 0.0, amplitude]]), 1.0)
    phase, force = 2.0 * np.pi * np.arange(SAMPLES) / SAMPLES, cycle.force[0]
    slipping = np.abs(force) >= mu * load * (1.0 - 1e-12)
    changes = phase[np.flatnonzero(slipping != np.roll(slipping, 1))]
    relaxed = np.arcsin(1.0 - 2.0 * mu * load / (kt * amplitude))
    expected = np.sort(np.mod([np.pi / 2, np.pi - relaxed, 3 * np.pi / 2, 2 * np.pi - relaxed], 2 * np.pi))
    np.testing.assert_allclose(np.sort(changes), expected, atol=2.01 * 2.0 * np.pi / SAMPLES)
    moving = np.cos(phase)
    assert np.all(force[slipping & (moving > 1e-3)] > 0.0)
    assert np.all(force[slipping & (moving < -1e-3)] < 0.0)
