"""Stepped sines against the closed form of a linear transient, and against steady responses with friction."""

import numpy as np
import pytest

import stickslip as ss

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
    steady = ss.forced_response(problem, frequencies, 4.0, harmonics=9).dataset["amplitude"].values[0, :, 0]
    long, short = (ss.stepped_sine(problem, frequencies, 4.0, dwell, steps_per_period=400) for dwell in (60, 3))
    np.testing.assert_allclose(long.dataset["amplitude"].values[:, 0], steady, rtol=2e-3)
    assert np.abs(short.dataset["amplitude"].values[:, 0] / steady - 1.0).max() > 0.05
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
        ({"frequencies": [15.0], "force": -1.0}, "force level must be positive"),
        ({"frequencies": ss.hertz(10.0, 20.0)}, "frequencies must be a list of frequencies in Hz, in the order of the test"),
        ({"frequencies": [15.0], "steps_per_period": "many"}, "steps_per_period must be a whole number"),
        ({"frequencies": [15.0], "method": "newmark"}, "method must be a GeneralisedAlpha or a Newmark"),
        ({"frequencies": [15.0], "start": "rest"}, "start must be a TimeStart"),
    ):
        with pytest.raises(ss.InputError, match=message):
            ss.stepped_sine(problem, **wrong)
    with pytest.raises(ss.InputError, match="must have motion, velocity and intercepts"):
        ss.stepped_sine(problem, [15.0], start=ss.stepped_sine(ss.rigs.three_mass_wedge(), [220.0], dwell=2).end)
