"""Many independent cases, each kept as it finishes: the one loop of the analyses.

An analysis states its work as data (`Work`); what a case gives are plain arrays, which travel between machines and to disk. An
`Executor` computes them: this process, several of this machine, or a cluster (`dask_cluster.py`).
"""

from __future__ import annotations

import signal
import threading
from collections.abc import Callable, Iterator, Mapping, Sequence
from concurrent.futures import FIRST_COMPLETED, Future, ProcessPoolExecutor, wait
from concurrent.futures.process import BrokenProcessPool
from contextlib import contextmanager, suppress
from dataclasses import dataclass
from multiprocessing import get_context
from multiprocessing.connection import Connection
from os import _exit
from typing import Any, Protocol, runtime_checkable

from numpy.typing import NDArray
from threadpoolctl import threadpool_limits

from stickslip.checks import fault

Arrays = Mapping[str, NDArray[Any]]
Progress = Callable[[float, str], None]
Tell = Callable[[float], None]
"""Called with the fraction of a case that is done."""
Keep = Callable[[int, Arrays], None]
"""Called with a case and its result as soon as it is solved."""

POLL = 0.1
"""Seconds between two looks at the progress of the processes."""


class Work(Protocol):
    """Work in independent cases. It travels to processes, so it holds data and rebuilds there what it needs."""

    @property
    def names(self) -> Sequence[str]:
        """One name per case, unique and complete: equal names mean equal results."""

    @property
    def words(self) -> Sequence[str]:
        """What each case is, for people."""

    def prepare(self) -> None:
        """Compile what the processes then load, once."""

    def solve(self, case: int, tell: Tell) -> Arrays:
        """The result of a case."""


class Finished(Protocol):
    """Keeps results of finished cases, so that an interrupted analysis goes on where it stopped."""

    def load(self, name: str) -> Arrays | None:
        """The kept result, or None."""

    def save(self, name: str, arrays: Arrays) -> None:
        """Keep a result; when this returns, it is safe."""


@runtime_checkable
class Executor(Protocol):
    """Computes independent cases somewhere. Each is solved alone with one BLAS thread: the results do not depend on where."""

    def compute(self, work: Work, cases: Sequence[int], keep: Keep, progress: Progress) -> None:
        """Solve the cases in any order; each is handed to `keep`, in this process, as soon as it is solved."""


Workers = int | Executor
"""Where cases are computed: by as many processes of this machine, or by an executor."""


def all_cases(
    work: Work,
    finished: Finished | None = None,
    workers: Workers = 1,
    progress: Progress = lambda fraction, text: None,
) -> list[Arrays]:
    """The results of all cases in order: those kept by `finished`, and the others computed."""
    executor = workers if isinstance(workers, Executor) else Processes(workers)
    results = {} if finished is None else _kept(work, finished)
    missing = [case for case in range(len(work.names)) if case not in results]

    def keep(case: int, arrays: Arrays) -> None:
        if finished is not None:
            finished.save(work.names[case], arrays)
        results[case] = arrays

    executor.compute(work, missing, keep, progress)
    return [results[case] for case in range(len(work.names))]


def _kept(work: Work, finished: Finished) -> dict[int, Arrays]:
    found = {case: finished.load(name) for case, name in enumerate(work.names)}
    return {case: arrays for case, arrays in found.items() if arrays is not None}


@dataclass(frozen=True)
class Processes:
    """Cases side by side in processes of this machine; one alone is this process."""

    workers: int = 1

    def __post_init__(self) -> None:
        if type(self.workers) is bool or not hasattr(self.workers, "__index__") or self.workers < 1:
            raise fault("workers", "must be a whole number from 1 on", self.workers, "A cluster is a `DaskCluster`.")

    def compute(self, work: Work, cases: Sequence[int], keep: Keep, progress: Progress) -> None:
        workers = min(self.workers, len(cases))
        if workers > 1:
            _by_processes(work, cases, workers, keep, progress)
        else:
            _here(work, cases, keep, progress)


def _here(work: Work, missing: Sequence[int], keep: Keep, progress: Progress) -> None:
    """One case after the other in this process."""
    for number, case in enumerate(missing):

        def tell(fraction: float, number: int = number, words: str = work.words[case]) -> None:
            progress((number + min(max(fraction, 0.0), 1.0)) / len(missing), words)

        tell(0.0)
        with threadpool_limits(1, user_api="blas"):
            arrays = work.solve(case, tell)
        keep(case, arrays)


def _by_processes(work: Work, missing: Sequence[int], workers: int, keep: Keep, progress: Progress) -> None:
    """Cases side by side. When a process is killed, its case and those not begun are computed by fewer, at last by this one."""
    work.prepare()
    left = list(missing)

    def keep_and_strike(case: int, arrays: Arrays) -> None:
        keep(case, arrays)
        left.remove(case)

    while workers > 1 and left:
        done = len(missing) - len(left)
        try:
            _pool(work, left.copy(), workers, keep_and_strike, _share_of(progress, done, len(missing)))
        except BrokenProcessPool:
            workers //= 2
    _here(work, left.copy(), keep_and_strike, _share_of(progress, len(missing) - len(left), len(missing)))


def _share_of(progress: Progress, done: int, total: int) -> Progress:
    return lambda fraction, text: progress((done + (total - done) * fraction) / total, text)


def _pool(work: Work, cases: Sequence[int], workers: int, keep: Keep, progress: Progress) -> None:
    """One pool of fresh processes; they end when this process does, whatever ends it, since each holds the end of a pipe."""
    context = get_context("spawn")
    fractions = context.RawArray("d", len(work.names))
    lifeline, held = context.Pipe(duplex=False)
    with _interrupts_for_this_process_only():
        executor = ProcessPoolExecutor(workers, context, _begin, (work, fractions, lifeline))
        futures: dict[Future[Arrays], int] = {executor.submit(_solve, case): case for case in cases}
    try:
        pending = set(futures)
        while pending:
            done, pending = wait(pending, POLL, FIRST_COMPLETED)
            for future in done:
                keep(futures[future], future.result())
            finished = len(cases) - len(pending)
            total = sum(fractions[case] for case in cases) / len(cases)
            progress(max(total, finished / len(cases)), f"{finished} of {len(cases)} done, {workers} at once")
    finally:
        held.close()
        executor.shutdown(wait=True, cancel_futures=True)


@contextmanager
def _interrupts_for_this_process_only() -> Iterator[None]:
    """Ctrl-C reaches every process of a terminal; those started in this block leave it to this one, which waits until they are.

    The mask alone would not do: a signal that another thread receives is handled in the main one all the same.
    """
    if not hasattr(signal, "pthread_sigmask"):
        yield
        return
    here = threading.current_thread() is threading.main_thread()
    met = threading.Event()
    handler = signal.signal(signal.SIGINT, lambda number, frame: met.set()) if here else None
    before = signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT})
    try:
        yield
    finally:
        signal.pthread_sigmask(signal.SIG_SETMASK, before)
        if here:
            signal.signal(signal.SIGINT, handler)
        if met.is_set():
            signal.raise_signal(signal.SIGINT)


_process: dict[str, Any] = {}
"""In a worker process: its work, and where it writes its progress."""


def _begin(work: Work, fractions: Any, lifeline: Connection) -> None:
    """Start of a worker process."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    threading.Thread(target=_end_with_parent, args=(lifeline,), daemon=True).start()
    threadpool_limits(1, user_api="blas")
    _process.update(work=work, fractions=fractions)


def _end_with_parent(lifeline: Connection) -> None:
    """Wait until the other end of the pipe closes, which it does at the latest with the process that holds it."""
    with suppress(EOFError, OSError):
        lifeline.recv_bytes()
    _exit(1)


def _solve(case: int) -> Arrays:
    def tell(fraction: float) -> None:
        _process["fractions"][case] = min(max(fraction, 0.0), 1.0)

    arrays: Arrays = _process["work"].solve(case, tell)
    tell(1.0)
    return arrays


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
        """As the first work does."""
        next(iter(self.works.values())).prepare()

    def solve(self, case: int, tell: Tell) -> Arrays:
        label, own = self.places[case]
        return self.works[label].solve(own, tell)

    def parted(self, results: Sequence[Arrays]) -> dict[str, list[Arrays]]:
        """The results of each work."""
        parts: dict[str, list[Arrays]] = {label: [] for label in self.works}
        for (label, _), arrays in zip(self.places, results, strict=True):
            parts[label].append(arrays)
        return parts
