"""Start states of friction contacts, the explicit input behind non-unique friction forces.

The traction at the last sample is `clip(tau, LO, HI)`, with [LO, HI] the interval of the period map (see
`stickslip.model.contact.period`). The three rules say what tau is. A value is a number for all friction elements of a
direction, or a sequence with one number per element.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from stickslip.support.checks import Array, fault, vector

Value = float | Sequence[float]


@dataclass(frozen=True)
class SliderOffset:
    """tau = kt (u_last − s): the slider rests at `value` = s, in m. s = 0 is the virgin contact."""

    value: Value = 0.0
    code: ClassVar[int] = 0
    key: ClassVar[str] = "slider_offset"

    def values(self, size: int) -> Array:
        """s of each of `size` friction elements, m."""
        return vector("slider_offset", np.asarray(self.value), size)


@dataclass(frozen=True)
class TractionRatio:
    """tau = m μN_last, `value` = m in [−1, 1]. Depends on the phase origin of the force.

    Equation 9 of "An Experimental and Computational Comparison of the Dynamic Response Variability in a Turbine Blade with
    Under-Platform Dampers".
    """

    value: Value = 0.0
    code: ClassVar[int] = 1
    key: ClassVar[str] = "traction_ratio"

    def values(self, size: int) -> Array:
        """m of each of `size` friction elements."""
        ratios = vector("traction_ratio", np.asarray(self.value), size)
        if np.any(np.abs(ratios) > 1.0):
            raise fault("traction_ratio", "must lie in [-1, 1]", ratios.tolist(), "It is T/(mu N).")
        return ratios


@dataclass(frozen=True)
class MeanTraction:
    """tau = T̄ − kt (ū − u_last): the mean traction over the period is `value` = T̄, in N."""

    value: Value = 0.0
    code: ClassVar[int] = 2
    key: ClassVar[str] = "mean_traction"

    def values(self, size: int) -> Array:
        """T̄ of each of `size` friction elements, N."""
        return vector("mean_traction", np.asarray(self.value), size)


Start = SliderOffset | TractionRatio | MeanTraction
STARTS: tuple[type[SliderOffset] | type[TractionRatio] | type[MeanTraction], ...] = (SliderOffset, TractionRatio, MeanTraction)
