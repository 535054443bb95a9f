"""Pictures that move over one period: frames of plotly.js with play, pause, speed, slider and steps of one frame.

A moving picture describes itself as data, traces and frames, from which notebooks, the explorer and the report draw it.
"""

from __future__ import annotations

import html
from abc import ABC, abstractmethod
from importlib.resources import files
from typing import Any

import numpy as np

from stickslip.plots.interactive import escaped, resolved

SPEEDS = {"slow": 120, "normal": 50, "fast": 20}
"""Milliseconds of a frame."""
PLAYED = 40
"""Periods after which playing ends."""
CONFIG = {"displaylogo": False, "showSendToCloud": False, "plotlyServerURL": "", "typesetMath": False}
"""Of plotly.js, without the button that uploads a figure."""


class MovingPicture(ABC):
    """What notebooks, pages and reports need of a picture that moves."""

    @property
    @abstractmethod
    def title(self) -> str:
        """What it shows."""

    @abstractmethod
    def description(self) -> dict[str, Any]:
        """title, note, traces `data`, `frames`, and layouts `wide` and `narrow` of plotly, with colours by name."""

    def to_plotly(self, *, dark: bool = False, narrow: bool = False) -> Any:
        """As a figure of plotly with frames: `.show()` or `.write_html(path)`; narrow: for a narrow screen."""
        from plotly.graph_objects import Figure as Interactive

        found = self.description()
        title = {"text": f"<b>{escaped(found['title'])}</b><br><sup>{escaped(found['note'])}</sup>", "x": 0.01}
        layout = found["narrow" if narrow else "wide"] | {"title": title, "paper_bgcolor": "@paper", "plot_bgcolor": "@paper"}
        layout["margin"] = layout["margin"] | {"t": 70}
        layout["height"] = layout["height"] + 54
        return Interactive(resolved({"data": found["data"], "layout": layout, "frames": found["frames"]}, dark))

    def to_html(self, *, dark: bool = False) -> str:
        """A page that needs nothing else: plotly.js is in it (5 MB)."""
        steps = f"{step_script()}const div = document.getElementById('{{plot_id}}'); div.before(stepper(div));"
        page: str = self.to_plotly(dark=dark).to_html(
            full_html=True, include_plotlyjs=True, auto_play=False, config=CONFIG, post_script=steps
        )
        return page

    def _repr_html_(self) -> str:
        found = self.description()
        page, title = html.escape(self.to_html(), quote=True), html.escape(found["title"])
        height = found["wide"]["height"] + 150
        return f'<iframe style="width:100%;height:{height}px;border:0" title="{title}" srcdoc="{page}"></iframe>'


def step_script() -> str:
    """The functions of the buttons that step through the frames."""
    return files("stickslip.plots").joinpath("step.js").read_text(encoding="utf-8")


def magnification(drawn: float, largest: float) -> float:
    """How many times displacements are drawn larger than they are: the next of 1, 2, 5 times a power of ten below drawn/largest,
    both [m]; 1 where nothing moves."""
    if not largest > 0.0 or not drawn > 0.0:
        return 1.0
    power = 10.0 ** np.floor(np.log10(drawn / largest))
    return float(power * max(step for step in (1.0, 2.0, 5.0) if step * power <= drawn / largest * (1.0 + 1e-12)))


def played(frames: int, at: dict[str, float], slider: dict[str, float], redraw: bool = False) -> dict[str, Any]:
    """Play, pause and speed at a place, and a slider below; redraw: traces in space move only if they are drawn anew."""

    def timed(milliseconds: int) -> dict[str, Any]:
        frame = {"duration": milliseconds, "redraw": redraw}
        return {"frame": frame, "transition": {"duration": 0}, "mode": "immediate"}

    names = [str(frame) for frame in range(frames)] * PLAYED
    look = {"bgcolor": "@paper", "bordercolor": "@grid", "font": {"color": "@text"}}
    place = {"type": "buttons", "direction": "right", "xanchor": "left", "yanchor": "top", "showactive": False}
    play = [{"label": f"▶ {speed}", "method": "animate", "args": [names, timed(ms)]} for speed, ms in SPEEDS.items()]
    pause = {"label": "❚❚ pause", "method": "animate", "args": [[None], timed(0)]}
    buttons = {**place, **at, **look, "buttons": [*play, pause], "pad": {"t": 0, "r": 8}}
    steps = [{"label": f"{frame / frames:.2f}", "method": "animate", "args": [[str(frame)], timed(0)]} for frame in range(frames)]
    value = {"prefix": "share of the period ", "xanchor": "right"}
    track = {"bgcolor": "@grid", "bordercolor": "@grid", "tickcolor": "@grid", "font": {"color": "@text"}}
    return {"updatemenus": [buttons], "sliders": [{"steps": steps, **slider, "pad": {"t": 4}, "currentvalue": value, **track}]}
