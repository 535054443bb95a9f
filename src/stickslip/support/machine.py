"""What the machine has, and what is used of it."""

import os
import sys
from contextlib import AbstractContextManager
from functools import lru_cache
from typing import Any

from threadpoolctl import ThreadpoolController

UNKNOWN = 8 << 30
"""Bytes where the system does not say."""


def memory() -> int:
    """The machine's memory, bytes."""
    try:
        return os.sysconf("SC_PAGE_SIZE") * os.sysconf("SC_PHYS_PAGES")
    except (AttributeError, ValueError, OSError):
        return UNKNOWN


def one_blas_thread() -> AbstractContextManager[Any]:
    """A context in which linear algebra computes with one thread: its matrices are small, and cases may run side by side."""
    return _libraries(len(sys.modules)).limit(limits=1, user_api="blas")  # type: ignore[no-any-return]


@lru_cache(maxsize=1)
def _libraries(modules: int) -> ThreadpoolController:
    """The libraries in memory, which take a millisecond to find; modules: how many are imported, since one more may load one."""
    return ThreadpoolController()
