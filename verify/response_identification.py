"""Contact parameters from synthetic frequency responses with noise, whose truth is known."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from functools import partial
from itertools import pairwise
from typing import Any

import numpy as np

import stickslip as ss
from stickslip.laboratory.identification.response.fit import FittedTest
from stickslip.model.problem import Problem
from stickslip.solve.balance.balance import Evaluation, HarmonicBalance
from stickslip.solve.continuation.continuation import first_point, trace
from stickslip.solve.continuation.curve_points import solve_at
from stickslip.solve.starts.states import start_space
from verify.row import Row, absolute, at_most

TITLE = "Parameters from frequency responses"
ABOUT = (
    "Synthetic responses, amplitude and phase, at three force levels with 1 % noise, fitted from rough starts; twenty seeds. The "
    "median error is that of the worst parameter. Intervals: how many of 60 miss the truth, and their median half width against "
    "1.96 standard deviations of the twenty values. The single blade: six force levels, three hidden start states of all its "
    "friction elements, which the fit has as free variables of each test."
)
NOISE, SEEDS = 0.01, 20
MEDIAN = 0.02
"""Error that the median of many sets keeps."""
SOURCE = "the truth that was put in"

ONE_MASS = {"kt": 0.5, "limit": 1.0, "damping": 0.02}
WEDGE = {"kt": 8e5, "mu": 0.4, "damping": 2e-3}
BLADE = {"cylinder_kt": 45e6, "cylinder_mu": 0.4}
RULE = ("traction_ratio", "virgin")


def one_mass_tests(seed: int) -> list[ss.MeasuredResponse]:
    """Responses of one mass at three force levels."""
    return _tests(ss.rigs.single_mass, ONE_MASS, (0.3, 1.0, 2.0), np.linspace(0.14, 0.24, 25), seed)


def rows() -> Iterator[Row]:
    yield from _statistics("One mass", ss.rigs.single_mass, ONE_MASS, one_mass_tests)
    near = 350.35 + np.array([-40, -30, -22, -15, -10, -6, -4, -2.5, -1.5, -0.7, 0, 0.7, 1.5, 2.5, 4, 6, 10, 15, 20.0])
    wedge = partial(_tests, ss.rigs.blade_and_wedge, WEDGE, (0.5, 6.0, 15.0), near)
    yield from _statistics("Wedge", ss.rigs.blade_and_wedge, WEDGE, wedge)
    yield from _blade()


def _tests(
    problem_of: Callable[..., Problem], truth: Mapping[str, float], levels: Sequence[float], frequencies: Any, seed: int
) -> list[ss.MeasuredResponse]:
    rng, found = np.random.default_rng(seed), []
    for force in levels:
        data = ss.forced_response(problem_of(**truth), frequencies.tolist(), force, harmonics=3).dataset
        found.append(_noisy(frequencies, force, data["response"].values[0, :, 0, 1] @ np.array([1.0, 1j]), rng))
    return found


def _noisy(frequencies: Any, force: float, X: Any, rng: np.random.Generator) -> ss.MeasuredResponse:
    X = X * (1.0 + NOISE * (rng.normal(size=X.size) + 1j * rng.normal(size=X.size)))
    return ss.MeasuredResponse(frequencies, np.abs(X), force, np.angle(X), "displacement", name=f"{force:g} N")


def one_seed() -> Iterator[Row]:
    """One set of noisy responses of one mass: errors within three times the median of many, truths within twice the intervals."""
    values, ends = _identified(ss.rigs.single_mass, ONE_MASS, one_mass_tests(0))
    true = np.array(list(ONE_MASS.values()))
    yield at_most("One mass, one set: error of the worst parameter", np.abs(values / true - 1.0).max(), 3.0 * MEDIAN, SOURCE)
    away = np.abs(true - ends.mean(axis=0)) / (0.5 * np.ptp(ends, axis=0))
    yield at_most("One mass, one set: truth from the middle of its interval, half widths, largest", away.max(), 2.0, SOURCE)


def _identified(
    problem_of: Callable[..., Problem], truth: Mapping[str, float], tests: Sequence[ss.MeasuredResponse]
) -> tuple[np.ndarray, np.ndarray]:
    """Values (parameters,) and ends of their intervals (2, parameters), from rough starts."""
    bounds = {key: (1.6 * value, 0.2 * value, 6.0 * value) for key, value in truth.items()}
    data = ss.identify_response(problem_of, bounds, tests, harmonics=3).dataset
    return data["value"].values, np.array([data["low"].values, data["high"].values])


def _statistics(
    name: str, problem_of: Callable[..., Problem], truth: Mapping[str, float], tests: Callable[[int], list[ss.MeasuredResponse]]
) -> Iterator[Row]:
    sets = [_identified(problem_of, truth, tests(seed)) for seed in range(SEEDS)]
    true, found, ends = np.array(list(truth.values())), *(np.array(part) for part in zip(*sets, strict=True))
    errors = np.median(np.abs(found / true - 1.0), axis=0)
    held = np.mean((ends[:, 0] <= true) & (true <= ends[:, 1]))
    widths = np.median(0.5 * (ends[:, 1] - ends[:, 0]), axis=0) / (1.96 * found.std(axis=0, ddof=1))
    yield at_most(f"{name}: median error of the worst parameter", errors.max(), MEDIAN, SOURCE)
    yield at_most(f"{name}: share of 95 % intervals that miss the truth", 1.0 - held, 0.15, SOURCE)
    yield absolute(f"{name}: narrowest interval against the spread", widths.min(), 1.1, 0.4, "spread over the seeds")
    yield absolute(f"{name}: widest interval against the spread", widths.max(), 1.1, 0.4, "spread over the seeds")


def _single_blade(cylinder_kt: float, cylinder_mu: float) -> Problem:
    return ss.rigs.single_blade(4.6, cylinder_kt=cylinder_kt, cylinder_mu=cylinder_mu)


def _swept(balance: HarmonicBalance, omegas: np.ndarray, force: float) -> Iterator[Evaluation]:
    """The solutions at frequencies, ascending, on the curve that a sweep from the first to the last of them follows."""
    points = list(trace(balance, first_point(balance, float(omegas[0]), force), "omega", float(omegas[-1])))
    steps = list(pairwise(points))
    yield points[0].evaluation
    for omega in map(float, omegas[1:-1]):
        low, high = next(pair for pair in steps if pair[0].point.omega < omega <= pair[1].point.omega)
        yield solve_at(balance, low, high, "omega", omega).evaluation
    yield points[-1].evaluation


def _blade() -> Iterator[Row]:
    rng, balance, tests = np.random.default_rng(0), HarmonicBalance(_single_blade(**BLADE), 3, 128), []
    space = start_space(balance, first_point(balance, 2.0 * np.pi * 500.0, 20.0).evaluation, RULE)
    hidden = [rng.uniform(-0.8, 0.8, space.size) for _ in range(3)]
    for k, force in enumerate((1.0, 5.0, 20.0, 50.0, 80.0, 100.0)):
        frequencies = np.linspace(520.0, 600.0, 17) if force < 15.0 else np.linspace(490.0, 590.0, 17)
        clean = ss.MeasuredResponse(frequencies, 1.0, force, np.zeros(17), "displacement")
        model = FittedTest(clean, _single_blade, 3, 128, [None] * 17, space)
        own = model.balance(BLADE, hidden[k % 3])
        swept = [model.per_force(own, each) for each in _swept(own, 2.0 * np.pi * frequencies, force)]
        tests.append(_noisy(frequencies, force, force * np.array(swept), rng))
    bounds = {"cylinder_kt": (30e6, 10e6, 150e6), "cylinder_mu": (0.25, 0.05, 1.0)}
    settings: dict[str, Any] = {"rule": RULE, "tries": 0, "evaluations": 30, "harmonics": 3, "samples": 128}
    free = ss.identify_response(_single_blade, bounds, tests, start_states="free", **settings)
    for key, value in BLADE.items():
        yield at_most(f"Single blade, {key}: error with free start states", abs(free.values[key] / value - 1.0), 0.05, SOURCE)
