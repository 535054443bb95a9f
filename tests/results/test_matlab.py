"""Results as .mat files: read back with SciPy, every number equal, complex parts together."""

import numpy as np
import pytest
from scipy import io
from typer.testing import CliRunner

import stickslip as ss
from stickslip.cli import app
from stickslip.results.files import LARGEST, save, save_mat
from stickslip.support.checks import InputError


def test_every_variable_comes_back(dataset, tmp_path):
    found = io.loadmat(ss.save_mat(dataset, tmp_path / "r.mat"), simplify_cells=True)
    for name, variable in dataset.variables.items():
        if name == "part":
            continue
        expected = variable.values
        if "part" in variable.dims:
            expected = variable.isel(part=0).values + 1j * variable.isel(part=1).values
        np.testing.assert_array_equal(np.squeeze(found[name]), np.squeeze(expected))
    assert found["units"]["contact_force"] == "N"
    assert found["axes"]["response"] == "case, point, output, harmonic"
    assert found["about"]["title"] == dataset.attrs["title"]


def test_no_contacts_and_no_peaks(any_dataset, tmp_path):
    found = io.loadmat(save_mat(any_dataset, tmp_path / "r.mat"))
    assert found["contact_force"].shape[2] == any_dataset.sizes["contact"]


def test_as_velocity_per_force(dataset, tmp_path):
    found = io.loadmat(save_mat(dataset, tmp_path / "r.mat", "velocity", per_force=True), simplify_cells=True)
    expected = ss.as_quantity(dataset, "velocity", per_force=True)
    np.testing.assert_array_equal(found["amplitude"], expected["amplitude"].squeeze().values)
    assert found["units"]["amplitude"] == expected["amplitude"].attrs["units"]


def test_too_large_for_the_format(dataset, tmp_path, monkeypatch):
    monkeypatch.setattr("stickslip.results.files.LARGEST", 100)
    assert LARGEST == 2**31 - 1
    with pytest.raises(InputError, match="must have less than 2 GiB"):
        save_mat(dataset, tmp_path / "r.mat")
    assert list(tmp_path.iterdir()) == []


@pytest.mark.slow
def test_several_results_at_the_command_line(dataset, tmp_path):
    for name in ("2.6kg", "4.6kg"):
        save(dataset, tmp_path / "demo" / name / "results.nc")
    result = CliRunner().invoke(app, ["export", str(tmp_path / "demo"), "--out", str(tmp_path / "all.mat")])
    assert result.exit_code == 0, result.output
    found = io.loadmat(tmp_path / "all.mat", simplify_cells=True)
    np.testing.assert_array_equal(found["r2_6kg"]["frequency"], dataset["frequency"].values)
    assert {"r2_6kg", "r4_6kg"} <= set(found)
    again = CliRunner().invoke(app, ["export", str(tmp_path / "demo"), "--out", str(tmp_path / "all.mat")])
    assert again.exit_code == 2
    assert "Name another, or add --overwrite." in again.output
