"""What pages of the report are made of: presentations of analyses, and HTML as strings.

Presentations say how console, report, figures and tables show the results of an analysis. The module of an analysis in this
folder registers it: `presents("campbell", "Campbell diagram", ...)`.

All data enter a page through `text` or `cell`, which escape them. Numbers as text: Hz, per cent, energies with prefix.

The charts of a page: places in the HTML, and the data from which report.js draws them. A place shows one of several charts, by
the choices of the reader (output, quantity, scale): every choice is a chart of its own, described in `show/plots/`. What several
charts share stands in the page once, numbers up to a factor.
"""

from __future__ import annotations

import base64
import gzip
import html
import io
import math
import re
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cache, partial
from importlib import import_module
from itertools import product
from pkgutil import iter_modules
from typing import TYPE_CHECKING, Any, Literal

import numpy as np

from stickslip.results.schema import Certainty, analysis_of, shown_sentence, shown_table, system_of
from stickslip.results.view import energy_unit, shown_unit
from stickslip.show import report
from stickslip.show.plots.chart import Chart, shown_chart
from stickslip.show.plots.deformed_shape import MovingPicture
from stickslip.show.plots.interactive import Combination, description, escaped
from stickslip.show.plots.look import colour, house_style
from stickslip.support.checks import Array, fault
from stickslip.support.late import Figure, pd, xr
from stickslip.support.units import UnitSystem

if TYPE_CHECKING:
    from stickslip.show.plots.paper import Figures


MOST_ROWS = 40
"""Rows of a table that stands open."""


def text(value: object) -> str:
    """Any value as text of the page: <, >, & and quotes are escaped."""
    return html.escape(str(value), quote=True)


def cell(shown: str, value: float | None = None, note: str = "") -> str:
    """A table cell; a number carries its exact value in SI units as data-value."""
    data = "" if value is None else f' data-value="{float(value)!r}"'
    kind = ' class="number"' if value is not None else ""
    return f"<td{kind}{data}>{text(shown)}{f' <small>{text(note)}</small>' if note else ''}</td>"


def table(identifier: str, caption: str, heads: Sequence[str], rows: Iterable[str], stacked: bool = False) -> str:
    """A table whose `rows` are ready <tr> elements; heads of numbers stand over their numbers, a long table is folded.

    stacked: on a narrow screen every number of a row stands below its head, so that none is out of sight.
    """
    ready = list(rows)
    kinds = re.findall(r"<td( class=\"number\")?", ready[0]) if ready else []
    kinds += [""] * (len(heads) - len(kinds))
    head = "".join(f'<th scope="col"{kind}>{text(name)}</th>' for name, kind in zip(heads, kinds, strict=False))
    kind = ""
    if stacked:
        kind, cells = ' class="stacked"', re.compile(r"<td(?! colspan)")
        for k, row in enumerate(ready):
            names = iter(heads)
            ready[k] = cells.sub(lambda found, names=names: f'{found[0]} data-head="{text(next(names))}"', row)  # type: ignore[misc]
    html = (
        f'<div class="wide" tabindex="0" role="region" aria-label="{text(caption)}"><table id="{identifier}"{kind}>'
        f"<caption>{text(caption)}</caption><thead><tr>{head}</tr></thead><tbody>{''.join(ready)}</tbody></table></div>"
    )
    folded = f"<details><summary>{text(caption.rstrip('.'))} ({len(ready)} rows)</summary>{html}</details>"
    return folded if len(ready) > MOST_ROWS else html


def section(identifier: str, title: str, *parts: str) -> str:
    """A section of the page with its heading."""
    heading = f'<h2 id="{identifier}-h">{text(title)}</h2>'
    return f'<section id="{identifier}" aria-labelledby="{identifier}-h">{heading}{"".join(parts)}</section>'


def picture(figure: Figure, description: str, kind: Literal["svg", "png"] = "svg") -> str:
    """A figure as an SVG image, or as PNG where it has thousands of faces; the same figure gives the same text."""
    buffer = io.BytesIO()
    with house_style():
        figure.savefig(buffer, format=kind, metadata={"Date": None} if kind == "svg" else None)
    data = base64.b64encode(buffer.getvalue()).decode()
    media = {"svg": "svg+xml", "png": "png"}[kind]
    return f'<img alt="{text(description)}" style="max-width:100%" src="data:image/{media};base64,{data}">'


def packed(identifier: str, content: str) -> str:
    """A text that report.js unpacks: gzipped and in base64 it takes a third of its size, and cannot leave its element."""
    encoded = base64.b64encode(gzip.compress(content.encode(), 5, mtime=0)).decode()
    return f'<script type="text/plain" id="{identifier}">{encoded}</script>'


def number(value: float, digits: int = 4) -> str:
    """A number with so many digits, never in exponents where a reader would not write them."""
    if not math.isfinite(value):
        return "–"
    return f"{value:.{digits}g}" if not 1e4 <= abs(value) < 1e7 else f"{value:.0f}"


def hertz(value: float) -> str:
    """A frequency, to a hundredth, or to five digits below 10 Hz."""
    if not math.isfinite(value):
        return "–"
    return f"{value:.2f}" if abs(value) >= 10.0 else f"{value:.5g}"


def percent(value: float) -> str:
    """A share in percent; more digits where it is near 100 %."""
    return f"{100.0 * value:.1f} %" if 0.0 < abs(1.0 - value) < 0.02 or abs(value) < 0.1 else f"{100.0 * value:.0f} %"


ROUNDING = 1e-11
"""Numbers below this share of the largest one of their unit in a table are rounding."""


def framed(identifier: str, caption: str, frame: pd.DataFrame, stacked: bool = False) -> str:
    """A data frame as a table; heads name units, "amplitude [m]"."""
    columns, rows = _columns(frame), []
    for values in frame.itertuples(index=False):
        cells = (_cell(value, size, zero) for value, (_, size, zero) in zip(values, columns, strict=True))
        rows.append(f"<tr>{''.join(cells)}</tr>")
    return table(identifier, caption, [head for head, _, _ in columns], rows, stacked)


def _columns(frame: pd.DataFrame) -> list[tuple[str, float, float]]:
    """Of each column its head with the unit that is shown, the size of that unit in SI, and the number below which it shows 0."""
    heads = [str(name) for name in frame.columns]
    units = [head.removesuffix("]").rpartition(" [")[2] if head.endswith("]") else head for head in heads]
    largest: dict[str, float] = {}
    for unit, (_, column) in zip(units, frame.items(), strict=True):
        values = np.abs(column.to_numpy(dtype=float)) if column.dtype.kind == "f" else np.zeros(0)
        largest[unit] = max(largest.get(unit, 0.0), float(np.max(values[np.isfinite(values)], initial=0.0)))
    columns = []
    for head, unit in zip(heads, units, strict=True):
        size, name = 1.0, unit
        if unit == "J":
            size, name = energy_unit(largest[unit])
        elif unit == "Pa":
            size, name = 1e6, "MPa"
        elif unit.split("/")[0] == "m":
            length = shown_unit(unit, largest[unit])
            size, name = length.metres, length.name
        quantity = head.rpartition(" [")[0]
        shown = head if unit == head else quantity if unit == "1" else f"{quantity} in {name}"
        columns.append((shown, size, ROUNDING * largest[unit]))
    return columns


def _cell(value: object, size: float, zero: float) -> str:
    """A cell; numbers below `zero` are rounding and shown as 0, their exact values in SI stay in the page."""
    if isinstance(value, float):
        return cell("0" if abs(value) < zero else number(value / size), value)
    return cell(str(value), float(value)) if isinstance(value, int) and not isinstance(value, bool) else cell(str(value))


DIGITS = 7
"""Of the numbers in the page; exact values stand in its tables and in results.nc."""
PACKED = {"<f4": "Float32Array", "<i4": "Int32Array"}
"""Kinds of large arrays that stand in the page as bytes, by their type; others stand as numbers."""
SHORT, LONG, WORDY = 4, 200, 60
"""Arrays of so few numbers stand where they are used, and parts and texts of not more characters."""
FEW = 16
"""Longer arrays stand as bytes with 7 digits: half the size of numbers as text, and read in a tenth of the time."""


@dataclass(frozen=True)
class Choice:
    """One thing that the reader may choose in a chart; charts of one page with a choice of the same name change together."""

    name: str
    options: Sequence[str]


@dataclass(frozen=True, eq=False)
class Opening:
    """Charts that a click on a curve opens: by the label of the curve the index of the chart of each point, or None."""

    charts: Sequence[Chart]
    points: Mapping[str, Sequence[int | None]]
    note: str


Draw = Callable[..., Chart | MovingPicture]


@dataclass(eq=False)
class Charts:
    """Gathers the charts of a page while its sections are written; system: the units that they are shown in."""

    results: Sequence[str]
    system: UnitSystem | None = None
    places: dict[str, list[dict[str, Any]]] = field(default_factory=dict)
    parts: list[Any] = field(default_factory=list)
    known: dict[str, int] = field(default_factory=dict)
    colours: set[str] = field(default_factory=set)

    def place(
        self, name: str, draw: Draw, choices: Iterable[Choice] = (), result: str = "", opening: Opening | None = None
    ) -> str:
        """HTML of a place for the charts that `draw` gives for every combination of choices.

        result: the result that they show; a place of several results shows the one that is chosen for the whole page.
        """
        shown = [choice for choice in choices if choice.options]
        drawn = [self._shown(draw(*options)) for options in product(*(choice.options for choice in shown))]
        offered = [{"name": choice.name, "options": list(choice.options)} for choice in shown if len(choice.options) > 1]
        entry: dict[str, Any] = {"result": result, "choices": offered, "charts": [self._encoded(chart) for chart in drawn]}
        if opening is not None:
            charts = [self._encoded(self._shown(chart)) for chart in opening.charts]
            entry["opening"] = {"charts": charts, "points": {escaped(label): list(at) for label, at in opening.points.items()}}
        first = name not in self.places
        self.places.setdefault(name, []).append(entry)
        return _html(name, drawn[0], opening) if first else ""

    def drawn(self, name: str, figure: Chart | Figure, description: str, result: str = "") -> str:
        """HTML of one chart without choices, or of a drawing as a picture."""
        return self.place(name, lambda: figure, result=result) if isinstance(figure, Chart) else picture(figure, description)

    def data(self) -> dict[str, Any]:
        """Everything that report.js draws."""
        schemes = {
            scheme: {name: colour(name, scheme == "dark") for name in sorted(self.colours)} for scheme in ("light", "dark")
        }
        return {"results": list(self.results), "places": self.places, "parts": self.parts, "colours": schemes}

    def _shown(self, chart: Chart | MovingPicture) -> Chart | MovingPicture:
        """A chart in the units of the page."""
        return shown_chart(chart, self.system) if isinstance(chart, Chart) else chart

    def _encoded(self, chart: Chart | MovingPicture) -> dict[str, Any]:
        described = chart.description() if isinstance(chart, MovingPicture) else description(chart)
        heads = {"title": described.pop("title"), "note": described.pop("note")}
        return {**heads, **self._part(described)}

    def _part(self, part: Any) -> Any:
        if isinstance(part, Combination):
            return {"sum": [self._part(array) for array in part.arrays], "weights": list(part.weights)}
        if isinstance(part, np.ndarray):
            return self._array(part)
        if isinstance(part, Mapping):
            encoded = {key: self._part(value) for key, value in part.items()}
            return self._shared(encoded) if len(repr(encoded)) > LONG else encoded
        if isinstance(part, str):
            if part.startswith("@"):
                self.colours.add(part[1:])
            return self._shared(part) if len(part) > WORDY else part
        return [self._part(value) for value in part] if isinstance(part, list) else part

    def _array(self, values: Array) -> Any:
        """Numbers in the page, or a factor times numbers that other charts have too."""
        if values.dtype.str in PACKED:
            return self._shared({"bytes": base64.b64encode(values.tobytes()).decode(), "kind": PACKED[values.dtype.str]})
        if values.size <= SHORT or not np.isfinite(values).any():
            return rounded(values)
        factor = float(np.abs(values[np.isfinite(values)]).max()) or 1.0
        scaled = values / factor
        return {**(self._shared(rounded(scaled)) if values.size <= FEW else self._array(scaled.astype("<f4"))), "factor": factor}

    def _shared(self, part: Any) -> dict[str, Any]:
        """The place of a part that stands in the page once."""
        key = repr(part)
        if key not in self.known:
            self.known[key] = len(self.parts)
            self.parts.append(part)
        return {"part": self.known[key]}


def rounded(values: Array) -> list[float | None]:
    """Numbers with `DIGITS` digits; None for what is not a number."""
    return [float(f"{value:.{DIGITS}g}") if math.isfinite(value) else None for value in np.asarray(values, dtype=float).tolist()]


def _html(name: str, chart: Chart | MovingPicture, opening: Opening | None) -> str:
    """The place that report.js fills: caption, controls, the chart in words for who cannot see it, and what a click opens."""
    panels = () if isinstance(chart, MovingPicture) else chart.panels
    axes = [f"{panel.y.label} over {panel.x.label}".strip() for panel in panels if panel.y.label and panel.x.label]
    spoken = ". ".join(dict.fromkeys([chart.title, *axes]))
    frame = f'<figure class="place" data-place="{text(name)}"><figcaption></figcaption><div class="controls"></div>'
    steps = '<div class="steps"></div>' if isinstance(chart, MovingPicture) else ""
    drawing = f'<div class="chart" id="{text(name)}" role="img" aria-label="{text(spoken)}"></div>{steps}</figure>'
    if opening is None:
        return frame + drawing
    opened = f'<figure><figcaption aria-live="polite"></figcaption><div class="chart" id="{text(name)}-opened"></div></figure>'
    return f'{frame}{drawing}<div data-opened="{text(name)}" hidden>{opened}<p class="note">{text(opening.note)}</p></div>'


@dataclass(frozen=True)
class Presentation:
    """How the results of an analysis are reported.

    title: the analysis in words, "Forced response".
    sentences: what came out, one line each, for the console and the head of the report.
    figures: by name of the file.
    tables: by caption, columns with their units; for the report and for `stickslip export`.
    failures: a sentence for each case that failed; empty if none.
    answer: the caption of the table that answers what was asked, which a report shows first.
    responses: whether its report is that of response curves, section by section; all others show figures and tables.
    histories: further tables as `tables`, too long for a report.
    """

    title: str
    sentences: Callable[[xr.Dataset], Sequence[str]]
    figures: Callable[[xr.Dataset], Figures]
    tables: Callable[[xr.Dataset], Mapping[str, pd.DataFrame]]
    failures: Callable[[xr.Dataset], Sequence[str]] = lambda dataset: ()
    answer: str = ""
    responses: bool = False
    histories: Callable[[xr.Dataset], Mapping[str, pd.DataFrame]] = lambda dataset: {}

    def exported(self, dataset: xr.Dataset) -> Mapping[str, pd.DataFrame]:
        """All tables, as `stickslip export` writes them."""
        return {**self.tables(dataset), **self.histories(dataset)}


_FINENESS = "The error due to harmonics = {harmonics} and samples = {samples} is not estimated: increase both to see it"
_STEPS = "The error of the time steps is not estimated: double `{}` to see it"
NOT_ESTIMATED = {
    "controlled_response": _FINENESS,
    "damper_cycle": _STEPS.format("steps"),
    "damper_design": f"{_FINENESS}. The search may have missed a better design",
    "damper_evolution": _STEPS.format("steps"),
    "free_decay": _STEPS.format("steps"),
    "limit_cycles": _FINENESS,
    "mistuned_population": f"{_FINENESS}. The percentiles are those of the samples drawn: more samples show how far they scatter",
    "nonlinear_modes": _FINENESS,
    "performance_band": f"{_FINENESS}. The search finds local optima, so the true band can be wider",
    "performance_curve": _FINENESS,
    "response_samples": _FINENESS,
    "run_up": f"{_STEPS.format('steps_per_period')}. Stiffness and constant loads are those at the middle of each cycle",
    "sensitivity_indices": f"{_FINENESS}. The intervals are those of the sampling alone",
    "speed_sweep": "The error is not estimated for loss factors, lower peaks and other points of the curves",
    "steady_cycles": _STEPS.format("steps"),
    "stepped_sine": _STEPS.format("steps_per_period"),
}
"""Of each analysis that shows numbers without an estimate of their error, why there is none and how to see it."""


def _with_certainty(analysis: str, presentation: Presentation) -> Presentation:
    """A presentation whose sentences end with what is not known of the error."""

    def sentences(dataset: xr.Dataset) -> list[str]:
        fineness = {name: dataset.attrs.get(name, "its value") for name in ("harmonics", "samples")}
        return [*presentation.sentences(dataset), Certainty(NOT_ESTIMATED[analysis].format(**fineness))]

    return replace(presentation, sentences=sentences) if analysis in NOT_ESTIMATED else presentation


_PRESENTATIONS: dict[str, Presentation] = {}


def presents(
    analyses: str | Sequence[str],
    title: str,
    sentences: Callable[[xr.Dataset], Sequence[str]],
    figures: Figures | Callable[[xr.Dataset], Figures],
    tables: Callable[[xr.Dataset], Mapping[str, pd.DataFrame]],
    **more: Any,
) -> Presentation:
    """Register what shows the results of one analysis or several, by their names in `[study] analysis`: the `Presentation` of
    these and of more fields; figures by name where all results have the same."""
    found = Presentation(title, sentences, figures if callable(figures) else lambda dataset: figures, tables, **more)
    for analysis in (analyses,) if isinstance(analyses, str) else analyses:
        _PRESENTATIONS[analysis] = _with_certainty(analysis, found)
    return found


@cache
def presentations() -> Mapping[str, Presentation]:
    """All presentations, by the name of the analysis."""
    for module in iter_modules(report.__path__, f"{report.__name__}."):
        import_module(module.name)
    return _PRESENTATIONS


def presentation_of(dataset: xr.Dataset) -> Presentation:
    """The presentation of a dataset, by the analysis that it came of."""
    return presentation_named(analysis_of(dataset))


@cache
def presentation_named(analysis: str) -> Presentation:
    """The presentation of an analysis by its name, with everything that it shows in the units of the study."""
    known = presentations()
    if analysis not in known:
        raise fault("The analysis of the results", f"must be one of {', '.join(sorted(known))}", analysis)
    own = known[analysis]

    def in_units(tables: Mapping[str, pd.DataFrame], dataset: xr.Dataset) -> Mapping[str, pd.DataFrame]:
        return {caption: shown_table(table, dataset) for caption, table in tables.items()}

    return replace(
        own,
        sentences=lambda data: [type(sentence)(shown_sentence(sentence, data)) for sentence in own.sentences(data)],
        failures=lambda data: [shown_sentence(sentence, data) for sentence in own.failures(data)],
        figures=lambda data: {name: partial(_shown, draw) for name, draw in own.figures(data).items()},
        tables=lambda data: in_units(own.tables(data), data),
        histories=lambda data: in_units(own.histories(data), data),
    )


def _shown(draw: Callable[[xr.Dataset], Chart | Figure], dataset: xr.Dataset) -> Chart | Figure:
    """A figure in the units of the study; a drawing without curves as it is."""
    figure = draw(dataset)
    return shown_chart(figure, system_of(dataset)) if isinstance(figure, Chart) else figure
