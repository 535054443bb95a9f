"""Files written whole or not at all.

The list that a folder keeps of the files that stickslip wrote into it, with their digests.

Commands whose names of files the user has not typed (results, report, figures, checkpoints) replace and remove only files of
this list that are still as they were written: `support.files` asks it and fills it within `only_own_files`.
"""

import hashlib
import os
import re
import secrets
import stat
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from contextvars import ContextVar
from pathlib import Path
from typing import Any

import numpy as np

from stickslip.support.checks import fault, first_of
from stickslip.support.interrupts import held_back


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


LIST = ".stickslip_files"
_HEAD = b"# Files that stickslip wrote into this folder, with the SHA-256 of their content. It replaces and removes no others.\n"
_UNFINISHED = "unfinished"
"""Instead of the digest of a temporary file, whose content is not known before it is complete."""
_LINE = re.compile(rf"([0-9a-f]{{64}}|{_UNFINISHED})  ([^/\\\0]+)")
TEMPORARY = re.compile(r"\..*\.[0-9a-f]{8}(\.[^.]+)?")
"""Names of temporary files, which `support.files` draws by chance."""
_ONLY_OWN = ContextVar("only_own", default=False)


@contextmanager
def only_own_files(only: bool = True) -> Iterator[None]:
    """Files that are written in this block replace only what stickslip wrote, and go on the list of their folder; with False,
    those of a cache, whose folder is of stickslip alone and which other processes fill too, replace any."""
    token = _ONLY_OWN.set(only)
    try:
        yield
    finally:
        _ONLY_OWN.reset(token)


def only_own() -> bool:
    """Whether such a block runs."""
    return _ONLY_OWN.get()


def refuse_obstacle(path: Path) -> None:
    """Refuse to write a file where a link, a folder or a write-protected file is."""
    try:
        mode = path.lstat().st_mode
    except OSError:
        return  # nothing is there, or the attempt to write says why not
    what = (
        f"a link to {os.readlink(path)!r}, and links are not followed"
        if stat.S_ISLNK(mode)
        else "a folder"
        if stat.S_ISDIR(mode)
        else "no regular file"
        if not stat.S_ISREG(mode)
        else "write-protected"
        if not mode & (stat.S_IWUSR | stat.S_IWGRP | stat.S_IWOTH)
        else ""
    )
    if what:
        raise fault("A file to write", f"must be free or replaceable ({what})", str(path), "Move it, or name another.")


def refuse_linked_folder(folder: Path) -> None:
    """Refuse a folder that is a link: what is written there would land elsewhere; and one whose list is another file."""
    if folder.is_symlink():
        remedy = "Name the folder itself."
        raise fault("The output folder", f"must be no link (to {os.readlink(folder)!r})", str(folder), remedy)
    listing = folder / LIST
    if os.path.lexists(listing) and not WrittenFiles(folder).exists:
        raise fault("The list of written files", "must be that of stickslip", str(listing), "Move this file.")


def digest(path: Path) -> str:
    """SHA-256 of a file, as hexadecimal digits."""
    with path.open("rb") as file:
        return hashlib.file_digest(file, "sha256").hexdigest()


class WrittenFiles:
    """The list of one folder.

    Its lines are those of `sha256sum`; the last one on a name counts. It only grows, so that a killed process leaves at most half
    a line.
    """

    def __init__(self, folder: str | Path) -> None:
        self.folder = Path(folder)
        self.list = self.folder / LIST

    @property
    def exists(self) -> bool:
        """Whether stickslip has written into the folder; on a full disk it may have begun its list without an entry."""
        if self.folder.is_symlink() or self.list.is_symlink() or not self.list.is_file():
            return False
        content = self._content()
        return content.startswith(_HEAD) or _HEAD.startswith(content)

    def entries(self) -> dict[str, str]:
        """Digests by the names of files, in the order in which these were first written."""
        content = self._content()
        if not content.startswith(_HEAD):
            return {}
        lines = map(_LINE.fullmatch, content.decode("utf-8", errors="surrogateescape").split("\n"))
        return {line[2]: line[1] for line in lines if line and line[2] not in (".", "..", LIST)}

    def has(self, path: Path) -> bool:
        """Whether a file of the folder, and no link, is as stickslip wrote it."""
        return self._is_own(path, self.entries().get(path.name, ""))

    def add(self, name: str, digest: str = _UNFINISHED) -> None:
        """List a file that is about to appear; without a digest a temporary one."""
        flags = os.O_RDWR | os.O_CREAT | os.O_APPEND | getattr(os, "O_NOFOLLOW", 0)
        try:
            descriptor = os.open(self.list, flags, 0o666)
        except OSError as error:
            raise fault(
                "The list of written files", "must be a file that can be written", str(self.list), f"({error.strerror})"
            ) from None
        try:
            size, head = os.fstat(descriptor).st_size, os.read(descriptor, len(_HEAD))
            if _HEAD.startswith(head):  # a full disk may have cut it off
                os.ftruncate(descriptor, 0 if size < len(_HEAD) else size)
                size = os.fstat(descriptor).st_size
            elif head != _HEAD:
                raise fault("The list of written files", "must be that of stickslip", str(self.list), "Move this file.")
            os.lseek(descriptor, max(size - 1, 0), os.SEEK_SET)
            start = _HEAD if not size else b"" if os.read(descriptor, 1) == b"\n" else b"\n"
            os.write(descriptor, start + os.fsencode(f"{digest}  {name}\n"))
            if digest != _UNFINISHED:
                os.fsync(descriptor)
        finally:
            os.close(descriptor)

    def remove(self, name: str) -> None:
        """Remove a file of the list that is as it was written; any other stays."""
        if self.has(self.folder / name):
            (self.folder / name).unlink()

    def remove_temporary(self) -> None:
        """Remove what a killed process left unfinished."""
        for name, digest in self.entries().items():
            if digest == _UNFINISHED:
                self.remove(name)

    def remove_all(self, last: Sequence[str] = ()) -> list[Path]:
        """Remove all files of the list that are as they were written, those named in `last` after the others, and the folder with
        the list if it holds nothing else then. Returns what is left."""
        if not self.exists or self.folder.is_symlink():
            return [self.folder] if self.folder.exists() else []
        entries = self.entries()
        for name in sorted(entries, key=lambda name: name in last):
            if self._is_own(self.folder / name, entries[name]):
                (self.folder / name).unlink()
        self.remove_list_alone()
        left = sorted(path for path in self.folder.iterdir() if path != self.list)
        if not left:
            self.folder.rmdir()
        return left

    def remove_list_alone(self) -> None:
        """Remove the list where it is all that the folder holds."""
        if self.exists and [*self.folder.iterdir()] == [self.list]:
            self.list.unlink()

    def refuse_others(self, path: Path) -> None:
        """Refuse to replace a file that is not on the list, or was changed."""
        if os.path.lexists(path) and not self.has(path):
            why = "was changed since stickslip wrote it" if path.name in self.entries() else f"is not on its list {LIST}"
            raise fault(
                "A file to replace", f"must be one that stickslip wrote (it {why})", str(path), "Move it, or name another folder."
            )

    def _is_own(self, path: Path, listed: str) -> bool:
        try:
            if not listed or not stat.S_ISREG(path.lstat().st_mode):
                return False
            return bool(TEMPORARY.fullmatch(path.name)) if listed == _UNFINISHED else digest(path) == listed
        except OSError:
            return False

    def _content(self) -> bytes:
        try:
            return b"" if self.list.is_symlink() else self.list.read_bytes()
        except OSError:
            return b""


def left_sentence(paths: Sequence[Path]) -> str:
    """A sentence on what was not removed."""
    names = first_of([path.name for path in paths], 3)
    return f"Left in {paths[0].parent}: {names}, which stickslip did not write, or which was changed since."
