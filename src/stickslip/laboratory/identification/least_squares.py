"""Least squares between bounds, the core of all identifications: parameters and their scale, derivatives, starts, solution."""

from abc import ABC, abstractmethod
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from types import MappingProxyType
from typing import Any

import numpy as np
from scipy import special
from scipy.optimize import least_squares

from stickslip.support.checks import Array, Index, fault, finite, positive, truth

CERTAINTY = float(special.ndtri(0.975))
"""Half width of a 95 % interval of a normal distribution, in standard errors: 1.96."""

CLOSE = 1.1
"""A simpler law is kept while its error on what was held out is below this times the smallest."""

INSIDE = 1e-9
"""Share of the distance of its bounds by which a variable begins inside them."""


@dataclass(frozen=True)
class FreeParameter:
    """A parameter to identify: where it starts and its bounds, in the units of the problem's argument.

    each_test: it has a value of its own in every test. deviation: standard deviation of what is known of it beforehand about
    `start` (a prior), or None for nothing. Where both bounds are positive its variable is the logarithm, else the share of the
    way between the bounds.
    """

    start: float
    low: float
    high: float
    each_test: bool = False
    deviation: float | None = None

    def __post_init__(self) -> None:
        for name in ("start", "low", "high"):
            finite(name, getattr(self, name))
        if not self.low <= self.start <= self.high or self.low == self.high:
            raise fault("start", "must lie between low and high, which differ", (self.start, self.low, self.high))
        truth("each_test", self.each_test)
        if self.deviation is not None:
            positive("deviation", self.deviation)

    @property
    def logarithmic(self) -> bool:
        return self.low > 0.0

    def variable(self, value: float) -> float:
        """The variable of a value: its logarithm, or its place between the bounds."""
        return float(np.log(value)) if self.logarithmic else (value - self.low) / (self.high - self.low)

    def value(self, variable: float) -> float:
        """The value of a variable."""
        return float(np.exp(variable)) if self.logarithmic else self.low + (self.high - self.low) * variable

    def slope(self, value: float) -> float:
        """d value/d variable."""
        return value if self.logarithmic else self.high - self.low


@dataclass(frozen=True, eq=False)
class Solution:
    """Variables x of the least squares, the sum of squares there, the residuals and their derivatives by the free variables.

    moved: False where the search saw a way down from its start and found none.
    """

    x: Array
    cost: float
    residuals: Array
    jacobian: Array
    moved: bool


class LeastSquares(ABC):
    """Variables between bounds that minimise the sum of the squares of residuals: what all fits have in common.

    A fit states bounds and residuals, and derivatives where it knows them. stops: stopping rule and scale of the trust region
    (`scipy.optimize.least_squares`); step: of differences, in the variables.
    """

    stops: Mapping[str, Any] = MappingProxyType({"x_scale": 0.1})
    step: float = 1e-7

    @property
    @abstractmethod
    def bounds(self) -> tuple[Array, Array]:
        """The least and the largest variables, (variables,) each."""

    @abstractmethod
    def residuals(self, x: Array) -> Array:
        """Residuals at the variables, in standard errors where these are known."""

    def jacobian(self, x: Array, here: Array | None = None) -> Array:
        """Derivatives of the residuals, (residuals, variables), by differences inside the bounds; here: the residuals at x."""
        here = self.residuals(x) if here is None else here
        steps = np.diag(np.where(x + self.step <= self.bounds[1], self.step, -self.step))
        return np.stack([(self.residuals(x + step) - here) / step[k] for k, step in enumerate(steps)], axis=1)

    def cost(self, x: Array) -> float:
        """Sum of the squares of the residuals."""
        return float(np.sum(self.residuals(x) ** 2))

    def solved(self, start: Array, held: Sequence[int] = (), evaluations: int | None = None, **stops: float) -> Solution:
        """The least squares from a start, in which the variables of the numbers `held` stay. stops: in place of the class's."""
        free: Index = np.delete(np.arange(start.size), list(held))
        low, high = (ends[free] for ends in self.bounds)
        if not free.size:
            return Solution(start, self.cost(start), self.residuals(start), self.jacobian(start)[:, free], True)
        inside = np.clip(start[free], low + INSIDE * (high - low), high - INSIDE * (high - low))
        last: dict[bytes, Array] = {}

        def whole(own: Array) -> Array:
            x = start.copy()
            x[free] = own
            return x

        def residuals(own: Array) -> Array:
            last.clear()
            last[own.tobytes()] = self.residuals(whole(own))
            return last[own.tobytes()]

        def jacobian(own: Array) -> Array:
            return self.jacobian(whole(own), last.get(own.tobytes()))[:, free]

        settings = {**self.stops, "max_nfev": evaluations, **stops}
        found = least_squares(residuals, inside, jacobian, bounds=(low, high), **settings)
        # A first step that is too short to take means that the start is the end.
        moved = bool(np.any(found.x != inside)) or found.nfev < 3
        return Solution(whole(found.x), 2.0 * float(found.cost), found.fun, np.asarray(found.jac), moved)

    def solutions(self, starts: Iterable[Array], enough: Callable[[Sequence[Solution]], bool], **settings: Any) -> list[Solution]:
        """The least squares from several starts in turn until they are enough, the best first."""
        found: list[Solution] = []
        for start in starts:
            found.append(self.solved(start, **settings))
            if enough(found):
                break
        return sorted(found, key=lambda one: one.cost)
