"""Contact parameters from loops: found, with intervals; refused where the loops cannot be those of the damper."""

import numpy as np
import pytest

from stickslip.analyses.identification import identify
from stickslip.checks import InputError
from stickslip.cli import main
from stickslip.dampers.platform_motion import in_phase, out_of_phase
from stickslip.measurement.cycles import whole_cycles
from stickslip.measurement.records import Record, write_record
from stickslip.measurement.rig_errors import RigErrors
from stickslip.measurement.synthetic import NO_ERRORS, synthetic_record, true_cycle
from stickslip.rigs.laboratory_damper import laboratory_damper
from stickslip.solve.platform_relaxation import elements_of, relaxed_cycle

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


def test_exact_loops_give_the_parameters(truths):
    found = identify(records(truths, NO_ERRORS), UNKNOWN_RIG, errors=NO_ERRORS, resamples=8, population=5, generations=15)
    for name, value in found.values.items():
        assert value == pytest.approx(TRUTH[name], rel=2e-3), name


def test_loops_with_the_errors_of_a_rig(truths):
    found = identify(records(truths, RigErrors(), 3), UNKNOWN_RIG, resamples=10, population=5, generations=15)
    tolerance = {"kt": 0.12, "kn": 0.08, "mu_L1": 0.12, "mu_L2": 0.12, "mu_R": 0.05}
    for name, value in found.values.items():
        assert value == pytest.approx(TRUTH[name], rel=tolerance[name]), name
        low, high = found.intervals[name]
        assert low < value < high
    assert sum(low <= TRUTH[name] <= high for name, (low, high) in found.intervals.items()) >= 4
    assert found.dataset.misfit.sel(channel="force_x").max() < 0.05
    for figure in ("", "residuals", "posterior"):
        assert found.plot(figure=figure).axes


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


def test_a_reversed_rotation_is_refused(truths):
    turned = [
        whole_cycles(Record(r.time, dict(r.signals) | {"rotation": -r.signals["rotation"]}, r.name))
        for r in records(truths, RigErrors())
    ]
    with pytest.raises(InputError, match=r"sign reversed|miss"):
        identify(turned, UNKNOWN_RIG, resamples=8, population=5, generations=10)


@pytest.mark.parametrize(
    ("options", "words"),
    [
        ({"unknown": ["kz"]}, "must begin with kt, kn or mu"),
        ({"unknown": ["mu_Q"]}, "must name lines of contact"),
        ({"resamples": 2}, "at least 8"),
        ({"bounds": {"kt": (5.0, 1.0)}}, "ascending"),
    ],
)
def test_wrong_wishes_are_refused(truths, options, words):
    with pytest.raises(InputError, match=words):
        identify(records(truths, RigErrors()), UNKNOWN_RIG, **options)


def test_the_command_line_says_what_is_wrong(truths, tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    path = write_record(records(truths, RigErrors())[0], tmp_path / "loop.csv")
    study = tmp_path / "s.toml"
    damper = '[damper]\nshape = "three_point"\npull = 80.0\nkt = 5e7\nkn = 8e7\nmu = 0.3\n'
    study.write_text(f'[study]\nanalysis = "identification"\n{damper}[identification]\nloops = ["x.csv"]\n')
    lines = path.read_text().replace("force_y [N]", "force_q [N]")
    path.write_text(lines)
    with pytest.raises(SystemExit) as end:
        main(["identify", str(path), "--damper", str(study), "--out", "r"])
    assert end.value.code == 2
    assert "force_y" in capsys.readouterr().err
