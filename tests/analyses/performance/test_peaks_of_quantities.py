"""Performance curves, followed peaks, designs and slopes by velocity and acceleration: the exact solution of one harmonic.

One mass with a Jenkins element: with A the amplitude and A_c = F_c/kd, a slipping element is the stiffness
k_eq = kd (θ − sin 2θ/2)/π and the damping h = 4 F_c (1 − A_c/A)/(π A), cos θ = 1 − 2 A_c/A (Griffin 1980), so that
(k + k_eq − ω²)² + (c ω + h)² = (F/A)² for a mass of 1 kg.
"""

from functools import cache

import numpy as np
import pytest
from scipy.optimize import minimize_scalar

import stickslip as ss
from stickslip.show.report.performance import design_sentences, sentences, tables
from stickslip.show.report.performance import index_sentences as matter_sentences

KD, C = 0.5, 0.1
QUANTITIES = ("displacement", "velocity", "acceleration")
UNITS = {"displacement": "m/N", "velocity": "m/(s N)", "acceleration": "m/(s2 N)"}
BAND = ss.radians_per_second(0.4, 3.0)
LIMITS = (0.6, 1.5, 4.0)


def mass(limit=1.0, kd=KD):
    return ss.rigs.single_mass(damping=C, kt=kd, limit=limit)


@cache
def exact(limit, order, kd=KD):
    """The highest ω^k A of a slip limit and its frequency in rad/s, under 1 N: a fine scan of A, and a search beside its best."""

    def best_at(amplitude):
        ratio = min(limit / kd / amplitude, 1.0)
        angle = np.arccos(1.0 - 2.0 * ratio)
        stiffness = 1.0 + kd * (angle - 0.5 * np.sin(2.0 * angle)) / np.pi
        friction = 4.0 * limit * (1.0 - ratio) / (np.pi * amplitude)
        roots = np.roots([1.0, 0.0, C**2 - 2.0 * stiffness, 2.0 * C * friction, stiffness**2 + friction**2 - amplitude**-2])
        real = roots[(abs(roots.imag) < 1e-7) & (roots.real > 0.0)].real
        return max(((w**order * amplitude, w) for w in real), default=(0.0, 0.0))

    scan = np.geomspace(0.05, 15.0, 600)
    k = int(np.argmax([best_at(amplitude)[0] for amplitude in scan]))
    ends = (scan[max(k - 1, 0)], scan[min(k + 1, scan.size - 1)])
    found = minimize_scalar(lambda a: -best_at(a)[0], bounds=ends, method="bounded", options={"xatol": 1e-12})
    return max(best_at(found.x), best_at(scan[k]))


@pytest.mark.parametrize("quantity", QUANTITIES)
def test_performance_curves_are_those_of_the_exact_peaks(quantity):
    order = QUANTITIES.index(quantity)
    curve = ss.performance_curve(
        mass(), np.geomspace(0.3, 10.0, 21).tolist() + list(LIMITS), band=BAND, harmonics=1, samples=1024, quantity=quantity
    )
    dataset = curve.dataset.isel(case=0).set_index(point="force_ratio")
    for limit in LIMITS:
        height, omega = exact(limit, order)
        assert float(dataset.amplitude_per_force.sel(point=limit)) == pytest.approx(height, rel=3e-5)
        width = 2.0 * np.pi * float(dataset.frequency_width.sel(point=limit))
        assert 2.0 * np.pi * float(dataset.frequency.sel(point=limit)) == pytest.approx(omega, abs=width)
    assert curve.dataset.amplitude_per_force.attrs["units"] == UNITS[quantity]
    lowest = minimize_scalar(lambda x: exact(float(x), order)[0], bounds=(0.5, 3.0), method="bounded", options={"xatol": 1e-4})
    best = curve.optimum()
    assert best["optimum_amplitude_per_force"] == pytest.approx(lowest.fun, rel=3e-5)
    assert best["optimum_ratio"] == pytest.approx(lowest.x, rel=0.01)
    for end in (best["plateau_low"], best["plateau_high"]):
        assert exact(end, order)[0] == pytest.approx(1.1 * lowest.fun, rel=1e-3)
    words, table = "\n".join(sentences(curve.dataset)), tables(curve.dataset)["performance curves"]
    assert ("lowest resonance, as inertance," in words) == (quantity == "acceleration")
    assert f"amplitude per force [{UNITS[quantity]}]" in table.columns
    assert curve.plot(quantity="amplitude_per_force").axes[0].get_ylabel().endswith(UNITS[quantity].replace("s2", "s²"))


def test_optima_of_the_quantities_differ():
    best = [minimize_scalar(lambda x, k=k: exact(float(x), k)[0], bounds=(0.5, 3.0), method="bounded").x for k in range(3)]
    assert best[0] > 1.03 * best[1] > 1.03**2 * best[2]


@pytest.mark.parametrize("quantity", QUANTITIES)
def test_inertance_is_that_of_the_first_harmonic_at_the_peak(quantity):
    dataset = ss.performance_curve(
        mass(), [1.5, 2.0], band=BAND, harmonics=3, samples=256, quantity=quantity, measure="rms"
    ).dataset
    peak = ss.forced_response(mass(), BAND, 1.0 / 1.5, 3, 256, quantity=quantity, measure="rms")
    assert float(dataset.amplitude[0, 0]) == pytest.approx(peak.peaks().rms[0], rel=1e-4)
    first = peak.as_quantity("inertance")["amplitude"].values[0, peak.peak_point(), 0]
    assert float(dataset.inertance[0, 0]) == pytest.approx(first, rel=0.02)
    words = {"displacement": "displacement peak", "velocity": "velocity peak", "acceleration": "inertance"}[quantity]
    assert words in dataset.inertance.attrs["long_name"]


@pytest.mark.parametrize("quantity", ["mobility", "inertance"])
def test_followed_peaks_are_those_of_the_exact_solution(quantity):
    path = ss.follow_peaks(mass, [4.0, 2.0, 1.5], BAND, 1.0, quantity=quantity, harmonics=1, samples=1024).dataset
    order = {"mobility": 1, "inertance": 2}[quantity]
    for limit in (4.0, 1.5):
        found = float(path.amplitude.sel(value=limit).max())
        assert found == pytest.approx(exact(limit, order)[0], rel=3e-5)
    assert path.amplitude.attrs["units"] == UNITS[QUANTITIES[order]]


@pytest.mark.slow
def test_a_design_by_its_acceleration():
    def problem(*, friction, load):
        return mass(limit=load * friction)

    settings = {
        "force": (1.0, 1.0),
        "levels": 1,
        "friction": 0.4,
        "friction_factor": 1.0,
        "starts": 0,
        "designs": 8,
        "refinements": 20,
    }
    lowest = minimize_scalar(lambda x: exact(float(x), 2)[0], bounds=(0.5, 3.0), method="bounded", options={"xatol": 1e-4})
    found = ss.damper_design(problem, {"load": (1.0, 8.0)}, harmonics=1, samples=256, quantity="acceleration", **settings)
    assert float(found.dataset.optimum_peak) == pytest.approx(lowest.fun, rel=1e-3)
    assert 0.4 * found.optimum["load"] == pytest.approx(lowest.x, rel=0.03)
    assert found.dataset.worst_peak.attrs["units"] == "m/s2"
    assert " m/s² over" in design_sentences(found.dataset)[0] or design_sentences(found.dataset)[0].endswith(" m/s²")
    assert "amplitude of the first harmonic of the acceleration" in design_sentences(found.dataset)[0]
    per_force = ss.damper_design(problem, {"load": (1.0, 8.0)}, harmonics=1, samples=256, quantity="inertance", **settings)
    assert per_force.dataset.worst_peak.attrs["units"] == "m/s2 per unit level"


def test_slopes_of_the_inertance_are_those_of_the_exact_peaks():
    def problem(*, kd, limit):
        return mass(limit=limit, kd=kd)

    ranges = {"kd": (0.4, 0.6), "limit": (1.2, 1.8)}
    found = ss.sensitivity_indices(problem, ranges, BAND, 2.0, draws=2, harmonics=1, samples=512, quantity="inertance").dataset

    def height(kd, limit):  # under 2 N as under 1 N with half the limit
        return np.log(exact(round(0.5 * limit, 12), 2, round(kd, 12))[0])

    slopes = [(height(0.51, 1.5) - height(0.49, 1.5)) * 10.0, (height(0.5, 1.53) - height(0.5, 1.47)) * 10.0]
    assert found.slope.values == pytest.approx(slopes, abs=2e-3)
    assert float(found.middle[0]) == pytest.approx(exact(0.75, 2)[0], rel=1e-4)
    assert 2.0 * np.pi * float(found.middle[1]) == pytest.approx(exact(0.75, 2)[1], rel=0.02)
    assert found.middle.attrs["units"] == "m/(s2 N) and Hz"
    assert "m/(s² N)" in matter_sentences(found)[0]
