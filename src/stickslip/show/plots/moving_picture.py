"""Pictures that move over one period: frames of plotly.js with play, pause, speed, slider and steps of one frame.

A moving picture describes itself as data, traces and frames, from which notebooks, the explorer and the report draw it.
"""

import html
import shutil
from abc import ABC, abstractmethod
from collections.abc import Callable
from importlib.resources import files
from pathlib import Path
from subprocess import CalledProcessError
from typing import Any

import numpy as np

from stickslip.show.plots.chart import wrapped
from stickslip.show.plots.interactive import escaped, resolved
from stickslip.show.plots.look import house_style
from stickslip.support.checks import InputError, between, fault, finite
from stickslip.support.files import replacing, write_text
from stickslip.support.late import Figure

SPEEDS = {"slow": 120, "normal": 50, "fast": 20}
"""Milliseconds of a frame."""
PLAYED = 40
"""Periods after which playing ends."""
CONFIG = {"displaylogo": False, "showSendToCloud": False, "plotlyServerURL": "", "typesetMath": False}
"""Of plotly.js, without the button that uploads a figure."""
NARROW, NARROW_NOTE, LINE = 42, 68, 22
"""Letters of a line of the title and of the note on a narrow screen, and the height of a line."""
FILES = (".gif", ".webp", ".mp4", ".html")
FPS = 20
SLOWEST, FASTEST = 0.01, 1000.0
"""Frames per second of a film; a .gif cannot hold a frame for longer than minutes."""


class MovingPicture(ABC):
    """What notebooks, pages, reports and films need of a picture that moves."""

    @property
    @abstractmethod
    def title(self) -> str:
        """What it shows."""

    @property
    @abstractmethod
    def frames(self) -> int:
        """How many pictures there are."""

    @abstractmethod
    def _drawn(self) -> tuple[Figure, Callable[[int], object]]:
        """A matplotlib figure, and what shows a frame in it."""

    @abstractmethod
    def description(self) -> dict[str, Any]:
        """title, note, traces `data`, `frames`, and layouts `wide` and `narrow` of plotly, with colours by name."""

    def to_plotly(self, *, dark: bool = False, narrow: bool = False) -> Any:
        """As a figure of plotly with frames: `.show()` or `.write_html(path)`; narrow: for a narrow screen."""
        from plotly.graph_objects import Figure as Interactive

        described = self.description()
        lines = wrapped(described["title"], NARROW) if narrow else [described["title"]]
        notes = wrapped(described["note"], NARROW_NOTE) if narrow else [described["note"]]
        heads = [f"<b>{escaped(line)}</b>" for line in lines] + [f"<sup>{escaped(line)}</sup>" for line in notes]
        title, more = {"text": "<br>".join(heads), "x": 0.01}, LINE * (len(heads) - 2)
        layout = described["narrow" if narrow else "wide"] | {"title": title, "paper_bgcolor": "@paper", "plot_bgcolor": "@paper"}
        layout["margin"] = layout["margin"] | {"t": 70 + more}
        layout["height"] = layout["height"] + 54 + more
        return Interactive(resolved({"data": described["data"], "layout": layout, "frames": described["frames"]}, dark))

    def to_html(self, *, dark: bool = False) -> str:
        """A page that needs nothing else: plotly.js is in it (5 MB)."""
        steps = f"{step_script()}const div = document.getElementById('{{plot_id}}'); div.before(stepper(div));"
        page: str = self.to_plotly(dark=dark).to_html(
            full_html=True, include_plotlyjs=True, auto_play=False, config=CONFIG, post_script=steps
        )
        return page

    def plot(self, frame: int = 0) -> Figure:
        """One picture as a matplotlib figure."""
        figure, show = self._drawn()
        show(between("frame", frame, 0, self.frames - 1))
        return figure

    def save(self, path: str | Path, fps: float = FPS) -> Path:
        """One period as a film that can be repeated, .gif or .webp (by Pillow) or .mp4 (by ffmpeg), or as a page: .html.

        fps: frames per second of a film; a page has speeds to choose from. Missing folders are made. Raises `InputError` where
        the file cannot be written.
        """
        place, kind = Path(path), Path(path).suffix.lower()
        if kind not in FILES:
            raise fault("The name of a moving picture", f"must end in {', '.join(FILES)}", str(path))
        if not SLOWEST <= finite("fps", fps) <= FASTEST:
            raise fault("fps", f"must lie between {SLOWEST:g} and {FASTEST:g} frames per second", fps)
        try:
            if kind == ".html":
                return write_text(place, self.to_html())
            self._film(place, fps)
        except (OSError, CalledProcessError) as error:
            raise InputError(f"The {'page' if kind == '.html' else 'film'} {place} could not be written: {error}") from error
        return place

    def _film(self, place: Path, fps: Any) -> None:
        """fps: a number; writers take fractions too."""
        from matplotlib import rc_context, rcParams
        from matplotlib.animation import FFMpegWriter, FuncAnimation, PillowWriter

        film = place.suffix.lower() == ".mp4"
        writer: Any = FFMpegWriter(fps=fps) if film else PillowWriter(fps=fps)
        with house_style(), rc_context():
            if film:
                rcParams["animation.ffmpeg_path"] = _ffmpeg()
            figure, show = self._drawn()
            shown: Any = show
            with replacing(place) as temporary:
                FuncAnimation(figure, shown, frames=self.frames, blit=False).save(temporary, writer=writer, dpi=90)

    def _repr_html_(self) -> str:
        described = self.description()
        page, title = html.escape(self.to_html(), quote=True), html.escape(described["title"])
        height = described["wide"]["height"] + 150
        return f'<iframe style="width:100%;height:{height}px;border:0" title="{title}" srcdoc="{page}"></iframe>'


def _ffmpeg() -> str:
    """Where the program ffmpeg is: of the system, else of the package imageio-ffmpeg.

    On Windows the search begins in the working folder, which may be that of a model; what is found there has no absolute path.
    """
    from matplotlib import rcParams

    program = shutil.which(rcParams["animation.ffmpeg_path"])
    if program is None or not Path(program).is_absolute():
        try:
            from imageio_ffmpeg import get_ffmpeg_exe

            program = get_ffmpeg_exe()
        except (ImportError, RuntimeError):
            raise InputError(
                "A .mp4 file needs the program ffmpeg, which is not installed. `pip install 'stickslip[film]'` installs it; or "
                "save a .gif."
            ) from None
    return str(program)


def step_script() -> str:
    """The functions of the buttons that step through the frames."""
    return files("stickslip.show.plots").joinpath("step.js").read_text(encoding="utf-8")


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
