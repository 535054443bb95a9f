"""Operating conditions of a design: force levels, friction coefficients and start states."""

from __future__ import annotations

from dataclasses import dataclass

from stickslip.solve.balance.measure import DISPLACEMENT_AMPLITUDE, Measure
from stickslip.solve.balance.orders import Harmonics

Case = tuple[float, float, int]
"""Force level, friction and start state of one case of a design."""


@dataclass(frozen=True)
class Conditions:
    """What a design has to stand: force levels ascending; friction coefficients; sampled start states and their seed; output;
    whether amplitudes count per force; harmonics and samples; whether all start states are searched in the worst case; what
    amplitudes are of. Without sampled start states contacts are virgin ones, and nothing is searched.
    """

    forces: tuple[float, ...]
    frictions: tuple[float, ...]
    starts: int
    seed: int
    output: int
    per_force: bool
    harmonics: Harmonics
    samples: int
    search: bool = False
    measure: Measure = DISPLACEMENT_AMPLITUDE
