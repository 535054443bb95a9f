"""ContinuedPeaks peaks in a parameter: against full sweeps, on kinks, and through births, deaths and swaps of peaks.

A flat top of a sampled curve carries cusps of some 40/Nt² of its height; a followed peak may stand on another one than the swept.
"""

from itertools import pairwise

import numpy as np
import pytest
from balance.full_balance import balance_residual

import stickslip as ss
from stickslip.analyses.performance.curve import follow_peaks
from stickslip.analyses.performance.work import centrifugal_pull, excitation, with_friction, with_preload_factor
from stickslip.model.structure.matrices import Structure
from stickslip.show.plots.performance_curve import performance_curves
from stickslip.show.report.performance import sentences, tables
from stickslip.solve.balance.balance import HarmonicBalance
from stickslip.solve.balance.measure import DISPLACEMENT_AMPLITUDE
from stickslip.solve.continuation.continuation import first_point, trace
from stickslip.solve.continuation.curve_points import solve_at
from stickslip.solve.continuation.newton import correct
from stickslip.solve.peaks.climb import COARSEST, PeakSolver, peak_band_of, plane_at
from stickslip.solve.peaks.continuation import PeakContinuation, swept_peaks

CUSPS = 60.0
BAND = ss.radians_per_second(0.8, 1.4)


def swept(problem, band, force=1.0, samples=1024, harmonics=1):
    """Highest peak of a plain forced response: amplitude and frequency."""
    table = ss.forced_response(problem, band, force, harmonics=harmonics, samples=samples).peaks()
    best = table.loc[table.amplitude.idxmax()]
    return float(best.amplitude), float(best.frequency)


PARAMETERS = {
    "stiffness": (lambda kt: ss.rigs.single_mass(damping=0.02, kt=kt), [0.2, 0.35, 0.5, 0.7]),
    "friction": (lambda mu: with_friction(ss.rigs.single_mass(damping=0.02, kt=0.5), mu), [4.0, 2.0, 1.2, 0.9]),
    "preload": (lambda p: with_preload_factor(ss.rigs.single_mass(damping=0.02, kt=0.5), p), [4.0, 2.0, 1.2, 0.9]),
    "two at once": (lambda s: ss.rigs.single_mass(damping=0.02, kt=0.5 * s, limit=2.0 / s), [1.0, 1.2, 1.4]),
}


@pytest.mark.parametrize("name", PARAMETERS)
def test_any_parameter_against_sweeps(name):
    problem_of, values = PARAMETERS[name]
    path = follow_peaks(problem_of, values, BAND, harmonics=1, samples=1024, check_every=100)
    for k, value in enumerate(values):
        amplitude, _ = swept(problem_of(value), BAND)
        assert float(path.dataset.amplitude[k].max()) == pytest.approx(amplitude, rel=CUSPS / 1024**2)


def two_modes(gap_between: float = 0.02) -> ss.Problem:
    """Two masses of nearly equal frequency, both forced, a slider on the first: at high force its peak meets the other's."""
    K = np.diag([1.0, (1.0 + gap_between) ** 2])
    structure = Structure(np.eye(2), K, ("1.x", "2.x"), C=0.02 * np.eye(2))
    slider = ss.Contact("slider", ss.Macroslip(0.3, 1.0, normal_load=1.0), (ss.between("1.x", "ground"),))
    forces = (ss.Force("1.x", 1.0), ss.Force("2.x", 0.35))
    return ss.Problem(structure, (slider,), forces, (ss.Output("sum", {"1.x": 1.0, "2.x": 1.0}),), "Two modes")


def test_peaks_that_end_and_swap_are_reported():
    """Stuck, the first mass resonates at 1.14 rad/s, far from the second at 1.02; free at 1.0: the two peaks have merged."""
    levels = ss.units.logspace(0.02, 40.0, 40)
    path = follow_peaks(lambda level: two_modes(), levels, BAND, force=lambda level: level, harmonics=1, samples=512)
    kinds = [event.kind for event in path.events]
    assert "swapped" in kinds
    assert "ended" in kinds or "merged" in kinds
    for k in (0, 9, 17, 25, 33, 39):
        amplitude, _ = swept(two_modes(), BAND, float(levels[k]), samples=512)
        assert float(path.dataset.amplitude[k].max()) == pytest.approx(amplitude, rel=CUSPS / 512**2)


def test_peaks_that_are_born_are_followed_back():
    """The same downwards: the peak that the sweeps find on the way exists at every value where a sweep has two."""
    levels = ss.units.logspace(0.02, 40.0, 40)[::-1]
    path = follow_peaks(lambda level: two_modes(), levels, BAND, force=lambda level: level, harmonics=1, samples=512)
    born = [event for event in path.events if event.kind == "born"]
    assert born
    for k, level in enumerate(levels):
        if k % 4 == 0:
            amplitude, _ = swept(two_modes(), BAND, float(level), samples=512)
            assert float(path.dataset.amplitude[k].max()) == pytest.approx(amplitude, rel=CUSPS / 512**2)


@pytest.mark.parametrize("samples", [8, 12])
def test_a_peak_on_a_kink_is_a_one_sided_maximum(samples):
    """So few samples put corners into the curve: the amplitude falls on both sides at an angle, and the peak says so."""
    kinks = 0
    for limit in (1.457, 1.643, 1.829):
        balance = HarmonicBalance(ss.rigs.single_mass(damping=0.01, kt=0.5, limit=limit), 1, samples)
        for peak in swept_peaks(balance, 1.0, (0.8, 1.4), 0, DISPLACEMENT_AMPLITUDE)[0]:
            plane = plane_at(balance, peak.evaluation)
            for side in (-1.0, 1.0):
                beside = correct(balance, peak.point, plane.at(side * 4e-3), iterations=30, halvings=10)
                fallen = 1.0 - float(np.hypot(*beside.evaluation.w[1, 1:3])) / peak.amplitude
                assert beside.converged
                assert fallen > (0.0 if peak.on_kink else -COARSEST)
            kinks += peak.on_kink
            assert peak_band_of(PeakSolver(balance, 0, DISPLACEMENT_AMPLITUDE), peak).width > 0.0
    assert kinks >= 2


@pytest.fixture(scope="module")
def wedge_that_lifts():
    problem = ss.rigs.blade_and_wedge(60.0, 35.0, 0.2)
    return problem, ss.performance_curve(problem, np.geomspace(3.0, 100.0, 30)[:6], band=ss.hertz(280.0, 390.0)).dataset


@pytest.mark.nightly
def test_the_curve_is_that_of_a_sweep_even_where_a_higher_peak_lies_apart(wedge_that_lifts):
    """Rounding chooses which peak on an isola is followed, and up to which F_C/F_E, not the curve beside it.

    40 changes of µ by 1e-14 led to 30.0, 35.0 or 38.0 µm/N at F_C/F_E = 4.312, and one of them to 49.7 µm/N at 3.386.
    """
    problem, curve = wedge_that_lifts
    for ratio, height in zip(curve.force_ratio.values, curve.amplitude_per_force.values[0], strict=True):
        force = 60.0 / float(ratio)
        swept = ss.forced_response(problem, ss.hertz(280.0, 390.0), force=force).dataset.peak_amplitude.values[0, 0].max()
        assert height == pytest.approx(swept / force, rel=1e-3)
    apart = curve.detached_amplitude_per_force.values[0]
    assert np.any(np.isfinite(apart))
    assert np.all((apart > curve.amplitude_per_force.values[0])[np.isfinite(apart)])


@pytest.mark.nightly
def test_peaks_on_isolas_are_periodic_motions(wedge_that_lifts):
    """Contact forces of the motion, marched in plain Python, balance the equation of motion in each harmonic."""
    problem, curve = wedge_that_lifts
    balance = HarmonicBalance(problem, 5, 256)
    band = (2.0 * np.pi * 280.0, 2.0 * np.pi * 390.0)
    continuation = PeakContinuation(lambda ratio: (balance, 60.0 / ratio), band, 0, DISPLACEMENT_AMPLITUDE)
    found = continuation.follow(curve.force_ratio.values[::-1].tolist(), 10, lambda fraction: None)
    apart = curve.detached_amplitude_per_force.values[0]
    for k in np.flatnonzero(np.isfinite(apart)):
        ratio = float(curve.force_ratio[k])
        peak = found.detached(ratio)[1].peak
        assert peak.amplitude * ratio / 60.0 == pytest.approx(apart[k], rel=1e-12)
        assert balance_residual(balance, peak.point) < 1e-7


@pytest.mark.slow
def test_continuation_in_the_force_level_passes_higher_motions(wedge_that_lifts):
    """At F_C/F_E = 4.312, where the curve has 24.1 µm/N: folds in the force level lead to isolas of a sweep.

    Beyond the first two, which of the isolas it meets depends on rounding: those of 45.6 µm/N, or of 81.9 and 91.2.
    """
    problem, curve = wedge_that_lifts
    ratio = float(curve.force_ratio[3])
    force, balance = 60.0 / ratio, HarmonicBalance(problem, 5, 1024)
    points = list(trace(balance, first_point(balance, 2.0 * np.pi * 315.9, 2.0), "level", 60.0))
    passed = [pair for pair in pairwise(points) if (pair[0].point.level - force) * (pair[1].point.level - force) < 0.0]
    solved = [solve_at(balance, *pair, "level", force) for pair in passed]
    motions = 1e6 / force * np.sort([np.hypot(*each.evaluation.w[balance.rows, 1:3]) for each in solved])
    assert ratio == pytest.approx(4.312, abs=5e-4)
    assert curve.amplitude_per_force.values[0, 3] == pytest.approx(24.07e-6, rel=1e-3)
    assert motions[0] == pytest.approx(20.62, rel=1e-3)
    for motion in (35.48, 38.01):
        assert np.any(np.isclose(motions, motion, rtol=1e-3))


def test_no_climb_of_a_sweep_leaves_its_curve():
    """With 1024 samples a climb from 32.3 µm/N at 315.90 Hz leads to 39.7 µm/N at 316.11 Hz, on the closed curve."""
    level, ends = 60.0 / 3.0 / 2.0 ** (1.0 / 3.0), (2.0 * np.pi * 280.0, 2.0 * np.pi * 390.0)
    found = swept_peaks(
        HarmonicBalance(ss.rigs.blade_and_wedge(60.0, 35.0, 0.2), 5, 1024), level, ends, 0, DISPLACEMENT_AMPLITUDE
    )[0]
    assert max(peak.amplitude for peak in found) / level == pytest.approx(32.768e-6, rel=1e-4)  # of a forced response


def test_a_peak_on_an_isola_is_reported_and_marked(wedge_that_lifts):
    curve = wedge_that_lifts[1]
    highest = 1e6 * np.nanmax(curve.detached_amplitude_per_force.values)
    apart = np.isfinite(curve.detached_amplitude_per_force.values[0])
    where = " to ".join(dict.fromkeys(f"{ratio:.4g}" for ratio in curve.force_ratio.values[apart][[0, -1]]))
    said = f"{where}: higher peaks, up to {highest:.4g} µm/N, lie on an isola that sweeps miss"
    assert any(said in words for words in sentences(curve))
    assert np.isfinite(tables(curve)["performance curves"]["on an isola [m/N]"]).sum() == apart.sum()
    assert {"as built", "on an isola", "another peak is the highest"} < {*performance_curves(curve).entries}


def test_what_happened_to_peaks_is_gathered_in_a_line_and_listed_one_by_one_in_the_table(wedge_that_lifts):
    curve = wedge_that_lifts[1]
    words = [str(event) for event in curve.event.values[0]]
    born = sum("appeared" in event or "split off" in event for event in words)
    gathered = [line for line in sentences(curve) if "resonance peaks appear" in line]
    assert born > 10
    assert len(gathered) == 1
    low, high = np.nanmin(curve.event_low.values), np.nanmax(curve.event_high.values)
    assert f"between F_C/F_E = {low:.4g} and {high:.4g} further resonance peaks appear ({born})" in gathered[0]
    table = tables(curve)["peaks along the curves"]
    assert all(
        f"{row['at Hz']:.5g} Hz: {row['what happened']}" in event for (_, row), event in zip(table.iterrows(), words, strict=True)
    )


def test_what_F_C_is():
    assert centrifugal_pull(ss.rigs.single_mass(limit=3.0)) == 3.0
    assert centrifugal_pull(ss.rigs.three_mass_wedge(pull=50.0)) == 50.0


def test_a_force_on_a_surface_counts_as_a_whole():
    """Its shares by area, 0.3, 0.5 and 0.2: their Euclidean norm, 0.62, was taken for the whole. One side of a pair counts."""
    structure = ss.Structure(np.eye(4), np.eye(4), ("1.x", "2.x", "3.x", "3.y"), C=0.1 * np.eye(4))
    shares, pair, slanted = {"1.x": 0.3, "2.x": 0.5, "3.x": 0.2}, {"1.x": 1.0, "2.x": -1.0}, {"3.x": 0.6, "3.y": 0.8}
    for direction, size in ((shares, 1.0), (pair, 1.0), (slanted, 1.0), ({"1.x": 1.0, "2.x": 1.0}, 2.0)):
        problem = ss.Problem(structure, (), (ss.Force(direction, 7.0, static=-5.0),), ("1.x",))
        assert excitation(problem) == pytest.approx(7.0 * size)
        assert centrifugal_pull(problem) == pytest.approx(5.0 * size)


def test_a_gap_that_hides_the_force_is_refused():
    """656 µm/N and an isola were given, where 3536 µm/N are right."""
    structure = ss.Structure(np.eye(1), 1e4 * np.eye(1), ("a.x",), C=2.0 * np.eye(1))
    stop = ss.Contact("stop", ss.Gap(kn=1e4, gap=1e13), normal={"a.x": 1.0})
    problem = ss.Problem(structure, (stop,), (ss.Force("a.x", 1.0, static=5.0),), ("a.x",))
    with pytest.raises(ss.InputError, match="gap of stop must not be so large"):
        ss.performance_curve(problem, [1.0, 2.0], band=ss.Band(14.0, 18.0), harmonics=3, samples=64)


@pytest.mark.parametrize(
    ("call", "words"),
    [
        (lambda rig: ss.performance_curve(rig, [1.0, -2.0]), "force_ratio must be positive"),
        (lambda rig: ss.performance_curve(rig, [1.0], friction=-0.1), "friction must not be negative"),
        (lambda rig: ss.performance_curve(rig, [1.0], vary="mass"), "vary must be one of force, preload"),
        (lambda rig: ss.performance_curve(rig, [1.0], output=3), "output must be 0 to 0"),
        (lambda rig: ss.performance_curve(rig, [1.0], check_every=0), "check_every must be at least 1"),
        (lambda rig: ss.follow_peaks(lambda v: rig, [1.0, 1.0], BAND), "values must be different"),
        (lambda rig: ss.logspace(1.0, 2.0, 1), "points must be at least 2"),
    ],
)
def test_wrong_input_is_said(call, words):
    with pytest.raises(ss.InputError, match=words):
        call(ss.rigs.single_mass())
