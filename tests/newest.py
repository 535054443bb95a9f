"""The newest Python of this machine that the project promises to work with: `make test-newest` runs the tests under it."""

import os
import re
import subprocess
import sys
import tomllib
from pathlib import Path

PROJECT = Path(__file__).parents[1] / "pyproject.toml"
VERSION = "import sys; print(*sys.version_info[:3])"


def promised() -> set[tuple[int, ...]]:
    """The versions that pyproject.toml names, (3, 11) and so on."""
    classifiers = tomllib.loads(PROJECT.read_text())["project"]["classifiers"]
    found = (re.fullmatch(r"Programming Language :: Python :: (\d+)\.(\d+)", each) for each in classifiers)
    return {tuple(map(int, each.groups())) for each in found if each}


def installed() -> list[Path]:
    """The interpreters of the search path and of pyenv, and this one."""
    folders = [Path(folder) for folder in os.get_exec_path()]
    folders += Path(os.environ.get("PYENV_ROOT", Path.home() / ".pyenv")).glob("versions/*/bin")
    named = (folder / f"python{major}.{minor}" for folder in folders for major, minor in promised())
    return [Path(sys.executable), *(path for path in named if path.is_file())]


def version(python: Path) -> tuple[int, ...]:
    """Its version; none of a program that does not start, as pyenv's for a version that is not chosen."""
    ran = subprocess.run([python, "-c", VERSION], capture_output=True, text=True, check=False)
    return tuple(map(int, ran.stdout.split())) if ran.returncode == 0 else ()


def newest() -> Path:
    """The one of the highest version."""
    versions = {python: version(python) for python in installed()}
    return max((python for python, found in versions.items() if found[:2] in promised()), key=versions.__getitem__)


if __name__ == "__main__":
    sys.stdout.write(f"{newest()}\n")
