"""Execution of independent cases in parallel processes of this machine.

Each process has a pipe of its own. Python's `ProcessPoolExecutor` shares one among all: a process killed while it writes a result
leaves half a message there, and the pool waits for the other half for ever.
"""

from __future__ import annotations

import queue
import signal
import threading
import traceback
import warnings
from collections import deque
from collections.abc import Iterator, Sequence
from contextlib import ExitStack, contextmanager, suppress
from dataclasses import dataclass
from multiprocessing import connection, get_context, reduction, resource_tracker
from os import _exit
from typing import TYPE_CHECKING, Any

from threadpoolctl import threadpool_limits

from stickslip.checks import fault
from stickslip.runs.work import Arrays, Keep, Progress, Work

if TYPE_CHECKING:
    from multiprocessing.context import SpawnProcess

POLL = 0.1
"""Seconds between two looks at the progress of the processes."""

_KILLED = "A process was killed while it computed {words}, which another one computes now. If memory ran out, take fewer workers."


@dataclass(frozen=True)
class Processes:
    """Cases in parallel processes of this machine; with one worker, runs in-process."""

    workers: int = 1

    def __post_init__(self) -> None:
        if type(self.workers) is bool or not hasattr(self.workers, "__index__") or self.workers < 1:
            raise fault("workers", "must be a whole number from 1 on", self.workers, "A cluster is a `DaskCluster`.")

    def compute(self, work: Work, cases: Sequence[int], keep: Keep, progress: Progress) -> None:
        workers = min(self.workers, len(cases))
        left = _side_by_side(work, cases, workers, keep, progress) if workers > 1 else cases
        _here(work, left, keep, _share_of(progress, len(cases) - len(left), len(cases)))


def _here(work: Work, cases: Sequence[int], keep: Keep, progress: Progress) -> None:
    """One case after the other in this process."""
    for number, case in enumerate(cases):

        def report(fraction: float, number: int = number, words: str = work.words[case]) -> None:
            progress((number + _fraction(fraction)) / len(cases), words)

        report(0.0)
        with threadpool_limits(1, user_api="blas"):
            arrays = work.solve(case, report)
        keep(case, arrays)


def _share_of(progress: Progress, done: int, total: int) -> Progress:
    return lambda fraction, text: progress((done + (total - done) * fraction) / total, text)


def _fraction(value: float) -> float:
    return min(max(value, 0.0), 1.0)


def _side_by_side(work: Work, cases: Sequence[int], workers: int, keep: Keep, progress: Progress) -> Sequence[int]:
    """Solve the cases by several processes; those that are left when all processes were killed.

    The case of a process that is killed goes to another one.
    """
    left, kept = deque(cases), 0
    fractions = get_context("spawn").RawArray("d", len(work.names))
    with _processes(work, fractions, workers) as free:
        busy: dict[connection.Connection, int] = {}
        while busy or (left and free):
            while left and free:
                pipe, case = free.pop(), left.popleft()
                busy[pipe] = case
                with suppress(OSError):
                    pipe.send(case)
            ready = connection.wait(list(busy), POLL)
            for pipe in [pipe for pipe in busy if pipe in ready]:
                case = busy.pop(pipe)
                try:
                    answer = pipe.recv()
                except (EOFError, OSError):
                    warnings.warn(_KILLED.format(words=work.words[case]), RuntimeWarning, stacklevel=2)
                    left.appendleft(case)
                    continue
                if isinstance(answer, Exception):
                    raise answer
                keep(case, answer)
                kept += 1
                free.append(pipe)
            done = sum(fractions[case] for case in cases) / len(cases)
            progress(max(done, kept / len(cases)), f"{kept} of {len(cases)} done, {len(busy) + len(free)} at once")
    return list(left)


@contextmanager
def _processes(work: Work, fractions: Any, count: int) -> Iterator[list[connection.Connection]]:
    """Fresh processes that solve the cases sent to them, as the pipes to them.

    They end when the block does or this process, whatever ends it, since each then finds its pipe closed. Each first receives the
    class of the work, whose modules it imports while this process compiles. The work follows when all have begun: a process takes
    large data only after its own start, for which the next one would have to wait.
    """
    context = get_context("spawn")
    data = reduction.ForkingPickler.dumps(work)
    with ExitStack() as ends:
        pipes = []
        with _interrupts_for_this_process_only():
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
        for pipe in pipes:
            with suppress(OSError):
                pipe.send_bytes(data)
        yield pipes


def _ended(process: SpawnProcess, pipe: connection.Connection) -> None:
    pipe.close()
    if process.pid is not None:
        process.join()


@contextmanager
def _interrupts_for_this_process_only() -> Iterator[None]:
    """Ctrl-C reaches every process of a terminal; those started in this block leave it to this one, which waits until they are.

    The mask alone would not do: a signal that another thread receives is handled in the main one all the same.
    """
    if not hasattr(signal, "pthread_sigmask"):
        yield
        return
    resource_tracker.ensure_running()  # it lets the signal through again when it starts
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


def _serve(fractions: Any, pipe: connection.Connection) -> None:
    """A process: solves the cases that come through the pipe after the class of the work and the work, until it closes."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    try:
        pipe.recv()
        work = pipe.recv()
    except (EOFError, OSError):
        return
    cases: queue.Queue[int] = queue.Queue()
    threading.Thread(target=_receive, args=(pipe, cases), daemon=True).start()
    with threadpool_limits(1, user_api="blas"), suppress(OSError):
        while True:
            pipe.send(_answer(work, cases.get(), fractions))


def _receive(pipe: connection.Connection, cases: queue.Queue[int]) -> None:
    """Pass on what comes through the pipe; when it closes, the process ends in the middle of whatever it does."""
    with suppress(EOFError, OSError):
        while True:
            cases.put(pipe.recv())
    _exit(1)


def _answer(work: Work, case: int, fractions: Any) -> Arrays | Exception:
    """The result of a case, or the error it ended with and where."""

    def report(fraction: float) -> None:
        fractions[case] = _fraction(fraction)

    try:
        arrays = work.solve(case, report)
    except Exception as error:
        error.add_note("In a process of its own:\n" + "".join(traceback.format_exception(error)))
        return error
    report(1.0)
    return arrays
