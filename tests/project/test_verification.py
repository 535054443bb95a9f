"""The programs behind `make verify`, which run for an hour, can at least be begun, and keep a part of what they promise."""

import importlib
from pathlib import Path

import pytest
from each import each

from verify.__main__ import TOPICS, cpu_seconds

FILES = sorted(path.stem for path in (Path(__file__).parents[2] / "verify").glob("*.py") if "\ndef rows(" in path.read_text())
LONGEST = 60.0
"""CPU time of a topic, s, from which on it needs a `one_seed`, which yields a part of its rows, or the rows of one seed."""


def test_every_file_with_rows_is_a_topic():
    assert sorted(TOPICS) == FILES


@each("topic", TOPICS)
def test_every_topic_of_the_verification_finds_what_it_imports(topic):
    module = importlib.import_module(f"verify.{topic}")
    assert module.TITLE
    assert module.ABOUT
    assert callable(module.rows)


@pytest.mark.slow
@pytest.mark.parametrize("topic", FILES)
def test_one_seed_of_a_topic_keeps_its_promises(topic):
    module, started = importlib.import_module(f"verify.{topic}"), cpu_seconds()
    rows = list(getattr(module, "one_seed", module.rows)())
    assert rows
    assert [f"{row.name}: {row.value:g}, not within {row.tolerance:g}" for row in rows if not row.passed] == []
    assert cpu_seconds() - started < LONGEST
