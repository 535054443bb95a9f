"""Sphinx settings of the documentation. The study reference is written from its data model before each build."""

from pathlib import Path

import stickslip

HERE = Path(__file__).parent

project = "stickslip"
author = "The stickslip developers"
copyright = "The stickslip developers"
release = version = stickslip.__version__

extensions = ["myst_parser"]
myst_enable_extensions = ["dollarmath", "deflist", "colon_fence"]
myst_heading_anchors = 3
exclude_patterns = ["_build", "gallery"]
html_theme = "furo"
html_title = "stickslip"
nitpicky = True
