"""Every measured number on a hand-written page has a marker that names what computes it, and agrees with that."""

from fractions import Fraction
from pathlib import Path

import pytest
from each import each
from project.page_numbers import GENERATED, ROOT, faults, measured, pieces, verified

PAGES = [path for path in sorted((ROOT / "docs").glob("*.md")) if str(path.relative_to(ROOT)) not in GENERATED.values()] + [
    ROOT / "README.md"
]

ROW = "k_n at 103.9 N, Harris, N/m"  # 654357503.2, reference 654400000, tolerance 1e-4
TEST = "tests/disks/test_lumped_disk.py"


def test_every_measured_number_is_computed_somewhere() -> None:
    found = [fault for path in PAGES for fault in faults(path.read_text(), str(path.relative_to(ROOT)))]
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
    assert not faults(page)


def test_a_formula_that_is_a_power_of_ten_is_a_number() -> None:
    assert [number.value for piece in pieces(r"about $6\cdot 10^{-6}$") for _, number in piece.numbers()] == [Fraction(6, 10**6)]


@each(
    "page",
    [
        f"6.544e8 N/m <!-- verify: {ROW} -->",  # value
        f"about 654 N/µm, to 1e-4 <!-- verify: {ROW} -->",  # a prefix of the unit; the promised bound
        "654.4 and 634.5 N/µm <!-- verify: k_n at 103.9 N, *, N/m -->",
        f"654 N/µm at 4.6 kg <!-- verify: {ROW} --> <!-- given: 4.6 -->",
        "536 and 549 Hz <!-- published: 536, 549; a paper -->",
        f"<!-- verify: {ROW} -->\n| a | b |\n| --- | --- |\n| x | 654.4 |\n| y | 6.544e8 |",
        f"| a | b |\n| --- | --- |\n| x | 654.4 <!-- verify: {ROW} --> |",
        "100.0 % of the problems <!-- robustness: constant load -->",
        "100.0 % of the problems <!-- robustness: # Robustness / varying load -->",
    ],
)
def test_numbers_with_their_markers_pass(page: str) -> None:
    assert not faults(page)


@each(
    ("page", "fault"),
    [
        ("peak at 529.3 Hz", "page:1: 529.3: no marker"),
        (f"655 N/µm <!-- verify: {ROW} -->", "page:1: 655: not given by"),
        (f"x\n\n6.543e8 N/m <!-- verify: {ROW} -->", "page:3: 6.543e8: not given by"),
        (f"6.544e8 N/m and 3.1 Hz <!-- verify: {ROW} -->", "page:1: 3.1: not given by"),
        (f"6.544e8 N/m\n\nmore words <!-- verify: {ROW} -->", "page:1: 6.544e8: no marker"),
        (f"6.544e8 N/m <!-- verify: {ROW} -->\n* 6.544e8 N/m", "page:2: 6.544e8: no marker"),
        (f"| a |\n| --- |\n| 6.544e8 <!-- verify: {ROW} --> |\n| 6.544e8 |", "page:4: 6.544e8: no marker"),
        ("|x| < 1\n|y| = 2.5", "page:2: 2.5: no marker"),
        (f"up to 100 % <!-- verify: {ROW} -->", "100: not given by"),
        ("| f in Hz |\n| --- |\n| 654 |", "page:3: 654: no marker"),
        ("6.544e8 N/m <!-- verify: k_n at some other load -->", "has no row"),
        ("0.5 <!-- test: tests/no_such_file.py::test_it -->", "no file"),
        (f"0.5 <!-- test: {TEST}::test_that_is_not_there -->", "has no test"),
        ("0.5 <!-- bench: no such problem -->", "has no line"),
        ("a length of\n<!-- given: 4.6 --> 4.6 m", "page:2: a line that begins with a marker"),
        ("a length\n<!-- given: 4.6 -->\nof 4.6 m", "page:2: a line that begins with a marker"),
        ("0.5 <!-- guessed: 0.5 -->", "a marker is one of"),
        ("4.7 kg <!-- given: 4.6 -->", "4.7: not given by"),
        ("4.6 kg <!-- given: 4.6, 80 -->", "80: no such number"),
        ("4.6 kg <!-- given: -->", "the numbers themselves"),
        ("536 Hz <!-- published: 536 -->", "the source must follow"),
        (f"some <!-- verify: {ROW} -->", "no such number"),
    ],
)
def test_a_number_without_its_marker_is_found(page: str, fault: str) -> None:
    found = faults(page)
    assert any(fault in line for line in found), found


def test_a_test_gives_the_numbers_that_it_and_its_constants_hold(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("project.page_numbers.ROOT", tmp_path)
    (tmp_path / "test_a.py").write_text(
        "PEAK = {'x': 528.7}\nOTHER = 12.5\n\ndef test_a():\n    assert PEAK['x'] == 3.25\n\ndef test_b():\n    print(7.5)\n"
    )
    assert not faults("528.7 and 3.25 <!-- test: test_a.py::test_a -->")
    assert "not given" in faults("12.5 <!-- test: test_a.py::test_a --> 3.25")[0]
    assert any("asserts nothing" in fault for fault in faults("7.5 <!-- test: test_a.py::test_b -->"))
