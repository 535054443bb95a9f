"""A result in a few lines: what `print` and notebooks show of it."""

from __future__ import annotations

import re
from typing import TYPE_CHECKING

from stickslip.show.report.markup import picture, presentations, text
from stickslip.support.late import xr
from stickslip.support.renderers import SENTENCES

if TYPE_CHECKING:
    from stickslip.results.schema import Result

MOST_FAILURES = 5
"""Failures listed in a summary."""


@SENTENCES.of("Result")
def summary(result: Result) -> list[str]:
    """The title, what came out in sentences, and what failed; where the analysis has no report, its table or what it
    holds."""
    dataset: xr.Dataset | None = getattr(result, "dataset", None)
    analysis = analysis_named(type(result).__name__)
    if dataset is None or analysis not in presentations():
        head = _titled(type(result).__name__, dataset)
        if dataset is None:
            return [head]
        variables = (f"{name} ({', '.join(map(str, variable.dims))})" for name, variable in dataset.data_vars.items())
        held = f"dataset: {', '.join(variables)}"
        if hasattr(result, "table"):
            units = {name: variable.attrs.get("units", "1") for name, variable in dataset.variables.items()}
            named = result.table().rename(columns={name: f"{name} [{unit}]" for name, unit in units.items() if unit != "1"})
            held = named.to_string(index=False, na_rep="", float_format="{:.6g}".format)
        return [head, *filter(None, (held, str(dataset.attrs.get("message", ""))))]
    presentation = presentations()[analysis]
    sentences = list(presentation.sentences(dataset))
    failures = [failure for failure in presentation.failures(dataset) if failure not in sentences]
    more = len(failures) - MOST_FAILURES
    return [
        _titled(presentation.title, dataset),
        *sentences,
        *(f"failed: {failure}" for failure in failures[:MOST_FAILURES]),
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
