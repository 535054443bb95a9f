"""Free decays that were not measured, from an identification: frequency and damping over the amplitude, with 95 % intervals.

Each case is the nonlinear mode of one draw (`drawn_problems.py`): a motion that decays slowly is, at every instant, that of the
mode at its amplitude.
"""

from __future__ import annotations

import time
from collections.abc import Sequence
from dataclasses import KW_ONLY, dataclass
from functools import cached_property
from typing import Annotated, Any

import numpy as np

from stickslip.analyses.modes.slow_decay import slow_decay
from stickslip.analyses.modes.work import Modes
from stickslip.analyses.settings import Setting, Whole, takes
from stickslip.laboratory.identification.response.decay_prediction_result import DecayPrediction
from stickslip.laboratory.identification.response.drawn_problems import DrawnProblems
from stickslip.laboratory.identification.response.draws import Draw, interval
from stickslip.laboratory.identification.response.prediction_result import FINER
from stickslip.runs.cases import all_cases
from stickslip.runs.work import Arrays, Report
from stickslip.solve.balance.balance import HarmonicBalance
from stickslip.solve.balance.orders import highest, of_attribute
from stickslip.solve.curves.mode_curve import solve_mode
from stickslip.support.checks import Array, InputError, fault, positive, vector
from stickslip.support.late import xr
from stickslip.support.machine import one_blas_thread

PER_DECADE = 100
"""Amplitudes in a decade at which a decay is predicted: damping rises within a few per cent where slip begins."""

BEYOND = 1.2
"""Ratio by which a mode goes beyond these amplitudes on either side: they count in the shape of the stuck mode, which changes as
contacts slip."""


def decay_ends(name: str, amplitude: Any) -> tuple[float, float]:
    """The smallest and the largest amplitude."""
    low, high = (positive(name, end) for end in vector(name, amplitude, 2).tolist())
    if not low < high:
        raise fault(name, "must be (low, high) with low below high", amplitude)
    return low, high


@dataclass(frozen=True, eq=False)
class DecayPredictionWork(DrawnProblems):
    """A prediction of a decay as independent cases: the nonlinear mode of the identified parameters and of each draw."""

    amplitude: Annotated[tuple[float, float], Setting(decay_ends)]
    _: KW_ONLY
    mode: Annotated[int | None, Setting(Whole(1))] = None
    frequency: Annotated[float | None, Setting(positive)] = None

    def __post_init__(self) -> None:
        super().__post_init__()
        if self.mode is not None and self.frequency is not None:
            raise InputError("mode and frequency must not be given together, but are: both say which mode decays.")

    @cached_property
    def drawn(self) -> list[Draw]:
        """The identified parameters, and the draws: a decay passes many levels, so that no line over them is followed."""
        return self.drawn_at(np.nan)

    @cached_property
    def names(self) -> tuple[str, ...]:
        """Everything that a mode depends on."""
        about, drawn = f"{self.amplitude}, mode {self.followed}, {self.about_all}", enumerate(self.drawn)
        return tuple(f"predicted decay, {n}, {dict(draw.values)!r}, {draw.gain!r}, {about}" for n, draw in drawn)

    @property
    def words(self) -> tuple[str, ...]:
        return tuple(f"draw {n}" for n in range(len(self.drawn)))

    @cached_property
    def grid(self) -> Array:
        """The amplitudes of the displacement, m."""
        low, high = self.amplitude
        return np.geomspace(low, high, 2 + int(np.ceil(PER_DECADE * np.log10(high / low))))

    @cached_property
    def followed(self) -> int:
        """The number of the stuck mode: the given one, or that nearest to the given frequency, or to the largest measured
        response inside the band of the test with the smallest motion."""
        if self.mode is not None:
            return self.mode
        if self.frequency is not None:
            return self._nearest(self.frequency)
        low, high = self.ends
        test = self.data.isel(test=int(np.argmin(self.tops("response"))))
        size = np.where((test["frequency"] >= low) & (test["frequency"] <= high), test["measured"], np.nan)
        if not np.any(np.isfinite(size)):
            raise fault("band", "must hold measured points, or mode or frequency be given", [low, high])
        at = float(test["frequency"].values[int(np.nanargmax(size))])
        return self._nearest(at)

    def _nearest(self, frequency: float) -> int:
        return Modes(self.problem(self.drawn[0]), frequency=frequency, output=self.output).modes[0]

    @property
    def measured(self) -> tuple[float, float]:
        """Least and largest amplitude of the displacement at the points of the tests, m."""
        data = self.data
        size = data["response"].values / (2.0 * np.pi * data["frequency"].values) ** self.measure.quantity.order
        return float(np.nanmin(size)), float(np.nanmax(size))

    def solve(self, case: int, report: Report) -> Arrays:
        """Frequency and damping ratio of a draw over the amplitude; of the identified parameters their errors too.

        The error of harmonics and samples is estimated as for a predicted response: the change of ln f and ln ζ with `FINER`
        times the harmonics and twice the samples, times 1/(1 − 1/FINER).
        """
        started = time.process_time()
        harmonics, samples = of_attribute(self.data.attrs["harmonics"]), int(self.data.attrs["samples"])
        with one_blas_thread():
            along = self._along(case, harmonics, samples, report)
            arrays: dict[str, Any] = {"found": along}
            if case == 0:
                many = FINER * highest(harmonics)
                finer = self._along(case, many, max(2 * samples, 4 * many + 2), lambda share: None)
                with np.errstate(invalid="ignore", divide="ignore"):
                    arrays["errors"] = np.abs(np.log(finer / along)) / (1.0 - 1.0 / FINER)
        return arrays | {"cpu_seconds": np.array(time.process_time() - started)}

    def _along(self, number: int, harmonics: Any, samples: int, report: Report) -> Array:
        """Frequency and damping ratio of the decay of a draw (2, amplitudes) as its measuring chain shows the amplitudes;
        NaN where there is none."""
        draw = self.drawn[number]
        problem, gain = self.problem(draw), float(np.exp(draw.gain))
        low, high = self.amplitude
        ends = low / gain / BEYOND, high / gain * BEYOND
        modes = Modes(problem, self.followed, ends, harmonics, samples, output=self.output)
        balance = modes.balance(0)
        levels = modes.levels(balance)
        if self.starts[0] != "virgin":  # a forced balance is decoupled, which a large structure need not pay for virgin contacts
            forced = HarmonicBalance(problem, harmonics, modes.samples)
            space, variables = self.start_state(forced, float(np.nanmedian(self.data["force"].values)), number)
            balance = balance if space is None else space.balance(balance, variables)  # type: ignore[assignment]
        curve = solve_mode(balance, *levels, report)
        if len(curve.points) < 2:
            return np.full((2, self.grid.size), np.nan)
        row, solved = balance.rows + self.output, [point.evaluation for point in curve.points]
        size = np.array([float(np.hypot(*one.w[row, 1:3])) for one in solved])
        frequency = np.array([balance.omega_of(one.point) / (2.0 * np.pi) for one in solved])
        rows = frequency, slow_decay(balance, curve.points).damping_ratio[:, self.output]
        order, at = np.argsort(size, kind="stable"), np.log(self.grid / gain)
        return np.array([np.interp(at, np.log(size[order]), values[order], np.nan, np.nan) for values in rows])

    def gathered(self, results: Sequence[Arrays]) -> DecayPrediction:
        """The prediction from all cases."""
        return DecayPrediction(_dataset(self, results))


@takes(DecayPredictionWork)
def predict_decay(work: DecayPredictionWork) -> DecayPrediction:
    """Predict the frequency and the damping ratio of a free decay over its amplitude, with 95 % intervals, from an identification
    by `identify_response`.

    amplitude: (low, high) of the displacement at the measured output, m. mode: number of the stuck mode that decays, 1 the
    lowest; or frequency [Hz], near which it lies; unless given the mode nearest to the largest response in `band` of the test
    with the smallest motion. Frequency and damping are those that a slow decay along the nonlinear mode of each draw shows: the
    frequency of the mode, and the damping ratio by `analyses/modes/slow_decay.py`. draws, seed, settings
    and start_states are those of `predict_response`, and so is what else the intervals include: parameters, scatter from test to
    test, of the gain too, start states of the contacts, errors of harmonics and samples.
    """
    return work.gathered(all_cases(work, work.checkpoint, work.workers, work.progress))


KEYS = {"frequency": ("Hz", "frequency of the decay"), "damping_ratio": ("1", "damping ratio of the decay")}
"""What is predicted of a decay."""


def _dataset(work: DecayPredictionWork, results: Sequence[Arrays]) -> xr.Dataset:
    drawn = np.array([np.asarray(one["found"]) for one in results[1:]])  # (draws, 2, amplitudes)
    errors = np.asarray(results[0]["errors"])
    whole = np.nan_to_num(errors)
    shifted = [_with_errors(draw, values, whole) for draw, values in zip(work.drawn[1:], drawn, strict=True)]

    def named(dims: Any, values: Any, words: str, unit: str) -> tuple[Any, ...]:
        return dims, values, {"units": unit, "long_name": words}

    data: dict[str, Any] = {}
    for k, (name, (unit, words)) in enumerate(KEYS.items()):
        values = np.array(shifted)[:, k]
        low, middle, high = interval(values, axis=0)
        for suffix, row, what in (
            ("", middle, "median"),
            ("_low", low, "low end of the interval"),
            ("_high", high, "high end of the interval"),
        ):
            data[f"{name}{suffix}"] = named("amplitude", row, f"{words}, {what} of the draws", unit)
        data[f"{name}_drawn"] = named(("draw", "amplitude"), values, f"{words} of each draw", unit)
        what = f"estimated error of the {words} due to harmonics and samples, relative"
        data[f"{name}_error"] = named("amplitude", errors[k], what, "1")
    least, most = work.measured
    inside = (work.grid >= least * (1.0 - 1e-6)) & (work.grid <= most * (1.0 + 1e-6))
    data["interpolated"] = named("amplitude", inside.astype(float), "1 within the measured amplitudes, 0 beyond them", "1")
    lost = np.sum(~np.isfinite(drawn[:, 0]), axis=0).astype(float)
    data["unsolved"] = named("amplitude", lost, "draws whose mode does not reach the amplitude", "1")
    names = list(work.population.free)
    values = np.array([[draw.values[name] for name in names] for draw in work.drawn[1:]])
    data["drawn"] = named(("draw", "parameter"), values, "drawn parameters", "as given")
    coords = {
        "amplitude": named("amplitude", work.grid, "amplitude of the displacement", "m"),
        "parameter": named("parameter", names, "parameter", "1"),
    }
    attrs = work.about_draws | {"title": "Predicted decay", "mode": work.followed, "measured_from": least, "measured_to": most}
    return xr.Dataset(data, coords, attrs | {"cpu_seconds": sum(float(one["cpu_seconds"]) for one in results)})


def _with_errors(draw: Draw, values: Array, errors: Array) -> Array:
    """Frequency and damping ratio (2, amplitudes) of a draw with its scatter between tests and its share of the errors."""
    scatter = np.array([[draw.shift], [0.0]])
    return np.asarray(values * np.exp(scatter + draw.truncation * errors))
