"""Which functions of the package each quick test enters, for `tools/drawn_mutants.py`.

    python -m pytest -p tools.entered -m QUICK tests

As a plugin of pytest it adds a line to results/entered/WORKER.jsonl for each test and each fixture: what it enters, in Python.
Compiled kernels are not seen: those who call them are. What is recorded again counts in place of what was. Tests of interrupted
runs may hang, since an interrupt may fall into the profile function; they enter no formula (`make entered` ignores tests/runs).
"""

from __future__ import annotations

import hashlib
import json
import os
import sys
import time
from collections import defaultdict
from collections.abc import Iterator
from pathlib import Path
from types import CodeType, FrameType
from typing import Any, NamedTuple

import pytest

ROOT = Path(__file__).parents[1]
SOURCE = ROOT / "src" / "stickslip"
FOLDER = ROOT / "results" / "entered"


class Entered(NamedTuple):
    """Processor seconds of a test, and the functions that it enters, by its fixtures too: "file.py:Class.method"."""

    seconds: float
    functions: frozenset[str]


class Recorder:
    """The plugin: what the code that runs now enters goes into `seen`."""

    def __init__(self) -> None:
        self.seen: set[CodeType] = set()
        self.path = FOLDER / f"{os.environ.get('PYTEST_XDIST_WORKER', 'alone')}.jsonl"

    def note(self, frame: FrameType, event: str, argument: Any) -> None:
        if event == "call":
            self.seen.add(frame.f_code)

    def functions(self) -> list[str]:
        """What was entered, of the package."""
        paths = {code: Path(code.co_filename) for code in self.seen}
        return sorted(
            {
                f"{path.relative_to(SOURCE)}:{code.co_qualname.partition('.<locals>')[0]}"
                for code, path in paths.items()
                if path.is_relative_to(SOURCE)
            }
        )

    def keep(self, **record: Any) -> None:
        FOLDER.mkdir(parents=True, exist_ok=True)
        with self.path.open("a") as file:
            file.write(json.dumps(record) + "\n")

    @pytest.hookimpl(hookwrapper=True)
    def pytest_fixture_setup(self, fixturedef: Any) -> Iterator[None]:
        """The fixtures that one asks for are set up before it."""
        before, self.seen = self.seen, set()
        sys.setprofile(self.note)
        yield
        sys.setprofile(None)
        self.keep(fixture=fixture_name(fixturedef), functions=self.functions())
        self.seen = before

    @pytest.hookimpl(hookwrapper=True)
    def pytest_runtest_call(self, item: Any) -> Iterator[None]:
        self.seen, began = set(), time.process_time()
        sys.setprofile(self.note)
        yield
        sys.setprofile(None)
        seconds = round(time.process_time() - began, 3)
        fixtures = [fixture_name(each) for several in item._fixtureinfo.name2fixturedefs.values() for each in several]
        text = digest_of(item.path)
        self.keep(test=item.nodeid, text=text, seconds=seconds, functions=self.functions(), fixtures=fixtures)


def digest_of(path: Path) -> str:
    return hashlib.sha256(path.read_bytes()).hexdigest()


def fixture_name(fixture: Any) -> str:
    return f"{fixture.baseid}::{fixture.argname}"


def pytest_configure(config: pytest.Config) -> None:
    config.pluginmanager.register(Recorder(), "entered")


def recorded() -> dict[str, Entered]:
    """The tests of the last recordings by their names."""
    tests, fixtures = dict[str, dict[str, Any]](), defaultdict[str, set[str]](set)
    for path in sorted(FOLDER.glob("*.jsonl"), key=lambda path: path.stat().st_mtime):
        for line in path.read_text().splitlines():
            each = json.loads(line)
            if "fixture" in each:
                fixtures[each["fixture"]] |= set(each["functions"])
            else:
                tests[each["test"]] = each
    # pytest cannot tell a test that is not there any more from one whose file the broken formula keeps from being read.
    texts = {name.partition("::")[0]: each["text"] for name, each in tests.items()}
    changed = [file for file, text in texts.items() if not (ROOT / file).is_file() or digest_of(ROOT / file) != text]
    if changed:
        raise SystemExit(f"Files of tests have changed since they were recorded: {' '.join(changed)}. Run make entered.")
    return {
        name: Entered(each["seconds"], frozenset(each["functions"]).union(*(fixtures[one] for one in each["fixtures"])))
        for name, each in tests.items()
    }
