"""Cases on a real Dask cluster of this machine: the same results bit by bit, killed workers, schedulers that are not there.

Needs the extra `dask` (pip install "stickslip[dask]"); without it, only the refusal is tested.
"""

import json
import os
import signal
import subprocess
import sys
import time
from pathlib import Path
from threading import Thread

import numpy as np
import pytest
from runs.logged_cases import Deadly, LoggedCases, SlowToPrepare
from typer.testing import CliRunner

import stickslip as ss
from stickslip.cli import app
from stickslip.runs import dask_cluster
from stickslip.runs.cases import all_cases
from stickslip.support import console
from stickslip.support.checks import InputError

needs_dask = pytest.mark.skipif(not dask_cluster.installed(), reason='needs distributed: pip install "stickslip[dask]"')


def on_a_cluster(test):
    return pytest.mark.slow(needs_dask(test))


TESTS = Path(__file__).parents[1]
NOBODY = "tcp://127.0.0.1:1"
STUDY = """
[study]
title = "Six mistuned sectors"
analysis = "mistuned_population"
[structure]
rig = "lumped_blisk"
[structure.parameters]
sectors = 6
[sweep]
at = [152.2, 152.4]
force_levels = [0.4]
harmonics = 1
samples = 24
[mistuned_population]
count = 3
blade_scatter = 0.003
"""


class LocalCluster:
    """A scheduler and its workers, each a process of its own, as they are started by hand."""

    def __init__(self, folder, allowed_failures=3):
        self.processes = []
        self.settings = {"DASK_DISTRIBUTED__SCHEDULER__ALLOWED_FAILURES": str(allowed_failures)}
        file = folder / "scheduler.json"
        self._start("scheduler", "--port", "0", "--host", "127.0.0.1", "--scheduler-file", file, "--no-dashboard")
        ends = time.monotonic() + 120.0
        while not (file.exists() and file.read_text().endswith("}")):  # the scheduler may still be writing it
            assert time.monotonic() < ends
            time.sleep(0.1)
        self.address = json.loads(file.read_text())["address"]

    def _start(self, *arguments):
        paths = os.pathsep.join([str(TESTS), *filter(None, [os.environ.get("PYTHONPATH")])])
        command = [sys.executable, "-m", "dask", *map(str, arguments)]
        quiet = {"stdout": subprocess.DEVNULL, "stderr": subprocess.DEVNULL}
        self.processes.append(subprocess.Popen(command, env={**os.environ, **self.settings, "PYTHONPATH": paths}, **quiet))

    def add_workers(self, count):
        for _ in range(count):
            self._start("worker", self.address, "--nthreads", "1", "--no-nanny", "--no-dashboard", "--host", "127.0.0.1")

    def end(self):
        for process in reversed(self.processes):
            process.kill()
            process.wait()


@pytest.fixture(scope="module")
def cluster(tmp_path_factory):
    started = LocalCluster(tmp_path_factory.mktemp("cluster"))
    started.add_workers(2)
    yield started
    started.end()


@on_a_cluster
def test_a_study_gives_the_same_results_bit_by_bit(cluster, tmp_path):
    """The command waits for the workers that are still starting."""
    (tmp_path / "study.toml").write_text(STUDY)
    for out, options in (("here", ("--workers", "1")), ("there", ("--scheduler", cluster.address))):
        command = [sys.executable, "-m", "stickslip", "run", str(tmp_path / "study.toml"), "--out", str(tmp_path / out), *options]
        found = subprocess.run(command, capture_output=True, text=True, check=False)
        assert found.returncode == 0, found.stderr
    assert cluster.address in found.stdout
    here, there = (ss.open_results(tmp_path / out / "results.nc") for out in ("here", "there"))
    assert set(here.variables) == set(there.variables)
    for name in set(here.variables) - {"cpu_time"}:
        assert here[name].values.tobytes() == there[name].values.tobytes(), name


class KillsOne:
    """Keeps results, and as soon as four cases have ended kills a worker in the middle of another one."""

    def __init__(self, work):
        self.work, self.kept = work, {}
        self.case = self.process = self.before = None
        Thread(target=self._watch, daemon=True).start()

    def load(self, name):
        return None

    def save(self, name, arrays):
        self.kept[name] = arrays

    def _watch(self):
        while self.process is None:
            time.sleep(0.02)
            ended = self.work.lines("ended")
            running = [pair for pair in self.work.lines("began") if pair not in ended]
            if len(ended) >= 4 and running:
                self.before = set(self.kept)
                self.case, self.process = running[-1]
                os.kill(self.process, signal.SIGKILL)


@on_a_cluster
def test_a_killed_worker_costs_only_what_it_was_computing(cluster, tmp_path):
    cluster.add_workers(1)
    work = LoggedCases(str(tmp_path / "log"), 12, 0.3)
    killer = KillsOne(work)
    results = all_cases(work, killer, ss.DaskCluster(cluster.address))
    assert [int(arrays["square"]) for arrays in results] == [k**2 for k in range(12)]
    began = work.lines("began")
    cases = [case for case, _ in began]
    again = {case for case in cases if cases.count(case) > 1}
    assert killer.case in again
    assert not {f"case {case}" for case in again} & killer.before
    assert again <= {case for case, process in began if process == killer.process}


@on_a_cluster
def test_a_case_that_ends_its_workers_is_named(tmp_path):
    own = LocalCluster(tmp_path, allowed_failures=0)
    try:
        own.add_workers(1)
        with pytest.raises(InputError, match=r"Workers must survive a case, but case . ended every one"):
            all_cases(Deadly(str(tmp_path / "log"), 2, 0.0), None, ss.DaskCluster(own.address))
    finally:
        own.end()


def a_run(folder, address):
    """`stickslip run --resume` of 400 samples on a cluster, once two more of them are kept."""
    (folder / "study.toml").write_text(STUDY.replace("count = 3", "count = 400"))
    before = kept(folder)
    command = ["run", str(folder / "study.toml"), "--out", str(folder / "out"), "--resume", "--scheduler", address]
    pipes = {"stdout": subprocess.PIPE, "stderr": subprocess.PIPE, "text": True}
    process = subprocess.Popen([sys.executable, "-m", "stickslip", *command], start_new_session=True, **pipes)
    ends = time.monotonic() + 240.0
    while kept(folder) < before + 2 and process.poll() is None and time.monotonic() < ends:
        time.sleep(0.02)
    return process


def kept(folder):
    return len(list((folder / "out" / "unfinished").glob("[!.]*.npz")))


def error_of(process):
    """What a process that is about to end says on its error stream."""
    try:
        return process.communicate(timeout=60.0)[1]
    finally:
        process.kill()


@on_a_cluster
def test_a_lost_scheduler_and_ctrl_c_end_a_run_that_goes_on_elsewhere(cluster, tmp_path):
    (tmp_path / "own").mkdir()
    own = LocalCluster(tmp_path / "own")
    try:
        own.add_workers(1)
        process = a_run(tmp_path, own.address)
        own.processes[0].kill()
        errors = error_of(process)
    finally:
        own.end()
    before = kept(tmp_path)
    assert process.returncode == console.FAILED, errors
    assert f"the scheduler at {own.address} has gone" in errors
    assert f"Kept {before} completed curves" in errors
    assert "Traceback" not in errors
    process = a_run(tmp_path, cluster.address)
    os.killpg(process.pid, signal.SIGINT)
    errors = error_of(process)
    assert process.returncode == console.INTERRUPTED, errors
    assert "with --resume to continue" in errors
    assert "Traceback" not in errors
    assert 2 <= before < kept(tmp_path) < 400


@on_a_cluster
def test_a_scheduler_lost_while_a_worker_prepares(tmp_path):
    own = LocalCluster(tmp_path)
    work = SlowToPrepare(str(tmp_path / "log"), 1, 0.0)

    def end_it():
        while not work.lines("began"):
            time.sleep(0.02)
        own.processes[0].kill()

    try:
        own.add_workers(1)
        Thread(target=end_it, daemon=True).start()
        with pytest.raises(ConnectionError, match="has gone"):
            all_cases(work, None, ss.DaskCluster(own.address))
    finally:
        own.end()


@needs_dask
def test_a_scheduler_that_is_not_there(tmp_path):
    began = time.monotonic()
    with pytest.raises(InputError, match=r"must be that of a Dask scheduler that answers.*`dask scheduler`"):
        all_cases(LoggedCases(str(tmp_path / "log"), 1, 0.0), None, ss.DaskCluster(NOBODY))
    assert time.monotonic() - began < 30.0


@needs_dask
def test_the_command_says_so_too(tmp_path):
    (tmp_path / "study.toml").write_text(STUDY)
    command = ["run", str(tmp_path / "study.toml"), "--out", str(tmp_path / "out"), "--scheduler", NOBODY]
    for options, words in (((), NOBODY), (("--workers", "2"), "--workers must be left out")):
        found = CliRunner().invoke(app, [*command, *options])
        assert found.exit_code == console.WRONG_INPUT
        assert words in found.output
    assert not (tmp_path / "out").exists()


def test_another_version_on_a_worker_is_refused(tmp_path):
    work = LoggedCases(str(tmp_path / "log"), 1, 0.0)
    assert dask_cluster._solve(work, 0, dask_cluster.own_version())["square"] == np.array(0)
    with pytest.raises(InputError, match=r"must be version 0\.0"):
        dask_cluster._solve(work, 0, "0.0")


def test_without_the_package_it_is_refused(monkeypatch):
    monkeypatch.setattr(dask_cluster, "installed", lambda: False)
    with pytest.raises(InputError, match=r"must have its package.*stickslip\[dask\]"):
        ss.DaskCluster(NOBODY).workers()


@pytest.mark.parametrize("address", ["", "no address", "tcp://nowhere", 8786, None])
def test_what_is_no_address(address):
    with pytest.raises(InputError, match="must read as"):
        ss.DaskCluster(address)


def test_an_address_for_a_number_of_workers():
    with pytest.raises(InputError, match="A cluster is a `DaskCluster`"):
        all_cases(LoggedCases("", 1, 0.0), None, NOBODY)
