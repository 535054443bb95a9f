"""Figures of results. `plot(result)` finds the figure of a result by the name of its class: the one late binding of the package.

matplotlib is imported when a figure is drawn, not before.
"""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING, Any

from stickslip.checks import fault

if TYPE_CHECKING:
    from matplotlib.figure import Figure

FIGURES = {
    "ForcedResponse": "stickslip.plots.forced_response:response_curves",
    "ResponseSamples": "stickslip.plots.response_samples:response_cloud",
    "ResponseBounds": "stickslip.plots.response_bounds:response_bounds",
    "ResponseHistory": "stickslip.plots.response_history:before_and_after",
    "FrictionFreedom": "stickslip.plots.friction_freedom:freedom",
    "ContactStiffness": "stickslip.plots.contact_stiffness:stiffness_over_load",
    "PerformanceCurve": "stickslip.plots.performance_curve:performance_curves",
    "Dataset": "stickslip.plots.forced_response:response_curves",
}
"""Class of a result: module and function that draws it. A new analysis adds its line here."""


def plot(result: Any, **options: Any) -> Figure:
    """The figure of a result; options are those of its function."""
    for kind in type(result).__mro__:
        if kind.__name__ in FIGURES:
            module, function = FIGURES[kind.__name__].split(":")
            figure: Figure = getattr(import_module(module), function)(getattr(result, "dataset", result), **options)
            return figure
    raise fault("The result", f"must be one of {', '.join(FIGURES)}", type(result).__name__)
