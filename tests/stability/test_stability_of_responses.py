"""Stability in a result: flags, changes, peaks, figures and sentences."""

import numpy as np
import pytest
import xarray as xr
from typer.testing import CliRunner

import stickslip as ss
from stickslip import rigs
from stickslip.cli import app
from stickslip.plots.response_curves import response_curves
from stickslip.report.responses import sentences, tables


@pytest.fixture(scope="module")
def duffing():
    """q̈ + 0.1 q̇ + q + q³/2 = cos ωt, with two folds."""
    structure = ss.Structure(np.eye(1), np.eye(1), ("1.x",), C=0.1 * np.eye(1))
    spring = ss.Contact("spring", ss.CubicSpring(0.5), (ss.between("1.x", "ground"),))
    problem = ss.Problem(structure, (spring,), (ss.Force("1.x", 1.0),), ("1.x",), "Duffing")
    return ss.forced_response(problem, ss.Band(0.1, 0.5), harmonics=7).with_stability()


def test_stability_changes_at_the_folds_of_a_duffing_oscillator(duffing):
    dataset = duffing.dataset
    frequency = dataset.frequency.values[0]
    turns = frequency[np.flatnonzero(np.diff(np.sign(np.diff(frequency)))) + 1]
    found = dataset.stability_change_frequency.values[0]
    assert found == pytest.approx(turns, rel=2e-3)
    assert dataset.stability_change.values[0].tolist() == [1, 1]
    assert dataset.stability_change.attrs["flag_meanings"].split()[1] == "fold"


def test_the_size_of_the_multiplier_says_what_the_flag_says(duffing):
    dataset = duffing.dataset
    size = np.hypot(*dataset.multiplier.values[0].T)
    assert np.array_equal(dataset.stability.values[0] == 2, (size > 1.0) & (dataset.stability.values[0] != 3))
    assert {1, 2} <= set(dataset.stability.values[0].tolist())


def test_peaks_say_whether_they_are_stable(duffing):
    assert duffing.peaks()["stability"].iloc[0] == "stable"
    assert tables(duffing.dataset)["peaks"]["stability"].iloc[0] == "stable"


def test_unstable_parts_are_dashed_and_belong_to_the_curve(duffing):
    lines = [
        layer for layer in response_curves(duffing.dataset).panels[0].layers if layer.label == "1 N" and np.size(layer.x) > 1
    ]
    solid, dashed = lines
    assert (solid.style.dash, dashed.style.dash) == ("solid", "dash")
    drawn = np.isfinite(solid.y) | np.isfinite(dashed.y)
    assert drawn.all()
    assert np.count_nonzero(np.isfinite(solid.y) & np.isfinite(dashed.y)) == 2
    assert np.array_equal(np.isfinite(dashed.y)[1:-1], _grown(duffing.dataset.stability.values[0] == 2)[1:-1])


def _grown(flags):
    """Flags with their neighbours."""
    return flags | np.append(flags[1:], False) | np.append(False, flags[:-1])


def test_sentences_name_the_folds_and_the_sliders_that_never_slip(duffing):
    text = "\n".join(sentences(duffing.dataset))
    assert "unstable; fold at" in text
    response = ss.forced_response(rigs.single_mass(), [0.1], harmonics=3).with_stability()
    assert response.dataset.stuck_sliders.values.tolist() == [[1]]
    assert "never slip" in "\n".join(sentences(response.dataset))


def test_results_with_stability_are_kept_in_files(duffing, tmp_path):
    read = xr.load_dataset(duffing.save(tmp_path / "duffing.nc"), engine="h5netcdf")
    assert np.array_equal(read.stability.values, duffing.dataset.stability.values)


def test_mean_springs_are_refused():
    problem = rigs.lumped_blisk("R", sectors=4, engine_order=1)
    response = ss.forced_response(problem, [float(problem.frequencies(stuck=True)[0])], harmonics=1, samples=24)
    with pytest.raises(ss.InputError, match="mean springs act on harmonic 0 alone"):
        response.with_stability()


def test_modes_that_follow_at_once_change_the_largest_multiplier_by_what_is_said():
    """A chain of 20 masses at its first resonance: the cut at eight times the third harmonic against all modes."""
    response = ss.forced_response(rigs.chain(), [0.012, 0.0125], harmonics=3, samples=64)
    few, whole = response.with_stability().dataset, response.with_stability(float("inf")).dataset
    assert few.attrs["stability_dropped_modes"] > 0 == whole.attrs["stability_dropped_modes"]
    sizes = [np.hypot(*np.moveaxis(dataset.multiplier.values, -1, 0)) for dataset in (few, whole)]
    allowed = few.attrs["stability_mode_error"] + few.multiplier_error.values + whole.multiplier_error.values
    assert np.all(np.abs(sizes[0] - sizes[1]) <= 1.1 * allowed + 1e-9)
    with pytest.raises(ss.InputError, match="highest"):
        response.with_stability(-1.0)


def test_a_study_asks_for_stability_by_a_table(tmp_path):
    text = """[study]
title = "One mass"
analysis = "forced_response"
[structure]
rig = "single_mass"
[stability]
[sweep]
frequency = [0.15, 0.2]
force_levels = [0.5]
harmonics = 3
"""
    (tmp_path / "mass.toml").write_text(text)
    done = CliRunner().invoke(app, ["run", str(tmp_path / "mass.toml"), "--out", str(tmp_path / "out")])
    assert done.exit_code == 0, done.output
    assert "points stable" in done.output
    (kept,) = (tmp_path / "out").rglob("*.nc")
    assert set(np.unique(xr.load_dataset(kept, engine="h5netcdf").stability.values)) <= {0, 1}
