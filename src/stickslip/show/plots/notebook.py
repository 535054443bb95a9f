"""Figures that notebooks show as pictures."""

from __future__ import annotations

import io

from matplotlib.figure import Figure

from stickslip.show.plots.look import house_style


class NotebookFigure(Figure):
    """A matplotlib figure that a notebook shows without pyplot; with pyplot's inline backend it is shown once all the same."""

    def _repr_png_(self) -> bytes:
        buffer = io.BytesIO()
        with house_style():
            self.savefig(buffer, format="png")
        return buffer.getvalue()
