"""How a problem goes with the time of its excitation: with the rotor speed that it follows, and over several of its periods."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from stickslip.model.loads import BaseMotion, Force
from stickslip.support.checks import InputError, between, fault, of_kind, several

if TYPE_CHECKING:
    from stickslip.model.problem.problem import Problem


@dataclass(frozen=True, eq=False)
class SpeedDependence:
    """An engine order excites at ω = EO Ω; stiffness and constant loads vary with the speed Ω [rad/s], K + Ω² K₁, p + Ω² p₁.

    stiffness: K₁ [N s²/m], symmetric: (n, n), of a cyclic structure one for each nodal diameter as its `stiffnesses`; None if
    only loads vary with the speed. loads: forces whose `static` is the load per Ω², N s² (m r of a damper whose pull is m r Ω²),
    without a harmonic part. Structure, C and static loads of the problem itself are those at rest, Ω = 0. Coriolis terms are
    neglected. Harmonic h of the motion, h ω = h EO Ω, sees the dynamic stiffness K + i h ω C − (h ω)² (M − K₁/(h EO)²), and the
    mean K + (ω/EO)² K₁.
    """

    engine_order: int
    stiffness: NDArray[Any] | None = None
    loads: tuple[Force, ...] = ()

    def __post_init__(self) -> None:
        between("speed.engine_order", self.engine_order, 1)
        object.__setattr__(self, "loads", several("speed.loads", self.loads))
        for load in self.loads:
            of_kind("speed.loads, a load", load, Force)
            if isinstance(load, BaseMotion) or any(load.amplitudes.values()):
                raise fault("speed.loads, a load", "must be a Force with its static part alone", load)
        if self.stiffness is not None:
            object.__setattr__(self, "stiffness", np.asarray(self.stiffness))

    def check(self, shape: tuple[int, ...]) -> None:
        """Refuse a K₁ that does not fit the stiffness of a structure."""
        if self.stiffness is None:
            return
        if self.stiffness.shape != shape:
            raise fault("speed.stiffness", f"must have the shape of K, {shape}", self.stiffness.shape)
        if not np.all(np.isfinite(self.stiffness)):
            raise fault("speed.stiffness", "must hold finite numbers", "NaN or infinite ones")
        gap = np.abs(self.stiffness - np.swapaxes(self.stiffness, -1, -2).conj()).max(initial=0.0)
        if gap > 1e-8 * np.abs(self.stiffness).max(initial=0.0):
            raise fault("speed.stiffness", "must be symmetric", f"a difference of {gap:.3g} to its transpose")

    def at(self, omega: float) -> float:
        """The rotor speed Ω, rad/s, at a frequency of the excitation, rad/s."""
        return omega / self.engine_order


def refuse_speed(problem: Problem, what: str) -> None:
    """Refuse a problem of many speeds where one is needed."""
    if problem.speed is not None:
        raise InputError(
            f"{what} must be of a problem at one rotor speed, but stiffness and loads of this one go with it. "
            "Use problem.at_speed(speed), in rad/s."
        )


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
