"""Interfaces of analyses with independent cases: the work, its executor and its checkpoint.

What a case gives are plain arrays, which travel between machines and to disk.

Checkpoints: one file per completed case beside the results, from which an interrupted run resumes.

Plain NumPy archives without pickle, each written beside its place and renamed. `runs.cases` saves and loads through it.
"""

from __future__ import annotations

import json
import os
import secrets
import zipfile
import zlib
from collections.abc import Callable, Mapping, Sequence
from hashlib import sha256
from itertools import zip_longest
from pathlib import Path
from typing import Any, Protocol, runtime_checkable

import numpy as np
from numpy.typing import NDArray

from stickslip.model.readers import numpy_archive
from stickslip.support.checks import InputError, fault
from stickslip.support.files import WrittenFiles, only_own_files, write_arrays, write_text
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
