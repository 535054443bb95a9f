"""Speed sweeps of study files: what goes with the speed, and faults."""

import numpy as np
import pytest

import stickslip as ss
from stickslip.study import job
from stickslip.support.checks import InputError

STUDY = """
[study]
analysis = "speed_sweep"
[structure]
matrices = {M = [[1.0, 0.0], [0.0, 0.1]], K = [[13000.0, 0.0], [0.0, 2000.0]]}
dofs = ["1.x", "2.y"]
[damping]
modal = 0.01
[[contact]]
law = "macroslip"
tangential = ["1.x", "ground"]
normal = ["2.y", "ground"]
kt = 3000.0
kn = 3000.0
mu = 0.4
[[force]]
direction = "1.x"
amplitude = 1.0
[[force]]
direction = "2.y"
static = 8.0
[sweep]
outputs = ["1.x"]
harmonics = 1
samples = 64
[speed_sweep]
speed = [300.0, 900.0]
engine_orders = [2, 4]
reference_speed = 600.0
stiffness_at_rest = [[10000.0, 0.0], [0.0, 2000.0]]
"""


def test_a_study_goes_with_the_speed_from_its_reference(tmp_path):
    plan = job(STUDY, tmp_path, "study").plan
    omega = 600.0 * 2.0 * np.pi / 60.0
    for speed, stiffness, pull in ((0.0, 1e4, 0.0), (omega, 1.3e4, 8.0), (0.5 * omega, 1.075e4, 2.0)):
        at = plan.works[""].parts[0].problem.at_speed(speed)
        np.testing.assert_allclose(at.structure.K[0, 0], stiffness, rtol=1e-12)
        np.testing.assert_allclose(at.static_load, [0.0, pull], atol=1e-12)
    assert [part.settings.frequencies for part in plan.works[""].parts] == [(10.0, 30.0), (20.0, 60.0)]
    assert plan.works[""].words[1] == "engine order 4, force level 1"


def test_a_study_gives_what_python_gives(tmp_path):
    plan = job(STUDY, tmp_path, "study").plan
    study = ss.SpeedSweep(plan.dataset({"": [plan.works[""].solve(k, lambda share: None) for k in range(2)]}), {})
    python = ss.speed_sweep(plan.works[""].parts[0].problem, (300.0, 900.0), [2, 4], harmonics=1, samples=64)
    np.testing.assert_array_equal(study.dataset["amplitude"], python.dataset["amplitude"])
    assert len(study.peaks()) == len(python.peaks()) >= 1


def test_the_stiffness_at_rest_may_lie_in_a_file(tmp_path):
    np.savez(tmp_path / "rest.npz", K=np.diag([10.0, 2.0]))
    text = STUDY.replace("[[10000.0, 0.0], [0.0, 2000.0]]", '"rest.npz"', 1)
    text = 'units = {length = "mm"}\n' + text.replace("13000.0", "13.0").replace(" 2000.0]]}", " 2.0]]}")
    problem = job(text, tmp_path, "study").plan.works[""].parts[0].problem
    np.testing.assert_allclose(problem.at_speed(0.0).structure.K, np.diag([1e4, 2e3]), rtol=1e-12)
    assert ss.Problem.at_speed(problem, 600.0 * np.pi / 30.0).structure.K[0, 0] == pytest.approx(1.3e4)


@pytest.mark.parametrize(
    ("before", "after", "words"),
    [
        ("speed = [300.0, 900.0]", "speed = [300.0, 300.0]", "two different ends"),
        ("speed = [300.0, 900.0]", "speed = [-300.0, 900.0]", "speed"),
        ("speed = [300.0, 900.0]", "speed = [300.0]", "speed"),
        ("[2, 4]", "[2, 2]", "engine_orders"),
        ("[2, 4]", "[0]", "engine_orders"),
        ("[2, 4]", "[2.5]", "engine_orders"),
        ("[2, 4]", "[]", "engine_orders"),
        ("reference_speed = 600.0", "", "reference_speed must be given"),
        ("reference_speed = 600.0", "reference_speed = 0.0", "reference_speed"),
        ("[[10000.0, 0.0], [0.0, 2000.0]]", "[[10000.0]]", "shape of K"),
        ("[[10000.0, 0.0], [0.0, 2000.0]]", "[[10000.0, 1.0], [0.0, 2000.0]]", "symmetric"),
        ("[[10000.0, 0.0], [0.0, 2000.0]]", '"nowhere.npz"', "nowhere.npz"),
        ("[[10000.0, 0.0], [0.0, 2000.0]]", "[[-1e6, 0.0], [0.0, 2000.0]]", "positive definite"),
        ("harmonics = 1", "harmonics = 1\nfrequency = [10.0, 20.0]", "range of its own"),
        ('analysis = "speed_sweep"', 'analysis = "forced_response"', "speed_sweep"),
    ],
)
def test_faults_are_said(tmp_path, before, after, words):
    assert before in STUDY
    place = STUDY.rindex(before)
    with pytest.raises(InputError, match=words):
        job(STUDY[:place] + after + STUDY[place + len(before) :], tmp_path, "study")


def test_something_must_go_with_the_speed(tmp_path):
    text = STUDY.replace("static = 8.0", "static = 0.0").replace("stiffness_at_rest = [[10000.0, 0.0], [0.0, 2000.0]]", "")
    with pytest.raises(InputError, match="goes with the speed"):
        job(text, tmp_path, "study")
