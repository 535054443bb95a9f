"""Units at the interface: constants for entering numbers, and frequency bands. Everything inside is SI.

>>> 25 * N_per_um
25000000.0
"""

from collections.abc import Iterable
from dataclasses import dataclass
from itertools import pairwise
from math import pi
from typing import Any, overload

import numpy as np
from numpy.typing import NDArray

from stickslip.support.checks import InputError, between, fault, finite, nearest, positive, unique

N_per_um = 1e6
um = 1e-6
mm = 1e-3
g = 1e-3
STANDARD_GRAVITY = 9.81
"""Acceleration that turns the dead weights of the rigs into newtons, m/s² (the value the published cases use)."""


LENGTHS = {"m": 1.0, "mm": 1e-3, "um": 1e-6}
FORCES = {"N": 1.0, "mN": 1e-3, "kN": 1e3}
MASSES = {"kg": 1.0, "g": 1e-3, "t": 1e3}
TIMES = {"s": 1.0, "ms": 1e-3}


@dataclass(frozen=True)
class UnitSystem:
    """Units in which numbers are written, by name; `metres` and the like are the SI size of one unit."""

    length: str = "m"
    force: str = "N"
    mass: str = "kg"
    time: str = "s"

    @property
    def metres(self) -> float:
        return LENGTHS[self.length]

    @property
    def newtons(self) -> float:
        return FORCES[self.force]

    @property
    def kilograms(self) -> float:
        return MASSES[self.mass]

    @property
    def seconds(self) -> float:
        return TIMES[self.time]


UNIT_SYSTEMS = {
    "SI": UnitSystem(),
    "mm-t-s": UnitSystem("mm", "N", "t", "s"),
    "mm-kg-s": UnitSystem("mm", "mN", "kg", "s"),
    "mm-kg-ms": UnitSystem("mm", "kN", "kg", "ms"),
}
"""Named consistent systems."""


def unit_system(name: str | UnitSystem) -> UnitSystem:
    """The system of a name; a system stays as it is."""
    if isinstance(name, UnitSystem):
        return name
    if name not in tuple(UNIT_SYSTEMS):
        raise fault("The system of units", "must be a known one", name, nearest(str(name), UNIT_SYSTEMS))
    return UNIT_SYSTEMS[name]


WIDEST = 1e6
"""Ratio of the ends of a band beyond which one of them is a mistake."""


@dataclass(frozen=True)
class Band:
    """A frequency band, in Hz; `start` above `stop` sweeps downwards."""

    start: float
    stop: float

    def __post_init__(self) -> None:
        positive("Band.start", self.start)
        positive("Band.stop", self.stop)
        if self.start == self.stop:
            raise fault("Band", "must have two different ends", (self.start, self.stop), "Widen it, or use `at`.")
        if self.high > WIDEST * self.low:
            raise fault("Band", f"must end within {WIDEST:g} times its start", (self.start, self.stop), "Check its unit.")

    @property
    def low(self) -> float:
        return min(self.start, self.stop)

    @property
    def high(self) -> float:
        return max(self.start, self.stop)


def hertz(start: float, stop: float | None = None) -> Band:
    """The band from `start` to `stop`, both in Hz."""
    if stop is None:
        raise fault("stop", "must be given", stop, "A band has two ends; frequencies in Hz are given as a list: [70.0, 80.0].")
    return Band(finite("start", start), finite("stop", stop))


@overload
def radians_per_second(start: float, stop: float) -> Band: ...
@overload
def radians_per_second(start: float) -> float: ...
@overload
def radians_per_second(start: Iterable[float]) -> list[float]: ...
def radians_per_second(start: Any, stop: float | None = None) -> Band | float | list[float]:
    """What is stated in rad/s, for every argument that takes Hz: a band by two numbers, a frequency by one, a list by a list.

    >>> radians_per_second(3.141592653589793)
    0.5
    """
    if stop is not None:
        return Band(finite("start", start) / (2.0 * pi), finite("stop", stop) / (2.0 * pi))
    if isinstance(start, Iterable) and not isinstance(start, str):
        return [finite("A frequency", frequency) / (2.0 * pi) for frequency in start]
    return finite("The frequency", start) / (2.0 * pi)


def in_order(frequencies: Any) -> list[float]:
    """Frequencies in Hz, at least one, checked one by one."""
    if isinstance(frequencies, str) or not isinstance(frequencies, Iterable):
        raise fault("band", "must be a Band, as of ss.hertz(480, 600), or a list of frequencies in Hz", frequencies)
    values = [positive("A frequency", frequency) for frequency in frequencies]
    if not values:
        raise InputError("The frequencies must hold at least one value, but are empty. Give a Band or a list in Hz.")
    return values


def listed(frequencies: Any) -> list[float]:
    """Different frequencies in Hz, checked, in their order. A pair in round brackets is refused: it could mean a band."""
    values = in_order(frequencies)
    unique("The frequencies", values)
    if isinstance(frequencies, tuple) and len(values) == 2:
        remedy = "Write ss.hertz(start, stop) for a band, or a list for two points."
        raise fault("band", "must not be a pair in round brackets, which could mean a band or two points", frequencies, remedy)
    return values


def followed(frequencies: Any) -> list[float]:
    """Frequencies in Hz, checked, in their order: `listed`, but a list may come back to where it was, upwards and downwards."""
    values = in_order(frequencies)
    for one, other in pairwise(values):
        unique("Frequencies beside each other", [one, other])
    if len(values) == 2:
        return listed(frequencies)
    return values


def logspace(start: float, stop: float, points: int = 50) -> NDArray[np.float64]:
    """So many values from `start` to `stop` in equal ratios, say of F_C/F_E."""
    count = between("points", points, 2)
    return np.geomspace(positive("start", start), positive("stop", stop), count)
