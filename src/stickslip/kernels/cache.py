"""Where compiled kernels are kept on disk.

numba's cache of a kernel does not notice when a kernel that it calls, in another file, has changed. The cache folder therefore
carries a digest of all kernel sources: a change anywhere compiles anew, and an old result is never used with new code.

numba unpickles what it finds there, and so runs it: a folder that others can write to is not used.
"""

from __future__ import annotations

import atexit
import hashlib
import os
import shutil
import stat
import tempfile
import time
from contextlib import suppress
from pathlib import Path

import numba

_PACKAGE = Path(__file__).parent.parent
FOLDERS = ("contact", "harmonic", "kernels", "platforms", "solve", "stability", "time")

UNUSED_SECONDS = 3 * 86400.0
"""Age from which a folder of other sources is removed; younger ones may belong to a process that still runs."""


def _digest() -> str:
    """Digest of the sources of all kernels: every file with a compiled function, and what makes kernels of them."""
    digest = hashlib.sha256()
    for path in sorted(path for folder in FOLDERS for path in (_PACKAGE / folder).glob("*.py")):
        source = path.read_bytes()
        if path.parent.name == "kernels" or any(mark in source for mark in (b"@kernel", b"@inner", b"@inlined", b"@separate")):
            digest.update(path.name.encode() + source)
    return digest.hexdigest()[:16]


def _cache_folder() -> Path:
    """A writable folder for this digest: beside the package, else the user's cache, else a temporary one of the user alone;
    folders unused for days are removed."""
    name = f"kernels-{_digest()}"
    home = Path(os.environ.get("XDG_CACHE_HOME") or os.path.expanduser("~/.cache"), "stickslip")
    for parent in (_PACKAGE / "__pycache__", home):
        if not parent.is_absolute():
            continue  # a user without a home; the working folder may be that of a model
        try:
            (parent / name).mkdir(parents=True, exist_ok=True)
            with tempfile.TemporaryFile(dir=parent / name):
                pass
        except OSError:
            continue
        for old in parent.glob("kernels-*"):
            if old.name != name and time.time() - old.stat().st_mtime > UNUSED_SECONDS:
                shutil.rmtree(old, ignore_errors=True)
        return parent / name
    return _temporary_folder() / name


def _temporary_folder() -> Path:
    """The user's own folder among the temporary ones, which later processes find again; where another took its name, one that
    ends with this process."""
    if not hasattr(os, "geteuid"):
        return Path(tempfile.gettempdir()) / "stickslip"  # on Windows temporary folders are the user's own
    folder = Path(tempfile.gettempdir()) / f"stickslip-{os.geteuid()}"
    with suppress(OSError):
        folder.mkdir(mode=0o700, exist_ok=True)
        if _is_mine_alone(folder) and folder.parent != Path.cwd():  # which is the last place for temporary files
            return folder
    passing = Path(tempfile.mkdtemp(prefix="stickslip-"))
    atexit.register(shutil.rmtree, passing, ignore_errors=True)
    return passing


def _is_mine_alone(folder: Path) -> bool:
    """Whether a folder, and no link to one, is this user's and shut to others, and stays: what holds it belongs to the user or
    the system, and others cannot write there or, by its sticky bit, not move what is not theirs."""
    own, above, me = folder.lstat(), folder.parent.stat(), os.geteuid()
    shut = stat.S_ISDIR(own.st_mode) and own.st_uid == me and not own.st_mode & (stat.S_IRWXG | stat.S_IRWXO)
    stays = above.st_mode & stat.S_ISVTX or not above.st_mode & (stat.S_IWGRP | stat.S_IWOTH)
    return shut and bool(stays) and above.st_uid in (0, me)


_CHOSEN = None if "NUMBA_CACHE_DIR" in os.environ else str(_cache_folder())


def keep_kernels_here() -> None:
    """Have numba keep what it is given next in the chosen folder, unless the user named one by NUMBA_CACHE_DIR.

    Whenever numba compiles it may take another from a file `.numba_config.yaml` of the working folder.
    """
    if _CHOSEN is not None:
        numba.config.CACHE_DIR = _CHOSEN  # type: ignore[attr-defined]


keep_kernels_here()
