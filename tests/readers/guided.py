"""Coverage-guided choice of damaged files: changes that lead to lines not reached before are kept and changed further."""

import sys
from contextlib import contextmanager
from pathlib import Path

from readers.fuzzing import drawn

import stickslip

FOLDERS = tuple(str(Path(stickslip.__file__).parent / name) for name in ("model/readers", "study"))
FRESH = 0.2
"""The share of inputs that start from the sound file again."""
MOST_CHANGES = 20


@contextmanager
def lines_reached(folders=FOLDERS):
    """The set of (file, line) that run in the block, of files in `folders`."""
    reached = set()

    def at_line(frame, event, argument):
        reached.add((frame.f_code.co_filename, frame.f_lineno))
        return at_line

    def at_call(frame, event, argument):
        return at_line if frame.f_code.co_filename.startswith(folders) else None

    before = sys.gettrace()
    sys.settrace(at_call)
    try:
        yield reached
    finally:
        sys.settrace(before)


class Corpus:
    """Inputs (which file, changes) of one kind, each of which reached a line that none before it did; the lines so far."""

    def __init__(self, answer, folders=FOLDERS):
        """answer(which, changes) reads the damaged file; `run` is to be called with no changes first."""
        self.answer, self.folders = answer, folders
        self.kept, self.lines = [], set()

    def draw(self, generator):
        """Which file, and its changes: mostly those of a kept input and some more."""
        which, changes = generator.getrandbits(8), drawn(generator)
        if self.kept and generator.random() >= FRESH:
            before_which, before = generator.choice(self.kept)
            if len(before) + len(changes) <= MOST_CHANGES:
                return before_which, [*before, *changes]
        return which, changes

    def run(self, which, changes):
        """The answer to one input, which is kept if it reached a new line, whatever the answer is."""
        with lines_reached(self.folders) as lines:
            try:
                return self.answer(which, changes)
            finally:
                if not lines <= self.lines:
                    self.lines |= lines
                    self.kept.append((which, changes))
