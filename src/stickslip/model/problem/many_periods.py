"""A problem whose time is counted in several periods of its excitation, for motions that repeat only after these."""

from __future__ import annotations

from dataclasses import replace

from stickslip.model.problem.problem import Problem
from stickslip.support.checks import InputError, between, fault

MOST_PERIODS = 16


def over_periods(problem: Problem, periods: int) -> Problem:
    """The problem over p periods of its excitation as one period of its own, of angular frequency ω/p: harmonic h of a load
    becomes harmonic p h. Refused for tuned disks, whose waves of a fraction of the engine order do not exist."""
    if between("periods", periods, 1, MOST_PERIODS) == 1:
        return problem
    if problem.speed is not None:
        raise fault("periods", "must be 1 where the frequency stands for the rotor speed", periods, "Use problem.at_speed(...).")
    if not problem.systems.one_for_vibration:
        raise InputError(
            "A motion over several periods must be asked for a structure that all harmonics share, but this disk is one sector "
            "that moves in waves of the engine order. Ask it of `disk.full()`."
        )
    forces = []
    for force in problem.forces:
        factor = float(periods) ** force.omega_power  # of a load that goes by ω^k, now counted in ω/p
        amplitude = {periods * harmonic: factor * amplitude for harmonic, amplitude in force.amplitudes.items()}
        forces.append(replace(force, amplitude=amplitude))
    return problem.with_forces(forces)
