"""The lines of a deck with those of the files that it includes, each with its file and number.

An included file must lie in the folder of the deck or below it: a deck of others would else read any file of the machine.
"""

from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from pathlib import Path
from time import process_time
from typing import NamedTuple

from stickslip.model.readers.numbers import refuse_utf_16, within_memory
from stickslip.support.checks import fault, similar_file

REPEATED_BYTES = 4 << 20
"""Bytes of files that a deck includes once more, beyond as many as its files have: seconds of reading."""
SECONDS, BYTES_PER_SECOND = 60.0, 1e5
"""Processor time for a deck, and for each of its bytes; the slowest reader takes a seventh of it."""
EACH_LINES = 4096
"""Lines between two looks at the time."""
MOST_FILES = 1000
DEEPEST = 20
"""Included files, and includes within each other: more is a file that includes itself."""


class Line(NamedTuple):
    """A line without its end; file and number say where it stands."""

    text: str
    file: str
    number: int

    @property
    def place(self) -> str:
        return f"{self.file}, line {self.number}"


Included = Callable[[str, Iterator[str]], str | None]
"""The name of the file that a line includes, None if it includes none; a card that goes on takes more lines from the iterator."""


@dataclass
class Lines:
    """deck: the file that was named; memory: bytes that a byte of text takes as it is read."""

    deck: Path
    included: Included
    memory: int
    size: int = 0
    files: int = 0
    sizes: dict[Path, int] = field(default_factory=dict)

    def read(self) -> Iterator[Line]:
        """Every line of the deck, that of an included file in the place of the card that names it."""
        begun = process_time()
        for number, line in enumerate(self._lines(self.deck, 0)):
            yield line
            if number % EACH_LINES == 0:
                limit = SECONDS + self.size / BYTES_PER_SECOND
                if process_time() - begun > limit:
                    rule = f"must be read within {limit:.0f} s of processor time"
                    raise fault(self.deck.name, rule, f"at {line.place} by then", "Is something in it made over and over again?")

    def of_file(self, name: str, card: Line) -> Iterator[Line]:
        """The lines of a file of data that a card names."""
        return self._lines(self._inside(name, card), 1)

    def _lines(self, path: Path, depth: int) -> Iterator[Line]:
        self.files += 1
        self.sizes[path] = path.stat().st_size
        self.size += self.sizes[path]
        own = sum(self.sizes.values())
        if self.size > 2 * own + REPEATED_BYTES:
            limit = f"must have at most {2 * own + REPEATED_BYTES} bytes with the files that it includes again"
            raise fault(self.deck.name, limit, f"more with {path.name}", "Include each file once.")
        if self.files > MOST_FILES or depth > DEEPEST:
            limit = f"must include at most {MOST_FILES} files, {DEEPEST} deep"
            raise fault(self.deck.name, limit, f"more with {path.name}", "Does a file include itself?")
        within_memory(self.deck.name, self.memory * self.size)
        refuse_utf_16(path)
        with path.open(encoding="utf-8-sig", errors="replace") as file:
            numbered = enumerate(file, start=1)
            for number, text in numbered:
                line = Line(text.rstrip("\r\n"), path.name, number)
                name = self.included(line.text, (more for _, more in numbered))
                if name is None:
                    yield line
                else:
                    yield from self._lines(self._inside(name, line), depth + 1)

    def _inside(self, name: str, line: Line) -> Path:
        """The path of an included file, by its name from the folder of the deck."""
        folder = self.deck.parent.resolve()
        path = (folder / name.replace("\\", "/")).resolve()
        if not path.is_relative_to(folder):
            raise fault(f"The file that {line.place} includes", "must lie in the folder of the deck", name, "Copy it there.")
        if not path.is_file():
            remedy = f"{similar_file(path)} Copy it there, or delete the line if it holds no nodes, sets or elements.".strip()
            raise fault(f"The file that {line.place} includes", "must exist in the folder of the deck", name, remedy)
        return path
