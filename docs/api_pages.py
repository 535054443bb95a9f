"""Pages of the public names, one for each topic of `stickslip/__init__.pyi`: a table of all names, then their descriptions."""

from __future__ import annotations

import inspect
import re
from pathlib import Path

import stickslip

STUB = Path(stickslip.__file__).with_name("__init__.pyi")
MODULES = ("dampers", "rigs", "units")
"""Names that are modules; rigs and dampers have pages of their own."""


def topics() -> dict[str, list[str]]:
    """Public names by topic, in the order of the stub."""
    found: dict[str, list[str]] = {}
    for block in re.split(r"^# ", STUB.read_text(), flags=re.M)[1:]:
        title, _, text = block.partition("\n")
        names = [name for name in re.findall(r" as (\w+)", text) if name not in MODULES]
        found[title.strip()] = names
    return found


def slug(title: str) -> str:
    return re.sub(r"\W+", "_", title.lower()).strip("_")


def page(title: str, names: list[str]) -> str:
    """One page: a table with the first sentence of each name, then all descriptions."""
    table = "\n".join(f"   {name}" for name in names)
    entries = "\n".join(entry(name) for name in names)
    heads = f".. currentmodule:: stickslip\n\n.. autosummary::\n   :nosignatures:\n\n{table}\n"
    return f"# {title}\n\n```{{eval-rst}}\n{heads}```\n\n```{{eval-rst}}\n{entries}\n```\n"


def entry(name: str) -> str:
    """The directive that documents a name."""
    if inspect.isclass(getattr(stickslip, name)):
        return f".. autoclass:: stickslip.{name}\n   :members:\n   :exclude-members: count, index\n"
    return f".. autofunction:: stickslip.{name}\n"


def write(folder: Path) -> None:
    """Write the pages; what is there and equal stays, so that nothing is built twice."""
    folder.mkdir(exist_ok=True)
    for title, names in topics().items():
        path, text = folder / f"{slug(title)}.md", page(title, names)
        if not path.exists() or path.read_text() != text:
            path.write_text(text)
