"""Cubic spring: a hardening or softening spring without friction, a common benchmark."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from stickslip.checks import fault, finite
from stickslip.contact.law import Elements, FrictionElements, Law


@dataclass(frozen=True)
class CubicSpring(Law):
    """f = k3 w³ along each direction, k3 [N/m³]; negative softens. A linear part belongs in K.

    Exact at 4H + 2 samples or more, since a cube of H harmonics holds 3H and no more; conservative, so that its loops hold no
    energy. A motion that nothing but a cubic spring holds has no linear stiffness, and is refused.
    """

    k3: float

    def __post_init__(self) -> None:
        if finite("k3", self.k3) == 0.0:
            raise fault("k3", "must not be zero", self.k3)

    @property
    def has_normal(self) -> bool:
        return False

    def elements(self, tangential: int, normal: bool) -> Elements:
        if not tangential or normal:
            raise fault("A cubic spring", "must have tangential and no normal directions", f"normal: {normal}")
        none, index = np.zeros(0), np.zeros(0, dtype=np.int64)
        return Elements((FrictionElements(none, none, none, index, index),) * tangential, None, cubic=self.k3)
