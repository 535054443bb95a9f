"""Charts as plotly figures, for the report and for notebooks: any `Chart`, in a wide and in a narrow layout.

Colours stand in it by name ("@level 2/6"), so that one description serves light and dark pages; `resolved` gives their values.
"""

import html
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any, assert_never

import numpy as np
from numpy.typing import ArrayLike, NDArray

from stickslip.show.plots.chart import Area, Axis, Bars, Cells, Chart, Key, Line, Panel, Rule, Shades, labelled, wrapped
from stickslip.show.plots.look import Style, colour

INCH = 96
"""Pixels of an inch of a panel."""
ABOVE, BELOW, NARROW_BELOW, BUTTONS = 34, 58, 62, 22
"""Pixels above a panel, for its title, and below it, for the labels of its axis; above all, for the buttons of plotly.js."""
CHARACTER = 7.2
"""Pixels of a character of a label, which is broken where its panel is smaller."""
PHONE = 340
"""Pixels of the width of a chart on a phone."""
WIDE = 900
"""Pixels of the width of a chart beside its legend on a large screen."""
LONGEST_NAME = 24
"""Characters of a name at an axis in one line."""
MOST_BELOW_EACH_OTHER, SCROLLED = 9, 200
"""Panels that a narrow screen shows in one column. Of more, the chart keeps its columns; where these do not fit, with so many
pixels each, it is scrolled."""
SMALL = 150
"""Pixels of a side of a panel below which its axis has few numbers."""
SYMBOLS = {
    "circle": "circle",
    "ring": "circle-open",
    "cross": "x",
    "diamond": "diamond-open",
    "square": "square-open",
    "star": "star",
}
BASE = {
    "paper_bgcolor": "rgba(0,0,0,0)",
    "plot_bgcolor": "rgba(0,0,0,0)",
    "hovermode": "closest",
    "barmode": "overlay",
    "hoverlabel": {"namelength": 40},
    "modebar": {"bgcolor": "rgba(0,0,0,0)", "color": "@grey", "activecolor": "@text"},
}
"""What all charts have in common."""


def plotly_figure(chart: Chart, dark: bool = False) -> Any:
    """A figure of plotly that stands alone: `.show()` or `.write_html(path)`."""
    from plotly.graph_objects import Figure

    described = description(chart)
    titled = {"title": {"text": "<br>".join(filter(None, (f"<b>{escaped(chart.title)}</b>", escaped(chart.note)))), "x": 0.01}}
    background = {"paper_bgcolor": "@paper", "plot_bgcolor": "@paper"}
    layout = described["wide"] | titled | background
    layout = layout | {"margin": layout["margin"] | {"t": layout["margin"]["t"] + 46}, "height": layout["height"] + 46}
    return Figure(resolved({"data": described["data"], "layout": layout}, dark))


def description(chart: Chart) -> dict[str, Any]:
    """Traces, and layouts for a wide and a narrow screen, with colours by name and numbers as arrays."""
    traces: list[dict[str, Any]] = []
    shapes: list[dict[str, Any]] = []
    unlisted = {label: id(layer) for label, layer in chart.entries.items()}
    for k, panel in enumerate(chart.panels):
        for layer in panel.layers:
            label = "" if isinstance(layer, Cells) else layer.label
            # One entry of the legend shows and hides all layers of its label.
            entry: dict[str, Any] = {"name": escaped(label), "showlegend": unlisted.get(label) == id(layer)}
            entry |= {"legendgroup": escaped(label)} if label else {}
            if entry["showlegend"]:
                del unlisted[label]
            if isinstance(layer, Rule):
                shapes.append(_rule(layer, k) | entry)
            else:
                traces.append(_trace(layer, panel) | _on(k) | entry)
    narrow_columns = 1 if len(chart.panels) <= MOST_BELOW_EACH_OTHER else chart.columns
    return {
        "title": chart.title,
        "note": chart.note,
        "data": traces,
        "wide": _layout(chart, chart.columns, narrow=False) | {"shapes": shapes},
        "narrow": _layout(chart, narrow_columns, narrow=True) | {"shapes": shapes},
    }


@dataclass(frozen=True, eq=False)
class Combination:
    """Σ weight × array: frames of a moving picture that are made of the same few arrays."""

    weights: tuple[float, ...]
    arrays: tuple[NDArray[np.floating[Any]], ...]

    @property
    def value(self) -> NDArray[np.floating[Any]]:
        """The sum, in the precision of the arrays."""
        return np.asarray(sum(weight * array for weight, array in zip(self.weights, self.arrays, strict=True)))


def resolved(part: Any, dark: bool) -> Any:
    """The same with the values of colours that stand by name, and of combinations."""
    if isinstance(part, Combination):
        return part.value
    if isinstance(part, str) and part.startswith("@"):
        return colour(part[1:], dark)
    if isinstance(part, Mapping):
        return {key: resolved(value, dark) for key, value in part.items()}
    if isinstance(part, list):
        return [resolved(value, dark) for value in part]
    return part


def escaped(text: str) -> str:
    """A text as it is: plotly.js reads a little HTML, MathJax formulas, and this module names of colours."""
    text = html.escape(text, quote=False).replace("$", "&#36;")
    return f"&#64;{text[1:]}" if text.startswith("@") else text


def _on(k: int) -> dict[str, str]:
    number = k + 1 if k else ""
    return {"xaxis": f"x{number}", "yaxis": f"y{number}"}


def _trace(layer: Line | Area | Bars | Cells | Shades | Key, panel: Panel) -> dict[str, Any]:
    """A layer as a trace, but for its axes and its entry in the legend."""
    look: dict[str, Any]
    marker: dict[str, Any]
    match layer:
        case Line():
            x, y = _floats(layer.x), _floats(layer.y)
            mode = "+".join(["lines"] * (layer.style.dash != "none") + ["markers"] * bool(layer.style.marker))
            look = {"type": "scatter", "mode": mode or "none", "line": _stroke(layer.style)}
            if layer.style.marker:
                symbol, shade = SYMBOLS[layer.style.marker], f"@{layer.style.colour}"
                look["marker"] = {"symbol": symbol, "size": 1.6 * layer.style.size, "color": shade}
            look |= {"opacity": layer.style.opacity} if layer.style.opacity < 1.0 else {}
            return {"x": x, "y": y, **look, **_hover(layer.hover, panel, x, y, layer.label)}
        case Area():
            look = {"type": "scatter", "mode": "lines", "fill": "toself", "fillcolor": f"@{layer.style.colour}"}
            look |= {"hoverinfo": "skip", "line": {"width": 0}, "opacity": layer.style.opacity}
            return {"x": _floats(layer.x), "y": _floats(layer.y), **look}
        case Bars():
            at, size, base = np.broadcast_arrays(_floats(layer.at), _floats(layer.size), _floats(layer.base))
            x, y = (size, at) if layer.horizontal else (at, size)
            look = {"type": "bar", "orientation": "h" if layer.horizontal else "v", "base": base, "width": layer.width}
            look |= {"marker": {"color": f"@{layer.style.colour}"}, "opacity": layer.style.opacity}
            return {"x": x, "y": y, **look, **_hover(layer.hover, panel, x, y, layer.label)}
        case Cells():
            return _cells(layer)
        case Shades():
            x, y = _floats(layer.x), _floats(layer.y)
            title = {"text": "<br>".join(map(escaped, wrapped(layer.scale.label, 24))), "side": "top"}
            bar = {"title": title, "orientation": "h", "y": 1.0, "yanchor": "bottom", "thickness": 12}
            marker = {"color": _floats(layer.value), "colorscale": "Viridis", "cmin": float(np.min(layer.value))}
            marker |= {"cmax": layer.high, "size": 9, "line": {"width": 0.5, "color": "@paper"}, "colorbar": bar}
            hover = _hover({layer.scale.label: layer.value, **layer.hover}, panel, x, y, layer.label)
            return {"type": "scatter", "mode": "markers", "x": x, "y": y, "marker": marker, **hover}
        case Key():
            marker = {"symbol": "square", "size": 12, "color": f"@{layer.style.colour}", "opacity": layer.style.opacity}
            marker |= {"line": {"width": 0.5, "color": "@grey"}}
            return {"type": "scatter", "mode": "markers", "x": [None], "y": [None], "marker": marker}
        case _:
            assert_never(layer)


def _floats(values: ArrayLike) -> np.ndarray[Any, Any]:
    return np.asarray(values, dtype=float)


def _stroke(style: Style) -> dict[str, Any]:
    dash = {"dash": style.dash} if style.dash not in ("solid", "none") else {}
    return {"color": f"@{style.colour}", "width": 1.25 * style.width, **dash}


def _hover(columns: Mapping[str, ArrayLike], panel: Panel, x: Any, y: Any, label: str) -> dict[str, Any]:
    """What hovering shows of a point: both axes and the columns, with their units."""
    lines: list[str] = []
    shown: list[Any] = []
    for letter, axis, values in (("x", panel.x, x), ("y", panel.y, y)):
        if axis.names:
            shown.append([escaped(axis.names.get(float(value), "")) for value in values])
            lines.append(f"%{{customdata[{len(shown) - 1}]}}")
        else:
            lines.append(_worded(axis.quantity, f"%{{{letter}:.{7 if axis.unit == 'Hz' else 5}~g}}", axis.unit))
    for name, column in columns.items():
        values = np.asarray(column)
        numeric = values.dtype.kind in "fiu"
        shown.append(_floats(values) if numeric else [escaped(str(value)) for value in values.tolist()])
        quantity, _, unit = name.rpartition(" in ") if " in " in name else (name, "", "")
        lines.append(_worded(quantity, f"%{{customdata[{len(shown) - 1}]{':.4~g' if numeric else ''}}}", unit))
    found: dict[str, Any] = {"hovertemplate": "<br>".join(lines) + f"<extra>{escaped(label)}</extra>"}
    return found | ({"customdata": shown} if shown else {})


def _worded(quantity: str, value: str, unit: str) -> str:
    return " ".join(filter(None, (escaped(quantity), value, escaped(unit))))


def _cells(layer: Cells) -> dict[str, Any]:
    """Cells as a heat map of the places of their colours among the different ones, since plotly colours only by a number."""
    values = np.clip(np.round(255.0 * layer.colours), 0.0, 255.0)
    codes = values @ np.array([65536.0, 256.0, 1.0]) if values.size else np.zeros(values.shape[:2])
    different = np.unique(codes[np.isfinite(codes)])
    places, known = np.searchsorted(different, np.nan_to_num(codes)), np.isfinite(codes)
    index = [[int(p) if k else None for p, k in zip(row, there, strict=True)] for row, there in zip(places, known, strict=True)]
    palette, last = [f"#{int(code):06x}" for code in different] or ["#000000"], max(different.size - 1, 1)
    scale: list[list[Any]] = [[i / last, shade] for i, shade in enumerate(palette)]
    scale = scale if len(scale) > 1 else [[0.0, palette[0]], [1.0, palette[0]]]
    look = {"type": "heatmap", "zmin": 0, "zmax": last, "colorscale": scale, "showscale": False, "hoverongaps": False}
    text = {"text": [[escaped(word) for word in row] for row in layer.words], "hovertemplate": "%{text}<extra></extra>"}
    return {"x": _floats(layer.edges), "y": layer.first + np.arange(len(index) + 1) - 0.5, "z": index, **look, **text}


def _rule(rule: Rule, k: int) -> dict[str, Any]:
    """A line across the whole of panel k, which no trace can be."""
    across, along = ("x", "y") if rule.along == "x" else ("y", "x")
    on = _on(k)
    ends = {f"{across}0": rule.at, f"{across}1": rule.at, f"{along}0": 0.0, f"{along}1": 1.0}
    refs = {f"{across}ref": on[f"{across}axis"], f"{along}ref": f"{on[f'{along}axis']} domain"}
    return {"type": "line", **ends, **refs, "line": _stroke(rule.style), "opacity": rule.style.opacity, "layer": "below"}


def _layout(chart: Chart, columns: int, narrow: bool) -> dict[str, Any]:
    """Everything but the traces: panels placed in pixels, since text has a size in pixels."""
    rows: list[Sequence[int]] = [range(k, min(k + columns, len(chart.panels))) for k in range(0, len(chart.panels), columns)]
    joined = chart.shared_x and columns == chart.columns
    heights = [round(INCH * max(chart.panels[k].height for k in row)) for row in rows]
    below = [26 if joined and i + 1 < len(rows) else NARROW_BELOW if narrow else BELOW for i in range(len(rows))]
    titles = [(ABOVE if any(chart.panels[k].title for k in row) else 12) + BUTTONS * (not i) for i, row in enumerate(rows)]
    entries = _legend_rows(chart) if narrow else 0
    inner = sum(heights) + sum(below[:-1]) + sum(titles[1:])
    layout: dict[str, Any] = BASE | {
        "height": inner + titles[0] + below[-1] + 22 * entries,
        "margin": {"l": 58 if narrow else 66, "r": 12, "t": titles[0], "b": below[-1] + 22 * entries},
        "font": {"color": "@text", "family": "system-ui, sans-serif", "size": 12 if narrow else 13},
        "showlegend": bool(chart.entries),
        "legend": _legend(chart, narrow),
        "annotations": [],
    }
    room = PHONE if narrow else WIDE
    total = max(room, SCROLLED * columns) if columns > 1 else room
    if total > room:
        layout["width"] = total
    spans = _columns(chart, rows, columns, total - 70)
    top = 0
    for i, row in enumerate(rows):
        top += titles[i] if i else 0
        ends = (1.0 - (top + heights[i]) / inner, 1.0 - top / inner)
        for (left, right), k in zip(spans, row, strict=False):
            panel, on, pixels = chart.panels[k], _on(k), (right - left) * (total - 70)
            names = CHARACTER * max((min(len(name), LONGEST_NAME) for name in panel.y.names.values()), default=0)
            x, y = _axis(panel.x, max(pixels - names, 0.5 * pixels), panel), _axis(panel.y, heights[i], panel)
            x |= {"domain": [left, right], "anchor": on["yaxis"]}
            last = not joined or k + columns >= len(chart.panels)
            named_x, named_y = labelled(chart.panels, columns, k)
            x |= {} if last else {"showticklabels": False}
            x |= {} if last and named_x else {"title": {"text": ""}}
            y |= {} if named_y else {"title": {"text": ""}}
            x |= {"matches": _on(k % chart.columns)["xaxis"]} if chart.shared_x and k >= chart.columns else {}
            y |= {"domain": list(ends), "anchor": on["xaxis"]} | ({"scaleanchor": on["xaxis"]} if panel.equal else {})
            if not panel.layers:
                x, y = x | {"visible": False}, y | {"visible": False}
            layout |= {on["xaxis"].replace("x", "xaxis"): x, on["yaxis"].replace("y", "yaxis"): y}
            if panel.title:
                layout["annotations"].append(_headline(panel.title, left, ends[1], pixels))
        top += heights[i] + below[i]
    return layout


def _columns(chart: Chart, rows: list[Sequence[int]], columns: int, pixels: float) -> list[tuple[float, float]]:
    """Where the columns begin and end, 0 to 1, with room for the numbers or names at the axes between them."""
    before = []
    for column in range(1, columns):
        axes = [chart.panels[row[column]].y for row in rows if column < len(row)]
        longest = max((min(len(name), LONGEST_NAME) for axis in axes for name in axis.names.values()), default=0)
        before.append(max(80.0, 30.0 + CHARACTER * longest) / pixels)
    width = (1.0 - sum(before)) / columns
    starts = np.cumsum([0.0, *(width + gap for gap in before)])
    return [(float(start), min(float(start) + width, 1.0)) for start in starts]


def _axis(axis: Axis, pixels: float, panel: Panel) -> dict[str, Any]:
    title = "<br>".join(escaped(line) for line in wrapped(axis.label, int(pixels / CHARACTER)))
    look: dict[str, Any] = {
        "title": {"text": title, "standoff": 8, "font": {"size": 13}},
        "automargin": True,
        "exponentformat": "none",
        "gridcolor": "@grid",
        "zerolinecolor": "@grid",
    }
    look |= {"linecolor": "@grey", "tickcolor": "@grey", "showline": True, "ticks": "outside"}
    if any(isinstance(layer, Cells) for layer in panel.layers):
        look |= {"showgrid": False, "zeroline": False}
    if pixels < SMALL:
        look |= {"nticks": 4}
    if axis.log:
        # Full numbers ("0.2", "0.5", "1") in place of plotly's single digits between powers, however far one zooms in. With more
        # ticks it writes all digits of a decade, one upon the other.
        look |= {"type": "log", "tickformat": "~g", "nticks": 3 if _decades(axis, panel) < 1.24 else 4}
    ends = [float(end) if end is not None and np.isfinite(end) else None for end in axis.limits]
    if ends == [0.0, None]:
        look |= {"rangemode": "tozero"}
    elif ends != [None, None] and ends[0] != ends[1]:
        look |= {"range": [end if end is None or not axis.log else float(np.log10(end)) for end in ends]}
        look |= {} if None not in ends else {"autorange": "max" if ends[1] is None else "min"}
    if axis.upside_down:
        look |= {"range": look["range"][::-1]} if "range" in look else {"autorange": "reversed"}
    if axis.names:
        size = 12 if len(axis.names) <= 12 else 9
        names = ["<br>".join(escaped(line) for line in wrapped(name, LONGEST_NAME)) for name in axis.names.values()]
        look |= {"tickvals": [*axis.names], "ticktext": names, "tickfont": {"size": size}}
    return look


def _decades(axis: Axis, panel: Panel) -> float:
    """What a logarithmic axis spans, in powers of ten."""
    lines = [layer for layer in panel.layers if isinstance(layer, Line | Shades)]
    values = np.concatenate([[], *(_floats(line.x if axis is panel.x else line.y) for line in lines)])
    positive = values[np.isfinite(values) & (values > 0.0)]
    ends = (float(positive.min()), float(positive.max())) if positive.size else (1.0, 1.0)
    low, high = (given if given else end for given, end in zip(axis.limits, ends, strict=True))
    return float(np.log10(high / low))


def _headline(title: str, left: float, top: float, pixels: float) -> dict[str, Any]:
    lines = "<br>".join(escaped(line) for line in wrapped(title, int(pixels / CHARACTER)))
    place = {"x": left, "y": top, "xref": "paper", "yref": "paper", "xanchor": "left", "yanchor": "bottom"}
    return {"text": f"<b>{lines}</b>", "align": "left", "showarrow": False, "font": {"size": 12}, **place}


def _legend(chart: Chart, narrow: bool) -> dict[str, Any]:
    """To the right of the panels; on a narrow screen below them."""
    title = {"title": {"text": escaped(chart.legend_title)}} if chart.legend_title else {}
    place = (
        {"orientation": "h", "yref": "container", "y": 0.0, "yanchor": "bottom", "x": 0.0} if narrow else {"x": 1.02, "y": 1.0}
    )
    return {**place, **title, "itemwidth": 30, "font": {"size": 12}}


def _legend_rows(chart: Chart) -> int:
    """Rows of a legend below the panels."""
    rows, room = int(bool(chart.legend_title)), 0.0
    for label in chart.entries:
        width = 52 + CHARACTER * len(label)
        rows, room = (rows, room - width) if width <= room else (rows + 1, PHONE - width)
    return rows
