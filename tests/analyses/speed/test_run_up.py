"""Run-ups in time: against an independent integration with steps of their own, and the quasi-steady sweep."""

from dataclasses import replace
from math import cos

import numpy as np
import pytest

import stickslip as ss

RPM = 60.0 / (2.0 * np.pi)


def one_mass(stiffening: float = 3.0) -> ss.Problem:
    """A mass with a slider, which the speed stiffens, under engine order 2."""
    structure = ss.Structure(np.eye(1), 100.0 * np.eye(1), ("1.x",), 1.0 * np.eye(1))
    slider = ss.Contact("slider", ss.Macroslip(kt=20.0, mu=0.5, normal_load=1.0), tangential=(ss.between("1.x", "ground"),))
    speed = ss.SpeedDependence(2, stiffening * np.eye(1))
    return ss.Problem(structure, (slider,), (ss.Force("1.x", 1.0),), ("1.x",), speed=speed)


def integrated(first: float, last: float, duration: float, stiffening: float) -> tuple[np.ndarray, np.ndarray]:
    """Excitation phase and displacement of `one_mass` in time, by symplectic Euler and return mapping; Ω in rad/s, K at every
    step. Ten seconds at the first speed precede the run."""
    step, x, v, s, phase, t = 2e-4, 0.0, 0.0, 0.0, -2.0 * 20.0 * first, -20.0
    phases, moved = [], []
    while t < duration:
        speed = first + (last - first) * max(t, 0.0) / duration
        pull = min(max(20.0 * (x - s), -0.5), 0.5)
        v += step * (2.0 * cos(phase) - v - (100.0 + stiffening * speed**2) * x - pull)
        x += step * v
        s += x - s - min(max(20.0 * (x - s), -0.5), 0.5) / 20.0
        t += step
        phase += 2.0 * speed * step
        if t > 0.0:
            phases.append(phase)
            moved.append(x)
    return np.array(phases), np.array(moved)


@pytest.mark.parametrize(("first", "last"), [(40.0, 110.0), pytest.param(110.0, 40.0, marks=pytest.mark.nightly)])
@pytest.mark.parametrize(("stiffening", "tolerance"), [(0.0, 0.01), (2.0, 0.03)])  # up to 6 % in a cycle of 50
def test_a_fast_run_is_that_of_an_independent_integration(first, last, stiffening, tolerance):
    """The stiffness of a cycle is that at its middle, which the larger tolerance allows for."""
    found = ss.run_up(one_mass(stiffening), (first, last), 20.0, force=2.0, steps_per_period=400).dataset.isel(case=0)
    phases, moved = integrated(first / RPM, last / RPM, 20.0, stiffening)
    cycles = np.floor(phases / (2.0 * np.pi)).astype(int)
    largest = np.array([np.abs(moved[cycles == k]).max() for k in range(found.sizes["cycle"])])
    np.testing.assert_allclose(found["max_abs"].values[:, 0], largest, rtol=tolerance)
    np.testing.assert_allclose(found["speed"], first + (last - first) * found["time"] / 20.0, rtol=1e-12)


@pytest.mark.nightly
def test_a_slow_run_passes_the_amplitudes_of_the_sweep_and_a_fast_one_lags_behind():
    problem = one_mass()
    sweep = ss.speed_sweep(problem, (30.0, 95.0), force=2.0, harmonics=7).dataset.isel(engine_order=0, case=0, output=0)
    deviations = {}
    for duration in (600.0, 30.0):
        for ends in ((40.0, 90.0), (90.0, 40.0)):
            found = ss.run_up(problem, ends, duration, force=2.0).dataset.isel(case=0)
            quasi = np.interp(found["speed"], sweep["speed"], sweep["amplitude"])
            deviations[duration, ends[0]] = float(np.abs(found["amplitude"].values[:, 0] / quasi - 1.0).max())
    assert max(deviations[600.0, first] for first in (40.0, 90.0)) < 0.02
    assert min(deviations[30.0, first] for first in (40.0, 90.0)) > 0.1


@pytest.mark.slow
def test_pulls_follow_the_speed_and_engine_orders_are_chosen():
    """The pull on a wedge follows the speed; a run begins with the steady motion of its first speed."""
    at = {speed: ss.rigs.blade_and_wedge(pull=60.0 * (speed / 6000.0) ** 2) for speed in (3000.0, 6000.0)}
    found = ss.run_up(at, (6600.0, 7000.0), 0.3, 3, force=6.0).dataset.isel(case=0)
    assert int(found["engine_order"]) == 3
    assert found["message"].item() == "Complete."
    np.testing.assert_allclose(found["frequency"], 3.0 * found["speed"] / 60.0, rtol=1e-12)
    steady = ss.speed_sweep(at, (6600.0, 7000.0), [3], force=6.0, harmonics=7).dataset.isel(engine_order=0, case=0, output=0)
    assert float(found["amplitude"][0, 0]) == pytest.approx(float(steady["amplitude"][0]), rel=0.01)


@pytest.mark.parametrize(
    ("change", "words"),
    [
        (lambda: ss.run_up(one_mass().at_speed(1.0), (10.0, 20.0), 10.0), "speed"),
        (lambda: ss.run_up(one_mass(), (10.0, 10.0), 10.0), "different"),
        (lambda: ss.run_up(one_mass(), (-10.0, 10.0), 10.0), "positive"),
        (lambda: ss.run_up(one_mass(), (10.0, 20.0), 0.0), "positive"),
        (lambda: ss.run_up(one_mass(), (10.0, 20.0), 1.0), "cycles"),
        (lambda: ss.run_up(one_mass(), (10.0, 20.0), 10.0, 0), "at least 1"),
        (lambda: ss.run_up({10.0: one_mass().at_speed(1.0)}, (10.0, 20.0), 10.0), "two speeds"),
        (lambda: ss.run_up(3, (10.0, 20.0), 10.0), "models"),
    ],
)
def test_bad_input_is_said(change, words):
    with pytest.raises(ss.InputError, match=words):
        change()


def blade_and_wedge(speed: float) -> ss.Problem:
    """The problem of `examples/run_up_in_time.py` at a speed in rev/min."""
    share = (speed / 6000.0) ** 2
    rig = ss.rigs.blade_and_wedge(pull=60.0 * share)
    K = rig.structure.K.copy()
    K[0, 0] *= 1.0 + 0.15 * share
    return replace(rig, structure=replace(rig.structure, K=K))


@pytest.mark.nightly
def test_a_run_keeps_what_the_last_slip_left():
    """At 7800 rev/min a contact sticks: downwards the run follows the sweep, upwards it lies above, however slow it is."""
    models = {speed: blade_and_wedge(speed) for speed in (3000.0, 6000.0)}

    def there(dataset):
        order = np.argsort(dataset["speed"].values)
        return float(np.interp(7800.0, dataset["speed"].values[order], dataset["amplitude"].values[order]))

    def amplitude(first, last, duration):
        return there(ss.run_up(models, (first, last), duration, 3, force=6.0).dataset.isel(case=0, output=0))

    swept = ss.speed_sweep(models, (7750.0, 7850.0), [3], force=6.0, harmonics=9).dataset
    steady = there(swept.isel(engine_order=0, case=0, output=0))
    fast, slow = amplitude(7600.0, 7900.0, 1.0), amplitude(7600.0, 7900.0, 4.0)
    assert slow > 1.04 * steady
    assert slow == pytest.approx(fast, rel=0.02)
    assert amplitude(7900.0, 7600.0, 4.0) == pytest.approx(steady, rel=0.01)
