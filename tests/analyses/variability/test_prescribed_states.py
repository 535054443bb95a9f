"""A prescribed start state without static equilibrium, or that leaves a body held by nothing, is recognised and said."""

import numpy as np
import pytest

from stickslip.analyses.forced_response import forced_response
from stickslip.analyses.variability.bounds import response_bounds
from stickslip.analyses.variability.samples import response_samples
from stickslip.model.contact.friction_disc import FrictionDisc
from stickslip.model.contact.point import Contact, SliderOffset, TractionRatio
from stickslip.model.loads import Force
from stickslip.model.problem import Problem
from stickslip.model.rigs import single_blade, three_mass_wedge
from stickslip.model.structure.matrices import Structure
from stickslip.show.report.answer import bounds_failures, bounds_warnings
from stickslip.solve.balance.balance import HarmonicBalance
from stickslip.solve.starts.extremes import AtFrequency
from stickslip.solve.starts.states import UnsolvedError, explored_space
from stickslip.support.checks import InputError
from stickslip.support.outcome import Outcome
from stickslip.support.units import hertz


@pytest.fixture(scope="module")
def blade():
    return single_blade(4.6, modes=20)


def test_a_ratio_in_the_axial_direction_leaves_the_damper_held_by_nothing(blade):
    """Along the axis only friction holds the damper: with a prescribed ratio it is free at harmonic 0."""
    found = response_samples(blade, hertz(480.0, 490.0), 1.0, np.full((1, 80), 0.3), rule="traction_ratio").dataset
    assert int(found.case_outcome[0]) == Outcome.BODY_HELD_BY_NOTHING
    assert "held by nothing" in str(found.case_message.values[0])


def test_bounds_say_it_too(blade):
    found = response_bounds(blade, [480.0], 1.0, rule="traction_ratio", cloud=2, starts=1).dataset
    assert set(found.outcome.values.ravel()) == {Outcome.MOST_STARTS_UNSOLVED}
    assert int(found.unsolved_outcome[0, 0]) in {Outcome.BODY_HELD_BY_NOTHING, Outcome.NO_STATIC_EQUILIBRIUM}
    assert np.all(np.isnan(found.amplitude.values))
    assert int(found.unsolved[0, 0]) == 3
    assert float(found.unsolved_share[0, 0]) == 1.0


@pytest.mark.slow
def test_a_rule_for_each_direction_holds_the_damper(blade):
    """Ratios in the plane and virgin sliders along the axis: each sample is what a problem that starts there gives."""
    where, rules = [480.0, 540.0], ("traction_ratio", "virgin")
    found = response_samples(blade, where, 20.0, np.array([[0.0], [-0.3]]), rule=rules, share="all").dataset
    assert np.all(found.case_outcome == Outcome.CONVERGED)
    assert found.attrs["rule"] == "traction_ratio, virgin"
    set_there = blade.with_contacts(lambda contact: contact.with_start((TractionRatio(-0.3), SliderOffset(0.0))))
    expected = forced_response(set_there, where, 20.0).dataset
    np.testing.assert_allclose(found.amplitude.values[1], expected.amplitude.values[0], rtol=1e-6)
    assert np.all(np.abs(found.amplitude.values[1, :, 0] / found.amplitude.values[0, :, 0] - 1.0) > 1e-2)


@pytest.mark.parametrize(("share", "count"), [("element", 40 + 40), ("direction", 16 + 16), ("contact", 16 + 16), ("all", 2)])
def test_directions_with_rules_of_their_own_share_no_variable(blade, share, count):
    balance = HarmonicBalance(blade, 1, 16)
    mixed = explored_space(balance, [2.0 * np.pi * 480.0], 1.0, ("traction_ratio", "slider_offset"), share)
    assert mixed.size == count
    ratio = mixed.kind == TractionRatio.code
    assert np.all(mixed.scale[ratio] == 1.0)
    assert np.all((mixed.scale[~ratio] > 0.0) & (mixed.scale[~ratio] < 1e-3))
    assert not set(mixed.group[ratio]) & set(mixed.group[~ratio])
    plane = explored_space(balance, [2.0 * np.pi * 480.0], 1.0, ("traction_ratio", "virgin"), share)
    assert plane.size == count // 2
    np.testing.assert_array_equal(plane.values(np.ones(plane.size)), np.where(ratio, 1.0, 0.0))


@pytest.mark.parametrize("rule", [("virgin", "virgin"), "virgin"])
def test_some_start_state_must_vary(rule):
    with pytest.raises(InputError, match="rule must vary some start state"):
        response_samples(three_mass_wedge(), [222.0], rule=rule)


def test_bounds_over_few_of_the_start_states_are_none(monkeypatch):
    """Where most start states have no solution, what the others bound is not reported."""

    def sample(self, variables):
        if np.max(np.abs(variables)) > 0.3:
            raise UnsolvedError(Outcome.NO_STATIC_EQUILIBRIUM)
        return self.point(variables)

    with monkeypatch.context() as patched:
        patched.setattr(AtFrequency, "sample", sample)
        found = response_bounds(three_mass_wedge(), [222.0], cloud=8, starts=1).dataset
    assert 0.5 < float(found.unsolved_share[0, 0]) < 1.0
    assert float(found.unsolved_share[0, 0]) == np.mean(np.isnan(found.sampled_amplitude.values))
    assert set(found.outcome.values.ravel()) == {Outcome.MOST_STARTS_UNSOLVED}
    assert np.all(np.isnan(found.amplitude.values))
    (sentence,) = bounds_failures(found)
    assert "force × 1: no bounds at 1 of 1 frequency. Most start states have no solution" in sentence
    assert "no static equilibrium" in sentence
    assert f"{int(found.unsolved[0, 0])} of 9 sampled start states" in sentence


def test_a_few_start_states_without_solution_are_a_warning(monkeypatch):
    def sample(self, variables):
        if np.all(variables == 1.0):
            raise UnsolvedError(Outcome.NO_STATIC_EQUILIBRIUM)
        return self.point(variables)

    with monkeypatch.context() as patched:
        patched.setattr(AtFrequency, "sample", sample)
        found = response_bounds(three_mass_wedge(), [222.0], cloud=8, starts=1).dataset
    assert int(found.unsolved[0, 0]) == 1
    assert set(found.outcome.values.ravel()) == {Outcome.CONVERGED}
    assert bounds_failures(found) == []
    (sentence,) = bounds_warnings(found)
    assert "1 of 9 sampled start states (11 %) have no solution, at 222.00 Hz" in sentence


def test_a_ratio_without_equilibrium_is_said():
    """Where friction could jam a steep wedge, prescribing it inwards on one side and outwards on the other balances nothing."""
    steep = three_mass_wedge(platform_angle=80.0, mu=3.0)
    found = response_samples(steep, [222.0], 0.01, np.array([[-0.9, 0.9]]), rule="traction_ratio").dataset
    assert int(found.case_outcome[0]) == Outcome.NO_STATIC_EQUILIBRIUM
    assert "no static equilibrium" in str(found.case_message.values[0])


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({"objective": "energy"}, "objective must be"),
        ({"rule": "ratio"}, "rule must be one of"),
        ({"share": "damper"}, "share must be one of"),
        ({"cloud": -1}, "cloud must be at least 0"),
        ({"output": 7}, "output must be 0 to 3"),
        ({"force": -1.0}, "force level must be positive"),
    ],
)
def test_wrong_arguments_are_refused(arguments, message):
    with pytest.raises(InputError, match=message):
        response_bounds(three_mass_wedge(), [222.0], **{"force": 1.0, **arguments})


def discs():
    """Two stiff directions: a mass on a disc whose pressure is constant, pushed along x with a weaker push along y."""
    return Problem(
        Structure(np.eye(2), np.eye(2), ("m.x", "m.y"), C=0.02 * np.eye(2)),
        (Contact("pad", FrictionDisc(kt=1.0, mu=1.0, normal_load=1.0), ({"m.x": 1.0}, {"m.y": 1.0})),),
        (Force({"m.x": 1.0, "m.y": 0.4}, 1.0),),
        ("m.x",),
    )


@pytest.mark.parametrize("rule", ["slider_offset", "traction_ratio"])
def test_friction_discs_are_sampled(rule):
    """Each sample is what a problem that starts there gives; a ratio beyond the disc is put onto its edge."""
    variables = np.array([[0.0, 0.0], [0.3, -0.5], [0.9, 0.8]])
    found = response_samples(discs(), [0.1], 0.4, variables, rule=rule).dataset
    assert np.all(found.case_outcome == Outcome.CONVERGED)
    values = found.start_value.values[1]
    rules = {"slider_offset": SliderOffset, "traction_ratio": TractionRatio}
    starts = tuple(rules[rule](float(value)) for value in values)
    single = forced_response(discs().with_contacts(lambda contact: contact.with_start(starts)), [0.1], 0.4).dataset
    mean = [d.contact_force.values[k, 0, 0, :2, 0, 0] for d, k in ((found, 1), (single, 0))]
    np.testing.assert_allclose(mean[0], mean[1], rtol=1e-8)
    assert np.hypot(*mean[0]) > 0.1
    edge = found.contact_force.values[2, 0, 0, :2, 0, 0]
    assert np.hypot(*edge) <= 1.0


def test_friction_discs_are_not_searched():
    with pytest.raises(InputError, match="derivative by its start state"):
        response_bounds(discs(), [0.1])
    with pytest.raises(InputError, match="the same in both directions"):
        response_samples(discs(), [0.1], 1.0, 3, rule=("slider_offset", "traction_ratio"))
    with pytest.raises(InputError, match="slider_offset or traction_ratio"):
        response_samples(discs(), [0.1], 1.0, 3, rule="mean_traction")
