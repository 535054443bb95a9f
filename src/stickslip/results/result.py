"""What the results of all analyses have in common: sentences and figures, made when they are asked for."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

from stickslip.support.checks import InputError, fault, nearest
from stickslip.support.renderers import FIGURES, SENTENCES

if TYPE_CHECKING:
    from matplotlib.figure import Figure


class Result:
    """A result with figures: those that `show/plots` registers for the name of its class, `@FIGURES.of("Curve", "loops")`.

    That without a name is the figure of `plot()`. Functions get the `dataset` of a result, or a result without one, and return a
    chart, or a matplotlib figure that is a drawing.
    """

    def __repr__(self) -> str:
        return "\n".join(SENTENCES.known("Result")[""](self))

    def _repr_html_(self) -> str:
        """What a notebook shows: what came out in sentences, and the figure of `plot()`."""
        page: str = SENTENCES.known("Result")["page"](self)
        return page

    @property
    def figures(self) -> tuple[str, ...]:
        """The names that `plot` takes; "" is the usual figure."""
        return tuple(FIGURES.known(type(self).__name__))

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
        known = FIGURES.known(type(self).__name__)
        if figure not in known:
            raise fault("figure", "must be a known one", figure, nearest(str(figure), filter(None, known)))
        drawn = known[figure](getattr(self, "dataset", self), **options)
        return FIGURES.known("Result")["in the units of the study"](drawn, self)
