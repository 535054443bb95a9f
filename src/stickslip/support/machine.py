"""What the machine has."""

from __future__ import annotations

import os

UNKNOWN = 8 << 30
"""Bytes where the system does not say."""


def memory() -> int:
    """The machine's memory, bytes."""
    try:
        return os.sysconf("SC_PAGE_SIZE") * os.sysconf("SC_PHYS_PAGES")
    except (AttributeError, ValueError, OSError):
        return UNKNOWN
