"""Compute every promised number: `python -m verify [TOPIC ...]`. Writes results/verify.json and docs/verification.md.

A topic is a module of this folder with TITLE, ABOUT and rows(). Ends with code 1 when a row fails.
"""

from __future__ import annotations

import importlib
import json
import os
import subprocess
import sys
import time
from pathlib import Path

import stickslip
from verify.page import page

ROOT = Path(__file__).parents[1]
TOPICS = (
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
    "hostile_input",
    "disks",
    "damper_cycle",
    "identification",
)


def commit() -> str:
    """The commit that is verified, with a + when files differ from it."""
    try:
        name = _git("rev-parse", "--short=12", "HEAD")
        changed = _git("status", "--porcelain", "--untracked-files=no", "--", "src", "verify")
    except (OSError, subprocess.CalledProcessError):
        return "unknown"
    return name + ("+" if changed else "")


def _git(*arguments: str) -> str:
    return subprocess.run(["git", *arguments], cwd=ROOT, check=True, capture_output=True, text=True).stdout.strip()


def cpu_seconds() -> float:
    """CPU time of this process and of those it started, s."""
    return sum(os.times()[:4])


def computed(name: str) -> dict[str, object]:
    """One topic with its rows and the CPU time that they took."""
    module = importlib.import_module(f"verify.{name}")
    started = cpu_seconds()
    rows = [row.as_dict() for row in module.rows()]
    for row in rows:
        print(f"  {'passed' if row['passed'] else 'FAILED'}  {row['name']}: {row['value']:.10g}", flush=True)
    return {
        "topic": name,
        "title": module.TITLE,
        "about": module.ABOUT,
        "cpu_seconds": time.process_time() - started,
        "rows": rows,
    }


def main(wanted: list[str]) -> int:
    sys.path.insert(0, str(ROOT / "tests"))
    unknown = sorted(set(wanted) - set(TOPICS))
    if unknown:
        print(f"Unknown topic {', '.join(unknown)}. Topics: {', '.join(TOPICS)}.")
        return 2
    topics = []
    for name in wanted or TOPICS:
        print(name, flush=True)
        topics.append(computed(name))
    result = {"version": stickslip.__version__, "commit": commit(), "date": time.strftime("%Y-%m-%d"), "topics": topics}
    target = ROOT / "results" / "verify.json"
    target.parent.mkdir(exist_ok=True)
    target.write_text(json.dumps(result, indent=1) + "\n")
    if not wanted:
        (ROOT / "docs" / "verification.md").write_text(page(result))
    failed = [row["name"] for topic in topics for row in topic["rows"] if not row["passed"]]
    print(
        f"{sum(len(topic['rows']) for topic in topics)} numbers, {len(failed)} failed" + "".join(f"\n  {name}" for name in failed)
    )
    return 1 if failed else 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
