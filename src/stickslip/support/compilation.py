"""What a user sees while kernels are compiled: a bar in a terminal or a notebook, else one sentence in the log.

Bars in the output of a notebook's cell, by the display messages that every front end of Jupyter knows: no widgets.
"""

import html
import logging
import math
import multiprocessing
import sys
import time
from contextlib import suppress
from datetime import timedelta
from typing import TYPE_CHECKING, Any

from stickslip.support.checks import counted

if TYPE_CHECKING:
    from rich.progress import Progress

SECONDS = 0.1
"""Least time between two pictures of a bar."""


def in_notebook() -> bool:
    """Whether this process is the kernel of a notebook; IPython in a terminal is none."""
    shell = getattr(sys.modules.get("IPython"), "get_ipython", lambda: None)()
    return getattr(shell, "kernel", None) is not None


class NotebookBar:
    """Tasks with a bar each, in one output of the cell that runs; the methods are those of `rich.progress.Progress`."""

    def __init__(self) -> None:
        self._tasks: dict[int, dict[str, Any]] = {}
        self._added, self._drawn = 0, 0.0
        self._display: Any = None
        self._cell: int | None = None

    def add_task(self, description: str, total: float, completed: float = 0.0) -> int:
        """A further bar; returns its number."""
        self._added += 1
        self._tasks[self._added] = {"description": description, "total": total, "completed": completed, "begun": time.monotonic()}
        self._show(tuple(self._tasks))
        return self._added

    def update(self, task: int, **changes: Any) -> None:
        """Change completed, total or description; drawn at most ten times a second, and when it is complete."""
        known = self._tasks[task]
        known.update(changes)
        if known["completed"] >= known["total"] or time.monotonic() - self._drawn >= SECONDS:
            self._show(tuple(self._tasks))

    def remove_task(self, task: int) -> None:
        """Take a bar away."""
        del self._tasks[task]
        self._show(tuple(self._tasks))

    def stop(self) -> None:
        """In place of the bars what took how long."""
        self._show(())

    def _show(self, running: tuple[int, ...]) -> None:
        from IPython import get_ipython
        from IPython.display import display

        now = time.monotonic()
        lines, words = [], []
        for number, task in self._tasks.items():
            share, seconds = min(task["completed"] / task["total"], 1.0), now - task["begun"]
            text = f"{task['description']} {_clock(seconds)}"
            if number in running:
                text = f"{task['description']} {share:.0%} {_clock(seconds)}"
                text += f", {_clock(seconds * (1.0 - share) / share)} left" if share > 0.0 else ""
            bar = f'<progress max="1" value="{share:.4f}" style="width:16em"></progress> ' if number in running else ""
            lines.append(f"<div>{bar}{html.escape(text)}</div>")
            words.append(text)
        shown = {"text/html": "".join(lines), "text/plain": "\n".join(words)}
        cell = get_ipython().execution_count
        if self._display is None or cell != self._cell:
            self._display, self._cell = display(shown, raw=True, display_id=True), cell
        else:
            self._display.update(shown, raw=True)
        self._drawn = now


def _clock(seconds: float) -> str:
    return str(timedelta(seconds=round(seconds)))


FIRST_PROBLEM = 100
"""About as many kernels as a first forced response compiles; the bar starts with this length and grows with what comes."""

TITLE = "Compiling kernels, once on this machine"

EVERY = 30.0
"""Seconds between two lines of progress where nobody sees a bar."""

SENTENCE = "stickslip compiles its kernels, once on this machine: about a minute for the first problem. They are kept on disk."


class CompilationNotice:
    """Counts compiled kernels on a bar, which is there as long as one is being compiled.

    command_bar: that of a command which shows its own progress; a terminal has room for one.
    """

    def __init__(self) -> None:
        self.command_bar: Progress | NotebookBar | None = None
        self._bar: Progress | NotebookBar | None = None
        self._task: Any = None
        self._depth, self._done = 0, 0
        self._began, self._said = 0.0, math.inf

    @property
    def compiling(self) -> bool:
        """Whether a kernel is being compiled."""
        return self._depth > 0

    @property
    def compiled(self) -> int:
        """How many kernels this process has compiled."""
        return self._done

    def begin(self) -> None:
        """A kernel is being compiled."""
        self._depth += 1
        if self._depth == 1:
            self._show()

    def end(self) -> None:
        """A kernel is compiled."""
        self._depth, self._done = self._depth - 1, self._done + 1
        if self._bar is not None and self._task is not None:
            self._bar.update(self._task, completed=self._done, total=max(FIRST_PROBLEM, self._done + 1))
            if self._depth == 0:
                self._hide()
        elif _may_write() and (now := time.monotonic()) - self._said >= EVERY:
            self._said = now
            _write(f"{counted(self._done, 'kernel')} compiled after {now - self._began:.0f} s.")

    def _show(self) -> None:
        if self.command_bar is None and not _bar_is_seen():
            if not self._done and _may_write():
                self._began = self._said = time.monotonic()
                _write(SENTENCE)
            return
        self._bar = self.command_bar or _own_bar()
        if self._bar is not None:
            self._task = self._bar.add_task(TITLE, total=max(FIRST_PROBLEM, self._done + 1), completed=self._done)

    def _hide(self) -> None:
        assert self._bar is not None
        assert self._task is not None
        with suppress(KeyError):
            self._bar.remove_task(self._task)
        if self._bar is not self.command_bar:
            self._bar.stop()
        self._bar = self._task = None


NOTICE = CompilationNotice()
"""That of this process."""


_IN_NOTEBOOK = NotebookBar()
"""One for all kernels: each cell shows a single one, however often compilation begins in it."""


def _may_write() -> bool:
    """Only the process that the user started writes."""
    return multiprocessing.parent_process() is None


def _write(sentence: str) -> None:
    logging.getLogger("stickslip").warning(sentence)


def _bar_is_seen() -> bool:
    """Whether a bar can be shown: on a terminal or in a notebook, by the process that the user started."""
    return _may_write() and (in_notebook() or (sys.stderr is not None and sys.stderr.isatty()))


def _own_bar() -> "Progress | NotebookBar | None":
    """A bar on the error stream or in the cell; none where another library shows one."""
    if in_notebook():
        return _IN_NOTEBOOK
    from rich.console import Console
    from rich.errors import LiveError
    from rich.progress import BarColumn, Progress, TextColumn, TimeElapsedColumn

    columns = TextColumn("{task.description}"), BarColumn(), TextColumn("{task.completed:.0f}"), TimeElapsedColumn()
    bar = Progress(*columns, console=Console(stderr=True), transient=True)
    try:
        bar.start()
    except LiveError:
        return None
    return bar
