"""Predictions from an identification: coverage of their intervals on synthetic truths, draws against what they are drawn from,
peaks against closed forms."""

import json
import re

import numpy as np
import pytest
import xarray as xr

import stickslip as ss
from stickslip.laboratory.identification.response.draws import Draws, interval, line_over
from stickslip.laboratory.identification.response.prediction_result import curve_table, steady_median, summary
from stickslip.laboratory.measurement.measured_response import at_frequencies, curve_peak, measured_peak
from stickslip.support.checks import InputError, digits_between

FREQUENCIES = np.linspace(0.14, 0.24, 21)
MEASURED, UNMEASURED = (0.3, 1.0, 2.0), (0.6, 1.5, 4.0)
FINE = {"harmonics": 3, "samples": 128}
FREE = {"kt": (0.6, 0.1, 5.0), "limit": (0.8, 0.1, 5.0), "damping": (0.03, 0.002, 0.2)}


def one_mass(kt=0.5, limit=1.0, damping=0.02, load=1.0):
    return ss.rigs.single_mass(kt=kt, limit=limit * load, damping=damping)


@pytest.fixture(scope="module")
def clean():
    """The responses of the true problem, by force."""
    data = ss.forced_response(one_mass(), FREQUENCIES.tolist(), MEASURED, **FINE).dataset
    return dict(zip(MEASURED, data["amplitude"].values[:, :, 0], strict=True))


def measured(clean, force, rng, noise=0.01, gain=1.0, **about):
    """A measured test: the truth times a gain and 1 + noise."""
    size = gain * clean[force] * (1.0 + noise * rng.normal(size=FREQUENCIES.size))
    return ss.MeasuredResponse(FREQUENCIES, size, force, quantity="displacement", name=f"{force:g} N", **about)


@pytest.fixture(scope="module")
def found(clean):
    """An identification by three tests with 1 % noise."""
    rng = np.random.default_rng(1)
    return ss.identify_response(one_mass, FREE, [measured(clean, force, rng) for force in MEASURED], tries=0, **FINE)


def inside(clean, seeds, forces, draws):
    """Of each seed of noise, force and quantity whether the true peak lies in the 95 % interval, and how wide that is."""
    peaks = ss.forced_response(one_mass(), ss.hertz(0.14, 0.24), forces, **FINE).peaks()
    peaks = peaks[peaks["peak"] == 0].set_index("force_level")
    hits, widths = [], []
    for seed in seeds:
        rng = np.random.default_rng(seed)
        found = ss.identify_response(one_mass, FREE, [measured(clean, force, rng) for force in MEASURED], tries=0, **FINE)
        data = found.predict(forces, seed=seed, draws=draws).dataset
        for k, force in enumerate(forces):
            for key in ("frequency", "amplitude"):
                low, high = (float(data[f"peak_{key}_{end}"][k]) for end in ("low", "high"))
                hits.append(low <= peaks.loc[force, key] <= high)
                widths.append((high - low) / peaks.loc[force, key])
    return np.array(hits), np.array(widths)


def test_intervals_hold_the_truth_at_an_unmeasured_force(clean):
    """Two seeds; intervals are below the 1 % of the noise, so that a wide one would be noticed. All seeds: below."""
    hits, widths = inside(clean, (0, 2), (0.6,), 20)
    assert hits.sum() >= 3
    assert np.all(widths < 0.015)


@pytest.mark.nightly
def test_95_per_cent_intervals_hold_95_per_cent_of_truths(clean):
    """Twenty seeds of noise, three forces inside and beyond the measured ones, frequency and amplitude of the peak."""
    hits, widths = inside(clean, range(20), UNMEASURED, 40)
    assert 0.90 <= hits.mean() <= 0.99, hits.mean()
    assert np.median(widths) < 0.01


def dataset_of_draws(values, covariance, tests, unknown=(), bounds=(-9.0, 9.0), curves=None):
    """A dataset as an identification keeps it: parameters a (of all tests) and b (of each test), as shares of −10 to 10."""
    size = len(values)
    names = ["a"] + ["b"] * (size - 1)
    free = {"a": ss.FreeParameter(0.0, -10.0, 10.0), "b": ss.FreeParameter(0.0, -10.0, 10.0, each_test=True)}
    if size == 1:
        del free["b"]
    fit = {
        "fit_value": np.array(values),
        "fit_low": np.full(size, bounds[0]),
        "fit_high": np.full(size, bounds[1]),
        "fit_unknown": np.isin(np.arange(size), unknown).astype(float),
        "fit_test": np.array([-1.0, *range(size - 1)]),
    }
    data = {name: ("fit_variable", row) for name, row in fit.items()}
    data["fit_covariance"] = ("fit_variable", "fit_variable_2"), np.array(covariance)
    f = np.linspace(90.0, 110.0, 21)
    shown = 1.0 / np.hypot(1.0 - (f / 100.0) ** 2, 0.05)
    curves = np.tile(shown, (tests, 1)) if curves is None else curves
    data |= {
        "frequency": (("test", "point"), np.tile(f, (tests, 1))),
        "computed": (("test", "point"), np.tile(shown, (tests, 1))),
    }
    data |= {"measured": (("test", "point"), curves), "solved": (("test", "point"), np.ones((tests, 21)))}
    coords = {"fit_variable": names, "fit_variable_2": names}
    return xr.Dataset(data, coords, {"free": json.dumps({name: vars(each) for name, each in free.items()})})


def shares(draws, name):
    """Variables of a parameter between −10 and 10."""
    return np.array([(draw.values[name] + 10.0) / 20.0 for draw in draws])


def test_draws_have_the_covariance_of_the_fit():
    """Correlated variables of two names, one test each; what one test alone has keeps its estimate."""
    covariance = np.array([[0.04, 0.018], [0.018, 0.01]])
    draws = Draws.of(dataset_of_draws([0.5, 0.4], covariance, 1)).drawn(4000, 0)
    both = np.array([shares(draws, "a"), shares(draws, "b")])
    assert both.mean(axis=1) == pytest.approx([0.5, 0.4], abs=5e-3)
    assert np.cov(both) == pytest.approx(covariance, rel=0.06)


def test_draws_stay_inside_bounds_and_fill_them_where_nothing_is_known():
    found = Draws.of(dataset_of_draws([0.5], [[0.04]], 1, bounds=(0.4, 0.9))).drawn(2000, 0)
    assert shares(found, "a").min() >= 0.4 - 1e-12
    assert np.mean(shares(found, "a") > 0.5) == pytest.approx(0.4772 / (0.4772 + 0.1915), abs=0.03)
    open_one = Draws.of(dataset_of_draws([0.5], [[0.0]], 1, unknown=(0,), bounds=(0.2, 0.9)))
    assert open_one.unknown == ["a"]
    drawn = shares(open_one.drawn(100, 0), "a")
    assert (drawn.min(), drawn.max()) == pytest.approx((0.2, 0.9), abs=0.01)
    assert drawn.mean() == pytest.approx(0.55, abs=5e-3)


def test_what_each_test_has_by_itself_is_drawn_for_a_further_test():
    """Student's prediction interval of one more value from four: mean ± 3.182 s √(1 + 1/4)."""
    own = np.array([0.47, 0.49, 0.52, 0.56])
    draws = Draws.of(dataset_of_draws([0.5, *own], np.zeros((5, 5)), 4)).drawn(4000, 0)
    low, middle, high = interval(shares(draws, "b"))
    reach = 3.182446 * np.std(own, ddof=1) * np.sqrt(1.25)
    assert middle == pytest.approx(own.mean(), abs=1e-3)
    assert [low, high] == pytest.approx([own.mean() - reach, own.mean() + reach], abs=0.03 * reach)


def test_scatter_between_tests_is_seen_beyond_noise():
    """Eight tests with known factors on response and frequency; noise alone gives none."""
    rng, f = np.random.default_rng(0), np.linspace(90.0, 110.0, 21)

    def curve(gain, shift):
        return gain / np.hypot(1.0 - (f / shift / 100.0) ** 2, 0.05) * np.exp(0.002 * rng.normal(size=f.size))

    gains, shifts = (
        np.exp(0.05 * np.array([-1.0, 1, -1, 1, -1, 1, -1, 1])),
        np.exp(0.002 * np.array([1.0, 1, -1, -1, 1, 1, -1, -1])),
    )
    curves = np.array([curve(*pair) for pair in zip(gains, shifts, strict=True)])
    scatter = Draws.of(dataset_of_draws([0.5], [[0.01]], 8, curves=curves)).scatter
    # 15 of 16 factors are free, one is taken up by the parameter
    assert scatter.gain == pytest.approx(0.05 * np.sqrt(16 / 15), rel=0.03)
    assert scatter.shift == pytest.approx(0.002 * np.sqrt(16 / 15), rel=0.1)
    assert scatter.freedom == 15.0
    quiet = np.array([curve(1.0, 1.0) for _ in range(8)])
    none = Draws.of(dataset_of_draws([0.5], [[0.01]], 8, curves=quiet)).scatter
    assert (none.gain, none.shift) == (0.0, 0.0)
    drawn = Draws.of(dataset_of_draws([0.5], [[0.0]], 8, curves=curves)).drawn(2000, 0)
    assert np.std([draw.gain for draw in drawn]) == pytest.approx(scatter.gain * 2.131450 / 1.959964, rel=0.03)
    assert np.std([draw.shift for draw in drawn]) == pytest.approx(scatter.shift * 2.131450 / 1.959964, rel=0.03)


def test_an_interval_is_from_end_to_end_of_39_draws():
    """(39 − 1)/(39 + 1) = 95 % of what is drawn alike lies between the ends of 39."""
    values = np.random.default_rng(0).permutation(39).astype(float)
    assert interval(values) == pytest.approx([0.0, 19.0, 38.0])
    assert interval(np.append(values, np.nan)) == pytest.approx([0.0, 19.0, 38.0])


def test_half_power_and_peak_of_an_oscillator():
    """|H| = 1/√((1 − r²)² + (2 ζ r)²): peak at √(1 − 2ζ²), half power at r² = 1 − 2ζ² ± 2ζ √(1 − ζ²); upwards, downwards, and
    measured at coarse frequencies."""
    zeta, r = 0.03, np.linspace(0.9, 1.1, 4001)
    size = 1.0 / np.hypot(1.0 - r**2, 2.0 * zeta * r)
    top, height = np.sqrt(1.0 - 2.0 * zeta**2), 1.0 / (2.0 * zeta * np.sqrt(1.0 - zeta**2))
    ends = np.sqrt(1.0 - 2.0 * zeta**2 + np.array([-1.0, 1.0]) * 2.0 * zeta * np.sqrt(1.0 - zeta**2))
    damping = (ends[1] - ends[0]) / (2.0 * top)
    for order in (slice(None), slice(None, None, -1)):
        assert curve_peak(r[order], size[order], (top, height)) == pytest.approx([top, height, damping], rel=1e-4)
    coarse = slice(7, None, 100)
    assert measured_peak(r[coarse], size[coarse]) == pytest.approx([top, height, damping], rel=3e-3)
    assert np.isnan(curve_peak(r[1800:2200], size[1800:2200], (top, height))[2])
    assert np.isnan(measured_peak(r[r > 1.0], size[r > 1.0])).all()


def test_a_folded_curve_has_its_largest_response():
    frequency, size = np.array([1.0, 3.0, 2.0, 4.0]), np.array([1.0, 3.0, 2.0, 1.0])
    assert at_frequencies(np.array([0.5, 1.5, 2.5, 3.5]), frequency, size)[1:] == pytest.approx([1.5, 2.5, 1.25])
    assert np.isnan(at_frequencies(np.array([0.5, 4.5]), frequency, size)).all()


@pytest.mark.slow
def test_a_prediction_says_what_it_rests_on(found, clean):
    """At forces and at held amplitudes, inside and beyond what was measured; figures and sentences; saved and compared."""
    data = found.predict([0.6, 4.0], draws=20).compare(measured(clean | {0.6: clean[0.3] * 2.0}, 0.6, np.random.default_rng(0)))
    first, *others = summary(data.dataset)
    assert first == "Free: kt, limit, damping. Measured forces from 0.3 to 2 N: 0.6 N interpolated, 4 N extrapolated."
    assert any("20 draws" in line and "90 %" in line for line in others)
    assert any("relies on the contact law" in line for line in others)
    assert {"", "peaks"} == set(data.figures)
    held = found.predict(amplitude=4.0, draws=20).dataset
    truth = ss.controlled_response(one_mass(), ss.hertz(0.14, 0.24), 4.0, quantity="displacement", **FINE).resonances()
    assert float(held["peak_frequency"][0]) == pytest.approx(truth["frequency"][0], rel=2e-3)
    assert float(held["peak_amplitude"][0]) == pytest.approx(4.0 / truth["force_level"][0], rel=0.01)
    assert held["peak_amplitude"].attrs["units"] == "m/N"


def test_errors_of_a_measured_curve_are_those_of_its_peak(found, clean):
    """A further test of the truth lies inside; one of another blade, twice as high, does not."""
    rng, data = np.random.default_rng(5), ss.forced_response(one_mass(), FREQUENCIES.tolist(), 0.6, **FINE).dataset
    truth = {0.6: data["amplitude"].values[0, :, 0]}
    table = found.predict(0.6).compare([measured(truth, 0.6, rng), measured(truth, 0.6, rng, gain=2.0)]).comparison()
    assert table["points inside in %"][0] >= 85.0
    assert table["points inside in %"][1] == 0.0
    assert table["error of amplitude in %"].to_numpy() == pytest.approx([0.0, -50.0], abs=3.0)
    assert table["error of frequency in %"].to_numpy() == pytest.approx([0.0, 0.0], abs=0.6)


def test_the_error_of_few_harmonics_is_part_of_the_interval(found):
    """Three harmonics against nine at the identified parameters, half as much again; the band goes on to its ends."""
    band, problem = ss.hertz(0.14, 0.24), one_mass(**dict(zip(FREE, found.values.values(), strict=True)))
    few, many = (
        ss.forced_response(problem, band, 0.6, h, n).peaks().iloc[0][["frequency", "amplitude"]].to_numpy(float)
        for h, n in ((3, 128), (9, 256))
    )
    data = found.predict(0.6).dataset
    errors = [float(data[f"peak_{key}_error"][0]) for key in ("frequency", "amplitude")]
    assert errors == pytest.approx(1.5 * np.abs(np.log(many / few)), rel=1e-3)
    low, high = (float(data[f"peak_frequency_{end}"][0]) for end in ("low", "high"))
    assert (high - low) / (high + low) > 0.9 * errors[0]
    assert np.isfinite(data["amplitude_drawn"].values[0][:, np.isfinite(data["frequency"].values[0])]).all()


@pytest.mark.slow
def test_start_states_are_drawn_as_they_were_identified(clean):
    """Free start states have their prior; stuck contacts at a small force then have many responses, virgin ones have one."""
    rng = np.random.default_rng(0)
    tests = [measured(clean, force, rng, noise=0.0) for force in MEASURED]
    known = ss.identify_response(one_mass, FREE, tests, tries=0, **FINE, start_states="free")
    found = known.predict(0.3, draws=20, band=ss.hertz(0.15, 0.22))
    assert found.dataset.attrs["start_states"] == "free"
    virgin = known.predict(0.3, draws=20, band=ss.hertz(0.15, 0.22), start_states="virgin")
    assert virgin.dataset.attrs["start_states"] == "virgin"


@pytest.mark.slow
def test_settings_that_differ_must_be_given(clean):
    rng = np.random.default_rng(0)
    tests = [measured(clean, force, rng, settings={"load": load}) for force, load in zip(MEASURED, (1.0, 1.0, 1.1), strict=True)]
    found = ss.identify_response(one_mass, FREE, tests, tries=0, **FINE)
    with pytest.raises(InputError, match="'load'"):
        found.predict(0.6)
    with pytest.raises(InputError, match="must not name what was identified"):
        found.predict(0.6, settings={"kt": 1.0, "load": 1.0})
    assert np.isfinite(found.predict(0.6, settings={"load": 1.0}, draws=20).dataset["peak_frequency"]).all()


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({}, "force must be given, or amplitude"),
        ({"force": 1.0, "amplitude": 1.0}, "force and amplitude must not be given together"),
        ({"force": -1.0}, "force must be positive"),
        ({"force": 1.0, "draws": 5}, "draws must be"),
        ({"force": 1.0, "start_states": "all"}, "start_states must be one of"),
        ({"force": 1.0, "band": [0.1, 0.2]}, "band must be"),
    ],
)
def test_wrong_arguments_are_refused(found, arguments, message):
    with pytest.raises(InputError, match=message):
        found.predict(**arguments)


def resonance(f, gain=1.0, top=100.0):
    return gain / np.hypot(1.0 - (f / top) ** 2, 0.05 * f / top)


def a_prediction(seed, draws=40, level=2.0, spread=0.01):
    """A prediction at one level as `predict_response` gives it: draws of a resonance that scatter in gain and frequency."""
    rng, f = np.random.default_rng(seed), np.linspace(90.0, 110.0, 81)
    gains, tops = np.exp(spread * rng.normal(size=draws)), 100.0 * np.exp(1e-3 * rng.normal(size=draws))
    curves = level * np.array([resonance(f, *each) for each in zip(gains, tops, strict=True)])
    data = {
        "frequency": (("level", "point"), f[None]),
        "amplitude_drawn": (("level", "draw", "point"), curves[None]),
        "peak_amplitude": ("level", [20.0], {"units": "m/s2"}),
        "interpolated": ("level", [1.0]),
        "peak_frequency_error": ("level", [0.0]),
        "peak_amplitude_error": ("level", [0.0]),
    }
    for key in ("peak_frequency", "peak_amplitude", "damping_ratio"):
        data |= {f"{key}{end}": ("level", [20.0], {"units": "m/s2"}) for end in ("", "_low", "_high")}
    attrs = {"held": "force", "quantity": "acceleration", "seed": seed, "draws": draws, "point_error": 0.01, "free": "kt"}
    attrs |= {"free_of_each_test": "", "unknown": "", "measured_from": 1.0, "measured_to": 3.0, "scatter_known": 1}
    attrs |= {"gain_scatter": 0.0, "frequency_scatter": 0.0}
    level_named = ("level", [level], {"units": "N", "long_name": "force level"})
    return ss.ResponsePrediction(xr.Dataset(data, {"level": level_named}, attrs))


def a_test(gain=1.0, force=2.0, name="blade", **about):
    f = np.linspace(92.0, 112.0, 11)
    return ss.MeasuredResponse(f, force * resonance(f, gain), force, name=name, **about)


def compared_lines(prediction, *tests):
    return [line for line in summary(prediction.compare(tests).dataset) if any(line.startswith(test.name) for test in tests)]


def test_errors_of_the_same_curve_are_the_same():
    """Of two copies in one comparison to the last bit, of several seeds of the draws to the digits that are shown."""
    table = a_prediction(0).compare([a_test(), a_test(name="copy")]).comparison()
    heads = [f"error of {what} in %" for what in ("frequency", "amplitude", "damping ratio")]
    assert table[heads].iloc[0].to_list() == table[heads].iloc[1].to_list()
    assert abs(table[heads[1]][0]) < 0.6  # the standard error of the median of 40 draws of 1 % is 0.2 %
    for seed in range(5):
        (line,) = compared_lines(a_prediction(seed), a_test())
        assert "amplitude +0 % (inside)" in line or "amplitude -0 % (inside)" in line, line


def test_the_standard_error_of_a_median_is_that_of_its_draws():
    """√(π/2) s/√n for normal draws, against the scatter of medians of 400 samples; noise within a draw adds its share only."""
    rng = np.random.default_rng(0)
    samples = [rng.normal(size=50) + 0.5 * rng.normal(size=(20, 50)) for _ in range(400)]
    medians, errors = np.transpose([steady_median(each) for each in samples])
    assert np.mean(errors) == pytest.approx(np.std(medians), rel=0.2)
    assert np.isnan(steady_median(np.full((2, 3), np.nan))).all()


@pytest.mark.parametrize(
    ("gain", "shown", "cause"),
    [
        (1.0 / 9.80665, r"amplitude 9\.\d* times as large", "an acceleration in g is given as in m/s2"),
        (2.0**-0.5, r"amplitude \+41 %", "the response is an RMS value"),
        (1e3, r"amplitude 0\.00(1|09)\d* times as large", "the force is in kN but taken for N"),
        (0.8e-3, r"amplitude 12\d\d times as large", "the force is in N but taken for kN"),
    ],
)
def test_a_wrong_unit_of_a_compared_curve_is_suspected(gain, shown, cause):
    first, second = compared_lines(a_prediction(0), a_test(gain))
    assert cause in second
    assert re.search(shown, first), first


def test_a_prediction_that_is_merely_wrong_is_not_taken_for_a_unit():
    (line,) = compared_lines(a_prediction(0), a_test(0.85))
    assert "amplitude +1" in line
    assert "(outside)" in line


def test_compared_points_outside_the_band_are_left_out():
    """A curve beyond the band from 90 to 110 Hz has its peak from the points inside; one of kHz has no point inside."""
    data = a_prediction(0).compare(a_test()).dataset
    assert np.nanmax(data["measured_frequency"].values) == pytest.approx(110.0)
    assert float(data["predicted_peak_frequency"][0]) == pytest.approx(100.0, rel=3e-3)
    test = a_test()
    away = ss.MeasuredResponse(np.asarray(test.frequency) / 1e3, test.amplitude, 2.0, name="kHz")
    with pytest.raises(InputError, match=r"at least three, but is 0. .* 0\.092 to 0\.112 Hz.*unit of the frequency"):
        a_prediction(0).compare(away)


def test_units_that_were_assumed_of_a_compared_curve_are_named(tmp_path):
    test = a_test()
    rows = zip(test.frequency, test.amplitude, test.force, strict=True)
    (tmp_path / "blade.csv").write_text("frequency,acceleration,force\n" + "\n".join(",".join(map(str, row)) for row in rows))
    said = summary(a_prediction(0).compare(ss.read_measured_response(tmp_path / "blade.csv")).dataset)
    assert "No unit is stated of frequency, acceleration and force in blade: Hz, m/s2 and N are assumed." in said


def test_intervals_of_few_draws_say_what_they_hold():
    """(20 − 1)/(20 + 1) = 90 %."""
    few, many = (summary(a_prediction(0, draws).dataset) for draws in (20, 39))
    assert any("90 % interval" in line for line in few)
    assert not any("95 % interval" in line for line in few)
    assert any("95 % interval" in line for line in many)


def test_a_band_without_a_peak_is_the_cause_that_is_named(found):
    """And no number is missing where figures take the largest."""
    prediction = found.predict(0.6, draws=20, band=ss.hertz(0.23, 0.24))
    said = summary(prediction.dataset)
    assert "0.6 N: no peak in the band. Give another or a wider band." in said
    assert not any("harmonics" in line for line in said)
    for name in ("", "peaks"):
        prediction.plot(name) if name else prediction.plot()


def test_curves_that_end_early_are_not_blamed_on_the_band():
    lost = {"peak_frequency": ("level", [np.nan]), "unsolved": ("level", [40.0])}
    said = summary(a_prediction(0).dataset.assign(lost))
    assert "2 N: no peak in the part of the band that the curves reach." in said


def test_results_of_earlier_versions_are_shown():
    """They hold neither standard errors of the compared values nor the gain of a test."""
    data = a_prediction(0).compare(a_test()).dataset
    old = data.drop_vars([name for name in data if name == "gain" or str(name).endswith("_deviation")])
    old.attrs.pop("notes_on_tests")
    assert any(line.startswith("blade: predicted against measured frequency") for line in summary(old))


def test_what_each_test_has_by_itself_may_lie_on_a_line_over_the_levels():
    """Ends by hand at a level between the tests and beyond them: t of two degrees of freedom times s √(1 + 1/n + (L − L̄)²/Σ²)."""
    levels, off = np.array([1.0, 2.0, 3.0, 4.0]), np.array([1e-3, -1e-3, -1e-3, 1e-3])
    own = 0.30 + 0.05 * levels + off
    known = Draws.of(dataset_of_draws([0.5, *own], np.zeros((5, 5)), 4))
    assert known.lines(levels) == ["b"]
    for level in (2.5, 6.0):
        drawn = shares(known.drawn(2000, 0, (levels, level)), "b")
        middle = 0.30 + 0.05 * min(level, 4.0)  # beyond the tests nothing says that the line goes on
        reach = 4.302653 * np.sqrt(4e-6 / 2.0 * (1.0 + 0.25 + (level - 2.5) ** 2 / 5.0))
        assert np.percentile(drawn, [2.5, 97.5]) == pytest.approx(middle + reach * np.array([-1.0, 1.0]), abs=3e-4)
    assert shares([known.best_at((levels, 6.0))], "b") == pytest.approx([0.5])
    assert shares([known.best_at(None)], "b") == pytest.approx([own.mean()])


@pytest.mark.parametrize(("values", "found"), [([0.5, 0.52, 0.49, 0.51], False), ([0.5, 0.6, 0.7], False), ([0.5] * 4, False)])
def test_chance_and_three_tests_make_no_line(values, found):
    levels = np.arange(1.0, len(values) + 1.0)
    assert (line_over(levels, np.array(values)) is not None) == found
    assert line_over(np.ones(4), np.array([0.1, 0.2, 0.3, 0.4])) is None


def test_a_line_over_the_levels_is_said_in_the_first_line(found):
    attrs = found.predict(0.6, draws=20).dataset.attrs | {"free_of_each_test": "gain, frequency", "free_over_level": "frequency"}
    first = summary(found.predict(0.6, draws=20).dataset.assign_attrs(attrs))[0]
    assert first.startswith("Free: kt, limit, damping; separately for each test: gain, frequency (along a line over the levels).")


def test_a_held_amplitude_without_phase_resonance_is_named_as_that(found):
    prediction = found.predict(amplitude=3.0, draws=20, band=ss.hertz(0.23, 0.24))
    words = "3 m: no peak in the band, because force and displacement are not at 90° anywhere. Give another or a wider band."
    assert words in summary(prediction.dataset)


def test_an_identification_that_explains_nothing_is_said_before_all_else():
    """What follows is only as good; one that explains its tests needs no such sentence."""
    attrs = a_prediction(0).dataset.attrs
    first = summary(a_prediction(0).dataset.assign_attrs(attrs | {"worst_misfit": 0.17}))[0]
    assert first.startswith("The identification did not explain its tests: the misfit is 17 % of the largest response.")
    assert summary(a_prediction(0).dataset.assign_attrs(attrs | {"worst_misfit": 0.09}))[0].startswith("Free: kt.")


def test_both_ends_of_a_narrow_interval_differ_in_their_digits():
    """Of 1.37e5 within ten, and of a peak within its fifth digit; wide intervals keep few digits."""
    assert digits_between(136990.0, 137010.0, 5) == 6
    assert digits_between(0.5, 2.0, 5) == 5
    assert digits_between(1.0, 1.0, 4) == 4
    one = a_prediction(0).dataset
    one = one.assign(
        {f"peak_amplitude{end}": one["peak_amplitude"] * f for end, f in (("_low", 1.0), ("_high", 1.00003), ("", 1.00001))}
    )
    line = next(line for line in summary(one) if "peak at" in line)
    _, ends = line.split(" Hz), ")
    low, high = re.findall(r"\(([\d.]+) .*? to ([\d.]+) ", ends)[0]
    assert float(high) > float(low)


def test_noise_of_compared_peaks_is_what_differs_from_point_to_point(found):
    """A misfit that goes along the curves is no noise of points: a predicted half-power width would break on it."""
    data = found.dataset
    assert np.array_equal(data["point_noise"].values, data["point_error"].values)  # independent from point to point
    prediction = found.predict(0.6, draws=20)
    smooth = prediction.dataset.assign_attrs(point_error=0.11, point_noise=0.0)
    measured = ss.MeasuredResponse(FREQUENCIES, np.interp(FREQUENCIES, *curve_of(prediction)), 0.6, quantity="displacement")
    compared = ss.ResponsePrediction(smooth).compare(measured).dataset
    assert float(compared["predicted_damping_ratio"][0]) == pytest.approx(float(compared["measured_damping_ratio"][0]), rel=0.02)


def curve_of(prediction):
    """Frequencies and medians of the first level."""
    known = np.isfinite(prediction.dataset["frequency"].values[0])
    return prediction.dataset["frequency"].values[0][known], prediction.dataset["amplitude"].values[0][known]


def test_curves_with_their_bands_are_among_the_tables(found):
    """For other programs: every point of every level."""
    data = found.predict([0.6, 1.5], draws=20).dataset
    table = curve_table(data)
    assert len(table) == int(np.isfinite(data["frequency"].values).sum())
    assert np.all(table["from amplitude [m]"] <= table["amplitude [m]"])
    assert set(table["force level [N]"]) == {0.6, 1.5}
