"""Gap: a unilateral spring without friction."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from stickslip.model.contact.law import Elements, Law, NormalElements
from stickslip.support.checks import fault, finite, positive


@dataclass(frozen=True)
class Gap(Law):
    """N = max(kn (z − gap) + preload, 0). kn [N/m], gap [m], preload [N]."""

    kn: float
    gap: float = 0.0
    preload: float = 0.0

    sticks: ClassVar[bool] = False
    remembers_start: ClassVar[bool] = False
    rubs: ClassVar[bool] = False

    def __post_init__(self) -> None:
        positive("kn", self.kn)
        finite("gap", self.gap)
        finite("preload", self.preload)

    @property
    def has_normal(self) -> bool:
        return True

    @property
    def has_friction(self) -> bool:
        return False

    def elements(self, tangential: int, normal: bool) -> Elements:
        if tangential or not normal:
            raise fault("A gap contact", "must have a normal and no tangential direction", f"{tangential} tangential")
        one = np.ones(1)
        return Elements((), NormalElements(self.kn * one, (self.preload - self.kn * self.gap) * one))
