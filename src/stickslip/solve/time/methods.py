"""Time integration methods as settings: Newmark and generalised-α in one form with four coefficients.

M a_{n+1−αm} + C v_{n+1−αf} + K q_{n+1−αf} + Bᵀ f_{n+1−αf} = p_{n+1−αf},  x_{n+1−α} = (1 − α) x_{n+1} + α x_n,
q_{n+1} = q_n + h v_n + h² ((½ − β) a_n + β a_{n+1}),   v_{n+1} = v_n + h ((1 − γ) a_n + γ a_{n+1}).
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

from stickslip.support.checks import fault, finite


class Coefficients(NamedTuple):
    """αm, αf, β, γ of the module's equations."""

    mass_weight: float
    force_weight: float
    beta: float
    gamma: float


@dataclass(frozen=True)
class GeneralisedAlpha:
    """Second order, unconditionally stable; motions far above the step rate shrink by `spectral_radius` at every step.

    spectral_radius ρ in [0, 1]: 1 damps nothing, as the trapezoidal rule, and rings or even gains energy where a contact lands
    whose own vibration the steps do not resolve; 0 removes within one step what the step cannot resolve.
    αm = (2ρ − 1)/(ρ + 1), αf = ρ/(ρ + 1), γ = ½ − αm + αf, β = ¼ (1 − αm + αf)².
    Source: Chung and Hulbert, J. Appl. Mech. 60 (1993) 371-375, equations 17, 18 and 25.
    """

    spectral_radius: float = 0.5

    def __post_init__(self) -> None:
        if not 0.0 <= finite("spectral_radius", self.spectral_radius) <= 1.0:
            raise fault("spectral_radius", "must lie in [0, 1]", self.spectral_radius)

    @property
    def coefficients(self) -> Coefficients:
        radius = self.spectral_radius
        mass, force = (2.0 * radius - 1.0) / (radius + 1.0), radius / (radius + 1.0)
        return Coefficients(mass, force, 0.25 * (1.0 - mass + force) ** 2, 0.5 - mass + force)


@dataclass(frozen=True)
class Newmark:
    """Newmark's rule; β = ¼, γ = ½ is the trapezoidal rule, of second order and without numerical damping.

    γ > ½ damps, at first order. Source: Newmark, J. Eng. Mech. Div. ASCE 85 (1959) 67-94.
    """

    beta: float = 0.25
    gamma: float = 0.5

    def __post_init__(self) -> None:
        if not 0.5 <= finite("gamma", self.gamma) <= 2.0 * finite("beta", self.beta):
            values = {"beta": self.beta, "gamma": self.gamma}
            raise fault("Newmark", "must be unconditionally stable, 1/2 <= gamma <= 2 beta", values, "Take 1/4 and 1/2.")

    @property
    def coefficients(self) -> Coefficients:
        return Coefficients(0.0, 0.0, self.beta, self.gamma)


Method = GeneralisedAlpha | Newmark

DEFAULT_METHOD = GeneralisedAlpha()
"""Enough numerical damping to keep a landing contact from ringing, too little to be seen in what the steps resolve."""
