"""Sphinx settings of the documentation. The study reference is written from its data model before each build."""

import re
import sys
from pathlib import Path
from typing import Any

from docutils import nodes
from latex2mathml.converter import convert

import stickslip

HERE = Path(__file__).parent
sys.path.insert(0, str(HERE))

import api_pages  # noqa: E402

api_pages.write(HERE / "api")

project = "stickslip"
author = "The stickslip developers"
copyright = "The stickslip developers"
release = version = stickslip.__version__

extensions = ["myst_parser", "sphinx.ext.autodoc", "sphinx.ext.autosummary", "sphinx_design"]
myst_enable_extensions = ["dollarmath", "deflist", "colon_fence"]
myst_heading_anchors = 3
exclude_patterns = ["_build", "gallery", "variability_numbers.md"]
html_theme = "furo"
html_title = "stickslip"
html_math_renderer = "mathml"
html_static_path = ["_static"]
html_css_files = ["pages.css"]
nitpicky = True
nitpick_ignore = [("py:class", "collections.abc.Callable")]

autodoc_typehints = "none"
autodoc_member_order = "bysource"


def as_plain_text(app: Any, what: str, name: str, item: Any, options: Any, lines: list[str]) -> None:
    """Docstrings are plain text: names in backticks become code, other marks of reStructuredText stand for themselves."""
    example = False
    for i, line in enumerate(lines):
        example = line.lstrip().startswith(">>>") or (example and bool(line.strip()))
        if not example:
            parts = re.split(r"(`[^`]+`)", line.strip())
            lines[i] = "".join(f"`{part}`\\ " if k % 2 else re.sub(r"([*|_\\\\])", r"\\\1", part) for k, part in enumerate(parts))


def without_markers(app: Any, name: str, source: list[str]) -> None:
    """Comments that say what computes a number (CONTRIBUTING.md) stay out of the built pages."""
    source[0] = re.sub(r" ?<!--.*?-->", "", source[0], flags=re.S)


def inline_formula(page: Any, node: Any) -> None:
    """A formula as MathML, which browsers show by themselves: no script, nothing from another host."""
    page.body.append(convert(node.astext()))
    raise nodes.SkipNode


def displayed_formula(page: Any, node: Any) -> None:
    page.body.append(f'<div class="formula">{convert(node.astext(), display="block")}</div>')
    raise nodes.SkipNode


def setup(app: Any) -> None:
    app.add_html_math_renderer("mathml", (inline_formula, None), (displayed_formula, None))
    app.connect("source-read", without_markers)
    app.connect("autodoc-process-docstring", as_plain_text)
