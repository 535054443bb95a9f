"""Sections of the page of an analysis: the answer with its chart, further figures, tables, failures.

An analysis fills them through its `Presentation`.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Mapping
from typing import Any

from stickslip.results.schema import Row
from stickslip.show.report.answer import warnings_at_a_glance
from stickslip.show.report.markup import Charts, framed, presentation_of, section, text
from stickslip.support.late import pd, xr

Datasets = Mapping[str, "xr.Dataset"]

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
            answer = _framed(place, shown.answer, frame, stacked=len(frame.columns) > BESIDE)
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
        parts += [_framed(place, caption, frame) for caption, frame in shown.tables(dataset).items() if caption != shown.answer]
    return section("tables", "Tables", *parts)


def _framed(place: int, caption: str, frame: pd.DataFrame, stacked: bool = False) -> str:
    return framed(f"table-{place}-{caption.replace(' ', '-')}", caption, frame, stacked)


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
