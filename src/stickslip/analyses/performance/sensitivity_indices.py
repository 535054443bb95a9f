"""Sobol' sensitivity indices: the share of the variance of peak amplitude and frequency that each uncertain parameter causes.

Variance-based indices of Sobol', with all parameters uniform in their ranges, and slopes at the middle.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from stickslip.analyses.performance.sampled_peaks import DrawsWork
from stickslip.analyses.response_dataset import levels_are_newtons
from stickslip.analyses.settings import takes
from stickslip.results.result import Result
from stickslip.runs.cases import all_cases
from stickslip.runs.work import Arrays
from stickslip.solve.balance.orders import attribute
from stickslip.support.checks import Array
from stickslip.support.renamed import renamed_arguments

if TYPE_CHECKING:
    import xarray as xr

RESAMPLES = 300
"""Bootstrap samples of the draws, for the intervals of the indices."""

QUANTITIES = ("peak amplitude", "peak frequency")


@dataclass(frozen=True, eq=False, repr=False)
class SensitivityIndices(Result):
    """`dataset`, axes (parameter, quantity): first_order and total indices of Sobol'; low_end and high_end: the quantity at both
    ends of a range, the others in the middle; spread: its standard deviation; slope: d ln(amplitude) over the range by the slope
    in the middle. first_order_interval, total_interval (.., 2): what 95 % of bootstrap samples of the draws give.
    """

    dataset: xr.Dataset


@renamed_arguments(finished="checkpoint")
@takes(DrawsWork)
def sensitivity_indices(work: DrawsWork) -> SensitivityIndices:
    """Sobol' indices of the highest peak and its frequency, and its slopes, by parameters in ranges.

    problem_of(**values) makes the problem; with several `workers` it must be a function of a module. parameters: {name: (low,
    high)}, anything the problem depends on: kt, kn, μ, preload, or a start state (a slider offset in m). draws: a power of two;
    draws (parameters + 2) problems are solved, each from the nearest one known. quantity, measure: what the peak is of, as for
    `forced_response`. d ln(amplitude) at the middle is by differences of
    fourth order between solved peaks at the ends of the range and of its middle half; samples put an error of up to about
    60/samples² into it (0.001 at 256).
    Source: A. Saltelli et al., Computer Physics Communications 181 (2010) 259, as in `scipy.stats.sobol_indices`.
    """
    return SensitivityIndices(gathered(work, all_cases(work, work.checkpoint, work.workers, work.progress)))


def gathered(work: DrawsWork, results: Sequence[Arrays]) -> xr.Dataset:
    """Indices, ends and slopes as one labelled dataset."""
    import xarray as xr

    shown = np.array([1.0 / work.measured.per(work.force), 1.0])
    first, drawn = results[0], np.concatenate([result["peaks"] for result in results[1:]])
    first = {**first, "middle": shown * first["middle"], "ends": shown * first["ends"]}
    cpu_seconds = sum(float(result["cpu_seconds"]) for result in results)
    drawn = shown * drawn

    def described(dims: Any, values: Any, unit: str, words: str) -> tuple[Any, Any, dict[str, str]]:
        return dims, values, {"units": unit, "long_name": words}

    middle = work.problem(np.mean(work.box, axis=1))
    units = f"{work.measured.reported_units(levels_are_newtons(middle))} and Hz"
    both, (low, high), ends = ("parameter", "quantity"), np.array(work.box).T, first["ends"]
    orders, intervals, spread = _indices(drawn), _intervals(drawn, work.seed), np.std(drawn[:, :2], axis=(0, 1))
    bounds, interval = (*both, "bound"), "what 95 % of bootstrap samples of the draws give for the"
    data = {
        "first_order": described(both, orders[0], "1", "first-order index: share of the variance by this parameter alone"),
        "total": described(both, orders[1], "1", "total index: with its interactions"),
        "first_order_interval": described(bounds, intervals[0], "1", f"{interval} first-order index"),
        "total_interval": described(bounds, intervals[1], "1", f"{interval} total index"),
        "low_end": described(both, ends[:, 0], units, "at the low end of the range, the others in the middle"),
        "high_end": described(both, ends[:, 1], units, "at the high end of the range, the others in the middle"),
        "middle": described("quantity", first["middle"], units, "all parameters in the middle"),
        "spread": described("quantity", spread, units, "standard deviation over all parameters"),
        "slope": described("parameter", first["slopes"], "1", "d ln(amplitude) over the range, by the slope in the middle"),
        "low": described("parameter", low, "as given", "low end of the range"),
        "high": described("parameter", high, "as given", "high end of the range"),
    }
    coords = {
        "parameter": described("parameter", list(work.parameters), "1", "uncertain parameter"),
        "quantity": described("quantity", list(QUANTITIES), "1", "quantity"),
        "bound": described("bound", ["low", "high"], "1", "end of an interval"),
    }
    attrs: dict[str, Any] = {"title": "Which parameter matters", "cpu_seconds": cpu_seconds}
    attrs |= {key: getattr(work, key) for key in ("force", "draws", "seed", "samples")} | work.measured.attributes
    attrs["harmonics"] = attribute(work.harmonics)
    return xr.Dataset(data, coords, attrs)


def _indices(drawn: Array) -> Array:
    """First-order and total indices (2, parameters, quantities) of peaks (draws, parameters + 2, quantities)."""
    from scipy.stats import sobol_indices

    f_A, f_B, *f_AB = np.moveaxis(drawn, 0, -1)
    found = sobol_indices(func={"f_A": f_A, "f_B": f_B, "f_AB": np.array(f_AB)}, n=len(drawn))
    return np.array([np.reshape(order, (*f_A.shape[:1], -1)).T for order in (found.first_order, found.total_order)])


def _intervals(drawn: Array, seed: int) -> Array:
    """The middle 95 % (2, parameters, quantities, 2) of the indices of draws drawn from these draws: how rough few draws are."""
    rng = np.random.default_rng(seed)
    again = [_indices(drawn[rng.integers(len(drawn), size=len(drawn))]) for _ in range(RESAMPLES)]
    return np.moveaxis(np.percentile(again, (2.5, 97.5), axis=0), 0, -1)
