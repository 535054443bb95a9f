"""Presentations: how console, report, figures and tables show the results of each analysis.

The module of an analysis in this folder registers it: `PRESENTATION = presents("campbell", Presentation(...))`.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cache, partial
from importlib import import_module
from pkgutil import iter_modules
from typing import TYPE_CHECKING

from stickslip.results.schema import analysis_of
from stickslip.results.shown_units import shown_sentence, shown_table, system_of
from stickslip.show import report
from stickslip.show.plots.chart import Chart, shown_chart
from stickslip.support.checks import fault
from stickslip.support.late import pd, xr

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from stickslip.show.plots.paper import Figures


@dataclass(frozen=True)
class Presentation:
    """How the results of an analysis are reported.

    title: the analysis in words, "Forced response".
    sentences: what came out, one line each, for the console and the head of the report.
    failures: a sentence for each case that failed; empty if none.
    figures: by name of the file.
    tables: by caption, columns with their units; for the report and for `stickslip export`.
    answer: the caption of the table that answers what was asked, which a report shows first.
    responses: whether its report is that of response curves, section by section; all others show figures and tables.
    histories: further tables as `tables`, too long for a report.
    """

    title: str
    sentences: Callable[[xr.Dataset], Sequence[str]]
    failures: Callable[[xr.Dataset], Sequence[str]]
    figures: Callable[[xr.Dataset], Figures]
    tables: Callable[[xr.Dataset], Mapping[str, pd.DataFrame]]
    answer: str = ""
    responses: bool = False
    histories: Callable[[xr.Dataset], Mapping[str, pd.DataFrame]] = lambda dataset: {}

    def exported(self, dataset: xr.Dataset) -> Mapping[str, pd.DataFrame]:
        """All tables, as `stickslip export` writes them."""
        return {**self.tables(dataset), **self.histories(dataset)}


_PRESENTATIONS: dict[str, Presentation] = {}


def presents(analyses: str | Sequence[str], presentation: Presentation) -> Presentation:
    """Register what shows the results of one analysis or several, by their names in `[study] analysis`."""
    for analysis in (analyses,) if isinstance(analyses, str) else analyses:
        _PRESENTATIONS[analysis] = presentation
    return presentation


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

    def sentences(dataset: xr.Dataset) -> list[str]:
        return [shown_sentence(sentence, dataset) for sentence in own.sentences(dataset)]

    def failures(dataset: xr.Dataset) -> list[str]:
        return [shown_sentence(sentence, dataset) for sentence in own.failures(dataset)]

    def figures(dataset: xr.Dataset) -> Figures:
        return {name: partial(_shown, draw) for name, draw in own.figures(dataset).items()}

    def tables(dataset: xr.Dataset) -> Mapping[str, pd.DataFrame]:
        return {caption: shown_table(table, dataset) for caption, table in own.tables(dataset).items()}

    def histories(dataset: xr.Dataset) -> Mapping[str, pd.DataFrame]:
        return {caption: shown_table(table, dataset) for caption, table in own.histories(dataset).items()}

    return replace(own, sentences=sentences, failures=failures, figures=figures, tables=tables, histories=histories)


def _shown(draw: Callable[[xr.Dataset], Chart | Figure], dataset: xr.Dataset) -> Chart | Figure:
    """A figure in the units of the study; a drawing without curves as it is."""
    figure = draw(dataset)
    return shown_chart(figure, system_of(dataset)) if isinstance(figure, Chart) else figure
