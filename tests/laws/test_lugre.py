"""The LuGre law against its ordinary differential equation by SciPy, differences, and the laws that it holds as limits."""

import numpy as np
import pytest
from laws.kernel import OMEGA, cycle, forces, motion_of, random_motion
from laws.marching import harmonics_of
from laws.samples import LUGRE_SAMPLES, Element, Sample
from scipy.integrate import solve_ivp

from stickslip.model.contact.dahl import Dahl
from stickslip.model.contact.lugre import LuGre
from stickslip.model.contact.point import SliderOffset
from stickslip.solve.balance.energy import cycle_work
from stickslip.support.checks import InputError

H, NT = 3, 64
VIRGIN = SliderOffset()


@pytest.fixture(params=LUGRE_SAMPLES, ids=lambda sample: sample.name)
def sample(request):
    return request.param


def integrated(law, w, load, samples):
    """T at the samples of the steady period under u = Σ w_h (1, cos, sin) and N = load (2H+1,) of the same storage, by SciPy."""
    order = np.arange(1, (w.size + 1) // 2)

    def signal(storage, t):
        return storage[0] + storage[1::2] @ np.cos(order * OMEGA * t) + storage[2::2] @ np.sin(order * OMEGA * t)

    def velocity(t):
        return OMEGA * (order * w[2::2]) @ np.cos(order * OMEGA * t) - OMEGA * (order * w[1::2]) @ np.sin(order * OMEGA * t)

    def rate(t, z):
        v = velocity(t)
        g = law.mu + (law.mu_static - law.mu) * np.exp(-((v / law.stribeck) ** 2))
        return v - law.kt * abs(v) * z / (signal(load, t) * g)

    period = 2.0 * np.pi / OMEGA
    times = period * (6.0 + np.arange(samples) / samples)
    z = solve_ivp(rate, (0.0, 7.0 * period), [0.0], t_eval=times, max_step=period / 400, rtol=1e-9, atol=1e-12).y[0]
    parts = [(signal(load, t), velocity(t), rate(t, one)) for t, one in zip(times, z, strict=True)]
    return np.array([law.kt * one + N * (law.damping * dz + law.viscosity * v) for one, (N, v, dz) in zip(z, parts, strict=True)])


@pytest.mark.parametrize("varies", [0.0, 0.5], ids=["constant load", "varying load"])
def test_forces_equal_those_of_the_differential_equation(varies):
    """Under two harmonics of motion: of second order in the samples."""
    load = np.array([1.2, 0.0, varies, 0.0, 0.0])
    options = {"kn": 1.0, "preload": 0.0} if varies else {"normal_load": 1.2}
    law = LuGre(2.0, 0.5, 0.8, 0.5, 0.15, 0.1, **options)
    sample = Sample("one", law, 1, (Element(2.0, 0.5, 1.0) if varies else Element(2.0, 0.5, load=1.2),))
    w = np.array([[0.0, 1.3, 0.4, 0.0, 0.5], load][: 2 if varies else 1])
    errors = []
    for samples in (128, 512):
        expected = integrated(law, w[0], load, samples)
        errors.append(np.abs(cycle(sample, VIRGIN, w, samples).force[0] - expected).max())
    assert errors[1] < 2e-4
    assert np.log2(errors[0] / errors[1]) / 2.0 == pytest.approx(2.0, abs=0.4)


def test_with_one_coefficient_and_no_damping_it_is_dahls_law():
    """Under a constant load, at every speed."""
    element = (Element(2.0, 0.5, load=1.2),)
    w = random_motion(Sample("dahl", Dahl(2.0, 0.5, normal_load=1.2), 1, element), H, np.random.default_rng(4))
    dahl, lugre = (
        Sample("one", law, 1, element) for law in (Dahl(2.0, 0.5, normal_load=1.2), LuGre(2.0, 0.5, 0.5, 0.1, normal_load=1.2))
    )
    for omega in (0.1, 10.0):
        expected = forces(dahl, VIRGIN, w, NT)
        np.testing.assert_allclose(forces(lugre, VIRGIN, w, NT, omega), expected, atol=1e-10)


def test_a_stuck_motion_is_a_spring_with_a_dashpot():
    """So small that nothing slips: T = kt u + N (σ1 + σ2) u̇ to the first order, z being u."""
    law, N, A = LuGre(2.0, 0.5, 0.8, 0.5, 0.4, 0.2, normal_load=1.2), 1.2, 1e-6
    one = Sample("one", law, 1, (Element(2.0, 0.5, load=N),))
    found = forces(one, VIRGIN, np.array([[0.0, A, 0.0]]), 256)[0]
    assert found[1] == pytest.approx(2.0 * A, rel=1e-5)
    assert found[2] == pytest.approx(-N * 0.6 * OMEGA * A, rel=1e-4)


def test_work_of_the_states_and_the_viscous_parts_is_that_of_the_force(sample):
    """The friction work that the steps count against the work of the harmonics, of second order."""
    errors = []
    w = random_motion(sample, 2, np.random.default_rng(8))
    for samples in (256, 1024):
        work = cycle_work(forces(sample, VIRGIN, w, samples), w)[: sample.tangential].sum()
        errors.append(abs(cycle(sample, VIRGIN, w, samples).slip_work.sum() / work - 1.0))
    assert errors[1] < 1e-3
    assert errors[1] < 0.3 * errors[0]


def test_harmonics_of_the_samples_are_those_of_the_forces(sample):
    w = random_motion(sample, H, np.random.default_rng(6))
    force = cycle(sample, VIRGIN, w, NT).force[: sample.tangential]
    np.testing.assert_allclose(forces(sample, VIRGIN, w, NT)[: sample.tangential], harmonics_of(force, H), atol=1e-12)
    assert motion_of(sample, w, NT).tangential.shape == force.shape


def test_parameters_are_checked():
    good = {"kt": 1.0, "mu": 0.3, "mu_static": 0.4, "stribeck": 0.1, "normal_load": 1.0}
    for wrong, said in (
        ({"mu": 0.0}, "mu must be positive"),
        ({"mu_static": 0.2}, "mu_static must be at least mu = 0.3, but is 0.2"),
        ({"stribeck": 0.0}, "stribeck must be positive"),
        ({"damping": -1.0}, "damping must be at least 0"),
    ):
        with pytest.raises(InputError, match=said):
            LuGre(**{**good, **wrong})
    for ask in ("loop_energy", "virgin_curve"):
        with pytest.raises(InputError, match="lugre contact must be asked for at a"):
            getattr(LuGre(**good), ask)(1.0)
