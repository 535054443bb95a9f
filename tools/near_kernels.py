"""A plugin of pytest for `tools/mutants.py`: with one formula broken, the kernels that do not hold it are taken as they were.

The package keeps kernels by the content of whole files, so that a formula that no kernel holds, in a file that others import,
would have most of them compiled again: a minute for each change. Here a kernel is compiled anew only where its code names, at
whatever depth, what differs between the copy of the package and the package itself.
"""

from __future__ import annotations

import ast
from collections.abc import Callable, Iterator
from functools import cache
from pathlib import Path
from typing import Any

import stickslip.support.kernels.cache as kernel_cache

SOURCE = Path(__file__).parents[1] / "src" / "stickslip"


def names_of(statement: ast.stmt) -> set[str]:
    """What a statement of a module defines."""
    if isinstance(statement, ast.FunctionDef | ast.ClassDef):
        over = [each.args[0] for each in statement.decorator_list if ast.unparse(each).startswith("overload(")]
        return {statement.name} | {each.id for each in over if isinstance(each, ast.Name)}  # of @overload(name)
    return {each.id for each in ast.walk(statement) if isinstance(each, ast.Name) and isinstance(each.ctx, ast.Store)}


def names_in(statement: ast.stmt) -> set[str]:
    """The names of other statements that a statement may hold: all but its own variables."""
    nodes = list(ast.walk(statement))
    own = {each.arg for each in nodes if isinstance(each, ast.arg)}
    own |= {each.id for each in nodes if isinstance(each, ast.Name) and isinstance(each.ctx, ast.Store)}
    used = {each.id for each in nodes if isinstance(each, ast.Name)} - own
    return used | {each.attr for each in nodes if isinstance(each, ast.Attribute)}


def changed(old: str, new: str) -> Iterator[str]:
    """What the statements define that differ between two texts of a file; of a class its members."""
    pairs = list(zip(ast.parse(old).body, ast.parse(new).body, strict=True))
    for before, after in pairs:
        if isinstance(before, ast.ClassDef) and isinstance(after, ast.ClassDef):
            pairs += zip(before.body, after.body, strict=True)
        elif ast.dump(before) != ast.dump(after):
            yield from names_of(before)


def holders(texts: dict[str, str], names: set[str]) -> set[str]:
    """Names whose code holds some names: what is compiled with them, and constants made of them.

    A function without a decorator is no kernel, and what is called through an address is compiled by itself.
    """
    parts = [
        (names_of(each), names_in(each), any("separate(" in name or "numbered(" in name for name in decorators(each)))
        for text in texts.values()
        for each in ast.parse(text).body
        if isinstance(each, ast.Assign | ast.AnnAssign) or decorators(each)
    ]
    found, spreading, size = set(names), set(names), 0
    while len(found) > size:
        size = len(found)
        for defined, held, alone in parts:
            if held & spreading:
                found |= defined
                spreading |= set() if alone else defined
    return found


def decorators(statement: ast.stmt) -> list[str]:
    return [ast.unparse(each) for each in getattr(statement, "decorator_list", [])]


def pytest_configure() -> None:
    """Kernels that hold nothing broken have the names of those of the whole package."""
    broken = kernel_cache._files()
    whole = {module: (SOURCE / "/".join(module.split(".")[1:])).with_suffix(".py").read_text() for module in broken}
    different = {name for module in broken if whole[module] != broken[module] for name in changed(whole[module], broken[module])}
    held = holders(whole, different)

    @cache
    def whole_digest(path: Path) -> str:
        kernel_cache._files = lambda: whole  # type: ignore[assignment]
        try:
            return kernel_cache.digest_of.__wrapped__(path)
        finally:
            kernel_cache._files = lambda: broken  # type: ignore[assignment]

    class NearCache(kernel_cache.KernelCache):
        def __init__(self, function: Callable[..., Any]) -> None:
            super().__init__(function)
            path = Path(function.__code__.co_filename)
            if path.is_relative_to(kernel_cache._PACKAGE) and function.__name__ not in held:
                self._sources = whole_digest(path)

    kernel_cache.KernelCache = NearCache  # type: ignore[misc]
