"""A curve that leaves its band through the start and returns: what lies outside is kept, marked and told, and counts for nothing.

A mass on a preloaded contact that lifts off, and so softens: from the start of the band the curve goes down to 0.124 Hz over a
peak of 5.4 m, and comes back. Followed from the other end it arrives at the start without leaving the band, so that both must
give the same answer.
"""

import json
from dataclasses import replace

import numpy as np
import pytest
from typer.testing import CliRunner

import stickslip as ss
from stickslip.analyses.harmonic_choice import _worst_points, sampling_warning
from stickslip.analyses.isolated import other_motion_warning
from stickslip.analyses.mistuning.work import _blades, damper_work
from stickslip.analyses.stress import margins
from stickslip.cli import app
from stickslip.laboratory.identification.response.prediction import ResponsePredictionWork
from stickslip.laboratory.measurement.measured_response import curve_peak
from stickslip.results.quantities import outside_table
from stickslip.results.view import converged_points, higher_end, highest_maximum, highest_peak, in_band
from stickslip.show.explorer.solving import Answer, curve_figure
from stickslip.show.plots.response_curves import response_curves
from stickslip.show.report.answer import OUTSIDE
from stickslip.show.report.markup import Charts
from stickslip.show.report.sections import peaks
from stickslip.show.report.stress import largest_stresses
from stickslip.solve.balance.balance import HarmonicBalance
from stickslip.solve.balance.measure import DISPLACEMENT_AMPLITUDE, Measure, quantity_named
from stickslip.solve.curves.curve import refined, solve_curve
from stickslip.solve.peaks.search import PeakSearch

LOW, HIGH, LEVEL = 1.0, 1.3, 0.05
FINENESS = {"harmonics": 3, "samples": 64}
SWEPT = FINENESS | {"isolated": False}


def softening(coupled=0.0):
    """A mass that a contact with lift-off holds, beside one that it drives by a spring."""
    structure = ss.Structure(
        np.eye(2), [[0.3 + coupled, -coupled], [-coupled, 1.0 + coupled]], ("1.y", "1.x"), damping=ss.ModalDamping(0.005)
    )
    law = ss.Macroslip(kt=0.1, mu=0.3, kn=1.0, preload=0.3)
    contact = ss.Contact("c", law, ({"1.x": 1.0},), {"1.y": 1.0}, balanced=True)
    return ss.Problem(structure, (contact,), (ss.Force("1.y", 1.0),), ("1.y", "1.x"))


@pytest.fixture(scope="module")
def leaves():
    return ss.forced_response(softening(), ss.radians_per_second(LOW, HIGH), LEVEL, **SWEPT)


@pytest.fixture(scope="module")
def stays():
    return ss.forced_response(softening(), ss.radians_per_second(HIGH, LOW), LEVEL, **SWEPT)


@pytest.fixture(scope="module")
def curve():
    balance = HarmonicBalance(softening(), **FINENESS)
    return balance, refined(balance, solve_curve(balance, [LOW, HIGH], LEVEL, exactly=False))


def test_the_curve_is_whole_and_meets_the_end_of_the_band_exactly(curve):
    omegas = np.array([point.point.omega for point in curve[1].points])
    assert omegas.min() < 0.8
    assert np.count_nonzero(omegas == LOW) == 3
    inside = np.array([curve[1].holds(omega) for omega in omegas])
    assert inside.tolist() == ((omegas >= LOW) & (omegas <= HIGH)).tolist()
    assert [point.point.omega for point in curve[1].inside] == omegas[inside].tolist()
    changes = np.flatnonzero(np.diff(inside.astype(int)))
    assert [min(omegas[k], omegas[k + 1]) < LOW == max(omegas[k], omegas[k + 1]) for k in changes] == [True, True]


def test_peaks_outside_are_kept_apart(curve):
    balance, found = curve
    assert found.peaks[0] == ()
    assert found.largest[0] is None
    (peak,) = found.outside[0]
    assert any(peak is point for point in found.points)
    highest = max(np.hypot(*point.evaluation.w[balance.rows, 1:3]) for point in found.points)
    assert np.hypot(*peak.evaluation.w[balance.rows, 1:3]) == pytest.approx(highest, rel=1e-6)


def test_the_answer_is_that_of_the_sweep_that_stays_inside(leaves, stays):
    assert leaves.peaks().empty
    assert stays.peaks().empty
    own, other = (highest_peak(each.dataset, 0) for each in (leaves, stays))
    assert own.amplitude == pytest.approx(other.amplitude, rel=1e-8)
    assert own.frequency == pytest.approx(other.frequency, rel=1e-8)
    assert highest_peak(leaves.dataset, 0).amplitude == pytest.approx(0.8126, rel=1e-3)


def test_it_is_told(leaves, stays):
    words = "The curve leaves the band down to 0.1243 Hz and comes back: what lies outside does not count."
    assert words in str(leaves.dataset["case_message"].values[0])
    assert words in str(leaves)
    assert "leaves the band" not in str(stays.dataset["case_message"].values[0])


def test_errors_stability_and_loop_are_those_of_the_band(leaves, stays):
    for name in ("truncation_error", "sampling_error", "work_error", "highest_stability", "loop_frequency", "loop_force"):
        np.testing.assert_allclose(leaves.dataset[name].values, stays.dataset[name].values, rtol=1e-5, atol=1e-9)


def test_points_in_the_band(leaves):
    dataset = leaves.dataset
    every = converged_points(dataset, 0)
    inside = in_band(dataset, 0, every)
    omegas = 2.0 * np.pi * dataset["frequency"].values[0, every]
    assert inside.tolist() == every[omegas > LOW - 1e-9].tolist()
    assert 0 < inside.size < every.size


@pytest.fixture(scope="module")
def with_peaks():
    """Two curves with a peak inside, the first of them also with one outside."""
    ends = ((1.0, 1.6), (1.6, 1.0))
    return [ss.forced_response(softening(0.3), ss.radians_per_second(*each), LEVEL, **SWEPT) for each in ends]


def test_readers_of_a_maximum_read_inside(with_peaks):
    assert "The curve leaves the band" in str(with_peaks[0].dataset["case_message"].values[0])
    first, second = (each.peaks() for each in with_peaks)
    np.testing.assert_allclose(first[["frequency", "amplitude"]], second[["frequency", "amplitude"]], rtol=1e-6)
    velocities = [each.peaks("velocity") for each in with_peaks]
    assert velocities[0]["frequency"].min() > LOW / (2.0 * np.pi)
    highest = [each.groupby("output")["amplitude"].max() for each in velocities]
    np.testing.assert_allclose(*highest, rtol=1e-5)
    velocity = Measure(quantity_named("velocity")[0], "amplitude")
    own, other = (highest_maximum(each.dataset, 0, 0, velocity) for each in with_peaks)
    np.testing.assert_allclose(own, other, rtol=1e-2)
    ends = [higher_end(each.dataset, 0, 0) for each in with_peaks]
    assert [end is None for end in ends] in ([True, True], [False, False])


def test_stress_and_margin_are_read_inside(with_peaks):
    dataset = with_peaks[0].dataset
    sizes = dataset["amplitude"].values[..., :1]
    dims = ("case", "point", "place")
    stressed = dataset.assign(
        stress_von_mises=(dims, sizes),
        stress_alternating=(dims, sizes),
        stress_amplitude=((*dims, "component"), sizes[..., None]),
        stress_mean=((*dims, "component"), sizes[..., None]),
        fatigue_mean=(dims, 0.0 * sizes),
        fatigue_limit=(dims, 0.0 * sizes + 10.0),
    ).assign_coords(place=["root"], component=["xx"])
    every = converged_points(dataset, 0)
    inside = in_band(dataset, 0, every)
    most = dataset["amplitude"].values[0, inside, 0].max()
    assert dataset["amplitude"].values[0, every, 0].max() > most
    (stress,) = largest_stresses(stressed)
    (margin,) = margins(stressed)
    assert stress.von_mises == margin.alternating == most
    assert stress.frequency == margin.frequency


@pytest.fixture(scope="module")
def coupled():
    """The curve with a peak inside as it is solved, before it becomes a dataset."""
    balance = HarmonicBalance(softening(0.3), **FINENESS)
    return balance, refined(balance, solve_curve(balance, [1.0, 1.6], LEVEL, exactly=False))


def highest_of(balance, points, output=0):
    return max(float(np.hypot(*point.evaluation.w[balance.rows + output, 1:3])) for point in points)


def test_samples_are_judged_at_the_highest_motion_inside(coupled, monkeypatch):
    balance, found = coupled
    asked = []
    monkeypatch.setattr(ss.Macroslip, "passage", lambda law, velocity: asked.append(velocity) or np.inf)
    sampling_warning(balance, found)

    def velocity(points, output):
        highest = max(points, key=lambda point: highest_of(balance, [point], output))
        return highest.point.omega * np.hypot(*highest.evaluation.w[0, 1:3])

    assert asked == [velocity(found.inside, 0), velocity(found.inside, 1)]
    assert asked[0] != velocity(found.points, 0)


def test_harmonics_are_chosen_at_the_highest_motions_inside():
    ends = LOW / (2.0 * np.pi), HIGH / (2.0 * np.pi)
    omegas = [evaluation.point.omega for _, evaluation in _worst_points(softening(), ends, LEVEL, 3, 64, 0.1)]
    assert omegas
    assert min(omegas) >= LOW


def test_another_motion_is_compared_with_the_curve_inside(curve, monkeypatch):
    """One of twice the height inside is told of, though the curve is higher outside."""
    balance, found = curve
    own, beyond = (highest_of(balance, points) for points in (found.inside, found.points))
    higher = min(
        (point for point in found.points if highest_of(balance, [point]) > 2.0 * own),
        key=lambda point: highest_of(balance, [point]),
    )
    assert highest_of(balance, [higher]) < beyond
    monkeypatch.setattr("stickslip.analyses.isolated._entering", lambda *given: iter([(LOW, [higher])]))
    assert other_motion_warning(balance, found, DISPLACEMENT_AMPLITUDE).startswith("Another motion enters the band")


def test_a_motion_is_large_by_what_moves_inside():
    """Beside 20 m the 0.8 m inside are little, and the 5.4 m outside are not."""
    problem = softening()
    placed = replace(problem, structure=replace(problem.structure, nodes={"1": (0.0, 0.0, 0.0), "2": (20.0, 0.0, 0.0)}))
    found = ss.forced_response(placed, ss.radians_per_second(LOW, HIGH), LEVEL, **SWEPT).dataset
    assert "times the size of the structure" not in str(found["case_message"].values[0])
    near = replace(placed, structure=replace(placed.structure, nodes={"1": (0.0, 0.0, 0.0), "2": (5.0, 0.0, 0.0)}))
    found = ss.forced_response(near, ss.radians_per_second(LOW, HIGH), LEVEL, **SWEPT).dataset
    assert "0.18 times the size of the structure" in str(found["case_message"].values[0])


def test_a_speed_sweep_reads_inside(stays):
    """Its envelope is that of the response without the speed, and its peaks are none."""
    excited = replace(softening(), speed=ss.SpeedDependence(1))
    ends = [60.0 * end / (2.0 * np.pi) for end in (LOW, HIGH)]
    sweep = ss.speed_sweep(excited, ends, force=LEVEL, **FINENESS)
    assert not np.isfinite(sweep.dataset["peak_speed"].values).any()
    envelope, speeds = sweep.dataset["envelope"].values[0, :, 0], sweep.dataset["envelope_speed"].values
    assert speeds.min() >= ends[0]
    assert envelope.max() == pytest.approx(highest_peak(stays.dataset, 0).amplitude, rel=1e-6)


def test_blades_and_the_work_of_dampers_are_read_inside(coupled):
    balance, found = coupled
    search = PeakSearch(balance, list(found.points), 1e-4, band=found.band)
    blades = _blades(balance, found.points, search, DISPLACEMENT_AMPLITUDE)
    assert blades["peak_frequency"].min() >= LOW / (2.0 * np.pi)
    np.testing.assert_allclose(blades["peak"], [highest_of(balance, found.inside, k) for k in (0, 1)], rtol=1e-6)
    largest = max(found.inside, key=lambda point: max(highest_of(balance, [point], k) for k in (0, 1)))
    np.testing.assert_allclose(blades["damper_work"], damper_work(balance, largest), rtol=1e-3)


class OfOneProblem(ResponsePredictionWork):
    """A prediction over the band of a problem alone."""

    ends, measure, output, held = (LOW / (2.0 * np.pi), 1.6 / (2.0 * np.pi)), DISPLACEMENT_AMPLITUDE, 1, False

    def __init__(self):
        pass

    def start_state(self, balance, force, number):
        return None, np.zeros(0)


def test_no_width_at_half_power_is_read_outside(coupled, monkeypatch):
    """Of a curve that leaves its band on the flank of the peak."""
    balance, found = coupled
    peak = max(found.peaks[1], key=lambda point: highest_of(balance, [point], 1))
    leaving = replace(found, band=(found.band[0], 1.001 * peak.point.omega))
    of = "stickslip.laboratory.identification.response.prediction"
    monkeypatch.setattr(f"{of}.solve_curve", lambda *given, **named: leaving)
    monkeypatch.setattr(f"{of}.refined", lambda balance, curve: curve)
    curve, (frequency, size), top = OfOneProblem()._curve(balance, LEVEL, 1, lambda share: None)
    assert np.isnan(size).tolist() == [not curve.holds(point.point.omega) for point in curve.points]
    assert np.isnan(curve_peak(frequency, size, top)[2])
    beyond = OfOneProblem()._sizes(balance, curve.points)[1]
    assert curve_peak(frequency, beyond, top)[2] == pytest.approx(0.0033, rel=0.02)


def test_peaks_outside_stand_in_a_table_of_their_own(leaves, stays, with_peaks):
    (row,) = outside_table(leaves.dataset).to_dict("records")
    every = converged_points(leaves.dataset, 0)
    assert row["amplitude [m]"] == leaves.dataset["amplitude"].values[0, every, 0].max()
    assert row["frequency [Hz]"] < 0.125
    assert outside_table(stays.dataset).empty
    assert set(outside_table(with_peaks[0].dataset)["frequency [Hz]"] < LOW / (2.0 * np.pi)) == {True}
    velocity = ss.forced_response(softening(), ss.radians_per_second(LOW, HIGH), LEVEL, quantity="mobility", **SWEPT).dataset
    (other,) = outside_table(velocity).to_dict("records")
    mobility = 2.0 * np.pi * row["frequency [Hz]"] * row["amplitude [m]"] / LEVEL
    assert other["amplitude [m/(s N)]"] == pytest.approx(mobility, rel=1e-3)
    said = "outside the band, where it does not count: 0.12437 Hz, amplitude 5.39 m"
    assert (said in str(leaves), "outside the band" in str(stays)) == (True, False)


def test_the_report_and_the_commands_show_them(leaves, stays, tmp_path):
    files = {name: each.save(tmp_path / f"{name}.nc") for name, each in (("leaves", leaves), ("stays", stays))}
    run = CliRunner().invoke
    printed = {name: run(app, ["peaks", str(file)]).output for name, file in files.items()}
    assert [OUTSIDE in printed[name] for name in files] == [True, False]
    assert "No peak inside the band." in printed["leaves"]
    found = {name: json.loads(run(app, ["peaks", str(file), "--json"]).stdout)["results"][0] for name, file in files.items()}
    assert [len(found[name]["peaks_outside_the_band"]) for name in files] == [1, 0]
    assert found["leaves"]["units"]["amplitude"] == "m"
    assert run(app, ["export", str(files["leaves"]), "--out", str(tmp_path / "x.csv")]).exit_code == 0
    (_, line) = (tmp_path / "x_peaks_outside_the_band.csv").read_text().splitlines()
    assert line.startswith("0.05,1.y,0.12437")
    pages = [peaks({"": each.dataset}, Charts([""])) for each in (leaves, stays)]
    assert [OUTSIDE in page for page in pages] == [True, False]
    assert 'data-value="5.39' in pages[0].partition(OUTSIDE)[2]


def test_the_part_outside_is_grey(leaves, stays):
    edge = LOW / (2.0 * np.pi)
    for each, goes in ((leaves, True), (stays, False)):
        lines = [layer for layer in response_curves(each.dataset).panels[0].layers if layer.label == "0.05 N"]
        grey = [line for line in lines if line.style.colour == "grey"]
        coloured = [line for line in lines if line.style.colour != "grey"]
        assert len(grey) == goes
        drawn = [np.asarray(line.x)[np.isfinite(line.y)] for line in (*grey, *coloured)]
        assert min(x.min() for x in drawn[goes:]) == pytest.approx(edge, rel=1e-12)
        assert max((x.max() for x in drawn[:goes]), default=edge) == pytest.approx(edge, rel=1e-12)
        figure = curve_figure(Answer(each, (), 0.0), None, "1.y", True, dark=False)
        traces = [trace for trace in figure["data"] if trace.get("name") == "this study"]
        assert len(traces) == 1 + goes
