"""Ready problems. `RIGS` lists them by their names in study files, `STRESS` their stress recoveries.

Nothing heavy is imported here: scikit-fem loads when a rig is meshed.
"""

from collections.abc import Callable

from stickslip.model.dampers.laboratory import laboratory_damper
from stickslip.model.problem import Problem
from stickslip.model.rigs.beams import blade_root, ring_damper, shrouded_blades
from stickslip.model.rigs.lumped import (
    blade_and_wedge,
    chain,
    chain_of_three,
    chain_varying_load,
    jointed_mode,
    lumped_blisk,
    single_mass,
    strip_damper,
    three_mass_wedge,
)
from stickslip.model.rigs.octopus_blisk import octopus_blisk
from stickslip.model.rigs.single_blade import single_blade, single_blade_stress, two_semi_cylinders
from stickslip.model.structure.stress import StressRecovery

STRESS: dict[str, Callable[..., StressRecovery]] = {"single_blade": single_blade_stress}

__all__ = [
    "RIGS",
    "STRESS",
    "blade_and_wedge",
    "blade_root",
    "chain",
    "chain_of_three",
    "chain_varying_load",
    "jointed_mode",
    "laboratory_damper",
    "lumped_blisk",
    "octopus_blisk",
    "ring_damper",
    "shrouded_blades",
    "single_blade",
    "single_blade_stress",
    "single_mass",
    "strip_damper",
    "three_mass_wedge",
    "two_semi_cylinders",
]

NO_PROBLEMS = ("RIGS", "STRESS", "laboratory_damper", "single_blade_stress")
RIGS: dict[str, Callable[..., Problem]] = {name: globals()[name] for name in __all__ if name not in NO_PROBLEMS}
