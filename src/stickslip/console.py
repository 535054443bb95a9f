"""Console output: progress with the remaining time, messages, and exit codes for errors."""

from __future__ import annotations

import _thread
import os
import signal
import sys
import threading
import warnings
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from functools import partial
from types import FrameType
from typing import Any

from rich.console import Console
from rich.progress import BarColumn, Progress, TaskProgressColumn, TextColumn, TimeElapsedColumn, TimeRemainingColumn

from stickslip.checks import Faults, InputError
from stickslip.compilation import NOTICE
from stickslip.notebook_bar import NotebookBar, in_notebook

Report = Callable[[float, str], None]
"""Called with the fraction done (0 to 1) and what is being done."""

RETRY_SECONDS = 0.05
"""After which a Ctrl-C that could not be passed on comes again."""

WRONG_INPUT, FAILED, INTERRUPTED, TERMINATED, INCOMPLETE = 2, 1, 130, 143, 3
"""Exit codes: wrong use or input; internal error; Ctrl-C; SIGTERM; computed, but a curve is incomplete."""


def say(message: str) -> None:
    """A line to the user."""
    _print(message, stderr=False)


def warn(message: str) -> None:
    """A line on the error stream."""
    _print(message, stderr=True)


def _print(message: str, stderr: bool) -> None:
    console = _console(stderr)
    try:
        console.print(message, markup=False, highlight=False, soft_wrap=True)
    except BrokenPipeError:  # of releases of rich that do not ask the console
        console.on_broken_pipe()


class _Console(Console):
    """Where nobody reads on, as behind `| head -1`, lines are dropped and the command does its work to the end."""

    def on_broken_pipe(self) -> None:
        nowhere = os.open(os.devnull, os.O_WRONLY)
        os.dup2(nowhere, self.file.fileno())
        os.close(nowhere)


def _console(stderr: bool) -> _Console:
    return _Console(stderr=stderr)


@contextmanager
def progress_bar(title: str) -> Iterator[Report]:
    """A bar with the remaining time, as long as a `with` block runs: in the cell of a notebook, or on a terminal's error stream.

    What it gives is the `progress` of an analysis:

        with stickslip.progress_bar("Forced response") as bar:
            response = stickslip.forced_response(problem, band, force, progress=bar)

    A notebook keeps the time that it took. Where nobody sees a bar, as in files of output, there is none.
    """
    console = _console(stderr=True)
    with _deferred_interrupts():
        if not in_notebook() and not console.is_terminal:
            yield lambda fraction, text: None
            return
        bar = NotebookBar() if in_notebook() else _terminal_bar(console)
        task: Any = bar.add_task(title, total=1.0)

        def report(fraction: float, text: str) -> None:
            bar.update(task, completed=min(max(fraction, 0.0), 1.0), description=f"{title}: {text}")

        NOTICE.command_bar = bar
        try:
            if isinstance(bar, Progress):
                bar.start()
            yield report
        finally:
            NOTICE.command_bar = None
            bar.update(task, description=title)
            bar.stop()


def _terminal_bar(console: Console) -> Progress:
    columns = (
        TextColumn("{task.description}"),
        BarColumn(),
        TaskProgressColumn(),
        TimeElapsedColumn(),
        TimeRemainingColumn(),
    )
    return Progress(*columns, console=console, transient=True)


def _in_compiler(frame: FrameType | None) -> bool:
    """Whether a frame was called by the compiler, whose callbacks cannot pass an exception on."""
    while frame is not None:
        if "llvmlite" in frame.f_code.co_filename:
            return True
        frame = frame.f_back
    return False


@contextmanager
def _deferred_interrupts() -> Iterator[None]:
    """Ctrl-C that cannot be passed on comes again a moment later, till it can.

    Callbacks of the compiler must not raise at all; from finalizers and callbacks of weak references Python drops an exception
    and reports it to `sys.unraisablehook` alone.
    """
    if threading.current_thread() is not threading.main_thread():
        yield
        return
    report_dropped = sys.unraisablehook

    def interrupt_later() -> None:
        # On Windows `os.kill` ends the process, whatever the signal; elsewhere it alone wakes a thread that waits.
        send = _thread.interrupt_main if os.name == "nt" else partial(os.kill, os.getpid(), signal.SIGINT)
        again = threading.Timer(RETRY_SECONDS, send)
        again.daemon = True
        again.start()

    def handle(number: int, frame: FrameType | None) -> None:
        if not _in_compiler(frame):
            raise KeyboardInterrupt
        interrupt_later()

    def dropped(unraisable: sys.UnraisableHookArgs) -> None:
        if issubclass(unraisable.exc_type, KeyboardInterrupt):
            interrupt_later()
        else:
            report_dropped(unraisable)

    before = signal.signal(signal.SIGINT, handle)
    sys.unraisablehook = dropped
    try:
        yield
    finally:
        sys.unraisablehook = report_dropped
        signal.signal(signal.SIGINT, before)


@contextmanager
def plain_warnings() -> Iterator[None]:
    """Warnings while the block runs as one sentence on the error stream, without their place in the program."""

    def show(message: Warning | str, *place: Any, **more: Any) -> None:
        warn(f"Warning: {message}")

    with warnings.catch_warnings():
        warnings.showwarning = show
        yield


@contextmanager
def termination_as_interrupt() -> Iterator[threading.Event]:
    """SIGTERM, which batch systems, containers and `timeout` send, acts as Ctrl-C while the block runs; whether it came.

    It does so too where SIGINT is ignored, as in the background of a shell script.
    """
    received = threading.Event()
    if threading.current_thread() is not threading.main_thread():
        yield received
        return

    def handle(number: int, frame: FrameType | None) -> None:
        received.set()
        as_ctrl_c = signal.getsignal(signal.SIGINT)
        if callable(as_ctrl_c):
            as_ctrl_c(signal.SIGINT, frame)
        else:
            raise KeyboardInterrupt

    before = signal.signal(signal.SIGTERM, handle)
    try:
        yield received
    finally:
        signal.signal(signal.SIGTERM, before)


def report_fault(error: BaseException) -> int:
    """Report an error; returns the exit code."""
    match error:
        case KeyboardInterrupt():
            warn("Interrupted; no file is incomplete.")
            return INTERRUPTED
        case Faults(faults=faults) if len(faults) > 1:
            warn(
                f"{len(faults)} faults:\n" + "\n".join(f"  {number}. {message}" for number, message in enumerate(faults, start=1))
            )
            return WRONG_INPUT
        case InputError():
            warn(f"Error: {error}")
            return WRONG_INPUT
        case ConnectionError():
            warn(f"Error: the connection broke: {error}")
            return FAILED
        case OSError():
            place = f" ({error.filename})" if error.filename else ""
            warn(f"Error: a file cannot be accessed{place}: {error.strerror or error}.")
            return WRONG_INPUT
        case MemoryError():
            warn("Error: out of memory. Reduce the number of harmonics, samples, points, draws or degrees of freedom.")
            return FAILED
        case _:
            what = f"{type(error).__name__}: {error}"
            warn(f"Error inside stickslip ({what}). Please report it with the output of `stickslip --debug ...`.")
            return FAILED
