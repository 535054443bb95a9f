"""Measures of how a package is cut up: `python tools/measures.py [FOLDER]`, for src/stickslip when no folder is named.

Numbers to look at, not limits to meet. They are read from the source (`ast`, `tokenize`); nothing is imported. Empty files and
`__init__.py` files that only import are left out.
"""

from __future__ import annotations

import ast
import statistics
import sys
import tokenize
from collections import Counter
from collections.abc import Iterator
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path

Function = ast.FunctionDef | ast.AsyncFunctionDef

SOURCE = Path(__file__).parents[1] / "src" / "stickslip"
SHORT = 20
"""Lines of a function, without its docstring, that fit on a screen with room around them."""

KERNELS = ("kernel", "inner", "inlined", "separate")
"""Decorators of compiled functions."""

CHAIN = ("MacroslipTable", "Macroslip", "Elements", "Contact", "ContactTable", "contact_forces", "friction_period")
"""What holds kt on its way from the study key to the kernel of the Jenkins element, in harmonic balance."""


@dataclass(frozen=True)
class Module:
    """A source file: its path, its dotted name from the package on, its text and its tree."""

    path: Path
    name: str

    @cached_property
    def text(self) -> str:
        return self.path.read_text(encoding="utf-8")

    @cached_property
    def tree(self) -> ast.Module:
        return ast.parse(self.text)

    @cached_property
    def functions(self) -> list[Function]:
        """Functions and methods, nested ones too."""
        return [node for node in ast.walk(self.tree) if isinstance(node, Function)]

    @property
    def comments(self) -> int:
        """Lines with a comment that is not an instruction to a tool."""
        with self.path.open("rb") as file:
            found = [token.string for token in tokenize.tokenize(file.readline) if token.type == tokenize.COMMENT]
        return sum(not text.startswith(("# noqa", "# type:", "# fmt:", "#!")) for text in found)

    @property
    def imports(self) -> Iterator[tuple[str, str]]:
        """Module and name of everything imported from somewhere, and module and "" of everything imported whole."""
        for node in ast.walk(self.tree):
            if isinstance(node, ast.ImportFrom):
                source = ".".join(filter(None, [self._above(node.level), node.module]))
                yield from ((source, each.name) for each in node.names)
            elif isinstance(node, ast.Import):
                yield from ((each.name, "") for each in node.names)

    def _above(self, level: int) -> str:
        """The package that so many dots at the start of an import name; none name none."""
        parts = self.name.split(".") + ["__init__"] * (self.path.name == "__init__.py")
        return ".".join(parts[:-level]) if level else ""

    @property
    def constants(self) -> list[str]:
        """Names of the module that are given a number, or a tuple or list of numbers."""
        found = []
        for node in self.tree.body:
            targets = node.targets if isinstance(node, ast.Assign) else [node.target] if isinstance(node, ast.AnnAssign) else []
            if targets and isinstance(node, ast.Assign | ast.AnnAssign) and node.value is not None and _is_number(node.value):
                found += [target.id for target in targets if isinstance(target, ast.Name)]
        return found

    @property
    def carriers(self) -> set[str]:
        """Names of its classes, in which a value travels, and of its compiled functions, which work with it."""
        tops = self.tree.body
        compiled = {node.name for node in tops if isinstance(node, Function) and is_kernel(node)}
        return compiled | {node.name for node in tops if isinstance(node, ast.ClassDef)}


def _is_number(node: ast.expr) -> bool:
    match node:
        case ast.Constant(value=value):
            return isinstance(value, int | float | complex) and not isinstance(value, bool)
        case ast.UnaryOp(operand=operand):
            return _is_number(operand)
        case ast.BinOp(left=left, right=right):
            return _is_number(left) and _is_number(right)
        case ast.Tuple(elts=parts) | ast.List(elts=parts):
            return bool(parts) and all(_is_number(part) for part in parts)
        case _:
            return False


def is_kernel(function: Function) -> bool:
    """Whether a function is compiled."""
    return any(
        isinstance(node, ast.Name) and node.id in KERNELS for decorator in function.decorator_list for node in ast.walk(decorator)
    )


def modules(folder: Path) -> list[Module]:
    """The modules of a package that hold more than imports."""
    found = []
    for path in sorted(folder.rglob("*.py")):
        parts = (folder.name, *path.relative_to(folder).with_suffix("").parts)
        module = Module(path, ".".join(parts).removesuffix(".__init__"))
        if module.text.strip() and not (path.name == "__init__.py" and _only_imports(module.tree)):
            found.append(module)
    return found


def _only_imports(tree: ast.Module) -> bool:
    def idle(node: ast.stmt) -> bool:
        return isinstance(node, ast.Import | ast.ImportFrom) or (
            isinstance(node, ast.Expr) and isinstance(node.value, ast.Constant)
        )

    return all(idle(node) for node in tree.body)


def function_lines(function: Function) -> int:
    """Lines from `def` to the end, without the docstring."""
    first = function.body[0]
    documented = ast.get_docstring(function, clean=False) is not None and first.end_lineno is not None
    docstring = first.end_lineno - first.lineno + 1 if documented and first.end_lineno is not None else 0
    return (function.end_lineno or function.lineno) - function.lineno + 1 - docstring


def arguments(function: Function) -> int:
    """Number of parameters, without self and cls."""
    given = function.args
    names = [each.arg for each in (*given.posonlyargs, *given.args, *given.kwonlyargs)]
    return len(names) - (names[:1] in (["self"], ["cls"])) + (given.vararg is not None) + (given.kwarg is not None)


def private_helpers(package: list[Module]) -> tuple[list[str], list[str]]:
    """Private functions and methods, and those of them that one single place mentions, as "module:name"."""
    every, once = [], []
    for module in package:
        mentioned = Counter(
            node.id if isinstance(node, ast.Name) else node.attr
            for node in ast.walk(module.tree)
            if isinstance(node, ast.Name | ast.Attribute)
        )
        helpers = {f.name for f in module.functions if f.name.startswith("_") and not f.name.endswith("__")} - {"_"}
        every += [f"{module.name}:{name}" for name in sorted(helpers)]
        once += [f"{module.name}:{name}" for name in sorted(helpers) if mentioned[name] == 1]
    return every, once


def importers(package: list[Module]) -> dict[str, set[str]]:
    """The modules of the package that import each module; an `__init__` that only passes names on is none."""
    names = {module.name for module in package}
    found: dict[str, set[str]] = {name: set() for name in names}
    for module in (each for each in package if each.path.name != "__init__.py"):
        for source, name in module.imports:
            home = next((each for each in (f"{source}.{name}", source) if each in names), None)
            if home is not None and home != module.name:
                found[home].add(module.name)
    return found


def repeated_constants(package: list[Module]) -> Counter[str]:
    """How often each name of a numeric constant is defined in the package."""
    return Counter(name for module in package for name in module.constants)


def mentions(package: list[Module], word: str) -> list[str]:
    """The modules in whose code (no text, no comment) a name stands: a variable, parameter, keyword or attribute."""
    fields = ("id", "attr", "arg")
    return [
        module.name
        for module in package
        if any(getattr(node, field, None) == word for node in ast.walk(module.tree) for field in fields)
    ]


def chain(package: list[Module], stations: tuple[str, ...]) -> list[str]:
    """The modules one opens to follow a value past its stations, each a class or a compiled function, in their order.

    Values travel in objects and arguments, so a station and the next one share a file or one of the two imports the other.
    """
    homes: list[Module] = []
    for station in stations:
        home = next((module for module in package if station in module.carriers), None)
        if home is None:
            raise LookupError(f"{station} is no class and no compiled function: renew CHAIN")
        if homes and home is not homes[-1] and not (_takes(home, homes[-1]) or _takes(homes[-1], home)):
            raise LookupError(f"{station} of {home.name} and the station before it share no import: renew CHAIN")
        homes += [home] if home not in homes else []
    return [home.name for home in homes]


def _takes(module: Module, other: Module) -> bool:
    return any(source == other.name and name in other.carriers for source, name in module.imports)


def rows(package: list[Module], stations: tuple[str, ...] = ()) -> list[tuple[str, str]]:
    """What is measured, and the number, as texts. With stations of kt, its way too."""
    lengths = [len(module.text.splitlines()) for module in package]
    functions = [function for module in package for function in module.functions]
    sizes = sorted(function_lines(function) for function in functions)
    counts = [arguments(function) for function in functions]
    most = max(zip(counts, functions, strict=True), key=lambda pair: pair[0])
    helpers, once = private_helpers(package)
    single = [name for name, others in importers(package).items() if len(others) == 1]
    constants = repeated_constants(package)
    repeated = [f"{name} {count}" for name, count in constants.most_common() if count > 1]
    followed = chain(package, stations)

    def share(part: int, whole: int) -> str:
        return f"{100 * part / max(whole, 1):.1f} % ({part} of {whole})"

    return [
        ("files", str(len(package))),
        ("lines", str(sum(lengths))),
        ("lines of a file, median / most", f"{statistics.median(lengths):.0f} / {max(lengths)}"),
        (f"functions of at most {SHORT} lines", share(sum(size <= SHORT for size in sizes), len(sizes))),
        (
            "lines of a function, median / 90 % / most",
            f"{statistics.median(sizes):.0f} / {sizes[len(sizes) * 9 // 10]} / {sizes[-1]}",
        ),
        ("private helpers used exactly once, of all functions", share(len(once), len(functions))),
        ("private helpers used exactly once, of the private helpers", share(len(once), len(helpers))),
        ("files with a single importer", f"{len(single)} of {len(package)}"),
        ("comments a 100 lines", f"{100 * sum(module.comments for module in package) / sum(lengths):.1f}"),
        ("numeric constants of modules", str(constants.total())),
        ("their names defined more than once", f"{len(repeated)}: {', '.join(repeated)}" if repeated else "0"),
        ("functions with more than 5 arguments", share(sum(count > 5 for count in counts), len(counts))),
        ("functions with more than 10 arguments", str(sum(count > 10 for count in counts))),
        ("most arguments", f"{most[0]} ({most[1].name})"),
    ] + [
        ("files whose code mentions kt", str(len(mentions(package, "kt")))),
        ("files from the study key kt to the kernel", f"{len(followed)}: {' > '.join(followed)}"),
    ] * bool(followed)


def main(folder: Path) -> int:
    package = modules(folder)
    if not any(module.functions for module in package):
        sys.stderr.write(f"{folder} holds no Python package with functions.\n")
        return 1
    for name, value in rows(package, CHAIN if folder == SOURCE else ()):
        sys.stdout.write(f"{name:<60}{value}\n")
    return 0


if __name__ == "__main__":
    sys.exit(main(Path(sys.argv[1]).resolve() if len(sys.argv) > 1 else SOURCE))
