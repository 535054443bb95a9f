"""Initial values of contact parameters from the loops alone: plateaus of T/N and stuck slopes."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from stickslip.laboratory.measurement.cycles import CycleSet
from stickslip.laboratory.measurement.friction import Plateau, friction_from_ratios
from stickslip.laboratory.measurement.reconstruction import feet_loads, reconstructed
from stickslip.laboratory.measurement.rig_errors import RigErrors, distorted
from stickslip.laboratory.measurement.stuck import StuckStiffness, StuckStretch, stiffness_from_slopes, stuck_stretch
from stickslip.model.dampers.between_platforms import BetweenPlatforms
from stickslip.support.checks import Array, InputError

DRAWS = 24
"""Draws of the errors of the rig for those of plateaux."""


@dataclass(frozen=True, eq=False)
class Clues:
    """Plateaux by case and line ("R", "L", "L1", "L2"), stuck slopes by case, the stiffness that they give, and why not."""

    plateaux: dict[str, dict[str, Plateau]]
    slopes: dict[str, StuckStretch]
    stiffness: StuckStiffness | None
    remarks: tuple[str, ...]

    def guess(self, name: str, otherwise: float) -> float:
        """A first value of an unknown."""
        part, _, line = name.partition("_")
        if part == "mu":
            levels = [p.level for case in self.plateaux.values() for key, p in case.items() if key in (line, line[:1])]
            return float(np.median(levels)) if levels else 0.25
        return float(getattr(self.stiffness, part, otherwise)) if self.stiffness is not None else otherwise


def clues(cases: Sequence[CycleSet], rig: BetweenPlatforms, errors: RigErrors) -> Clues:
    """What the mean cycles show, plateaux with their errors by those of the rig; what they do not show is noted in `remarks`."""
    plateaux, slopes, remarks = {}, {}, []
    directions: dict[str, list[float]] = {"x": [], "y": []}
    for case in cases:
        signals = {name: case.cycle(name) for name in case.channels}
        pull, own = float(rig.pull[1]) if case.pull is None else case.pull, errors.with_zeros(case.zero_errors)
        plateaux[case.name] = plateaux_with_errors(rig, signals, pull, own)
        axis = max("xy", key=lambda a: float(np.ptp(signals.get(f"platform_{a}", np.zeros(2)))))
        sign = 1.0 if axis == "x" else -1.0
        try:
            motion, resisting = signals[f"platform_{axis}"], signals[f"force_{axis}"] * sign
            # The force that resists the motion, turned so that it rises with it.
            rising = resisting if np.corrcoef(resisting * sign, motion)[0, 1] >= 0.0 else -resisting
            slopes[case.name] = stuck_stretch(motion, sign * rising)
            directions[axis].append(slopes[case.name].slope)
        except InputError as missing:
            remarks.append(f"{case.name}: no stuck slope. {missing}")
    stiffness = None
    try:
        if directions["x"] and directions["y"]:
            stiffness = stiffness_from_slopes(rig, max(directions["x"]), max(directions["y"]))
    except InputError as missing:
        remarks.append(f"No stiffness from slopes. {missing}")
    return Clues(plateaux, slopes, stiffness, tuple(remarks))


def plateaux_with_errors(rig: BetweenPlatforms, signals: dict[str, Array], pull: float, errors: RigErrors) -> dict[str, Plateau]:
    """Plateaux of T/N of one mean cycle, their errors from draws of the systematic errors of the rig."""
    best, generator = _plateaux(rig, signals, pull), np.random.default_rng(0)
    drawn = []
    for _ in range(DRAWS):
        one = errors.draw(generator)
        drawn.append(_plateaux(rig, {n: distorted(v, one[n]) if n in one else v for n, v in signals.items()}, pull))
    found = {}
    for name, plateau in best.items():
        apart = [one[name].level - plateau.level for one in drawn if name in one]
        error = float(np.sqrt(np.mean(np.square(apart)))) if 2 * len(apart) >= DRAWS else np.nan
        found[name] = replace(plateau, error=error)
    return found


def _plateaux(rig: BetweenPlatforms, signals: dict[str, Array], pull: float) -> dict[str, Plateau]:
    values, sides = reconstructed(rig, signals, pull), [point.side for point in rig.points]
    lever = sides.count("left") == 2 and sides.count("right") == 1
    feet = feet_loads(rig, values["left_normal"], values["left_place"]) if lever else None
    return friction_from_ratios(values["left_ratio"], values["right_ratio"], feet)
