"""Viscous damping of a structure: given as C, proportional, or modal on the free or on the stuck modes."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal

import numpy as np

from stickslip.checks import fault, not_negative, vector


@dataclass(frozen=True)
class ModalDamping:
    """Damping ratio ζ of every mode (a number), or of the first modes one by one (then zero).

    on = "stuck": the modes of K + BᵀK_cB; "free": those of K, the contacts absent.
    """

    ratio: float | Sequence[float]
    on: Literal["stuck", "free"] = "stuck"

    def __post_init__(self) -> None:
        if np.any(vector("damping ratio", np.asarray(self.ratio)) < 0.0):
            raise fault("damping ratio", "must not be negative", self.ratio)
        if self.on not in ("stuck", "free"):
            raise fault("on", 'must be "stuck" or "free"', self.on)


@dataclass(frozen=True)
class RayleighDamping:
    """C = mass_factor M + stiffness_factor K. Factors in 1/s and s."""

    mass_factor: float
    stiffness_factor: float

    def __post_init__(self) -> None:
        not_negative("mass_factor", self.mass_factor)
        not_negative("stiffness_factor", self.stiffness_factor)


Damping = ModalDamping | RayleighDamping
