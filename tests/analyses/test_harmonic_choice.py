"""The choice of H: it sees what two small H that agree with each other hide."""

from dataclasses import replace

import numpy as np
import pytest

import stickslip as ss
from stickslip.analyses.forced_response import forced_response
from stickslip.analyses.harmonic_choice import sufficient_harmonics, watched
from stickslip.model.loads import Output
from stickslip.model.rigs import chain_of_three, lumped_blisk, single_blade, single_mass
from stickslip.solve.balance.balance import HarmonicBalance
from stickslip.solve.continuation.truncation import resolved, truncation_at
from stickslip.solve.curves.curve import solve_curve
from stickslip.solve.peaks.climb import plane_at
from stickslip.support.checks import InputError
from stickslip.support.units import hertz


def point(problem, frequency, level, harmonics, samples=256):
    balance = HarmonicBalance(problem, harmonics, samples)
    omega = 2.0 * np.pi * frequency
    return balance, solve_curve(balance, (omega, omega), level, exactly=True).points[0].evaluation


def amplitude(balance, evaluation):
    return float(np.hypot(*evaluation.w[balance.rows, 1:3]))


def test_small_harmonics_agree_and_are_wrong_on_the_blade_and_the_estimate_says_so():
    """20 N at 543.45 Hz: H 3, 5 and 7 differ by 0.2 % and are 2 % off, for harmonics 11 to 13 fall on modes of the dampers."""
    rig = single_blade(4.6)
    finer = HarmonicBalance(rig, 31, 256)
    few = {H: point(rig, 543.45, 20.0, H) for H in (3, 5, 7)}
    sizes = [amplitude(*solved) for solved in few.values()]
    true = amplitude(finer, resolved(finer, few[7][1]).evaluation)
    assert np.ptp(sizes) < 2.5e-3 * sizes[0]
    assert min(abs(size / true - 1.0) for size in sizes) > 0.015
    estimates = [
        truncation_at(balance, finer, evaluation, plane_at(balance, evaluation).at(0.0)) for balance, evaluation in few.values()
    ]
    assert all(estimate.total > 8e-3 for estimate in estimates)
    assert 1 + np.argmax(estimates[2].share) in (11, 12, 13)


def test_the_chosen_number_is_right_to_the_tolerance():
    rig = single_blade(4.6)
    choice = sufficient_harmonics(rig, (541.0, 546.0), [20.0], tolerance=2e-3)
    assert 13 <= choice.harmonics <= 25
    assert choice.truncation_error <= 2e-3
    assert f"harmonic {choice.harmonics} at " in choice.sentence, "not the fifth, which moves most and is not enough"
    assert "near the stuck mode at" in choice.sentence
    chosen, many = point(rig, 543.45, 20.0, choice.harmonics), HarmonicBalance(rig, 31, 256)
    true = amplitude(many, resolved(many, chosen[1]).evaluation)
    assert amplitude(*chosen) == pytest.approx(true, rel=4e-3)


@pytest.mark.nightly
def test_a_tighter_tolerance_asks_for_more_and_gives_a_better_answer():
    problem = chain_of_three()
    reference = forced_response(problem, hertz(0.127, 0.32), harmonics=31, samples=512).peaks()["amplitude"].max()
    errors, numbers = [], []
    for tolerance in (0.3, 1e-2, 1e-3):
        response = forced_response(problem, hertz(0.127, 0.32), harmonics="auto", samples=512, tolerance=tolerance)
        numbers.append(response.dataset.attrs["harmonics"])
        errors.append(abs(response.peaks()["amplitude"].max() / reference - 1.0))
    assert numbers == sorted(numbers)
    assert numbers[0] < numbers[2]
    assert errors[2] < 1e-3


def test_samples_are_doubled_until_their_error_is_below_the_tolerance():
    problem = single_mass()
    choices = [sufficient_harmonics(problem, (0.08, 0.32), [1.0], tolerance) for tolerance in (2e-3, 1e-4, 3e-5)]
    assert [choice.samples for choice in choices] == [256, 512, 1024]
    assert [choice.sampling[:12] for choice in choices] == ["", "512 samples:", "1024 samples"]
    peaks = [
        forced_response(problem, hertz(0.08, 0.32), harmonics=7, samples=Nt).peaks()["amplitude"].max() for Nt in (512, 8192)
    ]
    assert peaks[0] == pytest.approx(peaks[1], rel=1e-4)


def test_an_output_that_does_not_move_chooses_nothing():
    problem = chain_of_three()
    still = replace(problem, outputs=(*problem.outputs, Output("none", {problem.structure.dofs[0]: 1e-12})))
    alone, both = (sufficient_harmonics(each, (0.127, 0.32), [1.0], 1e-3) for each in (problem, still))
    assert both.truncation_error == pytest.approx(
        alone.truncation_error, rel=1e-8
    )  # one more row changes the rounding of the others
    assert replace(both, truncation_error=alone.truncation_error) == alone


def test_samples_that_do_not_suffice_are_said_and_too_few_refused():
    choice = sufficient_harmonics(single_mass(), (0.08, 0.32), [1.0], 1e-7)
    assert choice.samples >= 8192
    assert "samples, the most that are tried" in choice.sentence
    with pytest.raises(InputError, match="samples must be at least 8"):
        sufficient_harmonics(single_mass(), (0.08, 0.32), [1.0], samples=7)


def rubbing_on_stiff_sliders(kt, limit):
    """Two masses, the first on a slider that is far stiffer than the springs."""
    structure = ss.Structure(np.eye(2), np.array([[2.0, -1.0], [-1.0, 1.0]]), ("1.x", "2.x"), damping=ss.ModalDamping(0.01))
    slider = ss.Contact("slider", ss.Macroslip(kt=kt, mu=0.5, normal_load=2.0 * limit), (ss.between("1.x", "ground"),))
    return ss.Problem(structure, (slider,), (ss.Force("1.x", 1.0),), ("2.x",))


@pytest.mark.parametrize("kt", [1e4, 1e5])
def test_stiff_sliders_are_right_to_the_tolerance_or_said_not_to_be(kt):
    """Seen through the receptance of the stuck structure no left-out force moves anything: 3 harmonics passed for enough."""
    problem, tolerance = rubbing_on_stiff_sliders(kt, 0.85), 1e-2
    choice = sufficient_harmonics(problem, [0.098], [1.0], tolerance)
    few, chosen, many = (amplitude(*point(problem, 0.098, 1.0, H, 1024)) for H in (3, choice.harmonics, 41))
    assert abs(few / many - 1.0) > 0.1
    assert abs(chosen / many - 1.0) < tolerance or "most tried" in choice.sentence


def test_a_peak_that_more_harmonics_move_away_is_swept_for():
    """On a disk of the case W the peak at 3 harmonics leads to none at 8, where the curve has two peaks."""
    choice = sufficient_harmonics(lumped_blisk(case="W", engine_order=2), (140.0, 156.0), [0.4], samples=264)
    assert choice.harmonics >= 8
    assert choice.truncation_error <= 2e-3


def test_the_whole_curve_is_right_to_the_tolerance_not_its_peak_alone():
    """On a cubic spring the resonance needs 5 harmonics, but those of harmonics 3 and 5 of the force, far below it, need 7."""
    structure = ss.Structure(np.eye(1), np.eye(1), ("m.x",), damping=ss.ModalDamping(0.01))
    spring = ss.Contact("spring", ss.CubicSpring(3.0), (ss.between("m.x", "ground"),))
    problem = ss.Problem(structure, (spring,), (ss.Force("m.x", 1.0),), ("m.x",))
    choice = sufficient_harmonics(problem, (0.03, 0.35), [0.5], tolerance=1e-2, samples=64)
    errors = [
        forced_response(problem, hertz(0.03, 0.35), 0.5, harmonics=H, samples=64).dataset["point_truncation_error"].max()
        for H in (5, choice.harmonics)
    ]
    assert errors[0] > 0.04
    assert errors[1] < 1e-2
    assert sufficient_harmonics(problem, (0.15, 0.35), [0.5], tolerance=1e-2, samples=64).harmonics == 3


def test_a_detached_curve_chooses_too():
    """A stop 20 times as stiff as the blade: the sweep stays below it and needs 3 harmonics, the detached curve strikes it."""
    M, K, C = np.diag([2.0, 0.06]), np.array([[1166713.0, -29713.0], [-29713.0, 29713.0]]), np.array([[2.3, -2.0], [-2.0, 2.0]])
    stop = ss.Contact("stop", ss.Gap(kn=2e7, gap=150e-6), normal={"blade.x": 1.0})
    blade = ss.Structure(M, K, ("blade.x", "absorber.x"), C=C)
    problem = ss.Problem(blade, (stop,), (ss.Force("blade.x", 1.0),), ("blade.x",))
    response = ss.forced_response(problem, ss.hertz(90.0, 220.0), 4.6, harmonics="auto")
    assert response.dataset.sizes["case"] == 2
    assert response.dataset["truncation_error"].max() < 4e-3
    assert sufficient_harmonics(problem, (90.0, 220.0), [4.6]).harmonics == 3
    assert len(response.dataset["harmonic"]) > 4


def test_a_stuck_contact_needs_no_more_than_the_least():
    assert sufficient_harmonics(single_mass(limit=1e6), (0.1, 0.3), [1.0]).harmonics == 3


@pytest.mark.parametrize("tolerance", [0.0, -1.0, 0.7, float("nan")])
def test_a_tolerance_without_sense_is_refused(tolerance):
    with pytest.raises(InputError, match="tolerance"):
        sufficient_harmonics(single_mass(), (0.1, 0.3), [1.0], tolerance)


def test_a_choice_is_watched():
    """Level by level, to the end of the curve of each; nobody watches afterwards."""
    seen = []
    with watched(lambda fraction, text: seen.append((fraction, text))):
        sufficient_harmonics(single_mass(), [0.1, 0.3], [1.0, 2.0])
    assert [fraction for fraction, _ in seen] == sorted(fraction for fraction, _ in seen)
    assert list(dict.fromkeys(text for _, text in seen)) == ["force level 1", "force level 2"]
    assert 0.7 < seen[-1][0] <= 1.0
    count = len(seen)
    sufficient_harmonics(single_mass(), [0.1, 0.3], [1.0])
    assert len(seen) == count
