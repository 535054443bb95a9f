"""What a compiled kernel depends on: a digest of its file and of all files whose kernels and types it holds.

numba compiles a kernel with the kernels that it calls, and does not notice when one of these, in another file, has changed. Here
the imports of each file are followed, as far as kernels, types and constants go into other kernels. A kernel that is compiled by
itself (`separate`) does not: it is called through an address.
"""

from __future__ import annotations

import hashlib
import re
from functools import cache
from pathlib import Path

_PACKAGE = Path(__file__).parents[2]

FOLDERS = (
    *("model/contact", "solve/balance", "solve/continuation", "solve/platforms", "solve/stability", "solve/time"),
    "support/kernels",
)
"""Those with kernels."""

_TAKES_PART = re.compile(r"^@(kernel|inner|inlined|separate|numbered|overload)\b|\(NamedTuple\)", re.MULTILINE)
"""In a file with kernels, or with named tuples, which are the types that kernels take."""

_SEPARATE = re.compile(r"^@(?:separate|numbered)\(.*\)\ndef (\w+)", re.MULTILINE)
_PLAIN = re.compile(r"(?<=\n\n)def (\w+)")
_OVERLOADED = re.compile(r"^@overload\((\w+)", re.MULTILINE)
_IMPORT = re.compile(r"^ *from (stickslip[\w.]*) import (\([^)]*\)|[^\n(]*)", re.MULTILINE)
_NAME = re.compile(r"(\w+)(?: as \w+)?")


@cache
def digest_of(path: Path) -> str:
    """Digest of what a kernel of this file depends on; of a file outside the package, on all, and on where it lies: a file of the
    same text elsewhere may import others. What such a file imports beside the package is not followed."""
    files = _files()
    own = _module(path) if path.is_relative_to(_PACKAGE) else None
    needed, left = set(files if own is None else ()), [own] if own else []
    while left:
        module = left.pop()
        if module not in needed:
            needed.add(module)
            left += needs(module)
    digest = hashlib.sha256(_makers() + (str(path.absolute()).encode() + path.read_bytes() if own is None else b""))
    for module in sorted(needed):
        digest.update(module.encode() + files[module].encode())
    return digest.hexdigest()


@cache
def needs(module: str) -> list[str]:
    """The files of which a file's kernels hold kernels, types or constants."""
    files = _files()
    text = files[module]
    if not _TAKES_PART.search(text):
        return []
    held: dict[str, list[str]] = {}
    for source, names in _IMPORT.findall(text):
        for name in _NAME.findall(names.strip("()")):
            if (whole := f"{source}.{name}") in files:
                held.setdefault(whole, []).extend(re.findall(rf"\b{name}\.(\w+)", text))
            elif source in files:
                held.setdefault(source, []).append(name)
    return [source for source, names in held.items() if any(_is_held(name, files[source]) for name in names)]


def _is_held(name: str, text: str) -> bool:
    """Whether code that uses a name of a file has a part of that file in it: a kernel that is compiled with those that call it, a
    type or a constant, but neither a kernel that is compiled by itself nor a function for Python."""
    if not _TAKES_PART.search(text):
        return name.isupper()
    return name not in _SEPARATE.findall(text) and (name not in _PLAIN.findall(text) or name in _OVERLOADED.findall(text))


@cache
def _files() -> dict[str, str]:
    """Sources of all files in the folders with kernels, by the names of the modules."""
    return {_module(path): path.read_text("utf-8") for folder in FOLDERS for path in (_PACKAGE / folder).glob("*.py")}


@cache
def _makers() -> bytes:
    """What makes kernels of functions, and so is part of all of them."""
    return b"".join(Path(__file__).with_stem(name).read_bytes() for name in ("decorators", "results", "separate", "views"))


def _module(path: Path) -> str:
    return ".".join(("stickslip", *path.relative_to(_PACKAGE).with_suffix("").parts))
