"""HTML as strings: all data enter the page through `text` or `cell`, which escape them.

Numbers as text: Hz, per cent, energies with prefix.
"""

from __future__ import annotations

import base64
import gzip
import html
import io
import math
import re
from collections.abc import Iterable, Sequence
from typing import TYPE_CHECKING, Literal

from stickslip.show.plots.look import house_style

if TYPE_CHECKING:
    from matplotlib.figure import Figure

MOST_ROWS = 40
"""Rows of a table that stands open."""


def text(value: object) -> str:
    """Any value as text of the page: <, >, & and quotes are escaped."""
    return html.escape(str(value), quote=True)


def cell(shown: str, value: float | None = None, note: str = "") -> str:
    """A table cell; a number carries its exact value in SI units as data-value."""
    data = "" if value is None else f' data-value="{float(value)!r}"'
    kind = ' class="number"' if value is not None else ""
    return f"<td{kind}{data}>{text(shown)}{f' <small>{text(note)}</small>' if note else ''}</td>"


def table(identifier: str, caption: str, heads: Sequence[str], rows: Iterable[str], stacked: bool = False) -> str:
    """A table whose `rows` are ready <tr> elements; heads of numbers stand over their numbers, a long table is folded.

    stacked: on a narrow screen every number of a row stands below its head, so that none is out of sight.
    """
    ready = list(rows)
    kinds = re.findall(r"<td( class=\"number\")?", ready[0]) if ready else []
    kinds += [""] * (len(heads) - len(kinds))
    head = "".join(f'<th scope="col"{kind}>{text(name)}</th>' for name, kind in zip(heads, kinds, strict=False))
    kind = ""
    if stacked:
        kind, cells = ' class="stacked"', re.compile(r"<td(?! colspan)")
        for k, row in enumerate(ready):
            names = iter(heads)
            ready[k] = cells.sub(lambda found, names=names: f'{found[0]} data-head="{text(next(names))}"', row)  # type: ignore[misc]
    html = (
        f'<div class="wide" tabindex="0" role="region" aria-label="{text(caption)}"><table id="{identifier}"{kind}>'
        f"<caption>{text(caption)}</caption><thead><tr>{head}</tr></thead><tbody>{''.join(ready)}</tbody></table></div>"
    )
    folded = f"<details><summary>{text(caption.rstrip('.'))} ({len(ready)} rows)</summary>{html}</details>"
    return folded if len(ready) > MOST_ROWS else html


def section(identifier: str, title: str, *parts: str) -> str:
    """A section of the page with its heading."""
    heading = f'<h2 id="{identifier}-h">{text(title)}</h2>'
    return f'<section id="{identifier}" aria-labelledby="{identifier}-h">{heading}{"".join(parts)}</section>'


def picture(figure: Figure, description: str, kind: Literal["svg", "png"] = "svg") -> str:
    """A figure as an SVG image, or as PNG where it has thousands of faces; the same figure gives the same text."""
    buffer = io.BytesIO()
    with house_style():
        figure.savefig(buffer, format=kind, metadata={"Date": None} if kind == "svg" else None)
    data = base64.b64encode(buffer.getvalue()).decode()
    media = {"svg": "svg+xml", "png": "png"}[kind]
    return f'<img alt="{text(description)}" style="max-width:100%" src="data:image/{media};base64,{data}">'


def packed(identifier: str, content: str) -> str:
    """A text that report.js unpacks: gzipped and in base64 it takes a third of its size, and cannot leave its element."""
    encoded = base64.b64encode(gzip.compress(content.encode(), 5, mtime=0)).decode()
    return f'<script type="text/plain" id="{identifier}">{encoded}</script>'


def number(value: float, digits: int = 4) -> str:
    """A number with so many digits, never in exponents where a reader would not write them."""
    if not math.isfinite(value):
        return "–"
    return f"{value:.{digits}g}" if not 1e4 <= abs(value) < 1e7 else f"{value:.0f}"


def hertz(value: float) -> str:
    """A frequency, to a hundredth, or to five digits below 10 Hz."""
    if not math.isfinite(value):
        return "–"
    return f"{value:.2f}" if abs(value) >= 10.0 else f"{value:.5g}"


def percent(value: float) -> str:
    """A share in percent; more digits where it is near 100 %."""
    return f"{100.0 * value:.1f} %" if 0.0 < abs(1.0 - value) < 0.02 or abs(value) < 0.1 else f"{100.0 * value:.0f} %"
