"""Units of a study file, and their conversion to SI. Only the study layer knows that other units exist.

Each field of a table carries its `Dimension`; one function scales them all. Frequencies are always in Hz, angles in rad.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated, Any, Literal

from pydantic import Field

from stickslip.study.fields import Table


@dataclass(frozen=True)
class Dimension:
    """Powers of force, length and time of a field, and its SI unit as text."""

    symbol: str
    force: int = 0
    length: int = 0
    time: int = 0


STIFFNESS = Dimension("N/m", force=1, length=-1)
FORCE = Dimension("N", force=1)
LENGTH = Dimension("m", length=1)
TIME = Dimension("s", time=1)
RATE = Dimension("1/s", time=-1)
FREQUENCY = Dimension("Hz")
DIMENSIONLESS = Dimension("-")

_LENGTHS = {"m": 1.0, "mm": 1e-3, "um": 1e-6}
_FORCES = {"N": 1.0, "mN": 1e-3, "kN": 1e3}
_MASSES = {"kg": 1.0, "g": 1e-3, "t": 1e3}
_TIMES = {"s": 1.0, "ms": 1e-3}


class Units(Table):
    """Units in which the numbers of this file are written: stiffnesses in force/length, C in force·time/length, and so on."""

    length: Annotated[Literal["m", "mm", "um"], Field(description="unit of lengths")] = "m"
    force: Annotated[Literal["N", "mN", "kN"], Field(description="unit of forces")] = "N"
    mass: Annotated[Literal["kg", "g", "t"], Field(description="unit of the entries of M")] = "kg"
    time: Annotated[
        Literal["s", "ms"], Field(description="unit of time in C and in Rayleigh factors; frequencies stay in Hz")
    ] = "s"

    @property
    def metres(self) -> float:
        return _LENGTHS[self.length]

    @property
    def newtons(self) -> float:
        return _FORCES[self.force]

    @property
    def kilograms(self) -> float:
        return _MASSES[self.mass]

    @property
    def seconds(self) -> float:
        return _TIMES[self.time]

    def factor(self, dimension: Dimension) -> float:
        """The SI size of one unit of `dimension`."""
        return float(self.newtons**dimension.force * self.metres**dimension.length * self.seconds**dimension.time)


SYSTEMS = {
    "SI": Units(),
    "mm-t-s": Units(length="mm", force="N", mass="t", time="s"),
    "mm-kg-s": Units(length="mm", force="mN", mass="kg", time="s"),
    "mm-kg-ms": Units(length="mm", force="kN", mass="kg", time="ms"),
}
"""Named consistent systems."""


def in_si(table: Table, units: Units) -> dict[str, Any]:
    """The fields of a table by name, every dimensional number in SI."""
    values: dict[str, Any] = {}
    for name, field in type(table).model_fields.items():
        dimension = next((item for item in field.metadata if isinstance(item, Dimension)), DIMENSIONLESS)
        values[name] = scaled(getattr(table, name), units.factor(dimension))
    return values


def scaled(value: Any, factor: float) -> Any:
    """`value` times `factor`, number by number through nested lists; what is no number stays."""
    if isinstance(value, list):
        return [scaled(item, factor) for item in value]
    return value * factor if isinstance(value, float) and factor != 1.0 else value
