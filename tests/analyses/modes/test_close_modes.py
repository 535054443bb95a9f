"""Warnings where other modes are near, the phase of a mode, and what modes refuse."""

import numpy as np
import pytest

import stickslip as ss
from stickslip.analyses.modes.work import CONSIDERABLE, with_peaks
from stickslip.show.report.nonlinear_modes import sentences


def two_masses(coupling):
    """Equal masses on sliders, one of them excited: with a weak coupling their two modes are close."""
    K = np.array([[1.0 + coupling, -coupling], [-coupling, 1.0 + coupling]])
    structure = ss.Structure(np.eye(2), K, ("1.x", "2.x"), C=0.02 * np.eye(2))
    law = ss.Macroslip(0.5, 1.0, normal_load=1.0)
    sliders = [ss.Contact(f"{n}", law, (ss.between(f"{n}.x", "ground"),)) for n in (1, 2)]
    return ss.Problem(structure, sliders, (ss.Force("1.x", 1.0),), ("1.x", "2.x"))


def three_masses():
    """A chain with a slider to the ground and one between its ends, whose mode 3 takes the other modes along."""
    K = 1e5 * np.array([[2.0, -1.0, 0.0], [-1.0, 2.0, -1.0], [0.0, -1.0, 1.0]])
    M = np.diag([1.0, 1.0, 0.8])
    structure = ss.Structure(M, K, ("1.x", "2.x", "3.x"), C=1e-5 * K + 0.4 * M)
    laws = ss.Macroslip(3e4, 0.4, normal_load=50.0), ss.Macroslip(5e4, 0.3, normal_load=20.0)
    sliders = [
        ss.Contact("a", laws[0], (ss.between("2.x", "ground"),)),
        ss.Contact("b", laws[1], (ss.between("3.x", "1.x"),)),
    ]
    return ss.Problem(structure, sliders, (ss.Force("3.x", 1.0),), ("3.x", "1.x"))


@pytest.mark.parametrize("coupling", [1e-3, 0.5])
def test_other_modes_come_with_a_warning_where_peaks_are_wrong(coupling):
    problem, close = two_masses(coupling), coupling < 0.01
    modes = ss.nonlinear_modes(problem, 1, harmonics=3, samples=64)
    swept = ss.forced_response(problem, ss.radians_per_second(0.7, 1.9), 0.5, harmonics=3, samples=64)
    wrong = float(modes.against(swept)["difference"].abs().max())
    warned = str(modes.dataset.synthesis_warning.values[0])
    assert "other modes contribute" in warned
    assert any("other modes contribute" in line for line in sentences(modes.dataset))
    assert (modes.peaks([0.5])["other_modes"][0] > 0.5) == close
    assert wrong > 0.5 if close else wrong < 0.15


def test_modes_far_from_others_have_no_warning():
    for problem, ends in ((ss.rigs.single_mass(), None), (ss.rigs.chain(), (3.0, 4.9))):
        modes = ss.nonlinear_modes(problem, 1, ends, harmonics=3, samples=64)
        assert modes.dataset.synthesis_warning.values[0] == ""


def test_a_mode_whose_peaks_are_off_by_several_percent_has_a_warning():
    problem = three_masses()
    modes = ss.nonlinear_modes(problem, 3, harmonics=5, samples=128)
    swept = ss.forced_response(problem, ss.hertz(85.0, 105.0), [10.0, 20.0], harmonics=5, samples=128)
    assert modes.against(swept)["difference"].abs().min() > 0.04
    assert (modes.peaks([10.0, 20.0])["other_modes"] < 0.2).all()
    assert "other modes contribute" in modes.dataset.synthesis_warning.values[0]


@pytest.mark.slow
def test_peaks_of_modes_without_a_warning_are_right():
    """The three masses at mode 1, where the other modes move by less than 5 %: within 1.3 %."""
    problem, levels = three_masses(), [1.0, 2.5, 7.0]
    modes = ss.nonlinear_modes(problem, 1, harmonics=5, samples=128)
    assert (modes.peaks(levels)["other_modes"] < CONSIDERABLE).all()
    swept = ss.forced_response(problem, ss.hertz(20.0, 33.0), levels, harmonics=5, samples=128)
    assert modes.against(swept)["difference"].abs().max() < 0.013


@pytest.mark.parametrize(("mode", "levels", "band"), [(3, [10.0, 20.0], (85.0, 105.0)), (1, [2.5, 7.0], (20.0, 33.0))])
def test_peaks_solved_from_a_mode_are_those_of_a_sweep(mode, levels, band):
    """Where the synthesis is 7.6 % low, and where it is 0.5 and 1.0 % low with indicators below 5 %."""
    problem = three_masses()
    modes = ss.nonlinear_modes(problem, mode, harmonics=5, samples=128)
    swept = ss.forced_response(problem, ss.hertz(*band), levels, harmonics=5, samples=128).peaks()
    for output, name in enumerate(problem.output_names):
        found = modes.peaks(levels, output=output)["solved_amplitude"]
        highest = swept[swept["output"] == name].groupby("force_level")["amplitude"].max()
        np.testing.assert_allclose(found, highest, rtol=1e-3)


def test_a_result_says_how_far_its_peaks_are_off_and_by_which_definition():
    problem = three_masses()
    modes = ss.nonlinear_modes(problem, 3, harmonics=5, samples=128)
    dataset = with_peaks(modes.dataset, problem, [10.0, 20.0])
    said = str(dataset.synthesis_warning.values[0])
    assert "Peaks that are solved as forced motions differ from the synthesised ones by up to 8.2 % (force level 20)" in said
    lines = sentences(dataset)
    assert any("solved" in line for line in lines)
    assert 'extended = "all"' in lines[-1]


def test_the_phase_at_an_output():
    """The same motion, moved in time: the output is a cosine, sizes and peaks stay."""
    problem = ss.rigs.chain(5, sliders=(3, 5), forced=2)
    plain, turned = (ss.nonlinear_modes(problem, 2, harmonics=3, samples=64, phase_at=phase_at).dataset for phase_at in (None, 0))
    first = turned.response.values[0, :, 0, 1]
    np.testing.assert_allclose(first[:, 1], 0.0, atol=1e-12 * np.abs(first).max())
    assert (first[:, 0] > 0.0).all()
    assert np.abs(np.angle(plain.response.values[0, :, 0, 1] @ [1.0, 1.0j])).max() > 1e-3
    for name in ("amplitude", "peak_amplitude", "frequency", "damping_ratio"):
        np.testing.assert_array_equal(turned[name], plain[name])
    # As a motion in time: x(t) of one is x(t + τ) of the other.
    X = [each.contact_force.values[0, -1, 0, 0] @ [1.0, 1.0j] for each in (plain, turned)]
    angle = -np.angle(plain.response.values[0, -1, 0, 1] @ [1.0, 1.0j])
    np.testing.assert_allclose(X[1], X[0] * np.exp(1j * angle * np.arange(4)), atol=1e-12)


def test_what_a_mode_refuses():
    problem = ss.rigs.single_mass()
    with pytest.raises(ss.InputError, match="forced response chooses"):
        ss.nonlinear_modes(problem, 1, harmonics="auto")
    with pytest.raises(ss.InputError, match="phase_at"):
        ss.nonlinear_modes(problem.with_start(ss.TractionRatio(0.5)), 1, amplitude=(0.5, 2.0), phase_at=0)
    with pytest.raises(ss.InputError, match="phase_at must be 0 to 0"):
        ss.nonlinear_modes(problem, 1, phase_at=4)
