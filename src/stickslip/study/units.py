"""Units of a study file and their conversion to SI, confined to the study layer.

Each field of a table carries its `Dimension`; one function scales them all. Angles are in rad.
"""

from __future__ import annotations

from dataclasses import asdict, dataclass
from math import pi
from typing import Annotated, Any, Literal, TypeVar

from pydantic import Field

from stickslip.study.fields import Table
from stickslip.support.units import UNIT_SYSTEMS, UnitSystem

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
RATE = Dimension("1/s", time=-1)
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
    time: Annotated[
        Literal["s", "ms"],
        Field(description="unit of time in C, Rayleigh factors, velocities and accelerations, not in frequencies and durations"),
    ] = "s"
    frequency: Annotated[
        Literal["Hz", "rad/s"], Field(description="unit of frequencies in this file; results and reports are in Hz")
    ] = "Hz"

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
    """`value` times `factor`, number by number through nested lists; what is no number stays."""
    if isinstance(value, list):
        return [scaled(item, factor) for item in value]
    return value * factor if isinstance(value, float) and factor != 1.0 else value
