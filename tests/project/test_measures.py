"""The measures of the source, on a package of a few lines that is counted by hand, and on this one."""

import re

import pytest

from tools import measures

FILES = {
    "__init__.py": '"""Passes names on."""\nfrom made.law import Law\n',
    "empty.py": "",
    "law.py": '''"""A law."""
TOLERANCE = 1e-9
SIZES = (1, -2.0)
DAY = 24 * 3600
NAME = "law"


class Law:
    """Two springs."""

    def force(self, kt, *rest, scale=1.0, **more):
        """Its force,

        in two more lines.
        """
        return _once(kt) + _twice(kt) + _twice(scale)  # the second one sticks


def _once(kt):
    return kt


def _twice(kt):
    return kt


def _passed_on(kt):
    return kt


NAMES = [_passed_on, _passed_on]
''',
    "step.py": '''"""A kernel."""
import made.law
from made.kernels import kernel

TOLERANCE: float = 1e-6


@kernel
def step(a, b, c, d, e, f):
    # why it is so
    return a
''',
    "table.py": "from .law import Law\nfrom made.step import step\n\n\nclass Key:\n    made = Law\n\n\n"
    + "def long():\n"
    + "    x = 1\n" * 20,
}


@pytest.fixture
def package(tmp_path):
    folder = tmp_path / "made"
    folder.mkdir()
    for name, text in FILES.items():
        (folder / name).write_text(text)
    return measures.modules(folder)


def test_files_that_hold_nothing_are_left_out(package):
    assert [module.name for module in package] == ["made.law", "made.step", "made.table"]


def test_a_function_is_measured_without_its_docstring(package):
    lengths = {f.name: measures.function_lines(f) for module in package for f in module.functions}
    assert lengths == {"force": 2, "_once": 2, "_twice": 2, "_passed_on": 2, "step": 3, "long": 21}


def test_arguments_are_counted_without_self(package):
    counts = {f.name: measures.arguments(f) for module in package for f in module.functions}
    assert (counts["force"], counts["step"], counts["long"]) == (4, 6, 0)


def test_a_helper_mentioned_in_one_place_is_used_once(package):
    every, once = measures.private_helpers(package)
    assert every == ["made.law:_once", "made.law:_passed_on", "made.law:_twice"]
    assert once == ["made.law:_once"]


def test_importers_leave_out_an_init_that_passes_names_on(package):
    assert measures.importers(package) == {
        "made.law": {"made.step", "made.table"},
        "made.step": {"made.table"},
        "made.table": set(),
    }


def test_numeric_constants_and_the_names_of_several(package):
    assert measures.repeated_constants(package) == {"TOLERANCE": 2, "SIZES": 1, "DAY": 1}


def test_comments_are_lines_for_the_reader(package):
    assert [module.comments for module in package] == [1, 1, 0]


def test_the_way_of_a_value(package):
    assert measures.mentions(package, "kt") == ["made.law"]
    assert measures.chain(package, ("Key", "Law")) == ["made.table", "made.law"]
    assert measures.chain(package, ("Law", "Key", "step")) == ["made.law", "made.table", "made.step"]


@pytest.mark.parametrize(("stations", "message"), [(("Key", "Spring"), "no class"), (("Law", "step"), "share no import")])
def test_a_way_that_is_not_there_is_named(package, stations, message):
    with pytest.raises(LookupError, match=message):
        measures.chain(package, stations)


def test_the_table_of_a_package(package):
    table = dict(measures.rows(package))
    assert table["files"] == "3"
    assert table["functions of at most 20 lines"] == "83.3 % (5 of 6)"
    assert table["their names defined more than once"] == "1: TOLERANCE 2"
    assert table["most arguments"] == "6 (step)"
    assert "files from the study key kt to the kernel" not in table


@pytest.fixture(scope="module")
def source():
    return measures.modules(measures.SOURCE)


@pytest.mark.slow
def test_this_package_is_measured_to_the_end(source):
    """Fails when a class or kernel on the way of kt has another name: then `CHAIN` is to be renewed."""
    table = dict(measures.rows(source, measures.CHAIN))
    assert int(table["files"]) > 100
    assert int(table["files from the study key kt to the kernel"].split(":")[0]) >= 2


@pytest.mark.slow
def test_only_keywords_and_kernels_are_more_than_ten(source):
    public = (measures.SOURCE / "__init__.pyi").read_text() + (measures.SOURCE / "model" / "rigs" / "__init__.py").read_text()
    names = set(re.findall(r"\w+", public))
    long = {
        f"{module.name}:{function.name}"
        for module in source
        for function in module.functions
        if measures.arguments(function) > 10 and function.name not in names and not measures.is_kernel(function)
        if len([each for each in function.args.args if each.arg not in ("self", "cls")]) > 1
    }
    assert long == set()


def test_a_folder_without_functions_is_refused(tmp_path, capsys):
    assert measures.main(tmp_path) == 1
    assert "no Python package" in capsys.readouterr().err
