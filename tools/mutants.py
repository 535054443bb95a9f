"""Formulas broken on purpose, each of which the named quick tests must notice: `make mutants`.

`tests/mutants.toml` lists them: a file of the package, its text, the broken text, and tests. Each is broken in a copy of the
package that the tests then import; what passes is reported, and so is a text that is no longer there once.
"""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
import tempfile
import tomllib
from pathlib import Path

ROOT = Path(__file__).parents[1]
PASSED, FAILED = 0, 1
"""Exit codes of pytest; any other is a fault of the run, as no test found."""


def broken(mutant: dict[str, str | list[str]], package: Path) -> str | None:
    """Break one formula in a copy of the package; None, or why it cannot be."""
    path = package / str(mutant["file"])
    text = path.read_text() if path.is_file() else ""
    if text.count(str(mutant["old"])) != 1:
        return f"holds the text {text.count(str(mutant['old']))} times"
    path.write_text(text.replace(str(mutant["old"]), str(mutant["new"])))
    return None


def outcome(mutant: dict[str, str | list[str]]) -> str:
    """killed, or what happened instead."""
    with tempfile.TemporaryDirectory() as folder:
        package = Path(folder) / "stickslip"
        shutil.copytree(ROOT / "src" / "stickslip", package, ignore=shutil.ignore_patterns("kernels-*"))
        if reason := broken(mutant, package):
            return reason
        environment = {**os.environ, "PYTHONPATH": folder, "NUMBA_CACHE_DIR": f"{folder}/kernels"}
        command = [sys.executable, "-m", "pytest", "-q", "-x", "-p", "no:cacheprovider", *mutant["tests"]]
        code = subprocess.run(command, cwd=ROOT, env=environment, capture_output=True, check=False).returncode
    return {PASSED: "survives", FAILED: "killed"}.get(code, f"pytest ended with {code}")


def main(words: list[str]) -> int:
    """All mutants, or those whose file or texts hold a word."""
    mutants = tomllib.loads((ROOT / "tests" / "mutants.toml").read_text())["mutant"]
    chosen = [each for each in mutants if not words or any(word in f"{each['file']} {each['old']}" for word in words)]
    named = sorted({test for mutant in chosen for test in mutant["tests"]})
    if subprocess.run([sys.executable, "-m", "pytest", "-q", "-p", "no:cacheprovider", *named], cwd=ROOT, check=False).returncode:
        sys.stdout.write("The named tests must pass before anything is broken.\n")
        return 1
    wrong = 0
    for mutant in chosen:
        found = outcome(mutant)
        wrong += found != "killed"
        sys.stdout.write(f"{found:9} {mutant['file']}: {mutant['old']}  ->  {mutant['new']}\n")
        sys.stdout.flush()
    sys.stdout.write(f"{len(chosen) - wrong} of {len(chosen)} broken formulas are noticed.\n")
    return bool(wrong) or not chosen


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
