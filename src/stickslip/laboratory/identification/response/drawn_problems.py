"""What all predictions from an identification have in common: its draws, their problems, and how the contacts start."""

from __future__ import annotations

import json
from collections.abc import Callable, Mapping, Sequence
from dataclasses import KW_ONLY, dataclass
from functools import cached_property
from typing import Annotated, Any, Literal, Protocol, get_args

import numpy as np
from scipy import special

from stickslip.analyses.forced_response import forced_response
from stickslip.analyses.settings import Execution, OfKind, OneOf, Seed, Setting, Whole, made
from stickslip.laboratory.identification.response.draws import Draw, Draws
from stickslip.model.problem import Problem
from stickslip.model.rigs import single_mass
from stickslip.solve.balance.balance import HarmonicBalance
from stickslip.solve.balance.measure import Measure, measure_of
from stickslip.solve.starts.states import StartSpace, explored_space
from stickslip.support.checks import Array, fault, finite, of_kind
from stickslip.support.late import xr
from stickslip.support.units import Band

FEWEST_DRAWS = 20
"""Draws at least."""

StartStates = Literal["identified", "virgin", "any"]
StartsOfDraws = Annotated[StartStates, Setting(OneOf(get_args(StartStates)))]


class Identification(Protocol):
    """What is predicted from: the dataset of an identification, and the problem of its parameters."""

    @property
    def dataset(self) -> xr.Dataset: ...

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
    def data(self) -> xr.Dataset:
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
        return "any" if known == "bounds" else known, rule, str(attrs["share"]), float(attrs["start_deviation"])

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

    def prepare(self) -> None:
        """Compile the kernels, or load them from disk, with the smallest problem there is."""
        forced_response(single_mass(), [0.1], harmonics=1, samples=8)

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
