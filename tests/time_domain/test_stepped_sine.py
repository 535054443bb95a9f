"""Stepped sines against the closed form of a linear transient, and against steady responses with friction."""

import numpy as np
import pytest

import stickslip as ss
from stickslip.results.schema import stamped
from stickslip.show.report.free_decay import highest, ways
from stickslip.show.report.free_decay import stepped_sentences as sentences
from stickslip.show.report.free_decay import stepped_tables as tables
from stickslip.show.report.markup import presentation_of
from stickslip.study.reading import job

OMEGA, RATIO = 100.0, 0.02


def slider(normal_load):
    structure = ss.Structure(np.eye(1), np.array([[OMEGA**2]]), ("1.x",), C=np.array([[2.0 * RATIO * OMEGA]]))
    contact = ss.Contact("slider", ss.Macroslip(2e3, 1.0, normal_load=normal_load), ({"1.x": 1.0},))
    return ss.Problem(structure, (contact,), (ss.Force("1.x", 1.0),), ("1.x",), "Mass on a slider")


def test_a_linear_transient_goes_on_from_dwell_to_dwell():
    """Stuck: x = Re(X exp(iωt)) + exp(−δt) (a cos ω_d t + b sin ω_d t) of each dwell, from the state that the last one left."""
    problem, stuck = slider(1e6), np.sqrt(OMEGA**2 + 2e3)
    delta = RATIO * OMEGA
    damped = np.sqrt(stuck**2 - delta**2)
    found = ss.stepped_sine(problem, [14.0, 17.0, 15.0], dwell=4, steps_per_period=2000)
    motion, speed = 0.0, 0.0
    for k, frequency in enumerate((14.0, 17.0, 15.0)):
        omega = 2.0 * np.pi * frequency
        X = 1.0 / (stuck**2 - omega**2 + 2j * delta * omega)
        a = motion - X.real
        b = (speed - np.real(1j * omega * X) + delta * a) / damped
        end = 4.0 / frequency
        t = end - (1.0 - np.arange(4000) / 4000.0) / frequency
        x = np.real(X * np.exp(1j * omega * t)) + np.exp(-delta * t) * (a * np.cos(damped * t) + b * np.sin(damped * t))
        harmonic = 2.0 * np.abs(np.mean(x * np.exp(-1j * omega * t)))
        assert float(found.dataset["amplitude"][k, 0]) == pytest.approx(harmonic, rel=1e-3)
        fading, angle = np.exp(-delta * end), damped * end
        left = a * np.cos(angle) + b * np.sin(angle)
        motion = X.real + fading * left
        speed = np.real(1j * omega * X) + fading * (damped * (b * np.cos(angle) - a * np.sin(angle)) - delta * left)
    assert found.end.motion[0] == pytest.approx(motion, rel=2e-3)
    assert found.end.velocity[0] == pytest.approx(speed, rel=5e-3)


def test_long_dwells_lead_to_the_steady_response():
    """With slip; short ones do not. The state goes on: a test of its own from there begins steady."""
    problem, frequencies = slider(1.0), [15.0, 16.0]
    response = ss.forced_response(problem, frequencies, 4.0, harmonics=9)
    steady = response.dataset["amplitude"].values[0, :, 0]
    long, short = (ss.stepped_sine(problem, frequencies, 4.0, dwell, steps_per_period=400) for dwell in (60, 3))
    np.testing.assert_allclose(long.dataset["amplitude"].values[:, 0], steady, rtol=2e-3)
    assert np.abs(short.dataset["amplitude"].values[:, 0] / steady - 1.0).max() > 0.05
    beside = long.with_response(response)
    np.testing.assert_array_equal(beside.dataset["balance_amplitude"].values[:, 0], steady)
    said = presentation_of(stamped(beside.dataset, "stepped_sine")).sentences(beside.dataset)
    assert said[0] == "2 dwells of 60 periods: all end within 0.1 % of the steady motion, by estimate"
    apart = np.abs(long.dataset["amplitude"].values[:, 0] - steady).max() / steady.max()
    assert f"differs from the dwells that end near the steady motion by up to {100.0 * apart:.2g} % of its highest" in said[2]
    for wrong, other in (("frequencies", {"band": [15.0, 17.0]}), ("force level 4", {"force": 3.0})):
        with pytest.raises(ss.InputError, match=wrong):
            long.with_response(ss.forced_response(problem, **{"band": frequencies, "force": 4.0, "harmonics": 1} | other))
    with pytest.raises(ss.InputError, match="is that of another problem"):
        long.with_response(ss.forced_response(slider(2.0), frequencies, 4.0, harmonics=1))
    unknown = long.dataset.assign(distance=("step", np.full(long.dataset.sizes["step"], np.inf)))  # where changes do not fall
    for table in tables(unknown).values():
        assert table["estimated distance from the steady motion [%]"].isna().all()
    again = ss.stepped_sine(problem, [16.0], 4.0, 3, start=long.end, steps_per_period=400)
    assert float(again.dataset["amplitude"][0, 0]) == pytest.approx(steady[1], rel=2e-3)
    decay = ss.free_decay(problem, 0.5, start=long.end, steps=5000).dataset
    assert float(decay["displacement"][0, 0]) == pytest.approx(long.end.motion[0], rel=1e-9)
    amplitude, distance = long.plot().axes
    np.testing.assert_allclose(amplitude.lines[0].get_ydata(), 1e3 * 1e3 * long.dataset["amplitude"].values[:, 0])
    assert distance.get_yscale() == "log"


def test_wrong_input_is_refused():
    problem = slider(1.0)
    for wrong, message in (
        ({"frequencies": []}, "frequenc"),
        ({"frequencies": [15.0], "dwell": 1}, "dwell must be"),
        ({"frequencies": [15.0], "force": -1.0}, "force must be positive"),
        ({"frequencies": ss.hertz(10.0, 20.0)}, "frequencies must be a list of frequencies in Hz, in the order of the test"),
        ({"frequencies": [15.0], "steps_per_period": "many"}, "steps_per_period must be a whole number"),
        ({"frequencies": [15.0], "method": "newmark"}, "method must be a GeneralisedAlpha or a Newmark"),
        ({"frequencies": [15.0], "start": "rest"}, "start must be a TimeStart"),
    ):
        with pytest.raises(ss.InputError, match=message):
            ss.stepped_sine(problem, **wrong)
    with pytest.raises(ss.InputError, match="must have motion, velocity and intercepts"):
        ss.stepped_sine(problem, [15.0], start=ss.stepped_sine(ss.rigs.three_mass_wedge(), [220.0], dwell=2).end)
    disk = ss.rigs.lumped_blisk()
    for refused in (lambda: ss.stepped_sine(disk, [150.0]), lambda: ss.free_decay(disk, 0.1, frequency=150.0)):
        with pytest.raises(ss.InputError, match="Time integration needs one structure for all harmonics"):
            refused()


STUDY = """
[study]
analysis = "stepped_sine"

[structure]
dofs = ["1.x"]
matrices = {{ M = [[1.0]], K = [[1e4]], C = [[4.0]] }}

[[contact]]
tangential = {{ "1.x" = 1.0 }}
law = "macroslip"
kt = 2e3
mu = 1.0
normal_load = 1.0

[[force]]
direction = "1.x"
amplitude = 1.0

[sweep]
{where}
harmonics = 9
outputs = ["1.x"]

[stepped_sine]
force = 4.0
dwell = 3
steps_per_period = 400
{more}
"""


def test_a_study_goes_up_and_down_beside_the_harmonic_balance(tmp_path):
    """A band is cut into equal steps and a list taken as it is; the study computes what Python does."""
    for where, more, order in (
        ("frequency = [15.0, 16.0]", "count = 3\nback = true", [15.0, 15.5, 16.0, 15.5, 15.0]),
        ("frequency = [16.0, 15.0]", "count = 3\nbalance = false", [16.0, 15.5, 15.0]),
        ("at = [15.0, 16.0, 15.0]", "", [15.0, 16.0, 15.0]),
    ):
        works = job(STUDY.format(where=where, more=more), tmp_path, "study").plan.works
        assert [work.frequencies for work in works.values() if hasattr(work, "frequencies")] == [order]
        assert len(works) == (1 if "false" in more else 2)
    plan = job(STUDY.format(where=where, more=""), tmp_path, "study").plan
    data = plan.dataset({name: [work.solve(0, lambda share: None)] for name, work in plan.works.items()})
    own = ss.stepped_sine(slider(1.0), order, 4.0, 3, steps_per_period=400).dataset
    np.testing.assert_allclose(data["amplitude"].values, own["amplitude"].values, rtol=1e-9)
    steady = ss.forced_response(slider(1.0), order, 4.0, harmonics=9).dataset["amplitude"].values[0]
    np.testing.assert_allclose(data["balance_amplitude"].values, steady, rtol=1e-9)
    assert [(way, run.tolist()) for way, run in ways(data)] == [("upwards", [0, 1]), ("downwards", [1, 2])]
    assert [step for _, _, step in highest(data)] == [
        int(np.argmax(own["amplitude"].values[:2])),
        1 + int(np.argmax(own["amplitude"].values[1:])),
    ]
    with pytest.raises(ss.InputError, match="count needs a band"):
        job(STUDY.format(where=where, more="count = 5"), tmp_path, "study")


def test_frequencies_without_a_steady_solution_are_named():
    """A balance that failed at one frequency leaves a gap there; one that failed at all leaves only gaps."""
    problem, frequencies = slider(1.0), [15.0, 16.0]
    marched = ss.stepped_sine(problem, frequencies, 4.0, 3, steps_per_period=400)
    response = ss.forced_response(problem, frequencies, 4.0, harmonics=1)
    for lost in ([0], [0, 1]):
        data = response.dataset.copy(deep=True)
        data["outcome"][0, lost] = 2
        found = marched.with_response(ss.ForcedResponse(data, problem)).dataset
        assert np.flatnonzero(np.isnan(found["balance_amplitude"].values[:, 0])).tolist() == lost
        (said,) = presentation_of(stamped(found, "stepped_sine")).failures(found)
        assert said.startswith(f"harmonic balance: {len(lost)} frequenc")
        assert len(sentences(found)) >= 3
