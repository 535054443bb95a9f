"""Text files of GNU Octave (`save -text`): "# name:", "# type:" and sizes before each value; fields of a struct as rom.M.

Matrices, sparse and diagonal ones, scalars, text and cells of names are read. (GNU Octave manual, Simple File I/O.)
"""

import re
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
from scipy import sparse

from stickslip.model.readers.numbers import (
    number_lines,
    refuse_utf_16,
    rows_with_entries,
    triplets,
    whole,
    within_file,
    within_memory,
)
from stickslip.support.checks import Array, fault

HEADER = re.compile(r"#\s*([a-z]+)\s*:\s*(.*)")
TEXT = ("string", "sq_string")
"""Types of text, in double and in single quotation marks."""


def arrays(path: Path) -> dict[str, Any]:
    """Arrays by name."""
    within_memory(path.name, 20 * path.stat().st_size)
    refuse_utf_16(path)
    return _Reader(path.read_text(encoding="utf-8", errors="replace").split("\n")).values()


class _Reader:
    """The lines of a file and the place in them."""

    def __init__(self, lines: list[str]) -> None:
        self.lines = lines
        self.size = sum(map(len, lines))
        self.place = 0

    def values(self) -> dict[str, Any]:
        """The values of all names; what is neither numbers nor text is passed over."""
        values: dict[str, Any] = {}
        inside: list[tuple[str, int]] = []  # the structs around what is read, and how many of their fields are left
        while (name := self._until("name")) is not None:
            kind = self._header("type").removeprefix("float ")
            full = ".".join((*(struct for struct, _ in inside), name))
            if full in values:
                raise fault(f"The variable {full}", "must stand in the file once", "twice", "Was the file put together?")
            inside = [(struct, left - (depth == len(inside) - 1)) for depth, (struct, left) in enumerate(inside)]
            if kind == "scalar struct":
                inside.append((name, self._count("length")))
            elif kind == "cell":
                texts = []
                for _ in range(self._count("rows") * self._count("columns")):
                    self._until("name")  # each cell has a name and a type of its own
                    texts.append(" ".join(self._text()) if self._header("type") in TEXT else "")
                values |= {full: texts} if name == "dofs" else {}
            elif (value := self._value(full, kind)) is not None:
                values[full] = value
            while inside and inside[-1][1] <= 0:
                inside.pop()
        return values

    def _value(self, name: str, kind: str) -> Any:
        """The value of a type of its own; None of one that is neither numbers nor text, or has more than two dimensions."""
        if kind == "scalar":
            return self._numbers(name, 1, 1)
        if kind == "matrix":
            if "ndims" in self.lines[self.place]:
                return None
            return self._numbers(name, self._count("rows"), self._count("columns"))
        if kind == "diagonal matrix":
            size = self._count("rows"), self._count("columns")
            values = self._numbers(name, min(size), 1)[:, 0]
            return sparse.diags_array(values, shape=size).tocsc()
        if kind == "sparse matrix":
            entries, shape = self._count("nnz"), (self._count("rows"), self._count("columns"))
            rows_with_entries(name, max(shape), entries)
            table = self._numbers(name, entries, 3)
            rows, columns = (whole(f"Rows and columns of {name}", table[:, k], 1, shape[k]) - 1 for k in (0, 1))
            return triplets(name, rows, columns, table[:, 2], max(shape))[: shape[0], : shape[1]]
        return list(self._text()) if kind in TEXT else None

    def _numbers(self, name: str, rows: int, columns: int) -> Array:
        """Lines of numbers, and none behind them."""
        lines = [self._line() for _ in range(rows)]
        rule = f"must have {columns} numbers in each of {rows} lines"
        if self.place < len(self.lines) and self.lines[self.place].strip().strip("#") and self.lines[self.place][0] != "#":
            raise fault(name, rule, "more", "The file is damaged.")
        if not rows * columns:
            return np.zeros((rows, columns))
        numbers = number_lines(name, "\n".join(lines).encode("ascii", "replace"))
        if numbers.shape != (rows, columns):
            raise fault(name, rule, "others", "The file is damaged.")
        return numbers

    def _text(self) -> Iterator[str]:
        """The rows of a text, each after its length."""
        for _ in range(self._count("elements")):
            self._count("length")
            yield self._line()

    def _line(self) -> str:
        if self.place >= len(self.lines):
            raise fault("The file", "must be whole", "cut off")
        self.place += 1
        return self.lines[self.place - 1]

    def _until(self, key: str) -> str | None:
        """The value of the next header of that name, None at the end of the file."""
        while self.place < len(self.lines):
            match = HEADER.match(self._line())
            if match and match[1] == key:
                return match[2].strip()
        return None

    def _header(self, key: str) -> str:
        match = HEADER.match(self._line())
        if match is None or match[1] != key:
            raise fault("A text file of Octave", f"must have a line # {key}:", self.lines[self.place - 1][:40])
        return match[2].strip()

    def _count(self, key: str) -> int:
        text = self._header(key) if key != "length" else self._until("length") or ""
        if not text.isdecimal():
            raise fault(f"{key} of a text file of Octave", "must be a whole number", text[:40])
        within_file(f"{key} of a text file of Octave", int(text), self.size, 0.5)
        return int(text)
