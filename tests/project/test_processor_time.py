"""Tests that take much processor time, in a fixture or a child process too, fail with `--cpu-limit` unless marked."""

import shutil
import subprocess
import sys
from pathlib import Path

TESTS = """
import subprocess, sys, time
import pytest

def burn(seconds):
    ends = time.process_time() + seconds
    while time.process_time() < ends:
        pass

@pytest.fixture(scope="module")
def costly():
    burn(0.5)

def test_in_a_fixture(costly): pass
def test_after_the_fixture(costly): pass
def test_in_a_child(): subprocess.run([sys.executable, "-c", "import time\\nwhile time.process_time() < 0.5: pass"], check=True)
def test_waiting(): time.sleep(0.5)
@pytest.mark.slow
def test_marked(): burn(0.5)
"""


def test_only_what_computes_for_long_and_is_not_marked_fails(tmp_path):
    shutil.copy(Path(__file__).parents[1] / "conftest.py", tmp_path)
    (tmp_path / "test_five.py").write_text(TESTS)
    (tmp_path / "pytest.ini").write_text("[pytest]\nmarkers =\n    slow\n")
    command = [sys.executable, "-m", "pytest", "-p", "no:cacheprovider", "--cpu-limit", "0.3"]
    found = subprocess.run(command, cwd=tmp_path, capture_output=True, text=True, check=False).stdout
    failed = {line.split()[1].split("::")[1] for line in found.splitlines() if line.startswith("FAILED")}
    assert failed == {"test_in_a_fixture", "test_in_a_child"}, found
    assert "in all 4 tests neither slow nor nightly" in found
