"""Console output: progress with the remaining time, messages, and exit codes for errors."""

import os
import warnings
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from time import monotonic
from typing import Any

from rich.console import Console
from rich.progress import BarColumn, Progress, TaskProgressColumn, TextColumn, TimeElapsedColumn, TimeRemainingColumn

from stickslip.support.checks import Faults, InputError
from stickslip.support.compilation import EVERY, NOTICE, NotebookBar, in_notebook
from stickslip.support.interrupts import deferred, is_behind

Report = Callable[[float, str], None]
"""Called with the fraction done (0 to 1) and what is being done."""

LEAST_KNOWN = 0.02
"""Share of the work below which the remaining time is anybody's guess."""
UNKNOWN = "the remaining time is unknown"
STANDING = 0.05
"""Share of what was done at all below which the second half of the time brought nothing; at a steady pace it brings half."""
CONTROLS = {code: "\ufffd" for code in (*range(32), *range(127, 160)) if chr(code) not in "\t\n"}
"""Characters that command a terminal, which titles and names of a foreign file may hold, and what is printed in their place."""
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
    message = message.translate(CONTROLS)
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


def progress_is_seen() -> bool:
    """Whether anybody sees a bar: in the cell of a notebook, or on a terminal."""
    return in_notebook() or _console(stderr=True).is_terminal


@contextmanager
def progress_bar(title: str, remedy: str = "") -> Iterator[Report]:
    """A bar with the remaining time, as long as a `with` block runs: in the cell of a notebook, or on a terminal's error stream.

    What it gives is the `progress` of an analysis:

        with stickslip.progress_bar("Forced response") as bar:
            response = stickslip.forced_response(problem, band, force, progress=bar)

    A notebook keeps the time that it took. Where nobody sees a bar, as in files of output, a line takes its place every ten
    seconds, later every half minute, which names the `remedy` where a curve does not advance.
    """
    console = _console(stderr=True)
    with deferred():
        if not progress_is_seen():
            yield _lines(title, remedy)
            return
        columns = TextColumn("{task.description}"), BarColumn(), TaskProgressColumn(), TimeElapsedColumn(), TimeRemainingColumn()
        bar = NotebookBar() if in_notebook() else Progress(*columns, console=console, transient=True)
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


def _lines(title: str, remedy: str) -> Report:
    """Progress in lines on the error stream, for files of output: what is done and the remaining time."""
    began = said = monotonic()
    known = [(began, 0.0)]

    def report(fraction: float, text: str) -> None:
        nonlocal said
        now = monotonic()
        if now - said < min(EVERY, max(EVERY / 3.0, (now - began) / EVERY)):
            return
        said = now
        if fraction < known[-1][1]:  # another part of the work begins, such as the curves after their first solutions
            known[:] = [(known[-1][0], 0.0)]
        known.append((now, fraction))
        warn(
            f"{title}: {text}: {100.0 * min(max(fraction, 0.0), 1.0):.0f} % after {_duration(now - began)}{_left(known, remedy)}"
        )

    return report


def _left(known: Sequence[tuple[float, float]], remedy: str) -> str:
    """The remaining time at the pace of the second half of the time so far, from times in seconds with the share that was done;
    curves that fold many times stand at one share for long."""
    (began, _), (now, fraction) = known[0], known[-1]
    half, before = next(pair for pair in reversed(known) if pair[0] <= 0.5 * (began + now))
    if fraction <= LEAST_KNOWN:
        return ""
    if fraction - before < STANDING * fraction:
        since = next(time for time, share in known if fraction - share < STANDING * fraction)
        return f", no progress for {_duration(now - since)}: {UNKNOWN}{remedy and f'; {remedy}'}"
    return f", about {_duration((now - half) * (1.0 - fraction) / (fraction - before))} left"


def _duration(seconds: float) -> str:
    """Seconds below two minutes, then minutes, then hours."""
    if seconds < 120.0:
        return f"{seconds:.0f} s"
    return f"{seconds / 60.0:.0f} min" if seconds < 7200.0 else f"{seconds / 3600.0:.1f} h"


@contextmanager
def plain_warnings() -> Iterator[None]:
    """Warnings while the block runs as one sentence on the error stream, without their place in the program."""

    def show(message: Warning | str, *place: Any, **more: Any) -> None:
        warn(f"Warning: {message}")

    with warnings.catch_warnings():
        warnings.showwarning = show
        yield


def report_fault(error: BaseException) -> int:
    """Report an error; returns the exit code."""
    match error:
        case KeyboardInterrupt():
            warn("Interrupted. All files written so far are complete.")
            return INTERRUPTED
        case Faults(faults=faults) if len(faults) > 1:
            warn(
                f"{len(faults)} errors:\n" + "\n".join(f"  {number}. {message}" for number, message in enumerate(faults, start=1))
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
        case _ if is_behind(error):
            return report_fault(KeyboardInterrupt())
        case _:
            what = f"{type(error).__name__}: {error}"
            warn(f"Error inside stickslip ({what}). Please report it with the output of `stickslip --debug ...`.")
            return FAILED
