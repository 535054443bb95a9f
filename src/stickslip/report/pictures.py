"""Figures as pictures inside the page."""

from __future__ import annotations

import base64
import io
from typing import TYPE_CHECKING

from stickslip.plots.look import house_style
from stickslip.report.markup import text

if TYPE_CHECKING:
    from matplotlib.figure import Figure


def picture(figure: Figure, description: str) -> str:
    """A figure as an SVG image; the same figure gives the same text."""
    buffer = io.BytesIO()
    with house_style():
        figure.savefig(buffer, format="svg", metadata={"Date": None})
    data = base64.b64encode(buffer.getvalue()).decode()
    return f'<img alt="{text(description)}" style="max-width:100%" src="data:image/svg+xml;base64,{data}">'
