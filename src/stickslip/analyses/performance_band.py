"""The band of a performance curve over the start states of the contacts: friction forces of stuck contacts are not unique, so
neither is the resonance, and one curve alone misleads.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike

from stickslip.analyses.cases import Finished, Progress, Workers
from stickslip.analyses.performance_work import OUTSIDE
from stickslip.analyses.response_bounds import response_bounds
from stickslip.analyses.scaled_problem import centrifugal_pull, excitation
from stickslip.checks import positive
from stickslip.harmonic.balance import HarmonicBalance
from stickslip.problem import Problem
from stickslip.solve.linear_peak import linear_peak
from stickslip.solve.start_space import Rule, Sharing
from stickslip.units import Band

if TYPE_CHECKING:
    import xarray as xr


@dataclass(frozen=True, eq=False)
class PerformanceBand:
    """`dataset`: amplitude_per_force [m/N] and frequency [Hz] of the lowest and the highest peak, axes (point, bound)."""

    dataset: xr.Dataset
    problem: Problem

    def plot(self, **options: Any) -> Any:
        """The figure of the band."""
        from stickslip.plots import plot

        return plot(self, **options)


def performance_band(
    problem: Problem,
    force_ratio: ArrayLike,
    *,
    band: Band | None = None,
    pull: float | None = None,
    output: int = 0,
    cloud: int = 20,
    starts: int = 2,
    rule: Rule = "slider_offset",
    share: Sharing = "contact",
    seed: int = 0,
    harmonics: int = 5,
    samples: int = 256,
    workers: Workers = 1,
    finished: Finished | None = None,
    progress: Progress = lambda fraction, text: None,
) -> PerformanceBand:
    """Lowest and highest resonance peak over all start states at values of F_C/F_E; the excitation is varied.

    The search is that of `response_bounds` with objective "peak": cloud, starts, rule, share and seed are its arguments.
    """
    ratios = sorted({positive("force_ratio", value) for value in np.atleast_1d(np.asarray(force_ratio, dtype=float))})
    own = centrifugal_pull(problem) if pull is None else positive("pull", pull)
    unit = excitation(problem)
    levels = [own / (ratio * unit) for ratio in ratios]
    search: dict[str, Any] = {"cloud": cloud, "starts": starts, "rule": rule, "share": share, "seed": seed, "output": output}
    found = response_bounds(
        problem,
        band or resonance_band(problem, output, harmonics, samples),
        levels,
        "peak",
        **search,
        harmonics=harmonics,
        samples=samples,
        workers=workers,
        finished=finished,
        progress=progress,
    )
    return PerformanceBand(_dataset(found.dataset, ratios, unit), problem)


def resonance_band(problem: Problem, output: int, harmonics: int, samples: int) -> Band:
    """A band that holds the free and the stuck resonance of an output."""
    balance = HarmonicBalance(problem, harmonics, samples)
    peaks = [linear_peak(balance, output, stuck).frequency for stuck in (False, True)]
    return Band(OUTSIDE[0] * min(peaks), OUTSIDE[1] * max(peaks))


def _dataset(bounds: xr.Dataset, ratios: list[float], unit: float) -> xr.Dataset:
    import xarray as xr

    force = unit * bounds["force_level"].values[:, None]
    at_peak = bounds.isel(frequency=0)
    per_force = at_peak["amplitude"].values / force
    virgin = at_peak["sampled_amplitude"].isel(start=0).values / force[:, 0]
    data = {
        "amplitude_per_force": (("point", "bound"), per_force, {"units": "m/N", "long_name": "peak per force"}),
        "frequency": (("point", "bound"), at_peak["resonance"].values, {"units": "Hz", "long_name": "resonance frequency"}),
        "virgin_amplitude_per_force": ("point", virgin, {"units": "m/N", "long_name": "peak per force, virgin start"}),
        "solves": ("point", at_peak["solves"].values, {"units": "1", "long_name": "solutions computed"}),
    }
    coords = {
        "force_ratio": ("point", ratios, {"units": "1", "long_name": "F_C/F_E"}),
        "bound": bounds["bound"].values,
    }
    keys = ("title", "output", "rule", "share", "seed", "cloud", "starts", "harmonics", "samples", "cpu_seconds")
    return xr.Dataset(data, coords, {key: bounds.attrs[key] for key in keys})
