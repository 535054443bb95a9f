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
    *,
    force: tuple[float, float],
    friction: float,
    friction_factor: float,
    objective: str,
    starts: int,
    levels: int,
    output: int,
    seed: int,
    harmonics: int | Sequence[int],
    samples: int,
    search: bool = False,
    measure: Measure = DISPLACEMENT_AMPLITUDE,
) -> Conditions:
    """The conditions of a design, checked. measure: what amplitudes are of, per force if it or the objective is."""
    ends = vector("force", force).tolist()
    if len(ends) != 2 or not 0.0 < ends[0] <= ends[1]:
        raise fault("force", "must be (low, high) with 0 < low <= high", force)
    low, high = (positive("force", level) for level in ends)
    mu, factor = positive("friction", friction), positive("friction_factor", friction_factor)
    starts, levels = between("starts", starts, 0), between("levels", levels, 1)
    if (levels == 1) != (low == high):
        remedy = "One level has (F, F); several need different ends."
        raise fault("levels", "must be 1 where both ends of force are the same, else at least 2", levels, remedy)
    if factor < 1.0:
        raise fault("friction_factor", "must be at least 1", factor)
    if objective not in ("amplitude", "amplitude_per_force"):
        raise fault("objective", "must be amplitude or amplitude_per_force", objective)
    of_kind("search", search, bool)
    H, Nt = fineness_of(harmonics, samples)
    return Conditions(
        forces=tuple(np.geomspace(low, high, levels).tolist()) if low < high else (low,),
        frictions=(mu / factor**0.5, mu, mu * factor**0.5) if factor > 1.0 else (mu,),
        starts=starts,
        seed=seed_of(seed),
        output=between("output", output, 0),
        per_force=objective == "amplitude_per_force" or measure.per_force,
        harmonics=H,
        samples=Nt,
        search=search and starts > 0,
        measure=replace(measure, per_force=False),
    )
