"""What the results of all analyses have in common: figures by name, drawn when they are asked for."""

from __future__ import annotations

from collections.abc import Mapping
from importlib import import_module
from typing import TYPE_CHECKING, Any, ClassVar

from stickslip.checks import InputError, fault, nearest
from stickslip.results.shown_units import system_of

if TYPE_CHECKING:
    from matplotlib.figure import Figure


class Result:
    """A result with figures, which its class names: `class Curve(Result, figure="curve:draw", loops="loops:draw")`.

    figure: that of `plot()`, as module of `stickslip.plots` and function; others by the name that `plot` takes. Functions get the
    `dataset` of a result, or a result without one, and return a chart, or a matplotlib figure that is a drawing. A module is
    imported when its figure is drawn.
    """

    figures: ClassVar[Mapping[str, str]]

    def __init_subclass__(cls, figure: str, **others: str) -> None:
        super().__init_subclass__()
        cls.figures = {"": figure, **others}

    def __repr__(self) -> str:
        return "\n".join(import_module("stickslip.report.summary").summary(self))

    def _repr_html_(self) -> str:
        """What a notebook shows: what came out in sentences, and the figure of `plot()`."""
        page: str = import_module("stickslip.report.summary").summary_page(self)
        return page

    def plot(self, figure: str = "", **options: Any) -> Figure:
        """The figure of the result, or another one by its name in `figures`; options are those of its function."""
        found = self._figure(figure, options)
        drawn: Figure = found.plot() if hasattr(found, "plot") else found
        return drawn

    def to_plotly(self, figure: str = "", *, dark: bool = False, **options: Any) -> Any:
        """The same as an interactive plotly figure: `.show()` or `.write_html(path)`; dark: for a dark background."""
        found = self._figure(figure, options)
        if not hasattr(found, "to_plotly"):
            raise InputError(f"The figure {figure or 'of this result'} is a drawing without curves: plot() draws it.")
        return found.to_plotly(dark)

    def _figure(self, figure: str, options: Mapping[str, Any]) -> Any:
        """The chart of a figure, or the drawing."""
        if figure not in self.figures:
            raise fault("figure", "must be a known one", figure, nearest(str(figure), filter(None, self.figures)))
        module, function = self.figures[figure].split(":")
        drawn = getattr(import_module(f"stickslip.plots.{module}"), function)(getattr(self, "dataset", self), **options)
        chart = import_module("stickslip.plots.chart").Chart
        if not isinstance(drawn, chart) or not hasattr(self, "dataset"):
            return drawn
        return import_module("stickslip.plots.shown_chart").shown_chart(drawn, system_of(self.dataset))
