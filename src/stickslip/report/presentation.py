"""Presentations: how console, report, figures and tables show the results of each analysis.

`report/<analysis>.py` holds it as PRESENTATION; `PRESENTATIONS` lists them.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from importlib import import_module
from typing import TYPE_CHECKING

from stickslip.checks import fault
from stickslip.results.schema import analysis_of

if TYPE_CHECKING:
    import pandas as pd
    import xarray as xr

    from stickslip.plots.files import Figures

PRESENTATIONS = {
    "forced_response": "stickslip.report.responses",
    "response_bounds": "stickslip.report.responses",
    "response_samples": "stickslip.report.responses",
    "damper_cycle": "stickslip.report.damper_cycle",
    "steady_cycles": "stickslip.report.damper_cycles",
    "damper_evolution": "stickslip.report.damper_cycles",
    "performance_curve": "stickslip.report.performance",
    "performance_band": "stickslip.report.performance_band",
    "damper_design": "stickslip.report.design",
    "sensitivity_indices": "stickslip.report.sensitivity_indices",
    "identification": "stickslip.report.identification",
    "mistuned_population": "stickslip.report.mistuning",
}
"""Analysis: module with its PRESENTATION. A new analysis adds its line here."""


@dataclass(frozen=True)
class Presentation:
    """How the results of an analysis are reported.

    title: the analysis in words, "Forced response".
    sentences: what came out, one line each, for the console and the head of the report.
    failures: a sentence for each case that failed; empty if none.
    figures: by name of the file.
    tables: by caption, columns with their units; for the report and for `stickslip export`.
    interactive: whether its report is that of response curves, which a script draws; all others show figures and tables.
    """

    title: str
    sentences: Callable[[xr.Dataset], Sequence[str]]
    failures: Callable[[xr.Dataset], Sequence[str]]
    figures: Callable[[xr.Dataset], Figures]
    tables: Callable[[xr.Dataset], Mapping[str, pd.DataFrame]]
    interactive: bool = False


def presentation_of(dataset: xr.Dataset) -> Presentation:
    """The presentation of a dataset, by the analysis that it came of."""
    analysis = analysis_of(dataset)
    if analysis not in PRESENTATIONS:
        raise fault("The analysis of the results", f"must be one of {', '.join(PRESENTATIONS)}", analysis)
    presentation: Presentation = import_module(PRESENTATIONS[analysis]).PRESENTATION
    return presentation
