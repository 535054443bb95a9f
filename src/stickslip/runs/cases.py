"""The common loop of all analyses over independent cases; completed cases go into the checkpoint.

An `Executor` computes them: this process or several of this machine (`Processes`), or a cluster (`dask_cluster.py`).

Of those that work in parallel this process solves cases too, in a thread: it has its modules and kernels already, so that work
begins while the others start.

Each place has a pipe of its own. Python's `ProcessPoolExecutor` shares one among all: a process killed while it writes a
result leaves half a message there, and the pool waits for the other half for ever.

Interfaces of analyses with independent cases: the work, its executor and its checkpoint.

What a case gives are plain arrays, which travel between machines and to disk.

Checkpoints: one file per completed case beside the results, from which an interrupted run resumes.

Plain NumPy archives without pickle, each written beside its place and renamed.
"""

import json
import os
import queue
import secrets
import signal
import threading
import traceback
import warnings
import zipfile
import zlib
from collections import deque
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import ExitStack, contextmanager, nullcontext, suppress
from dataclasses import dataclass
from functools import partial
from hashlib import sha256
from itertools import zip_longest
from multiprocessing import connection, current_process, get_context, reduction
from multiprocessing.context import SpawnProcess
from pathlib import Path
from time import monotonic
from typing import Any, Protocol, runtime_checkable

import numpy as np
from numpy.typing import NDArray

from stickslip.model.readers import numpy_archive
from stickslip.support.checks import InputError, fault
from stickslip.support.files import WrittenFiles, only_own_files, write_arrays, write_text
from stickslip.support.interrupts import for_this_process_only, raise_in, raised_again
from stickslip.support.late import xr
from stickslip.support.machine import one_blas_thread

Arrays = Mapping[str, NDArray[Any]]
Progress = Callable[[float, str], None]
Report = Callable[[float], None]
"""Called with the fraction of a case that is done."""
Keep = Callable[[int, Arrays], None]
"""Called with a case and its result as soon as it is solved."""


class CaseStopped(KeyboardInterrupt):
    """Ctrl-C in the middle of a case, with what there is of its result."""

    @property
    def arrays(self) -> Arrays:
        return self.args[0]  # type: ignore[no-any-return]


class Stopped(KeyboardInterrupt):
    """Ctrl-C while cases are computed, with the results there are, by case: also those of unfinished cases that are of use."""

    @property
    def results(self) -> Mapping[int, Arrays]:
        return self.args[0]  # type: ignore[no-any-return]


class Work(Protocol):
    """Work in independent cases. It travels to processes, so it holds data and rebuilds there what it needs."""

    @property
    def names(self) -> Sequence[str]:
        """One name per case, unique and complete: equal names mean equal results."""

    @property
    def words(self) -> Sequence[str]:
        """Names of the cases, for messages."""

    def prepare(self) -> None:
        """What is done once, before the work travels: compile what processes then load, find what all cases share."""

    def solve(self, case: int, report: Report) -> Arrays:
        """The result of a case."""


@runtime_checkable
class StoppableWork(Work, Protocol):
    """Work whose results are of use although some cases are missing or, after `CaseStopped`, unfinished."""

    def so_far(self, results: Mapping[int, Arrays]) -> "xr.Dataset":
        """The labelled results of some cases."""


@runtime_checkable
class Checkpoint(Protocol):
    """Keeps the results of completed cases, so that an interrupted analysis can resume."""

    def load(self, name: str) -> Arrays | None:
        """The kept result, or None."""

    def save(self, name: str, arrays: Arrays) -> None:
        """Keep a result; when this returns, it is safe."""


@runtime_checkable
class Executor(Protocol):
    """Computes independent cases somewhere. Each is solved alone with one BLAS thread: the results do not depend on where."""

    def compute(self, work: Work, cases: Sequence[int], keep: Keep, progress: Progress) -> None:
        """Solve the cases in any order; each is handed to `keep`, in this process, as soon as it is solved."""


def silent(share: float, text: str) -> None:
    """Progress that nobody watches."""


def checked_progress(progress: Progress) -> Progress:
    """`progress`, refused unless it can be called."""
    if not callable(progress):
        raise fault("progress", "must be a function of the share done and a text", progress)
    return progress


Workers = int | Executor
"""Where cases are computed: by as many processes of this machine, or by an executor."""


ABOUT = "about.json"
_NAME = "__name__"


def changed_line(before: str, now: str) -> str:
    """The first line in which two texts of several lines differ, in brackets; "" where there is none."""
    if "\n" not in before or "\n" not in now:
        return ""
    pairs = zip_longest(before.splitlines(), now.splitlines(), fillvalue="")
    for line, (old, new) in enumerate(pairs, 1):
        if old.strip() != new.strip():
            return f" (line {line}: {new.strip()!r} now, {old.strip()!r} then)"
    return ""


class CheckpointFolder:
    """Results of completed cases as files of one folder. Of what is in the folder, only what was written here is removed.

    about: what the cases were computed from, as short texts ({"study": ..., "version": ...}); a folder that was filled from
    something else is refused. Names of cases should say all that a case depends on.

    >>> import stickslip as ss
    >>> rig = ss.rigs.single_mass()
    >>> kept = ss.CheckpointFolder("results/mass/unfinished")             # doctest: +SKIP
    >>> ss.forced_response(rig, ss.hertz(0.1, 0.3), [1, 2], checkpoint=kept)  # doctest: +SKIP
    """

    def __init__(self, folder: str | Path, about: Mapping[str, str] | None = None) -> None:
        self.folder, self.about = Path(folder), dict(about or {})
        changed = self._changed()
        if changed:
            raise InputError(
                f"The checkpoint in {str(self.folder)!r} must belong to this run, but {' and '.join(changed)} changed since. "
                "Compute from the start (on the command line with --overwrite instead of --resume), or use another folder."
            )

    def _changed(self) -> list[str]:
        """What the folder was filled from that is not so any more."""
        try:
            before = json.loads((self.folder / ABOUT).read_text(encoding="utf-8"))
        except (OSError, ValueError):
            return []
        if not isinstance(before, dict):
            return []
        return [
            f"the {key}{changed_line(str(before.get(key, '')), self.about.get(key, ''))}"
            for key in sorted({*before, *self.about})
            if before.get(key) != self.about.get(key)
        ]

    def __len__(self) -> int:
        """How many cases are kept."""
        return self.count(self.folder)

    @staticmethod
    def count(folder: Path) -> int:
        """How many cases a folder keeps, of whatever run."""
        return sum(
            name.endswith(".npz") and not name.startswith(".") and (folder / name).is_file()
            for name in WrittenFiles(folder).entries()
        )

    def load(self, name: str) -> dict[str, NDArray[Any]] | None:
        """The arrays of a case; None when it is not kept, or its file is damaged or unpacks to more than it can hold: then
        it is computed again."""
        try:
            arrays = numpy_archive.arrays(self._path(name))
        except (OSError, ValueError, EOFError, KeyError, NotImplementedError, zipfile.BadZipFile, zlib.error):
            return None
        return arrays if str(arrays.pop(_NAME, "")) == name else None

    def save(self, name: str, arrays: Mapping[str, NDArray[Any]]) -> None:
        """Keep the arrays of a case; they are on the disk when this returns."""
        about, path = self.folder / ABOUT, self._path(name)
        if os.path.lexists(path) and not WrittenFiles(self.folder).has(path):  # damaged, or put there by somebody
            path.rename(path.with_suffix(f".{secrets.token_hex(4)}.damaged"))
        with only_own_files():
            if not about.exists():
                write_text(about, json.dumps(self.about, indent=1))
            write_arrays(path, {_NAME: np.array(name), **arrays})

    @staticmethod
    def remove(folder: Path) -> list[Path]:
        """Remove what was written into a checkpoint and the folders in it; returns what is left.

        What the cases were computed from goes last, so that no half of a checkpoint can be taken for that of another run.
        """
        inside = sorted(path for path in folder.iterdir() if path.is_dir()) if folder.is_dir() and not folder.is_symlink() else []
        left = [path for each in inside for path in WrittenFiles(each).remove_all()]
        return [path for path in WrittenFiles(folder).remove_all(last=(ABOUT,)) if path not in inside] + left

    def _path(self, name: str) -> Path:
        return self.folder / f"{sha256(name.encode()).hexdigest()[:24]}.npz"


POLL = 0.1
"""Seconds between two looks at the progress of the processes."""

STOP, GRACE = -1, 30.0
"""What stops a process in the middle of its case, and seconds in which it may then answer with what there is of the result."""

_SAFE_PATH = "PYTHONSAFEPATH"
"""The variable by which a process of Python keeps the folder in which it starts off its import path."""
_STARTING = threading.Lock()

_KILLED = "A process was killed while it computed {words}, which is computed again. If memory ran out, take fewer workers."
_NOT_STARTED = (
    "A process ended while it started; the cases are computed without it. If memory ran out, take fewer workers. "
    "In a script of your own put the work under `if __name__ == '__main__':`."
)


@dataclass(frozen=True)
class Processes:
    """Cases in parallel, by this process and `workers - 1` others of this machine.

    apart: by `workers` others alone. This process then answers Ctrl-C at once, whatever they are in the middle of, and ends them:
    for cases that stay in one call of a library for minutes, and of which no part is of use.
    """

    workers: int = 1
    apart: bool = False

    def __post_init__(self) -> None:
        if type(self.workers) is bool or not hasattr(self.workers, "__index__") or self.workers < 1:
            raise fault("workers", "must be a whole number from 1 on", self.workers, "A cluster is a `DaskCluster`.")

    def compute(self, work: Work, cases: Sequence[int], keep: Keep, progress: Progress) -> None:
        workers = min(self.workers, len(cases))
        if workers > 1 or (self.apart and cases):
            _side_by_side(work, cases, workers, keep, progress, self.apart)
        else:
            _here(work, cases, keep, progress)


def _here(work: Work, cases: Sequence[int], keep: Keep, progress: Progress) -> None:
    """One case after the other in this process."""
    for number, case in enumerate(cases):

        def report(fraction: float, number: int = number, words: str = work.words[case]) -> None:
            progress((number + _fraction(fraction)) / len(cases), words)

        report(0.0)
        try:
            with one_blas_thread():
                arrays = work.solve(case, report)
        except CaseStopped as stop:
            raise Stopped({case: stop.arrays}) from stop
        keep(case, arrays)


def _fraction(value: float) -> float:
    return min(max(value, 0.0), 1.0)


def _side_by_side(work: Work, cases: Sequence[int], workers: int, keep: Keep, progress: Progress, apart: bool) -> None:
    """Solve the cases in several places at once. The case of a process that is killed goes to another place.

    A process takes a case when it has begun, so that cases that are done by then never wait for it.
    """
    left, kept = deque(cases), 0
    fractions = get_context("spawn").RawArray("d", len(work.names))
    with (
        _processes(work, workers if apart else workers - 1, fractions) as started,
        nullcontext((None, None)) if apart else _thread(work, fractions) as (here, interrupt_here),
    ):
        busy: dict[connection.Connection, int | None] = dict.fromkeys(started)
        free = [] if here is None else [here]
        try:
            while kept < len(cases):
                if not (busy or free):  # none of the processes could start
                    return _here(work, list(left), keep, progress)
                while left and free:
                    pipe, case = free.pop(), left.popleft()
                    busy[pipe] = case
                    with suppress(OSError):
                        pipe.send(case)
                ready = connection.wait(list(busy), POLL)
                for pipe in [pipe for pipe in busy if pipe in ready]:
                    done = busy.pop(pipe)
                    try:
                        answer = pipe.recv()
                    except (EOFError, OSError):
                        what = _NOT_STARTED if done is None else _KILLED.format(words=work.words[done])
                        warnings.warn(what, RuntimeWarning, stacklevel=2)
                        left.extendleft([] if done is None else [done])
                        continue
                    if isinstance(answer, Exception):
                        raise answer
                    free.append(pipe)
                    if done is not None:
                        keep(done, answer)
                        kept += 1
                share = sum(fractions[case] for case in cases) / len(cases)
                at_once = len(free) + sum(case is not None for case in busy.values())
                progress(max(share, kept / len(cases)), f"{kept} of {len(cases)} done, {at_once} at once")
        except KeyboardInterrupt as stop:
            if apart:
                raise
            for pipe in busy:
                if pipe is here and interrupt_here is not None:
                    interrupt_here(KeyboardInterrupt)
                else:
                    with suppress(OSError):
                        pipe.send(STOP)
            raise Stopped(_unfinished(busy)) from stop


def _unfinished(busy: Mapping[connection.Connection, int | None]) -> dict[int, Arrays]:
    """What the places have of the cases in whose middle they were interrupted."""
    results: dict[int, Arrays] = {}
    waiting, until = {pipe: case for pipe, case in busy.items() if case is not None}, monotonic() + GRACE
    while waiting and (ready := connection.wait(list(waiting), max(until - monotonic(), 0.0))):
        for pipe in [pipe for pipe in waiting if pipe in ready]:
            case = waiting.pop(pipe)
            with suppress(EOFError, OSError):
                answer = pipe.recv()
                if isinstance(answer, CaseStopped):
                    results[case] = answer.arrays
                elif isinstance(answer, Mapping):  # completed at the same time
                    results[case] = answer
    return results


@contextmanager
def _thread(work: Work, fractions: Any) -> Iterator[tuple[connection.Connection, Callable[[type[BaseException]], None]]]:
    """A thread of this process that solves the cases sent to it, as the pipe to it and what raises an exception in it.

    An error in the block ends it in the middle of a case: between two instructions of Python, where Ctrl-C acts as well.
    """
    here, there = get_context("spawn").Pipe()

    def serve() -> None:
        # Interrupted in the middle of an answer, it closes the pipe: the other end would wait for the rest of it for ever.
        with there, suppress(EOFError, OSError, SystemExit, KeyboardInterrupt):
            while True:
                there.send(_answer(work, there.recv(), fractions))

    thread = threading.Thread(target=serve, name="stickslip cases")
    with one_blas_thread():
        thread.start()
        try:
            yield here, partial(raise_in, thread)
        except BaseException:
            raise_in(thread, SystemExit)
            raise
        finally:
            here.close()
            thread.join()


@contextmanager
def _processes(work: Work, count: int, fractions: Any) -> Iterator[list[connection.Connection]]:
    """Fresh processes that solve the cases sent to them, as the pipes to them. Each sends None when it has begun.

    They end when the block does or this process, whatever ends it, since each then finds its pipe closed. Each first receives the
    class of the work, whose modules it imports while this one prepares the work. That follows when all have begun: a process
    takes large data only after its own start, for which the next one would have to wait.
    """
    if getattr(current_process(), "_inheriting", False):
        raise SystemExit  # a process that imports a script without the guard; the one that started it says so
    context = get_context("spawn")
    with ExitStack() as ends:
        pipes = []
        with _safe_paths(), for_this_process_only():
            for _ in range(count):
                here, there = context.Pipe()
                process = context.Process(target=_serve, args=(fractions, there))
                ends.callback(_ended, process, here)
                process.start()
                there.close()
                pipes.append(here)
                with suppress(OSError):
                    here.send(type(work))
        work.prepare()
        data = reduction.ForkingPickler.dumps(work)
        for pipe in pipes:
            with suppress(OSError):
                pipe.send_bytes(data)
        yield pipes


@contextmanager
def _safe_paths() -> Iterator[None]:
    """Processes of Python that are started in this block import nothing from the working folder, which may be that of a model.

    Multiprocessing starts them and its resource tracker by `python -c`, which has the working folder first on the import path
    until the path of this process arrives. One thread at a time: another's end would take the variable away.
    """
    with _STARTING:
        before = os.environ.get(_SAFE_PATH)
        try:
            os.environ[_SAFE_PATH] = "1"
            yield
        finally:
            if before is None:
                os.environ.pop(_SAFE_PATH, None)
            else:
                os.environ[_SAFE_PATH] = before


def _ended(process: SpawnProcess, pipe: connection.Connection) -> None:
    pipe.close()
    if process.pid is not None:
        process.terminate()  # it may still be importing
        process.join()


def _serve(fractions: Any, pipe: connection.Connection) -> None:
    """A process: solves the cases that come through the pipe after the class of the work and the work, until it closes."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    try:
        pipe.recv()
        work = pipe.recv()
    except (EOFError, OSError):
        return
    cases: queue.Queue[int] = queue.Queue()
    with suppress(OSError, KeyboardInterrupt), raised_again(), one_blas_thread():
        threading.Thread(target=_receive, args=(pipe, cases), daemon=True).start()  # STOP may have come before the first case
        pipe.send(None)
        while True:
            pipe.send(_answer(work, cases.get(), fractions))


def _receive(pipe: connection.Connection, cases: queue.Queue[int]) -> None:
    """Pass on what comes through the pipe; when it closes, the process ends in the middle of whatever it does."""
    with suppress(EOFError, OSError):
        while True:
            case = pipe.recv()
            if case == STOP:
                raise_in(threading.main_thread(), KeyboardInterrupt)
            else:
                cases.put(case)
    os._exit(1)


def _answer(work: Work, case: int, fractions: Any) -> Arrays | Exception | CaseStopped:
    """The result of a case, or what there is of it after Ctrl-C, or the error it ended with and where."""

    def report(fraction: float) -> None:
        fractions[case] = _fraction(fraction)

    try:
        arrays = work.solve(case, report)
    except CaseStopped as stop:
        return CaseStopped(stop.arrays)
    except Exception as error:
        error.add_note("Where it was computed:\n" + "".join(traceback.format_exception(error)))
        return error
    report(1.0)
    return arrays


def all_cases(
    work: Work, checkpoint: Checkpoint | None = None, workers: Workers = 1, progress: Progress = lambda fraction, text: None
) -> list[Arrays]:
    """The results of all cases in order: those kept by `checkpoint`, and the others computed. Ctrl-C raises `Stopped`."""
    executor = workers if isinstance(workers, Executor) else Processes(workers)
    if checkpoint is not None and not isinstance(checkpoint, Checkpoint):
        raise fault("checkpoint", "must be a CheckpointFolder, or have its load and save", checkpoint)
    checked_progress(progress)
    results = {} if checkpoint is None else _kept(work, checkpoint)
    missing = [case for case in range(len(work.names)) if case not in results]

    def keep(case: int, arrays: Arrays) -> None:
        if checkpoint is not None:
            checkpoint.save(work.names[case], arrays)
        results[case] = arrays

    try:
        executor.compute(work, missing, keep, progress)
    except KeyboardInterrupt as stop:
        unfinished = stop.results if isinstance(stop, Stopped) else {}
        raise Stopped({**results, **unfinished}) from stop
    return [results[case] for case in range(len(work.names))]


def _kept(work: Work, checkpoint: Checkpoint) -> dict[int, Arrays]:
    found = {case: checkpoint.load(name) for case, name in enumerate(work.names)}
    return {case: arrays for case, arrays in found.items() if arrays is not None}


@dataclass(frozen=True, eq=False)
class Together:
    """Several works by name as one, so that all their cases share the processes."""

    works: Mapping[str, Work]

    @property
    def places(self) -> list[tuple[str, int]]:
        """Work and case of each case of the whole."""
        return [(label, case) for label, work in self.works.items() for case in range(len(work.names))]

    @property
    def names(self) -> list[str]:
        return [f"{label}: {self.works[label].names[case]}" for label, case in self.places]

    @property
    def words(self) -> list[str]:
        return [f"{label} {self.works[label].words[case]}".strip() for label, case in self.places]

    def prepare(self) -> None:
        """As every work does."""
        for work in self.works.values():
            work.prepare()

    def solve(self, case: int, report: Report) -> Arrays:
        label, own = self.places[case]
        return self.works[label].solve(own, report)

    def parted(self, results: Mapping[int, Arrays]) -> dict[str, dict[int, Arrays]]:
        """The results of each work by its cases, of all cases or of some."""
        parts: dict[str, dict[int, Arrays]] = {label: {} for label in self.works}
        for number, (label, case) in enumerate(self.places):
            if number in results:
                parts[label][case] = results[number]
        return parts
