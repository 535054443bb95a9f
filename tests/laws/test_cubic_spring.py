"""The cubic spring: exact harmonics and derivatives, and Duffing's oscillator in closed form, in harmonics and in time."""

import numpy as np
import pytest
from laws.kernel import answer, cycle, forces, random_motion
from laws.marching import harmonics_of, sampled
from laws.samples import SPRING_SAMPLES

import stickslip as ss
from stickslip.model.contact.protocol import SLIPPING
from stickslip.solve.balance.energy import cycle_work

VIRGIN = ss.SliderOffset()


@pytest.mark.parametrize("spring", SPRING_SAMPLES, ids=lambda s: s.name)
@pytest.mark.parametrize(("H", "samples"), [(1, 6), (3, 14), (5, 22), (5, 96)])
def test_forces_are_the_harmonics_of_the_cube(spring, H, samples):
    """At 4H + 2 samples nothing aliases: the harmonics equal those of a thousand samples."""
    w = random_motion(spring, H, np.random.default_rng(H), size=2.0)
    expected = harmonics_of(spring.law.k3 * sampled(w, 1000) ** 3, H)
    found = answer(spring, VIRGIN, w, samples)
    np.testing.assert_allclose(found.target, expected, atol=1e-12 * np.abs(expected).max())
    assert np.all(found.unknown == SLIPPING)
    np.testing.assert_allclose(cycle(spring, VIRGIN, w, samples).force, spring.law.k3 * sampled(w, samples) ** 3)


@pytest.mark.parametrize("spring", SPRING_SAMPLES, ids=lambda s: s.name)
def test_derivatives_equal_differences(spring):
    w, step = random_motion(spring, 3, np.random.default_rng(2), size=1.5), 1e-6
    own = answer(spring, VIRGIN, w, 64).own
    for row in range(w.shape[0]):
        for j in range(w.shape[1]):
            change = np.zeros_like(w)
            change[row, j] = step
            slope = (forces(spring, VIRGIN, w + change, 64) - forces(spring, VIRGIN, w - change, 64)) / (2.0 * step)
            np.testing.assert_allclose(own[row, :, j], slope[row], atol=1e-8 * np.abs(own).max())
            assert not np.delete(slope, row, axis=0).any()


@pytest.mark.parametrize("spring", SPRING_SAMPLES, ids=lambda s: s.name)
def test_loops_hold_no_energy(spring):
    w = random_motion(spring, 4, np.random.default_rng(3), size=2.0)
    works = cycle_work(forces(spring, VIRGIN, w, 18), w)
    np.testing.assert_allclose(works, 0.0, atol=1e-12 * np.abs(w).max() ** 4)


def duffing(k3=0.5, damping=0.04, **options):
    structure = ss.Structure(np.eye(1), np.eye(1), ("1.x",))
    spring = ss.Contact("spring", ss.CubicSpring(k3), (ss.between("1.x", "ground"),))
    dashpot = ss.Dashpot(ss.between("1.x", "ground"), damping)
    return ss.Problem(structure, (spring,), options.get("forces", (ss.Force("1.x", 0.1),)), ("1.x",), dashpots=(dashpot,))


def test_duffing_with_one_harmonic():
    """((1 + 3/4 k3 a² − ω²)² + (c ω)²) a² = F² along the whole curve, through both folds."""
    response = ss.forced_response(duffing(), ss.radians_per_second(0.6, 2.0), harmonics=1)
    data = response.dataset.isel(case=0, output=0)
    kept = data.outcome.values == 1
    a, omega = data.amplitude.values[kept], 2.0 * np.pi * data.frequency.values[kept]
    left = np.sqrt((1.0 + 0.75 * 0.5 * a**2 - omega**2) ** 2 + (0.04 * omega) ** 2) * a
    np.testing.assert_allclose(left, 0.1, rtol=1e-9)
    assert np.count_nonzero(np.diff(np.sign(np.diff(omega)))) == 2, "the curve of these numbers folds twice"
    # a is largest where its derivative by ω² vanishes: ω² = 1 + 3/4 k3 a² − c²/2.
    squared = np.roots([0.75 * 0.5 * 0.04**2, 0.04**2 - 0.25 * 0.04**4, -0.01]).max()
    assert float(data.peak_amplitude.max()) == pytest.approx(np.sqrt(squared), rel=1e-6)


@pytest.mark.slow
def test_duffing_in_time():
    """On the upper branch, H 7, against generalised-α from the same state, beside a dashpot in both."""
    response = ss.forced_response(duffing(), [0.6 / (2.0 * np.pi), 1.3 / (2.0 * np.pi)], harmonics=7)
    check = response.verify_in_time(0, 1, steps_per_period=1000)
    assert check.agrees(1e-4)


def test_a_softening_spring_bends_the_other_way():
    peaks = [ss.forced_response(duffing(k3), ss.radians_per_second(0.7, 1.5), harmonics=3).peaks() for k3 in (-0.03, 0.03)]
    low, high = (2.0 * np.pi * table["frequency"][0] for table in peaks)
    assert low < 0.99
    assert high > 1.01


def test_what_a_cubic_spring_refuses():
    for wrong, said in ((0.0, "must not be zero"), (np.nan, "must be finite"), (1e300, "larger")):
        with pytest.raises(ss.InputError, match=said):
            ss.CubicSpring(wrong)
    with pytest.raises(ss.InputError, match="no normal"):
        ss.Contact("spring", ss.CubicSpring(1.0), (), {"1.x": 1.0})
    with pytest.raises(ss.InputError, match="held by nothing"):
        duffing().with_structure(ss.Structure(np.eye(1), np.zeros((1, 1)), ("1.x",)))
