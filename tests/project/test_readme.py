"""What the README promises: its commands, its study and its Python example."""

import re
import shlex
from pathlib import Path

import numpy as np
import pytest
from typer.testing import CliRunner

from stickslip.cli import app

ROOT = Path(__file__).parents[2]
README = (ROOT / "README.md").read_text()


def commands(program):
    """The lines of the README's shell blocks that call a program, without their comments."""
    lines = [line for block in re.findall(r"```sh\n(.*?)```", README, re.S) for line in block.splitlines()]
    return [shlex.split(line, comments=True) for line in lines if line.startswith(f"{program} ")]


def test_the_targets_of_make_exist():
    targets = {name for line in re.findall(r"^([\w .-]+):", (ROOT / "Makefile").read_text(), re.M) for name in line.split()}
    named = [words[1] for words in commands("make")]
    assert named == ["demo", "test"]
    assert set(named) <= targets


@pytest.mark.slow
def test_the_first_study_gives_a_report(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    calls = commands("stickslip")
    assert [words[1] for words in calls] == ["new", "check", "run"]
    for words in calls:
        result = CliRunner().invoke(app, words[1:])
        assert result.exit_code == 0, result.output
    assert (tmp_path / "results" / "wedge" / "report.html").is_file()
    assert (tmp_path / "results" / "wedge" / "results.nc").is_file()


def test_the_python_example():
    """With one harmonic, energy is balanced at 4 µN (X − µN/kt) + π c ω X² = π F X."""
    (block,) = re.findall(r"```python\n(.*?)```", README, re.S)
    names = {}
    exec(block, names)
    peaks = names["response"].peaks()
    per_newton = peaks["amplitude"] / peaks["force_level"]
    assert per_newton.idxmin() == 2  # 10 N
    assert peaks["frequency"][2] == pytest.approx(311, abs=0.5)
    assert per_newton[2] == pytest.approx(16.0e-6, rel=3e-3)
    assert per_newton[0] == pytest.approx(103e-6, rel=5e-3)
    assert np.sqrt(2.5e5 / 0.1) / (2 * np.pi) == pytest.approx(252, abs=0.5)
    amplitude, omega = peaks["amplitude"], 2 * np.pi * peaks["frequency"]
    slip = 4 * 20.0 * (amplitude - 20.0 / 2e5) + np.pi * 1.6 * omega * amplitude**2
    np.testing.assert_allclose(slip, np.pi * peaks["force_level"] * amplitude, rtol=0.02)
