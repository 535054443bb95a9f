"""Microslip array: parallel macroslip elements with gaps, for gradual closing and slip of a line contact."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from stickslip.model.contact.law import (
    Elements,
    Friction,
    FrictionElements,
    Law,
    NormalElements,
    checked_friction,
    limit_at,
    line_of,
    share_of,
)
from stickslip.support.checks import InputError, fault, finite, vector


@dataclass(frozen=True)
class MicroslipArray(Law):
    """N = Σ max(kn_i (z − gap_i) + N0_i, 0), T = Σ T_i, each T_i a Jenkins element (kt_i, μ N_i).

    kt, kn [N/m], gaps [m], preload N0_i [N]: one entry per element. Without kn: constant loads normal_load_i [N].

    Equations 5 and 6 of "An Experimental and Computational Comparison of the Dynamic Response Variability in a Turbine Blade with
    Under-Platform Dampers". That paper does not say how it distributes its totals; `from_totals` is this project's rule.
    """

    kt: Sequence[float]
    mu: Friction
    kn: Sequence[float] | None = None
    gaps: Sequence[float] | float = 0.0
    preload: Sequence[float] | float = 0.0
    normal_load: Sequence[float] | None = None

    def __post_init__(self) -> None:
        size = len(self.kt)
        if np.any(vector("kt", self.kt) <= 0.0):
            raise fault("kt of every element", "must be positive", list(self.kt))
        checked_friction(self.mu)
        vector("gaps", self.gaps, size)
        vector("preload", self.preload, size)
        if (self.kn is None) == (self.normal_load is None):
            raise InputError(
                "A microslip array must have either kn (varying normal load) or normal_load (constant), but has "
                f"{'neither' if self.kn is None else 'both'}. Give exactly one of the two."
            )
        if self.kn is not None and np.any(vector("kn", self.kn, size) <= 0.0):
            raise fault("kn of every element", "must be positive", list(self.kn))
        if self.normal_load is not None and np.any(vector("normal_load", self.normal_load, size) < 0.0):
            raise fault("normal_load of every element", "must not be negative", list(self.normal_load))

    @classmethod
    def from_totals(cls, kt: float, kn: float, mu: Friction, largest_gap: float, elements: int = 5) -> "MicroslipArray":
        """Equal shares of kt and kn, gaps largest_gap (i − 1)/(n − 1): the element of largest gap closes last, slips first."""
        if elements < 2:
            raise fault("elements", "must be at least 2", elements, "One element is a macroslip law.")
        finite("largest_gap", largest_gap)
        share = np.full(elements, 1.0 / elements)
        gaps = largest_gap * np.arange(elements) / (elements - 1)
        return cls(tuple(kt * share), mu, tuple(kn * share), tuple(gaps))

    @property
    def has_normal(self) -> bool:
        return self.kn is not None

    def elements(self, tangential: int, normal: bool) -> Elements:
        if normal != self.has_normal:
            raise fault(
                "A microslip array",
                "must have a normal direction exactly when kn is given",
                f"kn {'given' if self.has_normal else 'missing'}, normal direction {'given' if normal else 'missing'}",
            )
        size = len(self.kt)
        index = np.arange(size)
        loads = np.zeros(size) if self.normal_load is None else np.asarray(self.normal_load, dtype=float)
        first, last = (index, index + 1) if normal else (0 * index, 0 * index)
        # At its own load an element has the coefficient that the whole contact has where all elements are loaded alike.
        parts = np.asarray(self.kn if self.normal_load is None else self.normal_load, dtype=float)
        mu = [share_of(self.mu, max(part / max(parts.sum(), 1e-300), 1e-12)) for part in parts]
        limits = np.array([limit_at(each, load) for each, load in zip(mu, loads, strict=True)])
        lines = [line_of(each) for each in mu]
        slopes = np.array([line.slope for line in lines])
        bends = tuple(
            np.stack(rows, axis=1) for rows in zip(*((line.slope * line.loads, line.changes) for line in lines), strict=True)
        )
        friction = FrictionElements(np.asarray(self.kt, float), slopes, limits, first, last, *(bends if normal else ()))
        springs = None
        if self.kn is not None:
            kn = np.asarray(self.kn, dtype=float)
            springs = NormalElements(kn, vector("preload", self.preload, size) - kn * vector("gaps", self.gaps, size))
        return Elements((friction,) * tangential, springs)
