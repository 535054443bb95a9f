"""A result in a few lines: what `print` and notebooks show of it."""

from __future__ import annotations

import re
from collections.abc import Sequence
from typing import TYPE_CHECKING

from stickslip.show.report.markup import text
from stickslip.show.report.pictures import picture
from stickslip.show.report.presentation import presentations
from stickslip.support.renderers import SENTENCES

if TYPE_CHECKING:
    import xarray as xr

    from stickslip.results.result import Result

MOST_FAILURES = 5
"""Failures listed in a summary."""


@SENTENCES.of("Result")
def summary(result: Result) -> list[str]:
    """The title, what came out in sentences, and what failed; where the analysis has no report, what the result holds."""
    dataset: xr.Dataset | None = getattr(result, "dataset", None)
    analysis = analysis_named(type(result).__name__)
    if dataset is None or analysis not in presentations():
        held = [] if dataset is None else [_content(dataset), str(dataset.attrs.get("message", ""))]
        return [_titled(type(result).__name__, dataset), *filter(None, held)]
    presentation = presentations()[analysis]
    said = list(presentation.sentences(dataset))
    return [
        _titled(presentation.title, dataset),
        *said,
        *_failed([each for each in presentation.failures(dataset) if each not in said]),
    ]


def _failed(failures: Sequence[str]) -> list[str]:
    """What failed, the first few."""
    more = len(failures) - MOST_FAILURES
    return [
        *(f"failed: {each}" for each in failures[:MOST_FAILURES]),
        *([f"failed: {more} more; the report has them"] if more > 0 else []),
    ]


def analysis_named(kind: str) -> str:
    """The analysis of a class of results, which is named after it: response_bounds of ResponseBounds."""
    return re.sub(r"(?<!^)(?=[A-Z])", "_", kind).lower()


@SENTENCES.of("Result", "page")
def summary_page(result: Result) -> str:
    """The same as HTML, with the figure of the result."""
    head, *lines = summary(result)
    return f"<p><b>{text(head)}</b></p><pre>{text(chr(10).join(lines))}</pre>{picture(result.plot(), head, 'png')}"


def _titled(name: str, dataset: xr.Dataset | None) -> str:
    title = "" if dataset is None else str(dataset.attrs.get("title", ""))
    return f"{name}: {title}" if title not in ("", name) else name


def _content(dataset: xr.Dataset) -> str:
    """Variables with their dimensions."""
    names = (f"{name} ({', '.join(map(str, variable.dims))})" for name, variable in dataset.data_vars.items())
    return f"dataset: {', '.join(names)}"
