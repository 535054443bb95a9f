"""Damper cycles of laws that are no table of sliders: Dahl's in every way there is, tanh-regularised friction where there is a
velocity."""

from dataclasses import replace

import numpy as np
import pytest
from analyses.damper_alone.harmonic_cycle import harmonic_cycle

from stickslip.analyses.damper_alone.cycle import damper_cycle
from stickslip.model.contact.dahl import Dahl
from stickslip.model.contact.lugre import LuGre
from stickslip.model.contact.tanh_coulomb import TanhCoulomb
from stickslip.model.contact.valanis import Valanis
from stickslip.model.dampers.between_platforms import in_phase, out_of_phase
from stickslip.model.dampers.laboratory import laboratory_damper
from stickslip.solve.platforms.relaxation import elements_of
from stickslip.solve.time.period import GeneralisedAlpha
from stickslip.support.checks import InputError

SLIDING = laboratory_damper(45.0, 50.0, (0.40, 0.22, 0.32))
FREQUENCY = 50.0


def rig_of(make):
    """The laboratory damper with another law of the same limits on every line of contact."""
    return replace(SLIDING, laws=tuple(make(law) for law in SLIDING.laws))


def dahl_rig():
    return rig_of(lambda law: Dahl(law.kt, law.mu, law.kn))


def valanis_rig(kappa=0.8):
    return rig_of(lambda law: Valanis(law.kt, law.mu, kappa, law.kn))


def tanh_rig():
    return rig_of(lambda law: TanhCoulomb(law.mu, 5e-4, law.kn))


def lugre_rig():
    """Falling from 1.1 μ, with bristle damping and viscosity."""
    return rig_of(lambda law: LuGre(law.kt, law.mu, 1.1 * law.mu, 1e-2, 1.0, 3.0, law.kn))


def stepped(kt, traction, du, before, after):
    """A step of Dahl's law in plain Python."""
    limit, s = 0.5 * (before + after), np.sign(du)
    if after <= 0.0:
        return 0.0
    return float(np.clip(s * limit + (traction - s * limit) * np.exp(-kt * abs(du) / limit), -after, after))


@pytest.mark.parametrize("motion", [out_of_phase(10e-6), in_phase(10e-6)], ids=["out-of-phase", "in-phase"])
@pytest.mark.parametrize("options", [{}, {"method": GeneralisedAlpha(), "frequency": FREQUENCY}], ids=["quasi-static", "in time"])
def test_a_cycle_takes_the_steps_of_the_law(motion, options):
    """Every friction force is that of a step from the sample before, motion and limit included; |T| ≤ μN, energies balance."""
    rig = dahl_rig()
    data = damper_cycle(rig, motion, steps=400, tolerance=1e-8, **options).dataset
    assert data.attrs["outcome"] == "steady", data.attrs["message"]
    T, u, L = (data[name].values for name in ("friction_force", "tangential_motion", "slip_limit"))
    assert np.all(np.abs(T) <= L + 1e-9)
    for c, law in enumerate(rig.laws):
        expected = [stepped(law.kt, T[n - 1, c], u[n, c] - u[n - 1, c], L[n - 1, c], L[n, c]) for n in range(400)]
        np.testing.assert_allclose(T[:, c], expected, atol=1e-5)
    assert data.loop_energy > 0.0
    assert data.energy_error < 1e-3


def test_a_cycle_of_valanis_law_lies_between_those_of_its_ends():
    """Without κ the cycle of Dahl's law, step by step; with κ near one that of sliders; the loop energy lies between theirs, and
    energies balance."""
    motion = out_of_phase(10e-6)
    dahl, same, between, near, sliders = (
        damper_cycle(rig, motion, steps=400, tolerance=1e-8).dataset
        for rig in (dahl_rig(), valanis_rig(0.0), valanis_rig(0.8), valanis_rig(0.999), SLIDING)
    )
    np.testing.assert_allclose(same.friction_force, dahl.friction_force, atol=1e-7)
    assert float(near.loop_energy) == pytest.approx(float(sliders.loop_energy), rel=5e-3)
    for data in (same, between, near):
        assert data.attrs["outcome"] == "steady", data.attrs["message"]
        assert np.all(np.abs(data.friction_force) <= data.slip_limit + 1e-9)
        assert data.energy_error < 1e-3
    low, middle, high = sorted(float(data.loop_energy) for data in (dahl, between, near))
    assert middle == float(between.loop_energy)
    assert high - low > 1e-3 * high


@pytest.mark.nightly
def test_quasi_static_cycle_against_harmonic_balance():
    """At 5 Hz inertia is nothing: the loop energy of both methods."""
    motion = in_phase(10e-6)
    marched = damper_cycle(dahl_rig(), motion, steps=2000).energy
    assert harmonic_cycle(dahl_rig(), motion, 5.0, harmonics=31, samples=1024).energy == pytest.approx(marched, rel=2e-3)


@pytest.mark.slow
def test_the_lugre_law_in_time_against_harmonic_balance():
    """At 50 Hz, contacts closed all the time: both count the work of bristles and viscous parts."""
    motion, options = out_of_phase(10e-6), {"method": GeneralisedAlpha(), "frequency": FREQUENCY}
    data = damper_cycle(lugre_rig(), motion, steps=800, tolerance=1e-6, **options).dataset
    assert data.attrs["outcome"] == "steady", data.attrs["message"]
    assert data.energy_error < 1e-3
    balanced = harmonic_cycle(lugre_rig(), motion, FREQUENCY, harmonics=15, samples=512)
    assert float(data.loop_energy) == pytest.approx(balanced.energy, rel=1e-3)


@pytest.mark.slow
def test_friction_by_the_velocity_in_time_against_harmonic_balance():
    """At 50 Hz, v0 a sixth of the platform's largest velocity."""
    motion, options = in_phase(10e-6), {"method": GeneralisedAlpha(), "frequency": FREQUENCY}
    data = damper_cycle(tanh_rig(), motion, steps=2000, tolerance=1e-7, **options).dataset
    assert data.attrs["outcome"] == "steady", data.attrs["message"]
    assert np.all(np.abs(data.friction_force) <= data.slip_limit + 1e-9)
    assert data.energy_error < 1e-3
    balanced = harmonic_cycle(tanh_rig(), motion, FREQUENCY, harmonics=31, samples=2048)
    assert float(data.loop_energy) == pytest.approx(balanced.energy, rel=2e-3)


def test_without_a_velocity_it_is_refused():
    with pytest.raises(InputError, match="must be given with a method in time, since the law of L1 depends on the velocity"):
        damper_cycle(tanh_rig(), in_phase(10e-6), steps=100)
    with pytest.raises(InputError, match="must be given with a method in time, since the law of L1 depends on the velocity"):
        damper_cycle(lugre_rig(), in_phase(10e-6), steps=100)


def test_relaxation_takes_sliders_alone():
    with pytest.raises(InputError, match="must pair each slider with a normal spring, but is 'Dahl'"):
        elements_of(dahl_rig())
