"""Formulas broken on purpose, each of which the named quick tests must notice: `make mutants`.

`tests/mutants.toml` lists them by file of the package: a text, the broken text, and tests. The tests import a copy of the
package in which one formula at a time is broken; what passes is reported, and so is a text that the file does not hold once.
"""

from __future__ import annotations

import os
import shutil
import signal
import subprocess
import sys
import tempfile
import tomllib
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import NamedTuple

from stickslip.support.kernels.cache import FOLDER

ROOT = Path(__file__).parents[1]
SOURCE = ROOT / "src" / "stickslip"
QUICK = "not slow and not nightly and not verify and not system"
PASSED, FAILED, NONE, LATE = 0, 1, 5, None
"""Exit codes of pytest, that of no test found among them, and that of a run out of time; any other is a fault of the run."""


class Mutant(NamedTuple):
    """A text of a file of the package, the text that breaks it, and the tests that must fail."""

    file: str
    old: str
    new: str
    tests: tuple[str, ...]

    def holds(self, word: str) -> bool:
        """Whether its file or its texts hold a word."""
        return word in f"{self.file}: {self.old} -> {self.new}"


def listed() -> list[Mutant]:
    """All mutants of `tests/mutants.toml`."""
    files = tomllib.loads((ROOT / "tests" / "mutants.toml").read_text())
    return [
        Mutant(file, each["old"], each["new"], tuple(f"tests/{test}" for test in each["tests"]))
        for file, content in files.items()
        for each in content.get("broken", [])
    ]


@contextmanager
def copied_package() -> Iterator[Path]:
    """A folder with a copy of the package and of its kernels."""
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        shutil.copytree(SOURCE, folder / "stickslip", ignore=shutil.ignore_patterns("__pycache__"))
        shutil.copytree(FOLDER, folder / "kernels" / "stickslip")
        yield folder


def tested(tests: list[str], folder: Path, limit: float | None = None) -> int | None:  # noqa: PT028 - no test
    """Exit code of pytest on some tests with the package of a folder, and the kernels there, of which only a broken one and those
    that hold it are compiled anew (`near_kernels`). After `limit` seconds, and when this process is interrupted, pytest and its
    children are ended."""
    environment = os.environ | {"PYTHONPATH": str(folder), "NUMBA_CACHE_DIR": str(folder / "kernels")}
    environment["PYTHONDONTWRITEBYTECODE"] = ""  # the copy of the package is read once, not in each run
    plugins = ["-p", "no:cacheprovider", "-p", "tools.near_kernels"]
    command = [sys.executable, "-m", "pytest", "-q", "-x", *plugins, "--hypothesis-profile=ci", "-m", QUICK]
    process = subprocess.Popen(
        [*command, *tests],
        cwd=ROOT,
        env=environment,
        stdout=subprocess.DEVNULL,
        stderr=subprocess.DEVNULL,
        start_new_session=True,
    )
    try:
        return process.wait(limit)
    except subprocess.TimeoutExpired:
        return LATE
    finally:
        with suppress(ProcessLookupError):
            os.killpg(process.pid, signal.SIGKILL)
        process.wait()


def outcome(file: str, text: str, tests: list[str], folder: Path, limit: float | None = None) -> str:
    """What the tests do with the package of a folder while a file of it has another text: killed, or what happened instead."""
    path = folder / "stickslip" / file
    path.write_text(text)
    try:
        code = tested(tests, folder, limit)
    finally:
        shutil.copyfile(SOURCE / file, path)
    return {PASSED: "survives", FAILED: "killed", LATE: "out of time"}.get(code, f"pytest ended with {code}")


def outcome_of_listed(mutant: Mutant, folder: Path) -> str:
    """killed, or what happened instead."""
    source = SOURCE / mutant.file
    text = source.read_text() if source.is_file() else ""
    if text.count(mutant.old) != 1:
        return f"holds the text {text.count(mutant.old)} times"
    return outcome(mutant.file, text.replace(mutant.old, mutant.new), list(mutant.tests), folder)


def main(words: list[str]) -> int:
    """All mutants, or those whose file or texts hold a word."""
    chosen = [mutant for mutant in listed() if not words or any(mutant.holds(word) for word in words)]
    wrong = 0
    with copied_package() as folder:
        if tested(sorted({test for mutant in chosen for test in mutant.tests}), folder) != PASSED:
            sys.stdout.write("The named tests must pass before anything is broken.\n")
            return 1
        for mutant in chosen:
            found = outcome_of_listed(mutant, folder)
            wrong += found != "killed"
            sys.stdout.write(f"{found:9} {mutant.file}: {mutant.old}  ->  {mutant.new}\n")
            sys.stdout.flush()
    sys.stdout.write(f"{len(chosen) - wrong} of {len(chosen)} broken formulas are noticed.\n")
    return bool(wrong) or not chosen


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
