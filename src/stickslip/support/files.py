"""Files written whole or not at all."""

from __future__ import annotations

import os
import re
import secrets
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import numpy as np

from stickslip.support.interrupts import held_back

_TEMPORARY = re.compile(r"\..+\.[0-9a-f]{8}\.[a-z]+")


@contextmanager
def replacing(path: str | Path) -> Iterator[Path]:
    """A temporary path in the folder of `path`, with its suffix; it takes the place of `path` when the block ends well.

    When the block raises, `path` stays as it was and the temporary file is removed. Missing folders are made.

    >>> with replacing("curve.txt") as temporary:                 # doctest: +SKIP
    ...     temporary.write_text("whole or not at all")
    """
    path = Path(path)
    path.parent.mkdir(parents=True, exist_ok=True)
    temporary = path.with_name(f".{path.stem}.{secrets.token_hex(4)}{path.suffix}")
    try:
        yield temporary
        _flush(temporary)
        os.replace(temporary, path)
    except OSError as error:
        if error.filename is None or Path(os.fsdecode(error.filename)) == temporary:
            error.filename = str(path)  # the name that the user knows
        raise
    finally:
        temporary.unlink(missing_ok=True)
    _flush(path.parent)


def write_text(path: str | Path, text: str) -> Path:
    """Write `text` as UTF-8, whole or not at all; returns the path."""
    with replacing(path) as temporary:
        temporary.write_text(text, encoding="utf-8")
    return Path(path)


def write_arrays(path: str | Path, arrays: Mapping[str, Any], compressed: bool = False) -> Path:
    """Write a NumPy archive, whole or not at all; returns the path. Ctrl-C waits for it: `zipfile` takes no interruption."""
    write: Any = np.savez_compressed if compressed else np.savez
    with held_back(), replacing(path) as temporary, temporary.open("wb") as file:
        write(file, **arrays)
    return Path(path)


def sweep(folder: str | Path) -> None:
    """Remove temporary files that a killed process left in a folder and below."""
    for path in Path(folder).rglob(".*"):
        if _TEMPORARY.fullmatch(path.name):
            path.unlink(missing_ok=True)


def _flush(path: Path) -> None:
    """Have the system put a file, or a folder's entries, on the disk."""
    if path.is_dir() and os.name == "nt":
        return
    descriptor = os.open(path, os.O_RDONLY if path.is_dir() else os.O_RDWR)
    try:
        os.fsync(descriptor)
    finally:
        os.close(descriptor)
