"""Ctrl-C: never lost, wherever in Python it strikes."""

import os
import signal
import subprocess
import sys
import threading
import time
import warnings
from contextlib import nullcontext, suppress

import numpy as np
import pytest

from stickslip.support.console import FAILED, INTERRUPTED, plain_warnings, progress_bar, report_fault, say, warn
from stickslip.support.files import write_arrays
from stickslip.support.interrupts import RETRY_SECONDS, raised_again, termination_as_interrupt


class InterruptedWhenDeleted:
    """A finalizer during which Ctrl-C is pressed; Python drops what a finalizer raises."""

    def __del__(self):
        os.kill(os.getpid(), signal.SIGINT)
        for _ in range(1000):
            pass  # the signal is handled between these


def work_interrupted():
    with progress_bar("work"):
        InterruptedWhenDeleted()
        for _ in range(1000):
            time.sleep(0.01)


def test_an_interrupt_that_python_drops_comes_again(capfd):
    hook, handler = sys.unraisablehook, signal.getsignal(signal.SIGINT)
    with pytest.raises(KeyboardInterrupt):
        work_interrupted()
    assert (sys.unraisablehook, signal.getsignal(signal.SIGINT)) == (hook, handler)
    assert capfd.readouterr().err == ""


def interrupted_twice():
    with progress_bar("work"):
        InterruptedWhenDeleted()
        raise KeyboardInterrupt


def test_an_interrupt_that_python_drops_beside_another_one_does_not_come_again():
    """It would kill the process that the other one ends."""
    with pytest.raises(KeyboardInterrupt):
        interrupted_twice()
    time.sleep(3.0 * RETRY_SECONDS)  # an interrupt now would end the test


def test_an_interrupt_that_python_drops_in_another_thread_comes_again_there():
    ended = []

    def work():
        with suppress(KeyboardInterrupt):
            DropsInterrupt()
            for _ in range(300):
                time.sleep(0.01)
            ended.append("the thread went on")

    with progress_bar("work"):
        thread = threading.Thread(target=work)
        thread.start()
        thread.join()
        time.sleep(3.0 * RETRY_SECONDS)
    assert not ended


def dropped_where_ctrl_c_is_ignored():
    with raised_again():
        DropsInterrupt()
        for _ in range(300):
            time.sleep(0.01)


def test_an_interrupt_that_python_drops_in_a_started_process_comes_again():
    """Such a process ignores the signal, and is stopped by an exception from another thread."""
    handler = signal.signal(signal.SIGINT, signal.SIG_IGN)
    try:
        with pytest.raises(KeyboardInterrupt):
            dropped_where_ctrl_c_is_ignored()
    finally:
        signal.signal(signal.SIGINT, handler)


class DropsInterrupt:
    """An object whose finalizer is interrupted."""

    def __del__(self):
        raise KeyboardInterrupt


class InterruptedWhenRead:
    """An array during whose writing Ctrl-C is pressed, or the system sends SIGTERM."""

    def __init__(self, number):
        self.number = number

    def __array__(self, dtype=None, copy=None):
        os.kill(os.getpid(), self.number)
        return np.arange(3.0)


@pytest.mark.parametrize(
    ("number", "sigint"),
    [
        (signal.SIGINT, signal.default_int_handler),
        (signal.SIGTERM, signal.default_int_handler),
        (signal.SIGTERM, signal.SIG_IGN),
    ],
)
def test_an_interrupt_waits_until_arrays_are_written(tmp_path, capfd, number, sigint):
    """Struck in the middle, `zipfile` puts an error of its own in the place of the interruption."""
    before = signal.signal(signal.SIGINT, sigint)
    try:
        with pytest.raises(KeyboardInterrupt), termination_as_interrupt():
            write_arrays(tmp_path / "kept.npz", {"u": InterruptedWhenRead(number)})
        assert signal.getsignal(signal.SIGINT) == sigint
    finally:
        signal.signal(signal.SIGINT, before)
    with np.load(tmp_path / "kept.npz") as kept:
        assert kept["u"].tolist() == [0.0, 1.0, 2.0]
    assert [path.name for path in tmp_path.iterdir()] == ["kept.npz"]
    assert capfd.readouterr().err == ""


class InterruptedWhileMade:
    """A descriptor during whose `__set_name__` Ctrl-C is pressed."""

    def __set_name__(self, owner, name):
        raise KeyboardInterrupt


def test_an_interrupt_that_python_turns_into_another_error_is_one(capfd):
    with pytest.raises((RuntimeError, KeyboardInterrupt)) as raised:
        type("Made", (), {"entry": InterruptedWhileMade()})
    assert report_fault(raised.value) == INTERRUPTED
    assert report_fault(RuntimeError("another")) == FAILED
    assert capfd.readouterr().err.startswith(
        "Interrupted. All files written so far are complete.\nError inside stickslip (RuntimeError: another)"
    )


def test_ctrl_c_while_modules_load_ends_without_a_traceback(tmp_path):
    """It strikes in a module of the name of one that loads first."""
    (tmp_path / "typer.py").write_text("raise KeyboardInterrupt\n")
    environment = {**os.environ, "PYTHONPATH": os.pathsep.join([str(tmp_path), *sys.path])}
    ended = subprocess.run([sys.executable, "-m", "stickslip"], env=environment, capture_output=True, text=True, check=False)
    assert (ended.returncode, ended.stderr) == (INTERRUPTED, "Interrupted. All files written so far are complete.\n")


def test_a_warning_is_a_sentence_without_its_place_in_the_program(capfd):
    with plain_warnings():
        warnings.simplefilter("default")
        warnings.warn("The units seem mixed.", RuntimeWarning, stacklevel=1)
    assert capfd.readouterr().err == "Warning: The units seem mixed.\n"


def work_terminated(bar):
    with bar, termination_as_interrupt():
        os.kill(os.getpid(), signal.SIGTERM)
        time.sleep(10.0)


@pytest.mark.parametrize("bar", [progress_bar, nullcontext])
@pytest.mark.parametrize("sigint", [signal.default_int_handler, signal.SIG_IGN, signal.SIG_DFL])
def test_sigterm_interrupts_whatever_sigint_does(sigint, bar):
    """A shell script starts programs in the background with SIGINT ignored."""
    before = signal.getsignal(signal.SIGTERM), signal.signal(signal.SIGINT, sigint)
    try:
        with pytest.raises(KeyboardInterrupt):
            work_terminated(bar("work"))
        assert signal.getsignal(signal.SIGTERM) == before[0]
    finally:
        signal.signal(signal.SIGINT, before[1])


def test_other_dropped_exceptions_are_reported(monkeypatch):
    class FailsWhenDeleted:
        def __del__(self):
            raise ValueError("dropped")

    reported = []
    monkeypatch.setattr(sys, "unraisablehook", lambda unraisable: reported.append(str(unraisable.exc_value)))
    with progress_bar("work"):
        FailsWhenDeleted()
    assert reported == ["dropped"]


@pytest.mark.parametrize("show", [say, warn])
def test_a_title_does_not_command_the_terminal(capsys, show):
    """ESC, and its one-character form CSI, begin what would set the title of the window or hide a line."""
    show("a\x1b]0;evil\x07b\x9b2Jc\rd\ne")
    assert "".join(capsys.readouterr()) == "a\ufffd]0;evil\ufffdb\ufffd2Jc\ufffdd\ne\n"


def test_progress_without_a_terminal_is_a_line_every_ten_seconds_and_later_every_half_minute(capfd, monkeypatch):
    """At 9, 11, 20, 31, 930 and 955 s; a share that is too small says nothing of the time left."""
    clock = iter([0.0, 9.0, 11.0, 20.0, 31.0, 930.0, 955.0])
    monkeypatch.setattr("stickslip.support.console.monotonic", lambda: next(clock))
    with progress_bar("Forced response") as report:
        for fraction in (0.0, 0.01, 0.1, 0.2, 0.75, 0.8):
            report(fraction, "level 1")
    lines = capfd.readouterr().err.splitlines()
    assert lines == [
        "Forced response: level 1: 1 % after 11 s",
        "Forced response: level 1: 20 % after 31 s, about 84 s left",
        "Forced response: level 1: 75 % after 16 min, about 7 min left",
    ]


def test_the_remaining_time_is_that_at_the_last_pace_and_unknown_where_a_curve_folds(capfd, monkeypatch):
    """57 % after 30 s and still after five minutes: the whole pace would promise 4 min more."""
    clock = iter([0.0, 31.0, 62.0, 120.0, 300.0, 600.0])
    monkeypatch.setattr("stickslip.support.console.monotonic", lambda: next(clock))
    with progress_bar("Forced response", "stop it") as report:
        for fraction in (0.57, 0.57, 0.58, 0.58, 0.9):
            report(fraction, "level 8")
    ends = [line.partition(" after ")[2] for line in capfd.readouterr().err.splitlines()]
    unknown = "the remaining time is unknown; stop it"
    assert ends == [
        "31 s, about 23 s left",
        f"62 s, no progress for 31 s: {unknown}",
        f"2 min, no progress for 89 s: {unknown}",
        f"5 min, no progress for 4 min: {unknown}",
        "10 min, about 94 s left",
    ]


def test_a_part_of_the_work_that_begins_anew_has_a_remaining_time_of_its_own(capfd, monkeypatch):
    """Curves after their first solutions, which had come to 75 %, were said to stand while they went from 28 to 67 %."""
    clock = iter([0.0, 10.0, 20.0, 30.0, 40.0])
    monkeypatch.setattr("stickslip.support.console.monotonic", lambda: next(clock))
    with progress_bar("Forced response", "stop it") as report:
        for fraction in (0.75, 0.3, 0.5, 0.7):
            report(fraction, "level 8")
    ends = [line.partition(" after ")[2] for line in capfd.readouterr().err.splitlines()]
    assert ends == ["10 s, about 3 s left", "20 s, about 23 s left", "30 s, about 25 s left", "40 s, about 15 s left"]
