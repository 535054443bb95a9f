"""`--json` of `info`, `check` and `peaks`, and runs of several studies."""

import json

import numpy as np
import pytest
from typer.testing import CliRunner

from stickslip.cli import app

ONE_MASS = """
units = "mm-t-s"
[study]
title = "One mode of a blade"
analysis = "forced_response"
[structure]
matrices = { M = [[1e-4]], K = [[250.0]], C = [[1.6e-3]] }
dofs = ["blade.x"]
[[contact]]
law = "macroslip"
between = ["blade.x", "ground"]
kt = 200.0
mu = 0.4
normal_load = 50.0
[[force]]
direction = "blade.x"
amplitude = 1.0
[sweep]
frequency = [200.0, 400.0]
force_levels = [5.0]
harmonics = 3
samples = 64
outputs = ["blade.x"]
"""


def stickslip_command(*arguments):
    return CliRunner().invoke(app, [str(argument) for argument in arguments])


def object_of(result, code=0):
    assert result.exit_code == code, result.output
    return json.loads(result.stdout)


@pytest.fixture
def study(tmp_path):
    path = tmp_path / "one.toml"
    path.write_text(ONE_MASS)
    return path


def test_check_gives_frequencies_and_the_units_of_the_study(study):
    found = object_of(stickslip_command("check", study, "--json"))
    assert (found["valid"], found["errors"], found["analysis"]) == (True, [], "forced_response")
    free, stuck = (np.sqrt(k / 1e-4) / (2.0 * np.pi) for k in (250.0, 450.0))
    assert found["frequencies"]["no_contacts"] == pytest.approx([free])
    assert found["frequencies"]["contacts_stuck"] == pytest.approx([stuck])
    assert found["units"] == {"frequencies": "Hz", "normal_loads": "N", "estimated_seconds": "s"}


def test_check_lists_all_errors_with_exit_code_2(study):
    study.write_text(ONE_MASS.replace("mu = 0.4", "mu = -0.4").replace("kt = 200.0", "kt = 0.0"))
    found = object_of(stickslip_command("check", study, "--json"), 2)
    assert found["valid"] is False
    assert len(found["errors"]) == 2
    assert any("mu must be at least 0, but is -0.4" in error for error in found["errors"])


def test_info_describes_a_model(tmp_path):
    np.savez(tmp_path / "chain.npz", M=np.diag([1.0, 2.0]), K=np.array([[3.0, -1.0], [-1.0, 2.0]]), dofs=["1.x", "2.x"])
    found = object_of(stickslip_command("info", tmp_path / "chain.npz", "--json"))
    assert (found["rows"], found["entries"], found["rigid_motions"]) == (2, {"M": 2, "K": 4}, 0)
    assert found["mass"] == {"x": 3.0, "y": None, "z": None}
    squares = (2.0 * np.pi * np.array(found["frequencies"])) ** 2
    np.testing.assert_allclose(np.sort(squares), np.sort(np.linalg.eigvals(np.array([[3.0, -1.0], [-0.5, 1.0]]))))


@pytest.mark.slow
def test_several_studies_are_run_side_by_side_and_their_peaks_printed(study, tmp_path):
    second = tmp_path / "two.toml"
    second.write_text(ONE_MASS.replace("normal_load = 50.0", "normal_load = 1e6").replace("kt = 200.0", "kt = 100.0"))
    out = tmp_path / "out"
    ran = stickslip_command("run", study, second, "--out", out)
    assert ran.exit_code == 0, ran.output
    assert (out / "report.html").is_file()
    found = object_of(stickslip_command("peaks", out, "--json"))["results"]
    assert [result["name"] for result in found] == ["one", "two"]
    assert found[0]["units"] == {"frequency": "Hz", "amplitude": "mm"}
    (stuck,) = found[1]["peaks"]
    omega = np.sqrt(350.0 / 1e-4)
    assert stuck["frequency"] == pytest.approx(omega / (2.0 * np.pi), rel=1e-4)
    assert stuck["amplitude"] == pytest.approx(5.0 / (1.6e-3 * omega), rel=1e-4)  # mm: F/(c ω) at resonance
    printed = stickslip_command("peaks", out).stdout
    assert f"{stuck['frequency']:.6g}" in printed
    assert "amplitude [mm]" in printed


def test_nothing_is_computed_when_one_of_several_studies_has_errors(study, tmp_path):
    bad, missing = tmp_path / "bad.toml", tmp_path / "missing.toml"
    bad.write_text(ONE_MASS.replace("mu = 0.4", "mu = -0.4"))
    ran = stickslip_command("run", study, bad, missing, "--out", tmp_path / "out")
    assert ran.exit_code == 2
    assert "2 errors:" in ran.stderr
    assert f"{bad}: Line" in ran.stderr
    assert f"{missing}: The study file must exist" in ran.stderr
    assert not (tmp_path / "out").exists()


def test_studies_of_one_name_are_refused(study, tmp_path):
    (tmp_path / "other").mkdir()
    (tmp_path / "other" / "one.toml").write_text(ONE_MASS)
    ran = stickslip_command("run", study, tmp_path / "other" / "one.toml", "--out", tmp_path / "out")
    assert ran.exit_code == 2
    assert "one" in ran.stderr


@pytest.mark.slow
def test_results_without_curves_have_no_peaks(tmp_path):
    path = tmp_path / "record.toml"
    assert stickslip_command("new", "contact_law", path).exit_code == 0
    assert stickslip_command("run", path, "--out", tmp_path / "out").exit_code == 0
    refused = stickslip_command("peaks", tmp_path / "out", "--json")
    assert refused.exit_code == 2
    assert "must be response curves, which have peaks" in refused.stderr
