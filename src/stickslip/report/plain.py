"""Sections of a page without scripts: conclusions, figures as pictures, tables, failures.

An analysis fills them through its `Presentation`.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING

from stickslip.plots.look import house_style
from stickslip.report.markup import cell, section, table, text
from stickslip.report.numbers import number
from stickslip.report.pictures import picture
from stickslip.report.presentation import presentation_of

if TYPE_CHECKING:
    import pandas as pd
    import xarray as xr

Datasets = Mapping[str, "xr.Dataset"]


def overview(datasets: Datasets) -> str:
    """What came out."""
    parts = []
    for label, dataset in datasets.items():
        lines = "".join(f"<li>{text(sentence.strip())}</li>" for sentence in presentation_of(dataset).sentences(dataset))
        seconds = dataset.attrs.get("cpu_seconds")
        note = "" if seconds is None else f'<p class="note">{text(f"{float(seconds):.3g} s of processor time")}.</p>'
        parts.append(f"{_head(label, datasets)}<ul>{lines}</ul>{note}")
    return section("overview", "Overview", *parts)


def figures(datasets: Datasets) -> str:
    """Every figure of every result."""
    parts = []
    for label, dataset in datasets.items():
        parts.append(_head(label, datasets))
        with house_style():
            drawn = {name: draw(dataset) for name, draw in presentation_of(dataset).figures(dataset).items()}
        parts += [f"<p>{picture(figure, name.replace('_', ' '))}</p>" for name, figure in drawn.items()]
    return section("figures", "Figures", *parts)


def tables(datasets: Datasets) -> str:
    """Every table of every result."""
    parts = []
    for place, (label, dataset) in enumerate(datasets.items()):
        parts.append(_head(label, datasets))
        for caption, frame in presentation_of(dataset).tables(dataset).items():
            parts.append(
                table(f"table-{place}-{caption.replace(' ', '-')}", caption, list(map(str, frame.columns)), _rows(frame))
            )
    return section("tables", "Tables", *parts)


def failures(datasets: Datasets) -> str:
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
