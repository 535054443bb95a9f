"""All the ways in which one formula of the package can be wrong: what `tools/drawn_mutants.py` draws from.

Python's own reading of each file (`ast`) gives the places: operators, signs, directions of comparisons, conjugates, transposes,
numeric factors, indices and axes, units, min and max, cos and sin. What only speaks or refuses is left out: annotations,
sentences, `raise`, checks of the input, functions that return text.
"""

from __future__ import annotations

import ast
import re
from pathlib import Path
from typing import NamedTuple

OPERATORS = {ast.Add: ("+", "-"), ast.Sub: ("-", "+"), ast.Mult: ("*", "/"), ast.Div: ("/", "*"), ast.Pow: ("**", "*")}
DIRECTIONS = {ast.Lt: ("<", ">"), ast.LtE: ("<=", ">="), ast.Gt: (">", "<"), ast.GtE: (">=", "<=")}
SWAPPED = {"cos": "sin", "min": "max", "minimum": "maximum", "argmin": "argmax", "nanmin": "nanmax", "fmin": "fmax"}
SWAPPED |= {other: name for name, other in SWAPPED.items()}
TEXTS = (ast.JoinedStr, ast.List, ast.Tuple, ast.ListComp, ast.Dict, ast.Set)
"""What `+` and `*` join instead of computing, with constants that are strings."""

TYPES = re.compile(r"(?:\w+\.)?(?:[A-Z][a-z]\w+|NDArray|dict|tuple|list|type)")
"""What has types in its square brackets, not indices."""


class Drawable(NamedTuple):
    """A change of one formula: a file of the package, the bytes that change, and what stands there instead."""

    file: str
    start: int
    end: int
    new: str
    kind: str

    def broken(self, text: str) -> str:
        """The text of the file with the formula broken."""
        content = text.encode()
        return (content[: self.start] + self.new.encode() + content[self.end :]).decode()

    def lines(self, text: str) -> tuple[str, str]:
        """The line (or lines) of the formula as it is and broken."""
        content = text.encode()
        first, last = content.rfind(b"\n", 0, self.start) + 1, content.find(b"\n", self.end)
        before, after = content[first : self.start], content[self.end : last]
        return content[first:last].decode().strip(), (before + self.new.encode() + after).decode().strip()


def of_file(file: str, text: str) -> list[Drawable]:
    """All changes of the formulas of a file, in their order."""
    found = _Formulas(file, text)
    found.visit(ast.parse(text))
    return sorted(set(found.all))


class _Formulas(ast.NodeVisitor):
    """Walks through a file and collects the changes of what it meets."""

    def __init__(self, file: str, text: str) -> None:
        self.file, self.text, self.all = file, text.encode(), list[Drawable]()
        self.lines = [0, *(match.end() for match in re.finditer(rb"\n", self.text))]
        self.checks = {"fault", "warn", "InputError"} | set(re.findall(r"\w+", _imported_checks(text)))
        self.units = "unit" in Path(file).stem

    def _start(self, node: ast.expr) -> int:
        return self.lines[node.lineno - 1] + node.col_offset

    def _end(self, node: ast.expr) -> int:
        return self.lines[(node.end_lineno or 0) - 1] + (node.end_col_offset or 0)

    def _replace(self, kind: str, start: int, end: int, new: str | bytes) -> None:
        self.all.append(Drawable(self.file, start, end, new if isinstance(new, str) else new.decode(), kind))

    def _token(self, kind: str, left: ast.expr, right: ast.expr, tokens: tuple[str, str]) -> None:
        """Replaces an operator between its operands."""
        start = self.text.find(tokens[0].encode(), self._end(left), self._start(right))
        if start >= 0:
            self._replace(kind, start, start + len(tokens[0]), tokens[1])

    # What only speaks or refuses.

    def visit_Raise(self, node: ast.Raise) -> None:
        pass

    def visit_JoinedStr(self, node: ast.JoinedStr) -> None:
        pass

    def visit_AnnAssign(self, node: ast.AnnAssign) -> None:
        if node.value:
            self.visit(node.value)

    def visit_arguments(self, node: ast.arguments) -> None:
        for default in (*node.defaults, *node.kw_defaults):
            if default:
                self.visit(default)

    def visit_FunctionDef(self, node: ast.FunctionDef) -> None:
        if not (node.returns and ast.unparse(node.returns) in ("str", "list[str]", "Iterator[str]")):
            self.visit(node.args)
            for each in node.body:
                self.visit(each)

    def visit_If(self, node: ast.If) -> None:
        if not isinstance(node.body[-1], ast.Raise):
            self.generic_visit(node)
        for each in node.orelse if isinstance(node.body[-1], ast.Raise) else ():
            self.visit(each)

    # What computes.

    def visit_BinOp(self, node: ast.BinOp) -> None:
        joins = any(isinstance(side, TEXTS) or _is_text(side) for side in (node.left, node.right))
        if type(node.op) in OPERATORS and not joins:
            self._token("operator", node.left, node.right, OPERATORS[type(node.op)])
        if isinstance(node.op, ast.Mult | ast.Div):
            for side in (node.left, node.right):
                if isinstance(side, ast.Constant) and type(side.value) in (int, float) and side.value:
                    self._replace("factor", self._start(side), self._end(side), repr(2 * side.value))
        self.generic_visit(node)

    def visit_UnaryOp(self, node: ast.UnaryOp) -> None:
        if isinstance(node.op, ast.USub):
            self._replace("sign", self._start(node), self._start(node) + 1, "")
        self.generic_visit(node)

    def visit_Compare(self, node: ast.Compare) -> None:
        for left, operator, right in zip((node.left, *node.comparators), node.ops, node.comparators, strict=False):
            if type(operator) in DIRECTIONS:
                self._token("direction", left, right, DIRECTIONS[type(operator)])
        self.generic_visit(node)

    def visit_Constant(self, node: ast.Constant) -> None:
        if type(node.value) is complex:
            self._replace("sign", self._start(node), self._end(node), f"(-{node.value.imag:g}j)")
        if self.units:
            self._unit(node)

    def visit_Dict(self, node: ast.Dict) -> None:
        for key, value in zip(node.keys, node.values, strict=True):
            if key and _is_text(key):
                self._unit(value)
        self.generic_visit(node)

    def visit_Attribute(self, node: ast.Attribute) -> None:
        if node.attr == "T":
            self._replace("transpose", self._end(node) - len(".T"), self._end(node), "")
        if node.attr == "pi":
            self._replace("factor", self._start(node), self._end(node), f"(0.5 * {ast.unparse(node)})")
        if node.attr in SWAPPED:
            self._replace("swap", self._end(node) - len(node.attr), self._end(node), SWAPPED[node.attr])
        self.generic_visit(node)

    def visit_Call(self, node: ast.Call) -> None:
        name = node.func.attr if isinstance(node.func, ast.Attribute) else getattr(node.func, "id", "")
        if name in self.checks:
            return
        if name in ("conj", "conjugate") and isinstance(node.func, ast.Attribute) and not node.args:
            self._replace("conjugate", self._end(node.func) - len(name) - 1, self._end(node), "")
        if name in SWAPPED and isinstance(node.func, ast.Name):
            self._replace("swap", self._start(node.func), self._end(node.func), SWAPPED[name])
        for keyword in node.keywords:
            if keyword.arg == "axis":
                self._shifted(keyword.value, {"0": "1", "-1": "0", "-2": "-1"}.get(ast.unparse(keyword.value), "0"))
        self.generic_visit(node)

    def visit_Subscript(self, node: ast.Subscript) -> None:
        if TYPES.fullmatch(ast.unparse(node.value)):
            return
        entries = node.slice.elts if isinstance(node.slice, ast.Tuple) else [node.slice]
        if len(entries) == 2 and ast.unparse(entries[0]) != ast.unparse(entries[1]):
            first, second = (self.text[self._start(each) : self._end(each)] for each in entries)
            self._replace("index", self._start(entries[0]), self._end(entries[1]), second + b", " + first)
        for each in ast.walk(node.slice):
            if isinstance(each, ast.Constant) and type(each.value) is int:
                self._shifted(each, str(each.value + 1))
        self.generic_visit(node)

    def _unit(self, node: ast.expr) -> None:
        if isinstance(node, ast.Constant) and type(node.value) is float:
            self._replace("unit", self._start(node), self._end(node), repr(1000.0 * node.value))

    def _shifted(self, node: ast.expr, new: str) -> None:
        self._replace("index", self._start(node), self._end(node), new)


def _is_text(node: ast.expr) -> bool:
    return isinstance(node, ast.Constant) and isinstance(node.value, str)


def _imported_checks(text: str) -> str:
    """The names that a file imports from the checks of input."""
    return " ".join(re.findall(r"^from stickslip\.support\.checks import (.*)$", text, re.M))
