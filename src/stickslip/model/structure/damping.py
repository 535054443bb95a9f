"""Viscous damping of a structure: a matrix C, Rayleigh damping, or modal damping on free or stuck modes."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Literal

import numpy as np

from stickslip.support.checks import fault, finite, not_negative, positive, vector


@dataclass(frozen=True)
class ModalDamping:
    """Damping ratio ζ of every mode (a number), or of the first modes one by one (then zero).

    on = "stuck": the modes of K + BᵀK_cB; "free": those of K, the contacts absent.
    """

    ratio: float | Sequence[float]
    on: Literal["stuck", "free"] = "stuck"

    def __post_init__(self) -> None:
        if np.any(vector("damping ratio", np.asarray(self.ratio)) < 0.0):
            raise fault("damping ratio", "must not be negative", self.ratio)
        if self.on not in ("stuck", "free"):
            raise fault("on", 'must be "stuck" or "free"', self.on)


@dataclass(frozen=True)
class RayleighDamping:
    """C = mass_factor M + stiffness_factor K. Factors in 1/s and s."""

    mass_factor: float
    stiffness_factor: float

    def __post_init__(self) -> None:
        not_negative("mass_factor", self.mass_factor)
        not_negative("stiffness_factor", self.stiffness_factor)


@dataclass(frozen=True)
class Dashpot:
    """A viscous damper along a direction, force c ẇ with w = Σ coefficient × dof; c [N s/m].

    It adds c rowᵀ row to C, whatever the damping of the structure is, and to the viscous part of all energies.
    """

    direction: Mapping[str, float]
    c: float

    def __post_init__(self) -> None:
        positive("c of a dashpot", self.c)
        _check_direction("A dashpot", self.direction)


@dataclass(frozen=True)
class AerodynamicDamping:
    """The viscous part of gas forces that follow the motion along a direction, c ẇ; c [N s/m], negative where they feed it.

    It stands in `Problem(dashpots=...)`. c = Im(L)/ω of a complex stiffness L [N/m] at ω, or 2ζmω of a damping
    ratio ζ and a modal mass m along the direction.
    """

    direction: Mapping[str, float]
    c: float

    def __post_init__(self) -> None:
        if finite("c of an aerodynamic damping", self.c) == 0.0:
            raise fault("c of an aerodynamic damping", "must not be zero", self.c)
        _check_direction("An aerodynamic damping", self.direction)


def _check_direction(what: str, direction: object) -> None:
    if not isinstance(direction, Mapping):
        rule = "must have a direction: coefficients by degree of freedom"
        raise fault(what, rule, direction, 'Write {"1.x": 1.0} for motion along x of node 1.')
    for dof, coefficient in direction.items():
        finite(f"{what}, coefficient of {dof}", coefficient)
    if not any(direction.values()):
        raise fault(what, "must have a direction", dict(direction))


Damping = ModalDamping | RayleighDamping
