"""Bounds of response variability: the highest and lowest response over all admissible start states.

At every frequency the amplitude itself is maximised and minimised, or the loss factor as its proxy; or the resonance peak, which
is what a designer needs: at a fixed frequency the lowest response is often only a resonance moved elsewhere.

The loss factor is the objective of "An Experimental and Computational Comparison of the Dynamic Response Variability in a
Turbine Blade with Under-Platform Dampers", equations 7 to 11.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

from stickslip.analyses.settings import takes
from stickslip.analyses.variability.bounds_work import BoundsWork
from stickslip.model.problem import Problem
from stickslip.results.result import Result
from stickslip.runs.cases import all_cases
from stickslip.support.renamed import renamed_arguments

if TYPE_CHECKING:
    import xarray as xr


@dataclass(frozen=True, eq=False, repr=False)
class ResponseBounds(Result):
    """`dataset`: amplitude, loss_factor, resonance, start states and contact forces by (case, bound, frequency), one case per
    force level; sampled_amplitude (case, start, frequency): the cloud that the search began with; unsolved_share (case,
    frequency): how much of it has no solution; solves spent. Where most has none, `outcome` says so and there are no bounds.

    For the peak there is one entry along frequency, and `resonance` says where the peak is.
    """

    dataset: xr.Dataset
    problem: Problem


@renamed_arguments(finished="checkpoint")
@takes(BoundsWork)
def response_bounds(work: BoundsWork) -> ResponseBounds:
    """Highest and lowest response over the start states, at each frequency or at the peak, for one or several force levels.

    band: a `Band`, with `points` frequencies spread over it (for the peak: continued over), or frequencies in Hz.
    objective: "amplitude" of the output; "loss_factor", least for the upper and largest for the lower bound; "peak", the
    amplitude at the resonance. quantity, measure: what the amplitude is of, as for `forced_response`.
    cloud: start states sampled at every frequency, half of them corners; the `starts` best begin a search each, besides the
    virgin state and the optima of neighbouring frequencies, or force levels for the peak; leaps from what was found follow.
    rule: what a start variable sets, "slider_offset", "traction_ratio" or "mean_traction", or one for each tangential direction
    t1, t2: ("traction_ratio", "virgin") varies the ratio in the plane of a damper and leaves the sliders along its axis, where
    only friction holds it, at rest at 0.
    share: one variable per friction "element", per "direction", per "contact", or for "all" with the same rule.
    Gradients are exact; extremes are multimodal, so a bound is the best found.
    """
    return ResponseBounds(work.gathered(all_cases(work, work.checkpoint, work.workers, work.progress)), work.problem)
