"""A coefficient of friction that depends on the normal load: numbers that a law turns into bends of its slip limit.

The slip limit μ(N)N is straight between the loads of a table. Its bends lie at these loads, so that kernels evaluate it and its
derivative exactly, and a law with a constant coefficient has none.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from stickslip.support.checks import Array, fault, finite, not_negative, positive, vector

DECADES = 2.0
"""A power law is tabulated over so many decades of the load below and above the one at which its coefficient is given."""

A_DECADE = 10
"""Loads of a power law a decade: the slip limit is then exact to 0.2 % for every exponent from −1 to 0."""


ROUNDING = 1e-12
"""Relative fall of the slip limit that is none: a constant one, from a table or a power of exponent −1."""


@dataclass(frozen=True)
class LoadDependentFriction:
    """A coefficient of friction μ(N), from a table: values μ_k at normal loads N_k [N] of the whole contact, ascending.

    The slip limit L(N) = μ(N) N is straight between its values μ_k N_k, so that μ = L/N lies between μ_k and μ_k+1, and
    dL/dN = (μ_k+1 N_k+1 − μ_k N_k)/(N_k+1 − N_k). Below the first and above the last load μ is constant. L may not fall as N
    grows. A contact that stands for a share of a surface has the coefficient of its share of the loads.

    In place of `mu` of a law: Macroslip(kt=2e7, mu=LoadDependentFriction((10.0, 100.0), (0.6, 0.4)), kn=3e7). For a coefficient
    that a law gives as it likes, tabulate it: LoadDependentFriction(loads, [f(N) for N in loads]).
    """

    over: Sequence[float]
    values: Sequence[float]

    __array_ufunc__ = None
    """A NumPy number times it is left to `__rmul__`."""

    def __post_init__(self) -> None:
        loads, values = vector("mu, over", self.over), vector("mu, values", self.values)
        if loads.size < 2:
            raise fault("mu, over", "must be at least two loads", loads.tolist(), "A constant coefficient is a number.")
        if loads.size != values.size:
            raise fault("mu, values", f"must be one for each of the {loads.size} loads in `over`", values.size)
        for load in loads:
            positive("mu, a load in over", load)
        for value in values:
            positive("mu, one of the values", value)
        if np.any(np.diff(loads) <= 0.0):
            raise fault("mu, over", "must ascend", loads.tolist())
        limits = loads * values
        if np.any(fallen := np.diff(limits) < -ROUNDING * limits[:-1]):
            k = int(np.argmax(fallen))
            raise fault(
                "mu",
                "must not fall faster than 1/N, for the friction force mu N would fall as the load grows",
                f"{values[k]:g} at {loads[k]:g} N and {values[k + 1]:g} at {loads[k + 1]:g} N",
                f"At least {limits[k] / loads[k + 1]:.4g} is possible there.",
            )
        object.__setattr__(self, "over", tuple(map(float, loads)))
        object.__setattr__(self, "values", tuple(map(float, values)))

    @classmethod
    def power(cls, value: float, at: float, exponent: float, over: Sequence[float] | None = None) -> LoadDependentFriction:
        """μ = value (N/at)^exponent, tabulated; exponent −1/3 for a sphere of which the contact area alone decides.

        value: of the coefficient at the normal load `at` [N]; exponent: from −1, a constant friction force, to 1; over: the loads
        (low, high) [N] between which it holds, from at/100 to 100 at unless given. Beyond them the coefficient is constant.
        """
        positive("mu, value", value)
        positive("mu, at", at)
        if not -1.0 <= finite("mu, exponent", exponent) <= 1.0 or exponent == 0.0:
            raise fault("mu, exponent", "must lie between -1 and 1 and not be 0", exponent, "A constant coefficient is a number.")
        low, high = (at * 10.0**-DECADES, at * 10.0**DECADES) if over is None else map(float, vector("mu, over", over, 2))
        if not 0.0 < low < high:
            raise fault("mu, over", "must be two positive loads, the lower one first", [low, high])
        loads = np.geomspace(low, high, 1 + max(1, round(A_DECADE * float(np.log10(high / low)))))
        return cls(tuple(loads), tuple(value * (loads / at) ** exponent))

    def __mul__(self, factor: float) -> LoadDependentFriction:
        """The same with every coefficient times a factor."""
        return LoadDependentFriction(self.over, tuple(factor * value for value in self.values))

    __rmul__ = __mul__

    def share(self, fraction: float) -> LoadDependentFriction:
        """That of a contact which carries this fraction of the load."""
        return LoadDependentFriction(tuple(fraction * load for load in self.over), self.values)

    def limit(self, load: ArrayLike) -> Array:
        """Slip limit L(N) = μ(N) N at normal loads [N], N."""
        N, (first, loads, changes) = np.asarray(load, dtype=float), _line(self)
        beyond = np.maximum(N[..., None] - loads, 0.0)
        return np.asarray(first * (np.maximum(N, 0.0) + beyond @ changes))

    def coefficient(self, load: ArrayLike) -> Array:
        """μ(N) = L(N)/N at normal loads [N]."""
        N = np.maximum(np.asarray(load, dtype=float), self.over[0])
        return np.asarray(self.limit(N) / N)


class Line(NamedTuple):
    """A slip limit L = slope (N + Σ change_k max(N − load_k, 0)): slope [-], loads [N] and changes [-] (k,)."""

    slope: float
    loads: Array
    changes: Array


def _line(friction: LoadDependentFriction) -> Line:
    """Slopes μ_1 up to the first load, between the loads by the limits there, μ_n from the last on; bends where they differ."""
    loads, values = np.asarray(friction.over), np.asarray(friction.values)
    slopes = np.concatenate([values[:1], np.diff(values * loads) / np.diff(loads), values[-1:]])
    return Line(float(values[0]), loads, np.diff(slopes) / values[0])


Friction = float | LoadDependentFriction
"""What `mu` of a law may be."""


def checked_friction(mu: Friction, name: str = "mu") -> None:
    """Refuse what is no coefficient of friction."""
    if not isinstance(mu, LoadDependentFriction):
        not_negative(name, mu)


def line_of(mu: Friction) -> Line:
    """The slip limit of a coefficient over the normal load."""
    return _line(mu) if isinstance(mu, LoadDependentFriction) else Line(float(mu), np.zeros(0), np.zeros(0))


def limit_at(mu: Friction, load: float) -> float:
    """μ(N) N of a coefficient at a normal load [N]."""
    return float(mu.limit(load)) if isinstance(mu, LoadDependentFriction) else mu * load


def share_of(mu: Friction, fraction: float) -> Friction:
    """The coefficient of a contact that carries a fraction of the load."""
    return mu.share(fraction) if isinstance(mu, LoadDependentFriction) else mu


def largest_friction(mu: Friction) -> float:
    """The largest coefficient at any load."""
    return max(mu.values) if isinstance(mu, LoadDependentFriction) else float(mu)
