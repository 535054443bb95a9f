"""Macroslip: one Jenkins element per tangential direction, with a constant or a varying normal load and lift-off."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from stickslip.checks import fault, finite, not_negative, positive
from stickslip.contact.law import Elements, FrictionElements, Law, NormalElements


@dataclass(frozen=True)
class Macroslip(Law):
    """A spring kt in series with a Coulomb slider, |T| ≤ μN.

    With kn: N = max(kn (z − gap) + preload, 0), from the motion z of a normal direction (positive closes).
    Without kn: N = normal_load, constant.

    kt, kn [N/m]; mu [-]; preload N0 [N]; gap [m]; normal_load [N]; kt2 [N/m]: along t2, where it differs from kt along t1.
    Source: Griffin (1980) for constant load; Yang, Chu and Menq (1998) for varying load.
    """

    kt: float
    mu: float
    kn: float | None = None
    preload: float = 0.0
    gap: float = 0.0
    normal_load: float | None = None
    kt2: float | None = None

    def __post_init__(self) -> None:
        positive("kt", self.kt)
        if self.kt2 is not None:
            positive("kt2", self.kt2)
        not_negative("mu", self.mu)
        finite("preload", self.preload)
        finite("gap", self.gap)
        if self.kn is not None:
            positive("kn", self.kn)
        if self.normal_load is not None:
            not_negative("normal_load", self.normal_load)
        if (self.kn is None) == (self.normal_load is None):
            raise fault(
                "A macroslip contact",
                "must have either kn (varying normal load) or normal_load (constant)",
                {"kn": self.kn, "normal_load": self.normal_load},
                "Give exactly one of the two.",
            )

    @property
    def has_normal(self) -> bool:
        return self.kn is not None

    def elements(self, tangential: int, normal: bool) -> Elements:
        if normal != self.has_normal:
            raise fault(
                "A macroslip contact",
                "must have a normal direction exactly when kn is given",
                f"kn = {self.kn}, normal direction {'given' if normal else 'missing'}",
            )
        if self.kt2 is not None and tangential < 2:
            raise fault("A macroslip contact", "must have a second tangential direction for its kt2", f"{tangential} direction")
        one = np.ones(1)
        limit = 0.0 if self.normal_load is None else self.mu * self.normal_load
        friction = tuple(
            FrictionElements(kt * one, self.mu * one, limit * one, np.array([0]), np.array([int(normal)]))
            for kt in (self.kt, self.kt if self.kt2 is None else self.kt2)[:tangential]
        )
        springs = None
        if self.kn is not None:
            springs = NormalElements(self.kn * one, (self.preload - self.kn * self.gap) * one)
        return Elements(friction, springs)
