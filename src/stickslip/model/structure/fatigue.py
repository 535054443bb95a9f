"""The fatigue limit of a material: the amplitude of stress that it stands, over the mean stress (Haigh diagram).

Source: R. C. Juvinall and K. M. Marshek, Fundamentals of Machine Component Design, chapter 8 (Goodman, Gerber, Soderberg);
G. Sines, Behavior of metals under complex static and alternating stresses (1959), for several components.
"""

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Literal

import numpy as np
from numpy.typing import ArrayLike

from stickslip.support.checks import Array, among, fault, numbers, positive

Criterion = Literal["goodman", "gerber", "soderberg"]
CRITERIA = ("goodman", "gerber", "soderberg")


@dataclass(frozen=True)
class FatigueLimit:
    """The stress amplitude σ_A [Pa] that a material stands at a mean stress σ_m [Pa], any number of cycles.

    fatigue_strength: σ_A without mean stress, S. criterion: "goodman", σ_A = S (1 − σ_m/R_m); "gerber",
    σ_A = S (1 − (σ_m/R_m)²); "soderberg", σ_A = S (1 − σ_m/R_p). ultimate_strength: R_m; yield_strength: R_p, beside the first
    two also σ_A + |σ_m| ≤ R_p. points: pairs (σ_m, σ_A) of a measured diagram in place of all these, with straight lines
    between. A mean stress in compression gains nothing; beyond R_m, or the last point, the material stands nothing.
    """

    fatigue_strength: float | None = None
    ultimate_strength: float | None = None
    yield_strength: float | None = None
    criterion: Criterion = "goodman"
    points: Sequence[Sequence[float]] = field(default=())

    def __post_init__(self) -> None:
        among("criterion", self.criterion, CRITERIA)
        if len(self.points):
            if (self.fatigue_strength, self.ultimate_strength, self.yield_strength) != (None, None, None):
                raise fault("points", "must stand alone", "beside a strength", "They are the whole diagram.")
            table, pairs = numbers("points", self.points), list(map(list, self.points))
            if table.ndim != 2 or table.shape[1] != 2 or len(table) < 2:
                raise fault("points", "must be two or more pairs of mean stress and amplitude", pairs)
            if np.any(np.diff(table[:, 0]) <= 0.0) or np.any(table[:, 1] < 0.0):
                raise fault("points", "must have rising mean stresses, and no negative amplitude", pairs)
            return
        if self.fatigue_strength is None:
            raise fault("fatigue_strength", "must be given", "none", "Or give points of a Haigh diagram.")
        for name in ("fatigue_strength", "ultimate_strength", "yield_strength"):
            if getattr(self, name) is not None:
                positive(name, getattr(self, name))
        needed = "yield_strength" if self.criterion == "soderberg" else "ultimate_strength"
        most = getattr(self, needed)
        if most is None:
            raise fault(needed, f'must go with criterion = "{self.criterion}"', "none")
        if self.fatigue_strength >= most:
            raise fault("fatigue_strength", f"must be below {needed} = {most:g}", self.fatigue_strength, "Are they exchanged?")

    def amplitude(self, mean: ArrayLike) -> Array:
        """σ_A [Pa] at mean stresses [Pa]."""
        mean = np.asarray(mean, dtype=float)
        if len(self.points):
            at, allowed = np.asarray(self.points, dtype=float).T
            return np.asarray(np.interp(mean, at, allowed, right=0.0))
        strength, tension = self.fatigue_strength or 0.0, np.maximum(mean, 0.0)
        if self.criterion == "gerber":
            allowed = strength * (1.0 - (tension / (self.ultimate_strength or np.inf)) ** 2)
        else:
            most = self.yield_strength if self.criterion == "soderberg" else self.ultimate_strength
            allowed = strength * (1.0 - tension / (most or np.inf))
        if self.yield_strength is not None:
            allowed = np.minimum(allowed, self.yield_strength - np.abs(mean))
        return np.asarray(np.maximum(allowed, 0.0))

    @property
    def largest_mean(self) -> float:
        """The mean stress [Pa] from which on the material stands no vibration, or that of the last point."""
        if len(self.points):
            return float(self.points[-1][0])
        known = [size for size in (self.ultimate_strength, self.yield_strength) if size is not None]
        return float(min(known))

    @property
    def words(self) -> str:
        """ "Goodman", or "given diagram"."""
        return "given diagram" if len(self.points) else self.criterion.capitalize()
