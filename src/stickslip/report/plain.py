"""Sections of the page of an analysis: the answer with its chart, further figures, tables, failures.

An analysis fills them through its `Presentation`.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import TYPE_CHECKING, Any

from stickslip.report.charts import Charts
from stickslip.report.markup import cell, section, table, text
from stickslip.report.numbers import number
from stickslip.report.presentation import presentation_of

if TYPE_CHECKING:
    import pandas as pd
    import xarray as xr

Datasets = Mapping[str, "xr.Dataset"]


def overview(datasets: Datasets, charts: Charts) -> str:
    """What came out: the answer, the first figure, everything else in sentences."""
    parts = []
    for place, (label, dataset) in enumerate(datasets.items()):
        shown = presentation_of(dataset)
        first, *rest = [sentence.strip() for sentence in shown.sentences(dataset)]
        lines = "".join(f"<li>{text(sentence)}</li>" for sentence in rest)
        seconds = dataset.attrs.get("cpu_seconds")
        note = "" if seconds is None else f'<p class="note">{text(f"{float(seconds):.3g} s of processor time")}.</p>'
        figure = "".join(_figure(charts, place, name, draw, dataset) for name, draw in [*shown.figures(dataset).items()][:1])
        parts.append(f'{_head(label, datasets)}<p class="headline">{text(first)}</p>{figure}<ul>{lines}</ul>{note}')
    return section("overview", "Overview", *parts)


def figures(datasets: Datasets, charts: Charts) -> str:
    """The other figures of every result."""
    parts = []
    for place, (label, dataset) in enumerate(datasets.items()):
        others = [*presentation_of(dataset).figures(dataset).items()][1:]
        parts += [_head(label, datasets), *(_figure(charts, place, name, draw, dataset) for name, draw in others)]
    return section("figures", "Figures", *parts)


def _figure(charts: Charts, place: int, name: str, draw: Callable[[xr.Dataset], Any], dataset: xr.Dataset) -> str:
    return charts.drawn(f"chart-{place}-{name.replace('_', '-')}", draw(dataset), name.replace("_", " "))


def tables(datasets: Datasets, charts: Charts) -> str:
    """Every table of every result."""
    parts = []
    for place, (label, dataset) in enumerate(datasets.items()):
        parts.append(_head(label, datasets))
        for caption, frame in presentation_of(dataset).tables(dataset).items():
            parts.append(
                table(f"table-{place}-{caption.replace(' ', '-')}", caption, list(map(str, frame.columns)), _rows(frame))
            )
    return section("tables", "Tables", *parts)


def failures(datasets: Datasets, charts: Charts) -> str:
    """What failed, and why."""
    parts = []
    for label, dataset in datasets.items():
        causes = "".join(f"<li>{text(sentence)}</li>" for sentence in presentation_of(dataset).failures(dataset))
        parts.append(_head(label, datasets) + (f'<ul class="failed">{causes}</ul>' if causes else "<p>Nothing failed.</p>"))
    return section("failures", "What failed, and why", *parts)


def _head(label: str, datasets: Datasets) -> str:
    return f"<h3>{text(label)}</h3>" if len(datasets) > 1 else ""


def _rows(frame: pd.DataFrame) -> list[str]:
    return [f"<tr>{''.join(_cell(value) for value in row)}</tr>" for row in frame.itertuples(index=False)]


def _cell(value: object) -> str:
    if isinstance(value, float):
        return cell(number(value), value)
    return cell(str(value), float(value)) if isinstance(value, int) and not isinstance(value, bool) else cell(str(value))
