"""Checks of arguments that several analyses share."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import Annotated, Any, get_args

import numpy as np
from numpy.typing import ArrayLike

from stickslip.analyses.settings import OfKind, OneOf, Setting, Whole
from stickslip.model.problem import Problem
from stickslip.solve.balance.fourier import fourier
from stickslip.solve.balance.measure import measure_of
from stickslip.solve.balance.orders import MOST_SAMPLES, Harmonics, checked_harmonics, fineness, highest
from stickslip.solve.starts.space import Rules, Sharing, rules_of
from stickslip.support.checks import (
    LARGEST_SEED,
    InputError,
    fault,
    finite,
    numbers,
    of_kind,
    positive,
    unique,
    vector,
    whole,
)
from stickslip.support.units import Band, followed

Ends = tuple[float, float]


def quantity_name(name: str, value: Any) -> str:
    """The name of a quantity, displacement for instance."""
    return measure_of(value, "amplitude").name


def measure_name(name: str, value: Any) -> str:
    """The name of a measure, amplitude for instance."""
    return measure_of("displacement", value).kind


def harmonic_numbers(name: str, value: Any) -> Harmonics:
    """H, or a list of harmonics that holds 1."""
    return checked_harmonics(value)


def _somewhere(name: str, band: Any) -> Band | list[float]:
    return band if isinstance(band, Band) else followed(band)


def _rule(name: str, value: Any) -> Rules:
    rules = rules_of(value)
    return rules[0] if len(rules) == 1 else rules


OfProblem = Annotated[Problem, Setting(OfKind(Problem))]
Frequencies = Annotated[Band | Sequence[float], Setting(_somewhere)]
HarmonicNumbers = Annotated[int | Sequence[int], Setting(harmonic_numbers)]
Samples = Annotated[int, Setting(Whole(1, MOST_SAMPLES))]
OutputNumber = Annotated[int, Setting(whole)]
QuantityName = Annotated[str, Setting(quantity_name)]
MeasureName = Annotated[str, Setting(measure_name)]
ForceLevels = Annotated[float | Sequence[float], Setting(lambda name, value: force_levels(value))]
Rule = Annotated[
    Rules,
    Setting(_rule, 'quantity that a start variable sets; a list: in t1 and in t2, where "virgin" leaves the sliders at 0'),
]
Share = Annotated[Sharing, Setting(OneOf(get_args(Sharing)), "which friction elements share a start variable")]
Seed = Annotated[int, Setting(Whole(0, LARGEST_SEED), "seed of the random draws")]


def force_levels(force: float | Sequence[float]) -> tuple[float, ...]:
    """Force levels, checked: positive and different."""
    levels = tuple(positive("A force level", level) for level in np.atleast_1d(numbers("force", force)))
    if not levels:
        raise InputError("force must hold at least one level, but is empty.")
    unique("Force levels", levels)
    return levels


def ratios_of(name: str, force_ratio: ArrayLike) -> tuple[float, ...]:
    """Values of F_C/F_E, ascending: at least one, positive, each once."""
    values = np.atleast_1d(numbers(name, force_ratio))
    if values.ndim != 1 or values.size == 0:
        raise fault(name, "must be a list of at least one number", values.tolist())
    ratios = sorted(positive(name, value) for value in values.tolist())
    unique(name, ratios)
    return tuple(ratios)


def frictions_of(name: str, friction: ArrayLike) -> tuple[float, ...]:
    """Friction coefficients of a performance curve."""
    values: list[float] = vector(name, friction).tolist()
    if not values:
        raise fault(name, "must hold at least one coefficient", values, "Leave it out for those of the problem.")
    if min(values) < 0.0:
        raise fault(name, "must not be negative", min(values))
    if min(values) == 0.0:
        remedy = "Contacts without friction damp nothing: the resonance does not depend on F_C/F_E."
        raise fault(name, "must be positive for a performance curve", 0.0, remedy)
    unique(name, values)
    return tuple(values)


def over_a_band(name: str, band: Any) -> Band:
    """A band, and no list of frequencies."""
    if not isinstance(band, Band):
        raise fault(name, "must be a Band, as of ss.hertz(480, 600)", band)
    return band


def ends_of(band: Any) -> Ends:
    """The ends of a band in Hz."""
    band = over_a_band("band", band)
    return band.low, band.high


def ranges_of(what: str, ranges: Any) -> dict[str, Ends]:
    """{name: (low, high)} with low below high, at least one."""
    if not isinstance(ranges, Mapping) or not ranges:
        raise fault(what, "must be {name: (low, high)} with at least one", ranges)
    found = {}
    for name, pair in ranges.items():
        own = f"{what}, {name}"
        ends = vector(own, pair).tolist()
        if len(ends) != 2 or not ends[0] < ends[1]:
            raise fault(own, "must be (low, high) with low below high", pair)
        found[name] = finite(own, ends[0]), finite(own, ends[1])
    return found


def point_of(what: str, given: Any, ranges: Mapping[str, Ends]) -> tuple[float, ...]:
    """A value within its range for every name, in the order of the ranges."""
    if not isinstance(given, Mapping) or set(given) != set(ranges):
        raise fault(what, f"must give {', '.join(ranges)}, and nothing else", given)
    point = {name: finite(f"{what}, {name}", given[name]) for name in ranges}
    for name, (low, high) in ranges.items():
        if not low <= point[name] <= high:
            raise fault(f"{what}, {name}", f"must be {low:g} to {high:g}", point[name])
    return tuple(point.values())


def output_of(problem: Problem, output: Any, what: str = "output") -> int:
    """The number of an output of a problem; what: the argument that names it."""
    of_kind("problem", problem, Problem)
    number = whole(what, output)
    if not 0 <= number < len(problem.outputs):
        raise fault(what, f"must be 0 to {len(problem.outputs) - 1}", number)
    return number


def fineness_of(harmonics: Any, samples: Any) -> tuple[Harmonics, int]:
    """Harmonics and samples that go together."""
    fine = fineness(harmonics, samples)
    fourier(highest(fine[0]), fine[1])
    return fine


def maker(name: str, problem_of: Any) -> Callable[..., Problem]:
    """A function that makes problems, whose wrong products `made` refuses."""
    if isinstance(problem_of, Problem) or not callable(problem_of):
        raise fault(name, "must be a function that returns a Problem", problem_of)
    return problem_of  # type: ignore[no-any-return]


def made(problem_of: Callable[..., Problem], *places: float, **values: float) -> Problem:
    """What `problem_of` returns for values: a Problem; a function that does not take them is refused."""
    given = ", ".join([f"{value:g}" for value in places] + [f"{name}={value:g}" for name, value in values.items()])
    try:
        problem = problem_of(*places, **values)
    except InputError:
        raise
    except (TypeError, ArithmeticError, ValueError, KeyError, AttributeError) as error:
        raise InputError(f"problem_of({given}) must return a Problem, but raises {type(error).__name__}: {error}.") from error
    return of_kind(f"problem_of({given})", problem, Problem)
