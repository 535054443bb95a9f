"""Sections of the page of an analysis: the answer with its chart, further figures, tables, failures.

An analysis fills them through its `Presentation`.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Mapping
from typing import Any

import numpy as np

from stickslip.results.schema import Row
from stickslip.results.view import energy_unit, shown_unit
from stickslip.show.report.answer import warnings_at_a_glance
from stickslip.show.report.markup import Charts, cell, number, presentation_of, section, table, text
from stickslip.support.late import pd, xr

Datasets = Mapping[str, "xr.Dataset"]

ROUNDING = 1e-11
"""Numbers below this share of the largest one of their unit in a table are rounding."""

BESIDE = 5
"""Columns that stand beside each other on a narrow screen."""

PREFIX = re.compile(r"^((note|Warning): |warning, )")
"""Before a warning on the console."""

SYMBOL = re.compile(r"\w+_\w+|\w+ (=|≥|×|is not found)")
"""A line that begins with a symbol."""


def overview(datasets: Datasets, charts: Charts) -> str:
    """What came out: the answer in a sentence or a table, warnings, the first figure, everything else in sentences.

    A table stands for the sentences that are its rows.
    """
    parts = []
    for place, (label, dataset) in enumerate(datasets.items()):
        shown = presentation_of(dataset)
        warned = {line for key in ("warnings", "notes") for line in str(dataset.attrs.get(key, "")).splitlines()}
        warnings: list[str] = []
        sentences: list[str] = []
        answer = ""
        if (frame := shown.tables(dataset).get(shown.answer)) is not None:
            answer = _table(place, shown.answer, frame, stacked=len(frame.columns) > BESIDE)
        for line in shown.sentences(dataset):
            sentence = PREFIX.sub("", line.strip())
            if sentence in warned or line.strip().startswith("warning, "):
                warnings.append(sentence)
            elif not (answer and isinstance(line, Row)):
                sentences.append(sentence)
        first, *rest = sentences
        lines = "".join(f"<li>{text(sentence)}</li>" for sentence in rest)
        seconds = dataset.attrs.get("cpu_seconds")
        note = "" if seconds is None else f'<p class="note">{text(f"{float(seconds):.3g} s of processor time")}.</p>'
        figure = "".join(_figure(charts, place, name, draw, dataset) for name, draw in [*shown.figures(dataset).items()][:1])
        parts.append(
            f'{_head(label, datasets)}<p class="headline">{text(_sentence(first))}</p>{answer}'
            f"{warnings_at_a_glance([_sentence(warning) for warning in warnings])}{figure}"
            f"<ul>{lines}</ul>{note}"
        )
    return section("overview", "Overview", *parts)


def figures(datasets: Datasets, charts: Charts) -> str:
    """The other figures of every result."""
    parts = []
    for place, (label, dataset) in enumerate(datasets.items()):
        others = [*presentation_of(dataset).figures(dataset).items()][1:]
        parts += [_head(label, datasets), *(_figure(charts, place, name, draw, dataset) for name, draw in others)]
    return section("figures", "Figures", *parts)


def has_more_figures(dataset: xr.Dataset) -> bool:
    """Whether a result has figures beside that of the overview."""
    return len(presentation_of(dataset).figures(dataset)) > 1


def _figure(charts: Charts, place: int, name: str, draw: Callable[[xr.Dataset], Any], dataset: xr.Dataset) -> str:
    return charts.drawn(f"chart-{place}-{name.replace('_', '-')}", draw(dataset), name.replace("_", " "))


def tables(datasets: Datasets, charts: Charts) -> str:
    """The tables of every result that the overview does not show."""
    parts = []
    for place, (label, dataset) in enumerate(datasets.items()):
        shown = presentation_of(dataset)
        parts.append(_head(label, datasets))
        parts += [_table(place, caption, frame) for caption, frame in shown.tables(dataset).items() if caption != shown.answer]
    return section("tables", "Tables", *parts)


def _table(place: int, caption: str, frame: pd.DataFrame, stacked: bool = False) -> str:
    columns, rows = _columns(frame), []
    for values in frame.itertuples(index=False):
        cells = (_cell(value, size, zero) for value, (_, size, zero) in zip(values, columns, strict=True))
        rows.append(f"<tr>{''.join(cells)}</tr>")
    return table(f"table-{place}-{caption.replace(' ', '-')}", caption, [head for head, _, _ in columns], rows, stacked)


def failures(datasets: Datasets, charts: Charts) -> str:
    """What failed, and why."""
    parts = []
    for label, dataset in datasets.items():
        causes = "".join(f"<li>{text(sentence)}</li>" for sentence in presentation_of(dataset).failures(dataset))
        parts.append(_head(label, datasets) + (f'<ul class="failed">{causes}</ul>' if causes else "<p>Nothing failed.</p>"))
    return section("failures", "What failed, and why", *parts)


def _head(label: str, datasets: Datasets) -> str:
    return f"<h3>{text(label)}</h3>" if len(datasets) > 1 else ""


def _sentence(line: str) -> str:
    """A line of the console as a sentence; a symbol at its start, `kt = ...`, stays as it is."""
    start = line[:1] if SYMBOL.match(line) else line[:1].upper()
    return start + line[1:] + ("" if line.endswith((".", "!", "?")) else ".")


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
