"""The damper routine in a blade model: it replaces the damper's body and contacts and returns harmonic forces on the platform.

The blade moves the left platform, the neighbour's side is at rest. Its equation per harmonic is X = R (P + F(X)), R the
receptance of the platform and F(X) the harmonics of the routine's force for the motion X: the purpose that Gola and Gastaldi
(ASME GT2014-25240) state for it.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy import optimize

from stickslip.analyses.damper_alone.cycle_dataset import forces_on_platforms
from stickslip.analyses.time_response import harmonics_of
from stickslip.model.dampers.between_platforms import BetweenPlatforms
from stickslip.model.dampers.platform_motion import PlatformMotion
from stickslip.model.loads import Force
from stickslip.model.structure.matrices import Structure
from stickslip.solve.balance.fourier import complex_harmonics, real_harmonics
from stickslip.solve.platforms.cycle import CycleModel, CycleOutcome, steady_cycle
from stickslip.support.checks import Array, InputError, positive

SOLVED = 1e-6
"""Residual of the motion, relative to the motion, at which the response counts as found."""


@dataclass(frozen=True, eq=False)
class BladeWithRoutine:
    """Motion of the platform (2, 2H+1) [m] and force of the damper on it (2, 2H+1) [N] in real harmonics, and how often the
    routine was called."""

    platform: Array
    force: Array
    calls: int


def blade_with_routine(
    blade: Structure,
    platform: tuple[str, str],
    rig: BetweenPlatforms,
    forces: Sequence[Force],
    frequency: float,
    *,
    harmonics: int = 7,
    steps: int = 1000,
) -> BladeWithRoutine:
    """Steady response of a blade whose platform (x and y, names of degrees of freedom) is the left one of a damper.

    blade: without the damper, with C; forces: on the blade; frequency [Hz]. The damper is quasi-static. Raises `InputError` where
    no solution is found from the motion with stuck contacts.
    """
    omega, model = 2.0 * np.pi * positive("frequency", frequency), CycleModel.of(rig)
    rows = blade.rows([{name: 1.0} for name in platform])
    # of the platform, (2, 2) at each harmonic
    receptances = [np.asarray(rows @ np.linalg.solve(_dynamic(blade, h, omega), rows.T)) for h in range(harmonics + 1)]
    free = _free_motion(blade, rows, forces, harmonics, omega)
    size, calls = (2, 2 * harmonics + 1), 0

    def damper(values: Array) -> Array:
        nonlocal calls
        calls += 1
        march = steady_cycle(model, PlatformMotion(values).samples(steps))
        if march.outcome == CycleOutcome.NOT_CONVERGED:
            raise InputError("The damper routine must find a cycle, but Newton's method failed in it. Take more steps.")
        return real_harmonics(harmonics_of(forces_on_platforms(model, march)[0].T, harmonics))

    def residual(scaled: Array) -> Array:
        values = scaled.reshape(size) * unit
        answer = complex_harmonics(damper(values))
        passive = np.stack([R @ answer[:, h] for h, R in enumerate(receptances)], axis=1)
        return ((values - free - real_harmonics(passive)) / unit).ravel()

    start = _stuck_motion(model, receptances, free)
    unit = float(np.abs(start).max())
    found = optimize.root(residual, (start / unit).ravel(), method="hybr", options={"xtol": 1e-9})
    if float(np.abs(residual(found.x)).max()) > SOLVED * float(np.abs(found.x).max()):
        raise InputError(f"The response with the damper routine must be found, but is not: {found.message}")
    values = found.x.reshape(size) * unit
    return BladeWithRoutine(values, damper(values), calls)


def _dynamic(blade: Structure, harmonic: int, omega: float) -> np.ndarray:
    s = 1j * harmonic * omega
    damping = np.zeros_like(blade.M) if blade.C is None else blade.C
    return np.asarray(s * s * blade.M + s * damping + blade.K)


def _free_motion(blade: Structure, rows: Array, forces: Sequence[Force], harmonics: int, omega: float) -> Array:
    """Motion of the platform under the forces alone, (2, 2H+1)."""
    load = np.zeros((blade.size, harmonics + 1), dtype=complex)
    for force in forces:
        row = blade.row(force.coefficients)
        load[:, 0] += force.static * row
        for harmonic, factor in force.factors.items():
            load[:, harmonic] += factor * omega**force.power * row
    motion = [rows @ np.linalg.solve(_dynamic(blade, h, omega), load[:, h]) for h in range(harmonics + 1)]
    return real_harmonics(np.stack(motion, axis=1))


def _stuck_motion(model: CycleModel, receptances: Sequence[np.ndarray], free: Array) -> Array:
    """The motion with every contact stuck, and the pull shared as at rest."""
    stuck = model.stuck_stiffness()
    motion = complex_harmonics(free)
    moved = [np.linalg.solve(np.eye(2) + R @ stuck, motion[:, h]) for h, R in enumerate(receptances)]
    return real_harmonics(np.stack(moved, axis=1))
