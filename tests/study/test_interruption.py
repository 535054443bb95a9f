"""A run may be killed at any moment, stopped, or run out of disk: nothing finished is lost, and resumed it ends the same."""

import os
import shutil
import signal
import subprocess
import sys
import time
from contextlib import suppress
from pathlib import Path

import numpy as np
import pytest

from stickslip.results.files import open_results
from stickslip.support import console
from stickslip.support.checks import counted
from stickslip.support.files import LIST

resource = pytest.importorskip("resource", reason="limits of file sizes need a Unix")

pytestmark = pytest.mark.slow
needs_proc = pytest.mark.skipif(sys.platform != "linux", reason="lists processes as Linux does")
LEVELS = [round(level, 3) for level in np.geomspace(0.3, 2.0, 8).tolist()]
STUDY = f"""
[study]
title = "One mass"
analysis = "forced_response"
[structure]
rig = "single_mass"
[sweep]
frequency = [0.08, 0.3]
force_levels = {LEVELS}
harmonics = 5
"""


def arguments(folder, *options):
    return [sys.executable, "-m", "stickslip", "run", str(folder / "study.toml"), "--out", str(folder / "out"), *options]


@pytest.fixture
def folder(tmp_path):
    (tmp_path / "study.toml").write_text(STUDY)
    return tmp_path


@pytest.fixture
def long(folder):
    """The study with so many curves that a run still computes when a test that waits for some of them goes on."""
    (folder / "study.toml").write_text(STUDY.replace(str(LEVELS), str(np.geomspace(0.3, 2.0, 60).tolist())))
    return folder


@pytest.fixture(scope="module")
def reference(tmp_path_factory):
    """The result of an uninterrupted run, and how long it took."""
    folder = tmp_path_factory.mktemp("reference")
    (folder / "study.toml").write_text(STUDY)
    subprocess.run(arguments(folder, "--workers", "1"), check=True, capture_output=True)
    started = time.monotonic()
    subprocess.run(arguments(folder, "--workers", "1", "--overwrite"), check=True, capture_output=True)
    return open_results(folder / "out" / "results.nc"), time.monotonic() - started


def assert_equal_bit_by_bit(a, b):
    assert set(a.variables) == set(b.variables)
    for name in a.variables:
        assert a[name].dtype == b[name].dtype, name
        assert a[name].values.tobytes() == b[name].values.tobytes(), name
        assert a[name].attrs.keys() == b[name].attrs.keys(), name
    apart = {"cpu_seconds"}
    assert {k: v for k, v in a.attrs.items() if k not in apart} == {k: v for k, v in b.attrs.items() if k not in apart}


def kept(folder):
    """Finished curves on disk: name, and when it was written."""
    found = {}
    for path in (folder / "out" / "unfinished").glob("[!.]*.npz"):
        with suppress(FileNotFoundError):  # removed since it was listed
            found[path.name] = path.stat().st_mtime_ns
    return found


def alive_in_session(leader):
    """Processes of a session that still run; ended ones that nobody has collected do not count."""
    found = []
    for stat in Path("/proc").glob("[0-9]*/stat"):
        try:
            state, _, _, session = stat.read_text().rpartition(")")[2].split()[:4]
        except (OSError, ValueError):
            continue
        if int(session) == leader and state not in "ZX":
            found.append(stat.parent.name)
    return found


def workers_of(process):
    """Processes that compute for another one."""
    children = Path(f"/proc/{process}/task/{process}/children")
    if not children.exists():
        return []
    found = []
    for child in children.read_text().split():
        with suppress(OSError):
            if b"spawn_main" in Path(f"/proc/{child}/cmdline").read_bytes():
                found.append(int(child))
    return found


def nothing_left_running(leader, within=60.0):
    if sys.platform != "linux":
        return
    ends = time.monotonic() + within
    while alive_in_session(leader):
        assert time.monotonic() < ends, "worker processes outlive the one that was killed"
        time.sleep(0.05)


def killed(folder, seconds, workers, curves=0):
    """A run that is killed so many seconds after its start, or after so many curves are kept."""
    shutil.rmtree(folder / "out", ignore_errors=True)
    command = arguments(folder, "--workers", str(workers))
    process = subprocess.Popen(command, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL, start_new_session=True)
    ends = time.monotonic() + 120.0
    while curves and len(kept(folder)) < curves:
        assert process.poll() is None, "the run ends before so many curves are kept"
        assert time.monotonic() < ends
        time.sleep(0.002)
    time.sleep(seconds)
    os.kill(process.pid, signal.SIGKILL)
    process.wait()
    nothing_left_running(process.pid)


def assert_resumes_to_the_same(folder, whole, workers):
    """Whatever a killed run left, it is whole or resumed to the whole, and nothing else lies there afterwards."""
    if (folder / "out" / "results.nc").exists():
        assert_equal_bit_by_bit(open_results(folder / "out" / "results.nc"), whole)
    before = kept(folder)
    resumed = subprocess.run(
        arguments(folder, "--resume", "--workers", str(workers)), check=False, capture_output=True, text=True
    )
    assert resumed.returncode == 0, resumed.stderr
    assert f"Resuming from {counted(len(before), 'completed curve')} in" in resumed.stdout or not before
    assert_equal_bit_by_bit(open_results(folder / "out" / "results.nc"), whole)
    assert sorted(path.name for path in (folder / "out").iterdir()) == [LIST, "report.html", "results.nc"]
    return len(before)


@pytest.mark.parametrize(("moment", "workers"), [(0.45, 1), (0.55, 1), (0.6, 2)])
def test_killed_three_times(folder, reference, moment, workers):
    whole, seconds = reference
    killed(folder, moment * seconds, workers)
    assert_resumes_to_the_same(folder, whole, workers)


@pytest.mark.verify
@pytest.mark.parametrize("workers", [1, 2])
def test_killed_at_twenty_random_moments(folder, reference, workers):
    """Ten from the start of the process to the end of the report, and ten among the curves, which take a small part of that."""
    whole, seconds = reference
    draw = np.random.default_rng(10 + workers)
    found = []
    for moment in draw.uniform(0.2, 1.0, 10):
        killed(folder, moment * seconds, workers)
        found.append(assert_resumes_to_the_same(folder, whole, workers))
    for curves in draw.integers(1, len(LEVELS), 10):
        killed(folder, draw.uniform(0.0, 0.03), workers, int(curves))
        found.append(assert_resumes_to_the_same(folder, whole, workers))
    assert len(set(found)) > 2, f"the moments meet different states of the run, but {found} curves were kept"


def test_killed_again_and_again(long):
    """What is kept grows until all is there."""
    before = {}
    while len(before) < 60:
        process = subprocess.Popen(
            arguments(long, "--resume", "--workers", "1"), stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL
        )
        ends = time.monotonic() + 120.0
        while len(kept(long)) < min(len(before) + 20, 60) and process.poll() is None and time.monotonic() < ends:
            time.sleep(0.005)
        process.kill()
        process.wait()
        now = kept(long)
        assert before.items() < now.items(), "a finished curve was lost, or computed again"
        before = now


@pytest.mark.parametrize("limit", [10_000, 100_000, 1_000_000])
def test_a_full_disk(folder, reference, limit):
    """Workspace for no curve; for curves, but not for results.nc; for results.nc, but not for the report."""

    def little_room():
        resource.setrlimit(resource.RLIMIT_FSIZE, (limit, limit))

    process = subprocess.run(
        arguments(folder, "--workers", "1"), capture_output=True, text=True, check=False, preexec_fn=little_room
    )
    assert process.returncode == console.WRONG_INPUT, process.stderr
    assert f"Error: a file cannot be accessed ({folder / 'out'}" in process.stderr
    assert ("with --resume to continue" in process.stderr) == (limit == 100_000)
    assert ("are complete; `stickslip report" in process.stderr) == (limit > 100_000)
    assert "Traceback" not in process.stderr
    assert (len(kept(folder)) == len(LEVELS)) == (limit == 100_000)
    assert (folder / "out" / "results.nc").exists() == (limit > 100_000)
    assert not (folder / "out" / "report.html").exists()
    assert {path.name for path in (folder / "out").rglob(".*")} <= {LIST}
    before = kept(folder)
    again = subprocess.run(arguments(folder, "--resume", "--workers", "1"), capture_output=True, text=True, check=True)
    assert f"Resuming from {len(before)} completed curves" in again.stdout or not before
    assert_equal_bit_by_bit(open_results(folder / "out" / "results.nc"), reference[0])


@pytest.mark.parametrize(
    ("send", "number", "code"),
    [(os.killpg, signal.SIGINT, console.INTERRUPTED), (os.kill, signal.SIGTERM, console.TERMINATED)],
    ids=["Ctrl-C", "SIGTERM"],
)
def test_ctrl_c_and_sigterm_end_all_processes_and_keep_what_is_finished(long, send, number, code):
    """A terminal interrupts all processes; a batch system terminates the one that it started."""
    process = subprocess.Popen(
        arguments(long, "--workers", "2"), stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, start_new_session=True
    )
    ends = time.monotonic() + 120.0
    while len(kept(long)) < 3 and time.monotonic() < ends:
        time.sleep(0.005)
    send(process.pid, number)
    _, errors = process.communicate(timeout=120)
    assert process.returncode == code, errors
    assert "Traceback" not in errors
    assert "with --resume to continue" in errors
    nothing_left_running(process.pid)
    assert len(kept(long)) >= 3


IN_PYTHON = """
import os, signal, threading
import stickslip as ss
signal.signal(signal.SIGINT, signal.default_int_handler)
for seconds in [0.0] + [0.02 + 0.0137 * k for k in range(12)]:
    if seconds:
        threading.Timer(seconds, os.kill, (os.getpid(), signal.SIGINT)).start()
    try:
        while True:
            ss.forced_response(ss.rigs.single_mass(), ss.radians_per_second(0.5, 2.0), 1.0, harmonics=5)
            if not seconds:
                break
    except KeyboardInterrupt:
        print("interrupted")
"""


def test_ctrl_c_while_compiled_code_runs_is_an_exception_in_python():
    """Not the end of the process: results of kernels are made without running Python code, which would raise half-way."""
    process = subprocess.run([sys.executable, "-c", IN_PYTHON], capture_output=True, text=True, check=False, timeout=300)
    assert process.returncode == 0, process.stderr
    assert process.stdout == "interrupted\n" * 12


@needs_proc
@pytest.mark.parametrize("seconds", [0.0, 0.1, 0.3, 0.6, 1.0])
def test_ctrl_c_while_processes_start_says_so_and_no_more(folder, reference, seconds):
    process = subprocess.Popen(arguments(folder, "--workers", "2"), stderr=subprocess.PIPE, text=True, start_new_session=True)
    ends = time.monotonic() + 60.0
    while not workers_of(process.pid) and process.poll() is None and time.monotonic() < ends:
        time.sleep(0.005)
    time.sleep(seconds)
    os.killpg(process.pid, signal.SIGINT)
    _, errors = process.communicate(timeout=120)
    assert "Traceback" not in errors
    nothing_left_running(process.pid)


def test_a_changed_study_is_refused_or_computed_again(folder, reference):
    subprocess.run(
        arguments(folder, "--workers", "1"),
        check=False,
        capture_output=True,
        preexec_fn=lambda: resource.setrlimit(resource.RLIMIT_FSIZE, (100_000, 100_000)),
    )
    assert len(kept(folder)) == len(LEVELS)
    (folder / "study.toml").write_text(STUDY.replace("harmonics = 5", "harmonics = 3"))
    refused = subprocess.run(arguments(folder, "--resume"), check=False, capture_output=True, text=True)
    assert refused.returncode == console.WRONG_INPUT
    line = STUDY.splitlines().index("harmonics = 5") + 1
    said = f"but the study (line {line}: 'harmonics = 3' now, 'harmonics = 5' then) changed since"
    assert said in " ".join(refused.stderr.split())
    assert len(kept(folder)) == len(LEVELS)
    refused = subprocess.run(arguments(folder), check=False, capture_output=True, text=True)
    assert refused.returncode == console.WRONG_INPUT
    assert "finished curves of an interrupted run" in " ".join(refused.stderr.split())
    assert len(kept(folder)) == len(LEVELS)
    subprocess.run(arguments(folder, "--overwrite"), check=True, capture_output=True)
    assert open_results(folder / "out" / "results.nc").attrs["harmonics"] == 3
