"""Every test asserts something that a reader sees in it: assert, an assert_... function, or an error that it expects."""

import ast
from collections.abc import Iterator
from pathlib import Path

TESTS = Path(__file__).parents[1]
EXPECTING = ("raises", "warns")


def silent_tests(source: str) -> Iterator[str]:
    """Names of the tests in a file that assert nothing."""
    for function in ast.walk(ast.parse(source)):
        if (
            isinstance(function, ast.FunctionDef)
            and function.name.startswith("test_")
            and not any(map(asserts, ast.walk(function)))
        ):
            yield function.name


def asserts(node: ast.AST) -> bool:
    called = node.func if isinstance(node, ast.Call) else None
    name = called.attr if isinstance(called, ast.Attribute) else called.id if isinstance(called, ast.Name) else ""
    return isinstance(node, ast.Assert) or name.startswith("assert_") or name in EXPECTING


def test_every_test_asserts():
    silent = {path.relative_to(TESTS).as_posix(): list(silent_tests(path.read_text())) for path in TESTS.rglob("test_*.py")}
    assert {path: names for path, names in silent.items() if names} == {}


def test_a_silent_test_is_found():
    assert list(silent_tests("def test_a():\n    print(1)\ndef test_b():\n    assert_close(1, 1)\n")) == ["test_a"]
