"""Loops of a single contact: the law that made them is chosen, and its kt and mu are found to 3 %."""

import numpy as np
import pytest
from scipy.stats import lognorm

from stickslip.laboratory.identification.contact_law.fit import (
    SEGMENTS,
    ContactLoop,
    LoopFit,
    array_weights,
    errors_of_motion,
    errors_of_scatter,
    first_guess,
)
from stickslip.laboratory.identification.contact_law.work import LawFit, contact_law, share_in_slip
from stickslip.laboratory.identification.least_squares import Solution
from stickslip.support.checks import InputError
from verify.identification import loop_of

PLACE = (np.arange(400) + 0.5) / 400
ELLIPSE = np.sqrt(1.0 - PLACE**2) / np.mean(np.sqrt(1.0 - PLACE**2))
TRUTHS = {"jenkins": np.ones(1), "iwan": ELLIPSE, "array": array_weights(np.array([0.8]))}


def loops(law, seed, amplitudes=(2e-6, 4e-6, 8e-6, 16e-6)):
    """Four loops with the errors of a rig: gain 1 %, zeros 0.8 N, noise of cell and laser after the mean of 20 cycles."""
    generator = np.random.default_rng(seed)
    gain, found = 1.0 + 0.01 * generator.standard_normal(), []
    for amplitude in amplitudes:
        u, f = loop_of(TRUTHS[law], 20e6, 0.4, 100.0, amplitude)
        u = u + 0.08e-6 / np.sqrt(20.0) * generator.standard_normal(u.size)
        f = gain * f + 0.05 * generator.standard_normal(u.size) + 0.8 * generator.standard_normal()
        found.append(ContactLoop(u, f, 100.0, f"{amplitude * 1e6:g} um"))
    return found


def test_limits_of_an_array_fall_evenly_to_what_the_spread_leaves():
    weights = array_weights(np.array([0.8]))
    assert weights.mean() == pytest.approx(1.0, rel=1e-14)
    assert weights[-1] / weights[0] == pytest.approx(0.2, rel=1e-14)
    np.testing.assert_allclose(np.diff(weights), np.diff(weights)[0], rtol=1e-12)


def test_the_search_begins_at_the_slider_that_made_the_loop():
    loop = ContactLoop(*loop_of(np.ones(1), 20e6, 0.4, 100.0, 16e-6), 100.0)
    assert np.exp(first_guess([loop], "jenkins")) == pytest.approx([20e6, 0.4], rel=0.01)


def test_a_slider_slips_but_for_its_elastic_travel():
    """W = 4 μN (A − μN/kt) of at most 4 μN A."""
    loop = ContactLoop(*loop_of(np.ones(1), 20e6, 0.4, 100.0, 16e-6), 100.0)
    assert share_in_slip(loop, 0.4) == pytest.approx(1.0 - 0.4 * 100.0 / (20e6 * 16e-6), rel=1e-3)


def solution(residuals, jacobian, x=(0.0,)):
    return Solution(np.array(x), float(residuals @ residuals), residuals, jacobian, True)


@pytest.mark.parametrize("harmonics", [None, 7])
def test_the_error_of_a_mean_of_white_noise_is_that_of_its_independent_values(harmonics):
    """Residuals ±σ in turn say nothing within a segment. A mean of n values errs by σ/√(n − 1); of a loop smoothed to H
    harmonics, 2H values are independent."""
    loop = ContactLoop(*loop_of(np.ones(1), 20e6, 0.4, 100.0, 8e-6), 100.0, harmonics=harmonics)
    size = np.size(loop.displacement)
    assert size % (2 * SEGMENTS) == 0
    noise, free = 0.3 * (-1.0) ** np.arange(size), (size if harmonics is None else 2 * harmonics) - 1
    assert errors_of_scatter(solution(noise, np.ones((size, 1))), [loop]) == pytest.approx([0.3 / np.sqrt(free)], rel=1e-12)


def test_residuals_alike_within_a_segment_count_once():
    """The error of a mean of so many values is their standard deviation over √n, by segments of two loops."""
    loop = ContactLoop(*loop_of(np.ones(1), 20e6, 0.4, 100.0, 8e-6), 100.0)
    means = np.random.default_rng(1).standard_normal(2 * SEGMENTS)
    means -= means.mean()
    left = np.repeat(means, np.size(loop.displacement) // SEGMENTS)
    expected = means.std(ddof=1) / np.sqrt(means.size)
    assert errors_of_scatter(solution(left, np.ones((left.size, 1))), [loop, loop]) == pytest.approx([expected], rel=1e-12)


def test_noise_of_the_displacement_is_an_error_of_the_stiffness_of_a_stuck_contact():
    """u = X sin θ and F = kt u: an error e of X alone changes ln kt by e/X; the limit is out of reach."""
    angle, X = 2.0 * np.pi * np.arange(200) / 200, 1e-6
    u, ends = X * np.sin(angle), np.log([[0.99 * 20e6, 0.4], [1.01 * 20e6, 0.4]])
    loop = ContactLoop(u, 20e6 * u, 1000.0, displacement_error=np.array([0.002 * X]))
    fit = LoopFit([loop], "jenkins", ends[0])
    by_kt = (fit.residuals(ends[0]) - fit.residuals(ends[1])) / (ends[1, 0] - ends[0, 0])
    jacobian = np.stack([by_kt, np.zeros(200)], axis=1)
    found = errors_of_motion(solution(np.zeros(200), jacobian, np.log([20e6, 0.4])), [loop], "jenkins")
    assert found == pytest.approx([0.002, 0.0], rel=0.4, abs=1e-12)


def test_intervals_hold_95_per_cent_of_a_lognormal_distribution():
    fit = LawFit("jenkins", 20e6, 0.4, (), (0.1, 0.02), 0.0, 0.0)
    for (low, high), value, error in ((fit.kt_interval, 20e6, 0.1), (fit.mu_interval, 0.4, 0.02)):
        distribution = lognorm(error, scale=value)
        assert [distribution.cdf(low), distribution.cdf(high)] == pytest.approx([0.025, 0.975], abs=1e-4)


@pytest.mark.parametrize("law", TRUTHS)
def test_the_law_and_its_parameters_are_found(law):
    choice = contact_law(loops(law, 1))
    assert choice.best == law
    assert choice.fits[law].kt == pytest.approx(20e6, rel=0.03)
    assert choice.fits[law].mu == pytest.approx(0.4, rel=0.03)


def dahl_loop(kt, limit, amplitude, samples=400):
    """u and T of the steady cycle, T from rest by small steps of dT = kt (1 − s T/L) du, cycle after cycle."""
    u, traction, found = amplitude * np.sin(2.0 * np.pi * np.arange(samples) / samples), 0.0, np.empty(samples)
    for _ in range(20):
        for n in range(samples):
            du = u[n] - u[n - 1]
            middle = traction + 0.5 * kt * (1.0 - np.sign(du) * traction / limit) * du
            traction += kt * (1.0 - np.sign(du) * middle / limit) * du
            found[n] = traction
    return u, found


def test_a_contact_that_yields_from_the_first_motion_on_is_recognised():
    """With the errors of `loops`: the law and, to 3 %, its kt and μ."""
    generator, measured = np.random.default_rng(3), []
    for amplitude in (2e-6, 4e-6, 8e-6, 16e-6):
        u, f = dahl_loop(20e6, 0.4 * 100.0, amplitude)
        u = u + 0.08e-6 / np.sqrt(20.0) * generator.standard_normal(u.size)
        measured.append(ContactLoop(u, f + 0.05 * generator.standard_normal(u.size) + 0.8 * generator.standard_normal(), 100.0))
    choice = contact_law(measured)
    assert choice.best == "dahl"
    assert choice.fits["dahl"].kt == pytest.approx(20e6, rel=0.03)
    assert choice.fits["dahl"].mu == pytest.approx(0.4, rel=0.03)


def test_the_shape_of_valanis_law_is_found():
    """From loops by small steps of dT = kt (1 − s T/L)/(1 − κ s T/L) du at four amplitudes, with the errors of `loops`."""
    generator, measured, kt, limit, kappa = np.random.default_rng(5), [], 20e6, 0.4 * 100.0, 0.8
    for amplitude in (2e-6, 4e-6, 8e-6, 16e-6):
        u, traction, f = amplitude * np.sin(2.0 * np.pi * np.arange(400) / 400), 0.0, np.empty(400)
        for n in np.tile(np.arange(400), 4):
            for _ in range(10):
                share = np.sign(u[n] - u[n - 1]) * traction / limit
                traction += 0.1 * kt * (1.0 - share) / (1.0 - kappa * share) * (u[n] - u[n - 1])
            f[n] = traction
        u = u + 0.08e-6 / np.sqrt(20.0) * generator.standard_normal(u.size)
        measured.append(ContactLoop(u, f + 0.05 * generator.standard_normal(u.size) + 0.8 * generator.standard_normal(), 100.0))
    choice = contact_law(measured, laws=["dahl", "valanis"])
    assert choice.best == "valanis"
    fit = choice.fits["valanis"]
    assert (fit.kt, fit.mu) == pytest.approx((kt, 0.4), rel=0.05)
    assert fit.shape[0] == pytest.approx(kappa, abs=0.1)


def test_too_little_motion_is_said():
    choice = contact_law(loops("iwan", 2, (1e-6, 2e-6)))
    assert any("mu is a lower bound" in sentence for sentence in choice.warnings)


def noisy(force):
    return force + 0.3 * np.random.default_rng(0).standard_normal(force.size)


@pytest.mark.parametrize(
    ("change", "words"),
    [
        (lambda u, f: (u, -f, 100.0), "sign reversed"),
        (lambda u, f: (1e6 * u, f, 100.0), "Is its unit right"),
        (lambda u, f: (u, 1e3 * f, 100.0), "Is a unit wrong"),
        (lambda u, f: (u, 1e-3 * f, 100.0), "in kN it would be 0.4"),
        (lambda u, f: (u, np.clip(noisy(f), -30.0, 30.0), 100.0), "must not be clipped"),
        (lambda u, f: (u, 0.0 * f, 100.0), "constant"),
        (lambda u, f: (u, f * np.nan, 100.0), "finite"),
        (lambda u, f: (u[:20], f[:20], 100.0), "at least 40"),
        (lambda u, f: (u, f, -3.0), "Normal load"),
    ],
)
def test_bad_loops_are_refused(change, words):
    with pytest.raises(InputError, match=words):
        ContactLoop(*change(*loop_of(np.ones(1), 20e6, 0.4, 100.0, 8e-6)))


def test_one_loop_cannot_choose_but_fits_a_law_that_is_named():
    one = loops("jenkins", 0)[-1:]
    for few, words in ((one, "at least two"), ([], "at least one")):
        with pytest.raises(InputError, match=words):
            contact_law(few)
    choice = contact_law(one, laws=["jenkins"])
    assert choice.best == "jenkins"
    assert choice.fits["jenkins"].mu == pytest.approx(0.4, rel=0.03)
    assert np.isnan(choice.fits["jenkins"].held_out)
    assert str(choice.fits["jenkins"]).count("held out") == 0


def test_the_answer_is_a_few_lines():
    found = repr(contact_law(loops("iwan", 1)))
    assert "iwan: kt = " in found
    assert len(found.splitlines()) <= 8
    assert "held out" in found
