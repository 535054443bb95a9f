"""The formulas that `make mutants-drawn` breaks: what is broken in a file, the draw by a seed, and what is kept of a run."""

import ast
import subprocess
import sys
from contextlib import nullcontext
from pathlib import Path

import pytest

from tools import drawn_mutants, entered, mutants
from tools.entered import Entered
from tools.formulas import Drawable, of_file
from tools.mutants import ROOT, SOURCE

FORMULAS = [
    ("operator", "y = (a + b)", "y = (a - b)"),
    ("operator", "y = (a + b) / (c - d)", "y = (a + b) * (c - d)"),
    ("operator", "y = a**b", "y = a*b"),
    ("factor", "y = 0.5 * a", "y = 1.0 * a"),
    ("factor", "y = f(np.pi)", "y = f((0.5 * np.pi))"),
    ("sign", "y = a.dot(-b)", "y = a.dot(b)"),
    ("sign", "y = f(1j)", "y = f((-1j))"),
    ("direction", "y = a <= b", "y = a >= b"),
    ("direction", "y = a < b < c", "y = a < b > c"),
    ("conjugate", "y = f(a.conj())", "y = f(a)"),
    ("transpose", "y = f(a.T)", "y = f(a)"),
    ("swap", "y = min(a, b)", "y = max(a, b)"),
    ("swap", "y = np.cos(a)", "y = np.sin(a)"),
    ("index", "y = a[i, j]", "y = a[j, i]"),
    ("index", "y = a[1:]", "y = a[2:]"),
    ("index", "y = a.sum(axis=0)", "y = a.sum(axis=1)"),
    ("unit", "y = {'ms': 1e-3}", "y = {'ms': 1.0}"),
]
SPOKEN = """
from stickslip.support.checks import positive
Array = Annotated[float, Setting(a)]
def said(a: float) -> str:
    return str(a + 1.0)
def checked(a: NDArray[float, 1]):
    positive("a", -a)
    if a < -1.0:
        raise ValueError(a + 1.0)
    text = f"{a + 1.0}" + "more"
    rows = [a] + [a]
"""


@pytest.mark.parametrize(("kind", "line", "broken"), FORMULAS)
def test_a_formula_is_broken(kind, line, broken):
    text = f"x = 'µ'\n{line}\n"
    changes = {each.lines(text): each for each in of_file("made.py", text)}
    assert changes[line, broken].kind == kind
    assert changes[line, broken].broken(text) == f"x = 'µ'\n{broken}\n"


def test_what_speaks_or_refuses_is_left_alone():
    assert of_file("made.py", SPOKEN) == []


def test_twice_nothing_is_no_change():
    assert [each.kind for each in of_file("made.py", "y = 0 * a\n")] == ["operator"]


def test_constants_of_a_file_of_units_are_units():
    assert [each.lines("mm = 1e-3\n") for each in of_file("support/units.py", "mm = 1e-3\n")] == [("mm = 1e-3", "mm = 1.0")]
    assert of_file("made.py", "mm = 1e-3\n") == []


def test_broken_files_of_the_package_are_python_and_differ():
    for file in ("model/problem/contraction.py", "support/units.py", "model/structure/centrifugal.py"):
        text = (SOURCE / file).read_text()
        changes = of_file(file, text)
        assert changes
        for each in changes:
            assert ast.dump(ast.parse(each.broken(text))) != ast.dump(ast.parse(text))


def test_changes_without_effect_are_drawn_from_the_files_as_they_are():
    listed = drawn_mutants.equivalent()
    files = {file: (SOURCE / file).read_text() for file, _, _ in listed}
    possible = {(file, *change.lines(text)) for file, text in files.items() for change in of_file(file, text)}
    assert listed
    assert listed <= possible


def made_rooms():
    sizes = {"large": 70, "middle": 25, "small": 5}
    return {room: [Drawable(f"{room}.py", k, k + 1, "", "sign") for k in range(size)] for room, size in sizes.items()}


def test_each_room_has_its_share_of_a_draw_that_a_seed_repeats():
    sample = drawn_mutants.drawn(made_rooms(), 10, seed=3)
    assert {room: len(set(changes)) for room, changes in sample.items()} == {"large": 7, "middle": 3, "small": 0}
    assert drawn_mutants.drawn(made_rooms(), 10, seed=3) == sample
    assert drawn_mutants.drawn(made_rooms(), 10, seed=4) != sample
    assert all(set(sample[room]) <= set(changes) for room, changes in drawn_mutants.drawn(made_rooms(), 100, seed=3).items())


def test_rooms_exist():
    assert all((SOURCE / room).is_dir() for room in drawn_mutants.ROOMS)


MADE = """TOP = 2.0 * 3.0
def own(a):
    return a + 1
class Law:
    def force(self, b):
        return b - TOP
@kernel
def deep(c):
    return c * c
@kernel
def shallow(c):
    return deep(c)
def called(c):
    return shallow(c)
"""
ENTERED = """
import sys
from stickslip.support.checks import positive

def test_one():
    positive("a", 1.0)

def test_two(made):
    assert made
"""


def test_tests_are_those_that_enter_a_function_name_a_constant_or_call_a_kernel(tmp_path, monkeypatch):
    """Those that enter least come first."""
    functions = {
        "tests/a.py::test_own": {"made.py:own", "made.py:other"},
        "tests/a.py::test_method": {"made.py:Law.force"},
        "tests/b.py::test_by_kernel": {"made.py:called"},
        "tests/b.py::test_own_alone": {"made.py:own"},
    }
    text = MADE
    (tmp_path / "made.py").write_text(text)
    monkeypatch.setattr(drawn_mutants, "SOURCE", tmp_path)
    tests_of = {name: Entered(1.0, frozenset(each)) for name, each in functions.items()}
    monkeypatch.setattr(drawn_mutants, "recorded", lambda: tests_of)
    tests = drawn_mutants.Tests()
    found = {each.lines(text)[0]: [name.rpartition("_")[2] for name in tests.of(each)] for each in of_file("made.py", text)}
    assert found["return a + 1"] == ["alone", "own"]
    assert found["return b - TOP"] == found["TOP = 2.0 * 3.0"] == ["method"]
    assert found["return c * c"] == ["kernel"]


def test_a_recording_holds_what_tests_and_their_fixtures_enter(tmp_path, monkeypatch):
    (tmp_path / "conftest.py").write_text(
        "import pytest\nfrom stickslip.support.checks import not_negative\n\n"
        "@pytest.fixture(scope='module')\ndef made():\n    return not_negative('b', 2.0)\n"
    )
    (tmp_path / "test_small.py").write_text(ENTERED)
    command = [sys.executable, "-c", RECORDING, str(tmp_path)]
    subprocess.run(command, cwd=ROOT, check=True, capture_output=True, timeout=120)
    monkeypatch.setattr(entered, "FOLDER", tmp_path / "entered")
    monkeypatch.setattr(entered, "ROOT", tmp_path)
    one, two = (entered.recorded()[f"test_small.py::{name}"].functions for name in ("test_one", "test_two"))
    assert "support/checks.py:positive" in one - two
    assert "support/checks.py:not_negative" in two - one
    (tmp_path / "test_small.py").write_text(ENTERED + "\n")
    with pytest.raises(SystemExit, match=r"have changed since they were recorded: test_small\.py\. Run make entered"):
        entered.recorded()


RECORDING = """
import sys
from pathlib import Path
import pytest
from tools import entered

folder = Path(sys.argv[1])
entered.FOLDER = folder / "entered"
plugins = ["-p", "tools.entered", "-p", "no:cacheprovider"]
sys.exit(pytest.main(["-q", *plugins, "--rootdir", str(folder), "-c", "/dev/null", str(folder)]))
"""


class AllTests:
    """One test for every change."""

    def of(self, change):
        return ["tests/test_made.py::test_all"]


@pytest.fixture
def small_run(tmp_path, monkeypatch):
    """A package of one file with four formulas, and tests that say of each broken line what `verdicts` holds."""
    source, verdicts, calls = tmp_path / "source", {}, []
    (source / "made").mkdir(parents=True)
    (source / "made" / "law.py").write_text("a = b + c\nd = e - f\ng = h * i\nj = k / l\n")
    (tmp_path / "tests").mkdir()
    (tmp_path / "tests" / "test_made.py").write_text("a\n")
    (tmp_path / "tests" / "mutants.toml").write_text(
        '["made/law.py"]\nequivalent = [{ old = "g = h * i", new = "g = h / i", why = "i is 1" }]\n'
    )

    def outcome(file, text, tests, folder, limit):
        broken = next(line for line in text.splitlines() if line not in (source / file).read_text().splitlines())
        calls.append(broken)
        if verdicts.get(broken) == "interrupt":
            raise KeyboardInterrupt
        return verdicts.get(broken, "killed")

    monkeypatch.setattr(drawn_mutants, "SOURCE", source)
    monkeypatch.setattr(drawn_mutants, "ROOT", tmp_path)
    monkeypatch.setattr(drawn_mutants, "ROOMS", ("made",))
    monkeypatch.setattr(drawn_mutants, "Tests", AllTests)
    monkeypatch.setattr(drawn_mutants, "RESULTS", tmp_path / "results" / "mutation.jsonl")
    monkeypatch.setattr(drawn_mutants, "PAGE", tmp_path / "mutation.md")
    monkeypatch.setattr(drawn_mutants, "outcome", outcome)
    monkeypatch.setattr(drawn_mutants, "copied_package", lambda: nullcontext(tmp_path))
    return tmp_path, verdicts, calls


def row_of(folder):
    return next(line for line in Path(folder / "mutation.md").read_text().splitlines() if line.startswith("| made |"))


def test_a_run_goes_on_and_its_page_counts(small_run, capsys):
    folder, verdicts, calls = small_run
    command = ["--count", "4", "--limit", "9"]
    verdicts["d = e + f"] = "interrupt"
    assert drawn_mutants.main(command) == 130
    assert "goes on" in capsys.readouterr().out
    told = len(calls) - 1
    assert row_of(folder) == f"| made | 4 | 4 | {told} | 0 | 1 | 0 | {3 - told} |"
    verdicts["d = e + f"] = "survives"
    assert drawn_mutants.main(command) == 0
    assert sorted(set(calls)) == ["a = b - c", "d = e + f", "j = k * l"]
    assert len(calls) == 4  # only what was interrupted is run twice
    assert row_of(folder) == "| made | 4 | 4 | 2 | 1 | 1 | 0 | 0 |"
    assert "* `made/law.py`: `d = e - f` → `d = e + f`" in (folder / "mutation.md").read_text()


def test_new_tests_run_what_survived_and_new_formulas_run_all(small_run):
    folder, verdicts, calls = small_run
    command = ["--count", "4", "--limit", "9"]
    verdicts["d = e + f"] = "survives"
    drawn_mutants.main(command)
    calls.clear()
    (folder / "tests" / "test_made.py").write_text("b\n")
    verdicts.clear()
    drawn_mutants.main(command)
    assert calls == ["d = e + f"]
    assert row_of(folder) == "| made | 4 | 4 | 3 | 0 | 1 | 0 | 0 |"
    calls.clear()
    law = folder / "source" / "made" / "law.py"
    law.write_text(law.read_text() + "m = n\n")
    drawn_mutants.main(command)
    assert len(calls) == 3


def test_tests_out_of_time_are_ended_and_the_file_is_whole_again(tmp_path, monkeypatch):
    for folder in ("source", "stickslip"):
        (tmp_path / folder).mkdir()
        (tmp_path / folder / "law.py").write_text("a = b + c\n")
    monkeypatch.setattr(mutants, "ROOT", tmp_path)
    monkeypatch.setattr(mutants, "SOURCE", tmp_path / "source")
    assert mutants.outcome("law.py", "a = b - c\n", ["test_law.py"], tmp_path, 0.02) == "out of time"
    assert (tmp_path / "stickslip" / "law.py").read_text() == "a = b + c\n"


def test_every_formula_that_is_broken_on_purpose_still_stands():
    """A text that was moved or rewritten breaks nothing any more, and its formula would be watched by no test."""
    texts = {mutant.file: (SOURCE / mutant.file).read_text() for mutant in mutants.listed()}
    assert [(mutant.file, mutant.old) for mutant in mutants.listed() if texts[mutant.file].count(mutant.old) != 1] == []
