"""Sobol' sensitivity indices: the share of the variance of peak amplitude and frequency that each uncertain parameter causes.

Variance-based indices of Sobol', with all parameters uniform in their ranges, and slopes at the middle.

Resonance peaks for sampled parameter values as independent cases, the work behind `sensitivity_indices`.
"""

import time
from collections.abc import Mapping, Sequence
from contextlib import suppress
from dataclasses import KW_ONLY, dataclass
from typing import Annotated, Any, Protocol

import numpy as np

from stickslip.analyses.forced_response import compile_forced_response
from stickslip.analyses.performance.work import no_resonance
from stickslip.analyses.response_dataset import levels_are_newtons
from stickslip.analyses.settings import (
    Execution,
    MeasuredOutput,
    Sampled,
    Seed,
    Setting,
    ends_of,
    fineness_of,
    made,
    maker,
    output_of,
    over_a_band,
    ranges_of,
    takes,
)
from stickslip.model.problem import Problem
from stickslip.results.schema import Result, tabulated
from stickslip.runs.cases import Arrays, Report, all_cases
from stickslip.solve.balance.balance import HarmonicBalance
from stickslip.solve.balance.fourier import attribute
from stickslip.solve.continuation.curve_points import LostCurveError
from stickslip.solve.peaks.climb import NoPeakError, PeakSolver, SolvedPeak
from stickslip.solve.peaks.continuation import swept_peaks
from stickslip.support.checks import Array, fault, positive, whole
from stickslip.support.late import xr
from stickslip.support.units import Band

MOST_DRAWS = 2**20
"""More would take months."""

BLOCK = 8
"""Draws of one case; their problems differ from one another in one parameter at a time."""

TIGHT = 1e-8
"""Relative amplitude by which the peaks that slopes are taken from may be below their tops."""


class ProblemOf(Protocol):
    """The problem of parameter values: `problem_of(kt=1e6, mu=0.4)`."""

    def __call__(self, **parameters: float) -> Problem: ...


def _power_of_two(name: str, draws: Any) -> int:
    if not 2 <= whole(name, draws) <= MOST_DRAWS or draws & (draws - 1):
        raise fault(name, f"must be a power of two, from 2 to {MOST_DRAWS}", draws)
    return int(draws)


@dataclass(frozen=True, eq=False)
class DrawsWork(Sampled, MeasuredOutput, Execution):
    """Peaks along the ranges (the first case), then at Saltelli's points, `BLOCK` draws a case.

    A draw is d + 2 points: one of A, one of B, and A with one value of B each.
    """

    problem_of: Annotated[ProblemOf, Setting(maker)]
    parameters: Annotated[Mapping[str, tuple[float, float]], Setting(ranges_of)]
    band: Annotated[Band, Setting(over_a_band)]
    force: Annotated[float, Setting(positive)] = 1.0
    _: KW_ONLY
    draws: Annotated[int, Setting(_power_of_two, "a power of two; draws × (ranges + 2) problems are solved")] = 64
    seed: Seed = 0

    def __post_init__(self) -> None:
        super().__post_init__()
        fineness_of(self.harmonics, self.samples)
        output_of(self.problem(np.mean(self.box, axis=1)), self.output)

    @property
    def box(self) -> tuple[tuple[float, float], ...]:
        """(low, high) of each parameter."""
        return tuple(self.parameters.values())

    def problem(self, values: Array) -> Problem:
        """The problem of values in the order of the parameters."""
        return made(self.problem_of, **dict(zip(self.parameters, map(float, values), strict=True)))

    def points(self) -> Array:
        """All points (draws, parameters + 2, parameters), from a Sobol' sequence of twice as many dimensions."""
        from scipy.stats import qmc  # takes half a second, which only those who draw shall wait for

        low, high = np.array(self.box).T
        count = low.size
        unit = qmc.Sobol(2 * count, bits=64, seed=self.seed).random(self.draws)
        A, B = low + (high - low) * unit[:, :count], low + (high - low) * unit[:, count:]
        mixed = np.where(np.eye(count, dtype=bool), B[:, None], A[:, None])
        return np.concatenate([A[:, None], B[:, None], mixed], axis=1)

    @property
    def blocks(self) -> list[slice]:
        """The draws of each case after the first."""
        return [slice(k, min(k + BLOCK, self.draws)) for k in range(0, self.draws, BLOCK)]

    @property
    def names(self) -> tuple[str, ...]:
        """Everything that a case depends on; a function of the problem is identified by what it returns at two corners."""
        corners = " ".join(self.problem(corner).fingerprint for corner in np.array(self.box).T)
        how = f"{self.identity('problem_of')}, problems {corners}"
        return (f"peaks along the ranges, {how}", *(f"peaks of {block}, {how}" for block in self.blocks))

    @property
    def words(self) -> tuple[str, ...]:
        return ("along the ranges", *(f"draws {block.start + 1} to {block.stop}" for block in self.blocks))

    prepare = staticmethod(compile_forced_response)

    def solve(self, case: int, report: Report) -> Arrays:
        """The peaks of one case."""
        started = time.process_time()
        peaks = Peaks(self)
        arrays = peaks.in_the_middle() if case == 0 else {"peaks": peaks.drawn(self.points()[self.blocks[case - 1]], report)}
        return arrays | {"cpu_seconds": np.array(time.process_time() - started)}


class Peaks:
    """Peaks of a problem at any parameter values, each climbed to from the nearest one known, else found by a sweep."""

    def __init__(self, work: DrawsWork) -> None:
        self.work = work
        self.span = np.ptp(np.array(work.box), axis=1)
        self.middle = np.mean(work.box, axis=1)
        self.known: list[tuple[Array, SolvedPeak, Array]] = []
        self.origin = self._keep(self.middle, self._balance(self.middle))

    def in_the_middle(self) -> dict[str, Array]:
        """The middle, both ends of each range with the others in the middle, and the slopes of ln(amplitude) over the range.

        A slope is (4 D(1/2) − D(1))/3, of fourth order, D(x) the difference between the ends of the share x of the range over x.
        No derivative at one frequency gives it: that of a lone mode by its stiffness is wrong by 2Q·ε for a peak whose frequency
        is ε half-widths off, and the cusps of samples put it anywhere within the 0.1 % band.
        """
        ends, halves = (np.array([self._pair(k, share) for k in range(self.middle.size)]) for share in (1.0, 0.5))
        wide, close = (np.diff(np.log(pairs[..., 0]))[:, 0] for pairs in (ends, halves))
        middle = (self.origin.amplitude, self.origin.omega / (2.0 * np.pi))
        return {"middle": np.array(middle), "ends": ends, "slopes": (8.0 * close - wide) / 3.0}

    def _pair(self, k: int, share: float) -> list[tuple[float, float]]:
        """Amplitude and frequency at both ends of a share of the range of parameter k, the others in the middle."""
        low, high = self.work.box[k]
        cut = 0.5 * (1.0 - share) * (high - low)
        ends = np.array([self.middle, self.middle])
        ends[:, k] = low + cut, high - cut
        return [self.at(values, TIGHT) for values in ends]

    def drawn(self, points: Array, report: Report) -> Array:
        """Amplitude and frequency at points (draws, points of a draw, parameters)."""
        found = []
        for k, draw in enumerate(points):
            report(k / len(points))
            found.append([self.at(values) for values in draw])
        return np.array(found)

    def at(self, values: Array, tolerance: float | None = None) -> tuple[float, float]:
        """Amplitude, as the work measures it, and frequency in Hz; tolerance: as for `PeakSolver`."""
        balance = self._balance(values)
        _, near, stiffness = min(self.known, key=lambda item: float(np.linalg.norm((item[0] - values) / self.span)))
        carried = near.point.forces + (stiffness - balance.stiffness)[:, None] * near.evaluation.w[: balance.rows]
        start = type(near.point)(carried, near.omega, self.work.force)
        solver = PeakSolver(balance, self.work.output, self.work.measured, tolerance)
        try:
            peak = solver.from_near(start, near.plane)
            self.known = [*self.known[-200:], (np.array(values), peak, balance.stiffness)]
        except NoPeakError:
            peak = self._keep(values, balance)
            with suppress(NoPeakError):
                peak = peak if tolerance is None else solver.from_solved(peak.evaluation)
        return peak.amplitude, peak.omega / (2.0 * np.pi)

    def _balance(self, values: Array) -> HarmonicBalance:
        return HarmonicBalance(self.work.problem(values), self.work.harmonics, self.work.samples)

    def _keep(self, values: Array, balance: HarmonicBalance) -> SolvedPeak:
        low, high = ends_of(self.work.band)
        try:
            band = (2.0 * np.pi * low, 2.0 * np.pi * high)
            found = swept_peaks(balance, self.work.force, band, self.work.output, self.work.measured)[0]
        except LostCurveError as lost:
            raise fault("Every value of the parameters", "must give a solvable curve", values.tolist(), str(lost)) from None
        if not found:
            listed = ", ".join(f"{name} = {value:g}" for name, value in zip(self.work.parameters, values, strict=True))
            raise no_resonance(balance, self.work.output, (low, high), f" for every value of the parameters, also at {listed}")
        peak = max(found, key=lambda peak: peak.amplitude)
        self.known.append((np.array(values), peak, balance.stiffness))
        return peak


RESAMPLES = 300
"""Bootstrap samples of the draws, for the intervals of the indices."""

QUANTITIES = ("peak amplitude", "peak frequency")


@dataclass(frozen=True, eq=False, repr=False)
class SensitivityIndices(Result):
    """`dataset`, axes (parameter, quantity): first_order and total indices of Sobol'; low_end and high_end: the quantity at both
    ends of a range, the others in the middle; spread: its standard deviation; slope: d ln(amplitude) over the range by the slope
    in the middle. first_order_interval, total_interval (.., 2): what 95 % of bootstrap samples of the draws give.
    """

    dataset: "xr.Dataset"


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


def gathered(work: DrawsWork, results: Sequence[Arrays]) -> "xr.Dataset":
    """Indices, ends and slopes as one labelled dataset."""
    shown = np.array([1.0 / work.measured.per(work.force), 1.0])
    first, drawn = results[0], np.concatenate([result["peaks"] for result in results[1:]])
    first = {**first, "middle": shown * first["middle"], "ends": shown * first["ends"]}
    cpu_seconds = sum(float(result["cpu_seconds"]) for result in results)
    drawn = shown * drawn
    middle = work.problem(np.mean(work.box, axis=1))
    units = f"{work.measured.reported_units(levels_are_newtons(middle))} and Hz"
    data = dict(zip(("first_order", "total"), _indices(drawn), strict=True))
    data |= dict(zip(("first_order_interval", "total_interval"), _intervals(drawn, work.seed), strict=True))
    data |= dict(zip(("low_end", "high_end"), np.moveaxis(first["ends"], 1, 0), strict=True))
    data |= {"middle": first["middle"], "spread": np.std(drawn[:, :2], axis=(0, 1)), "slope": first["slopes"]}
    data |= dict(zip(("low", "high"), np.array(work.box).T, strict=True))
    coords = {"parameter": list(work.parameters), "quantity": list(QUANTITIES), "bound": ["low", "high"]}
    attrs: dict[str, Any] = {"title": "Which parameter matters", "cpu_seconds": cpu_seconds}
    attrs |= {key: getattr(work, key) for key in ("force", "draws", "seed", "samples")} | work.measured.attributes
    attrs["harmonics"] = attribute(work.harmonics)
    return tabulated("sensitivity_indices", data, coords, attrs, units)


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
