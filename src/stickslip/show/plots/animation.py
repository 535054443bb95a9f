"""Animations of one period: a section that moves, contact points by state, force arrows, loops with a dot that goes round.

`Animation` holds what the renderers share: `to_plotly`, `to_html` and the report draw it with frames of plotly.js, films and
`plot` with matplotlib. Colours stand by name, as in `interactive.py`.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np

from stickslip.analyses.motion import STATES, PeriodOfMotion, Wheel, frames_of, largest_loops
from stickslip.results.schema import in_system
from stickslip.results.view import unit_in
from stickslip.show.plots.chart import polygons
from stickslip.show.plots.deformed_shape import MovingPicture, magnification, played
from stickslip.show.plots.interactive import BASE, escaped
from stickslip.show.plots.look import colour, house_style, plain
from stickslip.support.checks import Array
from stickslip.support.late import Axes, Figure
from stickslip.support.renderers import FIGURES
from stickslip.support.units import UnitSystem

COLOURS = ("stick", "slip", "microslip", "lift-off")
"""Of `STATES`, named as in `look.py`."""
DRAWN_MOTION, DRAWN_FORCE = 0.07, 0.3
"""The largest displacement and the longest arrow in a drawing, relative to its extent."""
HATCH = 0.06
"""Thickness of the platform that is drawn behind a face, relative to the extent."""
MOST_LOOPS = 4
"""Loops that are drawn: those that enclose most."""
MOST_STRIPS = 16
"""Directions whose states over the period are drawn."""
HUB, BLADE = 0.55, 0.45
"""Radius of the hub of a wheel and length of its blades, of a radius of 1."""
BINS = 8
"""Colours of amplitudes in a wheel."""
HEIGHT, PHONE_HEIGHT = 520, 980


@dataclass(frozen=True, eq=False)
class Polyline:
    """One thing that is drawn: x and y (frames, k), or (1, k) where it stays; NaN breaks it. panel: section, loops or wheel."""

    panel: str
    x: Array
    y: Array
    colour: str
    label: str = ""
    width: float = 1.6
    filled: bool = False
    marker: float = 0.0

    def at(self, frame: int) -> tuple[Array, Array]:
        """x and y in one frame."""
        k = min(frame, len(self.x) - 1)
        return self.x[k], self.y[k]

    @property
    def moves(self) -> bool:
        return len(self.x) > 1


@FIGURES.of("PeriodOfMotion")
@dataclass(frozen=True, eq=False, repr=False)
class Animation(MovingPicture):
    """One period in pictures. A notebook shows it with play, pause, speed, a slider and steps of one frame; `.to_html()` is the
    same as a page, `.to_plotly()` the figure, `.save("x.gif")` a film, `.plot(frame)` one picture."""

    motion: PeriodOfMotion

    def __repr__(self) -> str:
        return f"Animation of {self.motion.title}: {self.frames} frames; {self.note}"

    @cached_property
    def frames(self) -> int:
        """How many pictures there are."""
        return len(frames_of(len(self.motion.loops[0].displacement)))

    @property
    def title(self) -> str:
        return self.motion.title

    @cached_property
    def magnification(self) -> float:
        """How many times displacements of the section are drawn larger than they are, a round number."""
        motion = self.motion
        moved = [body.motion[:, :2] for body in motion.bodies] + [face.motion for face in motion.faces]
        moved += [point.motion for point in motion.points]
        largest = max((float(np.linalg.norm(each, axis=-1).max()) for each in moved), default=0.0)
        return magnification(DRAWN_MOTION * self._extent, largest)

    @cached_property
    def _extent(self) -> float:
        corners = [body.corners for body in self.motion.bodies] + [face.ends for face in self.motion.faces]
        return float(np.ptp(np.concatenate(corners), axis=0).max()) if corners else 0.0

    @property
    def note(self) -> str:
        """What is magnified, and by how much."""
        notes = []
        if self.motion.bodies:
            notes.append(f"Displacements about their means, magnified {self.magnification:g} times")
        if self.motion.wheel is not None:
            largest = _length(self.motion.wheel.amplitude.max(), self.motion.system)
            notes.append(f"blades: the largest of {largest} drawn as {0.25 * BLADE:.2g} of the radius")
        return "; ".join((*notes, *filter(None, (self.motion.note,))))

    @cached_property
    def parts(self) -> tuple[Polyline, ...]:
        """Everything that is drawn."""
        drawn: list[Polyline] = []
        if self.motion.bodies:
            drawn += self._section()
        if self.motion.wheel is not None:
            drawn += _wheel(self.motion.wheel, self.motion.system)
        return (*drawn, *self._loops())

    @cached_property
    def panels(self) -> tuple[str, ...]:
        """The panels that hold something."""
        return tuple(name for name in ("section", "wheel", "loops") if any(part.panel == name for part in self.parts))

    def _section(self) -> list[Polyline]:
        """Platforms, dampers, forces and contacts in the plane of the section, displacements magnified."""
        motion, m = self.motion, self.magnification
        drawn = []
        for face in motion.faces:
            # A platform is a band behind its face.
            front = face.ends + m * face.motion
            corners = np.concatenate([front, (front + HATCH * self._extent * face.into)[:, ::-1]], axis=1)
            drawn.append(Polyline("section", 1e3 * _closed(corners[..., 0]), 1e3 * _closed(corners[..., 1]), "pale", filled=True))
        for body in motion.bodies:
            angle = m * body.motion[:, 2:]
            arm = body.corners - body.centre
            # Rotations are drawn as rotations: the arms of small ones, magnified, would stretch the section.
            x = body.centre[0] + m * body.motion[:, :1] + np.cos(angle) * arm[:, 0] - np.sin(angle) * arm[:, 1]
            y = body.centre[1] + m * body.motion[:, 1:2] + np.sin(angle) * arm[:, 0] + np.cos(angle) * arm[:, 1]
            drawn.append(Polyline("section", 1e3 * _closed(x), 1e3 * _closed(y), "grey", filled=True))
        if motion.points:
            # One trace holds all arrows: a trace for each would cost more than everything else with hundreds of contacts.
            force = np.stack([point.force for point in motion.points], axis=1)
            foot = np.stack([point.place + m * point.motion for point in motion.points], axis=1)
            largest = float(np.linalg.norm(force, axis=2).max())
            tip = foot + DRAWN_FORCE * self._extent / (largest or 1.0) * force
            x, y = _arrows(foot, tip, 0.035 * self._extent)
            newtons, unit = self._force_unit
            drawn.append(Polyline("section", 1e3 * x, 1e3 * y, "ink", f"force, largest {largest / newtons:.3g} {unit}"))
        for state, label in enumerate(STATES):
            places = [np.where((p.state == state)[:, None], p.place + m * p.motion, np.nan) for p in motion.points]
            if places and (state != 2 or any(np.any(p.state == state) for p in motion.points)):
                x, y = np.stack(places, axis=1).transpose(2, 0, 1)
                drawn.append(Polyline("section", 1e3 * x, 1e3 * y, COLOURS[state], label, marker=11.0))
        return drawn

    def _loops(self) -> list[Polyline]:
        """The largest loops, each with its dot."""
        shown = largest_loops(self.motion, MOST_LOOPS)
        unit = self._length_unit
        frames = frames_of(len(self.motion.loops[0].displacement))
        lines = []
        for k, number in enumerate(shown):
            loop = self.motion.loops[number]
            u, force = loop.displacement / unit[0], loop.force / self._force_unit[0]
            shade = f"contact {k}"
            lines.append(Polyline("loops", _closed(u[None]), _closed(force[None]), shade, loop.label))
            lines.append(Polyline("loops", u[frames, None], force[frames, None], shade, marker=10.0))
        return lines

    @cached_property
    def _length_unit(self) -> tuple[float, str]:
        shown = largest_loops(self.motion, MOST_LOOPS)
        unit = unit_in(self.motion.system, "m", max(float(np.abs(self.motion.loops[k].displacement).max()) for k in shown))
        return unit.metres, unit.name

    @property
    def _force_unit(self) -> tuple[float, str]:
        factor, name = in_system("N", self.motion.system)
        return 1.0 / factor, name

    @cached_property
    def strips(self) -> tuple[list[str], Array]:
        """Names and states over the period of the contacts, (rows, frames)."""
        shown = largest_loops(self.motion, MOST_STRIPS)
        frames = frames_of(len(self.motion.loops[0].displacement))
        return [self.motion.loops[k].label for k in shown], np.stack([self.motion.loops[k].state[frames] for k in shown])

    def description(self) -> dict[str, Any]:
        """Traces, layouts and frames of plotly with colours by name, as `interactive.description` gives them of a chart."""
        traces = [_trace(part, part.at(0), self._axis(part.panel)) for part in self.parts]
        _, states = self.strips
        strips = [_cells(states, state) for state in range(len(STATES)) if np.any(states == state)]
        traces += [_trace(part, part.at(0), self._axis("states")) for part in strips]
        traces.append(self._cursor(0))
        moving = [k for k, part in enumerate(self.parts) if part.moves]
        frames = []
        for frame in range(self.frames):
            data = [dict(zip(("x", "y"), self.parts[k].at(frame), strict=True)) for k in moving]
            data.append({key: self._cursor(frame)[key] for key in ("x", "y")})
            frames.append({"name": str(frame), "data": data, "traces": [*moving, len(traces) - 1]})
        described = {"title": self.title, "note": self.note, "data": traces, "frames": frames}
        return described | {name: self._layout(name == "narrow") for name in ("wide", "narrow")}

    def _axis(self, panel: str) -> dict[str, str]:
        number = (*self.panels, "states").index(panel) + 1
        suffix = str(number) if number > 1 else ""
        return {"xaxis": f"x{suffix}", "yaxis": f"y{suffix}"}

    def _cursor(self, frame: int) -> dict[str, Any]:
        at, rows = frame / self.frames, len(self.strips[0])
        line = {
            "type": "scatter",
            "mode": "lines",
            "line": {"color": "@ink", "width": 2},
            "hoverinfo": "skip",
            "showlegend": False,
        }
        return {"x": np.array([at, at]), "y": np.array([-0.5, rows - 0.5]), **line, **self._axis("states")}

    def _layout(self, narrow: bool) -> dict[str, Any]:
        layout: dict[str, Any] = BASE | {"height": PHONE_HEIGHT if narrow else HEIGHT, "font": {"color": "@text"}}
        layout["margin"] = {"l": 60, "r": 20, "t": 16, "b": 280 if narrow else 120}
        if narrow:
            layout["legend"] = {"orientation": "h", "y": -0.27, "yanchor": "top", "x": 0.0}
        for name in (*self.panels, "states"):
            axes = dict(zip(("x", "y"), self._domain(name, narrow), strict=True))
            own = self._axis(name)
            for key, axis in (("x", own["xaxis"]), ("y", own["yaxis"])):
                layout[f"{key}axis{axis[1:]}"] = {"domain": axes[key], **self._look(name, key, own)}
        below = {"x": 0.0, "len": 1.0, "y": -0.13} if narrow else {"x": 0.52, "len": 0.48, "y": -0.2}
        return layout | played(self.frames, {"x": 0.0, "y": -0.08 if narrow else -0.22}, below)

    def _domain(self, name: str, narrow: bool) -> tuple[list[float], list[float]]:
        """Where a panel stands: beside each other, the states below; all below each other on a phone."""
        count = len(self.panels)
        if narrow:
            low = 0.16 if name != "states" else 0.0
            k = count - 1 - self.panels.index(name) if name != "states" else 0
            height = 0.84 / count
            return [0.0, 1.0], [0.0, 0.1] if name == "states" else [low + k * height + 0.08, low + (k + 1) * height]
        if name == "states":
            return [0.0, 1.0], [0.0, 0.14]
        k = self.panels.index(name)
        return [k / count + (0.09 if k else 0.0), (k + 1) / count - 0.02], [0.3, 1.0]

    def _look(self, name: str, key: str, own: dict[str, str]) -> dict[str, Any]:
        """An axis: its words, its range where motion would change it, its scale."""
        plainly = {
            "gridcolor": "@grid",
            "zeroline": False,
            "linecolor": "@grid",
            "anchor": own[f"{'y' if key == 'x' else 'x'}axis"],
        }
        if name == "states":
            labels, _ = self.strips
            if key == "x":
                return plainly | {"title": {"text": "share of the period"}, "range": [0.0, 1.0]}
            shown = {"tickvals": list(range(len(labels))), "ticktext": [escaped(label) for label in labels]}
            return (
                plainly
                | {"range": [len(labels) - 0.5, -0.5], "automargin": True}
                | (shown if len(labels) <= 6 else {"showticklabels": False})
            )
        title = {
            "section": {"x": "x in mm", "y": "y in mm"},
            "loops": {"x": f"relative displacement in {self._length_unit[1]}", "y": f"contact force in {self._force_unit[1]}"},
            "wheel": {"x": "", "y": ""},
        }[name][key]
        look = plainly | {"title": {"text": title}, "range": self._range(name, key)}
        if name in ("section", "wheel") and key == "y":
            look |= {"scaleanchor": own["xaxis"], "scaleratio": 1.0}
        return look | ({"showticklabels": False} if name == "wheel" else {})

    def _range(self, name: str, key: str) -> list[float]:
        """Limits that hold every frame."""
        values = np.concatenate([getattr(part, key).ravel() for part in self.parts if part.panel == name])
        low, high = float(np.nanmin(values)), float(np.nanmax(values))
        rim = 0.05 * ((high - low) or 1.0)
        return [low - rim, high + rim]

    def _drawn(self) -> tuple[Figure, Callable[[int], Sequence[Any]]]:
        """A matplotlib figure, and what shows a frame in it."""
        from stickslip.show.plots.paper import NotebookFigure

        with house_style():
            figure = NotebookFigure(figsize=(4.2 * max(len(self.panels), 2), 5.4), layout="constrained")
            grid = figure.add_gridspec(2, len(self.panels), height_ratios=[5, 1])
            axes = {name: figure.add_subplot(grid[0, k]) for k, name in enumerate(self.panels)}
            drawn = [_artist(axes[part.panel], part) for part in self.parts]
            for name, each in axes.items():
                titles = [self._look(name, key, {"xaxis": "x", "yaxis": "y"})["title"]["text"] for key in "xy"]
                each.set(xlabel=titles[0], ylabel=titles[1], xlim=self._range(name, "x"), ylim=self._range(name, "y"))
                if name != "loops":
                    each.set_aspect("equal")
                handles, labels = each.get_legend_handles_labels()
                if labels:
                    each.legend(handles, labels, loc="lower left", bbox_to_anchor=(0.0, 1.0), ncols=2, fontsize=7)
            cursor = self._drawn_states(figure.add_subplot(grid[1, :]))
            figure.suptitle(plain(f"{self.title}\n{self.note}"), x=0.01, ha="left", fontsize=9.5)

        def show(frame: int) -> Sequence[Any]:
            for part, artist in zip(self.parts, drawn, strict=True):
                x, y = part.at(frame)
                if part.moves and part.filled:
                    artist.set_verts(polygons(x, y))
                elif part.moves:
                    artist.set_data(x, y)
            cursor.set_xdata([frame / self.frames] * 2)
            return [*drawn, cursor]

        show(0)
        return figure, show

    def _drawn_states(self, axes: Axes) -> Any:
        """The states below the panels; returns the line that goes along them."""
        from matplotlib.collections import PolyCollection

        names, states = self.strips
        for state in np.unique(states):
            cells = _cells(states, int(state))
            axes.add_collection(PolyCollection(polygons(*cells.at(0)), facecolor=colour(cells.colour)))
        axes.set(xlim=(0.0, 1.0), ylim=(len(names) - 0.5, -0.5))
        axes.set(xlabel="share of the period", yticks=range(len(names)) if len(names) <= 6 else [])
        if len(names) <= 6:
            axes.set_yticklabels([plain(name) for name in names], fontsize=7)
        axes.grid(visible=False)
        return axes.axvline(0.0, color=colour("ink"), linewidth=1.5)


def _length(value: float, system: UnitSystem | None) -> str:
    unit = unit_in(system, "m", abs(value))
    return f"{value / unit.metres:.3g} {unit.name}"


def _closed(values: Array) -> Array:
    return np.asarray(np.concatenate([values, values[:, :1]], axis=1))


def _arrows(foot: Array, tip: Array, head: float) -> tuple[Array, Array]:
    """Shafts and heads of arrows (frames, arrows, 2) as lines (frames, 6 for each arrow), with a gap after each."""
    along = tip - foot
    size = np.linalg.norm(along, axis=2, keepdims=True)
    unit = np.divide(along, size, out=np.zeros_like(along), where=size > 0.0)
    across = np.stack([-unit[..., 1], unit[..., 0]], axis=2)
    back = np.minimum(head, size)
    left, right = (tip - back * (unit + side * 0.5 * across) for side in (1.0, -1.0))
    points = np.stack([foot, tip, left, tip, right, np.full_like(tip, np.nan)], axis=2).reshape(len(foot), -1, 2)
    return points[..., 0], points[..., 1]


def _wheel(wheel: Wheel, system: UnitSystem | None) -> list[Polyline]:
    """The hub and the blades, in as many colours as there are steps of the amplitude; tips go round by their displacement."""
    count, largest = len(wheel.amplitude), float(wheel.amplitude.max()) or 1.0
    angle = 2.0 * np.pi * np.arange(count) / count
    ring = np.linspace(0.0, 2.0 * np.pi, 97)
    drawn = [Polyline("wheel", HUB * np.cos(ring)[None], HUB * np.sin(ring)[None], "pale", filled=True)]
    bend = 0.25 * BLADE * wheel.displacement / largest
    steps = np.minimum((BINS * wheel.amplitude / largest).astype(int), BINS - 1)
    width = 0.5 * np.pi / count
    for step in np.unique(steps):
        x, y = [], []
        for blade in np.flatnonzero(steps == step):
            for r, side in ((HUB, -1.0), (HUB, 1.0), (HUB + BLADE, 0.6), (HUB + BLADE, -0.6), (HUB, -1.0)):
                turned = angle[blade] + side * width * HUB / r + bend[:, blade] * (r - HUB) / BLADE / r
                x.append(r * np.cos(turned))
                y.append(r * np.sin(turned))
            x.append(np.full(len(bend), np.nan))
            y.append(np.full(len(bend), np.nan))
        label = (
            f"amplitude up to {_length((step + 1) / BINS * largest, system)}"
            if len(np.unique(steps)) > 1
            else f"amplitude {_length(largest, system)}"
        )
        drawn.append(Polyline("wheel", np.stack(x, axis=1), np.stack(y, axis=1), f"level {step}/{BINS}", label, filled=True))
    return drawn


def _trace(part: Polyline, at: tuple[Array, Array], axes: dict[str, str]) -> dict[str, Any]:
    look: dict[str, Any] = {"type": "scatter", "hoverinfo": "skip", "mode": "markers" if part.marker else "lines"}
    if part.marker:
        look["marker"] = {"size": part.marker, "color": f"@{part.colour}", "line": {"color": "@ink", "width": 1.2}}
    elif part.filled:
        look |= {"fill": "toself", "fillcolor": f"@{part.colour}", "line": {"color": "@text", "width": 0.8}, "opacity": 0.85}
    else:
        look["line"] = {"color": f"@{part.colour}", "width": part.width}
    return look | {"x": at[0], "y": at[1], "name": escaped(part.label), "showlegend": bool(part.label), **axes}


def _cells(states: Array, state: int) -> Polyline:
    """Where the rows (rows, frames) are in a state, as rectangles."""
    x, y, count = [], [], states.shape[1]
    for row, known in enumerate(states == state):
        edges = np.flatnonzero(np.diff(np.concatenate([[0], known.astype(int), [0]])))
        for first, last in edges.reshape(-1, 2) / count:
            x += [first, last, last, first, first, np.nan]
            y += [row - 0.45, row - 0.45, row + 0.45, row + 0.45, row - 0.45, np.nan]
    return Polyline("states", np.array([x]), np.array([y]), COLOURS[state], filled=True)


def _artist(axes: Axes, part: Polyline) -> Any:
    """What matplotlib draws of a part, in the first frame."""
    from matplotlib.collections import PolyCollection

    x, y = part.at(0)
    label = plain(part.label) or None
    if part.filled:
        shade, edge = colour(part.colour), colour("text")
        return axes.add_collection(PolyCollection(polygons(x, y), facecolor=shade, edgecolor=edge, linewidth=0.6, label=label))
    look: dict[str, Any] = {"color": colour(part.colour), "linewidth": part.width, "label": label}
    if part.marker:
        look |= {"linestyle": "", "marker": "o", "markersize": 0.6 * part.marker, "markeredgecolor": colour("ink")}
    (line,) = axes.plot(x, y, **look)
    return line
