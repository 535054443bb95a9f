"""The quantity that peaks are of, from the study file to tables, report and export."""

import numpy as np
import pandas as pd
import pytest
from report.pages import Page
from typer.testing import CliRunner

import stickslip as ss
from stickslip.cli import app

STUDY = """
[study]
analysis = "{analysis}"

[structure]
rig = "single_mass"
parameters = {{ damping = 0.05 }}

[sweep]
frequency = [0.05, 0.6]
{levels}
harmonics = 3
samples = 64
quantity = "{quantity}"
measure = "{measure}"
"""
LEVEL = "force_levels = [0.75]"


BOUNDS = """
[study]
analysis = "response_bounds"

[structure]
rig = "three_mass_wedge"

[sweep]
frequency = [200.0, 235.0]
force_levels = [0.5]
harmonics = 3
samples = 64
quantity = "mobility"
measure = "rms"

[response_bounds]
objective = "peak"
cloud = 3
starts = 1
"""


def run(folder, analysis="forced_response", quantity="inertance", measure="amplitude", levels=LEVEL, more=""):
    study = folder / "study.toml"
    study.write_text(STUDY.format(analysis=analysis, quantity=quantity, measure=measure, levels=levels) + more)
    result = CliRunner().invoke(app, ["run", str(study), "--out", str(folder / "out"), "--workers", "1"])
    assert result.exit_code == 0, result.output
    return ss.open_results(folder / "out" / "results.nc"), result.output


@pytest.fixture(scope="module")
def inertance(tmp_path_factory):
    folder = tmp_path_factory.mktemp("inertance")
    return (*run(folder), folder)


def test_a_study_reports_the_peaks_of_its_quantity(inertance):
    dataset, output, folder = inertance
    problem = ss.rigs.single_mass(damping=0.05)
    expected = ss.forced_response(problem, ss.hertz(0.05, 0.6), 0.75, 3, 64, quantity="inertance").peaks().iloc[0]
    assert float(dataset.peak_frequency[0, 0, 0]) == pytest.approx(expected.frequency, rel=1e-12)
    assert float(dataset.peak_amplitude[0, 0, 0]) == pytest.approx(expected.amplitude, rel=1e-12)
    assert (dataset.attrs["quantity"], dataset.attrs["measure"]) == ("inertance", "amplitude")
    assert f"{expected.frequency:.5g} Hz" in output
    assert f"amplitude {expected.amplitude:8.4g} m/(s² N)" in output
    page = (folder / "out" / "report.html").read_text()
    assert "Peaks: local maxima of the amplitude of the first harmonic of the acceleration along the curve" in page
    assert f"Amplitude of the acceleration of {dataset['output'].values[0]} in" in page
    (curves,) = Page(page).data()["places"]["chart-curves"]
    assert next(choice["options"][0] for choice in curves["choices"] if choice["name"] == "Show") == "acceleration"
    assert f'data-value="{expected.amplitude}"' in page


def test_its_tables_are_exported_as_that_quantity(inertance):
    dataset, _, folder = inertance
    result = CliRunner().invoke(app, ["export", str(folder / "out"), "--out", str(folder / "t.csv")])
    assert result.exit_code == 0, result.output
    assert "own peaks" not in result.output
    peaks, curves = pd.read_csv(folder / "t_peaks.csv"), pd.read_csv(folder / "t.csv")
    assert peaks["amplitude [m/(s2 N)]"][0] == float(dataset.peak_amplitude[0, 0, 0])
    assert curves["amplitude [m/(s2 N)]"].max() == pytest.approx(peaks["amplitude [m/(s2 N)]"][0], rel=1e-12)


def test_an_unknown_quantity_is_refused(tmp_path):
    (tmp_path / "s.toml").write_text(
        STUDY.format(analysis="forced_response", quantity="speed", measure="amplitude", levels=LEVEL)
    )
    result = CliRunner().invoke(app, ["check", str(tmp_path / "s.toml")])
    assert result.exit_code == 2
    assert "quantity" in result.output
    assert "speed" in result.output


@pytest.mark.nightly
@pytest.mark.usefixtures("unsaved_figures")
def test_samples_and_bounds_take_the_quantity_of_the_sweep(tmp_path):
    samples, output = run(tmp_path, "response_samples", "velocity", "rms", more="[response_samples]\ncount = 3\n")
    assert samples.peak_amplitude.attrs["units"] == "m/s"
    assert "root mean square of the velocity" in output
    (tmp_path / "b").mkdir()
    (tmp_path / "b" / "study.toml").write_text(BOUNDS)
    command = ["run", str(tmp_path / "b" / "study.toml"), "--out", str(tmp_path / "b" / "out"), "--workers", "1"]
    result = CliRunner().invoke(app, command)
    assert result.exit_code == 0, result.output
    bounds = ss.open_results(tmp_path / "b" / "out" / "results.nc")
    assert bounds.bounds_amplitude.attrs["units"] == "m/s per unit level"
    low, high = bounds.bounds_amplitude.values[0, :, 0]
    assert low <= float(np.nanmin(bounds.bounds_sampled_amplitude))
    assert high >= float(np.nanmax(bounds.bounds_sampled_amplitude))
    assert low < float(bounds.peak_amplitude[0, 0, 0]) < high
