"""The cycle of a damper between platforms by harmonic balance: the third way beside quasi-static steps and time integration."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from threadpoolctl import threadpool_limits

from stickslip.checks import Array, InputError, positive
from stickslip.dampers.between_platforms import RIGHT, BetweenPlatforms
from stickslip.dampers.platform_motion import PlatformMotion
from stickslip.harmonic.balance import HarmonicBalance, Point
from stickslip.harmonic.energy import cycle_work
from stickslip.rigs.platform_problem import platform_problem
from stickslip.solve.newton import correct, fixed

LEVELS = np.linspace(0.02, 1.0, 25)
"""Shares of the motion over which the solution is carried from stuck contacts."""


@dataclass(frozen=True, eq=False)
class HarmonicCycle:
    """force_on_right (2, 2H+1): x and y in real harmonics, N; contact forces and motion (rows, 2H+1); energy of a cycle, J."""

    force_on_right: Array
    contact_force: Array
    contact_motion: Array
    energy: float


def harmonic_cycle(
    rig: BetweenPlatforms, motion: PlatformMotion, frequency: float, harmonics: int = 15, samples: int = 512
) -> HarmonicCycle:
    """The steady cycle with virgin sliders, inertia included, at a frequency [Hz].

    The motion grows from 2 to 100 per cent, each time from the solution before. Raises `InputError` where Newton fails.
    """
    omega = 2.0 * np.pi * positive("frequency", frequency)
    with threadpool_limits(1, user_api="blas"):
        balance = HarmonicBalance(platform_problem(rig, motion), harmonics, samples)
        point = balance.stuck_point(omega, float(LEVELS[0]))
        for level in LEVELS:
            found = correct(balance, Point(point.forces, omega, level), fixed("level", level), 40, halvings=8, patience=4)
            if not found.converged:
                raise InputError(
                    f"Harmonic balance must converge up to the whole motion, but fails at {level:.0%} of it. "
                    "Take fewer harmonics, more samples, or quasi-static steps (`damper_cycle`)."
                )
            point = found.evaluation.point
        force, moved = balance.carried_forces(found.evaluation), found.evaluation.w[: balance.rows]
    return HarmonicCycle(-rig.rows(RIGHT).T @ force, force, moved, float(np.sum(cycle_work(force, moved))))
