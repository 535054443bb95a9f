"""One mass with a Jenkins element, one harmonic: Griffin's optimum and peaks over frequency with viscous damping.

Without viscous damping the resonance amplitude is A = Fc²/(kd (Fc − πF/4)); optimum Fc/F = π/2 with A = πF/kd, ω² = (k + kd/2)/m.
Values with damping (k = m = 1, ζ = 0.005, kd = 0.5, F = 1): independent script of this project.
"""

from math import pi, sqrt

import numpy as np
import pytest
from scipy.optimize import brentq, minimize_scalar

from stickslip.analyses.forced_response import forced_response
from stickslip.model.rigs import single_mass
from stickslip.support.units import radians_per_second

SAMPLES = 8192
KD = 0.5


def peak(limit: float, damping: float = 0.01, force: float = 1.0, kt: float = KD, band=(0.9, 1.4)) -> tuple[float, float]:
    """Amplitude and ω of the highest peak."""
    problem = single_mass(damping=damping, kt=kt, limit=limit, force=force)
    table = forced_response(problem, radians_per_second(*band), harmonics=1, samples=SAMPLES).peaks()
    return float(table.amplitude[0]), 2.0 * pi * float(table.frequency[0])


@pytest.mark.parametrize(
    ("limit", "amplitude", "omega"),
    [
        (0.2, 74.6605, 1.000133),
        (0.8, 11.7613, 1.019996),
        (1.2, 6.16452, 1.085990),
        (1.5, 5.87236, 1.120785),
        (3.0, 7.86732, 1.186856),
        (10.0, 21.2358, 1.219878),
        (50.0, 81.6503, 1.224724),
    ],
)
def test_peaks_with_damping(limit, amplitude, omega):
    """Against the closed balance of one harmonic, maximised here, and the table: six digits. The top is flat: an amplitude
    error of 1e-7 from sampling moves it by 1e-4 of its frequency."""
    best = minimize_scalar(lambda w: -exact_amplitude(w, limit), bounds=(omega - 0.01, omega + 0.01), options={"xatol": 1e-10})
    assert -best.fun == pytest.approx(amplitude, rel=5e-6)
    assert best.x == pytest.approx(omega, abs=1e-6)
    found = peak(limit)
    assert found[0] == pytest.approx(-best.fun, rel=1e-6)
    assert found[1] == pytest.approx(omega, rel=1e-4)


def test_free_and_stuck_peaks_are_those_of_linear_oscillators():
    assert peak(1e-9) == pytest.approx((100.00125, 0.999975), rel=1e-6)
    assert peak(1e3) == pytest.approx((81.65034, 1.224724), rel=1e-6)


def test_optimum_with_damping():
    """Parabola through three limits: lowest peak 5.870724 at μN/F = 1.47424."""
    limits = np.array([1.44424, 1.47424, 1.50424])
    amplitudes = [peak(limit)[0] for limit in limits]
    assert amplitudes[1] == pytest.approx(5.870724, rel=1e-6)
    curve = np.polyfit(limits - limits[1], amplitudes, 2)
    assert limits[1] - 0.5 * curve[1] / curve[0] == pytest.approx(1.47424, abs=2e-3)


@pytest.mark.parametrize("ratio", [1.0, 1.3, 2.0, 5.0])
def test_resonance_without_viscous_damping(ratio):
    """Finite only beyond Fc = πF/4; everything depends on Fc/F and A kd/F alone."""
    exact = ratio**2 / (KD * (ratio - pi / 4.0))
    amplitude, _ = peak(ratio, damping=0.0, band=(0.8, 1.35))
    assert amplitude == pytest.approx(exact, rel=1e-6)


def test_optimum_without_viscous_damping():
    amplitude, omega = peak(pi / 2.0, damping=0.0)
    assert amplitude == pytest.approx(pi / KD, rel=1e-6)
    assert omega == pytest.approx(sqrt(1.0 + KD / 2.0), rel=1e-4)
    for other in (0.9, 1.1):
        assert peak(other * pi / 2.0, damping=0.0)[0] > amplitude


@pytest.mark.parametrize("scale", [0.01, 300.0])
def test_curves_of_equal_friction_to_force_ratio_collapse(scale):
    plain, scaled = peak(1.2), peak(1.2 * scale, force=scale)
    assert scaled == pytest.approx((scale * plain[0], plain[1]), rel=1e-8)


def test_second_order_in_the_samples():
    """Amplitudes at fixed frequencies against the balance with the exact k_eq and h of one harmonic."""
    omegas = np.linspace(1.0, 1.2, 9)
    errors = {n: rms_error(omegas, n) for n in (256, 1024, 4096)}
    assert errors[4096] < 1e-6
    assert np.log2(errors[256] / errors[4096]) / 4.0 == pytest.approx(2.0, abs=0.2)


def rms_error(omegas: np.ndarray, samples: int) -> float:
    response = forced_response(single_mass(damping=0.01, kt=KD, limit=1.2), omegas / (2 * pi), harmonics=1, samples=samples)
    found = response.dataset.amplitude.to_numpy().ravel()
    exact = np.array([exact_amplitude(omega, 1.2) for omega in omegas])
    return float(np.sqrt(np.mean((found / exact - 1.0) ** 2)))


def exact_amplitude(omega: float, limit: float) -> float:
    """|k + k_eq − ω² + i(cω + h)| A = F."""

    def gap(a: float) -> float:
        critical = limit / KD
        angle = np.arccos(1.0 - 2.0 * critical / a) if a > critical else pi
        stiffness = KD / pi * (angle - 0.5 * np.sin(2.0 * angle))
        h = 4.0 * limit / (pi * a) * max(1.0 - critical / a, 0.0)
        return abs(1.0 + stiffness - omega**2 + 1j * (0.01 * omega + h)) * a - 1.0

    return float(brentq(gap, 1e-3, 1e4, xtol=1e-14, rtol=1e-14))


@pytest.mark.nightly
@pytest.mark.parametrize(
    ("beta", "ratio", "exact"),
    [
        (0.6, 0.2, 1.5506028547),
        (1.3, 0.5, 1.0353280077),
        (2.0, 0.3, 0.2976761850),
    ],
)
def test_rigid_friction_is_the_limit_of_a_stiff_spring(beta, ratio, exact):
    """Den Hartog (1931), motion without stops: max|x| k/P = √(V² − r²U²), V = 1/(1 − β²), U = sin(π/β)/(β(1 + cos(π/β)))."""
    V, U = 1.0 / (1.0 - beta**2), np.sin(pi / beta) / (beta * (1.0 + np.cos(pi / beta)))
    assert np.sqrt(V**2 - ratio**2 * U**2) == pytest.approx(exact, rel=1e-10)
    errors = []
    for kt in (1e3, 1e4, 1e5):
        problem = single_mass(damping=0.0, kt=kt, limit=ratio)
        dataset = forced_response(problem, [beta / (2.0 * pi)], harmonics=61, samples=8192).dataset
        errors.append(abs(float(dataset.max_abs[0, 0, 0]) / exact - 1.0))
    assert errors[0] > 1.5 * errors[1] > 2.0 * errors[2]
    assert errors[2] < 6e-3
