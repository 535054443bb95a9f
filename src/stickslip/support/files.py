"""Files written whole or not at all."""

from __future__ import annotations

import os
import secrets
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import numpy as np

from stickslip.support.interrupts import held_back
from stickslip.support.written_files import WrittenFiles, digest, only_own, refuse_linked_folder, refuse_obstacle


@contextmanager
def replacing(path: str | Path) -> Iterator[Path]:
    """A temporary path in the folder of `path`, with its suffix; it takes the place of `path` when the block ends well.

    When the block raises, `path` stays as it was and the temporary file is removed. Missing folders are made. A link, a folder
    and a write-protected file are not replaced; within `only_own_files`, nothing that stickslip did not write.

    >>> with replacing("curve.txt") as temporary:                 # doctest: +SKIP
    ...     temporary.write_text("whole or not at all")
    """
    path = Path(path)
    refuse_obstacle(path)
    written = WrittenFiles(path.parent) if only_own() else None
    if written:
        refuse_linked_folder(path.parent)
        written.refuse_others(path)
    path.parent.mkdir(parents=True, exist_ok=True)
    temporary = path.with_name(f".{path.stem}.{secrets.token_hex(4)}{path.suffix}")
    try:
        if written:
            written.add(temporary.name)
        yield temporary
        _flush(temporary)
        if written:
            written.add(path.name, digest(temporary))
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


def _flush(path: Path) -> None:
    """Have the system put a file, or a folder's entries, on the disk."""
    if path.is_dir() and os.name == "nt":
        return
    descriptor = os.open(path, os.O_RDONLY if path.is_dir() else os.O_RDWR)
    try:
        os.fsync(descriptor)
    finally:
        os.close(descriptor)
