"""Interfaces of analyses with independent cases: the work, its executor and its checkpoint.

What a case gives are plain arrays, which travel between machines and to disk.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import Any, Protocol, runtime_checkable

from numpy.typing import NDArray

from stickslip.support.checks import fault
from stickslip.support.late import xr

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

    def so_far(self, results: Mapping[int, Arrays]) -> xr.Dataset:
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
