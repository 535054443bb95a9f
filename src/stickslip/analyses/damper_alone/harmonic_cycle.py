"""Damper cycle by harmonic balance, beside quasi-static steps and time integration a third independent method."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from stickslip.model.dampers.between_platforms import RIGHT, BetweenPlatforms
from stickslip.model.dampers.platform_motion import PlatformMotion
from stickslip.model.rigs.laboratory_damper import platform_problem
from stickslip.solve.balance.balance import Evaluation, HarmonicBalance, Point
from stickslip.solve.balance.energy import cycle_work
from stickslip.solve.continuation.newton import correct, fixed
from stickslip.support.checks import Array, InputError, of_kind, positive, whole
from stickslip.support.machine import one_blas_thread

FIRST, FINEST = 0.02, 1e-4
"""Share of the motion by which it grows at first, from stuck contacts, and the smallest that is tried where Newton fails."""

GROWTH = 1.5
"""By what a step follows one that succeeded; it is halved after a failure."""


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

    The motion grows from stuck contacts on, each time from the solution before, by steps that fit. Raises `InputError` where
    none does.
    """
    of_kind("rig", rig, BetweenPlatforms), of_kind("motion", motion, PlatformMotion)
    whole("harmonics", harmonics), whole("samples", samples)
    omega = 2.0 * np.pi * positive("frequency", frequency)
    with one_blas_thread():
        balance = HarmonicBalance(platform_problem(rig, motion), harmonics, samples)
        found = _grown(balance, omega)
        force, moved = balance.carried_forces(found), found.w[: balance.rows]
    return HarmonicCycle(-rig.rows(RIGHT).T @ force, force, moved, float(np.sum(cycle_work(force, moved))))


def _grown(balance: HarmonicBalance, omega: float) -> Evaluation:
    """The solution at the whole motion."""
    point, reached, step = balance.stuck_point(omega, FIRST), 0.0, FIRST
    while True:
        goal = min(reached + step, 1.0)
        found = correct(balance, Point(point.forces, omega, goal), fixed("level", goal), 40, halvings=8, patience=4)
        if not found.converged:
            step *= 0.5
        elif goal == 1.0:
            return found.evaluation
        else:
            point, reached, step = found.evaluation.point, goal, GROWTH * step
        if step < FINEST:
            raise InputError(
                f"Harmonic balance must converge up to the whole motion, but fails at {reached:.0%} of it. "
                "Take fewer harmonics, more samples, or quasi-static steps (`damper_cycle`)."
            )
