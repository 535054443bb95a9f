"""The deformed shape of meshed bodies over one period, coloured by amplitude: a mesh of plotly that can be turned and played, and
pictures and films of matplotlib.

Deformed shapes as a file of VTK (.vtu, XML in text), for ParaView and other programs.

Written here and not by meshio, which would be one more dependency for forty lines and has had no release since January 2024.

Pictures that move over one period: frames of plotly.js with play, pause, speed, slider and steps of one frame.

A moving picture describes itself as data, traces and frames, from which notebooks, the explorer and the report draw it.
"""

import html
import shutil
from abc import ABC, abstractmethod
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import cached_property
from importlib.resources import files
from pathlib import Path
from subprocess import CalledProcessError
from typing import Any
from xml.sax.saxutils import quoteattr

import numpy as np
from numpy.typing import NDArray

from stickslip.analyses.solved_points import SurfaceMotion
from stickslip.analyses.static_load import fields_at_rest
from stickslip.results.schema import in_system, system_of
from stickslip.results.view import Length, unit_in
from stickslip.show.plots.chart import wrapped
from stickslip.show.plots.interactive import BASE, Combination, escaped, resolved
from stickslip.show.plots.look import colour, house_style, plain
from stickslip.show.plots.model_view import axes_upright, in_space, scene
from stickslip.support.checks import Array, Index, InputError, between, fault, finite
from stickslip.support.files import replacing, write_text
from stickslip.support.late import Figure, xr
from stickslip.support.renderers import FIGURES

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


FRAMES = 24
"""Pictures of a period."""
DRAWN = 0.1
"""The largest displacement in a drawing, relative to the extent of the bodies."""
HEIGHT, PHONE_HEIGHT = 620, 560


@FIGURES.of("SurfaceMotion")
@dataclass(frozen=True, eq=False, repr=False)
class DeformedShape(MovingPicture):
    """One harmonic of the displacement of meshed bodies over its period, from the instant of the largest deflection on.

    A notebook shows it with play, pause, speed, a slider and steps of one frame, and it can be turned; `.to_html()` is the same
    as a page, `.to_plotly()` the figure, `.save("x.gif")` a film, `.plot(frame)` one picture. `motion`: points [m], triangles,
    displacement (complex) and amplitude [m].
    """

    motion: SurfaceMotion

    def __repr__(self) -> str:
        return f"DeformedShape of {self.title}: {len(self.motion.points)} points; {self.note}"

    @property
    def title(self) -> str:
        return self.motion.title

    @property
    def frames(self) -> int:
        """How many pictures there are; the first one shows the instant of the largest deflection."""
        return FRAMES

    @cached_property
    def magnification(self) -> float:
        """How many times displacements are drawn larger than they are, a round number."""
        extent = float(np.ptp(self.motion.points, axis=0).max())
        return magnification(DRAWN * extent, float(self.motion.amplitude.max()))

    @property
    def note(self) -> str:
        """What is magnified, and by how much, and the largest amplitude."""
        largest, unit = float(self.motion.amplitude.max()), self._unit
        amplitude = f"colours: amplitude, largest {largest / unit.metres:.4g} {unit.name}"
        parts = (f"Displacements magnified {self.magnification:g} times", amplitude, self.motion.note)
        return "; ".join(filter(None, parts))

    @property
    def _unit(self) -> Length:
        """The unit of amplitudes."""
        return unit_in(self.motion.system, "m", float(self.motion.amplitude.max()))

    @cached_property
    def _turned(self) -> NDArray[np.complex128]:
        """The displacement (p, 3) [m], as drawn, with the phase of the instant at which its real part is largest."""
        u = self.motion.displacement
        return np.asarray(self.magnification * u * np.exp(-0.5j * np.angle(np.sum(u**2))))

    def _weights(self, frame: int) -> tuple[float, float, float]:
        """Of points, real and imaginary part: Re u exp(iφ) = Re u cos φ − Im u sin φ."""
        phase = 2.0 * np.pi * frame / FRAMES
        return 1.0, float(np.cos(phase)), -float(np.sin(phase))

    def moved(self, frame: int = 0) -> Array:
        """The points (p, 3) [m] in one frame, displacements magnified."""
        one, real, imaginary = self._weights(between("frame", frame, 0, FRAMES - 1))
        return np.asarray(one * self.motion.points + real * self._turned.real + imaginary * self._turned.imag)

    @cached_property
    def _limits(self) -> Array:
        """Ends of the axes, (2, 3) [m], that hold every frame."""
        reach, points = np.abs(self._turned), self.motion.points
        low, high = np.min(points - reach, axis=0), np.max(points + reach, axis=0)
        rim = 0.01 * float((high - low).max())  # a flat body needs room too
        return np.array([low - rim, high + rim])

    def description(self) -> dict[str, Any]:
        metre, unit = in_system("m", self.motion.system)[0], self._unit
        parts = self.motion.points, self._turned.real, self._turned.imag
        arrays = [(metre * values).astype(np.float32) for values in parts]
        corners = {name: self.motion.triangles[:, k].astype(np.int32) for k, name in enumerate("ijk")}
        rest = {name: arrays[0][:, axis] for axis, name in enumerate("xyz")}
        columns = {name: tuple(array[:, axis] for array in arrays) for axis, name in enumerate("xyz")}

        def at(frame: int) -> dict[str, Any]:
            return {name: Combination(self._weights(frame), column) for name, column in columns.items()}

        mesh = {"type": "mesh3d", "hoverinfo": "skip", **corners}
        colours = {
            "intensity": (self.motion.amplitude / unit.metres).astype(np.float32),
            "colorscale": "Viridis",
            "cmin": 0.0,
            "colorbar": {"title": {"text": f"amplitude in {unit.name}"}, "thickness": 14, "len": 0.7},
            "flatshading": True,
            "lighting": {"ambient": 0.75, "diffuse": 0.5, "specular": 0.05},
        }
        at_rest = {"color": "@grey", "opacity": 0.12, "showscale": False, **rest}
        described = {"title": self.title, "note": self.note, "data": [mesh | at(0) | colours, mesh | at_rest]}
        described["frames"] = [
            {"name": str(frame), "data": [{"type": "mesh3d", **at(frame)}], "traces": [0]} for frame in range(FRAMES)
        ]
        return described | {name: self._layout(name == "narrow") for name in ("wide", "narrow")}

    def _layout(self, narrow: bool) -> dict[str, Any]:
        metre, length = in_system("m", self.motion.system)
        low, high = metre * self._limits
        space = scene(high - low, length, "@paper")
        for k, axis in enumerate("xyz"):
            space[f"{axis}axis"] |= {"range": [float(low[k]), float(high[k])], "gridcolor": "@grid", "color": "@text"}
            space[f"{axis}axis"] |= {"nticks": 5, "showspikes": False}
        slider = {"x": 0.0, "len": 1.0, "y": -0.15} if narrow else {"x": 0.52, "len": 0.48, "y": -0.01}
        buttons = {"x": 0.0, "y": -0.02 if narrow else -0.03}
        return {
            **BASE,
            "height": PHONE_HEIGHT if narrow else HEIGHT,
            "font": {"color": "@text"},
            "margin": {"l": 0, "r": 0, "t": 16, "b": 160 if narrow else 90},
            "scene": space | {"uirevision": "kept"},
            **played(FRAMES, buttons, slider, redraw=True),
        }

    def _drawn(self) -> tuple[Figure, Callable[[int], object]]:
        from matplotlib import cm, colormaps, colors
        from mpl_toolkits.mplot3d.art3d import Poly3DCollection

        from stickslip.show.plots.paper import NotebookFigure

        motion, unit = self.motion, self._unit
        metre, length = in_system("m", motion.system)
        sizes, sides = motion.amplitude / unit.metres, self._limits[1] - self._limits[0]
        order = axes_upright(sides)
        scale = cm.ScalarMappable(colors.Normalize(0.0, float(sizes.max()) or 1.0), colormaps["viridis"])
        faces = scale.to_rgba(sizes[motion.triangles].mean(axis=1))
        with house_style():
            figure = NotebookFigure(figsize=(6.4, 6.4))
            axes: Any = figure.add_axes((0.02, 0.06, 0.8, 0.84), projection="3d")
            corners = metre * self.moved()[motion.triangles][:, :, order]
            surface = Poly3DCollection(corners, facecolors=faces, edgecolors=colour("grey"), linewidths=0.15)
            axes.add_collection3d(surface)
            limits = metre * self._limits[:, order].T
            axes.set(xlim=limits[0], ylim=limits[1], zlim=limits[2])
            in_space(axes, sides, length)
            bar = figure.add_axes((0.86, 0.2, 0.025, 0.5))
            figure.colorbar(scale, cax=bar, label=f"amplitude in {unit.name}")
            heading = "\n".join((self.title, *wrapped(self.note, 84)))
            figure.suptitle(plain(heading), x=0.01, ha="left", fontsize=9.5)
        return figure, lambda frame: surface.set_verts(metre * self.moved(frame)[motion.triangles][:, :, order])


def save_vtu(shapes: Mapping[str, SurfaceMotion], path: str | Path) -> Path:
    """Write deformed shapes {name: shape} of one surface to a .vtu file, in the units of their study, and return its path.

    The file contains the points and triangles of the surface at rest, and for each shape NAME three fields: "NAME, real part" and
    "NAME, imaginary part" (p, 3), u(t) = Re cos ωt − Im sin ωt, and "NAME, amplitude" (p,), the largest displacement in the
    period.
    """
    if not shapes:
        raise InputError("A .vtu file must contain deformed shapes, but these results have none: no body has a surface mesh.")
    first = next(iter(shapes.values()))
    metre, unit = in_system("m", first.system)
    fields: dict[str, Any] = {}
    for name, shape in shapes.items():
        fields[f"{name}, real part [{unit}]"] = metre * shape.displacement.real
        fields[f"{name}, imaginary part [{unit}]"] = metre * shape.displacement.imag
        fields[f"{name}, amplitude [{unit}]"] = metre * shape.amplitude
    return _written(path, metre * first.points, first.triangles, fields)


def save_contacts_vtu(dataset: xr.Dataset, path: str | Path) -> Path:
    """Write the nodes of the contact surfaces of a result to a .vtu file, with its contacts at rest as fields, and return its
    path: in the units of the study, 1 and 2 in the state being closed and at the friction limit, 0 open."""
    places = in_system("m", system_of(dataset))[0] * dataset["contact_node_place"].values
    return _written(path, places, np.arange(len(places))[:, None], fields_at_rest(dataset))


def _written(path: str | Path, points: Array, corners: Index, fields: Mapping[str, Any]) -> Path:
    """A file of points (p, 3), cells, which are triangles (t, 3) or single points (t, 1), and fields of the points."""
    count, size = corners.shape
    cells = [
        _array("connectivity", corners.ravel(), "Int32"),
        _array("offsets", size * np.arange(1, count + 1), "Int32"),
        _array("types", np.full(count, 5 if size == 3 else 1), "UInt8"),  # the numbers of triangle and point among VTK's cells
    ]
    text = (
        '<?xml version="1.0"?>\n<VTKFile type="UnstructuredGrid" version="0.1" byte_order="LittleEndian">\n<UnstructuredGrid>\n'
        f'<Piece NumberOfPoints="{len(points)}" NumberOfCells="{count}">\n'
        f"<Points>\n{_array('points', points)}</Points>\n<Cells>\n{''.join(cells)}</Cells>\n"
        f"<PointData>\n{''.join(_array(name, values) for name, values in fields.items())}</PointData>\n"
        "</Piece>\n</UnstructuredGrid>\n</VTKFile>\n"
    )
    return write_text(path, text)


def _array(name: str, values: Any, kind: str = "Float32") -> str:
    """One array in text, a row a line."""
    table = np.reshape(values, (len(values), -1))
    form = "%.7g" if kind.startswith("Float") else "%d"
    rows = "".join(" ".join(form % value for value in row) + "\n" for row in table.tolist())
    head = f'<DataArray type="{kind}" Name={quoteattr(name)} NumberOfComponents="{table.shape[1]}" format="ascii">'
    return f"{head}\n{rows}</DataArray>\n"
