"""Parameters from synthetic frequency responses with noise, whose truth is known, and derivatives against differences."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
import xarray as xr
from scipy import stats

import stickslip as ss
from stickslip.laboratory.identification.response.fit import ComputedResponse, FittedTest, ResponseFit, enough
from stickslip.laboratory.identification.response.intervals import (
    above_noise,
    error_between_tests,
    independent_one_in,
    statistics,
)
from stickslip.laboratory.identification.response.result import _about_misfit, summary
from stickslip.laboratory.measurement.measured_response import flat_top
from stickslip.laboratory.measurement.number_table import FileUnit
from stickslip.show.report.markup import Charts
from stickslip.show.report.sections import energies
from stickslip.solve.balance.balance import HarmonicBalance
from stickslip.solve.continuation.continuation import first_point
from stickslip.solve.starts.states import start_space

FREQUENCIES = np.linspace(0.14, 0.24, 21)
TRUTH = {"kt": 0.5, "limit": 1.0, "damping": 0.02}
FREE = {"kt": (0.8, 0.1, 3.0), "limit": (0.6, 0.1, 5.0), "damping": (0.05, 0.002, 0.2)}


def one_mass(kt=0.5, limit=1.0, damping=0.02, load=1.0):
    return ss.rigs.single_mass(kt=kt, limit=limit * load, damping=damping)


def measured(force, seed, noise=0.01, frequencies=FREQUENCIES, phase=True, **settings):
    """A test of the true problem, its responses with a relative complex error."""
    data = ss.forced_response(one_mass(**TRUTH, **settings), frequencies.tolist(), force, samples=128).dataset
    X = data["response"].values[0, :, 0, 1] @ np.array([1.0, 1j])
    rng = np.random.default_rng(seed)
    X = X * (1.0 + noise * (rng.normal(size=X.size) + 1j * rng.normal(size=X.size)))
    known = {"quantity": "displacement", "error": noise or 0.01, "settings": settings}
    return ss.MeasuredResponse(frequencies, np.abs(X), force, np.angle(X) if phase else None, name=f"{force:g}", **known)


@pytest.mark.parametrize("held", ["force", "response"])
def test_derivatives_are_those_of_the_residuals(held):
    """Exact derivatives by parameters, gain and phase against central differences, with the force and with the response given."""
    tests = [measured(force, 1, frequencies=FREQUENCIES[3::5]) for force in (0.3, 1.0, 2.0)]
    given = {"held": held, "free_gain": True, "free_phase": True}
    tests = [ss.MeasuredResponse(t.frequency, t.amplitude, t.force, t.phase, "displacement", **given) for t in tests]
    free = {name: ss.FreeParameter(*values) for name, values in FREE.items()} | {
        "load": ss.FreeParameter(1.0, 0.5, 2.0, each_test=True)
    }
    fit = ResponseFit([FittedTest.of(test, one_mass, 3, 128) for test in tests], free)
    x = fit.start + 0.01 * np.cos(np.arange(fit.start.size))
    exact = fit.jacobian(x)
    for k in range(x.size):
        step = 1e-6 * np.eye(x.size)[k]
        differences = (fit.residuals(x + step) - fit.residuals(x - step)) / 2e-6
        assert exact[:, k] == pytest.approx(differences, abs=2e-4 * np.abs(exact[:, k]).max())


def test_derivatives_by_start_states():
    """A mass on three sliders that stick at a small force: only their start states and stiffness count, through the lift-off."""
    problem = ss.rigs.three_mass_wedge()
    frequencies = np.array([216.0, 219.0, 222.0])
    test = ss.MeasuredResponse(frequencies, 1e-6, 1.0, quantity="displacement")
    balance = HarmonicBalance(problem, 3, 128)
    space = start_space(balance, first_point(balance, 2.0 * np.pi * 216.0, 1.0).evaluation, "traction_ratio", "element")

    def rig(scale=1.0):
        return problem.with_forces([*problem.forces]) if scale == 1.0 else problem

    fit = ResponseFit([FittedTest(test, rig, 3, 128, [None] * 3, space)], {"scale": ss.FreeParameter(1.0, 0.5, 2.0)})
    x = fit.start + 0.1
    x[0] = 0.0
    exact, count = fit.jacobian(x), 3
    for k in range(1, x.size):
        step = 1e-5 * np.eye(x.size)[k]
        differences = (fit.residuals(x + step) - fit.residuals(x - step)) / 2e-5
        assert exact[:count, k] == pytest.approx(differences[:count], abs=1e-3 * max(np.abs(exact[:count]).max(), 1e-300))
    assert np.abs(exact[:count, 1:]).max() > 0.0


def blade(cylinder_kt=45e6, cylinder_mu=0.4):
    return ss.rigs.single_blade(4.6, cylinder_kt=cylinder_kt, cylinder_mu=cylinder_mu)


@pytest.fixture(scope="module")
def beside_a_fold():
    """A fit of three points at 20 N, the first between two folds of the single blade with some start states; its variables."""
    frequencies, balance = np.array([536.3, 540.0, 546.25]), HarmonicBalance(blade(), 3, 128)
    space = start_space(balance, first_point(balance, 2.0 * np.pi * 500.0, 20.0).evaluation, ("traction_ratio", "virgin"))
    rng = np.random.default_rng(0)
    starts = [rng.uniform(-0.8, 0.8, space.size) for _ in range(3)][2]
    test = ss.MeasuredResponse(frequencies, 20.0 * np.array([140.0, 177.0, 177.0]) * 1e-9, 20.0, np.zeros(3), "displacement")
    free = {"cylinder_kt": ss.FreeParameter(45e6, 10e6, 150e6), "cylinder_mu": ss.FreeParameter(0.4, 0.05, 1.0)}
    fit = ResponseFit([FittedTest(test, blade, 3, 128, [None] * 3, space)], free)
    x = np.concatenate([fit.start[:2], starts])
    fit.jacobian(x)
    return fit, x


def test_a_point_behind_a_fold_is_reached_along_the_curve(beside_a_fold):
    """Newton's method finds no solution at 546.25 Hz, neither from the stuck contacts nor from beside it."""
    fit, x = beside_a_fold
    fit.residuals(x)
    assert fit.computed[0].solved.all()
    assert np.abs(fit.computed[0].per_force[1:]) == pytest.approx([176.92e-9, 176.88e-9], rel=1e-3)


def test_a_refused_step_leaves_no_solutions_behind(beside_a_fold):
    """A point between two folds has three solutions: that of a far step must not change the residuals where it came from."""
    fit, x = beside_a_fold
    there, far = fit.residuals(x), x.copy()
    far[2:] = 0.5 * x[2:]
    fit.residuals(far)
    assert fit.residuals(x) == pytest.approx(there, abs=1e-6)


def test_a_fit_begins_again_at_its_solutions(beside_a_fold):
    """The solutions of all points survive an array, padded as those of several tests are; a point without one has none."""
    fit, x = beside_a_fold
    fit.jacobian(x)
    model = replace(fit.tests[0], known=[*fit.tests[0].known[:2], None])
    other = replace(model, known=[None] * 3)
    other.solutions = np.pad(model.solutions, ((0, 1), (0, 2), (0, 3)), constant_values=np.nan)
    assert other.known[2] is None
    for mine, its in zip(other.known[:2], model.known[:2], strict=True):
        assert np.array_equal(mine.forces, its.forces)
        assert (mine.omega, mine.level) == pytest.approx((its.omega, its.level))


class SlipsUnlessStarted(FittedTest):
    """A response that its start variable changes only above 0.2, where a contact begins to stick."""

    def computed(self, values, starts, names):
        found = ComputedResponse.unsolved(3, names, 1)
        found.per_force[:] = values["scale"] * (1.0 + max(starts[0] - 0.2, 0.0)) * np.array([1.0, 2.0, 1.0])
        found.by_value["scale"][:] = found.per_force / values["scale"]
        found.by_start[:, 0] = (starts[0] > 0.2) * values["scale"] * np.array([1.0, 2.0, 1.0])
        found.solved[:] = True
        return found


def test_a_test_that_its_start_state_does_not_explain_takes_others():
    """A start variable without a derivative stays where it is, and its test is missed, until other start states are tried."""

    def test_of(name, size):
        amplitude = size * np.array([1.0, 2.0, 1.0])
        measured = ss.MeasuredResponse(FREQUENCIES[:3], amplitude, 1.0, np.zeros(3), "displacement", name=name, error=0.01)
        return SlipsUnlessStarted(measured, one_mass, 3, 128, [None] * 3, SimpleNamespace(size=1))

    fit = ResponseFit(
        [*(test_of(f"{k}", 1.0) for k in range(5)), test_of("stuck", 1.3)], {"scale": ss.FreeParameter(1.1, 0.5, 2.0)}
    )
    x = fit.best(0, 0, 30)
    assert np.exp(x[0]) == pytest.approx(1.0, abs=0.01)
    assert x[-1] == pytest.approx(0.5, abs=0.01)


SMOOTH = {
    "valanis": (lambda kt, own: ss.Valanis(kt, 0.5, own, normal_load=2.0), 0.7, (0.4, 0.0, 0.95)),
    "lugre": (lambda kt, own: ss.LuGre(kt, 0.5, 0.6, 0.3, 0.05, own, normal_load=2.0), 0.04, (0.02, 0.0, 0.2)),
}


@pytest.mark.parametrize("name", SMOOTH)
def test_numbers_of_a_law_with_a_step_are_found(name):
    """kt and a number of the law's own from exact responses at two force levels."""
    make, truth, free = SMOOTH[name]

    def problem(kt, own):
        return ss.rigs.single_mass(damping=0.02).with_contacts(lambda contact: contact.with_law(make(kt, own)))

    tests, frequencies = [], FREQUENCIES[2::3]
    for force in (0.5, 2.0):
        data = ss.forced_response(problem(0.5, truth), frequencies.tolist(), force, harmonics=3, samples=64).dataset
        X = data["response"].values[0, :, 0, 1] @ np.array([1.0, 1j])
        tests.append(ss.MeasuredResponse(frequencies, np.abs(X), force, np.angle(X), "displacement", name=f"{force:g}"))
    found = ss.identify_response(problem, {"kt": (0.4, 0.1, 2.0), "own": free}, tests, tries=0, harmonics=3, samples=64).values
    assert found["kt"] == pytest.approx(0.5, rel=1e-4)
    assert found["own"] == pytest.approx(truth, rel=1e-3)


def test_the_truth_lies_in_the_intervals():
    """Three force levels, 1 % noise, with phases; verify/ has the statistics of twenty seeds."""
    found = ss.identify_response(one_mass, FREE, [measured(force, 3) for force in (0.3, 1.0, 2.0)], samples=128)
    for name, truth in TRUTH.items():
        k = list(found.values).index(name)
        low, high = (float(found.dataset[end][k]) for end in ("low", "high"))
        assert found.values[name] == pytest.approx(truth, rel=0.03)
        assert low < found.values[name] < high
        assert 1e-4 < high / low - 1.0 < 0.1
    assert float(found.dataset["misfit"].max()) < 0.02
    assert not found.notes
    assert str(found).count("95 % interval") == 3


@pytest.mark.nightly
def test_amplitudes_alone_with_preloads_and_a_measured_force_that_varies():
    """The force of every point is its own; two preloads are settings of their tests."""
    tests = [measured(1.5, 5, 0.0, phase=False, load=load) for load in (0.7, 1.4)]
    sagging = 1.5 * (1.0 - 0.5 * np.exp(-(((FREQUENCIES - 0.19) / 0.02) ** 2)))
    responses = []
    for f, force in zip(FREQUENCIES, sagging, strict=True):
        one = ss.forced_response(one_mass(**TRUTH), [f], float(force), samples=128).dataset
        responses.append(float(one["amplitude"][0, 0, 0]))
    tests = [
        *(
            ss.MeasuredResponse(t.frequency, t.amplitude, t.force, None, "displacement", settings=t.settings, name=n)
            for n, t in zip("ab", tests, strict=True)
        ),
        ss.MeasuredResponse(FREQUENCIES, responses, sagging, None, "displacement", name="sagging"),
    ]
    found = ss.identify_response(one_mass, FREE, tests, samples=128, leave_one_out=True)
    for name, truth in TRUTH.items():
        assert found.values[name] == pytest.approx(truth, rel=1e-5)
    assert float(found.dataset["held_out"].max()) < 1e-4
    again = ss.forced_response(found.problem(load=0.7), FREQUENCIES.tolist(), 1.5, samples=128).dataset
    assert again["amplitude"].values[0, :, 0] == pytest.approx(tests[0].amplitude, rel=1e-5)


def of_joints():
    """Two curves each of three joints whose stiffnesses differ."""
    tests = []
    for name, kt in {"A": 0.45, "B": 0.5, "C": 0.56}.items():
        for force in (0.3, 1.0):
            data = ss.forced_response(one_mass(kt=kt), FREQUENCIES[::2].tolist(), force, harmonics=3, samples=64).dataset
            size = data["amplitude"].values[0, :, 0]
            tests.append(
                ss.MeasuredResponse(FREQUENCIES[::2], size, force, None, "displacement", name=f"{name} {force}", joint=name)
            )
    return tests


JOINTS = {"tries": 0, "harmonics": 3, "samples": 64}


def test_one_joint_is_left_out_with_all_its_curves():
    """Its misfits are those of a fit to the other joints alone, which one curve of it would already have moved."""
    found = ss.identify_response(one_mass, FREE, of_joints(), leave_one_out=True, **JOINTS)
    others = ss.identify_response(one_mass, FREE, [test for test in of_joints() if test.joint != "A"], **JOINTS)
    model = [FittedTest.of(test, one_mass, 3, 64) for test in of_joints() if test.joint == "A"]
    fit = ResponseFit(model, {name: ss.FreeParameter(*ends) for name, ends in FREE.items()})
    x = np.array([fit.free[name].variable(value) for name, value in others.values.items()])
    assert found.dataset["held_out"].values[:2] == pytest.approx([fit.misfit(x, t) for t in range(2)], rel=1e-3)
    assert "each joint left out and predicted by the others: at most" in str(found)
    assert "(joint " in str(found)


def test_what_the_others_do_not_determine_is_not_taken_from_what_is_left_out():
    """Joint A sticks, so that it says nothing of the slip limit that joint B shows: B is not predicted, and one joint alone
    cannot be left out."""
    tests = [replace(measured(force, 3, 1e-3, FREQUENCIES[::2]), joint=joint) for force, joint in ((0.01, "A"), (1.0, "B"))]
    found = ss.identify_response(one_mass, FREE, tests, leave_one_out=True, **JOINTS)
    assert found.values["limit"] == pytest.approx(1.0, rel=0.02)
    assert float(found.dataset["held_out"][1]) > 0.05
    with pytest.raises(ss.InputError, match="leave_one_out must have another joint to predict from"):
        ss.identify_response(one_mass, FREE, [replace(test, joint="A") for test in tests], leave_one_out=True, **JOINTS)


def test_intervals_hold_how_joints_differ():
    """By the joints, of which there are three, and not by their six curves: the stiffness of each lies inside."""
    found = ss.identify_response(one_mass, FREE, of_joints(), **JOINTS).dataset.sel(parameter="kt")
    alone = ss.identify_response(one_mass, FREE, [replace(test, joint="") for test in of_joints()], **JOINTS).dataset
    alone = alone.sel(parameter="kt")
    assert float(found["low"]) < 0.46
    assert float(found["high"]) > 0.55
    assert float(found["high"] - found["low"]) > 1.2 * float(alone["high"] - alone["low"])
    with pytest.raises(ss.InputError, match="joint must be named for all tests or for none"):
        ss.identify_response(one_mass, FREE, [*of_joints()[:2], replace(of_joints()[2], joint="")])


@pytest.mark.nightly
def test_a_stuck_contact_says_nothing_of_friction():
    small = [measured(force, 2) for force in (0.005, 0.01)]
    found = ss.identify_response(one_mass, FREE, small, tries=0, samples=128)
    assert found.values["kt"] == pytest.approx(0.5, rel=0.02)
    assert any("only lower bounds of the friction coefficients" in note for note in found.notes)
    assert not any(note.startswith("limit is not determined") for note in found.notes)
    least = float(found.dataset["least"].sel(parameter="limit"))
    assert f"\nlimit ≥ {least:.5g}: lower bound: with less a contact would slip or open\n" in str(found)
    carried = 0.5 * max(float(np.max(test.amplitude)) for test in small)
    assert 0.9 * carried < least < 1.01 * carried
    assert np.isnan(found.dataset["least"].sel(parameter="kt"))
    unseen = ss.identify_response(one_mass, FREE | {"limit": (0.6, 0.4, 5.0)}, small, tries=0, samples=128)
    assert any("give no friction coefficient" in note for note in unseen.notes)
    assert any(note.startswith("limit is not determined") for note in unseen.notes)


@pytest.mark.nightly
@pytest.mark.parametrize("seed", [0, 3, 5, 7])
def test_slip_that_only_fits_noise_is_no_friction_limit(seed):
    """Stuck tests, fitted from limits at which the peaks slip: never slipping fits as well, so no interval is closed above."""
    small = [measured(force, seed) for force in (0.005, 0.01)]
    carried = 0.5 * max(float(np.max(test.amplitude)) for test in small)
    free = FREE | {"limit": (0.97 * carried, 0.1 * carried, 20.0 * carried)}
    found = ss.identify_response(one_mass, free, small, tries=0, samples=128)
    limit = found.dataset.sel(parameter="limit")
    assert 0.8 * carried < float(limit["least"]) < 1.05 * carried
    assert float(limit["high"]) == pytest.approx(20.0 * carried)
    assert not np.any(found.dataset["slips"])
    assert found.values["kt"] == pytest.approx(0.5, rel=0.02)


def test_slip_that_the_tests_show_keeps_its_interval():
    """One point that slips is enough, where the measured response shows it."""
    tests = [measured(force, 3) for force in (0.02, 0.06)]
    found = ss.identify_response(one_mass, FREE | {"limit": (0.6, 0.01, 5.0)}, tests, tries=4, samples=128)
    limit = found.dataset.sel(parameter="limit")
    assert np.count_nonzero(found.dataset["slips"]) == 1
    assert np.isnan(limit["least"])
    assert 0.95 < float(limit["low"]) < TRUTH["limit"] < float(limit["high"]) < 1.05


@pytest.mark.parametrize(("scale", "lost"), [(1.0, False), (1e-3, True)])
def test_a_parameter_near_zero_is_found_by_the_width_of_its_bounds(scale, lost):
    """A change of the stiffness that is zero in truth, between bounds on both sides; by a small scale it moves nothing."""
    tests = [measured(force, 4) for force in (0.3, 1.5)]
    free = {"change": (0.2, -1.0, 1.0), "damping": FREE["damping"]}
    found = ss.identify_response(
        lambda change, damping: one_mass(0.5 * (1.0 + scale * change), 1.0, damping), free, tests, tries=0
    )
    value, low, high = (float(found.dataset[key].sel(parameter="change")) for key in ("value", "low", "high"))
    assert low < 0.0 < high
    assert abs(value) < 0.5 * (high - low)
    assert any(note.startswith("change is not determined") for note in found.notes) == lost


@pytest.mark.slow
def test_what_every_test_has_by_itself():
    """A stiffness that differs from mounting to mounting, a gain and a phase of the measuring chain."""

    def mounted(kt, limit, extra):
        structure = ss.Structure(np.eye(1), np.array([[1.0 + extra]]), ("1.x",), C=np.array([[0.02]]))
        law = ss.Macroslip(kt, 1.0, normal_load=limit)
        return ss.Problem(structure, (ss.Contact("c", law, (ss.between("1.x", "ground"),)),), (ss.Force("1.x", 1.0),), ("1.x",))

    tests = []
    for k, (force, extra) in enumerate(((0.8, 0.0), (1.5, 0.03), (2.5, -0.02))):
        data = ss.forced_response(mounted(0.5, 1.0, extra), FREQUENCIES.tolist(), force, samples=128).dataset
        X = data["response"].values[0, :, 0, 1] @ np.array([1.0, 1j]) * 1.1 * np.exp(0.2j)
        chain = {"free_gain": True, "free_phase": True, "name": f"{k}"}
        tests.append(ss.MeasuredResponse(FREQUENCIES, np.abs(X), force, np.angle(X), "displacement", **chain))
    free = {"kt": (0.8, 0.1, 3.0), "limit": (0.6, 0.1, 5.0), "extra": ss.FreeParameter(0.0, -0.1, 0.1, each_test=True)}
    found = ss.identify_response(mounted, free, tests, tries=2, samples=128)
    assert found.values == pytest.approx({"kt": 0.5, "limit": 1.0}, rel=1e-4)
    own = found.dataset["own_value"]
    assert own.sel(own="extra").values == pytest.approx([0.0, 0.03, -0.02], abs=1e-4)
    assert own.sel(own="gain").values == pytest.approx(1.1, rel=1e-4)
    assert own.sel(own="phase offset").values == pytest.approx(0.2, abs=1e-4)
    assert "\ngain: 1.1 (0), 1.1 (1), 1.1 (2)\nphase offset: 11.46° (0), 11.46° (1), 11.46° (2)\n" in str(found)
    assert "gain is" not in " ".join(found.notes)
    many = found.dataset.isel(test=[0, 1, 2, 0, 1])
    assert "extra: -0.02 to 0.03 over 5 tests" in summary(many)
    loud = [replace(test, amplitude=2.0 * np.asarray(test.amplitude), free_phase=k > 0) for k, test in enumerate(tests)]
    again = ss.identify_response(mounted, free, [loud[1], tests[2]], tries=0, samples=128)
    assert "The gain is 2.2 of 1. It is the ratio of measured to computed response" in " ".join(again.notes)


def test_wrong_input():
    test = measured(1.0, 0)
    with pytest.raises(ss.InputError, match="start must lie between low and high"):
        ss.identify_response(one_mass, {"kt": (5.0, 0.1, 3.0)}, [test])
    with pytest.raises(ss.InputError, match="must hold one that all tests have in common"):
        ss.identify_response(one_mass, {"kt": ss.FreeParameter(0.5, 0.1, 3.0, each_test=True)}, [test])
    with pytest.raises(ss.InputError, match="tests must hold at least one"):
        ss.identify_response(one_mass, FREE, [])
    with pytest.raises(ss.InputError, match="Names of tests"):
        ss.identify_response(one_mass, FREE, [test, test])
    with pytest.raises(ss.InputError, match="force must be positive"):
        ss.MeasuredResponse([0.1, 0.2, 0.3], 1.0, 0.0)
    with pytest.raises(ss.InputError, match="free_phase must go with measured phases"):
        ss.MeasuredResponse([0.1, 0.2, 0.3], 1.0, 1.0, free_phase=True)


@pytest.mark.parametrize(
    ("change", "words"),
    [
        ({"parameters": 3}, "parameters must be {name: (start, low, high)}, but is 3"),
        ({"parameters": {"kt": 3}}, "parameter 'kt' must be a FreeParameter or (start, low, high), but is 3"),
        ({"parameters": {"kt": ("a", "b", "c")}}, "parameter 'kt' must hold numbers"),
        ({"parameters": {"kt": (1, 2)}}, "parameter 'kt' must be a FreeParameter or (start, low, high)"),
        ({"parameters": {"kt": (np.nan, 0.1, 2)}}, "parameter 'kt': start must be finite"),
        ({"parameters": {3: (1, 0.1, 2)}}, "The name of a parameter must be a text, but is 3"),
        ({"parameters": {"ky": (1, 0.1, 2)}}, "problem_of(ky=1) must return a Problem, but raises TypeError"),
        ({"parameters": {"load": (1, 0.1, 2)}}, "The settings of test 1 must not name what is free, but is ['load']"),
        ({"leave_one_out": "yes"}, "leave_one_out must be True or False, but is 'yes'"),
        ({"harmonics": "auto"}, "harmonics must be a whole number, but is 'auto'"),
        ({"start_states": "worn"}, "start_states must be one of virgin, free"),
        ({"rule": "offset"}, "rule must be one of"),
        ({"share": "none"}, "share must be one of"),
        ({"tries": 1.5}, "tries must be a whole number"),
        ({"problem_of": 3}, "problem_of must be a function that returns a Problem, but is 3"),
        ({"tests": 3}, "tests must be a tuple or list"),
        ({"tests": [3]}, "A test must be a MeasuredResponse, but is 3"),
    ],
)
def test_arguments_of_a_wrong_kind(change, words):
    test = ss.MeasuredResponse([0.1, 0.2, 0.3], 1.0, 1.0, settings={"load": 1.0})
    given = {"problem_of": one_mass, "parameters": FREE, "tests": [test]} | change
    with pytest.raises(ss.InputError) as raised:
        ss.identify_response(**given)
    assert words in str(raised.value)


def test_a_test_given_twice_is_said():
    tests = [measured(1.0, 3, frequencies=FREQUENCIES[::4]), measured(1.0, 3, frequencies=FREQUENCIES[::4])]
    tests[1] = replace(tests[1], name="again")
    found = ss.identify_response(one_mass, {"kt": (0.5, 0.1, 3.0)}, tests, tries=0, samples=128)
    assert "1 and again contain the same points" in " ".join(found.notes)


@pytest.mark.nightly
def test_what_the_model_does_not_explain_is_said():
    """The phase of all tests 40° off, which is no known mistake; a fit cut short."""
    tests = [measured(force, 3, frequencies=FREQUENCIES[::2]) for force in (0.3, 1.0, 2.0)]
    again = {"quantity": "displacement", "error": 0.01}
    wrong = [ss.MeasuredResponse(t.frequency, t.amplitude, t.force, t.phase + 0.7, name=t.name, **again) for t in tests]
    settings = {"harmonics": 3, "samples": 128}
    found = ss.identify_response(one_mass, FREE, wrong, tries=0, evaluations=15, **settings)
    (note,) = (note for note in found.notes if "The model does not explain the tests" in note)
    assert "the number of harmonics and the phase (of the displacement, not of the acceleration" in note
    short = ss.identify_response(one_mass, FREE, tests, tries=0, evaluations=2, **settings)
    assert any("stopped before it converged" in note for note in short.notes)
    whole = ss.identify_response(one_mass, FREE, tests, tries=0, **settings)
    assert not any("converged" in note or "explain" in note for note in whole.notes)


@pytest.mark.parametrize(
    ("change", "words"),
    [
        ({"phase": [-90.0, -95.0, -100.0]}, "must be in rad"),
        ({"amplitude": [1.0, 2.0]}, "must have 3 entries"),
        ({"amplitude": "large"}, "amplitude"),
        ({"quantity": "accel"}, "quantity must be one of displacement, velocity, acceleration"),
        ({"settings": 3}, "settings must be"),
        ({"free_gain": "yes"}, "free_gain must be True or False"),
        ({"output": "1.x"}, "output must be a whole number"),
        ({"error": 0.0}, "error must be positive"),
        ({"name": 3}, "The name of a test must be a text"),
    ],
)
def test_wrong_measured_responses(change, words):
    given = {"frequency": [1.0, 2.0, 3.0], "amplitude": 1.0, "force": 1.0} | change
    with pytest.raises(ss.InputError, match=words):
        ss.MeasuredResponse(**given)


def test_independent_residuals_stay_so_and_others_are_counted():
    """Noise; an autoregressive series of correlation 0.7, of which one in (1 + 0.7)/(1 − 0.7) is independent; a smooth misfit."""
    generator = np.random.default_rng(0)
    noise = [[generator.standard_normal(41) for _ in range(6)] for _ in range(40)]
    assert np.mean([independent_one_in(one) == 1.0 for one in noise]) > 0.9
    assert np.mean([above_noise(one) for one in noise]) == pytest.approx(1.0, abs=0.05)
    long = generator.standard_normal(20_000)
    for k in range(1, long.size):
        long[k] += 0.7 * long[k - 1]
    assert independent_one_in([long]) == pytest.approx(1.7 / 0.3, rel=0.1)
    assert above_noise([np.sin(np.linspace(0.0, 6.0, 41)) + 0.01 * generator.standard_normal(41)]) > 10.0


def test_errors_and_quantile_of_a_straight_line_are_those_of_linear_regression():
    """Against SciPy's; of a third variable, of which the data say nothing, the error is without end."""
    t = np.linspace(-1.0, 2.0, 12)
    y = 0.7 + 1.3 * t + 0.2 * np.random.default_rng(2).standard_normal(12)
    line = stats.linregress(t, y)
    J = np.stack([np.ones(12), t, 0.0 * t], axis=1)
    residuals = J @ [line.intercept, line.slope, 0.0] - y
    free = [SimpleNamespace(deviation=None, test=-1)] * 3
    fit = SimpleNamespace(variables=free, series=lambda x: [residuals], tests=())
    fit.residuals, fit.jacobian = lambda x: residuals, lambda x: J
    found = statistics(fit, None)
    assert found.one_in == 1.0
    assert found.error == pytest.approx([line.intercept_stderr, line.stderr, np.inf], rel=1e-9)
    assert found.noise == pytest.approx(np.sum(residuals**2) / 10.0)
    assert found.quantile == pytest.approx(stats.t.ppf(0.975, 10), rel=1e-9)
    assert found.correlation[0, 1] == pytest.approx(-t.mean() / np.sqrt(np.mean(t**2)))


def test_the_error_between_tests_is_that_of_their_means():
    """One shared mean of five tests with offsets of their own: the scatter of their means over √5; their own slopes drop out."""
    generator = np.random.default_rng(1)
    offsets, slope = generator.standard_normal(5), np.linspace(-1.0, 1.0, 20)
    residuals = [np.full(20, offset - offsets.mean()) + 3.0 * slope for offset in offsets]
    J = np.zeros((20, 6))
    J[:, 0] = -1.0
    parts = []
    for t, r in enumerate(residuals):
        own = J.copy()
        own[:, 1 + t] = slope
        parts.append((r, own, np.array([1 + t])))
    found = error_between_tests(parts, np.zeros((1, 1)), 1)
    assert found == pytest.approx([np.std(offsets, ddof=1) / np.sqrt(5.0)])


@pytest.mark.nightly
def test_intervals_hold_what_differs_from_test_to_test():
    """Six tests whose slip limits scatter by 5 %: with independent residuals one in twelve intervals of the limit holds it."""
    levels, held, widths = (0.3, 0.6, 1.0, 1.5, 2.0, 3.0), [], []
    names = list(TRUTH)
    for seed in range(5):
        loads = 1.0 + 0.05 * np.random.default_rng(seed).standard_normal(6)
        tests = [measured(force, 10 * seed + k, load=load) for k, (force, load) in enumerate(zip(levels, loads, strict=True))]
        tests = [replace(test, settings={}) for test in tests]
        found = ss.identify_response(
            one_mass, {name: (value, value / 8, 8 * value) for name, value in TRUTH.items()}, tests, tries=0
        )
        ends = [[float(found.dataset[end][k]) for end in ("low", "high")] for k in range(3)]
        held.append([low <= TRUTH[name] <= high for name, (low, high) in zip(names, ends, strict=True)])
        widths.append(np.log(ends[1][1] / ends[1][0]))
    assert np.mean(held) > 0.75
    assert 0.05 < np.mean(widths) < 0.3
    said = " ".join(found.notes)
    assert "Residuals of about" in said
    assert "they do not include an error common to all tests, such as a wrong contact law" in said


@pytest.mark.parametrize(
    ("costs", "ends"),
    [
        ([1.0], True),
        ([5e3], False),
        ([5e3, 5.001e3], True),
        ([5e3, 4.9e3], False),
        ([5e3, 4e3, 5.001e3], False),
        ([5e3, 4e3, 4e3], True),
    ],
)
def test_a_fit_that_explains_nothing_ends_when_two_starts_agree(costs, ends):
    """Of 100 residuals; further starts of a wrong model would take minutes to find the same minimum again."""
    assert enough([SimpleNamespace(cost=cost, residuals=np.zeros(100)) for cost in costs]) == ends


@pytest.mark.parametrize(("one_in", "named"), [(1.0, False), (1.4, False), (2.5, True)])
def test_neighbours_that_hardly_go_together_are_no_fault_of_the_model(one_in, named):
    """Chance alone makes one residual in 1.4 independent: "together over 1 points" would say nothing."""
    rng = np.random.default_rng(0)
    fit = SimpleNamespace(
        tests=[SimpleNamespace(test=SimpleNamespace(error=0.01, phase=None))] * 3, series=lambda x: list(rng.normal(size=(3, 41)))
    )
    known = SimpleNamespace(one_in=one_in, noise=1.0)
    said = _about_misfit(fit, np.zeros(1), known, {"misfit": xr.DataArray([0.01] * 3)})
    assert any("the model is incomplete" in sentence for sentence in said) == named


def test_noise_above_the_stated_error_is_no_fault_of_the_model():
    tests = [replace(measured(force, 3, 0.1), error=0.01) for force in (0.3, 1.0, 2.0)]
    found = ss.identify_response(one_mass, FREE, tests, tries=0, samples=128)
    assert "The tests scatter more than stated" in " ".join(found.notes)
    assert "does not explain" not in " ".join(found.notes)


def sprung(law, **direction):
    """One mass on a spring and a contact to ground."""
    structure = ss.Structure(np.eye(1), np.eye(1), ("1.x",), C=np.array([[0.05]]))
    place = direction or {"tangential": (ss.between("1.x", "ground"),)}
    return ss.Problem(structure, (ss.Contact("c", law, **place),), (ss.Force("1.x", 1.0),), ("1.x",))


@pytest.mark.parametrize(
    ("name", "words"), [("cubic", ""), ("gap", "No contact opens or closes at any point"), ("slider", "friction")]
)
def test_a_spring_is_no_friction(name, words):
    """What never slips says nothing of friction only where there is some: a cubic spring has none, nor has a gap."""
    laws = {
        "cubic": lambda k: sprung(ss.CubicSpring(k)),
        "gap": lambda k: sprung(ss.Gap(k, preload=100.0), tangential=(), normal=ss.between("1.x", "ground")),
        "slider": lambda k: sprung(ss.Macroslip(k, 1.0, normal_load=100.0)),
    }
    data = ss.forced_response(laws[name](0.5), FREQUENCIES.tolist(), 0.01, samples=128).dataset
    test = ss.MeasuredResponse(FREQUENCIES, data["amplitude"].values[0, :, 0], 0.01, quantity="displacement", name="one")
    found = ss.identify_response(laws[name], {"k": (0.4, 0.1, 2.0)}, [test], tries=0, samples=128)
    assert found.values["k"] == pytest.approx(0.5, rel=1e-4)
    assert not found.dataset["slips"].any()
    assert words in " ".join(found.notes)
    assert ("friction" in " ".join(found.notes)) == (name == "slider")
    said = energies({"": ss.forced_response(laws[name](0.5), ss.hertz(0.14, 0.24), 0.01).dataset}, Charts([""]))
    assert "dissipated in contacts" in said
    assert "friction" not in said


def clipped(test, level):
    """The points of a test above a level at that level, as of a saturated sensor."""
    return replace(test, amplitude=np.minimum(test.amplitude, level))


@pytest.mark.nightly
@pytest.mark.parametrize(("over", "alone"), [(0.9, False), (0.6, True), (1.5, False)])
def test_a_bad_point_at_the_resonance_of_a_sparse_curve_is_named(over, alone):
    """Of 11 points one lies at the resonance: it bends the fit to itself, so that every point misses it. alone: of one curve."""
    frequencies = FREQUENCIES[::2]
    tests = [replace(measured(force, 3, frequencies=frequencies), phase=None) for force in (0.3, 1.0, 2.0)][: 1 if alone else 3]
    free = {name: FREE[name] for name in (("kt", "damping") if alone else FREE)}
    top, amplitude = int(np.argmax(tests[0].amplitude)), np.array(tests[0].amplitude)
    amplitude[top] *= over
    settings = {"tries": 0, "samples": 128, "harmonics": 3}
    assert not np.any(ss.identify_response(one_mass, free, tests, **settings).dataset["outlier"])
    found = ss.identify_response(one_mass, free, [replace(tests[0], amplitude=amplitude), *tests[1:]], **settings)
    assert np.argwhere(found.dataset["outlier"].values > 0.0).tolist() == [[0, top]]
    assert f"1 point of 0.3 misses the fit to the others: at {frequencies[top]:.5g} Hz" in " ".join(found.notes)
    apart, without = (
        abs(float(found.dataset[key].sel(parameter="damping")) / 0.02 - 1.0) for key in ("value", "value_without_outliers")
    )
    assert without < 0.7 * apart


@pytest.mark.slow
@pytest.mark.parametrize("over", [pytest.param(0.9, marks=pytest.mark.nightly), 0.6])
def test_a_clipped_point_is_named_and_how_far_it_moves_the_parameters(over):
    """One point at the resonance of the largest level, 10 % or 40 % too low, with noise of 1 %: the fit follows it."""
    tests = [replace(measured(force, 3), phase=None) for force in (0.3, 1.0, 2.0)]
    top = int(np.argmax(tests[0].amplitude))
    amplitude = np.array(tests[0].amplitude)
    amplitude[top] *= over
    settings = {"tries": 0, "samples": 128, "harmonics": 3}
    sound = ss.identify_response(one_mass, FREE, tests, **settings)
    assert not np.any(sound.dataset["outlier"])
    assert "miss" not in " ".join(sound.notes)
    found = ss.identify_response(one_mass, FREE, [replace(tests[0], amplitude=amplitude), *tests[1:]], **settings)
    marked = np.argwhere(found.dataset["outlier"].values > 0.0)
    assert marked.tolist() == [[0, top]]
    said = " ".join(found.notes)
    assert f"1 point of {tests[0].name} misses the fit to the others: at {np.asarray(tests[0].frequency)[top]:.5g} Hz" in said
    assert "clipped" in said
    assert "as noise is" not in said
    assert found.dataset["value_without_outliers"].values == pytest.approx(sound.dataset["value"].values, rel=0.02)
    assert float(found.dataset["outlier_deviation"].values[0, top]) == pytest.approx(over - 1.0, abs=0.04)


def test_a_flat_top_is_said():
    """Equal largest amplitudes of neighbours; not where others are equal too, nor where the response is held."""
    test = measured(1.0, 3, frequencies=FREQUENCIES[::2])
    assert flat_top(test) == []
    flat = clipped(test, float(np.sort(test.amplitude)[-3]))
    (said,) = flat_top(flat)
    assert "3 points of 1 in a row have the largest displacement" in said
    coarse = clipped(replace(test, amplitude=np.round(test.amplitude / 0.5) * 0.5 + 0.5), 99.0)
    assert flat_top(coarse) == []
    assert flat_top(replace(flat, held="response")) == []
    found = ss.identify_response(one_mass, {"kt": (0.5, 0.1, 3.0)}, [flat], tries=0, samples=128)
    assert said in found.notes
    micro = replace(flat, units={"displacement": FileUnit("mm", 1e-3)})
    assert f"displacement, {1e3 * np.max(flat.amplitude):.6g} mm, to the last digit" in flat_top(micro)[0]
    (same,) = flat_top(replace(test, amplitude=2.0, force=np.asarray(test.amplitude)))
    assert "displacement of 1 is the same at all points, while the force varies" in same
    assert "swapped" in same


def test_a_parameter_at_its_bound_is_named_with_the_bound():
    """The true kt of 0.5 and the true damping of 0.02 lie beyond their bounds."""
    tests = [measured(force, 3, frequencies=FREQUENCIES[::2]) for force in (0.3, 1.0)]
    free = {"kt": (0.6, 0.55, 1.0), "damping": ss.FreeParameter(0.005, 0.002, 0.015, each_test=True), "limit": (1.0, 0.1, 5.0)}
    found = ss.identify_response(one_mass, free, tests, tries=0, samples=128, harmonics=3)
    assert (
        "kt ends at its lower bound, 0.55. Widen the bound; if it stays there, the model is probably incomplete." in found.notes
    )
    assert (
        "damping of 1 ends at its upper bound, 0.015. Widen the bound; if it stays there, the model is probably incomplete."
        in found.notes
    )
    assert not any("limit ends" in note for note in found.notes)


@pytest.mark.nightly
def test_points_that_a_bound_misses_are_no_outliers():
    """With the stiffness held too low the resonances lie elsewhere, and whole flanks are missed."""
    tests = [measured(force, 5) for force in (0.1, 0.3, 1.0)]
    found = ss.identify_response(one_mass, FREE | {"kt": (0.3, 0.1, 0.45)}, tests, tries=0, samples=128)
    assert float(found.dataset["misfit"].max()) > 0.1
    assert not np.any(found.dataset["outlier"])
    assert any(note.startswith("kt ends at its upper bound") for note in found.notes)
