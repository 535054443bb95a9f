"""Which commit a measurement belongs to."""

from __future__ import annotations

import subprocess
from pathlib import Path

ROOT = Path(__file__).parents[1]


def commit(*folders: str) -> str:
    """The last commit of some folders, with a + when files of them differ from it; unknown outside a repository."""
    try:
        name = _git("log", "-1", "--format=%h", "--abbrev=12", "--", *folders)
        changed = _git("status", "--porcelain", "--untracked-files=no", "--", *folders)
    except (OSError, subprocess.CalledProcessError):
        return "unknown"
    return (name or "unknown") + ("+" if changed else "")


def settled(name: str) -> bool:
    """Whether a commit says all: known, and without changes that are not in it."""
    return not name.endswith(("+", "unknown"))


def _git(*arguments: str) -> str:
    return subprocess.run(["git", *arguments], cwd=ROOT, check=True, capture_output=True, text=True).stdout.strip()
