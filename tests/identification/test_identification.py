"""Contact parameters from loops: found, with intervals; refused where the loops cannot be those of the damper."""

from dataclasses import replace
from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest
from scipy.optimize import least_squares

from stickslip.cli import main
from stickslip.laboratory.identification.damper.fit import LINE_LAWS, TENFOLD, MeasuringChain, Refits, likely_gaps
from stickslip.laboratory.identification.damper.fit import over_load as of_power
from stickslip.laboratory.identification.damper.work import (
    IdentificationWork,
    friction_over_load,
    identify,
    lag_remarks,
    never_sliding,
    remarks,
)
from stickslip.laboratory.measurement.cycles import LoadRemoval, analysis, whole_cycles
from stickslip.laboratory.measurement.reconstruction import RigErrors
from stickslip.laboratory.measurement.records import Record
from stickslip.model.contact.law import LoadDependentFriction
from stickslip.model.dampers import Cylinder, Wedge
from stickslip.model.dampers.between_platforms import BetweenPlatforms, PlatformMotion, in_phase, out_of_phase
from stickslip.model.dampers.laboratory import laboratory_damper
from stickslip.show.report.identification import PRESENTATION
from stickslip.solve.platforms.cycle import CycleModel, CycleOutcome, steady_cycle
from stickslip.solve.platforms.relaxation import carry, elements_of, marched_cycle, relaxed_cycle, stuck_stiffness
from stickslip.study import read
from stickslip.study.analyses.identification import IdentificationTable
from stickslip.study.measured_curves import with_loops
from stickslip.study.templates import write_new
from stickslip.support.checks import InputError
from stickslip.support.units import UnitSystem
from verify.identification import NO_ERRORS, with_microslip
from verify.synthetic_records import synthetic_record, true_cycle, write_record

FRICTION = (0.18, 0.199, 0.45)
TRUTH = {"kt": 56e6, "kn": 84e6, "mu_L1": 0.18, "mu_L2": 0.199, "mu_R": 0.45}
MOTIONS = {"out": out_of_phase(30e-6), "in": in_phase(30e-6)}
UNKNOWN_RIG = laboratory_damper(37.0, 80.0, 0.3, kt=30e6, kn=30e6)


@pytest.fixture(scope="module")
def truths():
    rig = laboratory_damper(37.0, 80.0, FRICTION)
    return {name: true_cycle(rig, motion, 1200) for name, motion in MOTIONS.items()}


def records(truths, errors, seed=0):
    systematic = errors.draw(np.random.default_rng(100 + seed))
    return [
        synthetic_record(truth, errors, seed=2 * seed + k, systematic=systematic, name=name)
        for k, (name, truth) in enumerate(truths.items())
    ]


@pytest.mark.parametrize("name", MOTIONS)
def test_two_schemes_give_one_cycle(truths, name):
    """Newton's method in fine steps, of the synthetic records, against relaxation, of the fit."""
    rig = laboratory_damper(37.0, 80.0, FRICTION)
    shown = relaxed_cycle(elements_of(rig), 80.0, MOTIONS[name].samples(1200))
    np.testing.assert_allclose(shown[:, 0], truths[name]["force_x"], atol=1e-5)
    np.testing.assert_allclose(shown[:, 4], truths[name]["rotation"], atol=1e-10)


def newton_forces(rig, platform):
    """Force on the right platform (steps, 2) [N] by Newton's march of the rig itself."""
    model = CycleModel.of(rig)
    march = steady_cycle(model, platform)
    assert march.outcome == CycleOutcome.STEADY
    return -march.record.force @ model.right


@pytest.mark.parametrize(
    ("angle", "name", "friction"),
    [(37.0, "in", (0.18, 0.199, 0.405)), (45.0, "out", (0.18, 0.199, 0.45)), (45.0, "in", (0.18, 0.199, 0.45))],
)
def test_a_foot_that_grazes_lift_off_has_its_cycle(angle, name, friction):
    """The load of L2 falls to 0.2 N or less: relaxation alone finds no balance with 120 steps a cycle."""
    rig, platform = laboratory_damper(angle, 80.0, friction), MOTIONS[name].samples(120)
    shown = relaxed_cycle(elements_of(rig), 80.0, platform)
    np.testing.assert_allclose(shown[:, :2], newton_forces(rig, platform), atol=1e-3)


@pytest.mark.parametrize("law", LINE_LAWS)
def test_newtons_march_takes_every_law_of_the_lines(law):
    """The cycle that relaxation gives as well, with unequal lines."""
    values = {"kt": [50e6, 60e6, 45e6], "kn": [80e6, 95e6, 70e6], "mu": [0.15, 0.2, 0.3], "gaps": [0.3, 0.3, 0.3]}
    elements = LINE_LAWS[law][0](elements_of(UNKNOWN_RIG), {k: np.array(v) for k, v in values.items()}, 80.0 / 3.0)
    platform = MOTIONS["in"].samples(200)
    relaxed, marched = (cycle(elements, 80.0, platform) for cycle in (relaxed_cycle, marched_cycle))
    np.testing.assert_allclose(relaxed[:, :2], marched[:, :2], atol=1e-5)
    np.testing.assert_allclose(relaxed[:, 4], marched[:, 4], atol=1e-10)


def over_load(pulls, exponent, friction=FRICTION):
    """The laboratory damper with coefficients that follow a power of the load, given at the middle load of a line."""
    at = float(np.exp(np.mean(np.log(pulls)))) / 3.0
    rig = laboratory_damper(37.0, pulls[0], friction)
    laws = [replace(law, mu=LoadDependentFriction.power(law.mu, at, exponent)) for law in rig.laws]
    return replace(rig, laws=tuple(laws)), at


@pytest.mark.parametrize("name", MOTIONS)
def test_friction_over_the_load_in_two_schemes(name):
    """Newton's march of the rig with laws of its own, a fine table, against relaxation with the table of the fit, and the march
    of its elements: the slip limits differ by 0.3 %."""
    rig, at = over_load([80.0], -0.25)
    platform, plain = MOTIONS[name].samples(400), elements_of(laboratory_damper(37.0, 80.0, FRICTION))
    elements = of_power(plain, 10.0**-0.25, at)
    relaxed, marched = (cycle(elements, 80.0, platform) for cycle in (relaxed_cycle, marched_cycle))
    np.testing.assert_allclose(relaxed[:, :2], marched[:, :2], atol=1e-4)
    forces = newton_forces(rig, platform)
    np.testing.assert_allclose(relaxed[:, :2], forces, atol=3e-3 * np.abs(forces).max())
    constant = relaxed_cycle(plain, 80.0, platform)
    assert np.abs(constant[:, :2] - forces).max() > 0.03 * np.abs(forces).max()
    parted = LINE_LAWS["iwan"][0](plain, {k: np.array(getattr(plain, k)) for k in ("kt", "kn", "mu")}, 80.0 / 3.0)
    for k, load in enumerate((at / 10.0, at, 4.0 * at)):  # the sum of the elements of a line has the limit of the line
        limit = []
        for e in (of_power(plain, 0.6, at), of_power(parted, 0.6, at)):
            own = e.line == k
            share = load / own.sum()
            limit.append(float(np.sum(e.mu[own])) * (share + e.change @ np.maximum(share - e.bend, 0.0)))
        expected = plain.mu[k] * load * 0.6 ** np.log10(load / at)
        np.testing.assert_allclose(limit, expected, rtol=3e-3)


def test_a_table_of_friction_in_the_frame_of_a_fit_is_refused_by_the_check(tmp_path):
    path = write_new("identification", tmp_path / "study.toml")[0]
    path.write_text(path.read_text().replace("mu = 0.3", "mu = { over = [10.0, 100.0], values = [0.4, 0.3] }"))
    with pytest.raises(InputError, match=r"must be a number, the coefficient at the mean load.*Add `tenfold` to `unknown`"):
        read(path)


def test_the_power_of_the_load_is_fitted():
    """From 40 to 160 N; the same fit with constant coefficients leaves the loops by a hundred times as much."""
    pulls = (40.0, 160.0)
    rig, at = over_load(pulls, -0.2, (0.19, 0.19, 0.6))
    truths = {f"{pull:g} N": true_cycle(rig.with_pull(pull), MOTIONS["out"], 600) for pull in pulls}
    loops = [
        whole_cycles(synthetic_record(truth, NO_ERRORS, cycles=4, name=name), pull=pull)
        for pull, (name, truth) in zip(pulls, truths.items(), strict=True)
    ]
    names = ("kt", "kn", "mu_L", "mu_R", TENFOLD)
    work = IdentificationWork(tuple(loops), UNKNOWN_RIG, unknown=names, errors=NO_ERRORS)
    fit = work.fit.steps(200)
    assert fit.at == pytest.approx(at)
    start = np.log([50e6, 90e6, 0.2, 0.55, 1.0])
    found = fit.solved(start, evaluations=12)
    assert np.log10(np.exp(found.x[-1])) == pytest.approx(-0.2, abs=0.02)
    plain = replace(fit, unknowns=fit.unknowns[:-1])
    assert plain.solved(start[:-1], evaluations=12).cost > 30.0 * found.cost
    (said,) = friction_over_load(fit, found.x, np.full(5, 0.01))
    assert f"at a normal load of {at:.4g} N on a line, and follow the power -0." in said
    (said,) = friction_over_load(fit, found.x, np.full(5, 1.0))
    assert "do not show that friction depends on the load" in said
    (said,) = friction_over_load(replace(fit, pulls=(80.0,) * len(fit.pulls)), found.x, np.full(5, 1.0))
    assert "All loops have one pull" in said
    assert friction_over_load(plain, start[:-1], np.full(4, 0.01)) == ()


def test_relaxation_alone_finds_the_balance_of_a_foot_that_carries_next_to_nothing():
    """With sweeps alone the first position takes 14 000 of them."""
    elements = elements_of(laboratory_damper(37.0, 80.0, (0.67, 0.023, 0.4), kt=318e6, kn=2.04e6))
    q, anchor, shown = np.zeros(3), np.zeros(3), np.zeros((1, 5))
    assert carry(elements, np.linalg.inv(stuck_stiffness(elements)), 80.0, np.zeros((1, 2)), q, anchor, shown) == 0
    assert shown[0, 1] > 0.0


def test_a_cycle_that_takes_many_periods_to_settle():
    """Slow shakedown: the eighth cycle is 57 N away from the steady one."""
    rig, platform = laboratory_damper(37.0, 80.0, (0.148, 1.09, 0.479), kt=21.3e6, kn=38.9e6), MOTIONS["in"].samples(120)
    assert relaxed_cycle(elements_of(rig), 80.0, platform, 8) is None
    np.testing.assert_allclose(relaxed_cycle(elements_of(rig), 80.0, platform)[:, :2], newton_forces(rig, platform), atol=1e-2)


def test_exact_loops_give_the_parameters(truths):
    found = identify(records(truths, NO_ERRORS), UNKNOWN_RIG, errors=NO_ERRORS, resamples=8, population=5, generations=15)
    for name, value in found.values.items():
        assert value == pytest.approx(TRUTH[name], rel=2e-3), name


@pytest.mark.slow
def test_loops_with_the_errors_of_a_rig(truths):
    found = identify(records(truths, RigErrors(), 3), UNKNOWN_RIG, resamples=10, population=5, generations=15)
    tolerance = {"kt": 0.12, "kn": 0.08, "mu_L1": 0.12, "mu_L2": 0.12, "mu_R": 0.05}
    for name, value in found.values.items():
        assert value == pytest.approx(TRUTH[name], rel=tolerance[name]), name
        low, high = found.intervals[name]
        assert low < value < high
    assert sum(low <= TRUTH[name] <= high for name, (low, high) in found.intervals.items()) >= 4
    assert found.dataset.misfit.sel(channel="force_x").max() < 0.05
    assert float(found.dataset.lag) == 0.0
    assert abs(found.dataset.attrs["lag_seen"]) < 1e-4
    assert any(line.startswith("lag    not fitted") for line in str(found).splitlines())
    for figure in ("", "residuals", "posterior"):
        assert found.plot(figure=figure).axes


@pytest.mark.nightly
def test_a_damper_that_grazes_lift_off_is_answered():
    """Refused before: no steady cycle was found for any parameters. The load of L2 falls to 0.2 N and to nothing."""
    friction = (0.18, 0.199, 0.405)
    rig = laboratory_damper(37.0, 80.0, friction)
    cycles = {name: true_cycle(rig, motion, 1200) for name, motion in MOTIONS.items()}
    found = identify(records(cycles, RigErrors(), 3), UNKNOWN_RIG, resamples=12, population=5, generations=12)
    truth = TRUTH | dict(zip(("mu_L1", "mu_L2", "mu_R"), friction, strict=True))
    tolerance = {"kt": 0.2, "kn": 0.2, "mu_L1": 0.12, "mu_L2": 0.12, "mu_R": 0.05}
    for name, value in found.values.items():
        assert value == pytest.approx(truth[name], rel=tolerance[name]), name
    assert not [sentence for sentence in found.warnings if "refits" in sentence]
    assert sum(low <= truth[name] <= high for name, (low, high) in found.intervals.items()) >= 4
    assert found.held_out == {}


def test_no_interval_is_given_where_the_refits_failed(truths):
    """From what a run kept: 12 of 32 refits did not reduce the misfit; then cycles are missing."""
    work = IdentificationWork((*map(whole_cycles, records(truths, RigErrors())),), UNKNOWN_RIG, steps=120)
    theta = np.log([TRUTH[p.name] for p in work.fit.unknowns])
    scattered = theta + 0.01 * np.random.default_rng(0).normal(size=(20, theta.size))
    chain = {"lags": np.full(20, 1e-4), "zeros": np.full((20, 2, 2), 0.5)}
    kept = {"theta": theta, "replicates": scattered, "law": np.array(0), "held_out": np.array([])} | chain
    kept["lag_prior"] = np.array([5e-3, 0.001])
    for counts, words in (((12, 500, 0), "12 of 32 refits"), ((0, 1193, 152), "152 of 1193 cycles")):
        found = work.identification(kept | {"counts": np.array(counts)})
        assert all(np.isnan(ends).all() for ends in found.intervals.values())
        assert found.warnings[0].startswith("No intervals are given: " + words)
        assert np.isnan([found.dataset.lag_error, *found.dataset.zero_error.values.ravel()]).all()
        for lines in (str(found).splitlines(), PRESENTATION.sentences(found.dataset)):
            assert sum("no interval" in line for line in lines) == len(theta) + 3
        assert found.plot(figure="posterior").axes
    fine = work.identification(kept | {"counts": np.array((3, 500, 0))})
    assert float(fine.dataset.lag_error) == pytest.approx(1e-4)
    assert fine.dataset.zero_error.sel(channel="force_y").values == pytest.approx([0.5, 0.5])
    assert fine.warnings[0] == "3 of 23 refits did not reduce the misfit and are not in the intervals."
    assert all(low < fine.values[name] < high for name, (low, high) in fine.intervals.items())


def test_errors_of_refits_are_their_distances_from_the_final_fit():
    """Root mean squares: a shift of all refits counts as well as their scatter."""
    rng, theta = np.random.default_rng(5), np.array([1.0, -2.0])
    values, lags, zeros = theta + [0.3, 0.0] + 0.1 * rng.standard_normal((40, 2)), rng.standard_normal(40), np.ones((40, 1, 2))
    errors, lag, zero = Refits(values, 0, 40, 0, lags, zeros).errors(theta)
    assert errors**2 == pytest.approx(values.var(axis=0) + (values.mean(axis=0) - theta) ** 2, rel=1e-12)
    assert lag**2 == pytest.approx(np.var(lags) + np.mean(lags) ** 2, rel=1e-12)
    np.testing.assert_allclose(zero, [[1.0, 1.0]])


def test_gaps_of_the_refits_are_those_that_the_loops_allow(truths):
    """Contacts without gaps, and with gaps of 0.5: of gaps up to 0.6, all equally likely before, loops rule out the others."""
    friction = (0.14, 0.15, 0.25)
    rig, means, wide = laboratory_damper(37.0, 80.0, friction), [], []
    for true in (rig, with_microslip(rig, 0.5)):
        cycles = {name: true_cycle(true, motion, 1200) for name, motion in MOTIONS.items()}
        work = IdentificationWork((*map(whole_cycles, records(cycles, RigErrors())),), UNKNOWN_RIG)
        coarse, theta = work.fit.steps(120), np.log([56e6, 84e6, *friction])
        gaps, weights, _ = likely_gaps(coarse, coarse.solved(theta, evaluations=20).x)
        means.append(float(gaps @ weights))
        wide.append(float(weights[gaps > 0.45].sum()))
    assert means[0] < 0.2 < 0.3 < means[1] < 0.5
    assert wide[0] < 0.01 < 0.1 < wide[1]


LAGS = (-2.0, -1.0, -0.5, 0.0, 0.5, 1.0, 2.0)  # of the forces behind the motions, ms


@pytest.mark.parametrize("lag", LAGS)
def test_the_lag_of_the_forces_is_found(truths, lag):
    """With the true contacts, whose cycles are known: a lag of either sign, and none where there is none; at 5 and 8 Hz."""
    frequencies = {"out": 5.0, "in": 8.0}
    loops = [
        synthetic_record(truth, RigErrors(), seed=7, lag=1e-3 * lag, frequency=frequencies[name], name=name)
        for name, truth in truths.items()
    ]
    fit = IdentificationWork((*map(whole_cycles, loops),), UNKNOWN_RIG, errors=RigErrors(lag=5e-3)).fit
    theta = np.log([TRUTH[p.name] for p in fit.unknowns])
    assert 1e3 * fit.chain(fit.predicted(theta)).lag == pytest.approx(lag, abs=0.02)
    back = [whole_cycles(one).without_lag(1e-3 * lag).channel("force_x") for one in loops]
    np.testing.assert_allclose(back[0][1:8], analysis(truths["out"]["force_x"], 30)[1:8], atol=0.6)
    moved = {sentence for sentence in lag_remarks(fit, theta, 1e-5) if "The fit corrects it as a lag" in sentence}
    assert bool(moved) == bool(lag)


@pytest.mark.parametrize("prior", [1e-6, 5e-3])
def test_gains_and_lag_are_the_most_likely_ones(truths, prior):
    """The least sum of squares of the residuals, whose last numbers are gains and lag over what they are expected to be."""
    loops = [synthetic_record(truth, RigErrors(), seed=7, lag=1e-3, name=name) for name, truth in truths.items()]
    fit = IdentificationWork((*map(whole_cycles, loops),), UNKNOWN_RIG, errors=RigErrors(lag=prior)).fit
    theta = np.log([TRUTH[p.name] for p in fit.unknowns])
    computed = fit.predicted(theta)
    scale = np.array([*(fit.errors.gain(name) for name in fit.channels), prior])

    def residuals(x):
        chain = MeasuringChain(scale[:-1] * x[:-1], scale[-1] * x[-1])
        return np.concatenate([((fit.data - fit.recorded(computed, chain)) / fit.spread).ravel(), x])

    likely = scale * least_squares(residuals, np.zeros(scale.size), xtol=1e-14, ftol=1e-14).x
    found = fit.chain(computed)
    np.testing.assert_allclose([*found.gains, found.lag], likely, rtol=1e-3, atol=1e-3 * prior)


@pytest.mark.nightly
def test_a_lag_is_corrected_and_reported(truths):
    """Forces 1 ms behind: kt is 35 % low where the fit excludes it, and says so; otherwise right, with the lag beside it."""
    errors = RigErrors()
    systematic = errors.draw(np.random.default_rng(103))
    loops = [
        synthetic_record(truth, errors, seed=6 + k, systematic=systematic, lag=1e-3, name=name)
        for k, (name, truth) in enumerate(truths.items())
    ]
    settings = {"resamples": 8, "population": 5, "generations": 15}
    found = identify(loops, UNKNOWN_RIG, **settings)
    assert found.values["kt"] == pytest.approx(56e6, rel=0.12)
    assert found.values["kn"] == pytest.approx(84e6, rel=0.08)
    lag, error = float(found.dataset.lag), float(found.dataset.lag_error)
    assert lag == pytest.approx(1e-3, abs=1.5e-4)
    assert 1e-6 < error < 2e-4
    line = next(line for line in str(found).splitlines() if line.startswith("lag "))
    assert line.endswith("the forces behind the motions where positive")
    assert line in PRESENTATION.sentences(found.dataset)
    assert any(sentence.startswith("The forces come") and "behind the motions" in sentence for sentence in found.warnings)
    blind = identify(loops, UNKNOWN_RIG, errors=RigErrors(lag=0.0), **settings)
    assert blind.values["kt"] < 0.8 * 56e6
    assert any("which `errors` exclude (lag = 0)" in sentence for sentence in blind.warnings)
    assert not [line for line in str(blind).splitlines() if line.startswith("lag ")]


@pytest.mark.nightly
def test_unknown_zeros_are_found_with_their_intervals(truths):
    """Raw readings of cells, whose zeros are drawn with 20 N."""
    errors = RigErrors(zero=20.0)
    found = identify(records(truths, errors, 3), UNKNOWN_RIG, errors=errors, resamples=10, population=5, generations=15)
    drawn = {name: errors.draw(np.random.default_rng(6 + k)) for k, name in enumerate(truths)}
    misses = []
    for name, of_case in drawn.items():
        for cell in ("force_x", "force_y"):
            one = found.dataset.sel(case=name, channel=cell)
            assert 0.05 < float(one.zero_error) < 2.0
            misses.append(abs(float(one.zero) - of_case[cell][2]) / float(one.zero_error))
    assert max(misses) < 3.0
    assert {line.split(":")[0] for line in str(found).splitlines() if line.startswith("zeros ")} == {"zeros  out", "zeros  in"}
    for name, tolerance in {"kt": 0.12, "kn": 0.08, "mu_R": 0.05}.items():
        assert found.values[name] == pytest.approx(TRUTH[name], rel=tolerance), name


def removal(levels, seed, noise=0.05, size=120):
    """Readings that fall from level to level, with ramps between."""
    steps = [np.full(size, levels[0])]
    for before, after in pairwise(levels):
        steps += [np.linspace(before, after, size // 10), np.full(size, after)]
    reading = np.concatenate(steps)
    return reading + noise * np.random.default_rng(seed).standard_normal(reading.size)


def raw(truths):
    """Loops whose cells show 60 N and -35 N without load, and the load removal of each: at once, and in three steps."""
    zeros, loops, removals = {"force_x": 60.0, "force_y": -35.0}, [], []
    for record in records(truths, RigErrors(zero=0.0), 3):
        loops.append(Record(record.time, {k: v + zeros.get(k, 0.0) for k, v in record.signals.items()}, record.name))
    for seed, shares in enumerate(((1.0, 0.0), (1.0, 0.7, 0.3, 0.0))):
        forces = {
            "force_x": removal([60.0 + 20.0 * s for s in shares], seed),
            "force_y": removal([-35.0 + 25.0 * s for s in shares], seed),
        }
        removals.append(LoadRemoval(forces, f"removal {seed}"))
    return loops, removals


@pytest.mark.nightly
def test_zeros_by_load_removal(truths):
    loops, removals = raw(truths)
    wrong = identify(loops, UNKNOWN_RIG, resamples=8, population=5, generations=10)
    assert sum("fits only with a zero of" in sentence and "load removal" in sentence for sentence in wrong.warnings) >= 2
    found = identify(loops, UNKNOWN_RIG, load_removal=removals, resamples=8, population=5, generations=15)
    for name, tolerance in {"kt": 0.12, "kn": 0.08, "mu_L1": 0.12, "mu_L2": 0.12, "mu_R": 0.05}.items():
        assert found.values[name] == pytest.approx(TRUTH[name], rel=tolerance), name
    assert not any("fits only with" in sentence for sentence in found.warnings)
    case = found.fit.cases[1]
    assert case.zero_errors["force_x"] == pytest.approx(0.04 * 20.0, rel=1e-2)
    assert found.fit.spread[1, found.fit.channels.index("force_y"), 0] == pytest.approx(np.hypot(1.0, 0.12), rel=1e-2)
    assert RigErrors().with_zeros(case.zero_errors).zero_of("force_y") == pytest.approx(0.04 * 25.0, rel=1e-2)
    with pytest.raises(InputError, match="one for all loops, or 2, one a loop, but is 3"):
        identify(loops, UNKNOWN_RIG, load_removal=[*removals, removals[0]])
    shown = found.dataset.right_motion
    assert list(shown.motion.values) == ["rolling dr", "translation ds", "slip ds - dr"]
    assert "measured motion at the right contact, peak to peak, µm" in PRESENTATION.tables(found.dataset)


@pytest.mark.nightly
def test_load_removal_from_the_command_line(truths, tmp_path, monkeypatch, capsys):
    """A key of the study, and an option in its place: removals of the study do not go with other loops."""
    monkeypatch.chdir(tmp_path)
    loops, removals = raw(truths)
    for loop, one in zip(loops, removals, strict=True):
        write_record(loop, tmp_path / f"{loop.name}.csv")
        columns = np.stack([np.arange(one.forces["force_x"].size) * 1e-2, one.forces["force_x"], one.forces["force_y"]], axis=1)
        np.savetxt(f"off_{loop.name}.csv", columns, delimiter=",", header="time [s],force_x [N],force_y [N]", comments="")
    damper = '[damper]\nshape = "three_point"\nleft_angle = 37.0\nright_angle = 37.0\npull = 80.0\nkt = 5e7\nkn = 8e7\nmu = 0.3\n'
    table = '[identification]\nloops = ["out.csv", "in.csv"]\nload_removal = ["off_out.csv", "off_in.csv"]\nresamples = 8\n'
    (tmp_path / "s.toml").write_text(f'[study]\nanalysis = "identification"\n{damper}{table}')
    plan = read(tmp_path / "s.toml").plan
    assert "zeros by load removal" in plan.summary
    cases = plan.works[""].cases
    assert [case.zero_errors["force_x"] for case in cases] == pytest.approx([0.8, 0.8], rel=1e-2)
    before, text = plan.content, (tmp_path / "off_in.csv").read_text()
    (tmp_path / "off_in.csv").write_text(text.replace("time [s]", "t [s]"))
    assert read(tmp_path / "s.toml").plan.content != before
    assert "zeros" not in with_loops(tmp_path / "s.toml", [Path("out.csv"), Path("in.csv")], (), ()).plan.summary
    given = ["--load-removal", "off_out.csv", "--load-removal", "off_in.csv", "--overwrite"]
    with pytest.raises(SystemExit) as end:
        main(["identify", "out.csv", "in.csv", "--damper", "s.toml", "--out", "r", *given])
    assert end.value.code == 0
    assert "2 loops, zeros by load removal" in " ".join(capsys.readouterr().out.split())
    (tmp_path / "off_in.csv").write_text("time [s],force_x [N]\n0,1\n1,2\n")
    with pytest.raises(SystemExit) as end:
        main(["identify", "out.csv", "in.csv", "--damper", "s.toml", "--out", "q", *given])
    assert end.value.code == 2
    assert "must hold force_y" in " ".join(capsys.readouterr().err.split())


def test_each_cell_has_its_own_error_of_the_zero(truths):
    """The zero of one cell weighs what its own error says, and takes no other's place."""
    cases = tuple(map(whole_cycles, records(truths, RigErrors())))
    fit = IdentificationWork(cases, UNKNOWN_RIG, errors=RigErrors(zero_x=20.0), steps=120).fit
    assert fit.spread[0, fit.channels.index("force_x"), 0] == pytest.approx(20.0, rel=1e-2)
    assert fit.spread[0, fit.channels.index("force_y"), 0] == pytest.approx(np.hypot(0.8, 0.12), rel=1e-2)
    drawn = [RigErrors(zero_x=20.0).draw(np.random.default_rng(seed)) for seed in range(200)]
    assert np.std([one["force_x"][2] for one in drawn]) == pytest.approx(20.0, rel=0.2)
    assert np.std([one["force_y"][2] for one in drawn]) == pytest.approx(0.8, rel=0.2)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("factors", "said"),
    [
        pytest.param({}, set(), marks=pytest.mark.nightly),
        ({"platform_x": 1.3, "platform_y": 1.3}, {"rotation", "damper_y"}),
        pytest.param({"force_x": 1.12}, {"force_x"}, marks=pytest.mark.nightly),
    ],
)
def test_a_wrong_scale_is_said(truths, factors, said):
    """The fit then takes a gain error that the stated errors hardly allow."""
    scaled = [
        Record(record.time, {name: factors.get(name, 1.0) * signal for name, signal in record.signals.items()}, record.name)
        for record in records(truths, RigErrors(), 3)
    ]
    found = identify(scaled, UNKNOWN_RIG, resamples=8, population=5, generations=15)
    assert {warning.split()[0] for warning in found.warnings if "gain error" in warning} == said


@pytest.mark.parametrize(
    ("change", "words"),
    [
        (lambda s: s | {"force_y": -s["force_y"]}, "must press the right platform"),
        (lambda s: s | {"force_x": -s["force_x"]}, "must press the right platform"),
        (lambda s: s | {"platform_x": -s["platform_x"]}, "Is a sign reversed"),
        (
            lambda s: s | {"force_x": 1e-3 * s["force_x"], "force_y": 1e-3 * s["force_y"]},
            "size of the pull",
        ),
        (lambda s: s | {"rotation": 300.0 * s["rotation"]}, "unit right"),
        (lambda s: {k: v for k, v in s.items() if k != "force_y"}, "must hold force_y"),
    ],
)
def test_loops_that_cannot_be_of_this_damper_are_refused(truths, change, words):
    record = records(truths, RigErrors())[0]
    with pytest.raises(InputError, match=words):
        identify([Record(record.time, change(dict(record.signals)))], UNKNOWN_RIG)


@pytest.mark.slow
def test_a_reversed_rotation_is_refused(truths):
    turned = [
        whole_cycles(Record(r.time, dict(r.signals) | {"rotation": -r.signals["rotation"]}, r.name))
        for r in records(truths, RigErrors())
    ]
    with pytest.raises(InputError, match=r"sign reversed|miss"):
        identify(turned, UNKNOWN_RIG, resamples=8, population=5, generations=10)


@pytest.mark.parametrize("channel", ["force_x", "force_y", "rotation", "damper_y"])
def test_a_channel_with_the_wrong_sign_is_refused_at_the_true_parameters(truths, channel):
    """A gain of -200 % would explain it."""
    cases = tuple(map(whole_cycles, records(truths, RigErrors())))
    fit, theta = IdentificationWork(cases, UNKNOWN_RIG, unknown=tuple(TRUTH)).fit, np.log([*TRUTH.values()])
    remarks(fit, theta, np.full(len(TRUTH), 0.01))
    data = fit.data.copy()
    data[:, fit.channels.index(channel)] *= -1.0
    with pytest.raises(InputError, match=f"{channel} of out runs against the model"):
        remarks(replace(fit, data=data), theta, np.full(len(TRUTH), 0.01))


@pytest.mark.parametrize(("pull", "crosstalk"), [(80.0, 0.0), (1600.0, 0.01)])
def test_a_force_that_symmetry_holds_constant_refuses_no_fit(pull, crosstalk):
    """A symmetric cylinder moved out of phase bears half of the pull on each side, whatever its contacts: force_y is noise, and a
    little of force_x. What a dead cell shows in place of a force that varies is refused still."""
    damper = Cylinder(left_angle=40.0, right_angle=40.0).damper(pull=pull)
    rig = BetweenPlatforms.macroslip(damper, 56e6, 84e6, 0.2)
    truth = true_cycle(rig, out_of_phase(30e-6 * pull / 80.0), 400)
    assert np.ptp(truth["force_y"]) < 1e-6
    truth["force_y"] = truth["force_y"] + crosstalk * (truth["force_x"] - np.mean(truth["force_x"]))
    record = synthetic_record(truth, RigErrors(), seed=1, name="out")
    fit, theta = IdentificationWork((whole_cycles(record),), rig, unknown=("kt", "kn", "mu")).fit, np.log([56e6, 84e6, 0.2])
    said = remarks(fit, theta, np.full(3, 0.01))
    assert any("force_y is missed" in sentence for sentence in said) == (crosstalk > 0.0)
    dead = fit.data.copy()
    dead[:, fit.channels.index("force_x"), 1:] = fit.data[:, fit.channels.index("force_y"), 1:]
    with pytest.raises(InputError, match=r"miss force_x of out|force_x of out runs"):
        remarks(replace(fit, data=dead), theta, np.full(3, 0.01))


@pytest.mark.parametrize(
    ("options", "words"),
    [
        ({"unknown": ["kz"]}, "must begin with kt, kn or mu"),
        ({"unknown": ["mu_Q"]}, "must name lines of contact"),
        ({"resamples": 2}, "at least 8"),
        ({"bounds": {"kt": (5.0, 1.0)}}, "ascending"),
        ({"law": "macroslp"}, "Did you mean 'macroslip'"),
        ({"law": ["iwan", "iwan"]}, "each once"),
    ],
)
def test_wrong_wishes_are_refused(truths, options, words):
    with pytest.raises(InputError, match=words):
        identify(records(truths, RigErrors()), UNKNOWN_RIG, **options)


def spoiled(columns, what):
    """The table of a loop, {header: values}, with one thing wrong."""
    time, x = columns["time [s]"], columns["force_x [N]"]
    two = time < 0.4
    return {
        "a column is missing": {k: v for k, v in columns.items() if k != "force_y [N]"},
        "a unit is missing": {k.replace("force_x [N]", "force_x"): v for k, v in columns.items()},
        "a unit of another quantity": {k.replace("force_x [N]", "force_x [um]"): v for k, v in columns.items()},
        "millimetres for micrometres": {k.replace("platform_x [um]", "platform_x [mm]"): v for k, v in columns.items()},
        "kilonewtons for newtons": {k.replace("[N]", "[kN]"): v for k, v in columns.items()},
        "a reversed force": columns | {"force_y [N]": -columns["force_y [N]"]},
        "a reversed motion": columns | {"platform_x [um]": -columns["platform_x [um]"]},
        "two cycles only": {k: v[two] for k, v in columns.items()},
        "a saturated cell": columns | {"force_x [N]": np.minimum(x, x.min() + 0.8 * np.ptp(x))},
        "NaN": columns | {"force_x [N]": np.where(time > 0.5, np.nan, x)},
        "a constant signal": columns | {"force_x [N]": 0.0 * x + 3.0},
    }[what]


@pytest.mark.parametrize(
    ("what", "words"),
    [
        ("a column is missing", "must hold force_y"),
        ("a unit is missing", "The unit of force_x in loop.csv must be stated"),
        ("a unit of another quantity", "The unit of force_x in loop.csv must be one of N"),
        ("millimetres for micrometres", "Is its unit right?"),
        ("kilonewtons for newtons", "must be of the size of the pull"),
        ("a reversed force", "must press the right platform"),
        ("a reversed motion", "Is a sign reversed"),
        ("two cycles only", "must hold at least 3 whole cycles"),
        ("a saturated cell", "must not be clipped"),
        ("NaN", "must be finite"),
        ("a constant signal", "must vary"),
    ],
)
def test_the_command_line_refuses_bad_records(truths, tmp_path, monkeypatch, capsys, what, words):
    monkeypatch.chdir(tmp_path)
    path = write_record(records(truths, RigErrors())[0], tmp_path / "loop.csv")
    values = np.loadtxt(path, delimiter=",", skiprows=1)
    columns = spoiled(dict(zip(path.read_text().partition("\n")[0].split(","), values.T, strict=True)), what)
    np.savetxt(path, np.stack(list(columns.values()), axis=1), delimiter=",", header=",".join(columns), comments="", fmt="%.9g")
    study = tmp_path / "s.toml"
    damper = '[damper]\nshape = "three_point"\nleft_angle = 37.0\nright_angle = 37.0\npull = 80.0\nkt = 5e7\nkn = 8e7\nmu = 0.3\n'
    study.write_text(f'[study]\nanalysis = "identification"\n{damper}[identification]\nloops = ["x.csv"]\n')
    with pytest.raises(SystemExit) as end:
        main(["identify", str(path), "--damper", str(study), "--out", "r"])
    assert end.value.code == 2
    said = " ".join(capsys.readouterr().err.split())
    assert words in said
    assert "Traceback" not in said
    assert not (tmp_path / "r" / "results.nc").exists()


def held_out_by_law(truth, laws=("macroslip", "iwan", "microslip")):
    """Errors on loops held out, exact loops."""
    motions = {"out": out_of_phase(20e-6), "in": in_phase(20e-6)}
    loops = [synthetic_record(true_cycle(truth, m, 800), NO_ERRORS, cycles=4, samples=200, name=n) for n, m in motions.items()]
    blind, settings = laboratory_damper(37.0, 80.0, 0.2), {"population": 4, "generations": 8, "resamples": 8, "steps": 120}
    return identify(loops, blind, law=laws, **settings)


@pytest.mark.nightly
def test_the_law_of_a_damper_is_chosen_by_loops_held_out():
    """Its contacts are arrays with wide gaps: macroslip misses kn, the law that the loops choose does not."""
    truth = with_microslip(laboratory_damper(37.0, 80.0, (0.14, 0.15, 0.25)), 0.6)
    found = held_out_by_law(truth)
    assert found.law == "microslip"
    assert found.held_out["microslip"] < 0.8 * found.held_out["macroslip"]
    assert found.values["kn"] == pytest.approx(84e6, rel=0.05)
    assert set(found.dataset.law.values) == {"macroslip", "iwan", "microslip"}
    assert "law    microslip, of macroslip" in str(found)


@pytest.mark.nightly
@pytest.mark.parametrize("shape", [Cylinder, Wedge])
def test_other_dampers_than_the_laboratory_one(shape):
    """One line a side, and three: found from exact loops with the usual unknowns, or said to be unseen."""
    damper = shape(left_angle=37.0, right_angle=41.0).damper(pull=80.0)
    truth, blind = (BetweenPlatforms.macroslip(damper, *values) for values in ((56e6, 84e6, 0.2), (30e6, 30e6, 0.3)))
    loops = [synthetic_record(true_cycle(truth, m, 800), NO_ERRORS, cycles=4, samples=200, name=n) for n, m in MOTIONS.items()]
    found = identify(loops, blind, errors=NO_ERRORS, population=4, generations=8, resamples=8, steps=250)
    assert list(found.values) == ["kt", "kn", "mu_L", "mu_R"]
    unseen = {sentence.partition(":")[0] for sentence in found.warnings if "never slides" in sentence}
    assert len(unseen) < 2
    for name, value in {"kt": 56e6, "kn": 84e6, "mu_L": 0.2, "mu_R": 0.2}.items():
        assert name in unseen or found.values[name] == pytest.approx(value, rel=0.02), name


def test_pulls_of_other_loops_are_refused_with_what_to_write():
    table = IdentificationTable(loops=["a.csv"], pulls=[40.0, 160.0])
    with pytest.raises(InputError, match=r"1 entries, one a loop, but is 2\. Write the pulls of these loops"):
        table.cases(Path(), UnitSystem())


def test_friction_of_a_contact_that_never_slides_is_said(truths):
    work = IdentificationWork((*map(whole_cycles, records(truths, NO_ERRORS)),), UNKNOWN_RIG, steps=250)
    theta = np.log([TRUTH[p.name] for p in work.fit.unknowns])
    said = never_sliding(work.fit, theta, UNKNOWN_RIG)
    assert len(said) == 1
    assert said[0].startswith("mu_R: its contact never slides")


@pytest.mark.slow
def test_minima_far_from_the_best_do_not_end_the_search():
    """A foot whose load falls to 0.07 N, at 45 degrees with small higher harmonics. The first four starts lead to minima of three
    to eight times the stiffness and of eight times the least sum of squares."""
    rig, harmonics = laboratory_damper(45.0, 80.0, FRICTION), np.zeros((2, 23))
    harmonics[0, [2, 5, 10, 22]] = 30e-6, 0.9e-6, 0.3e-6, 0.1e-6
    cells = RigErrors().draw(np.random.default_rng(1006))
    loops = [
        synthetic_record(
            true_cycle(rig, PlatformMotion(harmonics[::way])),
            RigErrors(),
            seed=60 + axis,
            systematic=cells,
            samples=400,
            name="xy"[axis],
        )
        for axis, way in enumerate((1, -1))
    ]
    found = identify(loops, laboratory_damper(45.0, 80.0, 0.3, kt=30e6, kn=30e6), resamples=8, seed=6)
    assert found.values["kt"] == pytest.approx(TRUTH["kt"], rel=0.1)
    assert found.values["kn"] == pytest.approx(TRUTH["kn"], rel=0.1)
