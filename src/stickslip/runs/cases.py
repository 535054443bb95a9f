"""The common loop of all analyses over independent cases; completed cases go into the checkpoint.

An `Executor` computes them: this process or several of this machine (`processes.py`), or a cluster (`dask_cluster.py`).
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

from stickslip.runs.processes import Processes
from stickslip.runs.work import Arrays, Checkpoint, Executor, Progress, Report, Stopped, Work, Workers, checked_progress
from stickslip.support.checks import fault


def all_cases(
    work: Work,
    checkpoint: Checkpoint | None = None,
    workers: Workers = 1,
    progress: Progress = lambda fraction, text: None,
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
