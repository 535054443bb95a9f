"""Valanis' law against marching in plain Python, differences, its closed forms, and the laws at its ends."""

from functools import partial

import numpy as np
import pytest
from laws.kernel import answer, cycle, forces, motion_of, random_motion
from laws.marching import harmonics_of, marched_by
from laws.samples import VALANIS_SAMPLES, Element, Sample
from scipy.integrate import quad
from scipy.optimize import brentq

from stickslip.model.contact.dahl import Dahl
from stickslip.model.contact.macroslip import Macroslip
from stickslip.model.contact.point import SliderOffset
from stickslip.model.contact.valanis import Valanis
from stickslip.solve.balance.energy import cycle_work
from stickslip.support.checks import InputError

H, NT = 3, 64
VIRGIN = SliderOffset()


@pytest.fixture(params=VALANIS_SAMPLES, ids=lambda sample: sample.name)
def sample(request):
    return request.param


def stepped(law, traction, du, before, after):
    """One step in plain Python: the travel from one traction to another is ∫ (1 − κ s T/L)/(1 − s T/L) dT/kt at the mean limit L,
    which a root search inverts; clipped."""
    if after <= 0.0:
        return 0.0
    limit, s = 0.5 * (before + after), np.sign(du)
    if s == 0.0 or s * traction >= limit:
        return float(np.clip(traction, -after, after))

    off = limit - s * traction

    def travel(decay):
        """Until off has fallen by exp(−decay)."""
        return (-law.kappa * off * np.expm1(-decay) + (1.0 - law.kappa) * limit * decay) / law.kt

    decay = brentq(lambda decay: travel(decay) - abs(du), 0.0, 1e3, xtol=1e-15, rtol=1e-14)
    return float(np.clip(s * (limit - off * np.exp(-decay)), -after, after))


@pytest.mark.parametrize("traction", [-0.5, 0.0, 0.3])
def test_the_travel_of_a_step_is_the_integral_of_the_law(traction):
    """The plain step above, which referees the kernel, against quadrature of du/dT."""
    law, limit, du = Valanis(2.0, 0.5, 0.8, normal_load=1.4), 0.7, 0.35
    for s in (1.0, -1.0):
        end = stepped(law, traction, s * du, limit, limit)
        ratio = lambda T: (1.0 - law.kappa * s * T / limit) / (1.0 - s * T / limit) / law.kt  # noqa: E731, B023
        assert quad(ratio, traction, end, epsabs=1e-13)[0] == pytest.approx(s * du, rel=1e-10)


@pytest.mark.parametrize("seed", range(3))
def test_forces_equal_marching_in_plain_python(sample, seed):
    w = random_motion(sample, H, np.random.default_rng(seed), size=(0.4, 1.0, 4.0)[seed])
    expected = marched_by(partial(stepped, sample.law), sample.elements[0], motion_of(sample, w, NT), 400, 1e-14)
    rows = slice(0, sample.tangential)
    np.testing.assert_allclose(cycle(sample, VIRGIN, w, NT).force[rows], expected, atol=1e-10)
    np.testing.assert_allclose(forces(sample, VIRGIN, w, NT)[rows], harmonics_of(expected, H), atol=1e-10)


@pytest.mark.parametrize("size", [1e-5, 1e-2, 0.3, 1.0, 4.0])
def test_without_kappa_it_is_dahls_law(size):
    """Marched by Newton's method here, by composition there: forces, derivatives and work; also of a small motion, whose map is
    next to the identity."""
    law = Dahl(1.3, 0.7, 2.0, 0.2, 0.1)
    samples = [
        Sample("plane", each, 2, (Element(1.3, 0.7, 2.0, 0.1, 0.2),)) for each in (law, Valanis(1.3, 0.7, 0.0, 2.0, 0.2, 0.1))
    ]
    w = random_motion(samples[0], H, np.random.default_rng(11), size)
    dahl, valanis = (answer(sample, VIRGIN, w, NT) for sample in samples)
    tolerance = 1e-9 if size > 1e-4 else 1e-7
    for name in ("target", "own", "normal"):
        expected = getattr(dahl, name)
        np.testing.assert_allclose(getattr(valanis, name), expected, atol=tolerance * np.abs(expected).max())
    works = [cycle(sample, VIRGIN, w, NT).slip_work.sum() for sample in samples]
    assert works[1] == pytest.approx(works[0], rel=1e-9, abs=1e-15)


@pytest.mark.parametrize("amplitude", [1e-9, 1e-7, 1e-5])
def test_a_tiny_motion_is_that_of_its_spring(amplitude):
    """The map of a period is the identity to 1e-8 and less: no mean is left of the march from rest, T = kt u."""
    one = Sample("one", Valanis(2.0, 0.5, 0.3, normal_load=1.2), 1, (Element(2.0, 0.5, load=1.2),))
    found = forces(one, VIRGIN, np.array([[0.0, amplitude, 0.0]]), 256)[0] / amplitude
    np.testing.assert_allclose(found, [0.0, 2.0, 0.0], atol=max(1e-3 * (1e-7 / amplitude), 1e-4))


def test_with_kappa_near_one_it_is_a_spring_and_slider():
    """Off by 1 − κ: forces in gross slip, loop energy and virgin curve."""
    element = (Element(2.0, 0.5, load=1.2),)
    jenkins = Sample("slider", Macroslip(2.0, 0.5, normal_load=1.2), 1, element)
    w = random_motion(jenkins, H, np.random.default_rng(2), 2.0)
    expected = forces(jenkins, VIRGIN, w, 256)
    errors = []
    for rest in (1e-2, 1e-3):
        law = Valanis(2.0, 0.5, 1.0 - rest, normal_load=1.2)
        errors.append(np.abs(forces(Sample("near", law, 1, element), VIRGIN, w, 256) - expected).max())
        for amplitude in (0.2, 0.4, 3.0):
            assert law.loop_energy(amplitude) == pytest.approx(jenkins.law.loop_energy(amplitude), abs=10.0 * rest)
            assert law.virgin_curve(amplitude) == pytest.approx(jenkins.law.virgin_curve(amplitude), abs=10.0 * rest)
    assert errors[1] < 0.2 * errors[0] < 0.02


@pytest.mark.parametrize("kappa", [0.0, 0.5, 0.95])
@pytest.mark.parametrize("amplitude", [0.02, 0.3, 1.0, 10.0])
def test_loop_energy_in_closed_form(amplitude, kappa):
    """4 L (A − τ L/kt): as slip work exactly, samples at both reversals; as work of the force beyond third order."""
    law = Valanis(2.0, 0.5, kappa, normal_load=1.2)
    one = Sample("one", law, 1, (Element(2.0, 0.5, load=1.2),))
    w, expected = np.array([[0.0, amplitude, 0.0]]), law.loop_energy(amplitude)
    assert cycle(one, VIRGIN, w, 64).slip_work[0] == pytest.approx(expected, rel=1e-9, abs=1e-14)
    errors = [cycle_work(forces(one, VIRGIN, w, n), w)[0] / expected - 1.0 for n in (64, 1024)]
    assert abs(errors[1]) < 1e-5
    assert abs(errors[1]) < 1e-3 * abs(errors[0]) or abs(errors[1]) < 1e-8


def test_virgin_curve_in_closed_form():
    law = Valanis(2.0, 0.5, 0.7, 3.0, 0.4)
    for z, limit in ((0.0, 0.2), (0.3, 0.65)):
        for u in (-0.7, 0.05, 0.4):
            assert law.virgin_curve(u, z) == pytest.approx(stepped(law, 0.0, u, limit, limit), rel=1e-10)
    assert law.virgin_curve(1.0, -1.0) == 0.0
    assert law.loop_energy(1.0, -1.0) == 0.0


def test_parameters_are_checked():
    for options, said in (
        ({"kt": 0.0, "mu": 0.3, "kappa": 0.5, "normal_load": 1.0}, "kt must be positive"),
        ({"kt": 1.0, "mu": 0.3, "kappa": 1.0, "normal_load": 1.0}, "kappa must be below 1, but is 1.0"),
        ({"kt": 1.0, "mu": 0.3, "kappa": -0.1, "normal_load": 1.0}, "kappa must be at least 0, but is -0.1"),
        ({"kt": 1.0, "mu": 0.3, "kappa": 0.5}, "exactly"),
    ):
        with pytest.raises(InputError, match=said):
            Valanis(**options)
