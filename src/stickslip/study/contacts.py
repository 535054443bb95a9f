"""[[contact]] tables of a study file and the `Contact`s built from them: one model per law, listed in `LAWS`.

Their start rules: one per contact or per direction; values for all, per direction or per element.

The coefficient of friction in a study file: a number, or a table of how it depends on the normal load.
"""

from abc import abstractmethod
from typing import Annotated, Any, ClassVar, Literal

from pydantic import Field, Tag, create_model

from stickslip.model.contact.cubic import CubicSpring, Gap
from stickslip.model.contact.dahl import Dahl
from stickslip.model.contact.friction_disc import FrictionDisc
from stickslip.model.contact.law import Law, LoadDependentFriction, Own, SingleLoad, own_numbers
from stickslip.model.contact.lugre import LuGre
from stickslip.model.contact.macroslip import Macroslip
from stickslip.model.contact.microslip import FourParameter, Hertz, Iwan, MicroslipArray, Parabolic, Spectrum
from stickslip.model.contact.point import STARTS, SliderOffset, Start
from stickslip.model.contact.tanh_coulomb import TanhCoulomb
from stickslip.model.contact.valanis import Valanis
from stickslip.study import fields
from stickslip.support.checks import fault, nearest

Values = Annotated[
    Annotated[fields.Number, Tag("<single>")] | Annotated[list[fields.Numbers], Field(min_length=1), Tag("<list>")],
    fields.by_form(),
]
RatioOrList = Annotated[Annotated[fields.Ratio, Tag("<single>")] | Annotated[list[fields.Ratio], Tag("<list>")], fields.by_form()]
Ratios = Annotated[
    Annotated[fields.Ratio, Tag("<single>")] | Annotated[list[RatioOrList], Field(min_length=1), Tag("<list>")],
    fields.by_form(),
    fields.Words("number or list"),
]
"""A number for all; a list with one entry per direction, or per element; a list of lists: per direction and element."""


class StartTable(fields.Table):
    """Exactly one rule. Its value: a number for all, a list per direction or per element of an array, or a list of lists."""

    slider_offset: Annotated[Values | None, fields.LENGTH, Field(description="where the slider rests (0: a virgin contact)")] = (
        None
    )
    traction_ratio: Annotated[Ratios | None, Field(description="T/(µN) at the last sample, from −1 to 1")] = None
    mean_traction: Annotated[Values | None, fields.FORCE, Field(description="mean of T over the period")] = None


Starts = Annotated[
    Annotated[StartTable, Tag("<table>")] | Annotated[list[StartTable], Field(min_length=1, max_length=2), Tag("<list>")],
    fields.by_form(),
]
"""One rule for a contact, or a list with one per tangential direction."""


RuleName = Literal["slider_offset", "traction_ratio", "mean_traction", "virgin"]
RuleOrRules = Annotated[
    Annotated[RuleName, Tag("<single>")] | Annotated[list[RuleName], Field(min_length=2, max_length=2), Tag("<list>")],
    fields.by_form(),
    fields.Words('`"slider_offset"`, `"traction_ratio"`, `"mean_traction"`, `"virgin"`, or a list of two'),
]
"""What the start states of all contacts are drawn from, or of tangential and normal directions."""


def start_rules(
    start: StartTable | list[StartTable] | None, units: fields.Units, directions: int, elements: int
) -> tuple[Start, ...]:
    """One rule per tangential direction, in SI. `elements` is the number of friction elements of each direction."""
    if start is None:
        return (SliderOffset(),) * directions
    if isinstance(start, StartTable):
        return spread(start, units, directions, elements)
    if len(start) != directions:
        raise fault("start", f"must have one rule per tangential direction ({directions})", len(start))
    return tuple(spread(table, units, 1, elements)[0] for table in start)


def spread(table: StartTable, units: fields.Units, directions: int, elements: int) -> tuple[Start, ...]:
    """The rule of a table for each direction."""
    given = {key: value for key, value in fields.in_si(table, units).items() if value is not None}
    if len(given) != 1:
        raise fault(
            "start", "must name exactly one rule", sorted(given), "Known: " + ", ".join(rule.key for rule in STARTS) + "."
        )
    ((key, value),) = given.items()
    rule = next(rule for rule in STARTS if rule.key == key)
    return tuple(rule(each) for each in per_direction(key, value, directions, elements))


def per_direction(key: str, value: Any, directions: int, elements: int) -> list[Any]:
    """The value of each direction: a number, or a list with one number per element."""
    if not isinstance(value, list):
        return [value] * directions
    nested = any(isinstance(item, list) for item in value)
    if nested or (len(value) == directions and elements != directions) or (elements == 1 and len(value) == directions):
        if len(value) != directions:
            raise fault(key, f"must have one list per tangential direction ({directions})", len(value))
        return list(value)
    if len(value) == directions == elements:
        raise fault(
            key, "must say what its entries stand for", value, f"{directions} directions or elements? Write a list of lists."
        )
    if len(value) != elements:
        raise fault(key, f"must have an entry per direction ({directions}) or per element ({elements})", len(value))
    return [value] * directions


ENTRIES = Field(min_length=2)


class LoadDependentFrictionTable(fields.Table):
    """A coefficient that depends on the normal load N of the contact: `over` and `values`, between which the slip limit µN is
    linear; or a power law, `value`, `at` and `exponent`: µ = value (N/at)^exponent. Outside the loads µ is constant."""

    over: Annotated[Annotated[list[fields.Positive], ENTRIES] | None, fields.FORCE] = None
    """normal loads, ascending; for a power law the lowest and the highest; default: at/100 and 100 at"""
    values: Annotated[list[fields.Positive], ENTRIES] | None = None
    """µ at each of these loads; µN must not fall as N grows"""
    value: Annotated[fields.Positive | None, Field(description="for a power law: µ at the load `at`")] = None
    at: Annotated[fields.Positive | None, fields.FORCE, Field(description="for a power law: the load of `value`")] = None
    exponent: Annotated[fields.Number | None, Field(description="for a power law: from -1 to 1, negative if µ falls")] = None

    def friction(self, units: fields.Units) -> LoadDependentFriction:
        """The coefficient over loads in newtons."""
        given = {key: value for key, value in fields.in_si(self, units).items() if value is not None}
        power = {"value", "at", "exponent"}
        if given.keys() == {"over", "values"}:
            return LoadDependentFriction(**given)
        if given.keys() - {"over"} == power:
            return LoadDependentFriction.power(**given)
        remedy = "Such as { over = [10, 100], values = [0.6, 0.4] } or { value = 0.5, at = 50, exponent = -0.2 }."
        raise fault("mu", "must have over and values, or value, at and exponent", sorted(given), remedy)


Friction = Annotated[
    Annotated[fields.NotNegative, Tag("<single>")] | Annotated[LoadDependentFrictionTable, Tag("<table>")],
    fields.by_form(),
    fields.Words("number or table"),
]

Frictions = Annotated[
    Annotated[fields.NotNegative, Tag("<single>")]
    | Annotated[list[fields.NotNegative], Field(min_length=1), Tag("<list>")]
    | Annotated[LoadDependentFrictionTable, Tag("<table>")],
    fields.by_form(),
    fields.Words("number, list of numbers or table"),
]


def friction_in_si(mu: Any, units: fields.Units) -> Any:
    """A coefficient with its loads in newtons."""
    return mu.friction(units) if isinstance(mu, LoadDependentFrictionTable) else mu


class ContactTable(fields.Table):
    """What every contact has. `between` stands for the only direction of a contact that has one."""

    between_is: ClassVar[Literal["tangential", "normal"]] = "tangential"

    name: Annotated[str | None, Field(min_length=1, description="name in the results; numbered when absent")] = None
    between: Annotated[
        fields.Pair | None, Field(description='[A, B]: A relative to B, as the only direction; B may be "ground"')
    ] = None

    @abstractmethod
    def law_in_si(self, values: dict[str, Any]) -> Law:
        """The law, from the fields in SI."""

    def make_law(self, units: fields.Units) -> Law:
        """The law with its parameters converted to SI."""
        return self.law_in_si(fields.in_si(self, units))


class SurfaceTable(ContactTable):
    """What contacts have that can stand for all nodes of a surface."""

    together: ClassVar[tuple[tuple[str, str], ...]] = (("surface", "against"),)
    in_place_of: ClassVar[dict[str, str]] = {"surface": "normal"}

    surface: Annotated[
        str | None,
        Field(
            min_length=1,
            description="a set of nodes of the model, with a contact at each; stiffnesses and loads are those of the whole "
            "surface, shared by area",
        ),
    ] = None
    against: Annotated[
        str | None, Field(min_length=1, description='what lies opposite: a [[body]], another set of nodes, or "ground"')
    ] = None
    facing: fields.Vector | None = None
    """direction out of the surface; default: towards the opposite side"""
    line: bool | None = None
    """true for a line contact: nodes along a straight, bent or closed edge share its length; refused without this key"""
    tangent: fields.Vector | None = None
    """direction t1, projected on the surface; default: along its greatest length, or along the line"""
    mesh_gap: bool = False
    """add to `gap` how far the set of nodes opposite stands off each node of the mesh"""
    points: Annotated[
        int | None,
        Field(
            ge=1,
            le=100_000,
            description="number of contacts, one for each patch of nodes instead of each node; the change of the highest peaks "
            "is computed",
        ),
    ] = None
    mean_pressure: Annotated[fields.NotNegative, fields.PRESSURE] = 0.0
    """N0 per area, in addition to `preload`; needs `kn`"""


class FrictionTable(SurfaceTable):
    """What every contact with friction has."""

    exactly_one: ClassVar[fields.Groups] = (("between", "tangential", "surface"), ("kn", "normal_load"))
    at_most_one: ClassVar[fields.Groups] = (("between", "normal"), ("surface", "normal"))
    together: ClassVar[tuple[tuple[str, str], ...]] = (("kn", "normal"), *SurfaceTable.together)

    mu: Annotated[Friction, Field(description="friction coefficient; as a table it depends on the normal load")]
    tangential: fields.Directions | None = None
    """t1, or [t1, t2]; a direction is [A, B] or a table of coefficients"""
    normal: Annotated[fields.Direction | None, Field(description="the closing direction, positive when A moves into B")] = None
    balanced: bool = False
    """count z from the preloaded equilibrium: the structure feels N − N0, not the whole N"""
    start: Starts | None = None
    """start rule, or a list with one rule per direction; a virgin contact when absent"""

    def make_law(self, units: fields.Units) -> Law:
        values = fields.in_si(self, units)
        return self.law_in_si(values | {"mu": friction_in_si(values["mu"], units)})


LOAD = ("mu", "kn", "preload", "gap", "normal_load")
"""Parameters of the limit μN."""

SLIDER = ("kt", *LOAD)
"""Parameters of a law with one spring and slider."""


class LoadTable(FrictionTable):
    """What contacts have whose limit is μN of one normal spring, or constant."""

    normal_load: Annotated[
        fields.NotNegative | None, fields.FORCE, Field(description="constant normal load, when there is no kn")
    ] = None
    kn: Annotated[fields.Positive | None, fields.STIFFNESS, Field(description="normal stiffness; needs `normal`")] = None
    preload: Annotated[fields.Number, fields.FORCE, Field(description="N0: normal force at z = 0 (an interference)")] = 0.0
    gap: Annotated[fields.Number, fields.LENGTH, Field(description="closes at z = gap")] = 0.0


class SliderTable(LoadTable):
    """What contacts with one spring and slider have."""

    kt: Annotated[fields.Positive, fields.STIFFNESS, Field(description="tangential stiffness")]


class MacroslipTable(SliderTable):
    """One spring and slider per tangential direction."""

    law: Annotated[Literal["macroslip"], Field(description="the contact law")]
    kt2: Annotated[
        fields.Positive | None, fields.STIFFNESS, Field(description="tangential stiffness along t2, where it is another")
    ] = None

    def law_in_si(self, values: dict[str, Any]) -> Law:
        return Macroslip(**{key: values[key] for key in (*SLIDER, "kt2")})


class FrictionDiscTable(SliderTable):
    """Two tangential directions coupled, the traction inside a disc of radius μN."""

    law: Annotated[Literal["friction_disc"], Field(description="the contact law")]

    def law_in_si(self, values: dict[str, Any]) -> Law:
        return FrictionDisc(**{key: values[key] for key in SLIDER})


def load_table(law: type[SingleLoad]) -> type[ContactTable]:
    """The table of a law that declares its name, what it is about and the numbers of its own."""
    base = SliderTable if "kt" in law.__annotations__ else LoadTable
    keys = [key for key in SLIDER if key in base.model_fields]
    own = {name: (_own_type(number), getattr(law, name, ...)) for name, number in own_numbers(law).items()}

    class OfLaw(base):  # type: ignore[misc, valid-type]
        def law_in_si(self, values: dict[str, Any]) -> Law:
            return law(**{key: values[key] for key in (*keys, *own)})

    named = (Annotated[Literal[law.name], Field(description="the contact law")], ...)
    return create_model(f"{law.__name__}Table", __base__=OfLaw, __doc__=law.about, law=named, **own)  # type: ignore[call-overload, no-any-return]


def _own_type(number: Own) -> Any:
    """Type of a key: a number in its range, with its dimension."""
    dimensions = [] if number.unit == fields.DIMENSIONLESS.symbol else [fields.BY_SYMBOL[number.unit]]
    field = Field(ge=number.least, gt=number.above, lt=number.below, description=number.description)
    return Annotated[fields.Number, *dimensions, field]


class MicroslipArrayTable(FrictionTable):
    """Parallel springs and sliders with gaps. A list has one entry per element; a number is the total, shared equally."""

    at_most_one: ClassVar[fields.Groups] = (*FrictionTable.at_most_one, ("gaps", "largest_gap"))

    law: Annotated[Literal["microslip_array"], Field(description="the contact law")]
    kt: Annotated[fields.Positives, fields.STIFFNESS, Field(description="tangential stiffness, total or per element")]
    elements: Annotated[int | None, Field(ge=1, le=1000, description="number of elements, when nothing is a list")] = None
    normal_load: Annotated[fields.NotNegatives | None, fields.FORCE] = None
    """constant normal load, total or per element, when there is no kn"""
    kn: Annotated[
        fields.Positives | None, fields.STIFFNESS, Field(description="normal stiffness, total or per element; needs `normal`")
    ] = None
    preload: Annotated[fields.Numbers, fields.FORCE, Field(description="N0, total or per element")] = 0.0
    gaps: Annotated[list[fields.Number] | None, fields.LENGTH, Field(min_length=1, description="gap of each element")] = None
    largest_gap: Annotated[fields.Number | None, fields.LENGTH] = None
    """gaps spaced equally from 0 to this, instead of `gaps`"""

    def law_in_si(self, values: dict[str, Any]) -> Law:
        size = self.size()
        kt, kn, preload, load = (shared(values[key], size) for key in ("kt", "kn", "preload", "normal_load"))
        return MicroslipArray(kt or (), values["mu"], kn, self._gaps(values, size), preload or 0.0, load)

    def size(self) -> int:
        """Number of elements: that of every list, or `elements`."""
        lists = {key: getattr(self, key) for key in ("kt", "kn", "preload", "gaps", "normal_load")}
        sizes = {key: len(value) for key, value in lists.items() if isinstance(value, list)}
        if self.elements is not None:
            sizes["elements"] = self.elements
        if not sizes:
            raise fault("elements", "must be given when nothing is a list", "missing")
        if len(set(sizes.values())) > 1:
            raise fault("Lists of a microslip array", "must have one entry per element", sizes)
        return next(iter(sizes.values()))

    def _gaps(self, values: dict[str, Any], size: int) -> tuple[float, ...]:
        if values["gaps"] is not None:
            return tuple(values["gaps"])
        return tuple((values["largest_gap"] or 0.0) * index / max(size - 1, 1) for index in range(size))


class IwanTable(SliderTable):
    """Microslip under one normal load: Iwan's law with the pressure of a cylinder on a flat, of a parabola, or Segalman's."""

    law: Annotated[Literal["iwan"], Field(description="the contact law")]
    spectrum: Literal["hertz", "parabolic", "four_parameter"] = "hertz"
    """of the displacements at which the elements slip: by a Hertzian or parabolic pressure, or Segalman's"""
    edge: fields.NotNegative | None = None
    """parabolic: pressure at the edge over that in the middle; default: 0"""
    chi: Annotated[fields.Number | None, Field(description="four_parameter: exponent, above -1; default: -0.5")] = None
    beta: Annotated[fields.NotNegative | None, Field(description="four_parameter: stiffness ratio; default: 0.5")] = None
    count: Annotated[int | None, Field(ge=2, le=10000)] = None
    """approximate number of springs and sliders; default: as many as an accuracy of 0.2 % requires"""

    def law_in_si(self, values: dict[str, Any]) -> Law:
        own = {key: values[key] for key in ("kt", "mu", "kn", "preload", "gap", "normal_load")}
        return Iwan(**own, spectrum=self._spectrum(), count=self.count)

    def _spectrum(self) -> Spectrum:
        members: dict[str, tuple[type[Spectrum], tuple[str, ...]]] = {
            "hertz": (Hertz, ()),
            "parabolic": (Parabolic, ("edge",)),
            "four_parameter": (FourParameter, ("chi", "beta")),
        }
        member, own = members[self.spectrum]
        given = {key: getattr(self, key) for key in ("edge", "chi", "beta") if getattr(self, key) is not None}
        for key in given:
            if key not in own:
                raise fault(key, "must go with another spectrum", self.spectrum)
        return member(**given)


class GapTable(SurfaceTable):
    """A stop without friction."""

    between_is: ClassVar[Literal["tangential", "normal"]] = "normal"
    exactly_one: ClassVar[fields.Groups] = (("between", "normal", "surface"),)

    law: Annotated[Literal["gap"], Field(description="the contact law")]
    normal: Annotated[fields.Direction | None, Field(description="the closing direction, positive when A moves into B")] = None
    balanced: Annotated[bool, Field(description="count z from the preloaded equilibrium: the structure feels N − N0")] = False
    kn: Annotated[fields.Positive, fields.STIFFNESS, Field(description="stiffness")]
    gap: Annotated[fields.Number, fields.LENGTH, Field(description="closes at z = gap")] = 0.0
    preload: Annotated[fields.Number, fields.FORCE, Field(description="N0: normal force at z = 0")] = 0.0

    def law_in_si(self, values: dict[str, Any]) -> Law:
        return Gap(**{key: values[key] for key in ("kn", "gap", "preload")})


class CubicSpringTable(ContactTable):
    """A spring k3 w³ without friction; its linear part belongs in K."""

    exactly_one: ClassVar[fields.Groups] = (("between", "tangential"),)

    law: Annotated[Literal["cubic_spring"], Field(description="the contact law")]
    tangential: fields.Directions | None = None
    """its direction, or two; a direction is [A, B] or a table of coefficients"""
    k3: Annotated[fields.Number, fields.CUBIC_STIFFNESS, Field(description="force per displacement cubed; negative softens")]

    def law_in_si(self, values: dict[str, Any]) -> Law:
        return CubicSpring(values["k3"])


LAWS: dict[str, type[ContactTable]] = {
    "macroslip": MacroslipTable,
    "friction_disc": FrictionDiscTable,
    "microslip_array": MicroslipArrayTable,
    "iwan": IwanTable,
    **{law.name: load_table(law) for law in (Dahl, Valanis, LuGre, TanhCoulomb)},
    "gap": GapTable,
    "cubic_spring": CubicSpringTable,
}


def shared(value: float | list[float] | None, size: int) -> tuple[float, ...] | None:
    """One entry per element: a number is a total, shared equally."""
    if value is None:
        return None
    return tuple(value) if isinstance(value, list) else (value / size,) * size


def table_of(values: Any) -> type[ContactTable]:
    """The model of a [[contact]] table, by its law."""
    law = values.get("law") if isinstance(values, dict) else None
    if law is None:
        raise fault("law", "must be given", "missing", f"Known: {', '.join(LAWS)}.")
    if not isinstance(law, str) or law not in LAWS:
        raise fault("law", "must be a known one", law, nearest(str(law), LAWS))
    return LAWS[law]
