"""A curve that leaves its band through the start and returns: what lies outside is kept, marked and told, and counts for nothing.

A mass on a preloaded contact that lifts off, and so softens: from the start of the band the curve goes down to 0.124 Hz over a
peak of 5.4 m, and comes back. Followed from the other end it arrives at the start without leaving the band, so that both must
give the same answer.
"""

import numpy as np
import pytest

import stickslip as ss
from stickslip.analyses.stress import margins
from stickslip.results.view import converged_points, higher_end, highest_maximum, highest_peak, in_band
from stickslip.show.report.stress import largest_stresses
from stickslip.solve.balance.balance import HarmonicBalance
from stickslip.solve.balance.measure import Measure, quantity_named
from stickslip.solve.curves.curve import solve_curve
from stickslip.solve.curves.refine import refined

LOW, HIGH, LEVEL = 1.0, 1.3, 0.05
FINENESS = {"harmonics": 3, "samples": 64}


def softening(coupled=0.0):
    """A mass that a contact with lift-off holds, beside one that it drives by a spring."""
    structure = ss.Structure(
        np.eye(2), [[0.3 + coupled, -coupled], [-coupled, 1.0 + coupled]], ("1.y", "1.x"), damping=ss.ModalDamping(0.005)
    )
    law = ss.Macroslip(kt=0.1, mu=0.3, kn=1.0, preload=0.3)
    contact = ss.Contact("c", law, ({"1.x": 1.0},), {"1.y": 1.0}, balanced=True)
    return ss.Problem(structure, (contact,), (ss.Force("1.y", 1.0),), ("1.y", "1.x"))


@pytest.fixture(scope="module")
def leaves():
    return ss.forced_response(softening(), ss.radians_per_second(LOW, HIGH), LEVEL, **FINENESS)


@pytest.fixture(scope="module")
def stays():
    return ss.forced_response(softening(), ss.radians_per_second(HIGH, LOW), LEVEL, **FINENESS)


@pytest.fixture(scope="module")
def curve():
    balance = HarmonicBalance(softening(), **FINENESS)
    return balance, refined(balance, solve_curve(balance, [LOW, HIGH], LEVEL, exactly=False))


def test_the_curve_is_whole_and_meets_the_end_of_the_band_exactly(curve):
    omegas = np.array([point.point.omega for point in curve[1].points])
    assert omegas.min() < 0.8
    assert np.count_nonzero(omegas == LOW) == 3
    inside = np.array([curve[1].holds(omega) for omega in omegas])
    assert inside.tolist() == ((omegas >= LOW) & (omegas <= HIGH)).tolist()
    assert [point.point.omega for point in curve[1].inside] == omegas[inside].tolist()
    changes = np.flatnonzero(np.diff(inside.astype(int)))
    assert [min(omegas[k], omegas[k + 1]) < LOW == max(omegas[k], omegas[k + 1]) for k in changes] == [True, True]


def test_peaks_outside_are_kept_apart(curve):
    balance, found = curve
    assert found.peaks[0] == ()
    assert found.largest[0] is None
    (peak,) = found.outside[0]
    assert any(peak is point for point in found.points)
    highest = max(np.hypot(*point.evaluation.w[balance.rows, 1:3]) for point in found.points)
    assert np.hypot(*peak.evaluation.w[balance.rows, 1:3]) == pytest.approx(highest, rel=1e-6)


def test_the_answer_is_that_of_the_sweep_that_stays_inside(leaves, stays):
    assert leaves.peaks().empty
    assert stays.peaks().empty
    own, other = (highest_peak(each.dataset, 0) for each in (leaves, stays))
    assert own.amplitude == pytest.approx(other.amplitude, rel=1e-8)
    assert own.frequency == pytest.approx(other.frequency, rel=1e-8)
    assert highest_peak(leaves.dataset, 0).amplitude == pytest.approx(0.8126, rel=1e-3)


def test_it_is_told(leaves, stays):
    words = "The curve leaves the band down to 0.1243 Hz and comes back: what lies outside does not count."
    assert words in str(leaves.dataset["case_message"].values[0])
    assert words in str(leaves)
    assert "leaves the band" not in str(stays.dataset["case_message"].values[0])


def test_errors_stability_and_loop_are_those_of_the_band(leaves, stays):
    for name in ("truncation_error", "sampling_error", "work_error", "highest_stability", "loop_frequency", "loop_force"):
        np.testing.assert_allclose(leaves.dataset[name].values, stays.dataset[name].values, rtol=1e-5, atol=1e-9)


def test_points_in_the_band(leaves):
    dataset = leaves.dataset
    every = converged_points(dataset, 0)
    inside = in_band(dataset, 0, every)
    omegas = 2.0 * np.pi * dataset["frequency"].values[0, every]
    assert inside.tolist() == every[omegas > LOW - 1e-9].tolist()
    assert 0 < inside.size < every.size


@pytest.fixture(scope="module")
def with_peaks():
    """Two curves with a peak inside, the first of them also with one outside."""
    ends = ((1.0, 1.6), (1.6, 1.0))
    return [ss.forced_response(softening(0.3), ss.radians_per_second(*each), LEVEL, **FINENESS) for each in ends]


def test_readers_of_a_maximum_read_inside(with_peaks):
    assert "The curve leaves the band" in str(with_peaks[0].dataset["case_message"].values[0])
    first, second = (each.peaks() for each in with_peaks)
    np.testing.assert_allclose(first[["frequency", "amplitude"]], second[["frequency", "amplitude"]], rtol=1e-6)
    velocities = [each.peaks("velocity") for each in with_peaks]
    assert velocities[0]["frequency"].min() > LOW / (2.0 * np.pi)
    highest = [each.groupby("output")["amplitude"].max() for each in velocities]
    np.testing.assert_allclose(*highest, rtol=1e-5)
    velocity = Measure(quantity_named("velocity")[0], "amplitude")
    own, other = (highest_maximum(each.dataset, 0, 0, velocity) for each in with_peaks)
    np.testing.assert_allclose(own, other, rtol=1e-2)
    ends = [higher_end(each.dataset, 0, 0) for each in with_peaks]
    assert [end is None for end in ends] in ([True, True], [False, False])


def test_stress_and_margin_are_read_inside(with_peaks):
    dataset = with_peaks[0].dataset
    sizes = dataset["amplitude"].values[..., :1]
    dims = ("case", "point", "place")
    stressed = dataset.assign(
        stress_von_mises=(dims, sizes),
        stress_alternating=(dims, sizes),
        stress_amplitude=((*dims, "component"), sizes[..., None]),
        stress_mean=((*dims, "component"), sizes[..., None]),
        fatigue_mean=(dims, 0.0 * sizes),
        fatigue_limit=(dims, 0.0 * sizes + 10.0),
    ).assign_coords(place=["root"], component=["xx"])
    every = converged_points(dataset, 0)
    inside = in_band(dataset, 0, every)
    most = dataset["amplitude"].values[0, inside, 0].max()
    assert dataset["amplitude"].values[0, every, 0].max() > most
    (stress,) = largest_stresses(stressed)
    (margin,) = margins(stressed)
    assert stress.von_mises == margin.alternating == most
    assert stress.frequency == margin.frequency


def test_a_warning_of_large_motion_does_not_count_what_lies_outside(curve):
    places = curve[1].places_outside
    assert [curve[1].points[k].point.omega < LOW for k in places] == [True] * len(places)
    assert len(places) + len(curve[1].inside) == len(curve[1].points)
