"""Bounds and samples from study files by the command line: results, report, figures, faults."""

import numpy as np
import pandas as pd
import pytest

from stickslip.analyses.forced_response import forced_response
from stickslip.analyses.variability.bounds import attached, detached, has_bounds, response_bounds
from stickslip.analyses.variability.samples import percentiles
from stickslip.cli import main
from stickslip.model.rigs import three_mass_wedge
from stickslip.results.files import open_results, save
from stickslip.solve.starts.extremes import AtFrequency
from stickslip.solve.starts.states import UnsolvedError
from stickslip.study import read
from stickslip.support.checks import Faults
from stickslip.support.outcome import Outcome


def run(arguments):
    with pytest.raises(SystemExit) as ended:
        main([str(argument) for argument in arguments])
    return ended.value.code


@pytest.mark.nightly
def test_bounds_come_with_results_report_and_figures(tmp_path, monkeypatch):
    study, out = tmp_path / "study.toml", tmp_path / "out"
    assert run(["new", "response_bounds", study]) == 0
    text = (
        study.read_text().replace("points = 25", "points = 3").replace("[0.5, 1.0]", "[1.0]").replace("cloud = 60", "cloud = 8")
    )
    study.write_text(text.replace("frequency = [200.0, 235.0]", "frequency = [215.0, 222.0]"))
    assert run(["run", study, "--out", out, "--workers", 1, "--figures"]) == 0
    dataset = open_results(out / "results.nc")
    low, high = detached(dataset)["amplitude"].values[0]
    expected = response_bounds(three_mass_wedge(), [222.0], cloud=8).dataset.amplitude.values[0, :, 0]
    np.testing.assert_allclose([low[-1], high[-1]], expected, rtol=1e-4)
    page = (out / "report.html").read_text()
    assert '<section id="bounds"' in page
    assert 'href="#bounds"' in page
    assert (out / "figures" / "bounds.svg").exists()
    assert run(["export", out, "--out", tmp_path / "t.csv"]) == 0
    table = pd.read_csv(tmp_path / "t_bounds.csv")
    np.testing.assert_allclose(table["frequency [Hz]"], [215.0, 218.5, 222.0])
    np.testing.assert_allclose(table[["lower amplitude [m]", "upper amplitude [m]"]].values.T, [low, high], rtol=1e-12)
    monkeypatch.setattr("stickslip.show.plots.paper.write_figure", lambda figure, path, suffix: None)
    assert run(["report", out]) == 0


@pytest.mark.nightly
def test_bounds_of_contacts_without_a_normal_direction_are_drawn_but_for_the_ratio_of_forces(tmp_path):
    study, out = tmp_path / "study.toml", tmp_path / "out"
    sweep = "[sweep]\nfrequency = [0.15, 0.25]\nforce_levels = [0.3]\nharmonics = 3\nsamples = 64\n"
    bounds = "[response_bounds]\npoints = 3\ncloud = 2\nstarts = 1\n"
    study.write_text('[study]\nanalysis = "response_bounds"\n[structure]\nrig = "single_mass"\n' + sweep + bounds)
    assert run(["run", study, "--out", out, "--workers", 1, "--figures"]) == 0
    drawn = {path.stem for path in (out / "figures").iterdir()}
    assert {"bounds", "bounds_contact_forces", "bounds_loops"} <= drawn
    assert "bounds_force_ratios" not in drawn


@pytest.mark.slow
@pytest.mark.usefixtures("unsaved_figures")
def test_a_study_whose_start_states_have_no_solution_fails(tmp_path, monkeypatch, capsys):
    """Exit code 3, a sentence on the error stream and in the report, and no numbers."""

    def sample(self, variables):
        if np.any(variables != 0.0):
            raise UnsolvedError(Outcome.BODY_HELD_BY_NOTHING)
        return self.point(variables)

    monkeypatch.setattr(AtFrequency, "sample", sample)
    study, out = tmp_path / "study.toml", tmp_path / "out"
    run(["new", "response_bounds", study])
    text = (
        study.read_text().replace("points = 25", "points = 2").replace("[0.5, 1.0]", "[1.0]").replace("cloud = 60", "cloud = 4")
    )
    study.write_text(text.replace('rule = "slider_offset"', 'rule = ["traction_ratio", "virgin"]'))
    capsys.readouterr()
    assert run(["run", study, "--out", out, "--workers", 1]) == 3
    printed = capsys.readouterr()
    assert "force × 1      none found" in printed.out
    assert "no bounds at 2 of 2 frequencies. Most start states have no solution" in printed.err
    assert "4 of 5 sampled start states (80 %) have no solution" in printed.err
    page = (out / "report.html").read_text()
    assert "4 of 5 sampled start states (80 %) have no solution" in page
    assert "Every point converged" not in page
    dataset = open_results(out / "results.nc")
    np.testing.assert_allclose(dataset["bounds_unsolved_share"], 0.8)
    assert np.all(np.isnan(dataset["bounds_amplitude"]))


@pytest.mark.slow
def test_samples_come_as_cases_with_percentiles(tmp_path):
    study, out = tmp_path / "study.toml", tmp_path / "out"
    assert run(["new", "response_samples", study]) == 0
    text = (
        study.read_text().replace("count = 20", "count = 3").replace("[0.5, 1.0]", "[1.0]").replace("points = 29", "points = 2")
    )
    study.write_text(text.replace("# law", "law").replace("# parameters", "parameters"))
    assert run(["run", study, "--out", out, "--workers", 1, "--figures"]) == 0
    dataset = open_results(out / "results.nc")
    assert dataset.sizes["case"] == 3
    assert dataset.start_variable.shape == (3, 2)
    assert not has_bounds(dataset)
    page = (out / "report.html").read_text()
    assert '<section id="bounds"' not in page
    assert '<section id="percentiles"' in page
    assert (out / "figures" / "percentiles.svg").exists()
    assert run(["export", out, "--out", tmp_path / "t.csv"]) == 0
    table = pd.read_csv(tmp_path / "t_percentiles.csv")
    np.testing.assert_allclose(table["50 % [m]"], percentiles(dataset).sel(percent=50.0).values[0], rtol=1e-12)
    assert table["solved"].tolist() == [3, 3]
    assert (out / "figures" / "samples.svg").exists()
    amplitude = dataset.amplitude.values[:, :2, 0]
    np.testing.assert_allclose(percentiles(dataset).sel(percent=50.0).values[0], np.median(amplitude, axis=0))
    assert dataset.frequency.values[0, :2].tolist() == [200.0, 235.0]


@pytest.mark.parametrize(
    ("change", "message"),
    [
        (('# law = "beta"', 'law = "bet"'), "law must be a continuous distribution"),
        (("# parameters", "parameters"), "parameters must go with a law"),
        (('"latin"  ', '"corners"\nlaw = "uniform"  '), "method must be latin or random with a law, but is 'corners'"),
        (("count = 20", "count = 100000000000000"), "count must be at most 100000, but is 100000000000000"),
        (("seed = 0", "seed = 9223372036854775808"), "seed must be at most 9223372036854775807, but is 9223372036854775808"),
        (("frequency = [200.0, 235.0]", "at = [222.0]"), "points needs a band"),
    ],
)
def test_faults_of_samples_are_said(tmp_path, change, message):
    study = tmp_path / "study.toml"
    run(["new", "response_samples", study])
    study.write_text(study.read_text().replace(*change))
    with pytest.raises(Faults, match=message):
        read(study)


@pytest.mark.slow
def test_attached_bounds_survive_the_file(tmp_path):
    response, bounds = forced_response(three_mass_wedge(), [222.0]).dataset, response_bounds(three_mass_wedge(), [222.0]).dataset
    together = attached(response, bounds)
    again = detached(open_results(save(together, tmp_path / "results.nc")))
    for name in ("amplitude", "contact_force", "start_value", "sampled_amplitude"):
        np.testing.assert_array_equal(again[name].values, bounds[name].values)
        assert again[name].dims == bounds[name].dims
    assert again.attrs["objective"] == "amplitude"


@pytest.mark.parametrize(
    ("change", "message"),
    [
        (("[response_bounds]", "[response_samples]"), "needs analysis"),
        (('objective = "amplitude"', 'objective = "energy"'), "objective must be"),
        (("points = 25", "points = 1"), "points must be"),
        (("cloud = 60", "cloud = 1000000000000000"), "cloud must be at most 100000"),
        (('rule = "slider_offset"', 'rulle = "slider_offset"'), "rulle"),
    ],
)
def test_faults_are_said(tmp_path, change, message):
    study = tmp_path / "study.toml"
    run(["new", "response_bounds", study])
    study.write_text(study.read_text().replace(*change))
    with pytest.raises(Faults, match=message):
        read(study)
