"""Loops under prescribed motion: energies of closed forms for every kind of law, and a march under a varying normal load."""

import numpy as np
import pytest

import stickslip as ss
from stickslip.support.checks import InputError

PHASE = 2.0 * np.pi * np.arange(2000) / 2000.0
U = 10e-6 * np.sin(PHASE)
ITS_OWN_LOAD = [
    ss.Macroslip(kt=20e6, mu=0.4, normal_load=100.0),
    ss.Iwan(kt=20e6, mu=0.4, normal_load=100.0),
    ss.Dahl(kt=20e6, mu=0.4, normal_load=100.0),
]


@pytest.mark.parametrize("law", ITS_OWN_LOAD, ids=lambda law: type(law).__name__)
def test_energies_are_those_of_the_closed_forms(law):
    loop = ss.hysteresis_loop(law, U)
    assert loop.energy == pytest.approx(law.loop_energy(10e-6), rel=2e-3)
    assert loop.normal == pytest.approx(100.0)
    assert np.max(np.abs(loop.force)) <= 40.0 * (1.0 + 1e-12)


def test_a_law_with_velocity_takes_the_frequency():
    """T = L tanh(v/v0) with v from differences of the samples."""
    law = ss.TanhCoulomb(mu=0.4, v0=1e-3, normal_load=100.0)
    loop = ss.hysteresis_loop(law, U, frequency=50.0)
    assert loop.force == pytest.approx(40.0 * np.tanh(1e-5 * 2.0 * np.pi * 50.0 * np.cos(PHASE) / 1e-3), abs=1e-3)


def test_a_varying_load_is_marched_exactly():
    """Macroslip under N(t) that follows the motion: T_n = clamp(T_(n−1) + kt Δu, ±μN_n), by hand."""
    normal = 100.0 + 60.0 * np.sin(PHASE + 0.7)
    loop = ss.hysteresis_loop(ss.Macroslip(kt=20e6, mu=0.4, kn=50e6, preload=30.0), U, normal)
    assert loop.normal == pytest.approx(normal, rel=1e-12)
    tension, force = 0.0, np.empty(U.size)
    for _ in range(2):
        for n in range(U.size):
            tension = np.clip(tension + 20e6 * (U[n] - U[n - 1]), -0.4 * normal[n], 0.4 * normal[n])
            force[n] = tension
    assert loop.force == pytest.approx(force, abs=1e-9)


def test_an_array_with_gaps_has_the_load_that_is_asked_for():
    law = ss.MicroslipArray.from_totals(20e6, 50e6, 0.4, 4e-6, 5)
    normal = 60.0 * (1.0 + np.sin(PHASE)) + 20.0
    loop = ss.hysteresis_loop(law, U, normal)
    assert loop.normal == pytest.approx(normal, rel=1e-12)
    z = ss.hysteresis_loop(law, U, normal_displacement=np.full(U.size, 3e-6))
    assert z.energy == pytest.approx(law.loop_energy(10e-6, 3e-6), rel=2e-3)


def test_lift_off_is_a_load_of_zero():
    normal = np.maximum(100.0 * np.sin(PHASE), 0.0)
    loop = ss.hysteresis_loop(ss.Macroslip(kt=20e6, mu=0.4, kn=50e6), U, normal)
    assert np.all(loop.force[normal == 0.0] == 0.0)


def test_a_disc_takes_two_directions():
    law = ss.FrictionDisc(kt=20e6, mu=0.4, normal_load=100.0)
    loop = ss.hysteresis_loop(law, np.stack([U, 10e-6 * np.cos(PHASE)]))
    size = np.hypot(*loop.force)
    assert size == pytest.approx(40.0, rel=1e-3)
    radius = np.sqrt(1.0 - (40.0 / (20e6 * 10e-6)) ** 2)
    assert loop.energy == pytest.approx(2.0 * np.pi * 10e-6 * 40.0 * radius, rel=2e-3)  # T leads the slip circle by asin(L/ktA)


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        ((3, U), "law must be a Law"),
        ((ITS_OWN_LOAD[0], U[:4]), "displacement must be finite and of shape"),
        ((ITS_OWN_LOAD[0], U * np.nan), "displacement must be finite"),
        ((ITS_OWN_LOAD[0], U, 5.0), "normal_load must stay away"),
        ((ss.Macroslip(kt=1.0, mu=0.1, kn=1.0), U), "one without the other"),
        ((ss.Macroslip(kt=1.0, mu=0.1, kn=1.0), U, -1.0), "must not be negative"),
        ((ss.Macroslip(kt=1.0, mu=0.1, kn=1.0), U, np.ones(7)), "must be finite, a number or of shape"),
    ],
)
def test_wrong_input_is_refused(arguments, words):
    with pytest.raises(InputError, match=words):
        ss.hysteresis_loop(*arguments)
