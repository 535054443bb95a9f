"""The documentation page of results/verify.json."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

INTRODUCTION = """\
# Verification

Numbers that this package promises, computed by `make verify` and written to `results/verify.json`; this page is generated from
that file. {passed} of {total} numbers are within their tolerance.{missing}

Errors are relative to the reference unless marked abs; rows without a reference are bounds on the value itself.
"""


def number(value: float | None) -> str:
    """A value with ten digits at most."""
    return "" if value is None else f"{value:.10g}"


def line(row: dict[str, Any]) -> str:
    """One row of a table."""
    mark = " abs" if row["kind"] == "absolute" else ""
    error = "" if row["kind"] == "at most" else f"{row['error']:.1e}{mark}"
    name = row["name"].replace("|", r"\|")
    cells = [name, number(row["value"]), number(row["reference"]), error, f"{row['tolerance']:.1e}", row["source"]]
    return "| " + " | ".join((*cells, "yes" if row["passed"] else "**no**")) + " |"


def section(topic: dict[str, Any]) -> str:
    """One topic: title, what it shows, table."""
    head = "| number | value | reference | error | tolerance | source | met |\n| --- | --- | --- | --- | --- | --- | --- |"
    lines = "\n".join(line(row) for row in topic["rows"])
    computed = f"Version {topic['version']}, commit `{topic['commit']}`, {topic['date']}, {topic['cpu_seconds']:.0f} s CPU."
    return f"\n## {topic['title']}\n\n{topic['about']} {computed}\n\n{head}\n{lines}\n"


def page(topics: Sequence[dict[str, Any]], missing: Sequence[str]) -> str:
    """The whole page: the topics that are there, and the names of those that are not."""
    rows = [row for topic in topics for row in topic["rows"]]
    passed = sum(bool(row["passed"]) for row in rows)
    said = f" Not yet computed for this page: {', '.join(missing)}." if missing else ""
    return INTRODUCTION.format(passed=passed, total=len(rows), missing=said) + "".join(map(section, topics))
