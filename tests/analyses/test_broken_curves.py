"""Curves that break off: how far they got, how the rest can be had, and what `at` gives where they did not get."""

from dataclasses import replace

import numpy as np
import pytest

import stickslip as ss
from robustness.ill_posed import HELD_BY_FRICTION, structure
from robustness.problems import random_case
from robustness.run import HARMONICS, SAMPLES, cause_of
from stickslip.solve.balance.balance import HarmonicBalance
from stickslip.solve.continuation import continuation, sweep
from stickslip.solve.continuation.continuation import TURNED_BACK, trace
from stickslip.solve.continuation.newton import correct, fixed
from stickslip.solve.continuation.steps import StepControl
from stickslip.solve.curves import curve
from stickslip.solve.curves.curve import solve_curve, with_peaks
from stickslip.support.outcome import Outcome

LEVEL = 1.0
BAND = ss.radians_per_second(0.5, 2.0)


@pytest.fixture
def few_points(monkeypatch):
    """Curves of at most ten points, none of which reaches the end of its band."""

    def short(balance, first, parameter, end, control=None):
        return trace(balance, first, parameter, end, StepControl(points=10))

    monkeypatch.setattr(sweep, "trace", short)


@pytest.mark.parametrize(("start", "stop"), [(0.5, 2.0), (2.0, 0.5)])
def test_a_curve_of_too_many_points_says_where_it_got_to_and_how_to_go_on(start, stop):
    balance = HarmonicBalance(ss.rigs.single_mass(), 3, 64)
    control = StepControl(points=10)
    found = curve.solve_curve(balance, [start, stop], LEVEL, exactly=False, control=control)
    reached = found.points[-1].point.omega
    assert found.outcome == Outcome.NOT_CONVERGED
    assert found.message == (
        f"The curve was not finished within 10 points. The sweep stopped at {reached / (2.0 * np.pi):.6g} Hz. For the rest, "
        "sweep from the other end of the band, start a new band beyond, or list single frequencies there (`at` in a study)."
    )
    assert cause_of(found.message) == "The curve was not finished within 10 points."
    assert cause_of(curve.ARRIVED) == curve.ARRIVED
    rest = curve.solve_curve(balance, [(1.001 if stop > start else 0.999) * reached, stop], LEVEL, exactly=False)
    assert rest.outcome == Outcome.CONVERGED


@pytest.mark.parametrize("steps", [5, 300])
def test_a_curve_that_gets_no_further_in_its_folds_is_lost_and_not_traced_with_shorter_steps(monkeypatch, steps):
    """Around a peak of damping ratio 1e-6 more than five points lie within a hundred-thousandth of the band."""
    monkeypatch.setattr(continuation, "FOLDING_STEPS", steps)
    traced = []
    monkeypatch.setattr(sweep, "trace", lambda *given: traced.append(given) or trace(*given))
    balance = HarmonicBalance(ss.rigs.single_mass(damping=2e-6), 3, 64)
    found = curve.solve_curve(balance, [0.5, 2.0], 1e-8 * LEVEL, exactly=False)
    assert (found.outcome, cause_of(found.message)) == {
        5: (Outcome.NOT_CONVERGED, continuation.FOLDS),
        300: (Outcome.CONVERGED, curve.ARRIVED),
    }[steps]
    assert [given[-1].reversible for given in traced] == {5: [False, False], 300: [False]}[steps]


@pytest.mark.parametrize(("start", "stop"), [(0.5, 2.0), (2.0, 0.5)])
def test_a_list_is_begun_anew_where_a_curve_ends(start, stop):
    balance, wanted = HarmonicBalance(ss.rigs.single_mass(), 3, 64), [start, 0.5 * (start + stop), stop]
    found = curve.solve_curve(balance, wanted, LEVEL, exactly=True, control=StepControl(points=10))
    whole = curve.solve_curve(balance, wanted, LEVEL, exactly=True)
    assert found.outcome == Outcome.CONVERGED
    assert found.message.startswith("The curve was begun anew at ")
    assert found.message.endswith(" of 3 frequencies. The curve was not finished within 10 points.")
    for one, other in zip(found.points, whole.points, strict=True):
        np.testing.assert_allclose(one.evaluation.w, other.evaluation.w, atol=1e-9)


@pytest.mark.nightly
def test_a_curve_that_turns_back_says_where_and_the_rest_can_be_had():
    """The first branch ends at a fold: the largest frequency of its points; beyond, from somewhere, the end is reached."""
    case = random_case("start state", 207)
    balance = HarmonicBalance(case.problem, HARMONICS, SAMPLES)
    ends = [2.0 * np.pi * f for f in (case.band.start, case.band.stop)]
    found = curve.solve_curve(balance, ends, case.level, exactly=False)
    farthest = max(point.point.omega for point in found.points)
    assert found.points[-1].point.omega < 0.9 * farthest
    words = f"{TURNED_BACK} The sweep stopped at {farthest / (2.0 * np.pi):.6g} Hz. For the rest, sweep from the other end"
    assert found.message.startswith(words)
    beyond = [curve.solve_curve(balance, [start, ends[1]], case.level, exactly=False) for start in (1.1, 1.3, 1.5)]
    assert Outcome.CONVERGED in [each.outcome for each in beyond]


@pytest.mark.usefixtures("few_points")
def test_frequencies_that_a_broken_curve_does_not_reach_have_no_value_but_its_outcome():
    problem = ss.rigs.single_mass()
    broken = ss.forced_response(problem, BAND, force=LEVEL)
    assert broken.dataset["case_outcome"].values.tolist() == [Outcome.NOT_CONVERGED]
    got = float(np.nanmax(broken.dataset["frequency"]))
    assert got < 0.6 * BAND.stop
    wanted = [0.9 * got, 1.1 * got, BAND.stop, BAND.start]
    at = broken.at(wanted)
    reached = np.array([True, False, False, True])
    assert at["outcome"].values[0, 0].tolist() == [1, Outcome.NOT_CONVERGED, Outcome.NOT_CONVERGED, 1]
    for name in ("response", "amplitude", "rms", "max_abs", "error"):
        values = at[name].values[0, 0]
        assert np.isfinite(values[reached]).all()
        assert np.isnan(values[~reached]).all()
    for outside in (0.99 * BAND.start, 1.01 * BAND.stop):
        with pytest.raises(ss.InputError, match=r"in the band of the response, from 0\.0795775 to 0\.31831 Hz"):
            broken.at([got, outside])


@pytest.mark.usefixtures("few_points")
def test_a_downward_curve_that_breaks_off_has_no_values_below():
    broken = ss.forced_response(ss.rigs.single_mass(), ss.radians_per_second(2.0, 0.5), force=LEVEL)
    at = broken.at([BAND.start, BAND.stop])
    assert at["outcome"].values[0, 0].tolist() == [Outcome.NOT_CONVERGED, 1]


def test_the_band_of_finished_curves_is_theirs():
    """Of a single frequency nothing beside it was asked for, although linear curves are drawn around it."""
    single = ss.forced_response(ss.rigs.single_mass(), [0.1], force=LEVEL)
    assert single.at([0.1])["outcome"].values.tolist() == [[[1]]]
    with pytest.raises(ss.InputError, match=r"in the band of the response, from 0\.1 to 0\.1 Hz"):
        single.at([0.101])


@pytest.mark.nightly
@pytest.mark.usefixtures("few_points")
def test_a_lost_curve_names_what_may_be_the_cause():
    def message(mu, kt=1.0):
        law = ss.Macroslip(kt=kt, mu=mu, kn=1.0, preload=1.0)
        problem = ss.rigs.chain_varying_load().with_contacts(lambda contact: contact.with_law(law))
        return str(ss.forced_response(problem, BAND, force=LEVEL).dataset["case_message"].values[0])

    assert "friction" not in message(0.5)
    assert "there (`at` in a study). Large friction coefficients (" in message(1e4)
    assert "up to mu = 1e+04" in message(1e4)
    assert "there (`at` in a study). Very stiff contacts (" in message(0.5, kt=1e4)


def test_a_curve_without_any_point_names_what_may_be_the_cause():
    """A traction ratio takes away the friction that alone holds the second mass; stiff is the contact of the first."""
    first, second = (ss.between(name, "ground") for name in ("1.x", "2.x"))
    free = ss.Contact("free", ss.Macroslip(kt=1.0, mu=0.5, normal_load=1.0), (second,), start=ss.TractionRatio(0.5))
    stiff = ss.Contact("stiff", ss.Macroslip(kt=2e4, mu=0.5, normal_load=1.0), (first,))
    problem = ss.Problem(structure(K=HELD_BY_FRICTION), (free, stiff), (ss.Force("1.x", 1.0),), ("2.x",))
    found = ss.forced_response(problem, BAND, harmonics=3, samples=64).dataset
    assert found["case_outcome"].values.tolist() == [Outcome.BODY_HELD_BY_NOTHING]
    sentence, cause = Outcome.BODY_HELD_BY_NOTHING.sentence, "Very stiff contacts (stiff): up to 2e+04 times what they join."
    assert str(found["case_message"].values[0]).startswith(f"{sentence} {cause}")


@pytest.mark.parametrize(("gap", "force"), [(1e-3, 1e-9), (10.0, 1e-7), (1e3, 1e-7)])
def test_a_gap_far_wider_than_the_motion_changes_nothing(gap, force):
    """The forces of the gap cancel but for their rounding, which is no residual of the motion: the response is linear."""
    structure = ss.Structure(np.eye(2), np.array([[2.0, -1.0], [-1.0, 2.0]]), ("1.x", "2.x"), C=0.02 * np.eye(2))
    contact = ss.Contact("c", ss.Gap(0.5, gap=gap), (), ss.between("1.x", "ground"))
    band, load = ss.radians_per_second(0.5, 2.5), (ss.Force("1.x", 1.0),)
    gapped = ss.forced_response(ss.Problem(structure, (contact,), load, ("1.x",)), band, force, harmonics=3)
    linear = ss.forced_response(ss.Problem(structure, (), load, ("1.x",)), band, force, harmonics=3)
    assert int(gapped.dataset.case_outcome[0]) == ss.Outcome.CONVERGED
    np.testing.assert_allclose(gapped.peaks().amplitude, linear.peaks().amplitude, rtol=1e-5)


@pytest.mark.parametrize(
    ("start", "outcome"),
    [(ss.SliderOffset(), ss.Outcome.STATIC_NOT_FOUND), (ss.TractionRatio(0.5), ss.Outcome.NO_STATIC_EQUILIBRIUM)],
)
def test_only_a_prescribed_start_is_blamed_for_a_static_state_that_is_not_found(start, outcome, monkeypatch):
    balance = HarmonicBalance(ss.rigs.three_mass_wedge(start), 1, 16)
    point = balance.stuck_point(1400.0, 1.0)
    unsolved = correct(balance, point, fixed("omega", 1400.0), iterations=0)
    assert not unsolved.converged
    assert sweep.failure(balance, unsolved) == ss.Outcome.NOT_CONVERGED
    monkeypatch.setattr(sweep, "solve_cold", lambda *_: unsolved)
    assert sweep.failure(balance, unsolved) == outcome
    assert "may be" in outcome.sentence


@pytest.mark.usefixtures("few_points")
def test_a_lost_curve_without_damping_or_of_a_body_that_friction_alone_holds_says_so():
    chain = np.array([[1.0, -1.0], [-1.0, 1.0]])
    slider = ss.Contact("slider", ss.Macroslip(kt=0.5, mu=0.5, normal_load=1.0), (ss.between("1.x", "ground"),))

    def message(K, damping, level, band):
        structure = ss.Structure(np.eye(2), K, ("1.x", "2.x"), damping=damping)
        problem = ss.Problem(structure, (slider,), (ss.Force("1.x", 1.0),), ("1.x", "2.x"))
        return str(ss.forced_response(problem, ss.radians_per_second(*band), level, 3, 64).dataset.case_message.values[0])

    undamped = message(chain + np.eye(2), None, 1e-6, (0.3, 3.0))
    assert "The structure has no damping" in undamped
    assert "friction alone" not in undamped
    floating = message(chain, ss.ModalDamping(0.01), 1.0, (0.3, 3.0))
    assert "A body is held by friction alone" in floating
    assert "no damping" not in floating


def test_a_response_without_bound_has_no_peak_and_blames_no_friction():
    """An undamped mass at a gap: at large amplitudes its natural frequency is 2 · 1 · 2/(1 + 2) = 4/3, whatever the force. The
    curve went on among numbers of rounding, with 54 "peaks" of up to 2e16 m."""
    gap = ss.Contact("gap", ss.Gap(3.0, gap=1.0), normal=ss.between("1.x", "ground"))
    structure = ss.Structure(np.eye(1), np.eye(1), ("1.x",))
    problem = ss.Problem(structure, (gap,), (ss.Force("1.x", 0.025),), ("1.x",))
    response = ss.forced_response(problem, ss.radians_per_second(0.7, 1.6), harmonics=9, samples=64)
    message = str(response.dataset.case_message.values[0])
    assert message.startswith("The response grows without bound.")
    assert message.count("The structure has no damping") == 1
    assert "friction" not in message
    assert response.peaks().empty
    assert response.dataset.sizes["point"] < 500


@pytest.mark.parametrize("force", [0.1, 1.0, 5.0])
def test_a_body_that_drifts_ends_the_curve_at_once(force):
    """A free mass on a sliding one, in slip: its mean is anywhere. The curve went 8000 points along that family of solutions."""
    structure = ss.Structure(np.eye(2), np.diag([1.0, 0.0]), ("1.x", "2.x"), damping=ss.ModalDamping(0.01))
    contact = ss.Contact("c", ss.Macroslip(kt=1.0, mu=0.5, normal_load=1.0), (ss.between("1.x", "2.x"),))
    problem = ss.Problem(structure, (contact,), (ss.Force("1.x", 1.0),), ("2.x",))
    response = ss.forced_response(problem, ss.radians_per_second(0.5, 2.5), force, harmonics=1, samples=64).dataset
    assert response.sizes["point"] < 100
    assert "A body drifts: all contacts that hold it slip" in str(response.case_message.values[0])
    assert "Hold it by mean_springs" in str(response.case_message.values[0])


@pytest.mark.parametrize("level", [0.1, 0.5])
def test_a_body_that_friction_alone_holds_ends_its_curve(level):
    """A mass on a slider without any spring: where it slips all along, its mean could be anything. The frequency stood within
    3e-11 of itself for thousands of points. Rounding decides whether such a curve stands still or Newton's method fails."""
    structure_ = ss.Structure(np.eye(1), np.zeros((1, 1)), ["1.x"], C=0.02 * np.eye(1))
    slider = ss.Contact("slider", ss.Macroslip(kt=1.0, mu=1.0, normal_load=1.0), [ss.between("1.x", "ground")])
    problem = ss.Problem(structure_, [slider], [ss.Force("1.x", 1.0)], ["1.x"])
    data = ss.forced_response(problem, ss.radians_per_second(0.2, 2.0), level, harmonics=3).dataset
    assert "A body is held by friction alone: where it slips, its mean position is not" in str(data.case_message.values[0])
    assert data.sizes["point"] < 1000


def test_a_lost_curve_keeps_the_narrow_peak_that_it_passed():
    """ζ = 1e-5: 5e-5 of the frequency beyond the peak the response is five times lower; at its top it might still rise."""
    structure_ = ss.Structure(np.eye(1), np.eye(1), ("1.x",), C=np.array([[2e-5]]))
    slider = ss.Contact("slider", ss.Macroslip(kt=0.5, mu=1.0, normal_load=1e6), (ss.between("1.x", "ground"),))
    balance = HarmonicBalance(ss.Problem(structure_, (slider,), (ss.Force("1.x", 1.0),), ("1.x",)), 1, 64)
    control, top = StepControl(largest=0.02), np.sqrt(1.5)
    whole = solve_curve(balance, (1.0, 1.5), 1.0, exactly=False, control=control)
    for beyond, count in ((5e-5, 1), (3e-6, 0)):
        points = tuple(point for point in whole.points if point.point.omega < (1.0 + beyond) * top)
        assert points[-1].point.omega > top
        lost = replace(whole, points=points, lost_at=points[-1].point.omega)
        assert len(with_peaks(balance, lost, lambda done: None, 1e-8).peaks[0]) == count


@pytest.mark.parametrize(("static", "arrives"), [(0.4, True), (0.6, False), (2.0, False)])
def test_a_load_that_friction_cannot_carry_has_no_answer(static, arrives):
    """Two masses, one on the other; 0.5 N hold the lower one. Beyond, both slip, and a mean of 1e14 m balanced any load."""
    stack = (
        ss.Contact("foot", ss.Macroslip(1.0, 0.5, normal_load=1.0), (ss.between("1.x", "ground"),)),
        ss.Contact("top", ss.Macroslip(1.0, 5.0, normal_load=1.0), (ss.between("2.x", "1.x"),)),
    )
    structure = ss.Structure(np.eye(2), np.zeros((2, 2)), ("1.x", "2.x"), C=0.02 * np.eye(2))
    loads = ss.Force("2.x", 0.01), ss.Force("2.x", static=static)
    found = ss.forced_response(ss.Problem(structure, stack, loads, ("2.x",)), ss.hertz(0.05, 0.3), 0.1, 3, 64).dataset
    assert (int(found["case_outcome"][0]) == Outcome.CONVERGED) == arrives
    assert np.isfinite(found["peak_amplitude"].values).any() == arrives
