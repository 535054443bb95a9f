"""Interface of contact laws: a law is a table of parallel springs and sliders, and its author only fills the table.

Normal elements:      N_e = max(k_e z + c_e, 0), summed to the normal force N of the contact.
Friction elements:    Jenkins, a spring kt in series with a slider of limit L = μ (sum of some N_e) + L0.
One compiled kernel (`stickslip.contact.period`) carries every such law round a period, with its derivatives.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from dataclasses import dataclass

import numpy as np

from stickslip.checks import Array, Index, fault


@dataclass(frozen=True)
class NormalElements:
    """N_e = max(stiffness_e z + constant_e, 0): arrays (e,), N/m and N. constant = N0 − kn δ."""

    stiffness: Array
    constant: Array

    def forces(self, z: float) -> Array:
        """N_e at normal displacement z, N."""
        return np.maximum(self.stiffness * z + self.constant, 0.0)


@dataclass(frozen=True)
class FrictionElements:
    """Jenkins elements of one direction: arrays (e,).

    stiffness [N/m]; friction μ; constant_limit L0 [N]; first, last: the normal elements first..last−1 whose load the limit
    follows, L = μ Σ N_e + L0.
    """

    stiffness: Array
    friction: Array
    constant_limit: Array
    first: Index
    last: Index

    def limits(self, normal_forces: Array) -> Array:
        """L of each element for given normal element forces, N."""
        sums = np.concatenate([[0.0], np.cumsum(normal_forces)])
        shared = sums[self.last] - sums[self.first]
        return np.asarray(self.friction * shared + self.constant_limit)


@dataclass(frozen=True)
class Elements:
    """The whole table of a contact: one set of friction elements per tangential direction, and the normal elements.

    coupled: the two directions, of one equal element each, share one friction disc. cubic: k3 of a spring k3 w³ along each
    tangential direction, N/m³, which then has no friction elements; 0 without one.
    """

    friction: tuple[FrictionElements, ...]
    normal: NormalElements | None
    coupled: bool = False
    cubic: float = 0.0


class Law(ABC):
    """A contact law. A member gives its table for a contact with so many tangential directions and a normal or none."""

    @abstractmethod
    def elements(self, tangential: int, normal: bool) -> Elements:
        """The table of springs and sliders; refuses a number of directions that the law does not suit."""

    def loop_energy(self, amplitude: float, z: float = 0.0) -> float:
        """Energy per cycle of u = A cos ωt at constant z, one direction: Σ 4 L (A − L/kt) over the elements with A > L/kt, J."""
        table, forces = self._at(z)
        limits = table.limits(forces)
        return float(np.sum(4.0 * limits * np.maximum(amplitude - limits / table.stiffness, 0.0)))

    def virgin_curve(self, u: float, z: float = 0.0) -> float:
        """Traction on first loading at constant z, one direction: T(u) = Σ min(kt_e u, L_e), N."""
        table, forces = self._at(z)
        return float(np.sign(u) * np.sum(np.minimum(table.stiffness * abs(u), table.limits(forces))))

    def _at(self, z: float) -> tuple[FrictionElements, Array]:
        varying = self.has_normal
        elements = self.elements(1, varying)
        if not elements.friction:
            raise fault(type(self).__name__, "must have a tangential direction here", "a law without friction")
        return elements.friction[0], elements.normal.forces(z) if elements.normal is not None else np.zeros(0)

    @property
    @abstractmethod
    def has_normal(self) -> bool:
        """Whether the law needs a normal direction (a varying normal load)."""
