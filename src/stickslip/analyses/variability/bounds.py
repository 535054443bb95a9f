"""Bounds of response variability: the highest and lowest response over all admissible start states.

At every frequency the amplitude itself is maximised and minimised, or the loss factor as its proxy; or the resonance peak, which
is what a designer needs: at a fixed frequency the lowest response is often only a resonance moved elsewhere.

The loss factor is the objective of "An Experimental and Computational Comparison of the Dynamic Response Variability in a
Turbine Blade with Under-Platform Dampers", equations 7 to 11.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from stickslip.analyses.forced_response import force_levels
from stickslip.analyses.variability.bounds_work import BoundsWork, Target
from stickslip.checks import Array, between, fault, of_kind
from stickslip.harmonic.measure import measure_of
from stickslip.problem import Problem
from stickslip.renamed import renamed_arguments
from stickslip.results.result import Result
from stickslip.runs.cases import all_cases
from stickslip.runs.work import Checkpoint, Progress, Workers
from stickslip.starts.space import Rules, Sharing
from stickslip.units import Band, listed

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
def response_bounds(
    problem: Problem,
    band: Band | Sequence[float],
    force: float | Sequence[float] = 1.0,
    objective: Target = "amplitude",
    *,
    output: int = 0,
    quantity: str = "displacement",
    measure: str = "amplitude",
    points: int = 25,
    cloud: int = 60,
    starts: int = 3,
    rule: Rules = "slider_offset",
    share: Sharing = "element",
    seed: int = 0,
    harmonics: int | Sequence[int] = 5,
    samples: int = 256,
    workers: Workers = 1,
    checkpoint: Checkpoint | None = None,
    progress: Progress = lambda fraction, text: None,
) -> ResponseBounds:
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
    of_kind("problem", problem, Problem)
    levels = force_levels(force)
    frequencies = tuple(float(frequency) for frequency in _frequencies(band, points))
    if objective == "peak" and len(frequencies) < 2:
        raise fault("band", "must be a band for the peak", band)
    work = BoundsWork(
        problem,
        frequencies=frequencies,
        levels=levels,
        objective=objective,
        output=output,
        cloud=cloud,
        starts=starts,
        rule=rule,
        share=share,
        seed=seed,
        harmonics=harmonics,
        samples=samples,
        measure=measure_of(quantity, measure),
    )
    return ResponseBounds(work.gathered(all_cases(work, checkpoint, workers, progress)), problem)


def _frequencies(band: Band | Sequence[float], points: int) -> Array:
    if isinstance(band, Band):
        return np.linspace(band.low, band.high, between("points", points, 2))
    return np.array(sorted(listed(band)))
