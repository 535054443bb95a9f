"""Charts in the units that the study of a result states: axes, what is drawn along them, and hover texts, by their units."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike

from stickslip.results.shown_units import in_system, system_of
from stickslip.show.plots.chart import Area, Axis, Bars, Cells, Chart, Layer, Line, Rule, Shades
from stickslip.support.renderers import FIGURES
from stickslip.support.units import UnitSystem

if TYPE_CHECKING:
    from matplotlib.figure import Figure


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
