"""A witness of `make robustness`: some of its random problems, every class, traced across their bands; and ill-posed ones."""

import dataclasses
import itertools
from itertools import product

import numpy as np
import pytest

import stickslip as ss
from robustness import limits, run
from robustness.ill_posed import ILL_POSED, IllPosed, respond
from robustness.one_slider import HighestResult
from robustness.page import ClassResult, ResonanceResult, page
from robustness.problems import CLASSES, random_case
from robustness.resonances import Tally
from robustness.run import traced
from stickslip.solve.balance.balance import HarmonicBalance
from stickslip.solve.continuation import continuation, sweep
from stickslip.solve.continuation.continuation import CLOSED, first_point, trace
from stickslip.solve.continuation.curve_points import LostCurveError
from stickslip.solve.continuation.steps import StepControl, Steps
from stickslip.solve.curves import curve
from stickslip.support.outcome import Outcome

HARD = [("start state", 40)]
"""Sharp folds that look like crossings."""

BARELY = [
    ("barely pressed", 0),
    ("barely pressed, start state", 1),
    pytest.param("barely pressed, start state", 0, marks=pytest.mark.nightly),
]
"""The last one closes on itself in a cascade of folds, and is traced again with reversible steps."""


@pytest.mark.parametrize(("kind", "seed"), [*product(CLASSES[:4], range(4)), *HARD, *BARELY])
def test_random_problems_are_traced_end_to_end(kind, seed):
    found = traced(kind, seed)
    case = random_case(kind, seed)
    assert found.outcome == Outcome.CONVERGED, found.message
    ends = np.array([found.points[0].point.omega, found.points[-1].point.omega]) / (2.0 * np.pi)
    np.testing.assert_allclose(ends, [case.band.start, case.band.stop], rtol=1e-9)
    assert max(point.evaluation.error for point in found.points) < 1e-9


def test_a_curve_that_comes_back_to_a_point_ends_and_says_so(monkeypatch):
    """Solved points of one curve, met again and again in the same direction: Brent's test sees it in the second round."""
    balance = HarmonicBalance(ss.rigs.single_mass(), 3, 64)
    first = first_point(balance, 0.5, 0.5)
    known = list(trace(balance, first, "omega", 2.0))[1:21]
    rounds = itertools.cycle(known)
    monkeypatch.setattr(continuation.Steps, "advance", lambda self, current, bend: next(rounds))
    with pytest.raises(LostCurveError, match="closed on itself"):
        list(itertools.islice(trace(balance, first, "omega", 2.0), 500))
    turned = dataclasses.replace(known[0], tangent=known[0].tangent.turned())
    tracer = continuation._Tracer(balance, "omega", first, 2.0, StepControl())
    assert tracer._meets(known[0], known[0])
    assert not tracer._meets(known[0], known[1])
    assert not tracer._meets(known[0], turned)


def test_a_curve_that_leaves_through_its_start_is_lost(monkeypatch):
    balance = HarmonicBalance(ss.rigs.single_mass(), 3, 64)
    forth = list(trace(balance, first_point(balance, 0.5, 0.5), "omega", 2.0))[1:11]
    back = [point for point in trace(balance, first_point(balance, 0.5, 0.5), "omega", 0.3) if point.point.omega < 0.5]
    turned = iter([*forth, *forth[::-1], *back])
    monkeypatch.setattr(continuation.Steps, "advance", lambda self, current, bend: next(turned))
    with pytest.raises(LostCurveError, match="turned back and left the band through its start"):
        list(trace(balance, first_point(balance, 0.5, 0.5), "omega", 2.0))


def test_a_lost_curve_is_traced_again_with_reversible_steps(monkeypatch):
    controls = []

    def traced(balance, first, start, end, progress, control):
        controls.append(control)
        points = list(trace(balance, first, "omega", end, control))
        return sweep.Sweep(points, CLOSED if len(controls) == 1 else None)

    monkeypatch.setattr(sweep, "_traced", traced)
    balance = HarmonicBalance(ss.rigs.single_mass(), 3, 64)
    assert curve.solve_curve(balance, [0.5, 2.0], 0.5, exactly=False).outcome == Outcome.CONVERGED
    assert [control.reversible for control in controls] == [False, True]


def test_a_step_is_reversible_on_its_branch_and_not_beside_it():
    case = random_case("lift-off", 2)
    balance = HarmonicBalance(case.problem, 5, 256)
    start, end = (2.0 * np.pi * f for f in (case.band.start, case.band.stop))
    first = first_point(balance, start, case.level)
    control = StepControl(reversible=True)
    points = list(trace(balance, first, "omega", end, control))
    assert points[-1].point.omega == end
    tracer = Steps(balance, "omega", abs(end - first.evaluation.point.omega) / 10.0, control)
    k = int(np.argmax([point.length for point in points]))
    before, after = points[k - 1], points[k]
    assert tracer._returns(before, after)
    aside = balance.evaluate(before.point.moved(0.2 * before.point.forces, "omega", 0.0))
    assert not tracer._returns(dataclasses.replace(before, evaluation=aside), after)


def test_a_curve_that_is_lost_is_followed_from_the_end_of_its_band(monkeypatch):
    balance = HarmonicBalance(ss.rigs.single_mass(), 3, 64)
    plain = curve.solve_curve(balance, [0.5, 2.0], 0.5, exactly=False)
    usual = sweep._traced

    def traced(balance, first, start, end, progress, control):
        found = usual(balance, first, start, end, progress, control)
        return found if end < start else sweep.Sweep(found.points[:5], "Lost.")

    monkeypatch.setattr(sweep, "_traced", traced)
    found = curve.solve_curve(balance, [0.5, 2.0], 0.5, exactly=False)
    assert found.outcome == Outcome.CONVERGED
    assert found.message == f"{curve.ARRIVED} {curve.FROM_THE_END} Cause: Lost."
    omegas = [point.point.omega for point in found.points]
    assert (omegas[0], omegas[-1]) == (0.5, 2.0)
    assert omegas == sorted(omegas)
    amplitudes = [[np.hypot(*peak.evaluation.w[-1, 1:3]) for peak in each.peaks[0]] for each in (plain, found)]
    np.testing.assert_allclose(*amplitudes, rtol=1e-6)
    for before, after in itertools.pairwise(found.points):
        assert after.leads_away_from(before, "omega")
        assert after.length == pytest.approx(before.chord(after, "omega"), rel=0.5)


def test_a_mean_that_drifts_by_many_times_the_vibration_does_not_shorten_the_steps():
    """A body that hardly vibrates above its resonances, while lightly pressed contacts let its mean drift."""
    case = random_case("barely pressed", 1)
    balance = HarmonicBalance(case.problem, 5, 256)
    low, high = (2.0 * np.pi * f for f in (case.band.start, case.band.stop))
    points = itertools.islice(trace(balance, first_point(balance, high, case.level), "omega", low), 40)
    assert min(point.point.omega for point in points) < 0.95 * high


@pytest.mark.parametrize("case", ILL_POSED, ids=lambda case: case.name)
def test_ill_posed_problems_are_recognised(case):
    assert case.mistaken_for() == ""


def test_a_sound_problem_is_not_taken_for_an_ill_posed_one():
    sound = IllPosed("nothing is wrong", respond(), outcome=Outcome.BODY_HELD_BY_NOTHING)
    assert sound.mistaken_for() == "answered: converged"
    assert len({case.name for case in ILL_POSED}) == len(ILL_POSED) >= 30


def test_the_problems_are_what_they_are_called():
    """Seeded: the same case twice; varied: sizes, contacts and laws differ; lift-off happens in its class."""
    assert np.array_equal(random_case("lift-off", 3).problem.structure.K, random_case("lift-off", 3).problem.structure.K)
    cases = [random_case(kind, seed).problem for kind in CLASSES for seed in range(25)]
    assert {problem.structure.size for problem in cases} == {1, 2, 3, 4, 5, 6}
    assert {len(problem.contacts) for problem in cases} == {1, 2, 3, 4}
    laws = {type(contact.law).__name__ for problem in cases for contact in problem.contacts}
    assert laws == {"Macroslip", "MicroslipArray", "Gap"}


def test_limits_are_measured_on_problems_that_are_stiffer_or_of_other_friction(monkeypatch):
    case = random_case("lift-off", 4)
    usual = case.problem.contact_stiffness
    np.testing.assert_allclose(limits.stiffer(case.problem, 30.0).contact_stiffness, 30.0 * usual)
    frictions = [contact.law.mu for contact in limits.of_friction(case.problem, 7.0).contacts if hasattr(contact.law, "mu")]
    assert frictions
    assert set(frictions) == {7.0}
    assert not limits.is_lost(case, case.problem)
    monkeypatch.setattr(limits, "PATIENCE", 0.0)
    assert limits.is_lost(case, case.problem)


def test_the_page_says_what_a_run_found():
    failed = {"The curve turned back.": [3], "Too many points.": [5, 9]}
    results = [ClassResult(kind, 20, 0.3, failed if kind == "lift-off" else {}) for kind in CLASSES]
    right, wrong = Tally(cases=2, peaks=12), Tally(cases=2, peaks=11, missing=1, wrong=["chain 1: 1 missing"])
    highest = [HighestResult(1e-3, 4, 3, ["one slider 7"])]
    text = page(results, [ResonanceResult("chain", 1e-3, right, wrong)], highest, "31 of 31 recognised", "Measured today")
    assert "| 0.001 | 4 | 3 | 2 |" in text
    assert "* one slider 7" in text
    assert "| chain | 0.001 | 2 | 12 | 0 | 0 | 11 | 1 | 0 |" in text
    assert "* chain 1: 1 missing" in text
    assert "| lift-off | the same with preload 0 to 2, and gaps | 17 of 20 (85.0 %) | 0.30 s |" in text
    assert text.index("2 of lift-off: Too many points. (numbers 5, 9)") < text.index("1 of lift-off: The curve turned back.")
    assert "No problem failed." in page(results[:1], [], [], "", "")


@pytest.mark.parametrize(
    ("result", "restored"),
    [
        (ClassResult("lift-off", 3, 0.5, {"Lost.": [1]}), lambda stored: ClassResult(**stored)),
        (ResonanceResult("chain", 1e-2, Tally(1, 4, wrong=["chain 0"]), Tally()), ResonanceResult.restored),
    ],
)
def test_a_robustness_run_goes_on_after_what_is_kept(result, restored, tmp_path, monkeypatch):
    computed = []

    def compute():
        computed.append(True)
        return result

    monkeypatch.setattr(run, "KEPT", tmp_path / "robustness.json")
    monkeypatch.setattr(run, "commit", lambda *folders: "0123456789ab")
    assert run.kept("one", compute, restored) == result
    assert run.kept("one", compute, restored) == result
    assert len(computed) == 1
    run.kept("other", compute, restored)
    assert len(computed) == 2
    monkeypatch.setattr(run, "commit", lambda *folders: "0123456789ab+")
    run.kept("one", compute, restored)
    assert len(computed) == 3
