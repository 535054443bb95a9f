"""Operating conditions of a design: force levels, friction coefficients and start states."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from stickslip.analyses.arguments import fineness_of
from stickslip.checks import between, fault, of_kind, positive, seed_of, vector
from stickslip.harmonic.measure import DISPLACEMENT_AMPLITUDE, Measure
from stickslip.harmonic.orders import Harmonics

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


def conditions_of(
    force: tuple[float, float],
    friction: tuple[float, float],
    objective: str,
    counts: tuple[int, int],
    numbers: tuple[int, int],
    fineness: tuple[int | Sequence[int], int],
    search: bool = False,
    measure: Measure = DISPLACEMENT_AMPLITUDE,
) -> Conditions:
    """The conditions of a design, checked. friction: nominal and factor; counts: start states and levels; numbers: output and
    seed; fineness: harmonics and samples; measure: what amplitudes are of, per force if it or the objective is.
    """
    ends = vector("force", force).tolist()
    if len(ends) != 2 or not 0.0 < ends[0] <= ends[1]:
        raise fault("force", "must be (low, high) with 0 < low <= high", force)
    low, high = (positive("force", level) for level in ends)
    mu, factor = positive("friction", friction[0]), positive("friction_factor", friction[1])
    starts, levels = between("starts", counts[0], 0), between("levels", counts[1], 1)
    output, seed = between("output", numbers[0], 0), seed_of(numbers[1])
    if (levels == 1) != (low == high):
        remedy = "One level has (F, F); several need different ends."
        raise fault("levels", "must be 1 where both ends of force are the same, else at least 2", levels, remedy)
    if factor < 1.0:
        raise fault("friction_factor", "must be at least 1", factor)
    if objective not in ("amplitude", "amplitude_per_force"):
        raise fault("objective", "must be amplitude or amplitude_per_force", objective)
    of_kind("search", search, bool)
    fine = fineness_of(harmonics=fineness[0], samples=fineness[1])
    forces = tuple(np.geomspace(low, high, levels).tolist()) if low < high else (low,)
    frictions = (mu / factor**0.5, mu, mu * factor**0.5) if factor > 1.0 else (mu,)
    per_force = objective == "amplitude_per_force" or measure.per_force
    settings = (*fine, search and starts > 0, replace(measure, per_force=False))
    return Conditions(forces, frictions, starts, seed, output, per_force, *settings)
