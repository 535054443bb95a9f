"""Runs the examples and keeps what they print and draw for the page of examples: `make gallery`, or some by name.

A picture is the figure that an example saves, or that of the last result it makes.
"""

from __future__ import annotations

import contextlib
import io
import os
import re
import runpy
import sys
import tempfile
import warnings
from pathlib import Path

from stickslip.results.schema import Result

ROOT = Path(__file__).parents[1]
KEPT = ROOT / "docs" / "gallery"
PAGE = ROOT / "docs" / "examples.md"
SHOWN = re.compile(r"\nIt prints\n\n```\{literalinclude\} gallery/.*?```\n|\n!\[[^\n]*\]\(gallery/[^\n]*\)\n", re.S)
"""What the page shows of an example below its code."""
CODE = re.compile(r"## ([^\n]+)\n(?:(?!## ).)*?```\{literalinclude\} \.\./examples/(\w+)\.py\n.*?```\n", re.S)
DPI = 90


def main(names: list[str]) -> None:
    """Renew the text and the picture of the examples named, of all without a name."""
    KEPT.mkdir(exist_ok=True)
    for path in sorted((ROOT / "examples").glob("*.py")):
        if not names or path.stem in names:
            text = kept(path)
            print(f"{path.stem}: {len(text.splitlines())} lines")
    PAGE.write_text(CODE.sub(lambda match: match[0] + shown(match[2], match[1]), SHOWN.sub("", PAGE.read_text())))


def shown(name: str, title: str) -> str:
    """What an example prints and draws, for the page."""
    text = f"\nIt prints\n\n```{{literalinclude}} gallery/{name}.txt\n:language: text\n```\n"
    return text + (f"\n![{title}](gallery/{name}.png)\n" if (KEPT / f"{name}.png").exists() else "")


def kept(path: Path) -> str:
    """Run one example in a folder of its own; keeps its picture and text, and returns the text."""
    output, home = io.StringIO(), Path.cwd()
    with tempfile.TemporaryDirectory() as folder:
        os.chdir(folder)
        try:
            with contextlib.redirect_stdout(output), warnings.catch_warnings():
                warnings.simplefilter("ignore")
                names = runpy.run_path(str(path), run_name="__main__")
            picture(names, Path(folder), KEPT / f"{path.stem}.png")
        finally:
            os.chdir(home)
    text = "\n".join(line.rstrip() for line in output.getvalue().strip().splitlines())
    (KEPT / f"{path.stem}.txt").write_text(f"{text}\n")
    return text


def picture(names: dict[str, object], folder: Path, target: Path) -> None:
    """The first figure that was saved, or that of the last result."""
    saved = sorted(folder.glob("*.png"), key=lambda path: path.stat().st_mtime)
    if saved:
        target.write_bytes(saved[-1].read_bytes())
        return
    drawable = [value for value in names.values() if isinstance(value, Result)]
    if drawable:
        drawable[-1].plot().savefig(target, dpi=DPI)


if __name__ == "__main__":
    main(sys.argv[1:])
