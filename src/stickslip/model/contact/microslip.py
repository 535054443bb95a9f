"""Microslip: parallel springs and sliders, for gradual slip.

An array of macroslip elements with gaps of their own closes and slips gradually as well, a line contact for instance.

Iwan's model has springs and sliders under one normal load: the modified law for a cylinder on a flat (`Hertz`), other pressures
(`Parabolic`), Segalman's joint (`FourParameter`). Its core are distributions of slip displacements over the springs.

Of the unit stiffness, K(s) slips up to displacement s [in units of μN/kt]; L(s) = ∫ s dK is the force it then carries and
Q(s) = ∫ s² dK. Everything follows: virgin curve T = L + s (1 − K), loop energy W(s) = 4 (s L − Q).

A contact of pressure p(ξ) over its half-width ξ in [0, 1] and uniform shear stiffness slips at s = p(ξ)/mean p: dK = dξ.

A law computes with a number of elements. Unless that is given, cells are as wide as keeps loop energy and virgin curve within
`ACCURACY` of those of the spread, at every amplitude from the share `SMALLEST_SLIP` of full slip on.
"""

from abc import ABC, abstractmethod
from collections.abc import Sequence
from dataclasses import dataclass, field
from functools import lru_cache

import numpy as np
import scipy
from numpy.typing import ArrayLike

from stickslip.model.contact.law import (
    Elements,
    Friction,
    FrictionElements,
    Law,
    NormalElements,
    SingleLoad,
    checked_friction,
    limit_at,
    line_of,
    share_of,
)
from stickslip.support.checks import Array, InputError, between, fault, finite, not_negative, of_kind, positive, vector

ACCURACY = 2e-3
"""Relative error of loop energy and virgin curve that the number of elements keeps to, where it is not given."""

AIM = 0.7 * ACCURACY
"""What cells are made for: they are evened out, and the error is measured at a few places."""

SMALLEST_SLIP = 1e-2
"""Displacement beyond `first`, as a share of that of full slip, from which on it does. Below it, two elements stand for all that
slips: a loop there dissipates about a millionth of that in full slip."""

CELLS_AT_ONCE = 8
"""The number of cells is a multiple of this: a small change of a parameter, as for a derivative, hardly ever changes it."""

WIDEST = 4.0
"""The largest ratio of the ends of a cell."""

WITHIN = np.linspace(0.0, 1.0, 17)[1:-1]
"""Where in a cell the error is measured."""


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

    def elements(self, count: int | None = None) -> tuple[Array, Array]:
        """Stiffness and slip displacement of about `count` elements in parallel, sum of the stiffness one.

        The spread is cut into count/2 cells at first + (last − first)(j/cells)², or without a count as `ACCURACY` asks for. Each
        cell becomes two elements, as a rule of equal stiffness at mean ± deviation: K, L and Q of a cell are kept, so virgin
        curve and energy are exact at every cut.
        """
        if self.atom == 1.0:
            return np.ones(1), np.array([self.last])
        cuts = _accurate_cuts(self) if count is None else self._at(np.linspace(0.0, 1.0, max(1, count // 2) + 1) ** 2)
        stiffness, slip = self._cells(cuts)
        if self.atom > 0.0:
            stiffness, slip = np.append(stiffness, self.atom), np.append(slip, self.last)
        return stiffness, slip

    def _at(self, shares: Array) -> Array:
        """Displacements at shares of the way from `first` to `last`."""
        return np.where(shares < 1.0, self.first + (self.last - self.first) * shares, self.last)

    def _cells(self, cuts: Array) -> tuple[Array, Array]:
        """Two elements for each cell between neighbouring cuts: stiffness and slip displacement."""
        K, L, Q = (np.diff(part) for part in self.moments(cuts))
        mean = L / K
        deviation = np.sqrt(np.maximum(Q / K - mean**2, 0.0))
        # Where the deviation is more than the mean (χ near −1), the lower element is the stiffer one, and not below zero.
        skew = np.where(deviation < mean, 1.0, 0.5 * mean / np.maximum(deviation, np.finfo(float).tiny))
        stiffness = K / (1.0 + skew**2)
        slip = mean - skew * deviation, mean + deviation / skew
        return np.stack([stiffness, skew**2 * stiffness], axis=1).ravel(), np.stack(slip, axis=1).ravel()

    def _cell_error(self, low: float, high: float) -> float:
        """Largest relative error of loop energy and virgin curve in a cell between these shares; at its ends there is none."""
        ends = self._at(np.array([low, high]))
        k, s = self._cells(ends)
        K, L, Q = (float(part[0]) for part in self.moments(ends[:1]))
        a = ends[0] + (ends[1] - ends[0]) * WITHIN
        gone = s < a[:, None]
        force, square = L + np.sum(k * s * gone, axis=1), Q + np.sum(k * s**2 * gone, axis=1)
        energy, curve = 4.0 * (a * force - square), force + a * (1.0 - K - np.sum(k * gone, axis=1))
        return float(np.max(np.abs(np.stack([energy / self.loop_energy(a), curve / self.virgin(a)]) - 1.0)))


def _next_cut(spectrum: Spectrum, share: float) -> float:
    """The upper end of the widest cell from a share on; solved to rounding, since derivatives by parameters are differences."""
    widest = float(np.log(min(WIDEST, 1.0 / share)))

    def beyond(log: float) -> float:
        return spectrum._cell_error(share, share * float(np.exp(log))) - AIM

    if beyond(widest) <= 0.0:
        return min(share * WIDEST, 1.0)
    return share * float(np.exp(scipy.optimize.brentq(beyond, 1e-6, widest, xtol=1e-15)))


@lru_cache(maxsize=256)
def _accurate_cuts(spectrum: Spectrum) -> Array:
    """The cuts of a spread, as few as keep to `ACCURACY`, in a multiple of `CELLS_AT_ONCE`: equally far apart by the error."""
    shares = [SMALLEST_SLIP]
    while shares[-1] < 1.0:
        shares.append(_next_cut(spectrum, shares[-1]))
    cells = len(shares) - 1
    wanted = cells + -cells % CELLS_AT_ONCE
    logs = np.interp(np.linspace(0.0, cells, wanted + 1), np.arange(cells + 1), np.log(shares))
    return spectrum._at(np.concatenate([[0.0], np.exp(logs[:-1]), [1.0]]))


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


@dataclass(frozen=True)
class Iwan(SingleLoad):
    """T = Σ Jenkins(kt k_i, μ k_i s_i N): `spectrum` gives shares k_i of the stiffness and slip displacements s_i in μN/kt.

    Rule for a varying load: every element keeps its stiffness and its share of μN(t), so that at any N the virgin curve is
    that of this N, and a contact that separates and lands again starts anew. N = max(kn (z − gap) + preload, 0), or
    `normal_load`, constant.

    kt: slope at rest, kn [N/m]; mu; preload, normal_load [N]; gap [m]; count: about how many elements, two a cell; unless given,
    as many as keep loop energy and virgin curve within 0.2 % of those of the spread, at every amplitude from 1 % of full slip
    on. Below that the loop energy errs by its own size, and the finest elements stick in the end: state a count there.
    Sources: Iwan (1966); Li, Xu, Gola and Botto (2020), DOI 10.1007/978-3-030-34747-5, whose α N0 is N(t).
    """

    kt: float
    mu: Friction
    kn: float | None = None
    preload: float = 0.0
    gap: float = 0.0
    normal_load: float | None = None
    spectrum: Spectrum = field(default_factory=Hertz)
    count: int | None = None

    def __post_init__(self) -> None:
        positive("kt", self.kt)
        if (self.kn is None) == (self.normal_load is None):
            raise fault("An Iwan contact", "must have either kn or normal_load", {"kn": self.kn, "normal_load": self.normal_load})
        self.check_load()
        of_kind("spectrum", self.spectrum, Spectrum)  # type: ignore[type-abstract]
        if self.count is not None:
            between("count", self.count, 2)

    def elements(self, tangential: int, normal: bool) -> Elements:
        if normal != self.has_normal:
            raise fault("An Iwan contact", "must have a normal direction exactly when kn is given", f"kn = {self.kn}")
        share, slip = self.spectrum.elements(self.count)
        slope, loads, changes = line_of(self.mu)
        limit = (share * slip) * limit_at(self.mu, self.normal_load or 0.0)
        friction, zero = slope * share * slip, np.zeros(share.size, dtype=np.int64)
        bends = (np.outer(loads, friction), np.repeat(changes[:, None], share.size, axis=1)) if normal else ()
        group = FrictionElements(self.kt * share, friction, limit, zero, zero + int(normal), *bends)
        springs = None
        if self.kn is not None:
            springs = NormalElements(np.array([self.kn]), np.array([self.preload - self.kn * self.gap]))
        return Elements((group,) * tangential, springs)


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
