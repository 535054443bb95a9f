"""One mass with one Jenkins element, one harmonic: performance curves against Griffin's closed forms.

Without viscous damping A = Fc²/(kd (Fc − πF/4)), optimum Fc/F = π/2 with A = πF/kd, ω² = (k + kd/2)/m. Values with damping
(k = m = 1, ζ = 0.005, kd = 0.5): independent script of this project.
"""

from math import pi, sqrt
from types import SimpleNamespace

import numpy as np
import pytest
from matplotlib.colors import to_rgb

import stickslip as ss
from stickslip.analyses.performance.curve import performance_curve
from stickslip.analyses.performance.work import _event_arrays
from stickslip.show.plots.look import colour
from stickslip.show.plots.performance_curve import REGIONS, performance_curves
from stickslip.show.report.performance import sentences
from stickslip.solve.peaks.continuation import PeakContinuation
from stickslip.support.units import logspace

KD = 0.5
DAMPED = {0.2: 74.6605, 0.8: 11.7613, 1.2: 6.16452, 1.5: 5.87236, 3.0: 7.86732, 10.0: 21.2358, 50.0: 81.6503}


def mass(damping: float = 0.01, limit: float = 1.0):
    return ss.rigs.single_mass(damping=damping, kt=KD, limit=limit)


@pytest.fixture(scope="module")
def damped():
    return performance_curve(mass(), sorted({*DAMPED, *logspace(0.2, 50.0, 20)}), harmonics=1, samples=4096)


def test_peaks_with_damping(damped):
    at = damped.dataset.isel(case=0).set_index(point="force_ratio")
    found = [float(at.amplitude_per_force.sel(point=ratio)) for ratio in DAMPED]
    assert found == pytest.approx(list(DAMPED.values()), rel=6e-6)


def test_optimum_and_limits_with_damping(damped):
    best = damped.optimum()
    assert best["optimum_amplitude_per_force"] == pytest.approx(5.870724, rel=1e-6)
    assert best["optimum_ratio"] == pytest.approx(1.47424, rel=2e-3)
    assert best["plateau_low"] < best["optimum_ratio"] < best["plateau_high"]
    dataset = damped.dataset
    assert float(dataset.free_amplitude_per_force[0]) == pytest.approx(100.00125, rel=1e-8)
    assert float(dataset.stuck_amplitude_per_force[0]) == pytest.approx(81.65034, rel=1e-7)
    assert 2 * pi * float(dataset.stuck_frequency[0]) == pytest.approx(1.224724, rel=1e-6)


def test_plateau_is_where_the_curve_is_ten_per_cent_higher():
    """A kd/F = r²/(r − π/4) = 1.1 π has two roots, r = (1.1π ± √((1.1π)² − 1.1π²))/2."""
    curve = performance_curve(mass(damping=0.0), logspace(1.0, 6.0, 30), harmonics=1, samples=1024)
    low, high = (0.5 * (1.1 * pi + sign * sqrt((1.1 * pi) ** 2 - 1.1 * pi**2)) for sign in (-1.0, 1.0))
    assert curve.optimum()["plateau_low"] == pytest.approx(low, rel=2e-3)
    assert curve.optimum()["plateau_high"] == pytest.approx(high, rel=2e-3)


def test_curve_without_viscous_damping():
    ratios = np.array([0.9, 1.0, 1.3, pi / 2, 2.0, 3.0, 5.0, 8.0])
    curve = performance_curve(mass(damping=0.0), ratios, harmonics=1, samples=8192, band=ss.radians_per_second(0.8, 1.35))
    exact = ratios**2 / (KD * (ratios - pi / 4.0))
    assert curve.dataset.amplitude_per_force.values[0] == pytest.approx(exact, rel=1e-6)
    assert 2 * pi * float(curve.dataset.frequency[0, 3]) == pytest.approx(sqrt(1.25), rel=1e-3)
    assert curve.optimum()["optimum_ratio"] == pytest.approx(pi / 2, rel=1e-3)


@pytest.mark.parametrize("vary", ["force", "preload"])
def test_curves_collapse_on_friction_times_ratio(vary):
    scaled = np.array([0.9, 1.5, 4.0, 30.0])
    one = performance_curve(mass(), scaled / 0.3, friction=0.3, vary=vary, harmonics=1, samples=256).dataset
    other = performance_curve(mass(), scaled / 0.6, friction=0.6, vary=vary, harmonics=1, samples=256).dataset
    assert one.amplitude_per_force.values == pytest.approx(other.amplitude_per_force.values, rel=1e-4)
    assert one.frequency.values == pytest.approx(other.frequency.values, rel=1e-2)


def test_states_of_the_contact(damped):
    """Stuck exactly where μN ≥ kd A of the stuck structure; what rubs dissipates."""
    dataset = damped.dataset
    stuck = dataset.force_ratio.values >= KD * 81.65034
    assert (dataset.region.values[0] == 0).tolist() == stuck.tolist()
    assert np.all(dataset.dissipated.values[0, stuck] == 0.0)
    assert np.all(dataset.dissipated.values[0, ~stuck] > 0.0)


def test_following_agrees_with_the_sweeps_that_check_it(damped):
    dataset = damped.dataset
    gap = dataset.check_followed.values / dataset.check_swept.values - 1.0
    assert np.abs(gap[np.isfinite(gap)]).max() < 2e-6
    assert damped.events() == []
    assert float(dataset.energy_residual.max()) < 1e-8


@pytest.mark.parametrize("ratios", [logspace(0.3, 50.0, 9), [0.1, 1.0, 10.0], [0.5, 1.0, 50.0]])
def test_optimum_and_plateau_do_not_depend_on_the_values(ratios):
    """Exact solution of one harmonic: lowest at 1.47424, 10 % higher at 1.1181 and 2.1250."""
    best = performance_curve(mass(), ratios, harmonics=1, samples=512).optimum()
    assert best["optimum_amplitude_per_force"] == pytest.approx(5.870724, rel=1e-4)
    assert best["optimum_ratio"] == pytest.approx(1.47424, rel=0.01)
    assert [best["plateau_low"], best["plateau_high"]] == pytest.approx([1.1181, 2.1250], rel=1e-3)


def test_an_optimum_at_an_end_of_the_values_is_said_so():
    curve = performance_curve(mass(), [1.0, 4.0], harmonics=1, samples=128)
    with pytest.warns(UserWarning, match="at an end of the values, F_C/F_E = 1: it may be lower beyond"):
        best = curve.optimum()
    assert best["plateau_high"] == pytest.approx(3.08, rel=2e-3)
    assert "at an end of the values" in sentences(curve.dataset)[0]


def test_an_optimum_between_curves_that_are_lost_is_said_so(monkeypatch):
    monkeypatch.setattr(PeakContinuation, "at", lambda *arguments: None)
    monkeypatch.setattr(PeakContinuation, "swept", lambda *arguments: None)
    curve = performance_curve(mass(), [1.0, 1.5, 4.0], harmonics=1, samples=128)
    with pytest.warns(UserWarning, match="the search for the lowest peak ended, since no peak was found at F_C/F_E = "):
        best = curve.optimum()
    assert best["optimum_ratio"] == 1.5
    assert np.isnan(best["plateau_high"])


@pytest.mark.parametrize("samples", [256, 1024])
def test_corners_that_samples_make_are_no_peaks(samples):
    """One mass has one peak everywhere; its figure has no line where another one would be the highest."""
    curve = performance_curve(mass(), logspace(0.3, 50.0, 40), harmonics=1, samples=samples)
    assert curve.events() == []
    assert curve.dataset.sizes["branch"] == 1
    assert "another peak is the highest" not in performance_curves(curve.dataset).entries


def test_the_band_of_a_peak_against_the_closed_form():
    """Half bands within 0.1 % of the peak and their middles in Hz: exact solution of one harmonic, an independent script."""
    bands = {3.6: (6.4735e-4, 0.190412), 4.1: (6.3285e-4, 0.191261), 10.4: (4.7226e-4, 0.194222), 15.4: (4.0140e-4, 0.194628)}
    widths, middles = np.array(list(bands.values())).T
    for samples, close in ((256, 0.1), (2048, 0.02)):
        at = performance_curve(mass(), list(bands), harmonics=1, samples=samples).dataset.isel(case=0)
        assert at.frequency_width.values == pytest.approx(widths, rel=close)
        assert np.all(np.abs(at.frequency.values - middles) < close * widths)


def test_events_are_listed_in_the_order_of_the_ratio():
    """A curve may be followed downwards, or in parts from the middle."""
    events = [
        SimpleNamespace(kind="born", low=a, high=b, frequency=2.0, words=w)
        for a, b, w in ((9.0, 5.0, "c"), (1.0, 2.0, "a"), (3.0, 4.0, "b"))
    ]
    arrays = _event_arrays(SimpleNamespace(events=events, checks=[], solves=0, iterations=0))
    assert [words[-1] for words in arrays["event"]] == ["a", "b", "c"]
    assert (arrays["event_low"].tolist(), arrays["event_high"].tolist()) == ([1.0, 3.0, 5.0], [2.0, 4.0, 9.0])


def test_values_far_apart_are_swept():
    """A peak that cannot be followed from one value to the next is found there by a sweep, as a forced response finds it."""
    rig = ss.rigs.single_mass(damping=0.01, kt=0.5)
    ratios = logspace(0.5, 5.0, 3)
    curve = performance_curve(rig, ratios, harmonics=1, samples=1024)
    peak = (
        ss.forced_response(rig, ss.hertz(0.1, 0.3), force=1.0 / ratios[1], harmonics=1, samples=1024).peaks()["amplitude"].max()
    )
    assert curve.dataset.amplitude.values[0, 1] == pytest.approx(peak, rel=1e-4)
    assert curve.optimum()["optimum_amplitude_per_force"] == pytest.approx(5.871, rel=0.01)


def test_every_state_is_seen_on_white():
    """A bar of lift-off in near white looked like a gap."""
    colours = [colour(region) for region in REGIONS]
    darkest = [min(to_rgb(shade)) for shade in colours]
    assert len(set(colours)) == 4
    assert max(darkest) < 0.75


def test_curves_are_relative_to_the_resonance_of_their_band():
    """Two masses that a weak spring joins; the force drives the lower mode more, but the band holds the upper one alone."""
    M, K, C = np.eye(2), np.array([[1.1, -0.1], [-0.1, 4.1]]), 0.02 * np.eye(2)
    slider = ss.Contact("slider", ss.Macroslip(0.2, 0.5, normal_load=1.0), (ss.between("2.x", "ground"),))
    problem = ss.Problem(ss.Structure(M, K, ("1.x", "2.x"), C=C), (slider,), (ss.Force("2.x", 1.0),), ("1.x",))
    found = ss.performance_curve(problem, [0.3, 1.0], harmonics=1, samples=256, band=ss.radians_per_second(1.7, 2.4)).dataset
    omega = np.linspace(1.7, 2.4, 70_001)
    receptance = np.linalg.inv(K - omega[:, None, None] ** 2 * M + 1j * omega[:, None, None] * C)[:, 0, 1]
    best = int(np.argmax(np.abs(receptance)))
    assert float(found["free_amplitude_per_force"].max()) == pytest.approx(abs(receptance[best]), rel=1e-6)
    assert float(found["free_frequency"].max()) == pytest.approx(omega[best] / (2.0 * np.pi), rel=1e-4)
    ratio = found["amplitude_per_force"].values / abs(receptance[best])
    np.testing.assert_allclose(found["normalised_amplitude"].values, ratio, rtol=1e-6)
