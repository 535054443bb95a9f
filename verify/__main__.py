"""Compute every promised number: `python -m verify [TOPIC ...]`. Writes results/verify.json, and docs/verification.md from it.

A topic is a module of this folder with TITLE, ABOUT and rows(), and with one_seed() if they take more than a minute: a part of
them, or the same for one seed, which `tests/project/test_verification.py` computes. A topic is kept as soon as it is finished,
with its commit: without a TOPIC, those that this commit has finished already are left out, so an interrupted run goes on. Ends
with code 1 when a row fails.
"""

from __future__ import annotations

import importlib
import json
import os
import sys
import time
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import stickslip
from stickslip.support.files import write_text
from tools.commits import commit, settled
from verify.page import page
from verify.row import Row

ROOT = Path(__file__).parents[1]
KEPT = ROOT / "results" / "verify.json"
PAGE = ROOT / "docs" / "verification.md"
FOLDERS = ("src", "verify")
"""What a topic's numbers come from."""
TOPICS = (
    "published",
    "single_contact",
    "one_mass",
    "linear_limits",
    "derivatives",
    "newton_system",
    "other_codes",
    "wedge",
    "single_blade",
    "variability",
    "performance",
    "modes",
    "hostile_input",
    "disks",
    "stability",
    "damper_cycle",
    "identification",
    "response_identification",
)


def cpu_seconds() -> float:
    """CPU time of this process and of those it started, s."""
    return sum(os.times()[:4])


def computed(name: str) -> dict[str, Any]:
    """One topic with its rows, the commit, and the CPU time that they took."""
    module = importlib.import_module(f"verify.{name}")
    started = cpu_seconds()
    rows = [row.as_dict() for row in said(module.rows())]
    about = {"title": module.TITLE, "about": module.ABOUT, "cpu_seconds": cpu_seconds() - started}
    return {
        **about,
        "version": stickslip.__version__,
        "commit": commit(*FOLDERS),
        "date": time.strftime("%Y-%m-%d"),
        "rows": rows,
    }


def said(rows: Iterator[Row]) -> Iterator[Row]:
    """The rows, each printed as soon as it is known."""
    for row in rows:
        print(f"  {'passed' if row.passed else 'FAILED'}  {row.name}: {row.value:.10g}", flush=True)
        yield row


def kept() -> dict[str, dict[str, Any]]:
    """The topics of earlier runs, by name."""
    return json.loads(KEPT.read_text()) if KEPT.is_file() else {}


def finished(topic: dict[str, Any] | None) -> bool:
    """Whether a topic was computed by this very commit."""
    return topic is not None and topic["commit"] == commit(*FOLDERS) and settled(topic["commit"])


def keep(name: str, topic: dict[str, Any]) -> None:
    """Write a topic beside those that are kept by now, and the page of them all."""
    topics = {**kept(), name: topic}
    write_text(KEPT, json.dumps(topics, indent=1) + "\n")
    missing = [name for name in TOPICS if name not in topics]
    write_text(PAGE, page([topics[name] for name in TOPICS if name in topics], missing))


def main(wanted: list[str]) -> int:
    sys.path.insert(0, str(ROOT / "tests"))
    unknown = sorted(set(wanted) - set(TOPICS))
    if unknown:
        print(f"Unknown topic {', '.join(unknown)}. Topics: {', '.join(TOPICS)}.")
        return 2
    before = kept()
    for name in wanted or [name for name in TOPICS if not finished(before.get(name))]:
        print(name, flush=True)
        keep(name, computed(name))
    after = kept()
    rows = [row for name in wanted or TOPICS for row in after[name]["rows"]]
    failed = [row["name"] for row in rows if not row["passed"]]
    print(f"{len(rows)} numbers, {len(failed)} failed" + "".join(f"\n  {name}" for name in failed))
    return 1 if failed else 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
