"""Distributions of slip displacements over the springs of a microslip contact, the core of Iwan's model.

Of the unit stiffness, K(s) slips up to displacement s [in units of μN/kt]; L(s) = ∫ s dK is the force it then carries and
Q(s) = ∫ s² dK. Everything follows: virgin curve T = L + s (1 − K), loop energy W(s) = 4 (s L − Q).

A contact of pressure p(ξ) over its half-width ξ in [0, 1] and uniform shear stiffness slips at s = p(ξ)/mean p: dK = dξ.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from stickslip.checks import Array, fault, not_negative


class Spectrum(ABC):
    """A spread of slip displacements between `first` and `last`, an atom of stiffness at `last` included."""

    @property
    @abstractmethod
    def first(self) -> float:
        """Displacement at which slip begins, in units of μN/kt."""

    @property
    @abstractmethod
    def last(self) -> float:
        """Displacement at which all slips, in units of μN/kt."""

    @abstractmethod
    def moments(self, s: Array) -> tuple[Array, Array, Array]:
        """K, L, Q at displacements between `first` and `last`, without the atom."""

    @property
    def atom(self) -> float:
        """Share of the stiffness that slips at once at `last`."""
        return 0.0

    def virgin(self, s: ArrayLike) -> Array:
        """T(s) on first loading, in units of μN."""
        K, L, _ = self._slipped(np.abs(np.asarray(s, dtype=float)))
        return np.asarray(np.sign(s) * (L + np.abs(s) * (1.0 - K)))

    def loop_energy(self, s: ArrayLike) -> Array:
        """Energy of a loop of amplitude s, in units of (μN)²/kt."""
        amplitude = np.abs(np.asarray(s, dtype=float))
        _, L, Q = self._slipped(amplitude)
        return np.asarray(4.0 * (amplitude * L - Q))

    def _slipped(self, s: Array) -> tuple[Array, Array, Array]:
        """K, L, Q at any displacement, the atom included beyond `last`."""
        K, L, Q = self.moments(np.clip(s, self.first, self.last))
        gone = np.where(s >= self.last, self.atom, 0.0)
        return K + gone, L + self.last * gone, Q + self.last**2 * gone

    def elements(self, count: int) -> tuple[Array, Array]:
        """Stiffness and slip displacement of about `count` elements in parallel, sum of the stiffness one.

        The spread is cut into count/2 cells at first + (last − first)(j/cells)². Each cell becomes two elements of equal
        stiffness at mean ± deviation: K, L and Q of a cell are kept, so virgin curve and energy are exact at every cut.
        """
        cells = max(1, count // 2) if self.atom < 1.0 else 0
        cuts = self.first + (self.last - self.first) * (np.arange(cells + 1) / max(cells, 1)) ** 2
        cuts[-1] = self.last
        K, L, Q = (np.diff(part) for part in self.moments(cuts))
        mean = L / K
        deviation = np.sqrt(np.maximum(Q / K - mean**2, 0.0))
        deviation = np.where(deviation < mean, deviation, 0.0)
        stiffness = [*np.repeat(0.5 * K, 2)]
        slip = [*np.stack([mean - deviation, mean + deviation], axis=1).ravel()]
        if self.atom > 0.0:
            stiffness, slip = [*stiffness, self.atom], [*slip, self.last]
        return np.array(stiffness), np.array(slip)


@dataclass(frozen=True)
class Hertz(Spectrum):
    """A cylinder on a flat, p ~ √(1 − ξ²): T = (2/π)(asin σ + σ √(1 − σ²)) μN with σ = π kt x/(4 μN).

    Source: Li, Xu, Gola and Botto (2020), DOI 10.1007/978-3-030-34747-5, equation 1.
    """

    @property
    def first(self) -> float:
        return 0.0

    @property
    def last(self) -> float:
        return 4.0 / np.pi

    def moments(self, s: Array) -> tuple[Array, Array, Array]:
        sigma = np.clip(s / self.last, 0.0, 1.0)
        c = np.sqrt(1.0 - sigma**2)
        L = 0.5 * self.last * (np.arcsin(sigma) - c * sigma)
        return 1.0 - c, L, self.last**2 * (2.0 / 3.0 - c + c**3 / 3.0)


@dataclass(frozen=True)
class Parabolic(Spectrum):
    """p ~ 1 + (edge − 1) ξ², edge the pressure at the edge over that in the middle: uniform for 1, convex below, concave above.

    edge 0 gives T = 1 − (1 − 2s/3)^(3/2), the curve of Mindlin and Deresiewicz for a sphere at constant load.
    """

    edge: float = 0.0

    def __post_init__(self) -> None:
        not_negative("edge", self.edge)

    @property
    def _mean(self) -> float:
        return (2.0 + self.edge) / 3.0

    @property
    def first(self) -> float:
        return min(1.0, self.edge) / self._mean

    @property
    def last(self) -> float:
        return max(1.0, self.edge) / self._mean

    @property
    def atom(self) -> float:
        return float(self.edge == 1.0)

    def moments(self, s: Array) -> tuple[Array, Array, Array]:
        growth = self.edge - 1.0
        if growth == 0.0:
            return (np.zeros_like(s),) * 3
        end = float(growth > 0.0)
        place = np.where(s >= self.last, end, np.sqrt(np.clip((s * self._mean - 1.0) / growth, 0.0, 1.0)))
        first, second = place + growth * place**3 / 3.0, place + 2.0 * growth * place**3 / 3.0 + growth**2 * place**5 / 5.0
        if growth > 0.0:
            return place, first / self._mean, second / self._mean**2
        whole = 1.0 + 2.0 * growth / 3.0 + growth**2 / 5.0
        return 1.0 - place, 1.0 - first / self._mean, (whole - second) / self._mean**2


@dataclass(frozen=True)
class FourParameter(Spectrum):
    """Segalman's spread R φ^χ up to φ_max and an atom S there, β = S (χ + 1)/(R φ_max^(χ+1)): W ~ A^(χ+3) before gross slip.

    Source: Segalman, J. Appl. Mech. 72 (2005) 752-760.
    """

    chi: float = -0.5
    beta: float = 0.5

    def __post_init__(self) -> None:
        if not -1.0 < self.chi < np.inf:
            raise fault("chi", "must lie above -1", self.chi)
        not_negative("beta", self.beta)

    @property
    def first(self) -> float:
        return 0.0

    @property
    def last(self) -> float:
        return (1.0 + self.beta) / (self.beta + (self.chi + 1.0) / (self.chi + 2.0))

    @property
    def atom(self) -> float:
        return self.beta / (1.0 + self.beta)

    def moments(self, s: Array) -> tuple[Array, Array, Array]:
        chi = self.chi
        R = (chi + 1.0) / ((1.0 + self.beta) * self.last ** (chi + 1.0))
        return tuple(R * s ** (chi + n) / (chi + n) for n in (1, 2, 3))
