"""Field types of study files. All are strict: no text for numbers, no unknown keys, no NaN.

A value that may have several forms (a number or a list) is a union that looks at the form first, so that a fault is reported
about the form the author meant. The marks of such forms are in angle brackets and never reach a message.

Units of a study file and their conversion to SI, confined to the study layer.

Each field of a table carries its `Dimension`; one function scales them all. Angles are in rad.

Tables of studies from the settings of analyses: keys, ranges, defaults and meanings are those of Python.
"""

from collections.abc import Callable, Mapping
from dataclasses import MISSING, asdict, dataclass, fields
from inspect import signature
from math import pi
from typing import Annotated, Any, ClassVar, Literal, TypeVar, get_type_hints

from pydantic import AfterValidator, BaseModel, ConfigDict, Discriminator, Field, Tag, create_model
from pydantic_core import PydanticCustomError

from stickslip.analyses.settings import Settings, Whole, Within, marks, not_given
from stickslip.support.checks import LARGEST, LARGEST_SEED, SMALLEST, Faults, InputError, fault, nearest
from stickslip.support.units import UNIT_SYSTEMS, UnitSystem

Groups = tuple[tuple[str, ...], ...]


@dataclass(frozen=True)
class Words:
    """What the reference calls a type."""

    text: str


class Table(BaseModel):
    """A table of a study file. What a key means stands in its `Field`, or below it where the sentence is long."""

    model_config = ConfigDict(extra="forbid", frozen=True, strict=True, defer_build=True)

    exactly_one: ClassVar[Groups] = ()
    """Groups of keys of which one and only one must be given."""
    at_most_one: ClassVar[Groups] = ()
    """Groups of keys that exclude each other."""
    together: ClassVar[tuple[tuple[str, str], ...]] = ()
    """Pairs of keys of which either both or none must be given."""
    in_place_of: ClassVar[dict[str, str]] = {}
    """Keys that stand for another one in these pairs: {"surface": "normal"}, and free its partner."""

    def check(self) -> None:
        """Refuse what the types of its keys cannot show."""


def _form(value: Any) -> str:
    if isinstance(value, dict):
        return "<table>"
    return "<list>" if isinstance(value, list) else "<single>"


def _places_form(value: Any) -> str:
    if isinstance(value, list) and not (value and all(isinstance(item, str) for item in value)):
        return "<several>"
    return _form(value)


def by_form(form: Callable[[Any], str] = _form) -> Discriminator:
    """A union discriminated by `form`; a form that no member has is reported with the forms of all (`faults.FORMS`)."""
    return Discriminator(form)


Column = Annotated[
    Annotated[str, Tag("<title>")] | Annotated[int, Tag("<number>")],
    by_form(lambda value: "<title>" if isinstance(value, str) else "<number>"),
]
"""A column of a file by its title, or by its number from 1."""


def _not_huge(value: float) -> float:
    """As `checks.finite` refuses it, with the place in the file."""
    if abs(value) > LARGEST:
        raise PydanticCustomError("too_large", "too large")
    return value


def _not_tiny(value: float) -> float:
    """As `checks.positive` refuses it, with the place in the file."""
    if value < SMALLEST:
        raise PydanticCustomError("too_small", "too small")
    return value


NotHuge, NotTiny = AfterValidator(_not_huge), AfterValidator(_not_tiny)

Number = Annotated[float, Field(allow_inf_nan=False), NotHuge]
Positive = Annotated[float, Field(gt=0, allow_inf_nan=False), NotHuge, NotTiny]
NotNegative = Annotated[float, Field(ge=0, allow_inf_nan=False), NotHuge]

QuantityName = Literal["displacement", "velocity", "acceleration", "receptance", "mobility", "inertance"]
"""What peaks are of; the last three are the same per force level."""

Harmonics = Annotated[
    Annotated[int, Field(ge=1, le=1000), Tag("<single>")]
    | Annotated[list[Annotated[int, Field(ge=0, le=1000)]], Field(min_length=1), Tag("<list>")],
    by_form(),
]
"""H for 0..H, or a list."""

Seed = Annotated[int, Field(ge=0, le=LARGEST_SEED)]

Vector = Annotated[list[Number], Field(min_length=3, max_length=3), Words("list of three numbers")]

Ratio = Annotated[float, Field(ge=-1, le=1)]

Numbers = Annotated[Annotated[Number, Tag("<single>")] | Annotated[list[Number], Tag("<list>")], by_form()]
Positives = Annotated[
    Annotated[Positive, Tag("<single>")] | Annotated[list[Positive], Field(min_length=1), Tag("<list>")], by_form()
]
NotNegatives = Annotated[
    Annotated[NotNegative, Tag("<single>")] | Annotated[list[NotNegative], Field(min_length=1), Tag("<list>")], by_form()
]

Coefficients = Annotated[dict[str, Number], Field(min_length=1), Words("table of coefficients")]
Pair = Annotated[list[str], Field(min_length=2, max_length=2), Words("pair of names")]
Direction = Annotated[Annotated[Pair, Tag("<list>")] | Annotated[Coefficients, Tag("<table>")], by_form(), Words("direction")]
Directions = Annotated[
    Annotated[Pair, Tag("<list>")]
    | Annotated[Coefficients, Tag("<table>")]
    | Annotated[list[Direction], Field(min_length=1, max_length=2), Tag("<several>")],
    by_form(_places_form),
    Words("direction or list of two directions"),
]
"""One direction (two names, or a table of coefficients), or a list of one or two of them."""

Place = Annotated[
    Annotated[str, Tag("<single>")] | Annotated[Coefficients, Tag("<table>")], by_form(), Words("name or table of coefficients")
]
Amplitude = Annotated[
    Annotated[Number, Tag("<single>")] | Annotated[list[Number], Field(min_length=2, max_length=2), Tag("<list>")],
    by_form(),
    Words("number or pair of numbers"),
]


AnyTable = TypeVar("AnyTable", bound=Table)


@dataclass(frozen=True)
class Dimension:
    """Powers of force, length, time, mass and frequency of a field, and its SI unit as text."""

    symbol: str
    force: int = 0
    length: int = 0
    time: int = 0
    mass: int = 0
    frequency: int = 0


STIFFNESS = Dimension("N/m", force=1, length=-1)
CUBIC_STIFFNESS = Dimension("N/m3", force=1, length=-3)
VISCOSITY = Dimension("N s/m", force=1, length=-1, time=1)
ACCELERATION = Dimension("m/s2", length=1, time=-2)
VELOCITY = Dimension("m/s", length=1, time=-1)
FORCE = Dimension("N", force=1)
LENGTH = Dimension("m", length=1)
TIME = Dimension("s", time=1)
MASS = Dimension("kg", mass=1)
INERTIA = Dimension("kg m2", mass=1, length=2)
PRESSURE = Dimension("Pa", force=1, length=-2)
DENSITY = Dimension("kg/m3", mass=1, length=-3)
FREQUENCY = Dimension("Hz", frequency=1)
DIMENSIONLESS = Dimension("-")
PACE = Dimension("s/m", length=-1, time=1)

BY_SYMBOL = {each.symbol: each for each in (STIFFNESS, VISCOSITY, VELOCITY, FORCE, LENGTH, TIME, PACE)}
"""The dimensions that numbers of contact laws have, by their SI unit."""


class Units(Table):
    """Units in which the numbers of this file are written: stiffnesses in force/length, C in force·time/length, and so on."""

    length: Annotated[Literal["m", "mm", "um"], Field(description="unit of lengths")] = "m"
    force: Annotated[Literal["N", "mN", "kN"], Field(description="unit of forces")] = "N"
    mass: Annotated[Literal["kg", "g", "t"], Field(description="unit of the entries of M")] = "kg"
    time: Literal["s", "ms"] = "s"
    """unit of time in C, Rayleigh factors, velocities and accelerations, not in frequencies and durations"""
    frequency: Literal["Hz", "rad/s"] = "Hz"
    """unit of frequencies in this file; results and reports are in Hz"""

    @property
    def system(self) -> UnitSystem:
        """The same for the layers below."""
        return UnitSystem(self.length, self.force, self.mass, self.time)

    def factor(self, dimension: Dimension) -> float:
        """The SI size of one unit of `dimension`."""
        units = self.system
        size = units.newtons**dimension.force * units.metres**dimension.length * units.seconds**dimension.time
        size *= units.kilograms**dimension.mass
        return float(size * (1.0 if self.frequency == "Hz" else 0.5 / pi) ** dimension.frequency)


SYSTEMS = {name: Units.model_validate(asdict(system)) for name, system in UNIT_SYSTEMS.items()}
"""Named consistent systems, as tables."""


def in_si(table: Table, units: Units) -> dict[str, Any]:
    """The fields of a table by name, every dimensional number in SI."""
    values: dict[str, Any] = {}
    for name, field in type(table).model_fields.items():
        dimension = next((item for item in field.metadata if isinstance(item, Dimension)), DIMENSIONLESS)
        values[name] = scaled(getattr(table, name), units.factor(dimension))
    return values


def with_si(table: AnyTable, units: Units) -> AnyTable:
    """The table with every dimensional number in SI."""
    return table.model_copy(update=in_si(table, units))


def scaled(value: Any, factor: float) -> Any:
    """`value` times `factor`, number by number through nested lists and tables; what is no number stays."""
    if isinstance(value, dict):
        return {key: scaled(item, factor) for key, item in value.items()}
    if isinstance(value, list):
        return [scaled(item, factor) for item in value]
    return value * factor if isinstance(value, float) and factor != 1.0 else value


AnyErrors = TypeVar("AnyErrors")


def errors_of(kind: Callable[..., AnyErrors], given: Mapping[str, float], what: str) -> AnyErrors:
    """Errors of a rig by the names of their class."""
    known = list(signature(kind).parameters)
    for name in given:
        if name not in known:
            raise fault(f"[{what}] errors", "must be known ones", name, nearest(name, known))
    return kind(**given)


def table_of(
    kind: type[Settings], introduction: str, base: type[Table] = Table, checked: bool = False, **forms: Any
) -> type[Table]:
    """The table whose keys are the settings that have a meaning.

    base: a table whose keys, rules and check it has too. checked: whether the checks of Python hold for its values as they are
    written. forms: the type of a key that a file writes in another form than Python, with its default where that is another, or
    the type and the default of a further key.
    """
    hints, keys = get_type_hints(kind), {}
    for setting in fields(kind):
        mark = marks(kind).get(setting.name)
        if mark is None or not mark.means:
            continue
        key = mark.key or setting.name
        default = ... if setting.default is MISSING else setting.default
        form = forms.pop(key, None) or _usual(mark.check) or hints[setting.name]
        form, default = form if isinstance(form, tuple) else (form, default)
        keys[key] = Annotated[form, Field(description=mark.means)], default
    made = create_model(f"{kind.__name__}Table", __base__=base, __doc__=introduction, **keys | forms)

    def check(table: Table) -> None:
        check_of(kind)(table)
        base.check(table)

    if checked:
        made.check = check  # type: ignore[assignment, method-assign]
    return made


def _usual(check: Callable[[str, Any], Any]) -> Any:
    """The type of a key by its check, where that has bounds."""
    match check:
        case Whole(least, most):
            return Annotated[int, Field(ge=least, le=most)]
        case Within(low, high):
            return Annotated[float, Field(gt=low, lt=high)]
    return None


def values_of(kind: type[Settings], table: Table) -> dict[str, Any]:
    """What such a table says, by the names of Python."""
    return {name: getattr(table, mark.key or name) for name, mark in marks(kind).items() if mark.means}


def check_of(kind: type[Settings]) -> Callable[[Table], None]:
    """The checks of Python on such a table, for what its model cannot check."""

    def check(table: Table) -> None:
        faults: list[str] = []
        for name, value in values_of(kind, table).items():
            try:
                if not not_given(kind, name, value):
                    marks(kind)[name].check(name, value)
            except InputError as error:
                faults += error.faults if isinstance(error, Faults) else [str(error)]
        if faults:
            raise Faults(faults)

    return check
