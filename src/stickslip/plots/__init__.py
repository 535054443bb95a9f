"""Figures of results. `plot(result)` looks up the figure by the class name of the result.

matplotlib is imported when a figure is drawn, not before.
"""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING, Any

from stickslip.checks import fault, nearest

if TYPE_CHECKING:
    from matplotlib.figure import Figure

FIGURES = {
    "ForcedResponse": "stickslip.plots.forced_response:response_curves",
    "ResponseSamples": "stickslip.plots.response_samples:response_cloud",
    "ResponseBounds": "stickslip.plots.response_bounds:response_bounds",
    "ResponseHistory": "stickslip.plots.response_history:before_and_after",
    "FrictionFreedom": "stickslip.plots.friction_freedom:freedom",
    "NodalDiameters": "stickslip.plots.disk:nodal_diameter_diagram",
    "ContactStiffness": "stickslip.plots.contact_stiffness:stiffness_over_load",
    "PerformanceBand": "stickslip.plots.performance_curve:performance_band",
    "DamperDesign": "stickslip.plots.design:design_space",
    "SensitivityIndices": "stickslip.plots.sensitivity_indices:tornado",
    "PerformanceCurve": "stickslip.plots.performance_curve:performance_curves",
    "MistunedPopulation": "stickslip.plots.mistuning:all_blades",
    "DamperCycle": "stickslip.plots.damper_cycle:damper_cycle",
    "SteadyCycles": "stickslip.plots.damper_cycles:damper_cycles",
    "DamperEvolution": "stickslip.plots.damper_cycles:damper_cycles",
    "TimeResponse": "stickslip.plots.time_response:last_period",
    "Identification": "stickslip.plots.identification:loops_and_fit",
    "LawChoice": "stickslip.plots.identification:law_loops",
    "Dataset": "stickslip.plots.forced_response:response_curves",
}
"""Class of a result: module and function that draws it. A new analysis adds its line here."""

MORE: dict[str, dict[str, str]] = {
    "Identification": {
        "residuals": "stickslip.plots.identification:residuals",
        "posterior": "stickslip.plots.identification:posterior",
    },
    "ResponseSamples": {"percentiles": "stickslip.plots.response_percentiles:response_percentiles"},
    "ResponseBounds": {
        "loss_factors": "stickslip.plots.response_bounds:loss_factors",
        "start_states": "stickslip.plots.response_bounds:start_states",
        "contact_forces": "stickslip.plots.bound_cycles:contact_forces",
        "force_ratios": "stickslip.plots.bound_cycles:force_ratios",
        "loops": "stickslip.plots.bound_cycles:loops",
        "force_plane": "stickslip.plots.force_plane:force_plane",
    },
    "MistunedPopulation": {
        "amplification": "stickslip.plots.mistuning:amplification",
        "worst_blade": "stickslip.plots.mistuning:worst_blade",
    },
}
"""Further figures of a result by name: `result.plot(figure="loops")`."""


def plot(result: Any, figure: str = "", **options: Any) -> Figure:
    """The figure of a result, or a further one by its name in `MORE`; options are those of its function."""
    kind = next((kind.__name__ for kind in type(result).__mro__ if kind.__name__ in FIGURES), None)
    if kind is None:
        raise fault("The result", f"must be one of {', '.join(FIGURES)}", type(result).__name__)
    named = {"": FIGURES[kind]} | MORE.get(kind, {})
    if figure not in named:
        raise fault("figure", "must be a known one", figure, nearest(figure, MORE.get(kind, {})))
    module, function = named[figure].split(":")
    drawn: Figure = getattr(import_module(module), function)(getattr(result, "dataset", result), **options)
    return drawn
