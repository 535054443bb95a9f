"""Which functions of the package each quick test enters, for `tools/drawn_mutants.py`.

    python -m pytest -p tools.entered -m QUICK tests

As a plugin of pytest it writes results/entered/WORKER.json: what each test and each fixture enters, in Python. Compiled kernels
are not seen: those who call them are. A recording of new tests alone adds to what is there.
"""

from __future__ import annotations

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
        self.tests: dict[str, tuple[float, list[str], list[str]]] = {}
        self.fixtures: dict[str, set[str]] = defaultdict(set)

    def note(self, frame: FrameType, event: str, argument: Any) -> None:
        if event == "call":
            self.seen.add(frame.f_code)

    def functions(self) -> set[str]:
        """What was entered, of the package."""
        paths = {code: Path(code.co_filename) for code in self.seen}
        return {
            f"{path.relative_to(SOURCE)}:{code.co_qualname.partition('.<locals>')[0]}"
            for code, path in paths.items()
            if path.is_relative_to(SOURCE)
        }

    @pytest.hookimpl(hookwrapper=True)
    def pytest_fixture_setup(self, fixturedef: Any) -> Iterator[None]:
        """The fixtures that one asks for are set up before it."""
        before, self.seen = self.seen, set()
        sys.setprofile(self.note)
        yield
        sys.setprofile(None)
        self.fixtures[fixture_name(fixturedef)] |= self.functions()
        self.seen = before

    @pytest.hookimpl(hookwrapper=True)
    def pytest_runtest_call(self, item: Any) -> Iterator[None]:
        self.seen, began = set(), time.process_time()
        sys.setprofile(self.note)
        yield
        sys.setprofile(None)
        seconds = time.process_time() - began
        fixtures = [fixture_name(each) for several in item._fixtureinfo.name2fixturedefs.values() for each in several]
        self.tests[item.nodeid] = seconds, sorted(self.functions()), fixtures

    def pytest_sessionfinish(self) -> None:
        if not self.tests:
            return
        FOLDER.mkdir(parents=True, exist_ok=True)
        fixtures = {name: sorted(functions) for name, functions in self.fixtures.items()}
        content = json.dumps({"tests": self.tests, "fixtures": fixtures})
        (FOLDER / f"{os.environ.get('PYTEST_XDIST_WORKER', 'alone')}.json").write_text(content)


def fixture_name(fixture: Any) -> str:
    return f"{fixture.baseid}::{fixture.argname}"


def pytest_configure(config: pytest.Config) -> None:
    config.pluginmanager.register(Recorder(), "entered")


def recorded() -> dict[str, Entered]:
    """The tests of the last recording by their names."""
    found = {}
    for path in sorted(FOLDER.glob("*.json"), key=lambda path: path.stat().st_mtime):
        content = json.loads(path.read_text())
        for name, (seconds, functions, fixtures) in content["tests"].items():
            by_fixtures = (content["fixtures"].get(each, ()) for each in fixtures)
            found[name] = Entered(seconds, frozenset(functions).union(*by_fixtures))
    return found
