"""The cubic through two values with their slopes, as a function of the fraction of the interval between them."""

from __future__ import annotations

from math import copysign, sqrt
from typing import NamedTuple


class Cubic(NamedTuple):
    """Values a and b at the fractions 0 and 1 with slopes da and db over the whole interval: a' = da + d f + c f²."""

    a: float
    b: float
    da: float
    db: float

    @property
    def _bend(self) -> tuple[float, float]:
        """c and d."""
        return 3.0 * (2.0 * (self.a - self.b) + self.da + self.db), 2.0 * (3.0 * (self.b - self.a) - 2.0 * self.da - self.db)

    @property
    def controls(self) -> tuple[float, float, float, float]:
        """The control points; values in between lie between the least and the largest of them."""
        return self.a, self.a + self.da / 3.0, self.b - self.db / 3.0, self.b

    def at(self, f: float) -> float:
        """The value at a fraction."""
        change = f * f * (3.0 - 2.0 * f) * (self.b - self.a)
        return self.a + f * (1.0 - f) ** 2 * self.da - f * f * (1.0 - f) * self.db + change

    def slope(self, f: float) -> float:
        """The slope over the whole interval at a fraction."""
        mean = 6.0 * f * (1.0 - f) * (self.b - self.a)
        return mean + (1.0 - f) * (1.0 - 3.0 * f) * self.da - f * (2.0 - 3.0 * f) * self.db

    @property
    def inner_extremes(self) -> list[float]:
        """Fractions of the two extremes that a cubic may have between ends whose slopes have one sign."""
        if self.da * self.db <= 0.0:
            return []
        square, linear = self._bend
        discriminant = linear * linear - 4.0 * square * self.da
        if square == 0.0 or discriminant <= 0.0:
            return []
        outer = -0.5 * (linear + copysign(sqrt(discriminant), linear))
        turns = sorted((outer / square, self.da / outer))
        return turns if turns[0] > 0.0 and turns[1] < 1.0 else []

    @property
    def trough(self) -> float:
        """Fraction of the lowest place of a cubic that falls, or is level, at its beginning and rises at its end."""
        square, linear = self._bend
        # The root that the slope crosses upwards, in the form that subtracts no two numbers of one sign. Where the linear term is
        # not positive, the square one is, since the slope rises.
        root = sqrt(max(linear * linear - 4.0 * square * self.da, 0.0))
        fraction = (root - linear) / (2.0 * square) if linear <= 0.0 else -2.0 * self.da / (linear + root)
        return min(fraction, 1.0)

    @property
    def top(self) -> float:
        """Fraction of the highest place of a cubic that rises at its beginning and falls at its end."""
        return Cubic(-self.a, -self.b, -self.da, -self.db).trough

    @property
    def lowest(self) -> float:
        """The lower end, or the lowest value of a cubic that falls and rises again."""
        return self.at(self.trough) if self.da < 0.0 < self.db else min(self.a, self.b)
