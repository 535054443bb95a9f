"""The cubic through two values with their slopes, as a function of the fraction of the interval between them."""

from __future__ import annotations

from math import sqrt
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
        turns = sorted((-linear + sign * sqrt(discriminant)) / (2.0 * square) for sign in (-1.0, 1.0))
        return turns if turns[0] > 0.0 and turns[1] < 1.0 else []

    @property
    def trough(self) -> float:
        """Fraction of the lowest place of a cubic that falls and rises again."""
        square, linear = self._bend
        # The root that the slope crosses upwards, in the form that loses no digits for a small square term.
        return -2.0 * self.da / (linear + sqrt(linear * linear - 4.0 * square * self.da))

    @property
    def lowest(self) -> float:
        """The lower end, or the lowest value of a cubic that falls and rises again."""
        return self.at(self.trough) if self.da < 0.0 < self.db else min(self.a, self.b)
