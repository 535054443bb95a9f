"""Laws under one normal load, constant or following the motion of a normal direction: its parameters, checks and table."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import MISSING, dataclass, field, fields
from typing import Any, ClassVar

import numpy as np

from stickslip.model.contact.law import (
    Elements,
    Friction,
    FrictionElements,
    Law,
    NormalElements,
    checked_friction,
    limit_at,
    line_of,
)
from stickslip.support.checks import fault, finite, not_negative, positive


@dataclass(frozen=True)
class Own:
    """A number that a law has of its own: what it is in a study file, its unit, and its range; `least` may be reached, `above`
    and `below` may not."""

    description: str
    unit: str = "-"
    least: float | None = None
    above: float | None = None
    below: float | None = None

    def check(self, name: str, value: float) -> None:
        """Refuse a value outside the range."""
        finite(name, value)
        if self.above is not None and value <= self.above:
            raise fault(name, "must be positive" if self.above == 0.0 else f"must be above {self.above:g}", value)
        if self.least is not None and value < self.least:
            raise fault(name, f"must be at least {self.least:g}", value)
        if self.below is not None and value >= self.below:
            raise fault(name, f"must be below {self.below:g}", value)


def own(description: str, unit: str = "-", *, default: Any = MISSING, **limits: float) -> Any:
    """A field of a law for a number of its own (`Own`): its check, its key in study files and the reference follow."""
    return field(default=default, metadata={"own": Own(description, unit, **limits)})


def own_numbers(law: type[Law] | Law) -> dict[str, Own]:
    """The numbers of its own that a law declares, by name."""
    return {each.name: each.metadata["own"] for each in fields(law) if "own" in each.metadata}  # type: ignore[arg-type]


class SingleLoad(Law):
    """A law whose friction limit is μN, with one N for all its tangential directions.

    With kn: N = max(kn (z − gap) + preload, 0), from the motion z of a normal direction (positive closes).
    Without kn: N = normal_load, constant. name: of the law in messages, as study files call it; about: what it is, for the
    reference of study files.
    """

    name: ClassVar[str]
    about: ClassVar[str]

    mu: Friction
    kn: float | None
    preload: float
    gap: float
    normal_load: float | None

    def check_load(self) -> None:
        """Refuse what is no friction coefficient and no normal load, and numbers of its own outside their range."""
        for name, number in own_numbers(self).items():
            number.check(name, getattr(self, name))
        checked_friction(self.mu)
        finite("preload", self.preload)
        finite("gap", self.gap)
        if self.kn is not None:
            positive("kn", self.kn)
        if self.normal_load is not None:
            not_negative("normal_load", self.normal_load)
        if (self.kn is None) == (self.normal_load is None):
            raise fault(
                f"A {self.name} contact",
                "must have either kn (varying normal load) or normal_load (constant)",
                {"kn": self.kn, "normal_load": self.normal_load},
                "Give exactly one of the two.",
            )

    @property
    def has_normal(self) -> bool:
        return self.kn is not None

    def under_load(self, stiffness: Sequence[float], normal: bool, parameters: tuple[float, ...] = ()) -> Elements:
        """The table with one friction element of a stiffness [N/m] for each tangential direction, under the load."""
        if normal != self.has_normal:
            words = f"kn = {self.kn}, normal direction {'given' if normal else 'missing'}"
            raise fault(f"A {self.name} contact", "must have a normal direction exactly when kn is given", words)
        one, limit = np.ones(1), 0.0 if self.normal_load is None else limit_at(self.mu, self.normal_load)
        slope, loads, changes = line_of(self.mu)
        follows = (slope * one, limit * one, np.array([0]), np.array([int(normal)]))
        bends = (slope * loads[:, None], changes[:, None]) if normal else ()
        friction = tuple(FrictionElements(kt * one, *follows, *bends) for kt in stiffness)
        if self.kn is None:
            return Elements(friction, None, parameters)
        return Elements(friction, NormalElements(self.kn * one, (self.preload - self.kn * self.gap) * one), parameters)


class Yielding(SingleLoad):
    """A law of a spring kt that yields from the smallest motion on: it dissipates at every amplitude, and the steady force does
    not depend on the start."""

    kt: float

    sticks: ClassVar[bool] = False
    remembers_start: ClassVar[bool] = False

    def __post_init__(self) -> None:
        positive("kt", self.kt)
        self.check_load()

    def _limit(self, z: float) -> float:
        """μN at a constant normal displacement z, N."""
        table, forces = self._at(z)
        return float(table.limits(forces)[0])
