"""`stickslip identify-response`: from measured curves to parameters in one command, and what it refuses."""

import re

import numpy as np
import pytest
from typer.testing import CliRunner

import stickslip as ss
from stickslip import console
from stickslip.cli import app

FREQUENCIES = np.linspace(0.14, 0.24, 13)
KT, LIMIT, DAMPING = 0.5, 1.0, 0.02

MODEL = """
[study]
title = "One mass"
analysis = "forced_response"
[structure]
dofs = ["1.x"]
matrices = { M = [[1.0]], K = [[1.0]] , C = [[0.03]] }
[[contact]]
tangential = { "1.x" = 1.0 }
law = "macroslip"
kt = 0.4
mu = 2.0
normal_load = 1.0
[[force]]
direction = "1.x"
amplitude = 1.0
[sweep]
frequency = [0.145, 0.25]
harmonics = "auto"
outputs = ["1.x"]
"""


@pytest.fixture(scope="module")
def curves(tmp_path_factory):
    """Responses of one mass with a slider at three force levels, in files of two layouts."""
    folder, paths = tmp_path_factory.mktemp("curves"), []
    for force in (0.3, 1.0, 2.0):
        problem = ss.rigs.single_mass(kt=KT, limit=LIMIT, damping=DAMPING)
        data = ss.forced_response(problem, FREQUENCIES.tolist(), force).dataset
        X = data["response"].values[0, :, 0, 1] @ np.array([1.0, 1j])
        rows = [f"{f:.6g};{1e3 * abs(x):.8g};{force};{np.degrees(np.angle(x)):.6g}" for f, x in zip(FREQUENCIES, X, strict=True)]
        paths.append(folder / f"level_{force:g}.csv")
        paths[-1].write_text("Frequency [Hz];Displacement [mm];Force [N];Phase [deg]\n" + "\n".join(rows) + "\n")
    return paths


def command(*arguments):
    return CliRunner().invoke(app, [str(argument) for argument in arguments])


def values(output):
    return {name: float(value) for name, value in re.findall(r"^(\w+) = ([\d.e+-]+), 95 %", output, re.M)}


def test_a_rig_and_curves_become_parameters_and_a_report(curves, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    free = ("--free", "kt=0.1:3", "--free", "limit=2:0.2:5", "--free", "damping")
    shown = command("identify-response", "single_mass", *curves, *free)
    assert shown.exit_code == 0, shown.output
    assert values(shown.output) == pytest.approx({"kt": KT, "limit": LIMIT, "damping": DAMPING}, rel=1e-3)
    folder = tmp_path / "results" / "single_mass"
    assert (folder / "report.html").is_file()
    assert list(ss.open_results(folder / "results.nc")["test"].values) == ["level_0.3", "level_1", "level_2"]
    again = command("identify-response", "single_mass", *curves, "--quantity", "displacement", *free)
    assert again.exit_code == console.WRONG_INPUT
    assert "--overwrite" in again.output


def test_the_contacts_of_a_study_are_scaled(curves, tmp_path):
    """Factors on what the study says; its band leaves out a point of each curve, which is said."""
    study = tmp_path / "mass.toml"
    study.write_text(MODEL)
    free = ("--free", "kt=0.2:5", "--free", "mu", "--free", "damping=0.1:10")
    shown = command("identify-response", study, *curves, "--quantity", "displacement", *free, "--out", tmp_path / "out")
    assert shown.exit_code == 0, shown.output
    truth = {"kt": KT / 0.4, "mu": LIMIT / 2.0, "damping": DAMPING / 0.03}
    assert values(shown.output) == pytest.approx(truth, rel=1e-3)
    assert "3 of 39 points lie outside the band of [sweep] and are not used." in shown.output


def test_settings_of_each_curve_and_a_curve_named_twice(curves, tmp_path):
    free, settings = ("--free", "kt=0.1:3", "--free", "damping"), ("--setting", "limit=1,1,1,1", "--set", "mass=1")
    known = ("--quantity", "displacement", "--out", tmp_path / "out")
    shown = command("identify-response", "single_mass", *curves, curves[0], *free, *settings, *known)
    assert shown.exit_code == 0, shown.output
    assert values(shown.output)["kt"] == pytest.approx(KT, rel=1e-3)
    assert "count twice" in shown.output


@pytest.mark.parametrize(
    ("problem", "options", "words"),
    [
        ("single_mas", ("--free", "kt"), "PROBLEM must be a study file that exists, or a ready rig"),
        ("single_mass", (), "--free must name a parameter at least"),
        ("single_mass", ("--free", "ky=1:2"), "--free must name one of"),
        ("single_mass", ("--free", "kt=1"), "--free must be NAME, NAME=LOW:HIGH or NAME=START:LOW:HIGH"),
        ("single_mass", ("--free", "kt=2:1"), "kt must be [start, low, high]"),
        ("single_mass", ("--free", "preload=1:0.5:2"), "factors on the problem's own value"),
        ("single_mass", ("--free", "kt", "--set", "mass=heavy"), "--set must give numbers"),
        ("single_mass", ("--free", "kt", "--setting", "limit=1,2"), "must have 3 values, one for each curve"),
        ("single_mass", ("--free", "kt", "--setting", "kt=1,2,3"), "settings must not name what is free"),
        ("single_mass", ("--free", "kt", "--setting", "kz=1,2,3"), "settings must name some of"),
        ("single_mass", ("--free", "kt", "--start-states", "worn"), "start_states"),
        ("single_mass", ("--free", "kt", "--quantity", "velocity"), "must name amplitude"),
    ],
)
def test_what_is_refused_leaves_nothing_behind(curves, tmp_path, problem, options, words):
    shown = command("identify-response", problem, *curves, *options, "--out", tmp_path / "out")
    assert shown.exit_code == console.WRONG_INPUT
    assert words in " ".join(shown.output.split())
    assert not (tmp_path / "out" / "results.nc").exists()
