"""Sizes of displacement, velocity and acceleration, with their derivatives by motion and frequency."""

import numpy as np
import pytest

import stickslip as ss
from stickslip.solve.balance.fourier import fourier
from stickslip.solve.balance.measure import KIND_WORDS, QUANTITIES, Measure, measure_of

H, OMEGA = 4, 3.7
MEASURES = [Measure(quantity, kind) for quantity in QUANTITIES.values() for kind in KIND_WORDS]
NAMES = [measure.words for measure in MEASURES]


def motion(seed=0):
    return np.random.default_rng(seed).normal(size=2 * H + 1)


def derivative_in_time(row, order, samples=200_000):
    """d^k x/dt^k over one period, from the derivatives of cos hωt and sin hωt themselves."""
    t = np.linspace(0.0, 2.0 * np.pi / OMEGA, samples, endpoint=False)
    x = np.full(samples, row[0] if order == 0 else 0.0)
    for h in range(1, H + 1):
        rate, (a, b) = h * OMEGA, row[2 * h - 1 : 2 * h + 1]
        c, s = np.cos(rate * t), np.sin(rate * t)
        x += (a * c + b * s, rate * (b * c - a * s), -(rate**2) * (a * c + b * s))[order]
    return x


@pytest.mark.parametrize("measure", MEASURES, ids=NAMES)
def test_a_size_is_that_of_the_motion_in_time(measure):
    row = motion(1)
    x = derivative_in_time(row, measure.order)
    first = 2.0 * np.mean(x * np.exp(-2j * np.pi * np.arange(x.size) / x.size))
    expected = {"amplitude": abs(first), "rms": np.sqrt(np.mean(x**2)), "max_abs": np.max(np.abs(x))}[measure.kind]
    assert measure.size(row, OMEGA) == pytest.approx(expected, rel=1e-8)


@pytest.mark.parametrize("measure", MEASURES, ids=NAMES)
def test_derivatives_by_motion_and_frequency_are_those_of_differences(measure):
    row, step = motion(2), 1e-6
    _, gradient, by_omega = measure.gradient(row, OMEGA)
    differences = [
        (measure.size(row + step * unit, OMEGA) - measure.size(row - step * unit, OMEGA)) / (2.0 * step)
        for unit in np.eye(row.size)
    ]
    np.testing.assert_allclose(gradient, differences, rtol=1e-7, atol=1e-7 * np.abs(gradient).max())
    across = (measure.size(row, OMEGA + step) - measure.size(row, OMEGA - step)) / (2.0 * step)
    assert by_omega == pytest.approx(across, rel=1e-7, abs=1e-12)
    change, rate = motion(3), 0.4
    _, slope = measure.slope(row, OMEGA, change, rate)
    assert float(slope) == pytest.approx(float(gradient @ change) + rate * by_omega, rel=1e-12)
    several = measure.slope(row, OMEGA, np.stack([change, 2.0 * change]))[1]
    np.testing.assert_allclose(several, [gradient @ change, 2.0 * gradient @ change], rtol=1e-12)


@pytest.mark.parametrize("measure", MEASURES, ids=NAMES)
def test_a_harmonic_motion_has_the_size_of_its_amplitude(measure):
    row = np.zeros(2 * H + 1)
    row[1:3] = 0.3, -0.4
    assert float(measure.of_harmonic(0.5, OMEGA)) == pytest.approx(measure.size(row, OMEGA), rel=1e-12)


@pytest.mark.parametrize("quantity", QUANTITIES.values(), ids=QUANTITIES)
def test_a_motion_over_two_periods_has_the_size_of_the_same_motion_over_one(quantity):
    """Harmonic h over one period at ω is harmonic 2h over two, whose frequency is ω/2."""
    once, twice = motion(5), np.zeros(4 * H + 1)
    for h in range(1, H + 1):
        twice[4 * h - 1 : 4 * h + 1] = once[2 * h - 1 : 2 * h + 1]
    measure = Measure(quantity)
    assert measure.over(2).size(twice, 0.5 * OMEGA) == pytest.approx(measure.size(once, OMEGA), rel=1e-12)


def test_names_per_force_are_sizes_per_force_level():
    inertance = measure_of("inertance", "amplitude")
    assert (inertance.order, inertance.per_force, inertance.per(20.0)) == (2, True, 20.0)
    assert inertance.reported_units(newtons=True) == "m/(s2 N)"
    assert inertance.reported_units(newtons=False) == "m/s2 per unit level"
    assert measure_of("accelerance", "amplitude") == inertance
    assert measure_of("acceleration", "amplitude").per(20.0) == 1.0


@pytest.mark.parametrize(
    ("quantity", "measure", "words"),
    [
        ("speed", "amplitude", "quantity must be displacement, velocity, acceleration, or per force receptance"),
        (2, "amplitude", "quantity must be a str, but is 2"),
        ("velocity", "peak", "measure must be one of amplitude, rms, max_abs, but is 'peak'"),
        ("velocity", None, "measure must be a str, but is None"),
    ],
)
def test_unknown_names_are_refused(quantity, measure, words):
    with pytest.raises(ss.InputError, match=words):
        ss.forced_response(ss.rigs.single_mass(), ss.hertz(0.1, 0.3), quantity=quantity, measure=measure)


def test_storage_is_that_of_the_balance():
    tables = fourier(H, 64)
    row = motion(4)
    assert Measure(kind="max_abs").size(row, OMEGA) >= np.max(np.abs(tables.E @ row)) * (1.0 - 1e-12)
