"""Constraints of damper design: no jamming, no lift-off, bounded contact forces and pressures.

A constraint is a function of a `Trial` that is positive where it is met, of order one.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from math import pi, radians, sqrt, tan
from typing import ClassVar

import numpy as np

from stickslip.support.checks import Array, fault, positive


@dataclass(frozen=True, eq=False)
class Trial:
    """A design at the resonance under one friction coefficient, force level and start state.

    variables: the design; friction; force: level; normal_forces: {contact: N over one period (samples,)} [N].
    """

    variables: Mapping[str, float]
    friction: float
    force: float
    normal_forces: Mapping[str, Array]


Constraint = Callable[[Trial], float]
"""Positive where it is met. One with an attribute `geometric` = True reads no normal forces: a design that breaks it is refused
before it is computed.
"""


def is_geometric(constraint: Constraint) -> bool:
    """Whether a constraint can be asked before a design is computed."""
    return bool(getattr(constraint, "geometric", False))


@dataclass(frozen=True)
class NoJamming:
    """1 − μ tan α > 0: the symmetric damper leaves its platforms by itself, whatever presses them together.

    angle: the variable that holds the platform angle, or the angle itself [degrees].
    """

    angle: str | float = "angle"
    geometric: ClassVar[bool] = True

    def __call__(self, trial: Trial) -> float:
        degrees = self.angle
        if isinstance(degrees, str):
            if degrees not in trial.variables:
                known = f"Variables: {', '.join(trial.variables)}."
                raise fault("angle", "must be a variable of the design, or a number", degrees, known)
            degrees = trial.variables[degrees]
        return 1.0 - trial.friction * tan(radians(degrees))


@dataclass(frozen=True)
class NoLiftOff:
    """Every contact keeps at least `share` of its mean normal force all through the period."""

    share: float = 0.0

    def __call__(self, trial: Trial) -> float:
        least = [force.min() / max(force.mean(), np.finfo(float).tiny) for force in trial.normal_forces.values()]
        return float(min(least, default=1.0)) - self.share - 1e-12


@dataclass(frozen=True)
class LargestForce:
    """No contact point carries more than `limit` [N]."""

    limit: float

    def __post_init__(self) -> None:
        positive("limit", self.limit)

    def __call__(self, trial: Trial) -> float:
        return 1.0 - max((float(force.max()) for force in trial.normal_forces.values()), default=0.0) / self.limit


@dataclass(frozen=True)
class LinePressure:
    """Hertz pressure p0 = √(P E*/(π R)) of a line contact below `limit` [Pa], P the force per length.

    contacts: the beginning of the names of the points of one line ("left cylinder"); length, radius [m]; modulus: E* [Pa],
    1/E* = 2 (1 − ν²)/E for equal materials. Source: Hertz; K. L. Johnson, Contact Mechanics, chapter 4.
    """

    limit: float
    contacts: str
    length: float
    radius: float
    modulus: float = 210e9 / (2.0 * (1.0 - 0.3**2))

    def __post_init__(self) -> None:
        for key in ("limit", "length", "radius", "modulus"):
            positive(key, getattr(self, key))

    def __call__(self, trial: Trial) -> float:
        line = [force for name, force in trial.normal_forces.items() if name.startswith(self.contacts)]
        if not line:
            raise fault("contacts", "must begin the names of some contacts", self.contacts)
        per_length = float(np.sum(line, axis=0).max()) / self.length
        return 1.0 - sqrt(per_length * self.modulus / (pi * self.radius)) / self.limit
