"""Processors whose rounding the tests are run with: only those whose instructions the machine has."""

import signal
import subprocess

import pytest

from tests import rounding


def ends_with(code):
    return lambda command, **how: subprocess.CompletedProcess(command, code, stdout="['SkylakeX']\n", stderr="")


def test_kernels_that_this_processor_cannot_run_are_left_out(monkeypatch):
    monkeypatch.setattr(rounding.subprocess, "run", ends_with(-signal.SIGILL))
    assert rounding.kernels({}) is None


def test_any_other_failure_is_not_taken_for_a_missing_instruction(monkeypatch):
    monkeypatch.setattr(rounding.subprocess, "run", ends_with(1))
    with pytest.raises(subprocess.CalledProcessError):
        rounding.kernels({})


def test_what_a_machine_has_by_itself_is_no_other_processor(monkeypatch):
    found = {"SkylakeX": None, "Haswell": "own", "Sandybridge": "Sandybridge", "Nehalem": "Nehalem", "Prescott": "Katmai"}
    monkeypatch.setattr(rounding.platform, "machine", lambda: "x86_64")
    monkeypatch.setattr(rounding, "kernels", lambda environment: found.get(environment.get("OPENBLAS_CORETYPE"), "own"))
    assert rounding.other_processors() == ["Sandybridge", "Nehalem", "Prescott"]
