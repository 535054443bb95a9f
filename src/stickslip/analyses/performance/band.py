"""The band of a performance curve over the start states of the contacts: friction forces of stuck contacts are not unique, so
neither is the resonance, and one curve alone misleads.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike

from stickslip.analyses.arguments import ends_of, fineness_of, output_of, ratios_of
from stickslip.analyses.performance.resonance_band import no_resonance, resonance_band
from stickslip.analyses.performance.scaled_problem import centrifugal_pull, excitation
from stickslip.analyses.variability.bounds_work import BoundsWork
from stickslip.checks import positive
from stickslip.harmonic.balance import HarmonicBalance
from stickslip.harmonic.measure import Measure, measure_of
from stickslip.problem import Problem
from stickslip.renamed import renamed_arguments
from stickslip.results.result import Result
from stickslip.runs.cases import all_cases
from stickslip.runs.work import Arrays, Checkpoint, Progress, Workers
from stickslip.starts.space import Rules, Sharing
from stickslip.units import Band

if TYPE_CHECKING:
    import xarray as xr


@dataclass(frozen=True, eq=False, repr=False)
class PerformanceBand(Result):
    """`dataset`: amplitude_per_force, frequency [Hz] and loss_factor of the lowest and the highest peak, axes (point,
    bound); virgin_amplitude_per_force and solves by point.
    """

    dataset: xr.Dataset
    problem: Problem


@renamed_arguments(finished="checkpoint")
def performance_band(
    problem: Problem,
    force_ratio: ArrayLike,
    *,
    band: Band | None = None,
    pull: float | None = None,
    output: int = 0,
    quantity: str = "displacement",
    measure: str = "amplitude",
    cloud: int = 20,
    starts: int = 2,
    rule: Rules = "slider_offset",
    share: Sharing = "contact",
    seed: int = 0,
    harmonics: int | Sequence[int] = 5,
    samples: int = 256,
    workers: Workers = 1,
    checkpoint: Checkpoint | None = None,
    progress: Progress = lambda fraction, text: None,
) -> PerformanceBand:
    """Lowest and highest resonance peak over all start states at values of F_C/F_E; the excitation is varied.

    The search is that of `response_bounds` with objective "peak": cloud, starts, rule, share and seed are its arguments.
    quantity, measure: what the peaks are of, as for `forced_response`; `amplitude_per_force` is in m/N, m/(s N) or m/(s² N).
    """
    row, ratios, (H, Nt) = output_of(problem, output), ratios_of("force_ratio", force_ratio), fineness_of(harmonics, samples)
    work = BoundsWork(
        problem,
        frequencies=ends_of(resonance_band(HarmonicBalance(problem, H, Nt), row) if band is None else band),
        levels=force_levels(problem, ratios, pull),
        objective="peak",
        output=row,
        cloud=cloud,
        starts=starts,
        rule=rule,
        share=share,
        seed=seed,
        harmonics=H,
        samples=Nt,
        measure=peak_per_force(quantity, measure),
    )
    return PerformanceBand(band_dataset(work, ratios, all_cases(work, checkpoint, workers, progress)), problem)


def peak_per_force(quantity: str, measure: str) -> Measure:
    """The measure of the arguments; that it is per force goes without saying in a performance band."""
    return replace(measure_of(quantity, measure), per_force=False)


def force_levels(problem: Problem, ratios: Sequence[float], pull: float | None = None) -> tuple[float, ...]:
    """The levels of the excitation at values of F_C/F_E. pull: F_C, N; that of the problem unless given."""
    own = centrifugal_pull(problem) if pull is None else positive("pull", pull)
    unit = excitation(problem)
    return tuple(own / (ratio * unit) for ratio in ratios)


def band_dataset(work: BoundsWork, ratios: Sequence[float], results: Sequence[Arrays]) -> xr.Dataset:
    """Bounds of the peak as a band over F_C/F_E."""
    import xarray as xr

    bounds, unit = work.gathered(results), excitation(work.problem)
    if not np.isfinite(bounds["amplitude"].values).any():
        ends = (min(work.frequencies), max(work.frequencies))
        raise no_resonance(work.balance, work.output, ends, " at one of the values of F_C/F_E")
    force = unit * bounds["force_level"].values[:, None]
    at_peak = bounds.isel(frequency=0)
    per_force = at_peak["amplitude"].values / force
    virgin = at_peak["sampled_amplitude"].isel(start=0).values / force[:, 0]
    units = work.measure.quantity.units_per_force
    data = {
        "amplitude_per_force": (("point", "bound"), per_force, {"units": units, "long_name": "peak per force"}),
        "frequency": (("point", "bound"), at_peak["resonance"].values, {"units": "Hz", "long_name": "resonance frequency"}),
        "virgin_amplitude_per_force": ("point", virgin, {"units": units, "long_name": "peak per force, virgin start"}),
        "loss_factor": (("point", "bound"), at_peak["loss_factor"].values, {"units": "1", "long_name": "loss factor"}),
        "outcome": (("point", "bound"), at_peak["outcome"].values, {"units": "1", "long_name": "outcome of the search"}),
        "unsolved_share": (
            "point",
            at_peak["unsolved_share"].values,
            {"units": "1", "long_name": "share of the sampled start states without a solution"},
        ),
        "solves": ("point", at_peak["solves"].values, {"units": "1", "long_name": "solutions computed"}),
    }
    coords = {
        "force_ratio": ("point", list(ratios), {"units": "1", "long_name": "F_C/F_E"}),
        "bound": ("bound", bounds["bound"].values, {"units": "1", "long_name": "lowest and highest peak"}),
    }
    keys = ("title", "output", *work.measure.attributes, "rule", "share", "seed", "cloud", "starts", "harmonics", "samples")
    keys = (*keys, "cpu_seconds")
    return xr.Dataset(data, coords, {key: bounds.attrs[key] for key in keys})
