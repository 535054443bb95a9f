"""Damaged model files and studies: any bytes give a model or an `InputError`, in bounded time and memory."""

from __future__ import annotations

import os
import random
import tempfile
import warnings
from collections import Counter
from collections.abc import Iterator
from pathlib import Path

from models.fuzzing import Victims, drawn, peak_memory, reader_of, study_answer

from verify.row import Row, at_most

TITLE = "Hostile input"
ABOUT = """\
Sound files of every format are damaged by up to five changes, drawn with fixed seeds (bytes flipped, overwritten, dropped,
doubled, files cut short, counts and numbers made huge), and read. A row counts the answers that are neither a model nor an
`InputError`; each reading has 20 s. `EXECUTIONS` in the environment sets how many are made of each kind of file, 2000 unless
given."""

SOURCE = "an InputError or a model"
STUDIES = "study files"
SLOW = ("mat73",)
"""Kinds that are read in a process of their own: a twentieth of the executions."""


def rows() -> Iterator[Row]:
    executions, before = int(os.environ.get("EXECUTIONS", "2000")), peak_memory()
    made: Counter[str] = Counter()
    wrong: Counter[str] = Counter()
    with tempfile.TemporaryDirectory() as folder, warnings.catch_warnings():
        warnings.simplefilter("ignore")
        victims = Victims(Path(folder))
        for kind in victims.paths:
            reader = reader_of(victims, kind)
            number = max(1, executions // 20) if kind in SLOW else executions
            made[reader] += number
            wrong[reader] += sum(not quiet(victims, kind, random.Random(f"{kind} {seed}")) for seed in range(number))
        made[STUDIES] = executions
        place = victims.paths["npz"].parent
        wrong[STUDIES] = sum(not quiet_study(place, random.Random(number)) for number in range(executions))
    for reader, number in made.items():
        yield at_most(f"{reader}: other answers in {number} executions", wrong[reader], 0.0, SOURCE)
    yield at_most("growth of memory over all of them, MiB", peak_memory() - before, 300.0, SOURCE)


def quiet(victims: Victims, kind: str, generator: random.Random) -> bool:
    """Whether a damaged file gave a model or an `InputError`."""
    changes, which = drawn(generator), generator.getrandbits(8)
    try:
        victims.answer(kind, which, changes)
    except (Exception, SystemError) as error:
        print(f"  {kind}, file {which}, {changes}: {type(error).__name__}: {error}")
        return False
    return True


def quiet_study(folder: Path, generator: random.Random) -> bool:
    """Whether a damaged study gave a job or an `InputError`."""
    changes = drawn(generator)
    try:
        study_answer(folder, changes)
    except Exception as error:
        print(f"  study, {changes}: {type(error).__name__}: {error}")
        return False
    return True
