"""Interface of contact laws. Most are a table of parallel springs and sliders, and their author only fills the table.

Normal elements:      N_e = max(k_e z + c_e, 0), summed to the normal force N of the contact.
Friction elements:    Jenkins, a spring kt in series with a slider of limit L = μ (sum of some N_e) + L0, which may bend
                      with the load (`friction.py`).
One compiled kernel (`period.py`) carries every such law round a period, with its derivatives. A law that is no such table brings
its own step (`protocol.py`) and says what it has not in common with sliders.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable
from dataclasses import dataclass, field, replace
from typing import Any, ClassVar, Self

import numpy as np
from numpy.typing import NDArray

from stickslip.model.contact.friction import share_of
from stickslip.support.checks import Array, Index, fault


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
    follows, L = ℓ + Σ_k change_k max(ℓ − bend_k, 0) with ℓ = μ Σ N_e + L0.
    bend [N], change [-], (k, e): where the limit bends, of a coefficient that depends on the load; none of a constant one.
    """

    stiffness: Array
    friction: Array
    constant_limit: Array
    first: Index
    last: Index
    bend: Array = field(default_factory=lambda: np.zeros((0, 1)))
    change: Array = field(default_factory=lambda: np.zeros((0, 1)))

    def line(self, normal_forces: Array) -> Array:
        """ℓ of each element for given normal element forces, N."""
        sums = np.concatenate([[0.0], np.cumsum(normal_forces)])
        shared = sums[self.last] - sums[self.first]
        return np.asarray(self.friction * shared + self.constant_limit)

    def passed(self, normal_forces: Array) -> NDArray[np.bool_]:
        """Which bends lie below the limit for given normal element forces, (k, e)."""
        return np.asarray(self.line(normal_forces) > self.bend)

    def limits(self, normal_forces: Array, passed: NDArray[np.bool_] | None = None) -> Array:
        """L of each element for given normal element forces, N; with the bends that are `passed` in place of those that are, it
        is linear in the forces."""
        line = self.line(normal_forces)
        beyond = self.change * (line - self.bend)
        return np.asarray(line + np.where(self.passed(normal_forces) if passed is None else passed, beyond, 0.0).sum(axis=0))

    def bounds(self) -> list[tuple[Array, Array]]:
        """Lines that no limit exceeds, L ≤ slope ℓ + constant, (e,) each: those of the least concave curve above it."""
        lines = [_concave(*ends) for ends in zip(self.constant_limit, self.bend.T, self.change.T, strict=False)]
        if not self.bend.size:
            return [(np.ones(self.stiffness.size), np.zeros(self.stiffness.size))]
        count = max(map(len, lines))
        padded = np.array([[*each, *[each[-1]] * (count - len(each))] for each in lines])
        return [(padded[:, k, 0], padded[:, k, 1]) for k in range(count)]


def _concave(start: float, bend: Array, change: Array) -> list[tuple[float, float]]:
    """Slope and constant of each line of the least concave curve over the limit of one element from ℓ = start on."""
    at = np.append(start, bend)
    limit = at + (change * np.maximum(at[:, None] - bend, 0.0)).sum(axis=1)
    last, lines, k = 1.0 + float(change.sum()), [], 0
    while True:
        slopes = (limit[k + 1 :] - limit[k]) / (at[k + 1 :] - at[k])
        steepest = max(float(slopes.max(initial=last)), last)
        lines.append((steepest, float(limit[k] - steepest * at[k])))
        if steepest <= last:
            return lines
        k += 1 + int(np.flatnonzero(slopes >= steepest)[-1])


@dataclass(frozen=True)
class Elements:
    """The whole table of a contact: one set of friction elements per tangential direction, and the normal elements.

    parameters: the numbers that the law's own kernels read; none for a table of sliders. Elements without stiffness are places
    for further states of such a law.
    """

    friction: tuple[FrictionElements, ...]
    normal: NormalElements | None
    parameters: tuple[float, ...] = ()


SLIDERS = 0
"""Kind of a contact whose law is a table of springs and sliders."""


class Law(ABC):
    """A contact law. A member gives its table for a contact with so many tangential directions and a normal or none.

    extensive: parameters that are shared out where one law stands for a whole surface; the others are the same at each point.
    couples_directions: the force along one tangential direction depends on the motion along the other.
    rate_independent: forces depend on the path of the motion, not on how fast it is passed.
    sticks: a motion small enough is that of the stuck spring kt, and its loop holds no energy.
    remembers_start: where it sticks, the steady force depends on the start state.
    rubs: it dissipates energy; a gap and a cubic spring do not.
    incrementally_passive: of a law with kernels of its own, whether under a constant load the difference of two motions gains no
    energy from it, ∫ ΔT Δu̇ dt ≥ V(end) − V(begin) with V ≥ 0; of a table of sliders the table says so (`problem/contraction.py`).
    """

    extensive: ClassVar[tuple[str, ...]] = ("kt", "kn", "preload", "normal_load")
    couples_directions: ClassVar[bool] = False
    rate_independent: ClassVar[bool] = True
    sticks: ClassVar[bool] = True
    remembers_start: ClassVar[bool] = True
    rubs: ClassVar[bool] = True
    incrementally_passive: ClassVar[bool] = False

    def share(self, fraction: float) -> Self:
        """The law of a point that carries this fraction of the surface: stiffnesses and loads times it, all else as it is."""
        whole = {name: getattr(self, name) for name in self.extensive if hasattr(self, name)}
        changed = {name: _times(fraction, value) for name, value in whole.items() if value is not None}
        if hasattr(self, "mu"):
            changed["mu"] = share_of(self.mu, fraction)
        return replace(self, **changed)  # type: ignore[type-var]

    @classmethod
    def kernels(cls) -> tuple[Callable[..., Any], ...]:
        """The law's own kernels, `step` or `step, period` of its file (`stickslip.model.contact.protocol`); none of sliders."""
        return ()

    @abstractmethod
    def elements(self, tangential: int, normal: bool) -> Elements:
        """The table of springs and sliders; refuses a number of directions that the law does not suit."""

    @property
    def has_friction(self) -> bool:
        """Whether the law acts along tangential directions."""
        return True

    def parameter_scales(self, force: float, width: float) -> Array:
        """What a whole change of each of the law's `Elements.parameters` is, for forces [N] and motions [m] of a size."""
        return np.zeros(0)

    def passage(self, velocity: float) -> float:
        """Share of a period in which the velocity alone takes the force from one limit to the other, for a harmonic motion of a
        velocity amplitude [m/s]; infinite where the force follows the path of the motion."""
        return float("inf")

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


def _times(fraction: float, value: Any) -> Any:
    """A number, or each of several, times a fraction."""
    return tuple(fraction * each for each in value) if np.ndim(value) else fraction * value
