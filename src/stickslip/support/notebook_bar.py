"""Bars in the output of a notebook's cell, by the display messages that every front end of Jupyter knows: no widgets."""

from __future__ import annotations

import html
import sys
import time
from datetime import timedelta
from typing import Any

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
        self._tasks[self._added] = {
            "description": description,
            "total": total,
            "completed": completed,
            "begun": time.monotonic(),
        }
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
