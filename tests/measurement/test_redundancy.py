"""Every redundancy of a measured table is used: what contradicts itself is refused, or said, but not read as another test."""

from pathlib import Path
from random import Random

import pytest
from measurement.redundancy import LAYOUTS, SoundTable, counts
from readers.redundancy import CLASSES

PAGE = Path(__file__).parents[2] / "docs" / "response_identification.md"
QUICKLY, THOROUGHLY = 40, 200
"""Faults of each class and layout."""


def answers(folder, layout, number):
    """How often faults of each class got each answer."""
    sound = SoundTable(folder / "one", layout)
    return {group: counts(sound, group, Random(f"{layout} {group}"), number) for group in CLASSES}


@pytest.mark.parametrize("layout", LAYOUTS)
def test_no_fault_that_shows_is_read_as_another_test(layout, tmp_path):
    found = answers(tmp_path, layout, QUICKLY)
    assert {group: answer["seen"] for group, answer in found.items()} == dict.fromkeys(CLASSES, 0)
    assert sum(answer["refused"] for answer in found.values()) > 2 * QUICKLY


@pytest.mark.nightly
@pytest.mark.parametrize("layout", LAYOUTS)
def test_the_table_of_the_page(layout, tmp_path):
    """A row of docs/response_identification.md: of the faults of each class the refused, those that change nothing, those said or
    not to be seen."""
    assert row(layout, answers(tmp_path, layout, THOROUGHLY)) in PAGE.read_text(encoding="utf-8").splitlines()


def row(layout, found):
    cells = [f"{answer['refused']} / {answer['same']} / {answer['said']} / {answer['unseen']}" for answer in found.values()]
    return f"| {layout} | {' | '.join(cells)} | {sum(answer['seen'] for answer in found.values())} |"
