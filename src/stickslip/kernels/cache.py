"""Where compiled kernels are kept on disk.

numba's cache of a kernel does not notice when a kernel that it calls, in another file, has changed. The cache folder therefore
carries a digest of all kernel sources: a change anywhere compiles anew, and an old result is never used with new code.
"""

from __future__ import annotations

import hashlib
import os
import shutil
import tempfile
import time
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
    """A writable folder for this digest: beside the package, else the user's cache; folders unused for days are removed."""
    name = f"kernels-{_digest()}"
    home = Path(os.environ.get("XDG_CACHE_HOME", Path.home() / ".cache")) / "stickslip"
    for parent in (_PACKAGE / "__pycache__", home):
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
    return Path(tempfile.gettempdir()) / "stickslip" / name


if "NUMBA_CACHE_DIR" not in os.environ:
    numba.config.CACHE_DIR = str(_cache_folder())  # type: ignore[attr-defined]
