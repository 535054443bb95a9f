"""Free decays against closed forms, a published case and integration from event to event."""

import numpy as np
import pytest
from stability.hybrid import OPEN, STICK, of_problem
from stability.test_multipliers import lifting
from typer.testing import CliRunner

import stickslip as ss
from stickslip.analyses.free_decay import half_cycles, turning_points
from stickslip.cli import app
from stickslip.model.rigs import three_mass_wedge
from stickslip.show.report.markup import presentation_named
from stickslip.solve.time.march import TimeStart

RELEASED, STIFFNESS, LIMIT = 0.85e-3, 1e4, 1.0


def slider(kt, normal_load=1.0, damping=0.0, stiffness=STIFFNESS, mass=1.0):
    structure = ss.Structure(np.array([[mass]]), np.array([[stiffness]]), ("1.x",), C=np.array([[damping]]))
    contact = ss.Contact("slider", ss.Macroslip(kt, LIMIT, normal_load=normal_load), ({"1.x": 1.0},))
    return ss.Problem(structure, (contact,), (ss.Force("1.x", 1.0),), ("1.x",), "Mass on a slider")


def test_a_mass_with_coulomb_friction_turns_where_code_aster_says():
    """SDND100 of code_aster: 1 kg, 1e4 N/m, 1 N; each half cycle loses 2 F/k, and within F/k of the middle the mass stays."""
    decay = ss.free_decay(slider(1e9), 0.3, {"1.x": RELEASED}, steps=15_000).dataset
    turning = decay["turning_point"].values[0]
    np.testing.assert_allclose(turning[:5], [8.5e-4, -6.5e-4, 4.5e-4, -2.5e-4, 0.5e-4], atol=1e-7)
    assert np.all(np.isnan(turning[5:]))
    np.testing.assert_allclose(np.diff(decay["turning_time"].values[0][:5]), np.pi / 100.0, atol=2.0 * 0.3 / 15_000)  # two steps
    assert abs(decay["displacement"].values[0, -1] - 0.5e-4) < 1e-7
    decrement = np.log([6.5 / 4.5, 4.5 / 2.5])  # of the half cycle from -0.65 to 0.45 mm, and of the next
    np.testing.assert_allclose(decay["damping_ratio"].values[0, 1:3], decrement / np.hypot(np.pi, decrement), rtol=2e-3)
    lost = 0.5 * STIFFNESS * (RELEASED**2 - 0.5e-4**2)
    assert float(decay["friction_work"].sum()) == pytest.approx(lost, rel=1e-3)


def test_in_the_plane_both_components_turn_together():
    """At 45°: a disc of the same limit, released along the diagonal."""
    structure = ss.Structure(np.eye(2), STIFFNESS * np.eye(2), ("1.x", "1.y"))
    contact = ss.Contact("disc", ss.FrictionDisc(1e8, LIMIT, normal_load=1.0), ({"1.x": 1.0}, {"1.y": 1.0}))
    plane = ss.Problem(structure, (contact,), (ss.Force("1.x", 1.0),), ("1.x", "1.y"), "Mass on a disc")
    share = np.cos(np.pi / 4.0)
    decay = ss.free_decay(plane, 0.3, {"1.x": share * RELEASED, "1.y": share * RELEASED}, steps=10_000).dataset
    for turning in decay["turning_point"].values:
        np.testing.assert_allclose(turning[:5] / share, [8.5e-4, -6.5e-4, 4.5e-4, -2.5e-4, 0.5e-4], atol=2e-7)


def test_a_linear_decay_has_its_frequency_and_damping_ratio():
    """Stuck: ω² = (k + kt)/m, ζ = c/(2 m ω); an impact of 0.1 m/s."""
    damping, kt = 3.0, 2000.0
    decay = ss.free_decay(slider(kt, normal_load=1e6, damping=damping), 0.5, velocity={"1.x": 0.1}, steps=20_000).dataset
    omega = np.sqrt(STIFFNESS + kt)
    ratio = damping / (2.0 * omega)
    count = int(np.isfinite(decay["amplitude"].values[0]).sum())
    assert count > 10
    damped = omega * np.sqrt(1.0 - ratio**2) / (2.0 * np.pi)
    np.testing.assert_allclose(decay["frequency"].values[0, :count], damped, rtol=1e-4)
    first = np.arctan2(np.sqrt(1.0 - ratio**2), ratio) / (2.0 * np.pi * damped)
    assert float(decay["turning_time"][0, 0]) == pytest.approx(first, rel=1e-3)
    np.testing.assert_allclose(decay["damping_ratio"].values[0, 1 : count - 1], ratio, rtol=1e-3)
    assert np.isnan(decay["damping_ratio"].values[0, [0, count - 1]]).all()
    given = 0.5 * 0.1**2
    left = given * np.exp(-damping * 0.5)
    assert float(decay["viscous_work"]) == pytest.approx(given - left, rel=0.02)


def test_a_steady_motion_of_light_damping_is_found_before_its_decay():
    """A stuck mass of ζ = 0.05 %: from rest it would take thousands of periods to be steady."""
    damping, kt = 0.1, 2000.0
    omega = np.sqrt(STIFFNESS + kt)
    problem = slider(kt, normal_load=1e6, damping=damping)
    decay = ss.free_decay(problem, 0.1, frequency=0.9 * omega / (2.0 * np.pi), steps=200).dataset
    size = 1.0 / abs((1.0 - 0.9**2) * omega**2 + 1j * 0.9 * omega * damping)
    assert float(decay["displacement"][0, 0]) == pytest.approx(size, rel=1e-4)  # nearly in phase with the force


@pytest.mark.parametrize("name", ["lifts off", "wedge"])
def test_decays_are_those_of_integration_from_event_to_event(name):
    if name == "wedge":
        problem, duration, moved = three_mass_wedge(), 0.02, {"1.y": 2e-4, "2.x": -1e-4}
    else:
        problem, duration, moved = lifting(), 12.0, {"1.x": 1.5, "1.y": 1.0}
    exact = of_problem(problem, 0.0)
    q = np.zeros(problem.structure.size)
    for dof, value in moved.items():
        q[problem.structure.dofs.index(dof)] = value
    modes, y = [], []
    for each in exact.sliders:
        spring, limit = each.kt * (each.u @ q), each.limit(q)
        open_ = each.z is not None and each.normal(q) < 0.0
        modes.append(OPEN if open_ else STICK if abs(spring) <= limit else int(np.sign(spring)))
        y.append(float(np.clip(spring, -limit, limit)) - spring)
    end = exact.travel(np.concatenate([q, np.zeros(q.size), y]), modes, 2.0 * np.pi / duration)[: q.size]
    decay = ss.free_decay(problem, duration, moved, steps=40_000).dataset
    error = np.abs(decay["displacement"].values[:, -1] - problem.output_rows @ end).max()
    assert error <= 1e-4 * np.abs(decay["displacement"].values).max()


def test_the_motion_goes_on_from_a_steady_one():
    """Where the excitation stops, motion, velocity and slider are those of the last period; here it stays stuck."""
    problem = slider(5000.0, damping=1.0)
    begin = ss.time_response(problem, 14.0, 1.0, steps_per_period=400, tolerance=1e-4).cycle.end
    decay = ss.free_decay(problem, 0.4, start=begin, steps=4000).dataset
    root = -0.5 + 1j * np.sqrt(15000.0 - 0.25)
    middle = -begin.intercepts[0] / 15000.0
    moved, speed = begin.motion[0] - middle, begin.velocity[0]
    weight = moved - 1j * (speed - root.real * moved) / root.imag
    exact = middle + np.real(weight * np.exp(root * decay["time"].values))
    np.testing.assert_allclose(decay["displacement"].values[0], exact, atol=1e-3 * np.abs(exact).max())


def test_wrong_input_is_refused():
    problem = slider(1e6)
    with pytest.raises(ss.InputError, match="must name degrees of freedom of the structure"):
        ss.free_decay(problem, 0.1, {"1.z": 1.0})
    with pytest.raises(ss.InputError, match="must move something"):
        ss.free_decay(problem, 0.1)
    for wrong, message in (
        ({"displacement": [1.0]}, "displacement must be a dict"),
        ({"start": "rest"}, "start must be a TimeStart"),
        ({"start": TimeStart(np.zeros(2), np.zeros(2), np.zeros(1))}, "start must have motion, velocity and intercepts"),
        ({"displacement": {"1.x": 1e-3}, "method": "newmark"}, "method must be"),
        ({"displacement": {"1.x": 1e-3}, "force": 2.0}, "force needs frequency"),
        ({"displacement": {"1.x": 1e-3}, "steps": 100}, "A half cycle must have 6 steps at least"),
    ):
        with pytest.raises(ss.InputError, match=message):
            ss.free_decay(problem, 10.0, **wrong)
    with pytest.raises(ss.InputError, match="duration"):
        ss.free_decay(problem, -1.0, {"1.x": 1.0})
    with pytest.raises(ss.InputError, match="steps"):
        ss.free_decay(problem, 1.0, {"1.x": 1.0}, steps=2)


def test_the_figure_shows_frequency_and_damping_over_amplitude():
    found = ss.free_decay(slider(5000.0, damping=2.0), 0.3, {"1.x": 1e-3}, steps=3000)
    motion, frequency, damping = found.plot().axes
    np.testing.assert_allclose(motion.lines[0].get_ydata(), 1e6 * found.dataset["displacement"].values[0])
    np.testing.assert_allclose(frequency.lines[0].get_ydata(), found.dataset["frequency"].values[0])
    np.testing.assert_allclose(damping.lines[0].get_ydata(), 100.0 * found.dataset["damping_ratio"].values[0])


def test_a_phase_resonance_test_stands_beside_the_decay():
    """Its frequency at 90° is that of the half cycles at the same displacement, whatever quantity was held."""
    problem = slider(1000.0, damping=0.2)
    found = ss.free_decay(problem, 1.5, velocity={"1.x": 1.0}, steps=30_000)
    half = found.dataset.isel(output=0)
    known = np.isfinite(half["frequency"].values)
    for quantity, held in (("displacement", [2e-3, 5e-3, 9e-3]), ("acceleration", [23.0, 60.0, 100.0])):
        test = ss.phase_resonance(problem, ss.hertz(10.0, 25.0), held, quantity=quantity, harmonics=5)
        data = found.with_phase_resonance(test).dataset
        at = np.interp(-data["resonance_amplitude"].values, -half["amplitude"].values[known], half["frequency"].values[known])
        assert data["resonance_frequency"].values == pytest.approx(at, rel=1e-3)
        assert np.all((data["resonance_amplitude"].values > 1e-3) & (data["resonance_amplitude"].values < 1.1e-2))
    other = ss.phase_resonance(slider(2000.0), ss.hertz(10.0, 25.0), [5e-3], quantity="displacement", harmonics=5)
    with pytest.raises(ss.InputError, match=r"must hold the first output, 1\.x, of the problem that decays"):
        found.with_phase_resonance(other)
    _, frequency, _ = found.with_phase_resonance(test).plot().axes
    np.testing.assert_allclose(frequency.lines[-1].get_ydata(), data["resonance_frequency"].values)


def test_the_decay_begins_in_the_steady_motion():
    """By frequency and force level as by the end of the steady motion itself."""
    problem = slider(5000.0, damping=20.0)
    end = ss.time_response(problem, 14.0, 1.0).cycle.end
    ways = [ss.free_decay(problem, 0.1, steps=1000, **begin).dataset for begin in ({"frequency": 14.0}, {"start": end})]
    by_frequency, by_end = (way["displacement"].values for way in ways)
    np.testing.assert_allclose(by_frequency, by_end, atol=2e-4 * np.abs(by_end).max())
    with pytest.raises(ss.InputError, match="must not be given together"):
        ss.free_decay(problem, 0.1, {"1.x": 1.0}, frequency=14.0)


def test_a_lightly_damped_decay_lies_on_the_nonlinear_mode(tmp_path):
    """Frequency of each half cycle at its mean amplitude; the damping by amplitude is that of a decay along the mode, up to 6 %
    more than the mode's own. The study of this decay computes both."""
    problem = slider(1000.0, damping=0.2)
    found = ss.free_decay(problem, 1.5, velocity={"1.x": 1.0}, steps=30_000)
    modes = ss.nonlinear_modes(problem, amplitude=(1e-3, 1.1e-2), harmonics=5)
    data = found.with_modes(modes).dataset
    amplitude, frequency, ratio = (data[key].values[0] for key in ("amplitude", "frequency", "damping_ratio"))
    inside = np.flatnonzero((amplitude > 2e-3) & np.isfinite(ratio))
    assert inside.size > 20
    x = data["mode_amplitude"].values[0, :, 0]
    at = np.interp(amplitude[inside], x, data["mode_frequency"].values[0])
    np.testing.assert_allclose(frequency[inside], at, rtol=5e-4)
    excess = ratio[inside] / np.interp(amplitude[inside], x, data["mode_damping_ratio"].values[0, :, 0])
    assert np.all((excess > 0.98) & (excess < 1.01))
    assert ss.open_results(found.save(tmp_path / "decay.nc")).attrs["analysis"] == "free_decay"
    with pytest.raises(ss.InputError, match="must be those of the problem"):
        ss.free_decay(slider(2000.0), 0.5, velocity={"1.x": 1.0}, steps=2000).with_modes(modes)


def test_small_ripples_in_a_decay_are_left_out():
    """A ripple of 5e-4 near each extreme of a decay neither ends the list of half cycles nor adds any."""
    t = np.arange(40_000) / 40_000
    decay = np.exp(-2.0 * t) * np.cos(40.0 * np.pi * t)
    rippled = decay + 5e-4 * np.exp(-2.0 * t) * np.cos(0.3 + 4000.0 * np.pi * t)
    amplitude, frequency, _ = half_cycles(*turning_points(t, rippled))
    assert 38 <= amplitude.size <= 40
    np.testing.assert_allclose(frequency, 20.0, rtol=0.02)
    np.testing.assert_allclose(amplitude, half_cycles(*turning_points(t, decay))[0][: amplitude.size], rtol=0.005)


def two_masses():
    """Frequencies of 5 and 17 Hz, each of a damping ratio of 1 %, and of both, by coordinates 1 +- 2."""
    omega, turn = 2.0 * np.pi * np.array([5.0, 17.0]), np.array([[1.0, 1.0], [1.0, -1.0]]) / np.sqrt(2.0)
    K, C = turn @ np.diag(omega**2) @ turn, turn @ np.diag(0.02 * omega) @ turn
    structure = ss.Structure(np.eye(2), K, ("1.x", "2.x"), C=C)
    contact = ss.Contact("slider", ss.Macroslip(1e-3, 1.0, normal_load=1e3), ({"1.x": 1.0},))
    return ss.Problem(structure, (contact,), (ss.Force("1.x", 1.0),), ("1.x",), "Two masses")


def test_several_modes_have_no_damping_of_half_cycles_but_a_motion_to_evaluate(tmp_path):
    """`stickslip export` writes the motion, in which `stickslip decay` finds the damping of one mode."""
    both, one = ({"1.x": 1e-3}, {"1.x": 1e-3, "2.x": 1e-3})
    decay, alone = (ss.free_decay(two_masses(), 2.0, begin, steps=4000) for begin in (both, one))
    (mixed, _), (single, _) = (presentation_named("free_decay").sentences(each.dataset) for each in (decay, alone))
    assert "several modes move" in mixed
    assert "most damping" not in mixed
    assert "most damping 1.0 %" in single
    (tmp_path / "both").mkdir()
    decay.save(tmp_path / "both" / "results.nc")
    results, motion = tmp_path / "d", tmp_path / "both_motion.csv"
    for command in (
        ("export", tmp_path / "both", "--out", tmp_path / "both.csv"),
        ("decay", motion, "--column", "signal=1.x", "--band", "3:8", "--cycles", "5", "--out", results),
    ):
        result = CliRunner().invoke(app, [str(word) for word in command])
        assert result.exit_code == 0, result.output
    data = ss.open_results(results / "results.nc")
    assert float(data["damping_ratio"].median()) == pytest.approx(0.01, rel=0.05)
    assert float(data["frequency"].median()) == pytest.approx(5.0, rel=1e-3)
