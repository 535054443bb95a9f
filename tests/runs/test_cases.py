"""Cases computed by processes, kept and given back: the same results whoever computes them."""

import os
import subprocess
import sys
import threading
import time
import warnings
from multiprocessing import active_children, connection, get_context

import numpy as np
import pytest
from runs.logged_cases import Broken, KilledWhileItAnswers, KillsWhatStarts, LoggedCases, SlowToArrive, Stoppable, Unprepared

import stickslip as ss
from stickslip.runs import cases
from stickslip.runs.cases import ABOUT, CheckpointFolder, Stopped, all_cases
from stickslip.support.checks import Faults
from stickslip.support.files import LIST

LEVELS = [0.4, 0.5, 0.7, 1.0, 1.4, 2.0]
BAND = ss.radians_per_second(0.5, 2.0)


def bits(response):
    return {name: variable.values.tobytes() for name, variable in response.dataset.variables.items()}


@pytest.fixture(scope="module")
def whole():
    return ss.forced_response(ss.rigs.single_mass(), BAND, LEVELS, harmonics=3)


def until_two_compute(text):
    """Halts the hand-out of cases, as progress of it, until another process computes too."""
    if "2 at once" not in text:
        time.sleep(2.0)


@pytest.mark.slow
def test_workers_change_nothing(whole):
    shares, texts = [], []

    def progress(fraction, text):
        until_two_compute(text)
        shares.append(fraction)
        texts.append(text)

    side_by_side = ss.forced_response(ss.rigs.single_mass(), BAND, LEVELS, harmonics=3, workers=2, progress=progress)
    assert bits(side_by_side) == bits(whole)
    assert shares == sorted(shares)
    assert shares[-1] == 1.0
    assert any("2 at once" in text for text in texts)


def test_a_killed_process_loses_nothing(whole):
    killed = []

    def kill_one(fraction, text):
        if not killed:
            until_two_compute(text)
            if "2 at once" in text:
                killed.append(active_children()[0])
                killed[0].kill()

    with pytest.warns(RuntimeWarning, match=r"A process was killed while it computed force level .* take fewer workers"):
        others = ss.forced_response(ss.rigs.single_mass(), BAND, LEVELS, harmonics=3, workers=2, progress=kill_one)
    assert bits(others) == bits(whole)
    assert killed


def test_a_process_that_ends_before_it_begins_is_no_loss(tmp_path):
    work = KillsWhatStarts(str(tmp_path / "log"), 5, 0.2)
    with pytest.warns(RuntimeWarning, match="A process ended while it started"):
        results = all_cases(work, workers=2)
    assert [int(arrays["square"]) for arrays in results] == [0, 1, 4, 9, 16]


@pytest.mark.slow
def test_a_script_without_the_guard_computes_with_one_warning(tmp_path):
    script = tmp_path / "script.py"
    script.write_text(
        "import stickslip as ss\n"
        "band = ss.radians_per_second(0.5, 2.0)\n"
        "levels = [1.0 + 0.05 * k for k in range(40)]\n"
        "found = ss.forced_response(ss.rigs.single_mass(), band, levels, harmonics=3, workers=2)\n"
        "print(found.dataset.sizes['case'])\n"
    )
    ended = subprocess.run([sys.executable, str(script)], capture_output=True, text=True, check=False)
    assert (ended.returncode, ended.stdout) == (0, "40\n")
    assert "Traceback" not in ended.stderr
    assert ended.stderr.count("A process ended while it started") <= 1


def test_cases_do_not_wait_for_processes_that_start(tmp_path):
    began, work = time.monotonic(), SlowToArrive(str(tmp_path / "log"), 3, 0.0)
    all_cases(work, workers=3)
    assert time.monotonic() - began < 30.0
    assert {process for _, process in work.lines("began")} == {os.getpid()}
    assert not active_children()


@pytest.mark.parametrize(
    "delay", [0.0, 0.01, *(pytest.param(delay, marks=pytest.mark.slow) for delay in (0.005, 0.015, 0.02, 0.03))]
)
def test_a_process_killed_in_the_middle_of_its_answer_costs_that_case_only(delay, tmp_path):
    """Half a result never stops the others (it does in a pool whose processes share a pipe)."""
    work = KilledWhileItAnswers(str(tmp_path / "log"), 6, delay, os.getpid())
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        results = all_cases(work, workers=2)
    assert [arrays["large"][0] for arrays in results] == list(range(6))
    began = work.lines("began")
    others = [case for case, process in began if process != os.getpid()]
    assert others
    handed_out = [case for case, _ in began]
    again = {case for case in handed_out if handed_out.count(case) > 1}
    assert again <= {others[-1]}  # the first, or the next one where the first was sent in time
    assert len(again) <= len(caught) <= 1


def test_an_error_in_a_process_ends_all_and_says_where(tmp_path):
    """This process is then in the middle of a case of a minute."""
    began = time.monotonic()
    with pytest.raises(Faults) as caught:
        all_cases(Broken(str(tmp_path / "log"), 4, 0.0, os.getpid()), workers=2)
    assert caught.value.faults == ("a", "b")
    assert "logged_cases.py" in caught.value.__notes__[0]
    assert time.monotonic() - began < 30.0
    assert not active_children()


def test_processes_start_while_this_one_prepares_and_end_with_it(tmp_path):
    """Their imports take a second, as preparing does; an error there leaves none behind."""
    work = Unprepared(str(tmp_path / "log"), 4, 0.0)
    with pytest.raises(Faults, match="no compiler"):
        all_cases(work, workers=2)
    assert work.lines("beside")
    assert not {process.pid for process in active_children()} & {process for _, process in work.lines("beside")}
    assert not work.lines("began")


@pytest.mark.parametrize("workers", [0, -1, 1.5, True])
def test_wrong_workers_are_refused(workers):
    with pytest.raises(ss.InputError, match="workers must be a whole number from 1 on"):
        ss.forced_response(ss.rigs.single_mass(), BAND, workers=workers)


def test_progress_goes_on_while_a_curve_runs():
    shares = []
    ss.forced_response(ss.rigs.single_mass(), BAND, 1.0, progress=lambda fraction, text: shares.append(fraction))
    assert len(set(shares)) > 10
    assert shares == sorted(shares)


def test_what_is_kept_is_given_back_bit_by_bit(whole, tmp_path):
    kept = CheckpointFolder(tmp_path / "kept")
    ss.forced_response(ss.rigs.single_mass(), BAND, LEVELS[:2], harmonics=3, checkpoint=kept)
    assert len(kept) == 2
    again = ss.forced_response(ss.rigs.single_mass(), BAND, LEVELS, harmonics=3, checkpoint=CheckpointFolder(tmp_path / "kept"))
    assert bits(again) == bits(whole)
    assert len(kept) == len(LEVELS)


def test_a_case_of_another_problem_is_not_given_back(whole, tmp_path):
    kept = CheckpointFolder(tmp_path)
    ss.forced_response(ss.rigs.single_mass(mass=1.1), BAND, LEVELS, harmonics=3, checkpoint=kept)
    again = ss.forced_response(ss.rigs.single_mass(), BAND, LEVELS, harmonics=3, checkpoint=kept)
    assert bits(again) == bits(whole)
    assert len(kept) == 2 * len(LEVELS)


def test_a_damaged_file_is_computed_again(tmp_path):
    kept = CheckpointFolder(tmp_path)
    kept.save("a case", {"x": np.arange(1000.0)})
    (file,) = tmp_path.glob("*.npz")
    content = file.read_bytes()
    for damaged in (b"", content[:300], content[:200] + b"\0" * 8 + content[208:], b"no archive"):
        file.write_bytes(damaged)
        found = kept.load("a case")
        assert found is None or np.array_equal(found["x"], np.arange(1000.0))
    file.write_bytes(content)
    np.testing.assert_array_equal(kept.load("a case")["x"], np.arange(1000.0))
    assert kept.load("another case") is None


def test_a_folder_of_something_else_is_refused(tmp_path):
    CheckpointFolder(tmp_path, {"study": "a", "version": "1"}).save("x", {"x": np.zeros(1)})
    with pytest.raises(ss.InputError, match="but the study and the version changed since"):
        CheckpointFolder(tmp_path, {"study": "b", "version": "2"})
    assert CheckpointFolder.remove(tmp_path / "none") == []
    assert CheckpointFolder.remove(tmp_path) == []
    assert not tmp_path.exists()


def test_what_others_put_into_a_checkpoint_stays(tmp_path):
    """A file of a user, one that was changed, a folder, links: all are left and named."""
    folder, precious = tmp_path / "kept", tmp_path / "precious"
    precious.mkdir()
    (precious / "thesis.doc").write_text("years")
    kept = CheckpointFolder(folder, {"study": "a"})
    kept.save("x", {"x": np.zeros(1)})
    kept.save("y", {"x": np.zeros(1)})
    for name in ("notes.npz", ".notes.0123abcd.npz"):
        (folder / name).write_text("mine")
    (folder / ABOUT).write_text("{half")
    (folder / "link.npz").symlink_to(precious / "thesis.doc")
    (folder / "linked").symlink_to(precious)
    (folder / "deep").mkdir()
    (folder / "deep" / "results.nc").write_text("mine")
    assert (CheckpointFolder.count(folder), CheckpointFolder(folder, {"study": "b"}).load("z")) == (2, None)
    left = {path.name for path in CheckpointFolder.remove(folder)}
    assert left == {"notes.npz", ".notes.0123abcd.npz", ABOUT, "link.npz", "linked", "deep"}
    assert (folder / "deep" / "results.nc").read_text() == (folder / "notes.npz").read_text() == "mine"
    assert (precious / "thesis.doc").read_text() == "years"
    assert {path.name for path in folder.iterdir()} == left | {LIST}


def test_a_damaged_case_is_put_aside_when_it_is_computed_again(tmp_path):
    kept = CheckpointFolder(tmp_path)
    kept.save("x", {"x": np.zeros(1)})
    (file,) = tmp_path.glob("*.npz")
    file.write_bytes(b"no archive")
    kept.save("x", {"x": np.ones(1)})
    assert kept.load("x")["x"] == 1.0
    (aside,) = CheckpointFolder.remove(tmp_path)
    assert aside.read_bytes() == b"no archive"


def test_stopped_cases_give_what_they_have(tmp_path):
    """Ctrl-C while this process and another compute, each in the middle of a case."""
    work = Stoppable(str(tmp_path / "log"), 3, 0.0)

    def stop(fraction, text):
        if "2 at once" in text and len(work.lines("began")) == 2:
            time.sleep(0.2)
            raise KeyboardInterrupt

    with pytest.raises(Stopped) as stopped:
        all_cases(work, workers=2, progress=stop)
    assert len(stopped.value.results) == 2
    assert all(1 <= int(arrays["done"]) < 1000 for arrays in stopped.value.results.values())
    assert not active_children()


def test_a_thread_interrupted_in_the_middle_of_its_answer_closes_the_pipe(tmp_path, monkeypatch):
    """A long answer goes out as its length and then its bytes; whoever has the length would wait for the bytes for ever."""
    send = connection.Connection._send

    def interrupted(pipe, data, *rest):
        send(pipe, data, *rest)
        if threading.current_thread() is not threading.main_thread():
            raise KeyboardInterrupt

    monkeypatch.setattr(cases, "_answer", lambda work, case, fractions: np.zeros(100_000))
    monkeypatch.setattr(connection.Connection, "_send", interrupted)
    got = []
    with cases._thread(LoggedCases(str(tmp_path / "log"), 1, 0.0), [0.0]) as (here, _):
        here.send(0)
        while here.poll(1.0):  # False where the rest never comes
            try:
                got.append(os.read(here.fileno(), 4096))
            except OSError:  # closed on Windows
                break
            if not got[-1]:
                break
        else:
            pytest.fail("the pipe stays open")
    assert 0 < len(b"".join(got)) < 100_000


def test_a_process_that_is_stopped_before_its_first_case_says_nothing(tmp_path, capfd):
    """What stops it waits in its pipe when it begins to listen, as it does where all are stopped while a process still starts."""
    context = get_context("spawn")
    here, there = context.Pipe()
    process = context.Process(target=cases._serve, args=(context.RawArray("d", 1), there))
    process.start()
    there.close()
    work = LoggedCases(str(tmp_path / "log"), 1, 0.0)
    for sent in (type(work), work, cases.STOP):
        here.send(sent)
    assert here.poll(60.0)  # it has begun, or has ended
    process.join(1.0)
    here.close()
    process.join()
    assert capfd.readouterr().err == ""


def test_processes_apart_are_ended_at_once_in_the_middle_of_a_case(tmp_path):
    """Ctrl-C while two others sleep for a minute, deaf to it; cases that were completed before are kept."""
    work = LoggedCases(str(tmp_path / "log"), 2, 60.0)
    stopped_at = None

    def stop(fraction, text):
        nonlocal stopped_at
        if len(work.lines("began")) == 2:
            stopped_at = time.monotonic()
            raise KeyboardInterrupt

    with pytest.raises(Stopped) as stopped:
        all_cases(work, workers=cases.Processes(2, apart=True), progress=stop)
    assert time.monotonic() - stopped_at < 2.0
    assert stopped.value.results == {}
    assert os.getpid() not in [process for _, process in work.lines("began")]
    assert not active_children()


def test_processes_apart_give_the_same_results(tmp_path):
    work = LoggedCases(str(tmp_path / "log"), 2, 0.0)
    assert [int(each["square"]) for each in all_cases(work, workers=cases.Processes(1, apart=True))] == [0, 1]
    assert {process for _, process in work.lines("began")} != {os.getpid()}
