"""Isolated curves of a cubic oscillator with a linear absorber, and subharmonics of one without: beside SciPy's time integration.

The absorber is tuned after Den Hartog: at large amplitude the oscillator leaves its frequency, so that the force which its mode
needs falls with the amplitude. Such detached resonance curves are known of it (G. Habib, T. Detroux, R. Viguié, G. Kerschen,
Mechanical Systems and Signal Processing 52-53, 2015); the numbers here are our own.
"""

import json
from dataclasses import replace

import numpy as np
import pytest
import xarray as xr
from scipy.integrate import solve_ivp
from typer.testing import CliRunner

import stickslip as ss
from stickslip.analyses.isolated import Isolated, LevelCurves
from stickslip.cli import app
from stickslip.results.schema import attributes_of
from stickslip.results.view import highest_peak, level_text
from stickslip.show.report.answer import further_curves_sentence
from stickslip.show.report.markup import Charts, hertz
from stickslip.show.report.responses import sentences
from stickslip.show.report.sections import overview
from stickslip.study.further_curves import FurtherCurves, IsolatedTable
from stickslip.support.units import unit_system

TURN = 2.0 * np.pi
MASS, OWN = 0.05, 0.0005
TUNING = 1.0 / (1.0 + MASS)
K2 = MASS * TUNING**2
C2 = 0.6 * 2.0 * MASS * TUNING * np.sqrt(3.0 * MASS / (8.0 * (1.0 + MASS) ** 3))
LEVEL = 0.038
BAND = ss.radians_per_second(0.7, 2.0)


def absorber():
    M, K = np.diag([1.0, MASS]), np.array([[1.0 + K2, -K2], [-K2, K2]])
    structure = ss.Structure(M, K, ("1.x", "2.x"), C=np.array([[OWN + C2, -C2], [-C2, C2]]))
    spring = ss.Contact("spring", ss.CubicSpring(1.0), (ss.between("1.x", "ground"),))
    return ss.Problem(structure, (spring,), (ss.Force("1.x", 1.0),), ("1.x", "2.x"))


def absorber_after(periods, omega, start):
    """State after a number of periods, (x1, x2, v1, v2), by SciPy."""

    def rates(t, y):
        x1, x2, v1, v2 = y
        joint = K2 * (x1 - x2) + C2 * (v1 - v2)
        return [v1, v2, LEVEL * np.cos(omega * t) - joint - x1 - x1**3 - OWN * v1, joint / MASS]

    return solve_ivp(rates, (0.0, periods * TURN / omega), start, rtol=1e-10, atol=1e-12).y[:, -1]


def state(dataset, case, point):
    omega = TURN * float(dataset.frequency[case, point])
    parts = dataset.response.values[case, point]
    X, h = parts[..., 0] + 1j * parts[..., 1], dataset.harmonic.values
    return omega, np.concatenate([X.real.sum(axis=1), (1j * h * omega * X).real.sum(axis=1)])


@pytest.fixture(scope="module")
def swept():
    return ss.forced_response(absorber(), BAND, LEVEL, harmonics=5, samples=64, isolated=False)


@pytest.fixture(scope="module")
def modes():
    return ss.nonlinear_modes(absorber(), 2, amplitude=(1e-2, 6.0), harmonics=5, samples=64)


@pytest.fixture(scope="module")
def whole(swept, modes):
    return swept.with_isolated(modes)


def test_the_mode_finds_what_the_sweep_misses(swept, whole):
    tops = swept.peaks(), whole.peaks()
    tops = [table[table["output"] == "1.x"]["amplitude"].max() for table in tops]
    assert tops[1] > 2.0 * tops[0]
    assert whole.dataset.curve_kind.values.tolist() == [0, 2]
    assert str(whole.dataset.case_message.values[1]).endswith("which closes on itself.")
    assert level_text(whole.dataset, 1).endswith(", isolated")
    assert whole.dataset.attrs["isolated_curves"] == 1
    np.testing.assert_array_equal(whole.dataset.amplitude[0], swept.dataset.amplitude[0][: whole.dataset.sizes["point"]])


def test_it_is_closed_and_apart(whole):
    dataset = whole.dataset
    good = dataset.outcome.values[1] == 1
    frequency, amplitude = dataset.frequency.values[1, good], dataset.amplitude.values[1, good, 0]
    assert frequency[0] == frequency[-1]
    assert frequency[0] < 1.001 * frequency.min()
    assert amplitude[0] == amplitude[-1]
    beside = whole.at([float(frequency.mean())]).amplitude.values[:, :, 0, 0]
    assert np.nanmin(beside[1]) > 2.0 * np.nanmax(beside[0])


@pytest.mark.nightly
def test_both_motions_are_there_in_time(whole):
    """At one frequency, started from the state of either curve, SciPy stays where it started."""
    found = whole.with_stability()
    stable = np.flatnonzero(found.dataset.stability.values[1] == 1)
    point = int(stable[len(stable) // 2])
    omega, high = state(found.dataset, 1, point)
    low = found.at([omega / TURN]).isel(case=0, branch=0, frequency=0)
    after = absorber_after(40, omega, high)
    np.testing.assert_allclose(after, high, atol=1e-3 * np.abs(high).max())
    rest = absorber_after(200, omega, np.zeros(4))
    assert abs(rest[0]) < 2.0 * float(low.amplitude[0])
    assert np.abs(high[:3:2]).max() > 5.0 * float(low.amplitude[0])
    assert found.verify_in_time(1, point, steps_per_period=1000).agrees(1e-3)


def test_the_search_along_the_force_level_finds_it_too(whole, modes):
    response = ss.forced_response(absorber(), BAND, LEVEL, harmonics=5, samples=64)
    assert response.dataset.curve_kind.values.tolist() == [0, 2]
    tops = [each.peaks().query("output == '1.x' and curve == 'isolated'")["amplitude"].max() for each in (whole, response)]
    np.testing.assert_allclose(tops[1], tops[0], rtol=1e-4)
    assert "1 curve apart from the sweep was found" in response.dataset.attrs["isolated_search"]
    again = response.with_isolated(modes)
    assert again.dataset.curve_kind.values.tolist() == [0, 2]


def test_modes_lead_to_a_curve_just_above_the_level_at_which_it_begins(modes):
    """Between two points of the mode beside its minimum, both of which need more force."""
    level = 1.001 * 0.037593
    needs = modes.dataset["peak_force_level"].values[0]
    lowest = needs[1:-1][(needs[1:-1] < needs[:-2]) & (needs[1:-1] < needs[2:])]
    assert np.all(lowest > level)
    swept = ss.forced_response(absorber(), BAND, level, harmonics=5, samples=64, isolated=False)
    assert swept.with_isolated(modes).dataset.curve_kind.values.tolist() == [0, 2]


@pytest.mark.parametrize("varies", [True, False])
def test_nothing_is_added_where_there_is_nothing(varies):
    """Under a constant load there is one motion, and no other is sought."""
    structure = ss.Structure(np.eye(2), np.diag([1.0, 4.0]), ("1.x", "1.y"), C=0.1 * np.eye(2))
    load = {"kn": 1.0, "preload": 1.0} if varies else {"normal_load": 1.0}
    normal = {"1.y": 1.0} if varies else None
    contact = ss.Contact("c", ss.Macroslip(1.0, 0.5, **load), ({"1.x": 1.0},), normal)
    problem = ss.Problem(structure, (contact,), (ss.Force("1.x", 1.0),), ("1.x",))
    modes = ss.nonlinear_modes(problem, 1, harmonics=3, samples=64)
    band = ss.radians_per_second(0.8, 1.8)
    response = ss.forced_response(problem, band, [0.5, 1.0], harmonics=3, samples=64, isolated=True)
    said = " ".join(response.dataset.attrs["isolated_search"])
    assert ("There was no search for detached curves: friction and damping allow only one motion." in said) != varies
    assert (said.count("no motion off the sweep was found") == 2) == varies
    found = response.with_isolated(modes)
    assert found.dataset.attrs["isolated_curves"] == 0
    assert (found.dataset.attrs["isolated_starts"] > 0) == varies
    np.testing.assert_array_equal(found.dataset.amplitude, response.dataset.amplitude)
    unasked = ss.forced_response(problem, band, 1.0, harmonics=1, samples=64)
    assert "isolated_search" not in unasked.dataset.attrs  # where contacts rub a search takes longer than the sweep


def needed(omega, amplitude):
    """The force level that an amplitude of the oscillator needs, with one harmonic: in closed form."""
    joint = K2 + 1j * omega * C2
    stiffness = 1.0 + K2 - omega**2 + 1j * omega * (OWN + C2) + 0.75 * amplitude**2 - joint**2 / (joint - MASS * omega**2)
    return amplitude * abs(stiffness)


def test_a_detached_curve_is_found_from_the_level_on_at_which_it_begins():
    """In closed form this is the least force that the ridge needs beyond its first top; folds of S-curves beside it, at other
    frequencies, lie above it."""
    omegas, sizes = np.linspace(1.2, 1.6, 4000), np.geomspace(0.7, 2.0, 1000)
    begin = min(needed(omegas, size).min() for size in sizes)
    np.testing.assert_allclose(begin, 0.037593, rtol=1e-4)
    searches = []
    for level in (0.99 * begin, 1.0005 * begin, 1.01 * begin):
        curve = ss.forced_response(absorber(), BAND, level, harmonics=1, samples=64, isolated=False)._solved_curve(0, 1)
        searches.append(LevelCurves(curve, Isolated(curve), 8 * len(curve.points)))
        searches[-1].search()
    assert [len(each.isolated.found) for each in searches] == [0, 1, 1]
    assert [len(each.fold) for each in searches] == [5, 5, 5]
    lowest = min(list(searches[0].fold)[:4], key=searches[0].fold.get)
    ridge = min(needed(lowest, size) for size in sizes[sizes > 0.8])
    np.testing.assert_allclose(searches[0].fold[lowest], ridge, rtol=4e-4)


def test_motions_with_few_harmonics_are_solved_with_all():
    """The search takes three harmonics; what it finds has those of the sweep, so that an impact stays one."""
    responses = [ss.forced_response(absorber(), BAND, LEVEL, harmonics=H, samples=128) for H in (3, 9)]
    tops = [each.peaks().query("output == '1.x' and curve == 'isolated'")["amplitude"].max() for each in responses]
    assert responses[1].dataset.sizes["harmonic"] == 10
    higher = responses[1].dataset.response.isel(case=1, harmonic=5)
    assert float(np.abs(higher).max()) > 0.0
    assert tops[1] != tops[0]
    np.testing.assert_allclose(tops[1], tops[0], rtol=0.02)


def test_the_first_line_names_the_highest_detached_curve(whole, tmp_path):
    """In the report, on the console and with --json alike, in the unit of the study, with the stability of that point."""
    tops = whole.peaks().query("output == '1.x'").set_index("curve")["amplitude"].groupby(level=0).max()
    own = [highest_peak(whole.dataset, case) for case in (0, 1)]
    said = (
        f"1.x: {tops['sweep']:.4g} m at {hertz(own[0].frequency)} Hz on the curve begun at {hertz(0.7 / TURN)} Hz, "
        f"{tops['isolated']:.4g} m at {hertz(own[1].frequency)} Hz on a detached curve (stable)."
    )
    assert str(whole).splitlines()[1] == said
    file = whole.save(tmp_path / "whole.nc")
    assert CliRunner().invoke(app, ["peaks", str(file)]).output.splitlines()[1] == said
    found = json.loads(CliRunner().invoke(app, ["peaks", str(file), "--json"]).stdout)
    assert found["results"][0]["further_curves"] == said
    assert f'<p class="headline">{said}</p>' in overview({"": whole.dataset}, Charts([""]))
    in_mm = whole.dataset.assign_attrs(attributes_of(unit_system("mm-t-s")))
    assert further_curves_sentence(in_mm).count(" mm at ") == 2


def test_the_first_line_takes_the_level_with_the_highest_of_them_and_its_verdict(whole, swept):
    """Nothing is said where there are none; several are counted, and a branch is called so."""
    assert further_curves_sentence(swept.dataset) == ""
    half = whole.dataset.isel(case=[0, 1, 1, 0]).copy(deep=True)
    half["force_level"].values[:] = [LEVEL, LEVEL, LEVEL, 2.0 * LEVEL]
    half["curve_kind"].values[3] = 1
    for flag, words in enumerate(("stability not judged", "stable", "unstable", "stability undecided")):
        half["highest_stability"].values[:] = flag
        sentence = further_curves_sentence(half)
        assert sentence.startswith(f"{LEVEL:g} N, 1.x: ")
        assert sentence.endswith(f" on the highest of 2 detached curves ({words}).")
    branches = half.isel(case=[0, 3])
    branches["force_level"].values[:] = LEVEL
    assert further_curves_sentence(branches).endswith("on a branch (stability undecided).")


def test_where_nothing_is_sought_it_is_said_when_asked_for():
    """Unless asked for, a response at listed frequencies or of one motion says nothing; a speed sweep seeks none."""
    for band, how in ((BAND, False), ([0.2, 0.21], None), ([0.2, 0.21], True)):
        response = ss.forced_response(absorber(), band, LEVEL, harmonics=1, samples=64, isolated=how)
        said = response.dataset.attrs.get("isolated_search", "")
        assert said == ("There was no search for detached curves: it needs a frequency band." if how else "")
        assert "curve_kind" not in response.dataset
    excited = replace(absorber(), speed=ss.SpeedDependence(1))
    sweep = ss.speed_sweep(excited, (60.0 * 0.7 / TURN, 60.0 * 2.0 / TURN), force=LEVEL, harmonics=1, samples=64)
    assert sweep.dataset.sizes["case"] == 1


def test_a_study_says_whether_detached_curves_are_sought():
    tables = None, IsolatedTable(), IsolatedTable(search=False)
    assert [FurtherCurves(table, None).search for table in tables] == [None, True, False]


def test_wrong_modes_are_refused(swept):
    with pytest.raises(ss.InputError, match="modes"):
        swept.with_isolated(swept)
    with pytest.raises(ss.InputError, match="problem of the modes"):
        swept.with_isolated(ss.nonlinear_modes(ss.rigs.single_mass(), 1, harmonics=3, samples=64))


def duffing():
    structure = ss.Structure(np.eye(1), np.eye(1), ("1.x",), C=np.array([[0.02]]))
    spring = ss.Contact("spring", ss.CubicSpring(1.0), (ss.between("1.x", "ground"),))
    return ss.Problem(structure, (spring,), (ss.Force("1.x", 1.0),), ("1.x",))


@pytest.fixture(scope="module")
def thirds():
    """Motions of a third of the frequency of the excitation."""
    band, modes = ss.radians_per_second(3.0, 8.0), ss.nonlinear_modes(duffing(), 1, (1e-2, 3.0), harmonics=5, samples=64)
    response = ss.forced_response(duffing(), band, harmonics=5, samples=64, periods=3, measure="max_abs")
    return response.with_isolated(modes).with_stability()


@pytest.mark.slow
def test_a_third_of_the_frequency_of_the_excitation(thirds):
    """Of three motions, each one period of the excitation after the other, one is kept; SciPy stays on it."""
    dataset = thirds.dataset
    assert dataset.curve_kind.values.tolist() == [0, 2]
    stable = np.flatnonzero(dataset.stability.values[1] == 1)
    for point in stable[[len(stable) // 3, len(stable) // 2]]:
        omega, start = state(dataset, 1, int(point))

        def rates(t, y, omega=omega):
            return [y[1], np.cos(omega * t) - 0.02 * y[1] - y[0] - y[0] ** 3]

        times = TURN / omega * np.array([1.0, 60.0])
        after = solve_ivp(rates, (0.0, times[-1]), start, rtol=1e-10, atol=1e-12, t_eval=times).y
        assert np.abs(after[:, 0] - start).max() > 0.5 * np.abs(start).max()
        np.testing.assert_allclose(after[:, 1], start, atol=1e-5 * np.abs(start).max())
    assert dataset.harmonic.values[:4].tolist() == pytest.approx([0.0, 1 / 3, 2 / 3, 1.0])
    third = np.hypot(*dataset.response.values[1, :, 0, 1].T)
    assert np.nanmax(third) > 10.0 * float(dataset.amplitude[1].max())


@pytest.mark.nightly
def test_the_time_check_goes_over_the_whole_expansion(thirds):
    point = int(np.flatnonzero(thirds.dataset.stability.values[1] == 1)[5])
    check = thirds.verify_in_time(1, point, steps_per_period=500)
    assert check.agrees(1e-3)
    assert f"{float(thirds.dataset.frequency[1, point]):.6g} Hz" in check.sentence
    assert "500 steps a period" in check.sentence


STUDY = """units = {{ frequency = "rad/s" }}

[study]
title = "Oscillator with an absorber"
analysis = "forced_response"

[structure]
dofs = ["1.x", "2.x"]
matrices = {{ M = [[1.0, 0.0], [0.0, {M}]], K = [[{k}, -{k2}], [-{k2}, {k2}]], C = [[{c}, -{c2}], [-{c2}, {c2}]] }}

[[contact]]
name = "spring"
law = "cubic_spring"
k3 = 1.0
tangential = ["1.x", "ground"]

[[force]]
direction = "1.x"
amplitude = 1.0

[isolated]
mode = 2
amplitude = [1e-2, 6.0]

[branches]

[stability]

[sweep]
frequency = [0.7, 2.0]
force_levels = [{level}]
harmonics = 5
samples = 64
outputs = ["1.x", "2.x"]
"""


def run(path, text):
    path.mkdir(exist_ok=True)
    (path / "study.toml").write_text(text)
    done = CliRunner().invoke(app, ["run", str(path / "study.toml"), "--out", str(path / "out")])
    kept = list((path / "out").rglob("*.nc"))
    return done, xr.load_dataset(kept[0], engine="h5netcdf") if kept else None


@pytest.mark.slow
def test_a_study_finds_the_isolated_curve(tmp_path, whole):
    text = STUDY.format(M=MASS, k=1.0 + K2, k2=K2, c=OWN + C2, c2=C2, level=LEVEL)
    done, dataset = run(tmp_path / "a", text)
    assert done.exit_code == 0, done.output
    assert "isolated curves: 1 found from 4 starts" in done.output
    assert f"force {LEVEL} N, isolated" in done.output
    np.testing.assert_allclose(dataset.peak_amplitude[1, 0, 0], whole.dataset.peak_amplitude[1, 0, 0], rtol=1e-9)
    report = next((tmp_path / "a" / "out").rglob("report.html")).read_text()
    assert "isolated" in report
    sentence = further_curves_sentence(dataset)
    assert f"on the curve begun at {hertz(0.7 / TURN)} Hz, " in sentence
    assert sentence in done.output
    assert sentence in report


def test_wrong_tables_are_refused(tmp_path):
    text = STUDY.format(M=MASS, k=1.0 + K2, k2=K2, c=OWN + C2, c2=C2, level=LEVEL)
    for k, (old, new, words) in enumerate(
        (
            ("frequency = [0.7, 2.0]", "at = [0.7, 2.0]", "needs a band"),
            ("[1e-2, 6.0]", "[6.0, 1e-2]", "smallest first"),
            ("mode = 2", "mode = 0", "mode"),
            ("mode = 2", "mode = 2\nperiods = 17", "periods"),
        )
    ):
        done, _ = run(tmp_path / str(k), text.replace(old, new))
        assert done.exit_code != 0
        assert words in done.output


def test_the_rest_of_a_sweep_outside_its_band_is_not_called_isolated():
    """Between the folds of a Duffing oscillator: the sweep follows one arm, the peak of the mode lies on the other."""
    structure = ss.Structure(np.eye(1), np.eye(1), ("1.x",), C=0.1 * np.eye(1))
    spring = ss.Contact("spring", ss.CubicSpring(0.5), (ss.between("1.x", "ground"),))
    problem = ss.Problem(structure, (spring,), (ss.Force("1.x", 1.0),), ("1.x",))
    mode = ss.nonlinear_modes(problem, 1, amplitude=(1e-2, 20.0), harmonics=5, samples=64)
    whole = ss.forced_response(problem, ss.hertz(0.1, 0.7), harmonics=5, samples=64)
    peak = float(whole.peaks().frequency[0])
    narrow = ss.forced_response(problem, ss.hertz(peak + 0.02, 0.9 * peak), harmonics=5, samples=64).with_isolated(mode)
    message = str(narrow.dataset.case_message.values[1])
    assert message.startswith(
        "A curve that the sweep does not meet in this band, though it may in a wider one, which leaves the band."
    )
    sentence = further_curves_sentence(narrow.dataset)
    assert "on a curve that the sweep does not meet in this band (" in sentence


def test_the_first_sentence_names_the_height_at_the_end_of_a_curve_that_rises_there():
    """A blade with an absorber on a stop, in a band that ends below its resonance at 30 N: a sweep up ends at 2.1 mm."""
    M, K, C = np.diag([2.0, 0.06]), np.array([[1166713.0, -29713.0], [-29713.0, 29713.0]]), np.array([[2.3, -2.0], [-2.0, 2.0]])
    stop = ss.Contact("stop", ss.Gap(kn=2e6, gap=150e-6), normal={"blade.x": 1.0})
    blade = ss.Structure(M, K, ("blade.x", "absorber.x"), C=C)
    problem = ss.Problem(blade, (stop,), (ss.Force("blade.x", 1.0),), ("blade.x",))
    sentence = further_curves_sentence(ss.forced_response(problem, ss.hertz(90.0, 150.0), 30.0, harmonics=5).dataset)
    assert sentence.startswith("195.3 µm at 107.07 Hz and 2106 µm at its end on the curve begun at 90.00 Hz, ")


@pytest.mark.parametrize(("isolated", "said"), [(None, True), (True, False)])
def test_a_response_whose_contacts_lift_off_says_that_no_detached_curves_were_sought(isolated, said):
    structure = ss.Structure(np.eye(2), np.eye(2), ("a.x", "a.y"), C=0.05 * np.eye(2))
    law = ss.Macroslip(kt=0.5, mu=0.3, kn=1.0, preload=0.1)
    contact = ss.Contact("c", law, (ss.between("a.x", "ground"),), normal={"a.y": 1.0})
    problem = ss.Problem(structure, (contact,), (ss.Force("a.y", 0.1), ss.Force("a.x", 0.1)), ("a.x",))
    response = ss.forced_response(problem, ss.radians_per_second(0.8, 1.6), harmonics=3, samples=64, isolated=isolated)
    lines = " ".join(sentences(response.dataset))
    assert ("Detached curves were not sought although contacts lift off" in lines) == said
