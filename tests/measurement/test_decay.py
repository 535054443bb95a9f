"""Measured decays against closed forms, a linear oscillator with and without noise and a Coulomb slider, and a computed decay."""

import re

import numpy as np
import pytest

import stickslip as ss
from stickslip.show.report.free_decay import measured_tables
from stickslip.support.checks import InputError

TIME = np.arange(4000) / 4000.0


def linear(ratio=0.01, frequency=60.0, amplitude=1e-3):
    """Displacement, velocity and acceleration of A exp(−ζω t) cos(ω_d t)."""
    omega = 2.0 * np.pi * frequency
    root = complex(-ratio / np.sqrt(1.0 - ratio**2) * omega, omega)
    return [np.real(root**order * amplitude * np.exp(root * TIME)) for order in range(3)], -root.real


@pytest.mark.parametrize("order", [0, 1, 2])
def test_a_linear_decay_is_found_whatever_was_measured(order):
    signals, delta = linear()
    data = ss.measured_decay(
        TIME, 0.2 * (order == 0) * 1e-3 + signals[order], ("displacement", "velocity", "acceleration")[order]
    ).dataset
    np.testing.assert_allclose(data["frequency"], 60.0, rtol=1e-9)
    np.testing.assert_allclose(data["damping_ratio"], 0.01, rtol=1e-7)
    exact = 1e-3 * np.exp(-delta * data["window_time"].values)
    np.testing.assert_allclose(data["amplitude"], exact, rtol=2e-4)  # |root|² of an acceleration is ω² (1 + ζ²)
    assert data.sizes["window"] > 80


def test_errors_are_those_of_noise():
    """Deviations over their standard errors have a standard deviation of 1; windows apart by their length are independent."""
    (signal, *_), delta = linear()
    rng, scores = np.random.default_rng(0), []
    for _ in range(16):
        noisy = signal + 2e-5 * rng.normal(size=TIME.size)
        data = ss.measured_decay(TIME, noisy, cycles=2.0).dataset.isel(window=slice(0, 40, 4))
        exact = {"frequency": 60.0, "damping_ratio": 0.01, "amplitude": 1e-3 * np.exp(-delta * data["window_time"].values)}
        scores.append([((data[key] - value) / data[f"{key}_error"]).values for key, value in exact.items()])
    assert np.std(np.array(scores), axis=(0, 2)) == pytest.approx(1.0, abs=0.2)
    assert ss.measured_decay(TIME, signal + 2e-5 * rng.normal(size=TIME.size)).dataset["amplitude"].values.min() > 2e-5


def test_rigid_friction_damps_by_its_closed_form():
    """Each half cycle loses 2 F/k: −2 F/(k π) a rad, ζ = 2 F/(π k A) at amplitudes far above F/k, at the undamped frequency."""
    omega, loss, start = 2.0 * np.pi * 60.0, 4e-6, 1e-3
    half = np.floor(TIME * omega / np.pi)
    signal = np.where(half % 2 == 0, 1.0, -1.0) * loss + (start - loss - 2.0 * loss * half) * np.cos(omega * TIME)
    data = ss.measured_decay(TIME, np.where(start - loss - 2.0 * loss * half > 0.0, signal, 0.0), cycles=2.0).dataset
    far = data.isel(window=data["amplitude"].values > 40.0 * loss)
    assert far.sizes["window"] > 60
    np.testing.assert_allclose(far["frequency"], 60.0, rtol=1e-3)
    # the friction offset, which changes its sign each half cycle, stands beside the sine: fits of few cycles feel it
    expected = 2.0 * loss / (np.pi * far["amplitude"].values)
    np.testing.assert_allclose(np.convolve(far["damping_ratio"] / expected, np.full(4, 0.25), "valid"), 1.0, atol=0.06)
    np.testing.assert_allclose(np.diff(far["amplitude"].values), -2.0 * loss, rtol=0.06)


def test_a_decay_ends_where_friction_stops_the_motion():
    """The same down to the stop, where nothing but a part of a cycle is left in a window; 1e-7 m of noise."""
    loss, start, omega = 2e-6, 1e-4, 100.0  # F/k, m; rad/s
    time = np.arange(0.0, 3.0, 1e-3)
    half = np.minimum(np.floor(time * omega / np.pi), np.floor(0.5 * (start - loss) / loss))
    left = start - loss - 2.0 * loss * half
    turning = np.where(left > 0.0, np.cos(np.minimum(time * omega, np.pi * (half + 1.0)) - np.pi * half), 0.0)
    signal = (-1.0) ** half * (loss + left * turning)
    for noise in (0.0, 1e-7):
        noisy = signal + noise * np.random.default_rng(0).normal(size=time.size)
        data = ss.measured_decay(time, noisy, cycles=2.0).dataset
        amplitude = data["amplitude"].values
        apart = data["damping_ratio"].values / (2.0 * loss / (np.pi * amplitude)) - 1.0
        assert amplitude[-1] < 8.0 * loss
        chance = 2.0 * data["damping_ratio_error"].values / data["damping_ratio"].values if noise else np.zeros(amplitude.size)
        assert np.all(np.abs(apart) < 0.02 + chance, where=amplitude > 10.0 * loss)
        assert np.abs(apart).max() < 0.1
        assert data["damping_ratio_error"].values.min() > 1e-6


@pytest.mark.parametrize(("other", "share"), [(30.0, 0.1), (45.0, 0.5)])
def test_a_second_mode_makes_errors_larger(other, share):
    time = np.arange(0.0, 6.0, 1.0 / 500.0)
    one, two = (np.exp(-0.01 * w * time) * np.cos(w * time) for w in 2.0 * np.pi * np.array([20.0, other]))
    data = ss.measured_decay(time, one + share * two).dataset
    apart = np.abs(data["damping_ratio"] - 0.01 / np.sqrt(1.0 + 0.01**2))
    assert float((apart < 2.0 * data["damping_ratio_error"]).mean()) > 0.7


@pytest.mark.parametrize("order", [0, 2])
def test_modes_outside_of_the_band_do_not_disturb(order):
    """Two of 390 and 1050 Hz beside one of 60 Hz, in acceleration ten times as large: errors are those of the noise alone."""
    rng = np.random.default_rng(0)
    noise = 2e-6 * (2.0 * np.pi * 60.0) ** order * rng.normal(size=TIME.size)
    alone, delta = linear()
    others = [
        linear(ratio, frequency, size)[0][order] for ratio, frequency, size in ((0.003, 390.0, 2e-4), (0.004, 1050.0, 5e-5))
    ]
    quantity = ("displacement", "velocity", "acceleration")[order]
    with_others, without = (
        ss.measured_decay(TIME, signal + noise, quantity, band=(40.0, 90.0)).dataset.isel(window=slice(0, 40))
        for signal in (alone[order] + sum(others), alone[order])
    )
    exact = {"frequency": 60.0, "damping_ratio": 0.01, "amplitude": 1e-3 * np.exp(-delta * with_others["window_time"].values)}
    for key, value in exact.items():
        error = with_others[f"{key}_error"].values
        assert np.std((with_others[key].values - value) / error) < 1.5
        assert np.median(error) < 2.0 * np.median(without[f"{key}_error"].values)


@pytest.mark.parametrize("order", [1, 2])
def test_the_damping_is_that_of_the_displacement_where_the_frequency_changes(order):
    """x = exp(−δ t) cos φ, φ' = ω₀ + 2 ν t: its rate is smaller by ω, and falls more slowly while ω rises."""
    begin, drift, delta = 2.0 * np.pi * 100.0, 300.0, 5.0
    phase, rate = begin * TIME + drift * TIME**2, 1j * (begin + 2.0 * drift * TIME) - delta
    motion = np.exp(-delta * TIME + 1j * phase)
    of = (rate * motion, (rate**2 + 2j * drift) * motion)[order - 1].real
    data = ss.measured_decay(TIME, of, ("velocity", "acceleration")[order - 1]).dataset
    omega = 2.0 * np.pi * data["frequency"].values
    np.testing.assert_allclose(omega, begin + 2.0 * drift * data["window_time"].values, rtol=1e-3)
    np.testing.assert_allclose(data["damping_ratio"].values, delta / np.hypot(delta, omega), rtol=0.02)
    np.testing.assert_allclose(data["amplitude"].values, np.exp(-delta * data["window_time"].values), rtol=0.01)


def test_tables_hold_the_frequency_also_where_it_is_a_coordinate():
    """As in exported results."""
    data = ss.measured_decay(TIME, linear()[0][0]).dataset
    expected, found = (measured_tables(each) for each in (data, data.set_coords("frequency")))
    for name, table in expected.items():
        assert set(table) == set(found[name])


@pytest.mark.parametrize("bits", [8, 12, 24])
@pytest.mark.parametrize("frequency", [15.0, 60.0])
def test_a_clipped_signal_is_refused_and_right_after_it(bits, frequency):
    """Records of 8 to 24 bits, with up to 267 samples a cycle: whole ones are taken, those whose range is 0.7 of them are not."""
    (signal, *_), _ = linear(frequency=frequency)
    steps = 2.0 ** (bits - 1) / 1e-3
    whole = np.round(signal * steps) / steps
    expected = ss.measured_decay(TIME, whole).dataset
    np.testing.assert_allclose(expected["frequency"][:3], frequency, rtol=1e-2)
    clipped = np.clip(whole, -0.7e-3, 0.7e-3)
    with pytest.raises(InputError, match="must not stay at its extreme value") as refusal:
        ss.measured_decay(TIME, clipped)
    begin = float(re.search(r"after (\S+) s", str(refusal.value)).group(1)) + 1e-3
    found = ss.measured_decay(TIME, clipped, begin=begin).dataset
    assert abs(float(found["damping_ratio"][0]) - 0.01) < 1e-3


def test_a_blow_before_the_decay_is_left_out():
    time = np.arange(-0.05, 0.5, 1e-4)
    ringing = np.where(time > 0.0, 2e3 * np.exp(-8.0 * time) * np.sin(2.0 * np.pi * 180.0 * time), 0.0)
    signal = ringing + np.where(np.abs(time + 3e-4) < 3e-4, 3.5e4, 0.0)
    with pytest.raises(ss.InputError, match="begin, --begin"):
        ss.measured_decay(time, signal, "acceleration")
    data = ss.measured_decay(time, signal, "acceleration", begin=0.0).dataset
    np.testing.assert_allclose(data["damping_ratio"].values, 8.0 / np.hypot(8.0, 2.0 * np.pi * 180.0), rtol=1e-3)
    with pytest.raises(ss.InputError, match="begin must leave"):
        ss.measured_decay(time, signal, begin=0.499)


def test_a_decay_in_a_file_is_that_of_its_structure(tmp_path):
    """A computed decay of a mass on a slider, written as mm and ms with noise: frequency and damping of its half cycles."""
    structure = ss.Structure(np.eye(1), 1e4 * np.eye(1), ("1.x",), C=np.array([[0.2]]))
    slider = ss.Contact("slider", ss.Macroslip(1e3, 1.0, normal_load=1.0), ({"1.x": 1.0},))
    problem = ss.Problem(structure, (slider,), (ss.Force("1.x", 1.0),), ("1.x",))
    decay = ss.free_decay(problem, 1.5, velocity={"1.x": 1.0}, steps=15_000).dataset
    signal = decay["displacement"].values[0, ::10] + 2e-6 * np.random.default_rng(0).normal(size=1501)
    rows = [f"{1e3 * t:.6g};{1e3 * x:.8g}" for t, x in zip(decay["time"].values[::10], signal, strict=True)]
    (tmp_path / "decay.csv").write_text("Time [ms];Displacement [mm]\n" + "\n".join(rows) + "\n")
    found = ss.read_decay(tmp_path / "decay.csv")
    amplitude, ratio, frequency = (decay[key].values[0] for key in ("amplitude", "damping_ratio", "frequency"))
    known = np.isfinite(ratio)
    order = np.argsort(amplitude[known])
    shown = found.dataset.isel(window=found.dataset["amplitude"].values > 3e-3)
    np.testing.assert_allclose(
        shown["frequency"], np.interp(shown["amplitude"], amplitude[known][order], frequency[known][order]), rtol=1e-3
    )
    between = np.sqrt(amplitude[known] * np.append(amplitude[known][1:], np.nan))
    inside = np.isfinite(between)
    expected = np.interp(shown["amplitude"], between[inside][::-1], ratio[known][inside][::-1])
    np.testing.assert_allclose(shown["damping_ratio"], expected, rtol=0.06)
    assert ss.open_results(found.save(tmp_path / "decay.nc")).attrs["quantity"] == "displacement"
    modes = ss.nonlinear_modes(problem, amplitude=(2e-3, 1e-2), harmonics=3, samples=128)
    beside = found.with_modes(modes)
    motion, frequency, _ = beside.plot().axes
    np.testing.assert_allclose(motion.lines[0].get_ydata(), 1e6 * found.dataset["signal"].values)
    np.testing.assert_allclose(frequency.lines[-1].get_ydata(), modes.dataset["frequency"].values[0])
    assert "Measured decay: decay" in str(beside)
    assert "standard error" in str(beside)


def test_what_is_no_decay_is_refused(tmp_path):
    rng, (signal, *_) = np.random.default_rng(0), linear()[0]
    wrong = [
        ((TIME, signal, "force"), {}, "quantity must be one of"),
        ((TIME[:20], signal[:20]), {}, "must hold 32 samples"),
        ((TIME**2, signal), {}, "must be even"),
        ((TIME, signal), {"band": (100.0, 50.0)}, "band must be"),
        ((TIME, signal), {"band": "all"}, "band must hold numbers"),
        ((TIME, signal), {"band": (1.0, 2.0, 3.0)}, "band must have 2 entries"),
        ((TIME, np.where(TIME[40] < TIME, np.nan, signal)), {}, "signal must be finite, but is 'nan at entry 42'"),
        ((TIME, signal[::-1].copy()), {}, "must have 3 cycles after it"),
        ((TIME, signal), {"cycles": 0.1}, "cycles must be"),
        ((TIME[::20], signal[::20]), {}, "must be 8 at least"),
        ((TIME, rng.normal(size=TIME.size)), {"band": (50.0, 70.0), "cycles": 2.0}, "must have two windows of 2 cycles"),
        ((TIME, np.zeros(TIME.size)), {}, "must move between"),
    ]
    for arguments, settings, message in wrong:
        with pytest.raises(InputError, match=message):
            ss.measured_decay(*arguments, **settings)
    (tmp_path / "two.csv").write_text("when;what\n" + "\n".join(f"{t};{x}" for t, x in zip(TIME, signal, strict=True)))
    with pytest.raises(InputError, match="must be stated by title or unit"):
        ss.read_decay(tmp_path / "two.csv")
    assert ss.read_decay(tmp_path / "two.csv", quantity="displacement").dataset.attrs["title"] == "two"
    with pytest.raises(InputError, match="A setting must be one of band, cycles, begin, name, but is 'bands'"):
        ss.read_decay(tmp_path / "two.csv", quantity="displacement", bands=(1.0, 2.0))
    with pytest.raises(InputError, match="path must be the name of a file"):
        ss.read_decay(3)
    with pytest.raises(InputError, match="columns must be one of"):
        ss.read_decay(tmp_path / "two.csv", columns={"x": 1})


PRINTED = {
    "seven digits": lambda t: np.array([float(f"{x:.7g}") for x in t]),
    "six decimals": lambda t: np.round(t, 6),
    "five decimals": lambda t: np.round(t, 5),
    "single precision": lambda t: t.astype(np.float32).astype(float),
    "milliseconds, four decimals": lambda t: 1e-3 * np.round(1e3 * t, 4),
}


@pytest.mark.parametrize("printed", PRINTED)
def test_steps_are_even_up_to_the_last_digit_of_the_times(printed):
    """As loggers print 1.000195, 1.000391, ... of 5120 Hz; one mode of 120 Hz and 0.1 %."""
    t = 1.0 + np.arange(15000) / 5120.0
    x = np.exp(-0.001 * 2.0 * np.pi * 120.0 * (t - 1.0)) * np.cos(2.0 * np.pi * 120.0 * (t - 1.0))
    data = ss.measured_decay(PRINTED[printed](t), x, "velocity").dataset
    np.testing.assert_allclose(data["frequency"], 120.0, rtol=1e-4)
    np.testing.assert_allclose(np.median(data["damping_ratio"]), 1e-3, rtol=1e-2)


def test_times_that_are_not_even_within_their_last_digit_are_refused():
    t, generator = np.arange(4000) / 5120.0, np.random.default_rng(0)
    for uneven in (t + 2e-6 * generator.normal(size=t.size), t + 1e-5 * np.sin(9.0 * t), np.delete(t, 700), t * (1.0 + 1e-3 * t)):
        with pytest.raises(InputError, match="must be even and positive"):
            ss.measured_decay(np.round(uneven, 6), np.cos(700.0 * uneven), "velocity")
