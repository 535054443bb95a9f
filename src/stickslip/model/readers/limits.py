"""Limits on untrusted files: a header is accepted only if file size and memory support it, a last line only if it is whole."""

from __future__ import annotations

from pathlib import Path

from stickslip.support import machine
from stickslip.support.checks import fault

MOST_DEFLATED = 1100
"""No deflate stream unpacks to more than 1032 times its size."""
CUT_SHORT = "The file was cut short: copy it again."
EMPTY_ROWS = 1000
"""Rows that a matrix may have beyond two for each of its entries."""


PACKED = {".gz": "gunzip", ".zip": "unzip", ".bz2": "bunzip2", ".xz": "unxz", ".zst": "unzstd", ".7z": "7z x", ".tar": "tar xf"}
"""Endings of packed files, and what unpacks them."""


def refuse_packed(what: str, path: Path) -> None:
    """Refuse a packed file: readers look for other files of the model beside it, by its name."""
    tool = PACKED.get(path.suffix.lower())
    if tool:
        raise fault(what, "must be unpacked", path.name, f"Unpack it first, with {tool}, beside the other files of the model.")


def memory() -> int:
    """Half of the machine's memory, bytes: more is not spent on one model."""
    return machine.memory() // 2


def refuse_utf_16(path: Path) -> None:
    """Refuse a text in UTF-16, as some editors of Windows save it: every other byte of it is zero."""
    with path.open("rb") as file:
        start = file.read(64)
    if start.startswith((b"\xff\xfe", b"\xfe\xff")) or (len(start) > 8 and not any(start[1::2]) and start[::2].isascii()):
        raise fault(path.name, "must be a text in ASCII or UTF-8", "UTF-16", "Save it again in that encoding.")


def refuse_cut(path: Path, remedy: str = CUT_SHORT) -> None:
    """Refuse a file of lines, not empty, whose last one has no end: a number there may have lost digits."""
    refuse_utf_16(path)
    with path.open("rb") as file:
        file.seek(-1, 2)
        if file.read() != b"\n":
            raise fault(path.name, "must end with a whole line", "cut off", remedy)


def within_file(what: str, claimed: int, file_size: int, smallest: float) -> None:
    """Refuse a header that claims more entries than the file can hold at `smallest` bytes an entry."""
    if claimed < 0 or claimed * smallest > file_size:
        raise fault(what, f"must fit into a file of {file_size} bytes", claimed, "The file is truncated, or its header is wrong.")


def within_memory(what: str, needed: int) -> None:
    """Refuse what would need more than half of the machine's memory."""
    if needed > memory():
        raise fault(what, f"must fit into {memory() / 2**30:.1f} GiB, half of the memory", f"{needed / 2**30:.1f} GiB")


def rows_with_entries(what: str, rows: int, entries: int) -> None:
    """Refuse a matrix with far more rows than entries: its size is not to be believed."""
    if rows > 2 * entries + EMPTY_ROWS:
        raise fault(f"The size of {what}", f"must go with its {entries} entries", rows, "Is its header right?")
