"""A damper alone between two platforms: exact plateaux, the cliff, energies of another program, cycles that never fail."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
import xarray as xr
from analyses.damper_alone.test_damper_cycle import random_case

from stickslip.analyses.damper_alone.cycle import damper_cycle
from stickslip.model.contact.microslip import Iwan
from stickslip.model.dampers import in_phase, out_of_phase
from stickslip.model.dampers.laboratory import laboratory_damper
from stickslip.solve.platforms.cycle import CycleOutcome
from verify.row import CLOSED, INDEPENDENT, PAGE, Row, absolute, at_most, relative

TITLE = "A damper between two platforms"
ABOUT = (
    "The three-point laboratory damper (feet 14 mm apart, kt 56, kn 84 N/µm) at 45 and 37 degrees under 50 N, moved by 30 µm; "
    "4000 steps a cycle. Friction rows of the source read as L1, L2, R and as R, L1, L2."
)
FRICTION_ROWS = (
    (0.14, 0.13, 0.13),
    (0.14, 0.22, 0.13),
    (0.14, 0.22, 0.14),
    (0.22, 0.22, 0.13),
    (0.32, 0.22, 0.32),
    (0.40, 0.22, 0.32),
)
"""The six rows of the source's friction study; whether their columns are L1, L2, R or R, L1, L2 is not readable in it."""

# Energies in µJ of FRICTION_ROWS read as L1, L2, R and as R, L1, L2, out of phase and in phase each (docs/damper_cycle.md).
STUDY = (
    (804.3, 775.1, 820.2, 788.0),
    (949.7, 893.2, 957.4, 924.2),
    (982.3, 919.4, 974.0, 936.6),
    (1073.4, 1009.4, 1208.0, 1145.8),
    (1877.2, 1096.9, 1937.9, 1064.0),
    (2005.4, 1172.9, 2257.1, 1157.5),
)


def rows() -> Iterator[Row]:
    yield from energies()
    yield from crossed()
    for angle, limit in ((45.0, 0.450893), (37.0, 0.406928)):
        yield absolute(f"Friction of R at which a foot lifts, {angle:g} degrees", cliff(angle), limit, 1e-5, CLOSED)
    yield at_most("Failures among 200 varied cycles", failures(200), 0.0, "none")
    law = Iwan(2.1, 1.0, normal_load=1.3, count=2000)
    width = 4.0 * 1.3 / (np.pi * 2.1)
    for share, energy in ((0.1, 4.3575e-5), (0.5, 2.86961625e-2), (0.9, 0.359961965), (1.5, 2.668912461)):
        yield relative(
            f"Iwan, 2000 elements, A/x_s = {share:g}: loop energy, J", law.loop_energy(share * width), energy, 1e-5, CLOSED
        )


def energies() -> Iterator[Row]:
    """Of the rows that another program computed, and the larger of the two readings of every row against friction work."""
    known = (
        (45.0, FRICTION_ROWS[0], out_of_phase, 804.3),
        (45.0, FRICTION_ROWS[0], in_phase, 775.1),
        (37.0, FRICTION_ROWS[0], out_of_phase, 626.4),
        (37.0, FRICTION_ROWS[0], in_phase, 807.1),
        (37.0, FRICTION_ROWS[5], out_of_phase, 1516.8),
        (37.0, FRICTION_ROWS[5], in_phase, 1032.5),
    )
    for angle, friction, make, energy in known:
        cycle = damper_cycle(laboratory_damper(angle, 50.0, friction), make(30e-6), steps=4000)
        name = f"Energy, {angle:g} degrees, μ {friction}, {make.__name__}, µJ"
        yield relative(name, 1e6 * cycle.energy, energy, 1e-3, INDEPENDENT)
    errors = []
    for (friction, reading, cycle), energy in zip(friction_table(45.0), np.ravel(STUDY), strict=True):
        errors.append(float(cycle.energy_error))
        name = f"Friction study, μ {friction} as {reading}: energy, µJ"
        yield relative(name, 1e6 * float(cycle.loop_energy), energy, 1e-4, PAGE)
    yield at_most("Loop energy less friction work, all rows and readings, relative", max(errors), 1e-4, "energy balance")


def friction_table(angle: float, steps: int = 4000) -> Iterator[tuple[tuple[float, ...], str, xr.Dataset]]:
    """The friction rows in both readings and both motions."""
    for friction in FRICTION_ROWS:
        for reading, values in (("L1, L2, R", friction), ("R, L1, L2", (*friction[1:], friction[0]))):
            for make in (out_of_phase, in_phase):
                cycle = damper_cycle(laboratory_damper(angle, 50.0, values), make(30e-6), steps=steps)
                yield friction, f"{reading}, {make.__name__}", cycle.dataset


def crossed() -> Iterator[Row]:
    """The three-point and the crossed damper with the last row of friction: energy, rotation, where the left force acts."""
    known = (
        ("three_point", in_phase, 1172.9, 2.226, 10.7, 0.64),
        ("three_point", out_of_phase, 2005.4, 0.018, 3.8, 0.0),
        ("crossed_curved_flat", in_phase, 1700.7, 0.0, 0.0, 0.0),
        ("crossed_curved_flat", out_of_phase, 2070.3, 0.0, 0.0, 0.0),
    )
    for shape, make, energy, rotation, excursion, alone in known:
        cycle = damper_cycle(laboratory_damper(45.0, 50.0, FRICTION_ROWS[5], shape), make(30e-6), steps=4000).dataset
        lower, upper = cycle.normal_force.values[:, 0], cycle.normal_force.values[:, 1]
        name = f"{shape}, {make.__name__}: "
        yield relative(f"{name}energy, µJ", 1e6 * float(cycle.loop_energy), energy, 1e-4, PAGE)
        yield absolute(f"{name}rotation, mrad", 1e3 * float(cycle.rotation), rotation, 1e-3, PAGE)
        yield absolute(f"{name}excursion, mm", float(np.ptp(7.0 * (upper - lower) / (upper + lower))), excursion, 0.1, PAGE)
        share = float(cycle.share.sel(kind="open").sum())
        yield absolute(f"{name}share of the cycle with an open contact", share, alone, 0.01, PAGE)


def cliff(angle: float) -> float:
    """Friction of R at which L2 begins to lift, by bisection to 1e-6."""
    low, high = 0.38, 0.47
    while high - low > 1e-6:
        middle = 0.5 * (low + high)
        cycle = damper_cycle(laboratory_damper(angle, 50.0, (0.18, 0.199, middle)), out_of_phase(30e-6), steps=500)
        opens = float(cycle.dataset.share.sel(contact="L2", kind="open")) > 0.0
        low, high = (low, middle) if opens else (middle, high)
    return 0.5 * (low + high)


def failures(count: int) -> float:
    """How many of so many random cycles do not become steady."""
    generator = np.random.default_rng(1)
    cases = (random_case(generator, k) for k in range(count))
    return float(sum(damper_cycle(rig, motion, steps=500).outcome != CycleOutcome.STEADY for rig, motion in cases))
