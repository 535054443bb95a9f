"""Charts drawn with matplotlib, for paper: any `Chart`, in one style, not larger than a page.

Figures that notebooks show as pictures.

Figures as PNG and SVG files, reproducible and written atomically.
"""

import io
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any, assert_never

import numpy as np
from matplotlib import colormaps
from matplotlib.axes import Axes
from matplotlib.axis import Axis as MatplotlibAxis
from matplotlib.collections import PolyCollection
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Patch
from matplotlib.ticker import LogLocator, NullFormatter, StrMethodFormatter

from stickslip.show.plots.chart import (
    Area,
    Axis,
    Bars,
    Cells,
    Chart,
    Key,
    Layer,
    Line,
    Panel,
    Rule,
    Shades,
    labelled,
    polygons,
    wrapped,
)
from stickslip.show.plots.look import PAGE, WIDTH, Style, colour, headed, house_style, plain
from stickslip.support.files import replacing
from stickslip.support.late import xr


class NotebookFigure(Figure):
    """A matplotlib figure that a notebook shows without pyplot; with pyplot's inline backend it is shown once all the same."""

    def _repr_png_(self) -> bytes:
        buffer = io.BytesIO()
        with house_style():
            self.savefig(buffer, format="png")
        return buffer.getvalue()


DASHES: dict[str, Any] = {"solid": "-", "dash": (0, (5, 2)), "dot": (0, (1.2, 1.6)), "dashdot": "-.", "none": ""}
MARKERS = {"": "", "circle": "o", "ring": "o", "cross": "x", "diamond": "D", "square": "s", "star": "*"}
OPEN_MARKERS = ("ring", "diamond", "square")
"""Markers without filling, so that what is behind them shows."""
CHARACTERS_AN_INCH = 15
"""Of a label, which is broken where its panel is lower."""
LONGEST_NAMES = 12
"""Names at an axis in full size; more are set smaller."""


def drawn(chart: Chart) -> Figure:
    """The figure of a chart."""
    with house_style():
        heights = [max(panel.height for panel in row) for row in chart.rows]
        size = min(max(WIDTH, 3.3 * chart.columns + 2.0), PAGE), min(0.7 + sum(heights), PAGE)
        figure = NotebookFigure(figsize=size, layout="constrained")
        grid = figure.add_gridspec(len(chart.rows), chart.columns, height_ratios=heights)
        upper: list[Axes] = []
        for place, panel in enumerate(chart.panels):
            row, column = divmod(place, chart.columns)
            above = upper[place - chart.columns] if chart.shared_x and row else None
            axes = figure.add_subplot(grid[row, column], sharex=above)
            upper.append(axes)
            _panel(axes, panel, (figure.get_figwidth() - 1.5) / chart.columns)
            joined = chart.shared_x and place + chart.columns < len(chart.panels)
            axes.tick_params(labelbottom=not joined)
            named_x, named_y = labelled(chart.panels, chart.columns, place)
            axes.xaxis.label.set_visible(named_x and not joined)
            axes.yaxis.label.set_visible(named_y)
        if handles := [_handle(layer, label) for label, layer in chart.entries.items()]:
            title = chart.legend_title or None
            figure.legend(handles=handles, loc="outside right upper", title=title, title_fontsize=8.5)
        headed(figure, chart.title, chart.note)
    return figure


def _panel(axes: Axes, panel: Panel, width: float) -> None:
    """A panel so many inches wide."""
    if not panel.layers:
        axes.set_axis_off()
    for layer in panel.layers:
        _layer(axes, layer)
    if panel.title:
        axes.set_title(plain(panel.title), fontsize=9)
    x, y = (
        plain("\n".join(wrapped(axis.label, int(CHARACTERS_AN_INCH * inches))))
        for axis, inches in ((panel.x, width - 0.5), (panel.y, panel.height))
    )
    axes.set(xlabel=x, ylabel=y)
    _axis(axes, panel.x, True)
    _axis(axes, panel.y, False)
    if any(isinstance(layer, Cells) for layer in panel.layers):
        axes.grid(visible=False)
    if panel.equal:
        axes.set_aspect("equal")


def _axis(axes: Axes, stated: Axis, across: bool) -> None:
    """Scale, limits and names of the x axis, which goes across, or of the y axis."""
    axis: MatplotlibAxis = axes.xaxis if across else axes.yaxis
    limits = axes.set_xlim if across else axes.set_ylim
    # A logarithmic axis needs a positive value; without one its least positive value is infinite.
    log = stated.log and bool(np.isfinite(axis.get_minpos()))
    if log:
        (axes.set_xscale if across else axes.set_yscale)("log")
    low, high = (end if end is not None and np.isfinite(end) else None for end in stated.limits)
    if (low is not None or high is not None) and (low != high):
        limits(low, high)
    if log:
        low, high = axis.get_view_interval()
        # Plain numbers at 1, 2 and 5 have room over not more than three decades.
        if high <= 1e3 * low:
            axis.set_major_locator(LogLocator(subs=(1.0, 2.0, 5.0)) if high > 4.0 * low else LogLocator(subs=range(1, 10)))
            axis.set_major_formatter(StrMethodFormatter("{x:g}"))
            axis.set_minor_formatter(NullFormatter())
    if stated.names:
        size = 8 if len(stated.names) <= LONGEST_NAMES else 5
        turned = across and sum(map(len, stated.names.values())) > 60
        axis.set_ticks(list(stated.names), [plain(name) for name in stated.names.values()], fontsize=size)
        axis.set_tick_params(rotation=60 if turned else 0)
    if stated.upside_down:
        axis.set_inverted(True)


def _layer(axes: Axes, layer: Layer) -> None:
    """A layer in its axes; a key draws nothing, and stands in the legend alone."""
    match layer:
        case Line():
            axes.plot(np.asarray(layer.x, dtype=float), np.asarray(layer.y, dtype=float), **_line(layer.style, layer.label))
        case Area():
            axes.add_collection(PolyCollection(polygons(layer.x, layer.y), label=plain(layer.label), **_filled(layer.style)))
            axes.autoscale_view()
        case Bars():
            sizes, look = np.nan_to_num(np.asarray(layer.size, dtype=float)), _filled(layer.style) | {"label": plain(layer.label)}
            if layer.horizontal:
                axes.barh(layer.at, sizes, height=layer.width, left=layer.base, **look)
            else:
                axes.bar(layer.at, sizes, width=layer.width, bottom=layer.base, **look)
        case Cells():
            edges, rows = np.asarray(layer.edges, dtype=float), len(layer.colours)
            shown = np.isfinite(layer.colours).all(axis=-1, keepdims=True)
            colours = np.concatenate([np.clip(np.nan_to_num(layer.colours), 0.0, 1.0), shown], axis=-1)
            if rows and edges.size > 1:
                axes.pcolormesh(edges, layer.first + np.arange(rows + 1) - 0.5, colours, rasterized=True)
        case Shades():
            points = axes.scatter(
                np.asarray(layer.x), np.asarray(layer.y), c=layer.value, s=34, edgecolor="white", linewidth=0.4,
                vmin=float(np.min(layer.value)), vmax=layer.high, cmap=colormaps["viridis"], label=plain(layer.label),
            )  # fmt: skip
            axes.figure.colorbar(points, ax=axes, label=layer.scale.label, extend="max")
        case Rule():
            (axes.axvline if layer.along == "x" else axes.axhline)(layer.at, **_line(layer.style, layer.label))
        case Key():
            pass
        case _:
            assert_never(layer)


def _line(style: Style, label: str) -> dict[str, Any]:
    """How matplotlib is to draw a line."""
    value = colour(style.colour)
    look = {
        "color": value,
        "linestyle": DASHES[style.dash],
        "linewidth": style.width,
        "alpha": style.opacity,
        "label": plain(label),
    }
    look |= {"marker": MARKERS[style.marker], "markersize": style.size}
    return look | ({"markerfacecolor": "none"} if style.marker in OPEN_MARKERS else {})


def _filled(style: Style) -> dict[str, Any]:
    return {"facecolor": colour(style.colour), "alpha": style.opacity, "linewidth": 0.0}


def _handle(layer: Layer, label: str) -> Line2D | Patch:
    """The entry of a layer in the legend."""
    if isinstance(layer, Line | Rule):
        return Line2D([], [], **_line(layer.style, label))
    if isinstance(layer, Shades):
        return Line2D([], [], marker="o", linestyle="", color=colormaps["viridis"](0.3), label=plain(label))
    if isinstance(layer, Cells):
        raise TypeError("Cells have no label; a Key names their colours.")
    return Patch(
        facecolor=colour(layer.style.colour),
        alpha=layer.style.opacity,
        edgecolor=colour("grey"),
        linewidth=0.5,
        label=plain(label),
    )


Figures = Mapping[str, Callable[[Any], "Chart | Figure"]]
"""Name of the file: function from a dataset to its chart, or to a drawing where it has no curves."""


def write_figures(
    figures: Figures, dataset: "xr.Dataset", directory: str | Path, formats: tuple[str, ...] = ("png", "svg")
) -> list[Path]:
    """Every figure of a dataset in every format; returns the paths."""
    paths = []
    for name, draw in figures.items():
        drawn = draw(dataset)
        figure = drawn.plot() if isinstance(drawn, Chart) else drawn
        for suffix in formats:
            path = Path(directory) / f"{name}.{suffix}"
            write_figure(figure, path, suffix)
            paths.append(path)
    return paths


def write_figure(figure: Figure, path: Path, suffix: str) -> None:
    """Save without the date, so that equal figures are equal files."""
    dated: dict[str, Any] = {"svg": {"Date": None}, "pdf": {"CreationDate": None}}
    with house_style(), replacing(path) as temporary:
        figure.savefig(temporary, format=suffix, metadata=dated.get(suffix))
