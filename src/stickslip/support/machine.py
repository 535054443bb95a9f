"""What the machine has, and what is used of it."""

import os
import sys
from contextlib import AbstractContextManager, suppress
from functools import lru_cache
from pathlib import Path
from typing import Any

from threadpoolctl import ThreadpoolController

UNKNOWN = 8 << 30
"""Bytes where the system does not say."""


LIMITS = [Path("/sys/fs/cgroup", name) for name in ("memory.max", "memory/memory.limit_in_bytes")]
"""Where Linux says what a container may take, in both versions of control groups."""


def memory() -> int:
    """The machine's memory, or what a container has of it, bytes."""
    try:
        least = os.sysconf("SC_PAGE_SIZE") * os.sysconf("SC_PHYS_PAGES")
    except (AttributeError, ValueError, OSError):
        least = UNKNOWN
    for file in LIMITS:
        with suppress(OSError, ValueError):  # without a limit the file says "max"
            least = min(least, int(file.read_text()))
    return least


def taken() -> int:
    """The memory that this process has now, bytes; 0 where the system does not say."""
    with suppress(OSError, IndexError, ValueError):
        return int(Path("/proc/self/statm").read_text().split()[1]) * os.sysconf("SC_PAGE_SIZE")
    return 0


def one_blas_thread() -> AbstractContextManager[Any]:
    """A context in which linear algebra computes with one thread: its matrices are small, and cases may run side by side."""
    return _libraries(len(sys.modules)).limit(limits=1, user_api="blas")  # type: ignore[no-any-return]


@lru_cache(maxsize=1)
def _libraries(modules: int) -> ThreadpoolController:
    """The libraries in memory, which take a millisecond to find; modules: how many are imported, since one more may load one."""
    return ThreadpoolController()
