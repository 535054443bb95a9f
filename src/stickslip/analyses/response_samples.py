"""Response variability: the cloud of responses of one problem over start states that nothing but history tells apart."""

from __future__ import annotations

import time
from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Literal

import numpy as np
from scipy.stats import qmc
from threadpoolctl import threadpool_limits

from stickslip.analyses.cases import Progress
from stickslip.analyses.response_dataset import curve_arrays, response_dataset
from stickslip.checks import Array, InputError, fault, positive
from stickslip.harmonic.balance import HarmonicBalance
from stickslip.problem import Problem
from stickslip.solve.continuation import first_point
from stickslip.solve.curve import Curve, solve_curve
from stickslip.solve.start_space import Rule, Sharing, StartSpace, start_space
from stickslip.units import Band

if TYPE_CHECKING:
    import xarray as xr

Method = Literal["random", "latin", "corners"]
MOST_CORNERS = 12
"""Up to so many variables all 2ⁿ corners are taken; beyond, a seeded subset."""


@dataclass(frozen=True, eq=False)
class ResponseSamples:
    """One curve per start state: `dataset` as of a forced response, with case = sample, and start_value (case, element)."""

    dataset: xr.Dataset
    problem: Problem

    def plot(self, **options: Any) -> Any:
        """The figure of the cloud."""
        from stickslip.plots import plot

        return plot(self, **options)


def response_samples(
    problem: Problem,
    band: Band,
    force: float = 1.0,
    starts: int | Array = 20,
    *,
    method: Method = "latin",
    rule: Rule = "slider_offset",
    share: Sharing = "element",
    seed: int = 0,
    harmonics: int = 5,
    samples: int = 256,
    progress: Progress = lambda fraction, text: None,
) -> ResponseSamples:
    """Curves over a band for many start states, each kept along its curve.

    starts: how many to draw, or variables in [−1, 1] as an array (samples, variables); the first drawn one is virgin (zeros).
    rule: what a variable sets (see `stickslip.contact.start`); an offset of ±1 is the largest that is not clipped in the virgin
    solution. share: one variable per friction "element", per "direction", per "contact", or for "all".
    """
    positive("force", force)
    started = time.process_time()
    with threadpool_limits(1, user_api="blas"):
        balance = HarmonicBalance(problem, harmonics, samples)
        omegas = [2.0 * np.pi * band.start, 2.0 * np.pi * band.stop]
        space = problem_space(balance, omegas[0], force, rule, share)
        variables = draw(space.size, starts, method, seed)
        curves: list[Curve] = []
        for k, sample in enumerate(variables):
            progress(k / len(variables), f"start state {k + 1} of {len(variables)}")
            curves.append(solve_curve(space.balance(balance, sample), omegas, force, exactly=False))
        attrs = {"title": problem.title, "harmonics": harmonics, "samples": samples}
        attrs |= {"cpu_seconds": time.process_time() - started, "rule": rule, "share": share, "seed": seed}
        arrays = [curve_arrays(balance, curve) for curve in curves]
        dataset = response_dataset(balance, [force] * len(curves), arrays, (band.low, band.high), attrs)
    values = np.array([space.values(sample) for sample in variables])
    return ResponseSamples(with_starts(dataset, "case", variables, values), problem)


def problem_space(balance: HarmonicBalance, omega: float, level: float, rule: Rule, share: Sharing) -> StartSpace:
    """The start states of a problem, scaled by its virgin solution at a frequency."""
    virgin = first_point(balance.with_starts(np.zeros(balance.table.stiffness.size), 0), omega, level)
    if not virgin.converged:
        raise InputError(
            f"The virgin contact must have a solution at {omega / (2.0 * np.pi):g} Hz to scale the start states, but none was "
            "found. Start the band where contacts stick."
        )
    return start_space(balance, virgin.evaluation, rule, share)


def draw(size: int, starts: int | Array, method: Method = "latin", seed: int = 0) -> Array:
    """Start variables (samples, size) in [−1, 1]; a number draws them, the first one zero (virgin)."""
    if isinstance(starts, np.ndarray | Sequence):
        given = np.asarray(starts, dtype=float)
        if given.ndim != 2 or given.shape[1] != size or not np.all(np.abs(given) <= 1.0):
            raise fault("starts", f"must have shape (samples, {size}) and lie in [-1, 1]", given.shape)
        return given
    if starts < 1:
        raise fault("starts", "must be at least 1", starts)
    count = starts - 1
    rng = np.random.default_rng(seed)
    if method == "latin":
        drawn = 2.0 * qmc.LatinHypercube(size, rng=rng).random(count) - 1.0
    elif method == "random":
        drawn = rng.uniform(-1.0, 1.0, (count, size))
    elif method == "corners":
        drawn = _corners(rng, size, count)
    else:
        raise fault("method", "must be one of latin, random, corners", method)
    return np.vstack([np.zeros((1, size)), drawn])


def _corners(rng: np.random.Generator, size: int, count: int) -> Array:
    """All corners of the cube where they fit into `count`, else a seeded subset without repetition."""
    if size <= MOST_CORNERS:
        numbers = np.arange(2**size)
        numbers = numbers if len(numbers) <= count else np.sort(rng.choice(numbers, count, replace=False))
        return np.asarray(2.0 * ((numbers[:, None] >> np.arange(size)) & 1) - 1.0)
    return np.asarray(np.unique(rng.choice([-1.0, 1.0], (count, size)), axis=0))


def with_starts(dataset: xr.Dataset, axis: str, variables: Array, values: Array) -> xr.Dataset:
    """The dataset with the start states that made it."""
    dataset = dataset.assign(start_variable=((axis, "variable"), variables), start_value=((axis, "element"), values))
    dataset["start_variable"].attrs = {"units": "1", "long_name": "start variable in [-1, 1]"}
    dataset["start_value"].attrs = {"units": "SI", "long_name": "start value of each friction element"}
    return dataset
