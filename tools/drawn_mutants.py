"""Formulas broken at random, which the quick tests of their room must notice: `make mutants-drawn`.

    python -m tools.drawn_mutants [--seed 1] [--count 300] [--limit SECONDS] [ROOM ...]

`tools/formulas.py` lists all changes; each room gives as many to the sample as it has of them, by a seed. Each result is a line
of results/mutation.jsonl, so that an interrupted run goes on; docs/mutation.md is written at the end, also after Ctrl-C. What is
equal or dead is listed under `equivalent` in tests/mutants.toml, by its lines, with the reason.
"""

from __future__ import annotations

import argparse
import ast
import hashlib
import itertools
import json
import os
import random
import re
import signal
import sys
import time
import tomllib
from collections import Counter
from datetime import UTC, datetime
from pathlib import Path
from typing import NamedTuple

from scipy.stats import beta

from tools.commits import commit
from tools.formulas import Drawable, of_file
from tools.mutants import NONE, PASSED, ROOT, SOURCE, copied_package, outcome, tested

RESULTS = ROOT / "results" / "mutation.jsonl"
PAGE = ROOT / "docs" / "mutation.md"
ROOMS = {
    "model/contact": ["laws"],
    "model/dampers": ["dampers", "rigs"],
    "model/disks": ["disks"],
    "model/interfaces": ["interfaces", "structure", "rigs"],
    "model/problem": ["problem", "physics"],
    "model/readers": ["readers"],
    "model/rigs": ["rigs", "physics"],
    "model/structure": ["structure", "disks", "study/test_surfaces_study.py"],
    "solve/balance": ["balance", "robustness", "physics", "analyses/modes", "problem/test_truncation.py"],
    "solve/continuation": ["continuation", "robustness", "analyses", "physics"],
    "solve/curves": ["analyses", "problem"],
    "solve/peaks": ["peaks", "robustness", "analyses"],
    "solve/platforms": ["analyses/damper_alone", "identification", "study/test_damper_cycle_study.py"],
    "solve/stability": ["stability", "laws", "analyses"],
    "solve/wheels": ["wheels", "analyses/mistuning"],
    "solve/starts": ["analyses/variability", "identification"],
    "solve/time": ["time_domain", "analyses/damper_alone"],
    "results": ["results", "report", "analyses"],
    "support": ["study/test_units_of_lengths.py", "study/test_units_of_tables.py", "results", "analyses", "physics"],
    "analyses": ["analyses", "physics", "time_domain", "stability"],
    "analyses/damper_alone": ["analyses/damper_alone", "study"],
    "analyses/mistuning": ["analyses/mistuning", "disks"],
    "analyses/modes": ["analyses/modes", "identification"],
    "analyses/performance": ["analyses/performance", "study"],
    "analyses/speed": ["analyses/speed", "study"],
    "analyses/variability": ["analyses/variability", "identification"],
    "laboratory/identification": ["identification"],
    "laboratory/identification/contact_law": ["identification"],
    "laboratory/identification/damper": ["identification"],
    "laboratory/identification/response": ["identification"],
    "laboratory/measurement": ["measurement", "identification"],
    "study": ["study"],
    "study/analyses": ["study"],
}
"""The rooms with formulas, and what tests them below tests/."""
BATCHES = (0, 2, 8, None)
"""Where the batches of a room's files of tests begin and end."""
PATIENCE = 3.0
"""How many times as long as with the whole formulas the tests of a room may take."""


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


def tests_of(room: str) -> list[Path]:
    """The files of tests of a room."""
    named = [ROOT / "tests" / name for name in ROOMS[room]]
    return [path for each in named for path in (sorted(each.rglob("test_*.py")) if each.is_dir() else [each])]


def nearest_first(tests: list[Path], text: str, change: Drawable) -> list[str]:
    """Those that name the broken file come first, then those that name its folder and what it defines: what fails comes early."""
    module = ".".join(Path(change.file).with_suffix("").parts)
    defined = {node.name for node in ast.walk(ast.parse(text)) if isinstance(node, ast.FunctionDef | ast.ClassDef)}

    def said(path: Path) -> tuple[int, int, int]:
        content = path.read_text()
        names = sum(name in defined for name in re.findall(r"\b[a-zA-Z]\w+", content))
        own = content.count(module) + (Path(change.file).stem in path.stem)
        return own, content.count(module.rpartition(".")[0]), names

    return [str(path.relative_to(ROOT)) for path in sorted(tests, key=said, reverse=True)]


def identity(room: str, change: Drawable) -> tuple[tuple[str, str, str], str, str]:
    """File and lines of a change, and digests of its file and of the tests of its room."""
    text = (SOURCE / change.file).read_text()
    return (change.file, *change.lines(text)), digest(text), digest(*(path.read_text() for path in tests_of(room)))


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


def run(sample: dict[str, list[Drawable]], seed: int, limit: float | None) -> None:
    """Tests each change of a sample whose result is not known yet: all of them with the tests nearest to them, then what these do
    not notice with more, rooms mixed. To read the tests of a whole room takes longer than to run a few."""
    known, ignored = earlier(), equivalent()
    pairs = [(room, change) for room, changes in sample.items() for change in changes]
    left = [(*pair, identity(*pair), 0.0) for pair in random.Random(seed).sample(pairs, len(pairs))]
    left = [each for each in left if each[2][0] not in ignored and not holds(known, each[2])]
    patience = dict.fromkeys(sample, limit)
    with copied_package() as folder:
        for first, end in itertools.pairwise(BATCHES):
            further = []
            for room, change, (key, *sources), seconds in left:
                text = (SOURCE / change.file).read_text()
                tests = nearest_first(tests_of(room), text, change)
                patience[room] = patience[room] or PATIENCE * unbroken_seconds(room, folder)
                began = processor_seconds()
                found = noticed(change, text, tests[first:end], folder, patience[room])
                seconds += processor_seconds() - began
                if found == "survives" and tests[first:end] != tests[first:]:
                    further.append((room, change, (key, *sources), seconds))
                    continue
                result = Result(*key, change.kind, found, round(seconds, 1), *sources)
                with RESULTS.open("a") as file:
                    file.write(json.dumps(result._asdict()) + "\n")
                sys.stdout.write(f"{found:11} {change.kind:9} {seconds:5.0f} s  {change.file}: {key[1]}  ->  {key[2]}\n")
                sys.stdout.flush()
            left = further


def noticed(change: Drawable, text: str, tests: list[str], folder: Path, limit: float) -> str:
    """What some files of tests, of which all may be slow, do with a change."""
    found = outcome(change.file, change.broken(text), tests, folder, limit)
    if found == f"pytest ended with {NONE}":
        return "survives"
    return "killed" if found.startswith("pytest ended") else found


def holds(known: dict[tuple[str, str, str], Result], identity: tuple[tuple[str, str, str], str, str]) -> bool:
    """Whether the result of a change is known for the sources as they are."""
    key, *sources = identity
    return key in known and known[key].holds(*sources)


def unbroken_seconds(room: str, folder: Path) -> float:
    """Seconds that the tests of a room take while nothing is broken."""
    began = time.monotonic()
    if tested([str(path) for path in tests_of(room)], folder) != PASSED:
        raise SystemExit(f"The tests of {room} must pass before anything is broken.")
    return time.monotonic() - began


def processor_seconds() -> float:
    """Processor time of the children that have ended."""
    return sum(os.times()[2:4])


def page(sample: dict[str, list[Drawable]], sizes: dict[str, int], command: str) -> str:
    """The score of each room, and the changes that no test notices."""
    known, ignored = earlier(), equivalent()
    rows, survivors, totals, seconds = [], [], Counter[str](), 0.0
    for room, changes in sample.items():
        identities = [identity(room, change) for change in changes]
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
        share = (
            f"{undecided} more of the sample are not decided, among them\nthose that the nearest tests did not notice, so that "
            "this is no share of all"
        )
    return f"""# Formulas broken at random

`make mutants-drawn` breaks formulas of the package one at a time: an operator, a sign, a direction of a comparison, a
conjugate, a transpose, a factor, an index or axis, a unit, min for max, cos for sin. Of all such changes it draws a sample by a
seed, from each room as many as it has of them, and runs the quick tests of that room until one fails.

**{missed} of {decided} changes survive** ({share}).
Changes without effect are listed with the reason in `tests/mutants.toml` and do not count; a run that takes too long is
neither noticed nor survives. A change takes {seconds / max(totals["run"], 1):.0f} s of processor time.

| room | possible | drawn | noticed | survive | equivalent | out of time | not run |
| --- | --- | --- | --- | --- | --- | --- | --- |
{chr(10).join(rows)}
{row("all", sum(sizes.values()), totals)}

Measured on {datetime.now(UTC):%Y-%m-%d} at commit `{commit("src", "tests")}` by `{command}`.

## What no quick test of its room notices

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
    parser.add_argument("--limit", type=float, help="seconds for each change; else by the unbroken tests of its room")
    options = parser.parse_args(arguments)
    found = places(options.rooms or list(ROOMS))
    sample = drawn(found, options.count, options.seed)
    RESULTS.parent.mkdir(exist_ok=True)
    try:
        run(sample, options.seed, options.limit)
    except KeyboardInterrupt:
        sys.stdout.write("Interrupted; the same command goes on from here.\n")
        return 130
    finally:
        command = " ".join(["python -m tools.drawn_mutants", *arguments])
        PAGE.write_text(page(sample, {room: len(each) for room, each in found.items()}, command))
    return 0


if __name__ == "__main__":
    for each in (signal.SIGINT, signal.SIGTERM):  # ignored in the background of a script, or without an end of the tests
        signal.signal(each, signal.default_int_handler)
    sys.exit(main(sys.argv[1:]))
