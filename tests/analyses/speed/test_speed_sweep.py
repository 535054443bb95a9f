"""Speed sweeps: against problems at one speed, closed forms, the whole disk, and time integration."""

import re
from dataclasses import replace
from math import cos

import numpy as np
import pytest
from balance.compiled_parts import receptance_of

import stickslip as ss
from stickslip.analyses.harmonic_choice import sufficient_harmonics
from stickslip.analyses.speed.models import at_reference_speed, synchronous
from stickslip.analyses.speed.speed_sweep import SpeedSweepSettings, SpeedSweepWork
from stickslip.show.report.markup import presentation_of
from stickslip.solve.balance.balance import HarmonicBalance, Point

M = np.diag([1.0, 0.5, 0.2])
K = np.array([[200.0, -100.0, 0.0], [-100.0, 180.0, -40.0], [0.0, -40.0, 90.0]])
K1 = np.array([[3.0, -1.0, 0.0], [-1.0, 2.0, -0.5], [0.0, -0.5, 1.5]])
RPM = 60.0 / (2.0 * np.pi)
LIGHT = ss.ModalDamping(0.01)


def chain(engine_order: int = 2, stiffening: float = 1.0, damping: ss.ModalDamping | None = LIGHT) -> ss.Problem:
    """Three masses, of which K and the pull on a contact go with the square of the speed."""
    structure = ss.Structure(M, K, dofs=("1.x", "2.x", "3.x"), damping=damping)
    rubbing = ss.Macroslip(kt=30.0, kn=50.0, mu=0.4)
    contact = ss.Contact("pad", rubbing, tangential=(ss.between("2.x", "ground"),), normal={"3.x": 1.0})
    speed = ss.SpeedDependence(engine_order, stiffening * K1 if stiffening else None, (ss.Force("3.x", static=0.5),))
    return ss.Problem(structure, (contact,), (ss.Force("1.x", 1.0),), ("1.x", "2.x"), speed=speed)


def ring(engine_order: int = 2) -> ss.TunedDisk:
    """Six sectors of one mass with a slider to the next one, stiffened and pulled by the speed."""
    sector = ss.Structure(np.eye(2), np.array([[100.0, -20.0], [-20.0, 90.0]]), ("a.x", "a.y"))
    disk = ss.sector_chain(sector, 6, np.array([[-15.0, 2.0], [0.0, -10.0]])).with_damping(ss.ModalDamping(0.01))
    added = ss.sector_chain(ss.Structure(np.eye(2), np.array([[2.0, 0.2], [0.2, 1.0]]), ("a.x", "a.y")), 6, -0.3 * np.eye(2))
    contact = ss.Contact(
        "joint", ss.Macroslip(kt=20.0, kn=40.0, mu=0.4), tangential=(ss.between("next/a.x", "a.x"),), normal={"a.y": 1.0}
    )
    speed = ss.SpeedDependence(engine_order, added.stiffnesses, (ss.Force("a.y", static=0.5),))
    return ss.TunedDisk(disk, (contact,), (ss.Force("a.x", 1.0),), ("a.x",), engine_order=engine_order, speed=speed)


@pytest.mark.parametrize("problem", [chain(), chain(1), chain(stiffening=0.0), chain(damping=None), ring(), ring(3)])
@pytest.mark.parametrize("harmonics", [3, [0, 1, 3]])
def test_a_point_is_that_of_the_problem_at_its_speed(problem, harmonics):
    samples = 66
    balance = HarmonicBalance(problem, harmonics, samples)
    forces = np.random.default_rng(0).normal(size=(balance.rows, balance.columns))
    forces[:, balance.dropped] = 0.0
    for omega in (0.3, 7.0, 15.0):
        alone = HarmonicBalance(problem.at_frequency(omega), harmonics, samples)
        assert alone.problem.speed is None
        one, other = (each.evaluate(Point(forces, omega, 1.3)) for each in (balance, alone))
        np.testing.assert_allclose(one.w, other.w, atol=1e-12 * np.abs(other.w).max())
        whole, known = (each.linear.whole_motion(forces, omega, 1.3) for each in (balance, alone))
        np.testing.assert_allclose(whole, known, atol=1e-12 * np.abs(known).max())
        rows = np.arange(balance.rows)
        for h in range(balance.highest + 1):
            if 2 * h in balance.kept:
                gains = [receptance_of(each.linear, omega, balance.highest, rows, rows)[:, h] for each in (balance, alone)]
                np.testing.assert_allclose(*gains, atol=1e-12 * np.abs(gains[1]).max())


@pytest.mark.parametrize("problem", [chain(), chain(stiffening=0.0), ring()])
def test_the_derivative_by_the_frequency_is_that_of_the_motion(problem):
    balance = HarmonicBalance(problem, 3, 66)
    forces = np.random.default_rng(0).normal(size=(balance.rows, balance.columns))
    omega, step = 7.0, 1e-5
    ends = [balance.linear.motion(forces, omega + change, 1.3) for change in (step, -step)]
    slope = balance.linear.slope(forces, omega, 1.3, False)
    np.testing.assert_allclose(slope, (ends[0] - ends[1]) / (2.0 * step), atol=1e-8 * np.abs(slope).max())
    assert np.abs(slope[:, 0]).max() > 1e-4  # the mean moves with the speed


def test_energies_are_those_of_the_problem_at_its_speed():
    problem = chain()
    found = ss.forced_response(problem, ss.hertz(1.5, 3.0), 6.0)
    at = found.peak_point()
    omega = 2.0 * np.pi * float(found.dataset["frequency"][0, at])
    again = ss.forced_response(problem.at_frequency(omega), [omega / (2.0 * np.pi)], 6.0).dataset
    for name in ("loss_factor", "amplitude", "max_abs"):
        np.testing.assert_allclose(found.dataset[name][0, at], again[name][0, 0], rtol=1e-7)
    assert float(found.dataset["energy_residual"].max()) < 1e-9


def test_one_mass_meets_its_engine_orders_where_the_closed_form_says():
    """Linear: (EO² m − K1) Ω² = K0, and no resonance at any speed where K1 > EO² m."""
    structure = ss.Structure(np.eye(1), 1e4 * np.eye(1), ("1.x",), 0.2 * np.eye(1))
    slider = ss.Contact("slider", ss.Macroslip(kt=1e-6, mu=0.5, normal_load=1.0), tangential=(ss.between("1.x", "ground"),))
    speed = ss.SpeedDependence(1, 2.0 * np.eye(1))
    problem = ss.Problem(structure, (slider,), (ss.Force("1.x", 1.0),), ("1.x",), speed=speed)
    sweep = ss.speed_sweep(problem, (200.0, 1500.0), [1, 2, 4], harmonics=1, samples=64)
    peaks = sweep.peaks().set_index("engine_order")
    assert 1 not in peaks.index
    for order in (2, 4):
        exact = np.sqrt(1e4 / (order**2 - 2.0))
        assert float(peaks.loc[order, "speed"]) == pytest.approx(exact * RPM, rel=1e-5)
        assert float(peaks.loc[order, "amplitude"]) == pytest.approx(1.0 / (0.2 * order * exact), rel=1e-5)
        assert float(peaks.loc[order, "frequency"]) == pytest.approx(order * float(peaks.loc[order, "speed"]) / 60.0, rel=1e-12)
    assert np.isfinite(sweep.responses[1].dataset["amplitude"]).all()
    free = sweep.dataset["free_amplitude"].values[0, 0, :, 0]
    omega = sweep.dataset["linear_speed"].values[0] / RPM
    np.testing.assert_allclose(free, 1.0 / np.abs(1e4 + omega**2 + 0.2j * omega), rtol=1e-6)


def test_a_sweep_agrees_with_forced_responses_at_constant_speeds():
    problem = chain()
    sweep = ss.speed_sweep(problem, (30.0, 100.0), [2], 6.0)
    one = sweep.dataset.isel(engine_order=0, case=0)
    for k in np.linspace(0, one.sizes["point"] - 1, 6).astype(int):
        speed, frequency = float(one["speed"][k]), float(one["frequency"][k])
        assert frequency == pytest.approx(2.0 * speed / 60.0, rel=1e-12)
        known = ss.forced_response(problem.at_speed(speed / RPM), [frequency], 6.0).dataset
        np.testing.assert_allclose(one["amplitude"][k], known["amplitude"][0, 0], rtol=1e-6)


def test_two_models_give_stiffness_and_pull_of_every_speed():
    at = {speed: chain().at_speed(speed / RPM) for speed in (40.0, 90.0)}
    known = chain(1)
    found = synchronous(at)
    for speed in (1.0, 5.0, 12.0):
        one, other = found.at_speed(speed), known.at_speed(speed)
        np.testing.assert_allclose(one.structure.K, other.structure.K, rtol=1e-10)
        np.testing.assert_allclose(one.static_load, other.static_load, atol=1e-12 * speed**2)
    problem = at_reference_speed(chain().at_speed(6.0), 6.0, K)
    np.testing.assert_allclose(problem.at_speed(3.0).structure.K, K + 9.0 * K1, rtol=1e-12)
    np.testing.assert_allclose(problem.at_speed(3.0).static_load, [0.0, 0.0, 4.5], rtol=1e-12)


def test_one_sector_moves_as_the_full_disk():
    disk = ring()
    sector = ss.forced_response(disk, [1.3, 1.7], 4.0, harmonics=3, samples=96).dataset
    full = ss.forced_response(disk.full(reported=[1]), [1.3, 1.7], 4.0, harmonics=3, samples=96).dataset
    np.testing.assert_allclose(sector["amplitude"], full["amplitude"], rtol=1e-7)


def test_a_disk_meets_the_nodal_diameter_of_each_engine_order():
    sweep = ss.speed_sweep(ring(), (20.0, 60.0), [2, 4], 2.0, harmonics=1, samples=96)
    assert [sweep.responses[order].problem.engine_order for order in (2, 4)] == [2, 4]
    assert sweep.responses[4].problem.speed.engine_order == 4
    for order in (2, 4):
        problem = sweep.responses[order].problem
        stuck = float(problem.frequencies(stuck=True)[0])
        alone = problem.at_frequency(2.0 * np.pi * stuck)
        assert np.abs(alone.frequencies(stuck=True) - stuck).min() < 1e-9 * stuck


@pytest.mark.nightly
def test_points_are_verified_in_time_and_have_multipliers_at_their_speed():
    found = ss.forced_response(chain(), ss.hertz(1.5, 3.0), 6.0).with_stability()
    at = found.peak_point()
    check = found.verify_in_time(0, at)
    assert check.agrees(5e-3), check.sentence
    omega = 2.0 * np.pi * float(found.dataset["frequency"][0, at])
    alone = ss.forced_response(chain().at_frequency(omega), [omega / (2.0 * np.pi)], 6.0).with_stability()
    np.testing.assert_allclose(found.dataset["multiplier"][0, at], alone.dataset["multiplier"][0, 0], rtol=1e-4)
    slopes = []
    for response, k in ((found, at), (alone, 0)):
        damped = ss.Parameter(1.0, lambda value, p=response.problem: p.with_damping(value * p.C))
        slopes.append(response.sensitivity(0, k, {"C": damped}).by_parameter["C"])
    assert np.abs(slopes[1]).max() > 1e-3
    np.testing.assert_allclose(*slopes, rtol=1e-5, atol=1e-7)


def test_the_envelope_is_the_largest_of_all_engine_orders():
    sweep = ss.speed_sweep(chain(), (30.0, 120.0), [1, 2], [3.0, 6.0], harmonics=3)
    data = sweep.dataset
    assert data["engine_order"].values.tolist() == [1, 2]
    assert data["force_level"].values.tolist() == [3.0, 6.0]
    tops = sweep.peaks().groupby(["force_level", "output"])["amplitude"].max()
    for case, level in enumerate((3.0, 6.0)):
        for output, name in enumerate(("1.x", "2.x")):
            highest = float(data["envelope"].values[case, :, output].max())
            assert highest == pytest.approx(float(tops[level, name]), rel=2e-3)
    sweep.plot()
    assert "engine order 2" in repr(sweep)


def test_peaks_stand_beside_linear_resonances_with_an_estimate_of_their_error():
    sweep = ss.speed_sweep(chain(), (40.0, 100.0), [2], [6.0], harmonics=1)
    data, response = sweep.dataset, sweep.responses[2].dataset
    peaks = presentation_of(data).tables(data)["peaks"]
    first = peaks[peaks["output"] == "1.x"].iloc[0]
    known = max(float(abs(response[name][0, 0])) for name in ("truncation_error", "sampling_error"))
    assert first["estimated error [%]"] == pytest.approx(100.0 * known)
    assert first["force level [N]"] == 6.0
    assert known > 1e-3
    for name, column in (("stuck", "with stuck contacts [m]"), ("free", "without contacts [m]")):
        assert first[column] == pytest.approx(np.nanmax(data[f"{name}_amplitude"].values[0, 0, :, 0]))
    share = 100.0 * (1.0 - first["amplitude [m]"] / first["with stuck contacts [m]"])
    said = repr(sweep)
    assert said.count("engine order 2, 6 N: 1.x") == 1, "one curve is not said twice, as the highest and by itself"
    assert re.search(r"estimated error \d\.\d %, (harmonics|samples)", said)
    assert f"{share:.0f} % lower than with stuck contacts" in said
    assert "warning, engine order 2, 6 N: " in said
    assert "The error is not estimated for loss factors, lower peaks and other points of the curves" in said


def test_all_engine_orders_have_the_samples_that_are_shown():
    """Six sectors are in phase again after two or three: 66 samples in place of 64 serve both."""
    work = SpeedSweepWork.of(SpeedSweepSettings(ring(), (40.0, 100.0), [2, 3], harmonics=3, samples=64))
    assert [part.samples for part in work.parts] == [66, 66]
    choice = sufficient_harmonics(ring(2).at_speed(9.0), (1.3, 1.7), [4.0], samples=64)
    assert choice.samples % 3 == 0


def test_a_slow_run_up_in_time_passes_the_amplitudes_of_the_sweep():
    """A run-up through a resonance at a slow rate, integrated in time, passes the amplitudes of the sweep."""
    structure = ss.Structure(np.eye(1), 100.0 * np.eye(1), ("1.x",), 1.0 * np.eye(1))
    slider = ss.Contact("slider", ss.Macroslip(kt=20.0, mu=0.5, normal_load=1.0), tangential=(ss.between("1.x", "ground"),))
    problem = ss.Problem(structure, (slider,), (ss.Force("1.x", 1.0),), ("1.x",), speed=ss.SpeedDependence(2, 3.0 * np.eye(1)))
    sweep = ss.speed_sweep(problem, (30.0, 90.0), [2], 2.0, harmonics=7).dataset.isel(engine_order=0, case=0, output=0)
    # Symplectic Euler, some 250 steps a period, with the slider by return mapping; Ω grows linearly.
    rate, step, x, v, s, phase = 0.005, 2e-3, 0.0, 0.0, 0.0, 0.0
    speeds = np.arange(40.0 / RPM, 80.0 / RPM, rate * step)
    moved = np.empty(speeds.size)
    for n, speed in enumerate(speeds.tolist()):
        phase += 2.0 * speed * step
        pull = min(max(20.0 * (x - s), -0.5), 0.5)
        v += step * (2.0 * cos(phase) - v - (100.0 + 3.0 * speed**2) * x - pull)
        x += step * v
        s += x - s - min(max(20.0 * (x - s), -0.5), 0.5) / 20.0
        moved[n] = x
    parts = np.array_split(np.arange(speeds.size), speeds.size // 1500)[10:]  # without the transient of the start
    middle = np.array([speeds[part].mean() * RPM for part in parts])
    height = np.array([np.ptp(moved[part]) / 2.0 for part in parts])
    quasi = np.interp(middle, sweep["speed"].values, sweep["amplitude"].values)
    assert np.abs(height / quasi - 1.0).max() < 0.03
    assert quasi.max() / quasi.min() > 2.0


@pytest.mark.parametrize(
    ("change", "words"),
    [
        (lambda: ss.speed_sweep(chain(), (0.0, 10.0)), "positive"),
        (lambda: ss.speed_sweep(chain(), (10.0, 10.0)), "different"),
        (lambda: ss.speed_sweep(chain(), (10.0, 20.0), []), "at least one"),
        (lambda: ss.speed_sweep(chain(), (10.0, 20.0), [0]), "at least 1"),
        (lambda: ss.speed_sweep(chain().at_speed(1.0), (10.0, 20.0)), "speed"),
        (lambda: ss.speed_sweep({10.0: chain().at_speed(1.0)}, (10.0, 20.0)), "two speeds"),
        (lambda: ss.nonlinear_modes(chain()), "at_speed"),
        (lambda: ss.time_response(chain(), 1.0, 1.0), "at_speed"),
        (lambda: ss.forced_response(chain(), ss.hertz(1.0, 2.0), periods=2), "periods"),
        (lambda: ss.SpeedDependence(2, np.eye(2), (ss.Force("1.x", 1.0),)), "static"),
        (lambda: replace(chain(), speed=ss.SpeedDependence(2, np.eye(2))), "shape of K"),
        (lambda: replace(chain(), speed=ss.SpeedDependence(2, np.triu(np.ones((3, 3))))), "symmetric"),
        (lambda: replace(chain(), speed=ss.SpeedDependence(2, None, (ss.Force("9.x", static=1.0),))), "9.x"),
        (lambda: at_reference_speed(ss.rigs.single_mass(), 10.0), "goes with the speed"),
    ],
)
def test_bad_input_is_said(change, words):
    with pytest.raises(ss.InputError, match=words):
        change()
