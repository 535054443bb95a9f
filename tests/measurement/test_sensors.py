"""Several sensors of one decay as one record: errors that hold, no worse than the best sensor, and what is said."""

import numpy as np
import pytest

import stickslip as ss

TIME = np.arange(8000) / 2000.0
SHAPE, NOISE = np.array([1.0, -0.7, 0.4, 1.5]), 0.02 * np.array([1.0, 0.5, 2.0, 1.5])
BAND = (60.0, 150.0)


def ringing(hertz, ratio, phase):
    return np.exp(-2.0 * np.pi * ratio * hertz * TIME) * np.cos(2.0 * np.pi * hertz * np.sqrt(1.0 - ratio**2) * TIME + phase)


def records(kind, seed):
    """Signals (n, sensors), undamped frequency and damping ratio of a mode of amplitude 1 at the first of them."""
    rng = np.random.default_rng(seed)
    hertz, ratio = 90.0 + 20.0 * rng.random(), 0.002 + 0.004 * rng.random()
    shape = SHAPE * (1.0, 1.0, 0.0 if kind == "dead" else 1.0, 1.0)
    x = ringing(hertz, ratio, 6.0 * rng.random())[:, None] * shape + NOISE * rng.normal(size=(TIME.size, 4))
    disturbing = {
        "hum": (50.0, 0.0, [0.1, 0.08, 0.12, 0.06]),
        "hum beside the mode": (1.06 * hertz, 0.0, [0.1, 0.08, 0.12, 0.06]),
        "suspension": (9.0, 0.02, [1.0, 1.2, 0.9, 1.1]),
        "close mode": (1.03 * hertz, 0.003, [0.3, 0.24, -0.21, -0.12]),
    }
    if kind in disturbing:
        other, damping, shares = disturbing[kind]
        x += ringing(other, damping, 6.0 * rng.random())[:, None] * shares
    return x[:, :2] if kind == "two sensors" else x, hertz, ratio


KINDS = ("white", "two sensors", "dead", "hum", "hum beside the mode", "suspension", "close mode")


def found(kind, seed, sensors=slice(None)):
    """(Value − truth)/error of frequency, damping ratio, amplitude (3, windows), and the median miss of the damping ratio."""
    x, hertz, ratio = records(kind, seed)
    data = ss.measured_decay(TIME, x[:, sensors], band=BAND).dataset
    true = hertz * np.sqrt(1.0 - ratio**2), ratio, np.exp(-2.0 * np.pi * ratio * hertz * data["window_time"].values)
    names = ("frequency", "damping_ratio", "amplitude")
    away = [(data[name].values - value) / data[f"{name}_error"].values for name, value in zip(names, true, strict=True)]
    return np.array(away), float(np.median(np.abs(data["damping_ratio"].values / ratio - 1.0)))


@pytest.mark.parametrize("kind", KINDS)
def test_errors_of_several_sensors_hold_the_truth_of_one_record(kind):
    away, missed = found(kind, 6000)
    assert np.mean(np.abs(away[:2]) < 2.8) > 0.9
    assert np.median(np.abs(away[2])) < 2.8
    assert missed < 0.08


@pytest.mark.nightly
@pytest.mark.parametrize("kind", KINDS)
def test_95_per_cent_of_the_windows_of_several_sensors_lie_within_their_errors(kind):
    """Twenty-five records, and over them no larger a miss than with the sensor of least noise alone; a tenth is scatter."""
    several = [found(kind, seed) for seed in range(7000, 7025)]
    inside = np.mean(np.abs(np.concatenate([away for away, _ in several], axis=1)[:2]) < 1.96, axis=1)
    assert np.all((inside >= 0.90) & (inside <= 0.99)), inside
    alone = np.median([found(kind, seed, 1)[1] for seed in range(7000, 7025)])
    assert np.median([missed for _, missed in several]) < 1.1 * alone


def test_the_sum_has_the_least_noise():
    """White noise of covariance diag σ²: the least variance of a sum that holds the mode once is 1/Σ(c/σ)²."""
    noise = []
    for seed in range(6010, 6014):
        data = ss.measured_decay(TIME, records("white", seed)[0], band=BAND).dataset
        noise.append(data["signal"].values[-2000:].std())
    least = 1.0 / np.sqrt(np.sum((SHAPE / NOISE) ** 2))
    assert 0.95 * least < np.sqrt(np.mean(np.square(noise))) < 1.1 * least


def test_hum_beside_the_mode_that_all_sensors_hold_cancels():
    """A line of 0.1 at the first sensor, 6 % from the mode, is a tenth of that in the sum."""
    for seed in (6020, 6021):
        x, hertz, _ = records("hum beside the mode", seed)
        signal = ss.measured_decay(TIME, x, band=BAND).dataset["signal"].values
        turning = np.exp(-2j * np.pi * 1.06 * hertz * TIME[-4000:]) * np.hanning(4000) / 1000.0
        assert np.abs(signal[-4000:] @ turning) < 0.01 < 0.09 < np.abs(x[-4000:, 0] @ turning)


def test_loud_hum_far_from_the_mode_does_not_take_the_weights():
    """Three times the mode at half its frequency, in almost the ratios of the mode, so that to cancel it would cost noise."""
    x = ringing(100.0, 0.004, 0.3)[:, None] * SHAPE + NOISE * np.random.default_rng(8).normal(size=(TIME.size, 4))
    hum = 3.0 * np.cos(2.0 * np.pi * 50.0 * TIME)
    signal = ss.measured_decay(TIME, x + hum[:, None] * SHAPE * (1.0, 1.0, 1.0, 0.8), band=BAND).dataset["signal"].values[-4000:]
    noise = (signal - hum[-4000:] * (signal @ hum[-4000:]) / (hum[-4000:] @ hum[-4000:])).std()
    assert noise < 1.15 / np.sqrt(np.sum((SHAPE / NOISE) ** 2))


def test_the_amplitude_has_the_error_of_a_loud_first_sensor():
    """Twelve records whose first sensor has ten times the noise of the second: deviations of one error, by their mean square."""
    away = []
    for seed in range(12):
        noise = np.array([0.2, 0.02]) * np.random.default_rng(seed).normal(size=(TIME.size, 2))
        x = ringing(100.0, 0.004, 0.3)[:, None] * (1.0, 1.5) + noise
        data = ss.measured_decay(TIME, x, band=BAND).dataset.isel(window=slice(3))
        true = np.exp(-2.0 * np.pi * 0.4 * data["window_time"])
        away.append(float(((data["amplitude"] - true) / data["amplitude_error"]).mean()))
    assert 0.6 < np.sqrt(np.mean(np.square(away))) < 1.5


def test_a_close_mode_of_the_other_sign_is_told_apart():
    """3 % away, a third as large at the first sensor: each sensor alone misses the damping by tens of per cent."""
    for seed in (6001, 6002):
        assert found("close mode", seed)[1] < 0.1 < found("close mode", seed, 0)[1]


def test_sensors_out_of_phase_and_without_the_mode_are_said():
    late = np.column_stack([ringing(97.0, 0.004, phase) for phase in (0.3, 0.6, 0.3, 0.36)]) * (1.0, 0.5, 0.0, 1.0)
    signals = late + 0.002 * np.random.default_rng(2).normal(size=late.shape)
    said = ss.measured_decay(TIME, signals, band=BAND).dataset.attrs["sensors"]
    assert "ratios to it 1, 0.478" in said or "ratios to it 1, 0.477" in said
    assert "out of phase: sensor 2" in said
    assert "sensor 2 and" not in said  # of sensor 4, 0.06 rad, nothing is said
    assert "no motion in the mode: sensor 3" in said
    assert "another ratio" not in said


def test_a_ratio_that_changes_along_the_decay_is_said():
    decay = ringing(97.0, 0.004, 0.3)
    signals = np.column_stack([decay, decay * (0.5 + 0.5 * np.exp(-TIME / 0.3))])
    signals += 0.002 * np.random.default_rng(2).normal(size=signals.shape)
    assert "another ratio at the end of the decay" in ss.measured_decay(TIME, signals, band=BAND).dataset.attrs["sensors"]


def test_exact_records_keep_their_exact_values():
    """Without noise, with a sensor that stands still."""
    x = ringing(97.0, 0.004, 0.3)[:, None] * (1.0, -2.0, 0.0)
    data = ss.measured_decay(TIME, x).dataset
    np.testing.assert_allclose(data["damping_ratio"], 0.004, rtol=1e-6)
    np.testing.assert_allclose(data["amplitude"], np.exp(-2.0 * np.pi * 97.0 * 0.004 * data["window_time"]), rtol=1e-5)


def test_columns_of_a_file_in_several_units_of_one_quantity(tmp_path):
    """Of m/s² and g the same as of two in m/s²; a velocity beside them is refused."""
    x = records("two sensors", 4)[0]
    rows = "\n".join(f"{t:.9g};{one:.9g};{two / 9.80665:.9g};{one:.9g}" for t, (one, two) in zip(TIME, x, strict=True))
    file = tmp_path / "blade.csv"
    file.write_text(f"time [s];tip [m/s2];root [g];laser [m/s]\n{rows}\n")
    read = ss.read_decay(file, columns={"signal": ["tip", "root"]}, band=BAND).dataset
    taken = ss.measured_decay(TIME, x, "acceleration", band=BAND).dataset
    np.testing.assert_allclose(read["damping_ratio"], taken["damping_ratio"], rtol=1e-5)
    with pytest.raises(ss.InputError, match="must name a signal"):
        ss.read_decay(file, columns={"signal": []})
    with pytest.raises(ss.InputError, match="one quantity"):
        ss.read_decay(file, columns={"signal": ["tip", "laser"]})
