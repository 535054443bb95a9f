"""The description of a figure of curves: a chart is panels, a panel two axes and layers. No drawing package is needed for it.

A figure is written once, as a function from a dataset to a `Chart`; `paper.py` draws it with matplotlib and `interactive.py` with
plotly, for the report and for notebooks. Colours and dashes are those of `look.py`, named by what a layer shows.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from textwrap import wrap
from typing import Any, Literal

import numpy as np
from numpy.typing import ArrayLike

from stickslip.results.schema import in_system, system_of
from stickslip.show.plots.look import Style
from stickslip.support.checks import Array
from stickslip.support.late import Figure
from stickslip.support.renderers import FIGURES
from stickslip.support.units import UnitSystem


@dataclass(frozen=True)
class Axis:
    """What an axis shows.

    quantity: in words, "frequency"; unit: "Hz", or "" for a number; limits: of what is shown, None for an end that the data set.
    names: words at places in the stead of numbers, such as contacts; upside_down: the first place at the top.
    """

    quantity: str
    unit: str = ""
    log: bool = False
    limits: tuple[float | None, float | None] = (None, None)
    names: Mapping[float, str] = field(default_factory=dict)
    upside_down: bool = False

    @property
    def label(self) -> str:
        """ "frequency in Hz"."""
        return f"{self.quantity} in {self.unit}" if self.unit else self.quantity


@dataclass(frozen=True, eq=False)
class Line:
    """A curve, or points: x and y of the same length, broken where they are not numbers.

    hover: what else is known of each point, by name with unit ("phase in °"). listed: False leaves the label out of the legend.
    """

    x: ArrayLike
    y: ArrayLike
    style: Style
    label: str = ""
    hover: Mapping[str, ArrayLike] = field(default_factory=dict)
    listed: bool = True


@dataclass(frozen=True, eq=False)
class Area:
    """Filled polygons, separated by NaN."""

    x: ArrayLike
    y: ArrayLike
    style: Style
    label: str = ""
    listed: bool = True


@dataclass(frozen=True, eq=False)
class Bars:
    """Bars from `base` over `size` at places of the other axis, as wide as `width` of that axis's units."""

    at: ArrayLike
    size: ArrayLike
    style: Style
    label: str = ""
    base: ArrayLike = 0.0
    width: float = 0.8
    horizontal: bool = False
    hover: Mapping[str, ArrayLike] = field(default_factory=dict)
    listed: bool = True


@dataclass(frozen=True, eq=False)
class Cells:
    """Rows of coloured cells: edges along x, (n + 1,); colours, (row, n, 3) from 0 to 1, NaN for none; a text for each cell.

    first: place of the first row along y.
    """

    edges: ArrayLike
    colours: Array
    words: Sequence[Sequence[str]]
    first: float = 0.0


@dataclass(frozen=True, eq=False)
class Shades:
    """Points coloured by a value: dark for small, light for all from `high` on."""

    x: ArrayLike
    y: ArrayLike
    value: Array
    scale: Axis
    high: float
    label: str = ""
    hover: Mapping[str, ArrayLike] = field(default_factory=dict)
    listed: bool = True


@dataclass(frozen=True)
class Rule:
    """A straight line across the panel at one value of x or y."""

    at: float
    style: Style
    label: str = ""
    along: Literal["x", "y"] = "x"
    listed: bool = True


@dataclass(frozen=True)
class Key:
    """An entry of the legend for what colours of cells mean."""

    label: str
    style: Style
    listed: bool = True


Layer = Line | Area | Bars | Cells | Shades | Rule | Key


@dataclass(frozen=True, eq=False)
class Panel:
    """Axes with their layers, the first at the back; height in inches; equal: the same scale along x and y."""

    x: Axis
    y: Axis
    layers: Sequence[Layer]
    title: str = ""
    height: float = 2.4
    equal: bool = False


@dataclass(frozen=True, eq=False)
class Chart:
    """Panels in rows of `columns`.

    note: a line on what is left out. shared_x: panels below each other have one x axis.
    legend: False where titles name the curves.
    """

    title: str
    panels: Sequence[Panel]
    columns: int = 1
    note: str = ""
    shared_x: bool = False
    legend: bool = True

    @property
    def rows(self) -> list[Sequence[Panel]]:
        """The panels, row by row."""
        return [self.panels[k : k + self.columns] for k in range(0, len(self.panels), self.columns)]

    @property
    def entries(self) -> dict[str, Layer]:
        """Layer of each label that the legend shows, in order."""
        found: dict[str, Layer] = {}
        for panel in self.panels:
            for layer in panel.layers:
                if self.legend and not isinstance(layer, Cells) and layer.label and layer.listed:
                    found.setdefault(layer.label, layer)
        return found

    @property
    def legend_title(self) -> str:
        """How many of the labels the legend shows, where it leaves some out."""
        labels = {layer.label for panel in self.panels for layer in panel.layers if not isinstance(layer, Cells)} - {""}
        return f"{len(self.entries)} of {len(labels)}" if self.entries and len(self.entries) < len(labels) else ""

    def plot(self) -> Figure:
        """As a matplotlib figure."""
        from stickslip.show.plots.paper import drawn

        return drawn(self)

    def to_plotly(self, dark: bool = False) -> Any:
        """As a plotly figure."""
        from stickslip.show.plots.interactive import plotly_figure

        return plotly_figure(self, dark)


def labelled(panels: Sequence[Panel], columns: int, place: int) -> tuple[bool, bool]:
    """Whether a panel of a grid writes the labels of its axes, x and y: those below and to its left may say the same."""
    panel = panels[place]
    below = panels[place + columns] if columns > 1 and place + columns < len(panels) else None
    left = panels[place - 1] if place % columns else None
    repeated_x = below is not None and bool(below.layers) and below.x.label == panel.x.label
    repeated_y = left is not None and bool(left.layers) and left.y.label == panel.y.label
    return not repeated_x, not repeated_y


def band(x: ArrayLike, low: ArrayLike, high: ArrayLike, style: Style, label: str = "") -> Area:
    """The area between two curves, in as many pieces as there are gaps."""
    x, low, high = (np.asarray(values, dtype=float) for values in (x, low, high))
    known = np.isfinite(x) & np.isfinite(low) & np.isfinite(high)
    pieces = np.split(np.arange(x.size), np.flatnonzero(np.diff(known.astype(int))) + 1) if x.size else []
    parts = [piece for piece in pieces if known[piece[0]]]
    across = [values for piece in parts for values in (x[piece], x[piece][::-1], [np.nan])]
    up = [values for piece in parts for values in (low[piece], high[piece][::-1], [np.nan])]
    return Area(np.concatenate([[], *across]), np.concatenate([[], *up]), style, label)


def polygons(x: ArrayLike, y: ArrayLike) -> list[Array]:
    """Corners (k, 2) of each polygon of a filled layer, which gaps separate."""
    corners = np.column_stack([np.asarray(x, dtype=float), np.asarray(y, dtype=float)])
    pieces = np.split(corners, np.flatnonzero(np.isnan(corners[:, 0])))
    return [known for piece in pieces if (known := piece[np.isfinite(piece).all(axis=1)]).size]


def closed(values: ArrayLike) -> Array:
    """A period with its first value at the end."""
    values = np.asarray(values, dtype=float)
    return np.append(values, values[:1])


def edges_between(centres: Array, log: bool = False) -> Array:
    """Cell edges halfway between points, (n + 1,); of a logarithmic axis in the geometric middle."""
    if log:
        return np.asarray(np.exp(edges_between(np.log(centres))))
    if centres.size < 2:
        return np.array([centres[0] - 0.5, centres[0] + 0.5]) if centres.size else np.zeros(1)
    middle = 0.5 * (centres[1:] + centres[:-1])
    return np.concatenate([[1.5 * centres[0] - 0.5 * centres[1]], middle, [1.5 * centres[-1] - 0.5 * centres[-2]]])


def wrapped(words: str, most: int) -> list[str]:
    """A text in lines of at most so many characters."""
    return wrap(words, max(most, 8), break_long_words=False) or [""]


def from_zero(axis: Axis) -> Axis:
    """An axis that begins at zero."""
    return replace(axis, limits=(0.0, axis.limits[1]))


def spans(values: ArrayLike, factor: float) -> bool:
    """Whether positive values span more than a factor, so that a logarithmic axis shows them better."""
    values = np.asarray(values, dtype=float)
    return bool(values.size > 1 and values.min() > 0.0 and values.max() > factor * values.min())


def shown_chart(chart: Chart, system: UnitSystem | None) -> Chart:
    """The chart with every length, force, mass, stress and energy in the units of a system; as it is without one."""
    if system is None:
        return chart
    panels = []
    for panel in chart.panels:
        across, x = _axis(panel.x, system)
        up, y = _axis(panel.y, system)
        panels.append(replace(panel, x=x, y=y, layers=[_layer(layer, across, up, system) for layer in panel.layers]))
    return replace(chart, panels=panels)


@FIGURES.of("Result", "in the units of the study")
def shown_of(drawn: Chart | Figure, result: Any) -> Chart | Figure:
    """What was drawn of a result in the units of its study; a drawing without curves as it is."""
    if not isinstance(drawn, Chart) or not hasattr(result, "dataset"):
        return drawn
    return shown_chart(drawn, system_of(result.dataset))


def _axis(axis: Axis, system: UnitSystem) -> tuple[float, Axis]:
    """The factor of what is drawn along an axis, and the axis."""
    factor, unit = in_system(axis.unit, system)
    low, high = (None if end is None else factor * end for end in axis.limits)
    return factor, replace(axis, unit=unit, limits=(low, high), names={factor * at: name for at, name in axis.names.items()})


def _layer(layer: Layer, x: float, y: float, system: UnitSystem) -> Layer:
    """A layer with what is drawn along x and y times a factor each, and its texts in the units of the system."""
    if isinstance(layer, Line):
        return replace(layer, x=_times(layer.x, x), y=_times(layer.y, y), hover=_hover(layer.hover, system))
    if isinstance(layer, Area):
        return replace(layer, x=_times(layer.x, x), y=_times(layer.y, y))
    if isinstance(layer, Bars):
        at, along = (y, x) if layer.horizontal else (x, y)
        size, base, hover = _times(layer.size, along), _times(layer.base, along), _hover(layer.hover, system)
        return replace(layer, at=_times(layer.at, at), size=size, base=base, width=at * layer.width, hover=hover)
    if isinstance(layer, Cells):
        return replace(layer, edges=_times(layer.edges, x))
    if isinstance(layer, Shades):
        factor, scale = _axis(layer.scale, system)
        shaded = replace(layer, value=factor * layer.value, scale=scale, high=factor * layer.high)
        return replace(shaded, x=_times(layer.x, x), y=_times(layer.y, y), hover=_hover(layer.hover, system))
    if isinstance(layer, Rule):
        return replace(layer, at=layer.at * (x if layer.along == "x" else y))
    return layer


def _hover(hover: Mapping[str, ArrayLike], system: UnitSystem) -> dict[str, ArrayLike]:
    """What else is known of each point, by names such as "energy in J"; texts stay."""
    shown: dict[str, ArrayLike] = {}
    for name, values in hover.items():
        quantity, within, unit = name.rpartition(" in ")
        factor, shown_unit = in_system(unit, system) if within else (1.0, unit)
        shown[f"{quantity}{within}{shown_unit}"] = values if factor == 1.0 else _times(values, factor)
    return shown


def _times(values: ArrayLike, factor: float) -> ArrayLike:
    return values if factor == 1.0 else np.asarray(factor * np.asarray(values, dtype=float), dtype=float)
