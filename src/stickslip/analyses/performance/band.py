"""The band of a performance curve over the start states of the contacts: friction forces of stuck contacts are not unique, so
neither is the resonance, and one curve alone misleads.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import KW_ONLY, dataclass
from functools import cached_property
from typing import Annotated

import numpy as np
from numpy.typing import ArrayLike

from stickslip.analyses.arguments import (
    HarmonicNumbers,
    MeasureName,
    OfProblem,
    OutputNumber,
    QuantityName,
    Rule,
    Samples,
    Seed,
    Share,
    fineness_of,
    output_of,
    over_a_band,
    ratios_of,
)
from stickslip.analyses.performance.resonance_band import no_resonance, resonance_band
from stickslip.analyses.performance.scaled_problem import centrifugal_pull, excitation
from stickslip.analyses.performance.work import Pull
from stickslip.analyses.settings import Execution, Setting, Whole, takes
from stickslip.analyses.variability.bounds import BoundsWork
from stickslip.analyses.work_parts import Measured
from stickslip.model.problem import Problem
from stickslip.results.result import Result
from stickslip.runs.cases import all_cases
from stickslip.runs.work import Arrays
from stickslip.solve.balance.balance import HarmonicBalance
from stickslip.support.late import xr
from stickslip.support.renamed import renamed_arguments
from stickslip.support.units import Band


@dataclass(frozen=True, eq=False, repr=False)
class PerformanceBand(Result):
    """`dataset`: amplitude_per_force, frequency [Hz] and loss_factor of the lowest and the highest peak, axes (point,
    bound); virgin_amplitude_per_force and solves by point.
    """

    dataset: xr.Dataset
    problem: Problem


@dataclass(frozen=True, eq=False)
class BandSettings(Measured, Execution):
    """What a performance band is searched for by: bounds of the peak, at the force levels of values of F_C/F_E."""

    problem: OfProblem
    force_ratio: Annotated[ArrayLike, Setting(ratios_of, "[low, high] of F_C/F_E")]
    _: KW_ONLY
    band: Annotated[Band | None, Setting(over_a_band)] = None
    pull: Pull = None
    output: OutputNumber = 0
    quantity: QuantityName = "displacement"
    measure: MeasureName = "amplitude"
    cloud: Annotated[int, Setting(Whole(0), "number of start states sampled at each value")] = 20
    starts: Annotated[int, Setting(Whole(0), "number of the best of these states, from each of which a search begins")] = 2
    rule: Rule = "slider_offset"
    share: Share = "contact"
    seed: Seed = 0
    harmonics: HarmonicNumbers = 5
    samples: Samples = 256

    def __post_init__(self) -> None:
        super().__post_init__()
        output_of(self.problem, self.output)
        fineness_of(self.harmonics, self.samples)

    @property
    def ratios(self) -> tuple[float, ...]:
        """Values of F_C/F_E, ascending."""
        return ratios_of("force_ratio", self.force_ratio)

    @cached_property
    def bounds(self) -> BoundsWork:
        """Its cases. That amplitudes are per force goes without saying."""
        own = centrifugal_pull(self.problem) if self.pull is None else self.pull
        unit = excitation(self.problem)
        balance = HarmonicBalance(self.problem, self.harmonics, self.samples)
        return BoundsWork(
            self.problem,
            self.band or resonance_band(balance, self.output),
            [own / (ratio * unit) for ratio in self.ratios],
            "peak",
            output=self.output,
            quantity=self.measured.quantity.name,
            measure=self.measure,
            cloud=self.cloud,
            starts=self.starts,
            rule=self.rule,
            share=self.share,
            seed=self.seed,
            harmonics=self.harmonics,
            samples=self.samples,
        )


@renamed_arguments(finished="checkpoint")
@takes(BandSettings)
def performance_band(work: BandSettings) -> PerformanceBand:
    """Lowest and highest resonance peak over all start states at values of F_C/F_E; the excitation is varied.

    The search is that of `response_bounds` with objective "peak": cloud, starts, rule, share and seed are its arguments.
    quantity, measure: what the peaks are of, as for `forced_response`; `amplitude_per_force` is in m/N, m/(s N) or m/(s² N).
    """
    results = all_cases(work.bounds, work.checkpoint, work.workers, work.progress)
    return PerformanceBand(band_dataset(work, results), work.problem)


def band_dataset(asked: BandSettings, results: Sequence[Arrays]) -> xr.Dataset:
    """Bounds of the peak as a band over F_C/F_E."""
    work = asked.bounds
    bounds, unit = work.gathered(results), excitation(work.problem)
    if not np.isfinite(bounds["amplitude"].values).any():
        ends = (min(work.frequencies), max(work.frequencies))
        raise no_resonance(work.balance, work.output, ends, " at one of the values of F_C/F_E")
    force = unit * bounds["force_level"].values[:, None]
    at_peak = bounds.isel(frequency=0)
    per_force = at_peak["amplitude"].values / force
    virgin = at_peak["sampled_amplitude"].isel(start=0).values / force[:, 0]
    units = work.measured.quantity.units_per_force
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
        "force_ratio": ("point", list(asked.ratios), {"units": "1", "long_name": "F_C/F_E"}),
        "bound": ("bound", bounds["bound"].values, {"units": "1", "long_name": "lowest and highest peak"}),
    }
    keys = ("title", "output", *work.measured.attributes, "rule", "share", "seed", "cloud", "starts", "harmonics", "samples")
    keys = (*keys, "cpu_seconds")
    return xr.Dataset(data, coords, {key: bounds.attrs[key] for key in keys})
