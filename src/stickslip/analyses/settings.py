"""Settings of an analysis, declared once: the fields of a frozen dataclass derived from `Settings`.

They are the arguments of its function in Python (`takes`), what travels to processes, what names a case (`identity`) and, by
`study/fields.py`, the keys of its table in a study. The dataclass is the `Work` of the analysis as a rule.

What works of several analyses share: what travels to other processes, and the balance that their cases solve.

Checks of arguments that several analyses share.

Settings of a forced response, which speed sweeps, other analyses and the table [sweep] of studies share.
"""

import inspect
from collections.abc import Callable, Mapping, Sequence
from dataclasses import KW_ONLY, dataclass, fields
from functools import cached_property, wraps
from typing import Annotated, Any, Literal, ParamSpec, TypeVar, get_args, get_type_hints

import numpy as np
from numpy.typing import ArrayLike

from stickslip.model.problem import Problem
from stickslip.runs.cases import Checkpoint, Progress, Workers, silent
from stickslip.solve.balance.balance import HarmonicBalance
from stickslip.solve.balance.fourier import MOST_SAMPLES, Harmonics, checked_harmonics, fineness, fourier, highest
from stickslip.solve.balance.measure import Measure, measure_of
from stickslip.solve.peaks.search import TOLERANCE
from stickslip.solve.starts.states import Rules, Sharing, rules_of
from stickslip.support import checks
from stickslip.support.checks import InputError, fault
from stickslip.support.machine import one_blas_thread
from stickslip.support.units import Band, followed

EXECUTION = ("workers", "checkpoint", "progress")
"""Arguments that say how cases are computed: they do not travel, and no result depends on them."""


class StateOfFields:
    """A dataclass of which the fields alone travel to a process, not what was built from them."""

    def __getstate__(self) -> dict[str, Any]:
        names = [field.name for field in fields(self)]  # type: ignore[arg-type]
        return {name: getattr(self, name) for name in names if name not in EXECUTION}

    def prepare(self) -> None:
        """Nothing that its cases share; works of which they share something say so."""


class OneBalance(StateOfFields):
    """A work whose cases share one balance."""

    problem: Problem
    harmonics: Any
    samples: int

    @property
    def periods(self) -> int:
        """Of the excitation, over which a motion is expanded."""
        return 1

    @cached_property
    def balance(self) -> HarmonicBalance:
        with one_blas_thread():
            return HarmonicBalance(self.problem, self.harmonics, self.samples, self.periods)


Arguments = ParamSpec("Arguments")
Given = TypeVar("Given")
Result = TypeVar("Result")


@dataclass(frozen=True)
class Setting:
    """The mark of a field, in `Annotated`.

    check: takes name and value, and returns what is kept or raises a `fault`. It must accept what it has returned, since copies
    are checked again, and is not asked about None where that is the default. Inside a class it stands there by its name: a
    lambda in the text of an annotation does not see its module.
    means: for the reference of study files; a setting without a meaning is no key of the table. key: its name there, where that
    is another.
    """

    check: Callable[[str, Any], Any]
    means: str = ""
    key: str = ""


@dataclass(frozen=True)
class Whole:
    """The check of a whole number, whose bounds the table of a study takes over."""

    least: int
    most: int = checks.MOST

    def __call__(self, name: str, value: Any) -> int:
        return checks.between(name, value, self.least, self.most)


@dataclass(frozen=True)
class Within:
    """The check of a number between two bounds that it does not meet, which the table of a study takes over."""

    low: float
    high: float

    def __call__(self, name: str, value: Any) -> float:
        number = checks.finite(name, value)
        if not self.low < number < self.high:
            raise fault(name, f"must lie between {self.low:g} and {self.high:g}", number)
        return number


@dataclass(frozen=True)
class OfKind:
    """The check of an object of a class."""

    kind: type[Any]

    def __call__(self, name: str, value: Any) -> Any:
        return checks.of_kind(name, value, self.kind)


@dataclass(frozen=True)
class OneOf:
    """The check of one of some words."""

    words: tuple[str, ...]

    def __call__(self, name: str, value: Any) -> str:
        return checks.among(name, value, self.words)


@dataclass(frozen=True, eq=False)
class Settings(StateOfFields):
    """Checks its marked fields when it is made; what two fields need together, `__post_init__` of a subclass checks after."""

    def __post_init__(self) -> None:
        for name, mark in marks(type(self)).items():
            if not not_given(type(self), name, getattr(self, name)):
                object.__setattr__(self, name, mark.check(name, getattr(self, name)))

    @property
    def words(self) -> Sequence[str]:
        """What each case is, for the console."""
        raise NotImplementedError

    @property
    def names(self) -> Sequence[str]:
        """Everything that each case depends on; a work whose words may be the same for two cases has names of its own."""
        return [f"{words}: {self.identity()}" for words in self.words]

    def identity(self, *but: str) -> str:
        """Everything that results depend on, less the fields that are named."""
        kept = {each.name: getattr(self, each.name) for each in fields(self) if each.name not in (*EXECUTION, *but)}
        return ", ".join(f"{name} {getattr(value, 'fingerprint', repr(value))}" for name, value in kept.items())


@dataclass(frozen=True, eq=False)
class Execution(Settings):
    """How the cases of an analysis are computed; no result depends on it."""

    _: KW_ONLY
    workers: Workers = 1
    checkpoint: Checkpoint | None = None
    progress: Progress = silent


def not_given(kind: type[Settings], name: str, value: Any) -> bool:
    """Whether a setting is None by default, and is None."""
    return value is None and getattr(kind, name, ...) is None


_KNOWN: dict[type[Settings], Mapping[str, Setting]] = {}


def marks(kind: type[Settings]) -> Mapping[str, Setting]:
    """The marks of the fields that have one, in their order; read once, since they stand in the text of the class."""
    if kind not in _KNOWN:
        hints = get_type_hints(kind, include_extras=True)
        found = {each.name: getattr(hints[each.name], "__metadata__", ()) for each in fields(kind)}
        _KNOWN[kind] = {name: mark for name, given in found.items() for mark in given if isinstance(mark, Setting)}
    return _KNOWN[kind]


def takes(kind: Callable[Arguments, Given]) -> Callable[[Callable[[Given], Result]], Callable[Arguments, Result]]:
    """A function of one object as a function of its flat arguments, whose types and defaults type checkers and `help` show."""
    hints, signature = get_type_hints(kind), inspect.signature(kind)
    last = sorted(signature.parameters.values(), key=lambda each: each.name in EXECUTION)
    plain = [each.replace(annotation=hints[each.name]) for each in last]

    def decorate(body: Callable[[Given], Result]) -> Callable[Arguments, Result]:
        @wraps(body)
        def function(*args: Arguments.args, **kwargs: Arguments.kwargs) -> Result:
            try:
                signature.bind(*args, **kwargs)
            except TypeError as error:
                raise TypeError(f"{body.__name__}() {error}") from None
            return body(kind(*args, **kwargs))

        returned = inspect.signature(body).return_annotation
        function.__signature__ = signature.replace(parameters=plain, return_annotation=returned)  # type: ignore[attr-defined]
        function.__annotations__ = {each.name: each.annotation for each in plain} | {"return": returned}
        return function

    return decorate


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


def _rule(name: str, value: Any) -> Rules:
    rules = rules_of(value)
    return rules[0] if len(rules) == 1 else rules


def _problem(name: str, value: Any) -> Problem:
    """A problem with all its rows: how contacts deform a mesh, forced responses and modes alone find out."""
    problem: Problem = checks.of_kind(name, value, Problem)
    if problem.mesh is not None:
        rule = "must have a row for each direction of its contacts"
        raise fault(name, rule, "on a mesh", "Give `forced_response`, or keep the rows of its contacts (`read_structure`).")
    return problem


def _with_shapes(name: str, value: Any) -> Problem:
    """A problem with all its rows, or with the shapes of contact forces that a forced response found; results state the error."""
    problem: Problem = checks.of_kind(name, value, Problem)
    if problem.mesh is not None and not problem.mesh.solved:
        rule = "must have the shapes of its contact forces"
        remedy = "Give `forced_response(...).problem`, or keep the rows of its contacts (`read_structure`)."
        raise fault(name, rule, "a mesh without them", remedy)
    return problem


AnyProblem = Annotated[Problem, Setting(OfKind(Problem))]
OfProblem = Annotated[Problem, Setting(_problem)]
ProblemWithShapes = Annotated[Problem, Setting(_with_shapes)]
Frequencies = Annotated[Band | Sequence[float], Setting(lambda name, band: band if isinstance(band, Band) else followed(band))]
HarmonicNumbers = Annotated[int | Sequence[int], Setting(harmonic_numbers)]
Samples = Annotated[int, Setting(Whole(1, MOST_SAMPLES))]
OutputNumber = Annotated[int, Setting(checks.whole)]
QuantityName = Annotated[str, Setting(quantity_name)]
MeasureName = Annotated[str, Setting(measure_name)]
ForceLevels = Annotated[float | Sequence[float], Setting(lambda name, value: force_levels(value))]
Rule = Annotated[
    Rules, Setting(_rule, 'quantity that a start variable sets; a list: in t1 and in t2, where "virgin" leaves the sliders at 0')
]
Share = Annotated[Sharing, Setting(OneOf(get_args(Sharing)), "which friction elements share a start variable")]
Seed = Annotated[int, Setting(Whole(0, checks.LARGEST_SEED), "seed of the random draws")]


@dataclass(frozen=True, eq=False)
class Measured(Settings):
    """What amplitudes are of: a quantity, and a measure of it."""

    _: KW_ONLY
    quantity: QuantityName = "displacement"
    measure: MeasureName = "amplitude"

    @property
    def measured(self) -> Measure:
        return measure_of(self.quantity, self.measure)


@dataclass(frozen=True, eq=False)
class MeasuredOutput(Measured):
    """The output whose amplitudes these are, by its number."""

    _: KW_ONLY
    output: OutputNumber = 0


@dataclass(frozen=True, eq=False)
class Sampled(Settings):
    """Harmonics of a motion, and samples of its period."""

    _: KW_ONLY
    harmonics: HarmonicNumbers = 5
    samples: Samples = 256


class AtLevels(StateOfFields):
    """A work at one or several force levels."""

    force: Any

    @property
    def levels(self) -> tuple[float, ...]:
        """The force levels, checked."""
        return force_levels(self.force)


def force_levels(force: float | Sequence[float]) -> tuple[float, ...]:
    """Force levels, checked: positive and different."""
    levels = tuple(checks.positive("A force level", level) for level in np.atleast_1d(checks.numbers("force", force)))
    if not levels:
        raise InputError("force must hold at least one level, but is empty.")
    checks.unique("Force levels", levels)
    return levels


def ratios_of(name: str, force_ratio: ArrayLike) -> tuple[float, ...]:
    """Values of F_C/F_E, ascending: at least one, positive, each once."""
    values = np.atleast_1d(checks.numbers(name, force_ratio))
    if values.ndim != 1 or values.size == 0:
        raise fault(name, "must be a list of at least one number", values.tolist())
    ratios = sorted(checks.positive(name, value) for value in values.tolist())
    checks.unique(name, ratios)
    return tuple(ratios)


def frictions_of(name: str, friction: ArrayLike) -> tuple[float, ...]:
    """Friction coefficients of a performance curve."""
    values: list[float] = checks.vector(name, friction).tolist()
    if not values:
        raise fault(name, "must hold at least one coefficient", values, "Leave it out for those of the problem.")
    if min(values) < 0.0:
        raise fault(name, "must not be negative", min(values))
    if min(values) == 0.0:
        remedy = "Contacts without friction damp nothing: the resonance does not depend on F_C/F_E."
        raise fault(name, "must be positive for a performance curve", 0.0, remedy)
    checks.unique(name, values)
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
        ends = checks.vector(own, pair).tolist()
        if len(ends) != 2 or not ends[0] < ends[1]:
            raise fault(own, "must be (low, high) with low below high", pair)
        found[name] = checks.finite(own, ends[0]), checks.finite(own, ends[1])
    return found


def point_of(what: str, given: Any, ranges: Mapping[str, Ends]) -> tuple[float, ...]:
    """A value within its range for every name, in the order of the ranges."""
    if not isinstance(given, Mapping) or set(given) != set(ranges):
        raise fault(what, f"must give {', '.join(ranges)}, and nothing else", given)
    point = {name: checks.finite(f"{what}, {name}", given[name]) for name in ranges}
    for name, (low, high) in ranges.items():
        if not low <= point[name] <= high:
            raise fault(f"{what}, {name}", f"must be {low:g} to {high:g}", point[name])
    return tuple(point.values())


def output_of(problem: Problem, output: Any, what: str = "output") -> int:
    """The number of an output of a problem; what: the argument that names it."""
    checks.of_kind("problem", problem, Problem)
    number = checks.whole(what, output)
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
    return checks.of_kind(f"problem_of({given})", problem, Problem)


OR_AUTO = 'Or write "auto".'


def _harmonics(name: str, value: Any) -> Harmonics | Literal["auto"]:
    return "auto" if isinstance(value, str) and value == "auto" else checked_harmonics(value, OR_AUTO)


@dataclass(frozen=True, eq=False)
class Fineness(AtLevels, Settings):
    """The force levels, and how finely each curve is computed."""

    force: Annotated[
        float | Sequence[float],
        Setting(lambda name, value: force_levels(value), "factors on every harmonic force", key="force_levels"),
    ] = 1.0
    harmonics: Annotated[
        int | Sequence[int] | Literal["auto"],
        Setting(
            _harmonics,
            'H, highest harmonic, or a list that holds 1, such as [0, 1, 3, 5]; "auto": raised, and samples doubled, until the '
            "rest at the peaks is below `tolerance`, where the contacts start as the problem says",
        ),
    ] = 5
    samples: Annotated[int, Setting(Whole(1, MOST_SAMPLES), "samples of a period")] = 256
    _: KW_ONLY
    tolerance: Annotated[
        float, Setting(Within(0.0, 0.5), 'for harmonics = "auto": left-out motion of the contacts, relative')
    ] = 2e-3
    peak_tolerance: Annotated[float, Setting(Within(0.0, 0.1), "relative amplitude by which a peak may be too low")] = TOLERANCE

    @property
    def fineness(self) -> dict[str, Any]:
        """These settings by name."""
        return {each.name: getattr(self, each.name) for each in fields(Fineness)}


@dataclass(frozen=True, eq=False)
class OverBand(Settings):
    """A problem and the frequencies in Hz: a band, or a list in the order of travel."""

    problem: AnyProblem
    band: Frequencies

    @property
    def listed(self) -> bool:
        """Whether only the frequencies of a list are wanted."""
        return not isinstance(self.band, Band)

    @property
    def frequencies(self) -> tuple[float, ...]:
        """In Hz, in the order of travel: the ends of a band, or those of a list."""
        return (self.band.start, self.band.stop) if isinstance(self.band, Band) else tuple(self.band)


@dataclass(frozen=True, eq=False)
class ForcedResponseSettings(Measured, Fineness, OverBand, Execution):
    """The arguments of `forced_response`."""

    quantity: Annotated[str, Setting(quantity_name, "what the peaks, bounds and optima are of")] = "displacement"
    measure: Annotated[
        str,
        Setting(measure_name, "how the signal becomes one number: first-harmonic amplitude, RMS, or largest value in the period"),
    ] = "amplitude"
    periods: Annotated[int, Setting(checks.whole)] = 1
    isolated: Annotated[bool | None, Setting(OfKind(bool))] = None
