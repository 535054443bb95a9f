"""Presentations: how console, report, figures and tables show the results of each analysis.

A module of this folder holds it as PRESENTATION; the `Kind` of an analysis (`study/analyses/`) names the module.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from importlib import import_module
from typing import TYPE_CHECKING

from stickslip.checks import fault
from stickslip.results.schema import analysis_of
from stickslip.study.kinds import KINDS

if TYPE_CHECKING:
    import pandas as pd
    import xarray as xr

    from stickslip.plots.files import Figures


@dataclass(frozen=True)
class Presentation:
    """How the results of an analysis are reported.

    title: the analysis in words, "Forced response".
    sentences: what came out, one line each, for the console and the head of the report.
    failures: a sentence for each case that failed; empty if none.
    figures: by name of the file.
    tables: by caption, columns with their units; for the report and for `stickslip export`.
    responses: whether its report is that of response curves, section by section; all others show figures and tables.
    """

    title: str
    sentences: Callable[[xr.Dataset], Sequence[str]]
    failures: Callable[[xr.Dataset], Sequence[str]]
    figures: Callable[[xr.Dataset], Figures]
    tables: Callable[[xr.Dataset], Mapping[str, pd.DataFrame]]
    responses: bool = False


def presentation_of(dataset: xr.Dataset) -> Presentation:
    """The presentation of a dataset, by the analysis that it came of."""
    return presentation_named(analysis_of(dataset))


def presentation_named(analysis: str) -> Presentation:
    """The presentation of an analysis by its name."""
    if analysis not in KINDS:
        raise fault("The analysis of the results", f"must be one of {', '.join(KINDS)}", analysis)
    presentation: Presentation = import_module(f"stickslip.report.{KINDS[analysis].report}").PRESENTATION
    return presentation
