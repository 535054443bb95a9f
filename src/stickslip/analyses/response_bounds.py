"""The bounds of response variability: highest and lowest response over all admissible start states.

At every frequency the amplitude itself is maximised and minimised, or, as S4 (equations 7 to 11) does, the loss factor as its
proxy; or the resonance peak, which is what a designer needs: at a fixed frequency the lowest response is often only a
resonance moved elsewhere.
"""

from __future__ import annotations

import time
from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Literal

import numpy as np
from threadpoolctl import threadpool_limits

from stickslip.analyses.cases import Progress
from stickslip.analyses.response_samples import draw, problem_space
from stickslip.checks import Array, fault, positive
from stickslip.harmonic.balance import HarmonicBalance
from stickslip.harmonic.cycle import contact_cycle
from stickslip.harmonic.energy import EnergyBalance
from stickslip.problem import Problem
from stickslip.solve.extremes import AtFrequency, AtPeak, Extreme, UnsolvedError, amplitude, extreme, loss_factor
from stickslip.solve.start_space import Rule, Sharing, StartSpace
from stickslip.units import Band

if TYPE_CHECKING:
    import xarray as xr

Target = Literal["amplitude", "loss_factor", "peak"]
BOUNDS = ("lower", "upper")


@dataclass(frozen=True, eq=False)
class ResponseBounds:
    """`dataset`: amplitude, loss_factor and start states by (bound, frequency), or by (bound,) for the peak; solves spent.

    sampled_amplitude (sample, frequency): the cloud the search started from, for comparison.
    """

    dataset: xr.Dataset
    problem: Problem

    def plot(self, **options: Any) -> Any:
        """The figure of the bounds."""
        from stickslip.plots import plot

        return plot(self, **options)


def response_bounds(
    problem: Problem,
    band: Band | Sequence[float],
    force: float = 1.0,
    objective: Target = "amplitude",
    *,
    output: int = 0,
    points: int = 25,
    cloud: int = 10,
    starts: int = 2,
    rule: Rule = "slider_offset",
    share: Sharing = "element",
    seed: int = 0,
    harmonics: int = 5,
    samples: int = 256,
    progress: Progress = lambda fraction, text: None,
) -> ResponseBounds:
    """Highest and lowest response over the start states, at each frequency or at the peak.

    band: a `Band`, with `points` frequencies spread over it (for the peak: continued over), or frequencies in Hz.
    objective: "amplitude" |X_1| of the output; "loss_factor", least for the upper and largest for the lower bound (S4);
    "peak" |X_1| at the resonance. cloud: sampled start states at every frequency; `starts` best of them begin a search each,
    besides the virgin state and the optimum of the frequency before. Gradients are exact; extremes are multimodal, so a bound
    is the best found.
    """
    positive("force", force)
    if objective not in ("amplitude", "loss_factor", "peak"):
        raise fault("objective", "must be amplitude, loss_factor or peak", objective)
    if not 0 <= output < len(problem.outputs):
        raise fault("output", f"must be 0 to {len(problem.outputs) - 1}", output)
    frequencies = _frequencies(band, points)
    started = time.process_time()
    with threadpool_limits(1, user_api="blas"):
        balance = HarmonicBalance(problem, harmonics, samples)
        space = problem_space(balance, 2.0 * np.pi * frequencies[0], force, rule, share)
        search = _Search(balance, space, output, force, draw(space.size, cloud + 1, "latin", seed), starts)
        if objective == "peak":
            dataset = search.peak((2.0 * np.pi * min(frequencies), 2.0 * np.pi * max(frequencies)), progress)
        else:
            dataset = search.band(frequencies, objective, progress)
    attrs = {"title": problem.title, "objective": objective, "rule": rule, "share": share, "seed": seed, "force": force}
    attrs |= {"harmonics": harmonics, "samples": samples, "cpu_seconds": time.process_time() - started}
    return ResponseBounds(dataset.assign_attrs(attrs), problem)


def _frequencies(band: Band | Sequence[float], points: int) -> Array:
    if isinstance(band, Band):
        return np.linspace(band.low, band.high, max(points, 2))
    return np.array(sorted({positive("A frequency", frequency) for frequency in band}))


class _Search:
    """One search: the problem, its start space, the cloud of start states it may begin from."""

    def __init__(self, balance: HarmonicBalance, space: StartSpace, output: int, level: float, cloud: Array, starts: int) -> None:
        self.balance, self.space, self.output, self.level = balance, space, output, level
        self.cloud, self.starts = cloud, starts
        self.energy = EnergyBalance(balance)

    def band(self, frequencies: Array, objective: Target, progress: Progress) -> xr.Dataset:
        """Bounds at every frequency; a search starts from the optimum before it, the virgin state and the best of the cloud."""
        best: dict[float, Array] = {}
        found: list[list[Extreme | None]] = [[], []]
        sampled = np.full((len(self.cloud), len(frequencies)), np.nan)
        solves = np.zeros(len(frequencies))
        for k, frequency in enumerate(frequencies):
            progress(k / len(frequencies), f"{frequency:.4g} Hz")
            target = loss_factor(self.energy) if objective == "loss_factor" else amplitude(self.output)
            place = AtFrequency(self.balance, self.space, target, 2.0 * np.pi * frequency, self.level)
            values = self._cloud(place, sampled[:, k])
            for bound, sign in enumerate((-1.0, 1.0)):
                toward = -sign if objective == "loss_factor" else sign
                begins = [best[sign]] if sign in best else []
                result = self._extreme(place, toward, [*begins, *self._promising(values, toward)])
                found[bound].append(result)
                if result is not None:
                    best[sign] = result.variables
            solves[k] = place.solves
        return self._dataset(frequencies, found, sampled, solves)

    def peak(self, band: tuple[float, float], progress: Progress) -> xr.Dataset:
        """The highest and the lowest resonance peak."""
        place = AtPeak(self.balance, self.space, self.output, band, self.level)
        values = np.full(len(self.cloud), np.nan)
        for k, variables in enumerate(self.cloud):
            progress(0.5 * k / len(self.cloud), f"peak of start state {k + 1}")
            try:
                values[k] = place.value(variables)[0]
            except UnsolvedError:
                continue
        found: list[list[Extreme | None]] = []
        for k, sign in enumerate((-1.0, 1.0)):
            progress(0.5 + 0.25 * k, f"{BOUNDS[k]} bound of the peak")
            found.append([self._extreme(place, sign, self._promising(values, sign))])
        return self._dataset(np.array([np.nan]), found, values[:, None], np.array([place.solves]))

    def _cloud(self, place: AtFrequency, amplitudes: Array) -> Array:
        """Objective of every start state of the cloud at a frequency; fills their amplitudes."""
        values = np.full(len(self.cloud), np.nan)
        for k, variables in enumerate(self.cloud):
            try:
                balance, evaluation = place.solve(variables)
            except UnsolvedError:
                continue
            values[k] = place.objective(balance, evaluation)[0]
            amplitudes[k] = self._amplitude(evaluation.w)
        return values

    def _promising(self, values: Array, sign: float) -> list[Array]:
        """The virgin start state and the best of the cloud."""
        order = np.argsort(np.where(np.isnan(values), np.inf, -sign * values))[: self.starts]
        return [self.cloud[0], *(self.cloud[k] for k in order if k != 0)]

    def _extreme(self, place: AtFrequency | AtPeak, sign: float, begins: Sequence[Array]) -> Extreme | None:
        try:
            return extreme(place, sign, begins)
        except UnsolvedError:
            return None

    def _amplitude(self, w: Array) -> float:
        return float(np.hypot(*w[self.balance.rows + self.output, 1:3]))

    def _dataset(
        self, frequencies: Array, found: Sequence[Sequence[Extreme | None]], sampled: Array, solves: Array
    ) -> xr.Dataset:
        import xarray as xr

        shape = (2, len(frequencies))
        numbers = {name: np.full(shape, np.nan) for name in ("amplitude", "loss_factor", "resonance")}
        variables, values = np.full((*shape, self.space.size), np.nan), np.full((*shape, self.space.group.size), np.nan)
        forces = np.full((*shape, self.balance.rows, self.balance.tables.E.shape[0]), np.nan)
        for bound, row in enumerate(found):
            for k, result in enumerate(row):
                if result is None:
                    continue
                evaluation = result.evaluation
                cycle = contact_cycle(evaluation.table, self.balance.tables, evaluation.w)
                numbers["amplitude"][bound, k] = self._amplitude(evaluation.w)
                numbers["loss_factor"][bound, k] = self.energy.at(evaluation, cycle).loss_factor
                numbers["resonance"][bound, k] = evaluation.point.omega / (2.0 * np.pi)
                variables[bound, k], values[bound, k] = result.variables, self.space.values(result.variables)
                forces[bound, k] = cycle.force
        place = ("bound", "frequency")
        rows = [f"{c.name} {d}" for c in self.balance.problem.contacts for d in c.direction_names]
        attributes = {
            "amplitude": {"units": "m", "long_name": "amplitude of the first harmonic"},
            "loss_factor": {"units": "1", "long_name": "loss factor"},
            "resonance": {"units": "Hz", "long_name": "frequency of the solution"},
        }
        return xr.Dataset(
            {
                **{name: (place, array, attributes[name]) for name, array in numbers.items()},
                "start_variable": ((*place, "variable"), variables, {"units": "1"}),
                "start_value": ((*place, "element"), values, {"units": "SI"}),
                "contact_force": ((*place, "row", "sample"), forces, {"units": "N"}),
                "sampled_amplitude": (("start", "frequency"), sampled, {"units": "m"}),
                "solves": (("frequency",), solves, {"units": "1"}),
            },
            {"bound": list(BOUNDS), "frequency": ("frequency", frequencies, {"units": "Hz"}), "row": rows},
        )
