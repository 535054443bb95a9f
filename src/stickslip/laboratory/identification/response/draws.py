"""Draws of what an identification left uncertain: parameters, what a further test has by itself, and the scatter between tests.

`kept_for_draws` is what the dataset of an identification keeps of its fit, `Draws` reads it and draws.
"""

import json
from collections.abc import Mapping
from dataclasses import asdict, dataclass
from typing import Any

import numpy as np
from scipy import special

from stickslip.laboratory.identification.least_squares import CERTAINTY, FreeParameter
from stickslip.laboratory.identification.response.fit import GAIN, ResponseFit
from stickslip.laboratory.identification.response.intervals import TOGETHER, FitStatistics, above_noise
from stickslip.support.checks import Array, InputError
from stickslip.support.late import xr

FIT, OTHER = "fit_variable", "fit_variable_2"
"""Axes of the variables of a fit."""

ENDS = (2.5, 97.5)
"""Percentiles of an interval."""

ATTEMPTS = 1000
"""Attempts to draw anew what lies outside the bounds, before it is moved onto them."""

FEWEST_ON_A_LINE = 4
"""Tests from which a line over their levels leaves two degrees of freedom."""

FEWEST_POINTS, SIGNIFICANCE = 6, 0.05
"""Points from which a test shows its own scatter, and the chance of noise alone from which on nothing counts as scatter."""


def kept_for_draws(fit: ResponseFit, x: Array, known: FitStatistics, solution: Mapping[str, Any]) -> dict[str, Any]:
    """Variables of the dataset of an identification: the fit with the covariance of its variables."""
    low, high = (np.array(ends, dtype=float) for ends in fit.bounds)
    unknown, error, shared = ~np.isfinite(known.error), np.array(known.error, dtype=float), fit.shared
    least = np.asarray(solution.get("least", np.full(len(shared), np.nan)))
    held = np.isfinite(least)
    low[np.array(shared)[held]], unknown[np.array(shared)[held]] = least[held], True
    error[unknown] = 0.0
    error *= known.quantile / CERTAINTY
    covariance = np.nan_to_num(known.correlation * np.outer(error, error), posinf=0.0, neginf=0.0)
    tests, errors = [float(each.test) for each in fit.variables], np.array([model.test.error for model in fit.tests])
    errors *= float(np.sqrt(known.noise))
    noise = errors / max(above_noise(fit.series(x)), 1.0) if known.one_in >= TOGETHER else errors
    return {
        "fit_value": x,
        "fit_low": low,
        "fit_high": high,
        "fit_unknown": unknown.astype(float),
        "fit_test": tests,
        "fit_covariance": covariance,
        "point_error": errors,
        "point_noise": noise,
    }


def free_as_text(free: Mapping[str, FreeParameter]) -> str:
    """The free parameters, as an attribute."""
    return json.dumps({name: asdict(each) for name, each in free.items()})


@dataclass(frozen=True, eq=False)
class Draw:
    """One draw: parameters by name; factors on response and frequency as logarithms, gain and shift; truncation: −1 to 1, the
    share of the estimated error of harmonics and samples that applies."""

    values: Mapping[str, float]
    gain: float = 0.0
    shift: float = 0.0
    truncation: float = 0.0


@dataclass(frozen=True, eq=False)
class Scatter:
    """Standard deviations from test to test of what the fit leaves: of ln response and of ln frequency; 0 where noise explains
    it. freedom: degrees of freedom of both; 0 with one test, whose scatter is not known."""

    gain: float
    shift: float
    freedom: float


@dataclass(frozen=True, eq=False)
class Draws:
    """What an identification left uncertain."""

    dataset: "xr.Dataset"
    free: Mapping[str, FreeParameter]

    @classmethod
    def of(cls, dataset: "xr.Dataset") -> "Draws":
        """From the dataset of an identification."""
        if "fit_covariance" not in dataset:
            raise InputError(
                "The identification must keep the covariance of its fit, but was made by an earlier version. Identify again."
            )
        free = {name: FreeParameter(**each) for name, each in json.loads(dataset.attrs["free"]).items()}
        return cls(dataset, free)

    @property
    def names(self) -> list[str]:
        """Of the variables."""
        return [str(name) for name in self.dataset[FIT].values]

    @property
    def tests(self) -> int:
        return int(self.dataset.sizes["test"])

    def _at(self, name: str) -> np.ndarray[Any, np.dtype[np.intp]]:
        """The numbers of the variables of a name: one, or one for each test."""
        return np.flatnonzero(np.array(self.names) == name)

    @property
    def unknown(self) -> list[str]:
        """Parameters that may lie anywhere between two ends."""
        marked = self.dataset["fit_unknown"].values > 0.0
        return list(dict.fromkeys(name for name, mark in zip(self.names, marked, strict=True) if mark and name in self.free))

    @property
    def of_each_test(self) -> list[str]:
        """What each test has by itself: parameters and the gain."""
        own = self.dataset["fit_test"].values >= 0
        found = dict.fromkeys(name for name, mine in zip(self.names, own, strict=True) if mine)
        return [name for name in found if name in self.free or name == GAIN]

    @property
    def scatter(self) -> Scatter:
        """What differs from test to test beyond parameters and noise, as a factor on the response and one on the frequency.

        By least squares ln(measured/computed) = a − b d ln|h|/d ln f in each test; a and b count where their sum of squares in
        standard errors is one that noise reaches in 5 % of all cases only. The parameters that all tests share take
        up some of it: of 2 n such numbers only 2 n − p are free.
        """
        fitted = [found for t in range(self.tests) if (found := _own_factors(self.dataset.isel(test=t))) is not None]
        count, shared = len(fitted), int(np.sum(self.dataset["fit_test"].values < 0))
        if count < 2:
            return Scatter(0.0, 0.0, 0.0)
        values, errors = np.array([each[0] for each in fitted]), np.array([each[1] for each in fitted])
        freedom = max(2.0 * count - shared, 1.0)
        large = np.sum((values / errors) ** 2, axis=0) > special.chdtri(count, SIGNIFICANCE)
        excess = np.maximum(np.mean(values**2 - errors**2, axis=0), 0.0) * 2.0 * count / freedom
        gain, shift = np.sqrt(np.where(large, excess, 0.0))
        return Scatter(float(gain), float(shift), freedom)

    def lines(self, levels: Array) -> list[str]:
        """What each test has by itself and that a straight line over the levels of the tests (tests,) explains beyond chance."""
        return [name for name in self.of_each_test if self._line(name, levels) is not None]

    def _of_a_further_test(self, name: str, at: tuple[Array, float] | None) -> tuple[float, float, int]:
        """What a further test has by itself: mean, standard error and degrees of freedom, by the line over the levels if any."""
        values = self.dataset["fit_value"].values[self._at(name)]
        line = None if at is None else self._line(name, at[0])
        if line is None or at is None:
            return float(values.mean()), float(np.std(values, ddof=1)) * float(np.sqrt(1.0 + 1.0 / values.size)), values.size - 1
        return line.at(at[1]), line.spread(at[1]), values.size - 2

    def _line(self, name: str, levels: Array) -> "Line | None":
        values = self.dataset["fit_value"].values[self._at(name)]
        return line_over(levels, values) if values.size == levels.size else None

    def drawn(self, count: int, seed: int, at: tuple[Array, float] | None = None) -> list[Draw]:
        """So many draws inside the bounds, stratified in each variable (Latin hypercube). at: levels of the tests (tests,) and
        the level of the further one, on which what each test has by itself may depend along a line."""
        generator = np.random.default_rng(seed)
        own, scatter = self.of_each_test, self.scatter
        # Latin hypercube: one in each of `count` strata of every column.
        size = len(self.names) + len(own) + 3
        strata = np.stack([generator.permutation(count) for _ in range(size)], axis=1)
        shares = np.asarray((strata + generator.uniform(size=(count, size))) / count)
        variables = self._variables(shares[:, : len(self.names)], generator)
        deviations = shares[:, len(self.names) : len(self.names) + len(own)]
        spread = special.stdtrit(max(scatter.freedom, 1.0), 0.975) / CERTAINTY
        found = []
        for x, apart, last in zip(variables, deviations, shares[:, -3:], strict=True):
            normal = special.ndtri(last[:2]) * spread * np.array([scatter.gain, scatter.shift])
            others = normal[0], normal[1], 2.0 * last[2] - 1.0
            found.append(self._drawn(x, dict(zip(own, apart, strict=True)), others, at))
        return found

    def best_at(self, at: tuple[Array, float] | None) -> Draw:
        """The identified parameters; of what each test has by itself the mean, or the line at a level."""
        return self._drawn(self.dataset["fit_value"].values, {}, (0.0, 0.0, 0.0), at)

    def _variables(self, shares: Array, generator: np.random.Generator) -> Array:
        """Variables (draws, variables) from shares between 0 and 1."""
        data = self.dataset
        low, high, unknown = data["fit_low"].values, data["fit_high"].values, data["fit_unknown"].values > 0.0
        middle, covariance = np.clip(data["fit_value"].values, low, high), data["fit_covariance"].values
        scale = np.sqrt(np.maximum(np.diag(covariance), 1e-300))
        values, vectors = np.linalg.eigh(covariance / np.outer(scale, scale))
        root = scale[:, None] * vectors * np.sqrt(np.maximum(values, 0.0))  # R of the covariance R Rᵀ

        def of(share: Array) -> Array:
            return np.asarray(np.where(unknown, low + share * (high - low), middle + special.ndtri(share) @ root.T))

        found = of(shares)
        for k in np.flatnonzero(np.any((found < low) | (found > high), axis=1)):
            for _ in range(ATTEMPTS):
                found[k] = of(np.asarray(generator.uniform(size=shares.shape[1])))
                if np.all((found[k] >= low) & (found[k] <= high)):
                    break
        return np.clip(found, low, high)

    def _drawn(
        self, x: Array, apart: Mapping[str, float], others: tuple[float, float, float], at: tuple[Array, float] | None
    ) -> Draw:
        """What variables mean; apart: of what each test has by itself, the share of the scatter of a further test, at a level."""
        low, high, fitted = (self.dataset[f"fit_{key}"].values for key in ("low", "high", "value"))

        def variable(name: str) -> float:
            own = self._at(name)
            if own.size == 1:
                return float(x[own[0]])
            middle, error, freedom = self._of_a_further_test(name, at)
            found = middle + float(np.mean(x[own] - fitted[own]))
            if name in apart:
                found += error * float(special.stdtrit(freedom, apart[name]))
            return float(np.clip(found, low[own[0]], high[own[0]]))

        values = {name: free.value(variable(name)) for name, free in self.free.items()}
        gain = variable(GAIN) if self._at(GAIN).size else 0.0
        return Draw(values, gain + others[0], others[1], others[2])


@dataclass(frozen=True)
class Line:
    """A straight line through values over levels by least squares, with what the values scatter about it."""

    slope: float
    middle: tuple[float, float]
    ends: tuple[float, float]
    deviation: float
    tests: int
    width: float

    def at(self, level: float) -> float:
        """The value at a level; beyond the tests that at the nearest one, since nothing says that the line goes on."""
        return self.middle[1] + self.slope * (float(np.clip(level, *self.ends)) - self.middle[0])

    def spread(self, level: float) -> float:
        """Standard error of a further value at a level, s √(1 + 1/n + (L − L̄)²/Σ(L − L̄)²)."""
        return self.deviation * float(np.sqrt(1.0 + 1.0 / self.tests + (level - self.middle[0]) ** 2 / self.width))


def line_over(levels: Array, values: Array) -> "Line | None":
    """The line of values over levels (tests,), None where chance alone gives such a slope in `SIGNIFICANCE` of all cases."""
    if values.size < FEWEST_ON_A_LINE or not np.ptp(levels) > 0.0:
        return None
    across = levels - levels.mean()
    width = float(across @ across)
    slope = float(across @ values) / width
    left = values - values.mean() - slope * across
    square = float(left @ left) / (values.size - 2)
    t = abs(slope) / np.sqrt(max(square, np.finfo(float).tiny) / width)
    if 2.0 * special.stdtr(values.size - 2, -t) > SIGNIFICANCE:
        return None
    ends = float(levels.min()), float(levels.max())
    return Line(slope, (float(levels.mean()), float(values.mean())), ends, float(np.sqrt(square)), values.size, width)


def interval(values: Array, axis: int = -1) -> Array:
    """Percentiles 2.5, 50 and 97.5 (3, ...) along an axis of draws, at p (n + 1) of n ordered ones; of numbers alone."""
    rows = np.moveaxis(values, axis, -1)
    flat = rows.reshape(-1, rows.shape[-1])
    found = np.full((3, len(flat)), np.nan)
    for k, row in enumerate(flat):
        there = row[np.isfinite(row)]
        if there.size:
            found[:, k] = np.percentile(there, (ENDS[0], 50.0, ENDS[1]), method="weibull")
    return found.reshape(3, *rows.shape[:-1])


def of_draws(name: str, values: Array, axis: int) -> dict[str, Array]:
    """Variables of values along an axis of draws: NAME, the median of the draws, NAME_low and NAME_high, the ends of the
    interval, and NAME_drawn, the values."""
    return dict(zip((f"{name}_low", name, f"{name}_high"), interval(values, axis), strict=True)) | {f"{name}_drawn": values}


def _own_factors(test: "xr.Dataset") -> tuple[Array, Array] | None:
    """Factors a and b of a test with their standard errors, (2,) each; None of too few points."""
    solved = (test["solved"].values > 0.0) & np.isfinite(test["frequency"].values)
    order = np.argsort(test["frequency"].values[solved], kind="stable")
    f, measured, computed = (test[key].values[solved][order] for key in ("frequency", "measured", "computed"))
    if np.unique(f).size < max(FEWEST_POINTS, f.size):
        return None
    rows = np.column_stack([np.ones(f.size), -np.gradient(np.log(computed), np.log(f))])
    inverse = np.linalg.pinv(rows.T @ rows)
    left = np.log(measured / computed)
    values = inverse @ rows.T @ left
    square = float(np.sum((left - rows @ values) ** 2)) / (f.size - 2)
    return values, np.sqrt(np.maximum(square * np.diag(inverse), 1e-30))
