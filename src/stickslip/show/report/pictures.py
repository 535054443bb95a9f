"""Figures embedded in the page."""

from __future__ import annotations

import base64
import io
from typing import TYPE_CHECKING, Literal

from stickslip.show.plots.look import house_style
from stickslip.show.report.markup import text

if TYPE_CHECKING:
    from matplotlib.figure import Figure


def picture(figure: Figure, description: str, kind: Literal["svg", "png"] = "svg") -> str:
    """A figure as an SVG image, or as PNG where it has thousands of faces; the same figure gives the same text."""
    buffer = io.BytesIO()
    with house_style():
        figure.savefig(buffer, format=kind, metadata={"Date": None} if kind == "svg" else None)
    data = base64.b64encode(buffer.getvalue()).decode()
    media = {"svg": "svg+xml", "png": "png"}[kind]
    return f'<img alt="{text(description)}" style="max-width:100%" src="data:image/{media};base64,{data}">'
