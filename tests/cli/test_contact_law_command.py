"""`stickslip contact-law`, the study it stands for, and what both refuse."""

import re
import signal
import subprocess
import sys
import time
from pathlib import Path

import numpy as np
import pytest
from typer.testing import CliRunner

import stickslip as ss
from stickslip.cli import app
from stickslip.support import console
from stickslip.support.files import only_own_files, write_text
from verify.identification import loop_of


@pytest.fixture
def record(tmp_path):
    """Six cycles of one slider: kt 20 N/µm, mu 0.4, 100 N; with noise."""
    generator = np.random.default_rng(0)
    u, force = (np.tile(one, 6) for one in loop_of(np.ones(1), 20e6, 0.4, 100.0, 10e-6, 200))
    u, force = u + 5e-8 * generator.standard_normal(u.size), force + 0.2 * generator.standard_normal(u.size)
    path = tmp_path / "record.txt"
    lines = [f"{1e6 * x:.6g}\t{f:.6g}" for x, f in zip(u, force, strict=True)]
    path.write_text("Position [um]\tFriction [N]\n" + "\n".join(lines) + "\n")
    return path


def command(*arguments):
    return CliRunner().invoke(app, [str(argument) for argument in arguments])


@pytest.mark.slow
def test_a_record_becomes_an_answer_a_report_and_results(record, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    shown = command("contact-law", record, "--normal-load", 100, "--figures")
    assert shown.exit_code == 0, shown.output
    found = re.search(r"jenkins: kt = ([\d.]+) N/µm, .*; mu = ([\d.]+), 95 %", shown.output)
    assert float(found[1]) == pytest.approx(20.0, rel=0.01)
    assert float(found[2]) == pytest.approx(0.4, rel=0.01)
    folder = tmp_path / "results" / "record"
    data = ss.open_results(folder / "results.nc")
    assert float(data["mu"].sel(law="jenkins")) == pytest.approx(float(found[2]), rel=1e-3)
    assert {path.name for path in (folder / "figures").iterdir()} >= {"loops.png", "cycles.svg", "laws.png"}
    page = (folder / "report.html").read_text()
    assert "Law of a contact" in page
    assert "analysis = &quot;contact_law&quot;" in page or 'analysis = "contact_law"' in page
    again = command("contact-law", record, "--normal-load", 100)
    assert again.exit_code == console.WRONG_INPUT
    assert "--overwrite" in again.output


@pytest.mark.slow
def test_the_command_and_its_study_agree(record, tmp_path):
    options = ("--law", "jenkins", "--rig-stiffness", 100, "--column", "displacement=1", "--unit", "force=N")
    shown = command("contact-law", record, "--normal-load", 100, *options, "--out", tmp_path / "a")
    assert shown.exit_code == 0, shown.output
    by_command = ss.open_results(tmp_path / "a" / "results.nc")
    assert float(by_command["kt"][0]) == pytest.approx(25e6, rel=0.02)  # 1/20 - 1/100 = 1/25
    study = tmp_path / "study.toml"
    study.write_text(
        '[units]\nlength = "mm"\n[study]\nanalysis = "contact_law"\n[contact_law]\nfiles = ["record.txt"]\nnormal_load = 100.0\n'
        'laws = ["jenkins"]\nrig_stiffness = 1e5\n'
    )
    assert command("run", study, "--out", tmp_path / "b").exit_code == 0
    by_study = ss.open_results(tmp_path / "b" / "results.nc")
    assert float(by_study["kt"][0]) == float(by_command["kt"][0])
    assert command("run", study, "--out", tmp_path / "b", "--resume").exit_code == 0


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        ((), "normal load of record.txt must be known"),
        (("--normal-load", "0.1"), "Is a unit wrong"),
        (("--normal-load", "-5"), "normal_load"),
        (("--normal-load", "nan"), "normal_load must be finite"),
        (("--normal-load", "100", "--unit", "force=N", "--unit", "force=kN"), "--unit must give force once"),
        (("--normal-load", "100", "--law", "coulomb"), "laws"),
        (("--normal-load", "100", "--column", "force"), "--column must be NAME=VALUE"),
        (("--normal-load", "100", "--column", "kraft=1"), "columns"),
        (("--normal-load", "100", "--unit", "force=furlong"), "must be a known one"),
        (("--normal-load", "100", "--rig-stiffness", "10"), "stiffness of rig and contact together"),
    ],
)
def test_what_is_refused_leaves_nothing_behind(record, tmp_path, arguments, words):
    shown = command("contact-law", record, *arguments, "--out", tmp_path / "out")
    assert shown.exit_code == console.WRONG_INPUT
    assert words in " ".join(shown.output.split())
    assert not (tmp_path / "out").exists()


def test_a_missing_file_is_named(tmp_path):
    shown = command("contact-law", Path("no.txt"), "--normal-load", 5, "--out", tmp_path / "out")
    assert shown.exit_code == console.WRONG_INPUT
    assert "no.txt" in shown.output
    assert not (tmp_path / "out").exists()


@pytest.mark.slow
def test_ctrl_c_while_many_files_are_read_and_fitted(tmp_path):
    u, force = (np.tile(one, 5) for one in loop_of(np.ones(1), 20e6, 0.4, 100.0, 10e-6, 400))
    files = [tmp_path / f"cycle_{k}.txt" for k in range(60)]
    for k, path in enumerate(files):
        generator = np.random.default_rng(k)
        noisy = 1e6 * u + 0.05 * generator.standard_normal(u.size), force + 0.2 * generator.standard_normal(u.size)
        np.savetxt(path, np.stack(noisy, axis=1), header="x [um] F [N]")
    out = tmp_path / "out"
    arguments = [sys.executable, "-m", "stickslip", "contact-law", *map(str, files), "--normal-load", "100", "--out", str(out)]
    process = subprocess.Popen(arguments, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
    while not out.is_dir() and process.poll() is None:
        time.sleep(0.002)
    time.sleep(0.5)
    process.send_signal(signal.SIGINT)
    output, errors = process.communicate(timeout=60)
    assert process.returncode == console.INTERRUPTED, output + errors
    assert errors.splitlines() == [
        "Nothing was kept yet: no part of the work was completed.",
        "Interrupted. All files written so far are complete.",
    ]
    assert not [path for path in out.rglob("*") if path.is_file()]


def test_an_interrupted_overwriting_run_leaves_no_report_of_other_results(record, tmp_path, monkeypatch):
    """The report of the results before is gone when the new ones are written."""
    with only_own_files():
        write_text(tmp_path / "out" / "report.html", "old")
    seen = []

    def interrupted(dataset, path):
        seen.append((path.parent / "report.html").exists())
        raise KeyboardInterrupt

    monkeypatch.setattr("stickslip.study.run.save", interrupted)
    command("contact-law", record, "--normal-load", 100, "--law", "jenkins", "--out", tmp_path / "out", "--overwrite")
    assert seen == [False]
