"""Every measured number on a hand-written page has a source in docs/numbers.toml that computes it, and agrees with that."""

from fractions import Fraction
from pathlib import Path

import pytest
from each import each
from project.page_numbers import GENERATED, ROOT, faults, measured, pieces, register, verified

RECORDS = {*GENERATED.values(), "docs/decisions.md"}
"""Pages of what was measured once."""

PAGES = [ROOT / "README.md"]
PAGES += [path for path in sorted((ROOT / "docs").glob("*.md")) if str(path.relative_to(ROOT)) not in RECORDS]

ROW = "k_n at 103.9 N, Harris, N/m"  # 654357503.2, reference 654400000, tolerance 1e-4
TEST = "tests/disks/test_lumped_disk.py"


def test_every_measured_number_is_computed_somewhere() -> None:
    sources = register()
    names = {str(path.relative_to(ROOT)): path for path in PAGES}
    assert set(sources) <= set(names)
    found = [fault for name, path in names.items() for fault in faults(path.read_text(), sources.get(name, {}), name)]
    assert not found, "\n".join(found)


def test_the_register_is_read() -> None:
    assert verified()[ROW] == [654357503.2, 654400000.0, 1e-4]


@each(
    ("text", "numbers"),
    [
        ("at 529.3 Hz and 20 N", ["529.3"]),
        ("from 503 to 529 Hz", ["503", "529"]),
        ("5 and 2 % of 256 samples", ["5", "2"]),
        ("within 5·10⁻⁵ or 1e-8, not 10⁻⁴", ["5·10⁻⁵", "1e-8", "10⁻⁴"]),
        ("takes a 42nd of the time, 3 minutes", ["42nd", "3"]),
        ("64 per cent, 1.8 times", ["64", "1.8"]),
        ("26 µm/N against 31 µm/N", ["26", "31"]),
        ("C3D20R, B2a, 11.x, version 0.1.0, 20-node, 35°", []),
    ],
)
def test_what_counts_as_measured(text: str, numbers: list[str]) -> None:
    assert [number.text for _, number in measured(text)] == numbers


def test_code_formulas_and_targets_of_links_hold_no_measured_numbers() -> None:
    page = "```toml\nkt = 1.5\n```\n\n`kt = 1.5` and $k = 1.5$ in [this](https://a.b/1.5) and\n\n$$\n1.5\n$$\n"
    assert not faults(page, {})


def test_a_formula_that_is_a_power_of_ten_is_a_number() -> None:
    assert [number.value for piece in pieces(r"about $6\cdot 10^{-6}$") for _, number in piece.numbers()] == [Fraction(6, 10**6)]


@each(
    ("page", "sources"),
    [
        ("6.544e8 N/m", {"6.544e8": [f"verify: {ROW}"]}),  # value
        ("about 654 N/µm, to 1e-4", {"about": [f"verify: {ROW}"]}),  # a prefix of the unit; the promised bound
        ("654.4 and 634.5 N/µm", {"654.4": ["verify: k_n at 103.9 N, *, N/m"]}),
        ("**At** 654 N/µm and\n4.6 kg", {"At 654": [f"verify: {ROW}", "given: 4.6"]}),
        ("536 and 549 Hz", {"536": ["published: 536, 549; a paper"]}),
        ("| a | b |\n| --- | --- |\n| x | 654.4 |\n| y | 6.544e8 |", {"all of: a b": [f"verify: {ROW}"]}),
        ("| a | b |\n| --- | --- |\n| x | 654.4 |", {"x": [f"verify: {ROW}"]}),
        ("* x, 654.4\n* y, 6.544e8", {"all of: x,": [f"verify: {ROW}"]}),
        ("100.0 % of the problems", {"100.0 % of": ["robustness: constant load"]}),
        ("100.0 % of the problems", {"100.0 % of": ["robustness: # Robustness / varying load"]}),
    ],
)
def test_a_number_that_its_source_gives(page: str, sources: dict[str, list[str]]) -> None:
    assert faults(page, sources) == []


@each(
    ("page", "sources", "fault"),
    [
        ("655 N/µm", {"655": [f"verify: {ROW}"]}, "page:1: 655: not given by"),
        ("x\n\n6.543e8 N/m", {"6.543e8": [f"verify: {ROW}"]}, "page:3: 6.543e8: not given by"),
        ("6.544e8 N/m and 3.1 Hz", {"6.544e8": [f"verify: {ROW}"]}, "page:1: 3.1: not given by"),
        ("6.544e8 N/m\n\nmore words", {"more words": [f"verify: {ROW}"]}, "page:1: 6.544e8: no source"),
        ("x 6.544e8 N/m\n* y 6.544e8 N/m", {"x": [f"verify: {ROW}"]}, "page:2: 6.544e8: no source"),
        ("| a |\n| --- |\n| x 6.544e8 |\n| 6.544e8 |", {"x": [f"verify: {ROW}"]}, "page:4: 6.544e8: no source"),
        ("up to 100 %", {"up to": [f"verify: {ROW}"]}, "100: not given by"),
        ("6.544e8 N/m", {"6.544e8": ["verify: k_n at some other load"]}, "has no row"),
        ("0.5", {"0.5": ["test: tests/no_such_file.py::test_it"]}, "no file"),
        ("0.5", {"0.5": [f"test: {TEST}::test_that_is_not_there"]}, "has no test"),
        ("0.5", {"0.5": ["bench: no such problem"]}, "has no line"),
        ("0.5", {"0.5": ["guessed: 0.5"]}, "a source is one of"),
        ("4.7 kg", {"4.7": ["given: 4.6"]}, "4.7: not given by"),
        ("4.6 kg", {"4.6": ["given: 4.6, 80"]}, "80: no such number"),
        ("4.6 kg", {"4.6": ["given: "]}, "the numbers themselves"),
        ("536 Hz", {"536": ["published: 536"]}, "the publication must follow"),
        ("some", {"some": [f"verify: {ROW}"]}, "no such number"),
    ],
)
def test_a_number_without_its_source_is_found(page: str, sources: dict[str, list[str]], fault: str) -> None:
    found = faults(page, sources)
    assert any(fault in line for line in found), found


def test_a_test_gives_the_numbers_that_it_and_its_constants_hold(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("project.page_numbers.ROOT", tmp_path)
    (tmp_path / "test_a.py").write_text(
        "PEAK = {'x': 528.7}\nOTHER = 12.5\n\ndef test_a():\n    assert PEAK['x'] == 3.25\n\ndef test_b():\n    print(7.5)\n"
    )
    assert not faults("528.7 and 3.25", {"528.7": ["test: test_a.py::test_a"]})
    assert "not given" in faults("12.5 and 3.25", {"12.5": ["test: test_a.py::test_a"]})[0]
    assert any("asserts nothing" in fault for fault in faults("7.5", {"7.5": ["test: test_a.py::test_b"]}))
