"""Construction of a problem in SI from the tables of a study file; each function reports all faults that it finds.

Names of degrees of freedom in a study: detection of unknown names, and directions as coefficients in SI.
"""

import inspect
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import fields, replace
from math import gcd
from typing import Any, Literal

import numpy as np

from stickslip.model import rigs
from stickslip.model.contact.point import GROUND, Contact, SliderOffset, between
from stickslip.model.dampers import SHAPES
from stickslip.model.dampers.damper import Shape
from stickslip.model.dampers.seat import Seat
from stickslip.model.disks.tuned import TunedDisk, check_engine_order
from stickslip.model.loads import DERIVATIVES, BaseMotion, Force, Output
from stickslip.model.problem import Problem
from stickslip.model.problem.load_steps import OF_CONTACTS, LoadStep
from stickslip.model.problem.speed import CentrifugalLoad
from stickslip.model.readers.model import levers
from stickslip.model.readers.numbers import DIGITS
from stickslip.model.readers.stress_places import SAME_SPEED
from stickslip.model.structure.assembly import RigidBody, Spring
from stickslip.model.structure.centrifugal import RotationAxis
from stickslip.model.structure.matrices import Damping, Dashpot, ModalDamping, RayleighDamping, nearest_dof, of_single_nodes
from stickslip.study.contacts import ContactTable, FrictionTable, StartTable, start_rules
from stickslip.study.faults import parsed
from stickslip.study.fields import DENSITY, LENGTH, MASS, Units, in_si, scaled
from stickslip.study.tables import (
    BaseTable,
    BodyTable,
    DampingTable,
    DashpotTable,
    ExcitationTable,
    ForceTable,
    FrequenciesTable,
    LoadStepTable,
    MeanSpringTable,
    OverSpeedTable,
    RotationTable,
    StructureTable,
)
from stickslip.support.checks import Array, Faults, InputError, fault, nearest
from stickslip.support.units import Band, followed, listed


class Names:
    """The degrees of freedom that exist, with the factor of each, and `short` names of those of sets of one node."""

    def __init__(self, dofs: Sequence[str], units: Units) -> None:
        self.lever = dict(zip(dofs, levers(dofs, units.system).tolist(), strict=True))
        self.short = of_single_nodes(dofs)

    def coefficients(self, given: Sequence[str] | Mapping[str, float]) -> dict[str, float]:
        """A direction given as a pair of names or as a table, as coefficients in SI."""
        table = given if isinstance(given, Mapping) else between(*given)
        return {name: coefficient * self.lever.get(self.short.get(name, name), 1.0) for name, coefficient in table.items()}

    def faults(self, document: Mapping[str, Any]) -> list[str]:
        """Every name in the document that does not exist."""
        known = {*self.lever, *self.short}
        return [f"{place}: {self._fault(name)}" for place, name in names_in(document) if name not in known]

    def _fault(self, name: str) -> str:
        if name == GROUND:
            return f"must be a degree of freedom, which moves, but is {name!r}."
        return f"degree of freedom {name!r} does not exist. {nearest_dof(name, [*self.lever, GROUND])}"


def dofs_in(document: Mapping[str, Any]) -> list[str]:
    """The names of the degrees of freedom, as far as the document has them."""
    structure = document.get("structure")
    dofs = structure.get("dofs") if isinstance(structure, dict) and "body" not in document else None
    return [dof for dof in dofs if isinstance(dof, str)] if isinstance(dofs, list) else []


def names_in(document: Mapping[str, Any]) -> Iterator[tuple[str, str]]:
    """Places and names, read from the document as it stands, so that other faults do not hide a wrong name."""
    for key, places in (
        ("contact", ("between", "tangential", "normal")),
        ("force", ("direction",)),
        ("dashpot", ("between",)),
        ("mean_spring", ("direction",)),
    ):
        tables = document.get(key)
        for number, table in enumerate(tables if isinstance(tables, list) else (), start=1):
            if isinstance(table, dict) and not (key == "force" and "surface" in table):
                for place in places:
                    yield from ((f"[[{key}]] {number}: {place}", name) for name in words(table.get(place)))
    base = document.get("base")
    if isinstance(base, dict) and isinstance(base.get("direction"), dict):
        yield from (("[base]: direction", name) for name in base["direction"])
    sweep = document.get("sweep")
    outputs = sweep.get("outputs") if isinstance(sweep, dict) else None
    for output in outputs if isinstance(outputs, list) else ():
        value = output.get("direction") if isinstance(output, dict) else output
        yield from (("[sweep]: outputs", name) for name in words(value))


def words(value: Any) -> list[str]:
    """The names in a place: one, a pair (where "ground" is the fixed side), the keys of a table, or lists of these."""
    if isinstance(value, str):
        return [value]
    if isinstance(value, dict):
        return list(value)
    if not isinstance(value, list):
        return []
    return [word for item in value for word in words(item) if not (isinstance(item, str) and item == GROUND)]


COUNTS = ("lines", "flat_points")
"""Arguments of damper shapes that are numbers of lines and points."""

OTHER_DIMENSIONS = {"density": DENSITY, "mass": MASS}
"""Arguments of damper shapes that are neither lengths nor angles nor counts."""


def rig_named(table: StructureTable) -> Problem:
    """The ready problem that a [structure] table names."""
    misplaced = [
        key
        for key in ("names", "variables", "units", "keep", "modes", "shift", "own_damping", "sector", "stress")
        if key in table.model_fields_set
    ]
    if misplaced:
        raise fault(" and ".join(misplaced), "must go with a model", "beside a rig", "Leave it out.")
    maker = rigs.RIGS.get(str(table.rig))
    if maker is None:
        raise fault("rig", "must be a known one", table.rig, nearest(str(table.rig), rigs.RIGS))
    known = inspect.signature(maker).parameters
    unknown = [name for name in table.parameters if name not in known]
    if unknown:
        raise Faults([str(fault("parameters, key", "must be a known one", name, nearest(name, known))) for name in unknown])
    missing = [name for name, parameter in known.items() if parameter.default is parameter.empty and name not in table.parameters]
    if missing:
        raise Faults([f"parameters, {name} must be given, but is missing." for name in missing])
    return made(maker, {name: rig_argument(name, value) for name, value in table.parameters.items()})


def rig_argument(name: str, value: Any) -> Any:
    """An argument of a rig: as it stands, or a start rule from its table."""
    if name != "start":
        return value
    (rule,) = start_rules(parsed(StartTable, value), Units(), directions=1, elements=1)
    return rule


def made(maker: Callable[..., Problem], parameters: Mapping[str, Any]) -> Problem:
    """The rig, with a value of a wrong kind reported as a fault."""
    try:
        return maker(**parameters)
    except InputError:
        raise
    except (TypeError, ValueError) as error:
        raise InputError(f"parameters must suit the rig, but {dict(parameters)!r} does not ({error}).") from None


def damping_rule(table: DampingTable | None, units: Units) -> Damping | None:
    """The damping rule, in SI."""
    if table is None:
        return None
    if table.rayleigh is not None:
        seconds = units.system.seconds
        return RayleighDamping(table.rayleigh[0] / seconds, table.rayleigh[1] * seconds)
    return ModalDamping(table.modal if isinstance(table.modal, float) else tuple(table.modal or ()), table.on)


def shape_of(name: str, dimensions: Mapping[str, Any], units: Units, **angles: float) -> Shape:
    """A damper shape of dimensions in the units of the study and slopes of its platforms in degrees."""
    known = [field.name for field in fields(SHAPES[name]) if not angles or not field.name.endswith("_angle")]  # type: ignore[arg-type]
    for key in dimensions:
        if key not in known:
            raise fault("dimensions", f"must be those of the shape {name!r}", key, f"Known: {', '.join(known)}.")
    return SHAPES[name](**{key: _dimension(key, value, units) for key, value in dimensions.items()}, **angles)


def _dimension(key: str, value: Any, units: Units) -> Any:
    """An argument of a shape in SI: a length, unless its name says otherwise; counts have no unit."""
    if key.endswith("_angle") or (isinstance(value, bool | int) and key in COUNTS):
        return value
    factor = units.factor(OTHER_DIMENSIONS.get(key, LENGTH))
    return scaled(float(value) if isinstance(value, int) and not isinstance(value, bool) else value, factor)


def fitted(table: BodyTable, seat: Seat, units: Units) -> tuple[Shape, BodyTable]:
    """The shape of a body that fits between two platforms, and its table with the place and the axes of the seat."""
    kind, given = str(table.shape), table.dimensions
    known = seat.dimensions(SHAPES[kind], given)
    if "width" in given and "height" in known:  # a wedge that is narrower than where the platforms begin
        known["height"] = seat.narrower(_dimension("width", given["width"], units))
    shape = shape_of(kind, given, units, **known)
    centre = (seat.centre(shape) / units.factor(LENGTH)).tolist()
    return shape, table.model_copy(update={"centre": centre, "axes": seat.axes[:2].tolist()})


def body(table: BodyTable, units: Units, seat: Seat | None = None) -> tuple[RigidBody, tuple[Force, ...]]:
    """A rigid body in SI, and the static forces that pull it; seat: of a body between two platforms."""
    own = None
    if seat is not None:
        shape, table = fitted(table, seat, units)
        own = shape.body()
    elif table.shape is not None:
        own = shape_of(table.shape, table.dimensions, units).body()
    values = in_si(table, units)
    mass, inertia = (values["mass"], values["inertia"]) if own is None else (own.mass, own.inertia)
    given = np.asarray(inertia, dtype=float)
    turn = axes_of(table.axes)
    turned = turn.T @ (np.diag(given) if given.ndim == 1 else given) @ turn
    outline = () if own is None else np.reshape(own.outline, (-1, 3)) @ turn
    rigid = RigidBody(mass, turned, values["centre"], outline=outline)
    pull = zip("xyz", values["pull"], strict=True)
    return rigid, tuple(replace(pull_on(table.name, axis), static=f) for axis, f in pull if f)


def pull_on(body: str, axis: str) -> Force:
    """A force that pulls a body along an axis, without its size."""
    return Force(f"{body}/{RigidBody.node}.{axis}", name=f"pull on {body} along {axis}")


def axes_of(given: list[list[float]] | None) -> Array:
    """Rows x, y, z of a body in the coordinates of the model, (3, 3)."""
    if given is None:
        return np.eye(3)
    x, y = np.asarray(given, dtype=float)
    lengths = np.linalg.norm(x), np.linalg.norm(y)
    if not min(lengths) or abs(x @ y) > 1e-6 * lengths[0] * lengths[1]:
        raise fault("axes", "must be two directions at right angles", given)
    return np.stack([x / lengths[0], y / lengths[1], np.cross(x, y) / (lengths[0] * lengths[1])])


def contact(table: ContactTable, number: int, names: Names, units: Units) -> Contact:
    """A contact in SI."""
    law = table.make_law(units)
    tangential, normal = directions(table, names)
    friction = law.elements(len(tangential), normal is not None).friction
    size = friction[0].stiffness.size if friction else 1
    start = start_rules(table.start, units, len(tangential), size) if isinstance(table, FrictionTable) else SliderOffset()
    return Contact(table.name or f"contact {number}", law, tangential, normal, start, getattr(table, "balanced", False))


def directions(table: ContactTable, names: Names) -> tuple[tuple[dict[str, float], ...], dict[str, float] | None]:
    """The tangential directions and the normal one."""
    tangential, normal = several(getattr(table, "tangential", None)), getattr(table, "normal", None)
    if table.between is not None:
        tangential, normal = ([table.between], None) if table.between_is == "tangential" else ([], table.between)
    along = tuple(names.coefficients(direction) for direction in tangential)
    return along, None if normal is None else names.coefficients(normal)


def several(given: Any) -> list[Any]:
    """A list of directions, of one or of several."""
    if given is None:
        return []
    return given if isinstance(given, list) and not isinstance(given[0], str) else [given]


def force(table: ForceTable, names: Names, units: Units) -> Force:
    """A force in SI."""
    place = {table.direction: 1.0} if isinstance(table.direction, str) else table.direction
    return force_along(names.coefficients(place), table, units)


def force_along(direction: Mapping[str, float], table: ForceTable, units: Units) -> Force:
    """A force in SI along a direction with coefficients in SI."""
    values = in_si(table, units)
    amplitude = {table.harmonic: complex_amplitude(values["amplitude"])}
    return Force(direction, amplitude, values["static"], table.name, omega_power=table.omega_power)


def complex_amplitude(given: Any) -> complex:
    """An amplitude from a number or from [re, im]."""
    return complex(*given) if isinstance(given, list) else complex(given)


def dashpot(table: DashpotTable, names: Names, units: Units) -> Dashpot:
    """A viscous damper in SI."""
    return Dashpot(names.coefficients(table.between), in_si(table, units)["c"])


def mean_spring(table: MeanSpringTable, names: Names, units: Units) -> Spring:
    """A spring on the mean position in SI."""
    direction = {table.direction: 1.0} if isinstance(table.direction, str) else table.direction
    return Spring(names.coefficients(direction), in_si(table, units)["k"])


def excited(problem: Problem, table: ExcitationTable) -> TunedDisk:
    """The disk under the engine orders of a table."""
    if not isinstance(problem, TunedDisk):
        remedy = "Leave it out, or describe the sector in [structure.sector]."
        raise fault("The structure", "must be a bladed disk", type(problem).__name__, remedy)
    if table.engine_order is not None:
        return problem.with_engine_order(table.engine_order)
    return problem.with_engine_orders(_factors(table))


def _factors(table: ExcitationTable) -> dict[int, complex]:
    """{EO: factor on the forces} of several engine orders."""
    for order in table.orders or {}:
        if not order.isdecimal():
            raise fault("orders, an engine order", "must be a whole number", order)
        if len(order) > DIGITS:
            raise fault("orders, an engine order", f"must have at most {DIGITS} digits", f"{order[:DIGITS]}...")
    return {int(order): complex_amplitude(factor) for order, factor in (table.orders or {}).items()}


def check_orders(table: ExcitationTable, sectors: int) -> None:
    """Refuse what a table says wrongly whatever the disk's structure is."""
    _factors(table)
    if table.engine_order is not None:
        check_engine_order(table.engine_order, sectors)


def check_speeds(table: OverSpeedTable, speed: float | None) -> None:
    """What a table over the speed must not say beside a sector whose K was written at `speed` in rev/min, None where that is not
    given."""
    if table.stiffness_at_rest is not None:
        raise InputError(f"[{table.key}]: stiffness_at_rest must be left out: a sector has at_speeds in [structure.sector].")
    reference = table.reference_speed
    if speed is not None and reference is not None and abs(speed - reference) > SAME_SPEED * reference:
        raise fault(f"[{table.key}]: reference_speed", f"must be the speed of the sector's model, {speed:g} rev/min", reference)


def lowest_order(table: ExcitationTable) -> int:
    """The engine order by which the frequencies of a study count: the one, or the greatest common divisor of several."""
    return gcd(*_factors(table)) if table.engine_order is None else table.engine_order


def rotation(table: RotationTable, over: OverSpeedTable | None, units: Units) -> tuple[float, RotationAxis, bool]:
    """Speed in rev/min, at which an analysis over the speed has its structure, axis in SI, and whether Coriolis forces act."""
    if over is not None and over.reference_speed not in (None, table.speed):
        rule = f"must be the reference_speed of [{over.key}], {over.reference_speed:g} rev/min"
        raise fault("speed", rule, table.speed)
    if table.coriolis and over is not None and over.key != "campbell":
        rule = f"must be false with [{over.key}], which neglects Coriolis forces"
        raise fault("coriolis", rule, "true", "A Campbell diagram can include them.")
    axis = RotationAxis.of((table.axis.point, table.axis.direction)).scaled(units.system.metres)
    return table.speed, axis, table.coriolis


def load_step(table: LoadStepTable, rotation: RotationTable | None, problem: Problem, units: Units) -> LoadStep:
    """A load before that of the study: at a speed the square of its ratio to that of [rotation] of all centrifugal loads."""
    values = in_si(table, units)
    static = {pull_on(body, axis).name: f for body, pull in values["pull"].items() for axis, f in zip("xyz", pull, strict=True)}
    if table.speed is not None:
        if rotation is None:
            raise InputError(f"speed = {table.speed:g} needs [rotation]. Add it, or give a factor of all static forces.")
        square = (table.speed / rotation.speed) ** 2
        static |= {force.name: square * force.static for force in problem.forces if isinstance(force, CentrifugalLoad)}
    return LoadStep(table.factor, static | values["static"], **{key: values[key] for key in OF_CONTACTS})


def base(table: BaseTable, names: Names, units: Units) -> BaseMotion:
    """A moving base in SI; a letter stands for every degree of freedom in that direction."""
    place = table.direction
    if isinstance(place, str):
        along = {dof: 1.0 for dof in names.lever if dof.rpartition(".")[2] == place}
        if not along:
            raise fault("direction", "must be that of some degree of freedom", place, "Write a letter as in NODE.x, or a table.")
        place = along
    values = in_si(table, units)
    motion = next(motion for motion in DERIVATIVES if values[motion] is not None)
    return BaseMotion(names.coefficients(place), {table.harmonic: complex_amplitude(values[motion])}, of=motion)


def outputs(table: FrequenciesTable, names: Names) -> tuple[Output, ...]:
    """The outputs. A degree of freedom by its name is reported as it is, a rotation in rad."""
    return tuple(
        Output.of(place) if isinstance(place, str) else Output(place.name, names.coefficients(place.direction))
        for place in table.outputs or ()
    )


def frequencies(table: FrequenciesTable, units: Units, repeated: bool = False) -> Band | list[float]:
    """The band, or the frequencies to solve at, Hz; `repeated`: they may come back to where they were."""
    values = in_si(table, units)
    if table.frequency is not None:
        return Band(*values["frequency"])
    return (followed if repeated else listed)(list(values["at"] or ()))


def enough_samples(harmonics: int | Sequence[int] | Literal["auto"], samples: int) -> None:
    """As many samples as the harmonic balance needs to separate H harmonics of a product, or the first when they are chosen."""
    least = 4 * (1 if harmonics == "auto" else int(np.max(harmonics))) + 2
    if samples < least:
        raise fault("samples", f"must be at least 4 x harmonics + 2 = {least}", samples, "256 is usual.")
