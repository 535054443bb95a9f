"""Predicted decays: against time integration of the true structure, coverage of the intervals, and what is refused."""

import numpy as np
import pytest

import stickslip as ss
from stickslip.laboratory.identification.response.decay_prediction import QUICK, summary, whole_tables
from stickslip.support.checks import InputError

FREQUENCIES = np.linspace(0.150, 0.170, 31)
FORCES = (0.005, 0.03, 0.06)
FINE = {"harmonics": 3, "samples": 128}
FREE = {"kt": (0.06, 0.01, 0.5), "limit": (0.04, 0.005, 0.5), "damping": (3e-3, 2e-4, 2e-2)}
AMPLITUDES = (0.5, 4.5)


def one_mass(kt=0.05, limit=0.05, damping=2e-3, gain=1.0):
    """A slider so soft that a decay takes many cycles while it slips: at most 0.9 % of damping."""
    return ss.rigs.single_mass(kt=kt, limit=limit, damping=damping)


@pytest.fixture(scope="module")
def clean():
    """The responses of the true structure, by force."""
    data = ss.forced_response(one_mass(), FREQUENCIES.tolist(), FORCES, **FINE).dataset
    return dict(zip(FORCES, data["amplitude"].values[:, :, 0], strict=True))


def identified(clean, seed, gains=(1.0, 1.0, 1.0), **about):
    """An identification by three tests with 1 % noise."""
    rng = np.random.default_rng(seed)
    tests = [
        ss.MeasuredResponse(
            FREQUENCIES,
            gain * size * (1.0 + 0.01 * rng.normal(size=size.size)),
            force,
            quantity="displacement",
            name=f"{force:g} N",
            **about,
        )
        for gain, (force, size) in zip(gains, clean.items(), strict=True)
    ]
    return ss.identify_response(one_mass, FREE, tests, tries=0, **FINE)


@pytest.fixture(scope="module")
def found(clean):
    return identified(clean, 3)


@pytest.fixture(scope="module")
def predicted(found):
    return found.predict_decay(AMPLITUDES, draws=20)


@pytest.fixture(scope="module")
def ring_down():
    """The true structure released at 7 m and integrated in time, with 0.1 % noise."""
    decay = ss.free_decay(one_mass(), 400.0, displacement={"1.x": 7.0}, steps=20_000).dataset
    rng = np.random.default_rng(0)
    signal = decay["displacement"].values[0] + 7e-3 * rng.normal(size=20_001)
    return ss.measured_decay(decay["time"].values, signal, name="ring-down")


def test_a_decay_in_time_lies_inside_its_prediction(predicted, ring_down):
    """Frequency and damping of the windows against those predicted from steady responses, by no common code of solution."""
    compared = predicted.compare(ring_down)
    data, table = compared.dataset, compared.comparison()
    assert data.sizes["window"] > 20
    assert float(data["inside_damping_ratio"][0]) > 0.75
    assert np.abs(table["error of frequency in %"]).max() < 0.05
    slipping = table[table["amplitude [m]"] > 1.3]
    assert len(slipping) >= 4
    assert np.abs(slipping["error of damping ratio in %"]).max() < 2.0
    assert "ring-down: predicted against measured frequency" in "\n".join(summary(data))


def test_the_first_line_says_what_was_free_and_what_is_extrapolated(predicted, found):
    first, *_ = summary(predicted.dataset)
    assert first.startswith("Free: kt, limit, damping. Measured amplitudes from 0.03154 m to 4.557 m:")
    assert first.endswith("decay of mode 1 of the stuck structure from 0.5 m to 4.5 m, interpolated.")
    beyond = summary(found.predict_decay((1.0, 100.0), draws=20).dataset)
    assert beyond[0].endswith("decay of mode 1 of the stuck structure from 1 m to 100 m, extrapolated in part.")
    assert any("relies on the contact law" in line for line in beyond)


def test_intervals_hold_the_decay_of_the_truth(predicted):
    hits, widths = inside(predicted.dataset)
    assert hits.mean() > 0.85
    assert np.all(widths < (3e-4, 0.06))


def inside(data):
    """Whether frequency and damping ratio of a decay along the true mode lie in the intervals (2, amplitudes), and the median
    widths of these, relative."""
    mode = ss.nonlinear_modes(one_mass(), amplitude=(0.4, 6.0), **FINE).with_decays().dataset.isel(case=0, output=0)
    size, hits, widths = np.log(mode["amplitude"].values), [], []
    for key, values in (("frequency", mode["frequency"].values), ("damping_ratio", mode["decay_damping_ratio"].values)):
        truth = np.interp(np.log(data["amplitude"].values), size, values)
        low, high = data[f"{key}_low"].values, data[f"{key}_high"].values
        hits.append((low <= truth) & (truth <= high))
        widths.append(np.median((high - low) / truth))
    return np.array(hits), np.array(widths)


@pytest.mark.nightly
def test_95_per_cent_intervals_hold_95_per_cent_of_true_decays(clean):
    """Twenty seeds of noise, at five amplitudes that are far enough apart to be of their own."""
    hits = [inside(identified(clean, seed).predict_decay(AMPLITUDES, seed=seed).dataset)[0][:, ::24] for seed in range(20)]
    assert 0.90 <= np.mean(hits) <= 0.99, np.mean(hits)


def test_gains_of_the_tests_move_the_amplitudes(clean):
    """Half as much again is measured in all tests: the measured amplitudes of a decay are so as well."""
    plain = identified(clean, 3).predict_decay((1.0, 3.0), draws=20).dataset
    gained = identified(clean, 3, gains=(1.5, 1.5, 1.5), free_gain=True).predict_decay((1.5, 4.5), draws=20).dataset
    assert gained["amplitude"].values == pytest.approx(1.5 * plain["amplitude"].values)
    assert gained["damping_ratio"].values == pytest.approx(plain["damping_ratio"].values, rel=0.1)
    assert gained["frequency"].values == pytest.approx(plain["frequency"].values, rel=5e-4)
    assert "separately for each test: gain" in summary(gained)[0]


def test_a_quick_decay_is_said_to_be_one(predicted, ring_down):
    """Within two cycles of a damping ratio of three per cent the amplitude falls by a third."""
    assert np.exp(-2.0 * 2.0 * np.pi * QUICK) == pytest.approx(2.0 / 3.0, abs=0.03)
    compared = predicted.compare(ring_down).dataset
    assert not any("too quick" in line for line in summary(compared))
    quick = compared.assign(damping_ratio=compared["damping_ratio"] + QUICK)
    assert any("too quick" in line for line in summary(quick))


def two_masses(kt=0.5, gain=1.0):
    """The first rubs: its frequency comes to that of the second as it begins to slip."""
    structure = ss.Structure(np.eye(2), [[1.1, -0.1], [-0.1, 1.25]], ("1.x", "2.x"), C=0.002 * np.eye(2))
    slider = ss.Contact("slider", ss.Macroslip(kt=kt, mu=1.0, normal_load=1.0), ({"1.x": 1.0},))
    return ss.Problem(structure, (slider,), (ss.Force("1.x", 1.0),), ("1.x",))


def test_a_mode_that_comes_close_is_said(predicted):
    """As of a decay along the mode, whose damping is up to 1.9 times that of half cycles (`test_slow_decay.py`)."""
    assert not any("another mode takes part" in line for line in summary(predicted.dataset))
    frequencies = np.linspace(0.165, 0.215, 21)
    data = ss.forced_response(two_masses(), frequencies.tolist(), [0.2, 1.5], **FINE).dataset
    tests = [
        ss.MeasuredResponse(frequencies, size, force, quantity="displacement", name=f"{force:g} N")
        for force, size in zip((0.2, 1.5), data["amplitude"].values[:, :, 0], strict=True)
    ]
    close = ss.identify_response(two_masses, {"kt": (0.49, 0.1, 2.0)}, tests, tries=0, **FINE).predict_decay(
        (3.0, 30.0), mode=2, draws=20
    )
    assert sum("another mode takes part" in line for line in summary(close.dataset)) == 1
    apart = close.dataset["amplitude"].values[close.dataset["uncertain"].values > 0.5]
    assert 10.0 < apart.max() < 17.0
    assert apart.min() == pytest.approx(3.0)


@pytest.mark.parametrize(
    ("amplitude", "settings", "message"),
    [
        ((2.0, 1.0), {}, "amplitude must be (low, high) with low below high"),
        ((1.0,), {}, "amplitude must have 2 entries"),
        ((1.0, 2.0), {"mode": 3}, "mode"),
        ((1.0, 2.0), {"band": ss.hertz(3.0, 4.0)}, "band must hold measured points, or mode or frequency be given"),
        ((1.0, 2.0), {"mode": 1, "frequency": 0.16}, "mode and frequency must not be given together"),
        ((1.0, 2.0), {"settings": {"kt": 1.0}}, "settings must not name what was identified"),
        ((1.0, 2.0), {"draws": 3}, "draws must be at least 20"),
    ],
)
def test_what_is_refused(found, amplitude, settings, message):
    with pytest.raises(InputError) as error:
        found.predict_decay(amplitude, **settings)
    assert message in str(error.value)


def test_decays_at_other_amplitudes_are_refused(predicted, ring_down):
    small = ring_down.dataset.assign(amplitude=1e-3 * ring_down.dataset["amplitude"])
    with pytest.raises(InputError, match=r"The amplitudes of ring-down must reach into those that are predicted, 0\.5 to 4\.5 m"):
        predicted.compare(ss.MeasuredDecay(small))
    with pytest.raises(InputError, match="A comparison needs measured decays"):
        predicted.comparison()


def test_comparisons_replace_each_other_and_name_another_mode(predicted, ring_down):
    """Two decays after one; a decay at half the frequency is that of another mode; exports hold all amplitudes and windows."""
    other = ss.MeasuredDecay(ring_down.dataset.assign(frequency=0.5 * ring_down.dataset["frequency"]))
    twice = predicted.compare(ring_down).compare([ring_down, other])
    said = summary(twice.dataset)
    assert twice.dataset.sizes["decay"] == 2
    assert sum("Is it the decay of another mode?" in line for line in said) == 1
    tables = whole_tables(twice.dataset)
    assert len(tables["decay"]) == predicted.dataset.sizes["amplitude"]
    assert len(tables["windows"]) == 2 * twice.dataset.sizes["window"]


def test_a_decay_does_not_depend_on_the_range_that_is_predicted(found, predicted):
    """Where slip begins the damping rises within a few per cent of the amplitude: two decades more move it by little."""
    wide = found.predict_decay((0.005, 50.0), draws=20).dataset
    narrow = predicted.dataset
    for key, most in (("frequency", 2e-4), ("damping_ratio", 0.03)):
        at = np.interp(np.log(narrow["amplitude"].values), np.log(wide["amplitude"].values), wide[key].values)
        assert at == pytest.approx(narrow[key].values, rel=most)
