"""Damaged model files and studies: any bytes give a model or an `InputError`, in bounded time and memory."""

from __future__ import annotations

import os
import random
import tempfile
import warnings
from collections import Counter, defaultdict
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

from readers.fuzzing import APART, TookTooLongError, Victims, peak_memory, reader_of, studies, study_answer
from readers.guided import Corpus

from verify.row import Row, at_most

TITLE = "Hostile input"
ABOUT = """\
Sound files of every format are damaged by changes that are drawn with fixed seeds (bytes flipped, overwritten, dropped,
doubled, files cut short, counts and numbers made huge), and read. The search is guided by coverage: changes that lead to lines
of the readers or of the studies that none before them reached are kept and changed further. A row counts the answers that are
neither a model nor an `InputError`, and names the lines reached, with those that the sound files reach; each reading has 20 s.
`EXECUTIONS` in the environment sets how many are made of each kind of file, 2000 unless given. MATLAB files are read by other
packages in a process of their own, where lines are not seen."""

SOURCE = "an InputError or a model"
STUDIES = "study files"
SLOWER = 20
"""How many times fewer executions are made of kinds that are read in a process of their own."""

Answer = Callable[[int, Any], bool]


class Tally:
    """Of one reader, over its kinds of files: executions, wrong answers, lines reached, those of sound files."""

    def __init__(self) -> None:
        self.counts: Counter[str] = Counter()
        self.lines: set[Any] = set()
        self.sound: set[Any] = set()

    def fuzz(self, kind: str, answer: Answer, seeds: int, executions: int) -> None:
        """Read each of the sound files, then damaged ones."""
        corpus, generator = Corpus(answer), random.Random(kind)
        for which in range(seeds):
            self.counts["wrong"] += not quiet(corpus, kind, which, [])
        self.sound |= corpus.lines
        self.counts["wrong"] += sum(not quiet(corpus, kind, *corpus.draw(generator)) for _ in range(executions))
        self.counts["executions"] += executions
        self.lines |= corpus.lines

    def row(self, reader: str) -> Row:
        reached = f"{len(self.lines)} lines reached, {len(self.sound)} by sound files"
        name = f"{reader}: other answers in {self.counts['executions']} executions; {reached}"
        return at_most(name, self.counts["wrong"], 0.0, SOURCE)


def rows() -> Iterator[Row]:
    yield from fuzzed(int(os.environ.get("EXECUTIONS", "2000")))


def one_seed() -> Iterator[Row]:
    """A few changes of each kind of file."""
    yield from fuzzed(100)


def fuzzed(executions: int) -> Iterator[Row]:
    """All readers with so many executions of each kind of file."""
    before = peak_memory()
    tallies: defaultdict[str, Tally] = defaultdict(Tally)
    with tempfile.TemporaryDirectory() as folder, warnings.catch_warnings():
        warnings.simplefilter("ignore")
        victims = Victims(Path(folder))
        for kind in victims.paths:
            number = max(1, executions // SLOWER) if kind in APART else executions
            tallies[reader_of(victims, kind)].fuzz(kind, answer_of(victims, kind), 1, number)
        place = victims.paths["npz"].parent
        seeds = studies(place)
        read = lambda which, changes: study_answer(seeds[which % len(seeds)], place, changes)  # noqa: E731
        tallies[STUDIES].fuzz(STUDIES, read, len(seeds), executions)
    for reader, tally in tallies.items():
        yield tally.row(reader)
    yield at_most("growth of memory over all of them, MiB", peak_memory() - before, 300.0, SOURCE)


def answer_of(victims: Victims, kind: str) -> Answer:
    """How a kind of file is read."""
    return lambda which, changes: victims.answer(kind, which, changes)


def quiet(corpus: Corpus, kind: str, which: int, changes: Any) -> bool:
    """Whether a damaged file gave a model or an `InputError`."""
    try:
        corpus.run(which, changes)
    except (Exception, TookTooLongError) as error:
        print(f"  {kind}, file {which}, {changes}: {type(error).__name__}: {error}")
        return False
    return True
