"""Responses that were not measured, from an identification by those that were: curves with 95 % intervals.

Each case is the curve of one draw (`draws.py`) at one level; `measured_response.py` finds the peaks of computed and measured
curves.

What all predictions from an identification have in common: its draws, their problems, and how the contacts start.
"""

import json
import time
from collections.abc import Callable, Mapping, Sequence
from dataclasses import KW_ONLY, dataclass
from functools import cached_property
from typing import Annotated, Any, Literal, Protocol, get_args

import numpy as np
from scipy import special

from stickslip.analyses.controlled_response import amplitudes_of
from stickslip.analyses.forced_response import compile_forced_response
from stickslip.analyses.settings import Execution, OfKind, OneOf, Seed, Setting, Whole, made, takes
from stickslip.analyses.variability.samples import start_curve
from stickslip.laboratory.identification.response.draws import Draw, Draws, of_draws
from stickslip.laboratory.identification.response.prediction_result import FINER, ResponsePrediction
from stickslip.laboratory.measurement.measured_response import at_frequencies, curve_peak
from stickslip.model.problem import Problem
from stickslip.results.schema import stacked, tabulated
from stickslip.runs.cases import Arrays, Report, all_cases
from stickslip.solve.balance.balance import HarmonicBalance
from stickslip.solve.balance.fourier import highest, of_attribute
from stickslip.solve.balance.measure import Measure, measure_of, quantity_named
from stickslip.solve.balance.system import Control
from stickslip.solve.continuation.curve_points import CurvePoint
from stickslip.solve.curves.curve import Curve, controlled_curve, force_phase, phase_resonances, refined, solve_curve
from stickslip.solve.starts.states import StartSpace, explored_space
from stickslip.support.checks import Array, InputError, fault, finite, of_kind
from stickslip.support.late import xr
from stickslip.support.machine import one_blas_thread
from stickslip.support.outcome import Outcome
from stickslip.support.units import Band

FEWEST_DRAWS = 20
"""Draws at least."""

StartStates = Literal["identified", "virgin", "any"]
StartsOfDraws = Annotated[StartStates, Setting(OneOf(get_args(StartStates)))]


class Identification(Protocol):
    """What is predicted from: the dataset of an identification, and the problem of its parameters."""

    @property
    def dataset(self) -> "xr.Dataset": ...

    @property
    def problem_of(self) -> Callable[..., Problem]: ...


def _identification(name: str, given: Any) -> Any:
    """An identification by `identify_response`, with the problem that it is of."""
    if not callable(getattr(given, "problem_of", None)) or "fit_value" not in getattr(given, "dataset", {}):
        raise fault(name, "must be what identify_response returned", given, "Identify again with this version if it is older.")
    return given


Identified = Annotated[Identification, Setting(_identification)]


def settings_beside(tests: Sequence[Mapping[str, Any]], given: Mapping[str, float]) -> dict[str, Any]:
    """Settings given for a prediction, and those that all tests had alike; refused where one that differs is not given."""
    found: dict[str, Any] = dict(given)
    for name in dict.fromkeys(name for one in tests for name in one if name not in found):
        values = [one.get(name) for one in tests]
        if values[0] is None or any(value != values[0] for value in values):
            rule = f"must give {name} a value for the prediction, since it differs from test to test"
            remedy = f"The tests have {values}. Give settings={{{name!r}: ...}} (--setting {name}=...)."
            raise fault("settings", rule, dict(given), remedy)
        found[name] = values[0]
    return found


def _settings(name: str, given: Any) -> dict[str, float]:
    return {str(key): finite(f"{name}, {key}", value) for key, value in dict(of_kind(name, given, Mapping)).items()}  # type: ignore[type-abstract]


@dataclass(frozen=True, eq=False)
class DrawnProblems(Execution):
    """The problems of the identified parameters and of draws of them; number 0 is the first."""

    identification: Identified
    _: KW_ONLY
    band: Annotated[Band | None, Setting(OfKind(Band))] = None
    settings: Annotated[Mapping[str, float] | None, Setting(_settings)] = None
    start_states: StartsOfDraws = "identified"
    draws: Annotated[int, Setting(Whole(FEWEST_DRAWS))] = 40
    seed: Seed = 0

    def __post_init__(self) -> None:
        super().__post_init__()
        for name in self.settings or {}:
            if name in self.population.free:
                raise fault("settings", "must not name what was identified", name)
        _ = self.known_settings

    @property
    def data(self) -> "xr.Dataset":
        """The dataset of the identification."""
        return self.identification.dataset

    @cached_property
    def population(self) -> Draws:
        return Draws.of(self.data)

    @property
    def ends(self) -> tuple[float, float]:
        """The band in Hz, that of the measured curves unless given."""
        f = self.data["frequency"].values
        return (float(np.nanmin(f)), float(np.nanmax(f))) if self.band is None else (self.band.low, self.band.high)

    @property
    def measure(self) -> Measure:
        """What was measured."""
        return measure_of(str(self.data["quantity"].values[0]), "amplitude")

    @property
    def output(self) -> int:
        """The number of the measured output."""
        return int(self.data.attrs["output_number"])

    @cached_property
    def known_settings(self) -> dict[str, Any]:
        """Settings of the problem: those given, and those that all tests had alike."""
        return settings_beside(json.loads(str(self.data.attrs["settings"])), self.settings or {})

    @property
    def test_levels(self) -> Array:
        """Levels of the tests (tests,), on which what each has by itself may depend along a line; of none nothing does."""
        return np.zeros(0)

    def drawn_at(self, level: float) -> list[Draw]:
        """The identified parameters, and the draws, of a further test at a level."""
        at = self.test_levels, level
        return [self.population.best_at(at), *self.population.drawn(self.draws, self.seed, at)]

    @property
    def starts(self) -> tuple[str, tuple[str, ...], str, float]:
        """How contacts start: virgin, free (normal about 0) or any; rule, share and deviation."""
        attrs = self.data.attrs
        known = {"identified": str(attrs["start_states"]), "virgin": "virgin", "any": "any"}[self.start_states]
        rule = tuple(np.atleast_1d(attrs["rule"]).tolist())
        return known, rule, str(attrs["share"]), float(attrs["start_deviation"])

    @property
    def about_all(self) -> str:
        """Everything that all problems and their solutions depend on, beside the drawn values."""
        problem, attrs = self.problem(self.population.best_at(None)).fingerprint, self.data.attrs
        words = f"{problem}, {self.ends}, {self.measure}, {self.starts}, {self.seed}, {attrs['harmonics']}"
        return f"{words}, {attrs['samples']}, {self.known_settings}"

    def problem(self, draw: Draw) -> Problem:
        """The problem of a draw."""
        values: dict[str, Any] = {**draw.values, **self.known_settings}
        return made(self.identification.problem_of, **values)

    prepare = staticmethod(compile_forced_response)

    def start_state(self, balance: HarmonicBalance, force: float, number: int) -> tuple[StartSpace | None, Array]:
        """The start states of the contacts, of the width that a force level needs, and the variables of a draw; None for virgin
        ones."""
        states, rule, share, deviation = self.starts
        if states == "virgin" or not balance.problem.contacts:
            return None, np.zeros(0)
        low, high = self.ends
        omegas = [2.0 * np.pi * f for f in (low, 0.5 * (low + high), high)]
        rules: Any = rule[0] if len(rule) == 1 else rule
        space = explored_space(balance, omegas, force, rules, share)  # type: ignore[arg-type]
        generator = np.random.default_rng([self.seed, number])
        if number == 0:
            return space, np.zeros(space.size)
        if states == "any":
            return space, generator.uniform(-1.0, 1.0, space.size)
        low, high = special.ndtr(np.array([-1.0, 1.0]) / deviation).tolist()
        return space, np.asarray(deviation * special.ndtri(generator.uniform(low, high, space.size)))

    def values_of(self, drawn: Sequence[Draw]) -> Array:
        """The parameters of draws (draws, parameters)."""
        return np.array([[draw.values[name] for name in self.population.free] for draw in drawn])

    def tops(self, key: str) -> Array:
        """Of each test a quantity at the point of its largest response per force (tests,)."""
        data = self.data
        at = [int(np.nanargmax(data["measured"].values[t])) for t in range(data.sizes["test"])]
        return np.array([float(data[key].values[t, top]) for t, top in enumerate(at)])

    @property
    def about_draws(self) -> dict[str, Any]:
        """What a prediction states of its draws."""
        population, scatter = self.population, self.population.scatter
        return {
            "draws": self.draws,
            "seed": self.seed,
            "start_states": self.starts[0],
            "free": ", ".join(name for name in population.free if name not in population.of_each_test),
            "free_of_each_test": ", ".join(population.of_each_test),
            "free_over_level": ", ".join(population.lines(self.test_levels)),
            "unknown": ", ".join(population.unknown),
            "tests": population.tests,
            "worst_misfit": float(self.data["misfit"].max()),
            "gain_scatter": scatter.gain,
            "frequency_scatter": scatter.shift,
            "scatter_known": int(scatter.freedom > 0.0),
            "harmonics": self.data.attrs["harmonics"],
            "samples": self.data.attrs["samples"],
        }


def within(values: Array, ends: tuple[float, float]) -> Array:
    """1.0 of values between two ends, but for rounding, 0.0 beyond them."""
    return ((values >= ends[0] * (1.0 - 1e-6)) & (values <= ends[1] * (1.0 + 1e-6))).astype(float)


PER_FORCE = {"displacement": "m/N", "velocity": "m/(s N)", "acceleration": "m/(s2 N)"}
"""Units of responses per force."""

GRID = 81
"""Frequencies of the band over the whole, beside those of the curve of the identified parameters."""

PEAK = ("peak_frequency", "peak_amplitude", "damping_ratio")
"""What is predicted of a peak."""


def levels_of(name: str, values: Any) -> tuple[float, ...]:
    """Levels, checked; none is allowed."""
    return amplitudes_of(name, values) if np.size(values) else ()


def one_kind_of_level(force: Sequence[float], amplitude: Sequence[float], files: bool = False) -> None:
    """Refuse both forces and held amplitudes, and none; files: of measured curves to compare with, which may say them."""
    what = "force: force levels in N, such as force = [1.0, 5.0]; amplitude: held amplitudes of the measured quantity."
    if force and amplitude:
        given = f"force = {list(force)} and amplitude = {list(amplitude)}"
        raise InputError(f"force and amplitude must not be given together, but {given} are. Leave one out. {what}")
    if not force and not amplitude:
        raise fault("force", f"must be given, or amplitude{', or files to compare with' if files else ''}", [], what)


@dataclass(frozen=True, eq=False)
class ResponsePredictionWork(DrawnProblems):
    """A prediction as independent cases: the identified parameters and each draw, at each level."""

    force: Annotated[float | Sequence[float], Setting(levels_of)] = ()
    _: KW_ONLY
    amplitude: Annotated[float | Sequence[float], Setting(levels_of)] = ()

    def __post_init__(self) -> None:
        super().__post_init__()
        one_kind_of_level(*self.levels)

    @cached_property
    def levels(self) -> tuple[tuple[float, ...], tuple[float, ...]]:
        """Forces and held amplitudes, of which one is empty."""
        return levels_of("force", self.force), levels_of("amplitude", self.amplitude)

    @property
    def held(self) -> bool:
        """Whether amplitudes are held."""
        return bool(self.levels[1])

    @property
    def cases(self) -> list[tuple[int, int]]:
        """Level and draw of every case."""
        return [(level, draw) for level, drawn in enumerate(self.drawn) for draw in range(len(drawn))]

    @property
    def test_levels(self) -> Array:
        """Force levels of the tests, or amplitudes where these are held, at their largest response."""
        return self.tops("response" if self.held else "force")

    @cached_property
    def drawn(self) -> list[list[Draw]]:
        """Of each level the identified parameters, and the draws."""
        return [self.drawn_at(level) for level in self.levels[self.held]]

    @cached_property
    def names(self) -> tuple[str, ...]:
        """Everything that a curve depends on."""
        about = f"{self.about_all}, held {self.held}"
        drawn = [(self.levels[self.held][k], n, dict(self.drawn[k][n].values)) for k, n in self.cases]
        return tuple(f"prediction {level!r}, {n}, {values!r}, {about}" for level, n, values in drawn)

    @property
    def words(self) -> tuple[str, ...]:
        return tuple(f"{self.levels[self.held][k]:g} {self.level_units}, draw {n}" for k, n in self.cases)

    @property
    def level_units(self) -> str:
        return self.measure.units if self.held else "N"

    def solve(self, case: int, report: Report) -> Arrays:
        """Frequency and response along the curve of a case, and its peak; of the identified parameters its errors too.

        Their estimate is the change of ln frequency and ln response of the peak with `FINER` times the harmonics and twice the
        samples, times 1/(1 − 1/FINER): what remains of an error that falls at least as 1/H is so much more.
        """
        started = time.process_time()
        k, number = self.cases[case]
        level, problem = self.levels[self.held][k], self.problem(self.drawn[k][number])
        harmonics, samples = of_attribute(self.data.attrs["harmonics"]), int(self.data.attrs["samples"])
        with one_blas_thread():
            curve, points, peak = self._curve(HarmonicBalance(problem, harmonics, samples), level, number, report)
            arrays = {"frequency": points[0], "size": points[1], "peak": curve_peak(*points, peak)}
            if number == 0:
                many = FINER * highest(harmonics)
                finer = HarmonicBalance(problem, many, problem.systems.enough_samples(max(2 * samples, 4 * many + 2)))
                better = self._curve(finer, level, number, lambda share: None)[2]
                change = np.abs(np.log(np.divide(better, peak))) if peak and better else np.full(2, np.nan)
                arrays["errors"] = change / (1.0 - 1.0 / FINER)
        arrays["solved"] = np.array(float(curve.outcome == Outcome.CONVERGED))
        return arrays | {"cpu_seconds": np.array(time.process_time() - started)}

    def _curve(
        self, balance: HarmonicBalance, level: float, number: int, report: Report
    ) -> tuple[Curve, tuple[Array, Array], tuple[float, float] | None]:
        """The curve of a draw, its frequencies and responses, and those of its peak."""
        force = float(np.nanmedian(self.data["force"].values)) if self.held else level
        space, variables = self.start_state(balance, force, number)
        if self.held:
            curve, peak = self._held_curve(space.balance(balance, variables) if space else balance, level, report)
        else:
            curve, peak = self._forced_curve(balance, space, variables, level, report)
        frequency, size = self._sizes(balance, curve.points)
        size[curve.places_outside] = np.nan
        return curve, (frequency, size), peak

    def _forced_curve(
        self, balance: HarmonicBalance, space: StartSpace | None, variables: Array, level: float, report: Report
    ) -> tuple[Curve, tuple[float, float] | None]:
        """The curve at a force level, refined, and its highest peak."""
        if space is None:
            omegas = [2.0 * np.pi * f for f in self.ends]
            curve = solve_curve(balance, omegas, level, False, report, measure=self.measure)
        else:
            curve = start_curve(balance, space, variables, self.ends, level, False, report, self.measure)
            balance = space.balance(balance, variables)
        if not curve.points:
            return curve, None
        curve = refined(balance, curve) if curve.peaks else curve
        peaks = curve.peaks[self.output] if curve.peaks else ()
        tops = np.array(self._sizes(balance, peaks)) if peaks else np.zeros((2, 0))
        return curve, None if not peaks else (float(tops[0, tops[1].argmax()]), float(tops[1].max()))

    def _held_curve(self, balance: HarmonicBalance, amplitude: float, report: Report) -> tuple[Curve, tuple[float, float] | None]:
        """The curve at a held amplitude, and the phase resonance of the least force."""
        order = quantity_named(str(self.data["quantity"].values[0]))[0].order
        held = balance.holding(Control(balance.rows + self.output, order, amplitude))
        curve = controlled_curve(held, [2.0 * np.pi * f for f in self.ends], False, report)
        phase = force_phase(balance.problem, 2.0 * np.pi * self.ends[0]) or 0.0
        found = phase_resonances(held, curve.points, phase) if curve.points else []
        found = [each for each in found if curve.holds(each.evaluation.point.omega)]
        if not found:
            return curve, None
        point = found[0].evaluation.point
        return curve, (balance.hertz(point.omega), amplitude / abs(point.level))

    def _sizes(self, balance: HarmonicBalance, points: Sequence[CurvePoint]) -> tuple[Array, Array]:
        """Frequencies in Hz and responses of points; where an amplitude is held, the response per force."""
        row = balance.rows + self.output
        sizes = [self.measure.size(each.evaluation.w[row], each.point.omega) for each in points]
        if self.held:
            sizes = [size / abs(each.point.level) for size, each in zip(sizes, points, strict=True)]
        return np.array([balance.hertz(each.point.omega) for each in points]), np.array(sizes)

    def gathered(self, results: Sequence[Arrays]) -> ResponsePrediction:
        """The prediction from all cases."""
        return ResponsePrediction(_dataset(self, results))


@takes(ResponsePredictionWork)
def predict_response(work: ResponsePredictionWork) -> ResponsePrediction:
    """Predict responses that were not measured, with 95 % intervals, from an identification by `identify_response`.

    force: levels, N; or amplitude: held amplitudes of the measured quantity, m, m/s or m/s². band: that of the measured curves
    unless given. settings: of the problem, for what differs from test to test. draws: parameter sets that are drawn from the
    covariance of the fit, inside their bounds; those that it does not determine, anywhere between theirs. Each draw is a further
    test: what every test has by itself (gain, parameters of each test) is drawn with Student's distribution from the tests, about
    their mean or, where chance does not explain it, about a line over their levels. So is what they scatter beyond that, a factor
    on the response and one on the frequency. Contacts start as identified: virgin, or with the prior distribution of free
    start states; start_states="any" draws any state for each. The errors of harmonics and samples,
    as a curve with three times the harmonics shows them, are part of each draw.

    Medians and percentiles 2.5 and 97.5 of the draws are given, at p (n + 1) of n ordered ones. What is the same for all tests
    and not in the model, such as another contact law, is not in the intervals.
    """
    return work.gathered(all_cases(work, work.checkpoint, work.workers, work.progress))


def _dataset(work: ResponsePredictionWork, results: Sequence[Arrays]) -> "xr.Dataset":
    levels, count = work.levels[work.held], 1 + work.draws
    parts = [results[k * count : (k + 1) * count] for k in range(len(levels))]
    ends = work.ends
    grids = [
        np.unique(np.concatenate([np.linspace(*ends, GRID), one[0]["frequency"][np.isfinite(one[0]["size"])]])) for one in parts
    ]
    longest = max(grid.size for grid in grids)
    peaks = np.full((3, len(levels), count - 1), np.nan)
    curves, errors = np.full((len(levels), count - 1, longest), np.nan), np.array([one[0]["errors"] for one in parts])
    for k, (grid, one) in enumerate(zip(grids, parts, strict=True)):
        off, size = np.nan_to_num(errors[k])  # where no finer peak was found, the answer says so
        factors = np.array([draw.gain + size * draw.truncation for draw in work.drawn[k][1:]])
        shifts = np.array([draw.shift + off * draw.truncation for draw in work.drawn[k][1:]])
        for n, (factor, shift, each) in enumerate(zip(factors, shifts, one[1:], strict=True)):
            # A shifted curve goes on level to the end of the band, which it would else miss by the shift.
            along = at_frequencies(np.clip(grid * np.exp(-shift), *ends), each["frequency"], each["size"])
            curves[k, n, : grid.size] = np.exp(factor) * along
        drawn = np.array([each["peak"] for each in one[1:]])
        peaks[:, k] = drawn[:, 0] * np.exp(shifts), drawn[:, 1] * np.exp(factors), drawn[:, 2]
    data: dict[str, Any] = {}
    for name, drawn in zip(PEAK, peaks, strict=True):
        data |= of_draws(name, drawn, axis=1)
    data |= {"frequency": stacked(grids)} | of_draws("amplitude", curves, axis=1)
    data |= {"peak_frequency_error": errors[:, 0], "peak_amplitude_error": errors[:, 1]}
    data["interpolated"] = within(np.array(levels), _measured_levels(work))
    data["unsolved"] = np.array([sum(not one["solved"] for one in each[1:]) for each in parts], dtype=float)
    data["drawn"] = np.array([work.values_of(drawn[1:]) for drawn in work.drawn])
    coords = {"level": list(levels), "parameter": list(work.population.free)}
    low, high = _measured_levels(work)
    attributes = work.about_draws | {
        "title": "Predicted responses",
        "held": "response" if work.held else "force",
        "quantity": work.measure.quantity.name,
        "measured_from": low,
        "measured_to": high,
        "point_error": float(np.median(work.data["point_error"].values)),
        "point_noise": float(np.median(work.data.get("point_noise", work.data["point_error"]).values)),
        "cpu_seconds": sum(float(one["cpu_seconds"]) for one in results),
    }
    units = PER_FORCE[work.measure.quantity.name] if work.held else work.measure.units
    found = tabulated("response_prediction", data, coords, attributes, units)
    found["level"].attrs |= {"units": work.level_units, "long_name": "held amplitude" if work.held else "force level"}
    return found


def _measured_levels(work: ResponsePredictionWork) -> tuple[float, float]:
    """Least and largest level that the tests of the identification had at their largest response."""
    return float(work.test_levels.min()), float(work.test_levels.max())
