"""Formulas broken at random, which the quick tests of their room must notice: `make mutants-drawn`.

    python -m tools.drawn_mutants [--seed 1] [--count 300] [--limit SECONDS] [ROOM ...]

`tools/formulas.py` lists all changes; each room gives as many to the sample as it has of them, by a seed. A change is tried with
the tests that enter its function (`tools/entered.py`), or one that names the kernel or constant it is in. Each result is a line
of results/mutation.jsonl, so that an interrupted run goes on; docs/mutation.md is written at the end, also after Ctrl-C. What is
equal or dead is listed under `equivalent` in tests/mutants.toml, by its lines, with the reason.
"""

from __future__ import annotations

import argparse
import ast
import hashlib
import json
import os
import random
import signal
import sys
import tomllib
from collections import Counter, defaultdict
from collections.abc import Iterator
from datetime import UTC, datetime
from pathlib import Path
from typing import NamedTuple

from scipy.stats import beta

from tools.commits import commit
from tools.entered import recorded
from tools.formulas import Drawable, of_file
from tools.mutants import NONE, ROOT, SOURCE, copied_package, outcome
from tools.near_kernels import changed, decorators, holders, names_in

RESULTS = ROOT / "results" / "mutation.jsonl"
PAGE = ROOT / "docs" / "mutation.md"
ROOMS = (
    "model/contact",
    "model/dampers",
    "model/disks",
    "model/interfaces",
    "model/problem",
    "model/readers",
    "model/rigs",
    "model/structure",
    "solve/balance",
    "solve/continuation",
    "solve/curves",
    "solve/peaks",
    "solve/platforms",
    "solve/stability",
    "solve/wheels",
    "solve/starts",
    "solve/time",
    "results",
    "support",
    "analyses",
    "analyses/damper_alone",
    "analyses/mistuning",
    "analyses/modes",
    "analyses/performance",
    "analyses/speed",
    "analyses/variability",
    "laboratory/identification",
    "laboratory/identification/contact_law",
    "laboratory/identification/damper",
    "laboratory/identification/response",
    "laboratory/measurement",
    "study",
    "study/analyses",
)
"""The rooms with formulas."""
COMPILED = ("kernel", "inner", "inlined", "separate", "numbered", "overload")
"""Decorators of functions that Python does not enter."""
FIRST = 40
"""Tests of the first run of each change, those that enter least."""
LIMIT = 240.0
"""Seconds of each run of pytest."""


class Result(NamedTuple):
    """What the tests did with a change, which is known by its file and by its lines."""

    file: str
    old: str
    new: str
    kind: str
    outcome: str
    seconds: float
    source: str
    tests: str

    def holds(self, source: str, tests: str, late: bool = False) -> bool:
        """Whether it tells of these sources: tests that grow go on noticing what they noticed. One that was late may end now."""
        same = self.tests == tests and (late or self.outcome != "out of time")
        return self.source == source and (same or self.outcome == "killed")


def places(rooms: list[str]) -> dict[str, list[Drawable]]:
    """All changes of the formulas of each room."""
    files = {room: [str(path.relative_to(SOURCE)) for path in sorted((SOURCE / room).glob("*.py"))] for room in rooms}
    return {room: [each for file in files[room] for each in of_file(file, (SOURCE / file).read_text())] for room in rooms}


def drawn(found: dict[str, list[Drawable]], count: int, seed: int) -> dict[str, list[Drawable]]:
    """A sample in which each room has its share, by largest remainders."""
    total = sum(map(len, found.values()))
    shares = {room: count * len(each) / total for room, each in found.items()}
    left = count - sum(map(int, shares.values()))
    more = sorted(shares, key=lambda room: (int(shares[room]) - shares[room], room))[:left]
    return {
        room: random.Random(f"{seed}/{room}").sample(each, min(len(each), int(shares[room]) + (room in more)))
        for room, each in found.items()
    }


class Tests:
    """The quick tests that enter a function, or name what a change defines, those that enter least first."""

    def __init__(self) -> None:
        self.texts = {str(path.relative_to(SOURCE)): path.read_text() for path in sorted(SOURCE.rglob("*.py"))}
        self.recorded = recorded()
        if not self.recorded:
            raise SystemExit("No test was recorded: run `make mutants-drawn`, which does so first.")
        self.entering = defaultdict(set[str])
        for name, test in self.recorded.items():
            for function in test.functions:
                self.entering[function].add(name)
        self.naming: dict[str, set[str]] = defaultdict(set)
        for file, text in self.texts.items():
            for function, node in functions_of(ast.parse(text)):
                for each in names_in(node):
                    self.naming[each].add(f"{file}:{function}")

    def of(self, change: Drawable) -> list[str]:
        """Tests that may notice a change."""
        text = self.texts[change.file]
        line = text.encode()[: change.start].count(b"\n") + 1
        around = [(name, node) for name, node in functions_of(ast.parse(text)) if node.lineno <= line <= (node.end_lineno or 0)]
        functions = {f"{change.file}:{name}" for name, _ in around}
        if not around or any(each.startswith(COMPILED) for _, node in around for each in decorators(node)):
            names = set(changed(text, change.broken(text)))
            functions |= {function for name in holders(self.texts, names) for function in self.naming[name]}
        found = {name for function in functions for name in self.entering.get(function, ())}
        return sorted(found, key=lambda name: (len(self.recorded[name].functions), self.recorded[name].seconds, name))


def functions_of(tree: ast.Module) -> Iterator[tuple[str, ast.FunctionDef]]:
    """The functions and methods of a file, "Class.method", with what stands in them."""
    for statement in tree.body:
        if isinstance(statement, ast.FunctionDef):
            yield statement.name, statement
        elif isinstance(statement, ast.ClassDef):
            yield from ((f"{statement.name}.{each.name}", each) for each in statement.body if isinstance(each, ast.FunctionDef))


def identity(change: Drawable, tests: list[str]) -> tuple[tuple[str, str, str], str, str]:
    """File and lines of a change, and digests of its file and of the tests that may notice it."""
    text = (SOURCE / change.file).read_text()
    files = sorted({name.partition("::")[0] for name in tests})
    return (change.file, *change.lines(text)), digest(text), digest(*tests, *((ROOT / file).read_text() for file in files))


def digest(*texts: str) -> str:
    return hashlib.sha256("".join(texts).encode()).hexdigest()[:16]


def equivalent() -> set[tuple[str, str, str]]:
    """File, line and broken line of the changes of tests/mutants.toml that change nothing."""
    files = tomllib.loads((ROOT / "tests" / "mutants.toml").read_text())
    return {(file, each["old"], each["new"]) for file, content in files.items() for each in content.get("equivalent", [])}


def earlier() -> dict[tuple[str, str, str], Result]:
    """The last result of each change."""
    lines = RESULTS.read_text().splitlines() if RESULTS.is_file() else []
    results = [Result(**json.loads(line)) for line in lines]
    return {(each.file, each.old, each.new): each for each in results}


def run(sample: dict[str, list[Drawable]], seed: int, limit: float, tests: Tests) -> None:
    """Tests each change of a sample whose result is not known yet, with few tests, then with all others that may notice it."""
    known, ignored = earlier(), equivalent()
    changes = [change for several in sample.values() for change in several]
    with copied_package() as folder:
        for change in random.Random(seed).sample(changes, len(changes)):
            names = tests.of(change)
            identified = key, *sources = identity(change, names)
            if key in ignored or holds(known, identified):
                continue
            text, began, found = (SOURCE / change.file).read_text(), processor_seconds(), "survives"
            for some in (names[:FIRST], names[FIRST:]):
                if some and found == "survives":
                    found = noticed(change, text, some, folder, limit)
            seconds = processor_seconds() - began
            result = Result(*key, change.kind, found, round(seconds, 1), *sources)
            with RESULTS.open("a") as file:
                file.write(json.dumps(result._asdict()) + "\n")
            sys.stdout.write(f"{found:11} {change.kind:9} {seconds:5.0f} s  {change.file}: {key[1]}  ->  {key[2]}\n")
            sys.stdout.flush()


def noticed(change: Drawable, text: str, tests: list[str], folder: Path, limit: float) -> str:
    """What some tests do with a change."""
    found = outcome(change.file, change.broken(text), tests, folder, limit)
    if found == f"pytest ended with {NONE}":
        return "survives"
    return "killed" if found.startswith("pytest ended") else found


def holds(known: dict[tuple[str, str, str], Result], identity: tuple[tuple[str, str, str], str, str]) -> bool:
    """Whether the result of a change is known for the sources as they are."""
    key, *sources = identity
    return key in known and known[key].holds(*sources)


def processor_seconds() -> float:
    """Processor time of the children that have ended."""
    return sum(os.times()[2:4])


def page(sample: dict[str, list[Drawable]], sizes: dict[str, int], command: str, tests: Tests) -> str:
    """The score of each room, and the changes that no test notices."""
    known, ignored = earlier(), equivalent()
    rows, survivors, totals, seconds = [], [], Counter[str](), 0.0
    for room, changes in sample.items():
        identities = [identity(change, tests.of(change)) for change in changes]
        run_now = [known[key] for key, *sources in identities if key in known and known[key].holds(*sources, late=True)]
        results = [each for each in run_now if each[:3] not in ignored]
        counts = Counter(each.outcome for each in results) | Counter(equivalent=sum(key in ignored for key, *_ in identities))
        counts |= Counter(drawn=len(changes), run=len(results))
        seconds += sum(each.seconds for each in results)
        totals += counts
        survivors += [f"* `{each.file}`: `{each.old}` → `{each.new}`" for each in results if each.outcome == "survives"]
        rows += [row(room, sizes[room], counts)] if changes else []
    missed, decided = totals["survives"], totals["killed"] + totals["survives"]
    most = beta.ppf(0.95, missed + 1, decided - missed) if decided > missed else 1.0
    listed = "\n".join(survivors) or "None."
    undecided = totals["drawn"] - totals["run"] - totals["equivalent"]
    share = (
        f"{100.0 * missed / max(decided, 1):.1f} %; of all {sum(sizes.values())} possible ones\nat most {100.0 * most:.0f} % "
        "with 95 % confidence, unless tests were written for the survivors of this seed: then take another\nseed"
    )
    if undecided:
        share += f"; {undecided} more of the sample are not run"
    return f"""# Formulas broken at random

`make mutants-drawn` breaks formulas of the package one at a time: an operator, a sign, a direction of a comparison, a
conjugate, a transpose, a factor, an index or axis, a unit, min for max, cos for sin. Of all such changes it draws a sample by a
seed, from each room as many as it has of them, and runs the quick tests that enter the broken function until one fails.

**{missed} of {decided} changes survive** ({share}).
Changes without effect are listed with the reason in `tests/mutants.toml` and do not count; a run that takes too long is
neither noticed nor survives. A change takes {seconds / max(totals["run"], 1):.0f} s of processor time.

| room | possible | drawn | noticed | survive | equivalent | out of time | not run |
| --- | --- | --- | --- | --- | --- | --- | --- |
{chr(10).join(rows)}
{row("all", sum(sizes.values()), totals)}

Measured on {datetime.now(UTC):%Y-%m-%d} at commit `{commit("src", "tests")}` by `{command}`.

## What no quick test notices

{listed}
"""


def row(room: str, size: int, counts: Counter[str]) -> str:
    missing = counts["drawn"] - counts["run"] - counts["equivalent"]
    cells = (size, *(counts[name] for name in ("drawn", "killed", "survives", "equivalent", "out of time")), missing)
    return f"| {room} | {' | '.join(map(str, cells))} |"


def main(arguments: list[str]) -> int:
    parser = argparse.ArgumentParser(prog="python -m tools.drawn_mutants", description=__doc__.splitlines()[0])
    parser.add_argument("rooms", nargs="*", metavar="ROOM", choices=[*ROOMS, []], help="only these rooms")  # none: all
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--count", type=int, default=300)
    parser.add_argument("--limit", type=float, default=LIMIT, help="seconds of each run of pytest")
    options = parser.parse_args(arguments)
    found = places(options.rooms or list(ROOMS))
    sample = drawn(found, options.count, options.seed)
    RESULTS.parent.mkdir(exist_ok=True)
    tests = Tests()
    try:
        run(sample, options.seed, options.limit, tests)
    except KeyboardInterrupt:
        sys.stdout.write("Interrupted; the same command goes on from here.\n")
        return 130
    finally:
        command = " ".join(["python -m tools.drawn_mutants", *arguments])
        PAGE.write_text(page(sample, {room: len(each) for room, each in found.items()}, command, tests))
    return 0


if __name__ == "__main__":
    for each in (signal.SIGINT, signal.SIGTERM):  # ignored in the background of a script, or without an end of the tests
        signal.signal(each, signal.default_int_handler)
    sys.exit(main(sys.argv[1:]))
