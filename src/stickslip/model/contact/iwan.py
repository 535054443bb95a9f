"""Iwan model: parallel springs and sliders under one normal load, for gradual slip.

The modified law for a cylinder on a flat (`Hertz`), other pressures (`Parabolic`), Segalman's joint (`FourParameter`).
"""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from stickslip.model.contact.friction import Friction, checked_friction, limit_at, line_of
from stickslip.model.contact.law import Elements, FrictionElements, Law, NormalElements
from stickslip.model.contact.spectrum import Hertz, Parabolic, Spectrum
from stickslip.support.checks import between, fault, finite, not_negative, of_kind, positive


@dataclass(frozen=True)
class Iwan(Law):
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
        checked_friction(self.mu)
        finite("preload", self.preload)
        finite("gap", self.gap)
        if (self.kn is None) == (self.normal_load is None):
            raise fault("An Iwan contact", "must have either kn or normal_load", {"kn": self.kn, "normal_load": self.normal_load})
        if self.kn is not None:
            positive("kn", self.kn)
        if self.normal_load is not None:
            not_negative("normal_load", self.normal_load)
        of_kind("spectrum", self.spectrum, Spectrum)  # type: ignore[type-abstract]
        if self.count is not None:
            between("count", self.count, 2)

    @property
    def has_normal(self) -> bool:
        return self.kn is not None

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

    def continuous_curve(self, u: float, z: float = 0.0) -> float:
        """Virgin curve of the spread itself, without elements, N."""
        limit = self._limit(z)
        return limit * float(self.spectrum.virgin(u * self.kt / limit)) if limit > 0.0 else 0.0

    def continuous_energy(self, amplitude: float, z: float = 0.0) -> float:
        """Loop energy of the spread itself, without elements, J."""
        limit = self._limit(z)
        return limit**2 / self.kt * float(self.spectrum.loop_energy(amplitude * self.kt / limit)) if limit > 0.0 else 0.0

    def _limit(self, z: float) -> float:
        load = self.normal_load if self.kn is None else max(self.kn * (z - self.gap) + self.preload, 0.0)
        return limit_at(self.mu, float(load or 0.0))


def mindlin_sphere(
    G: float,
    nu: float,
    radius: float,
    mu: float,
    kn: float | None = None,
    normal_load: float | None = None,
    count: int | None = None,
) -> Iwan:
    """A sphere on a flat of the same material: kt = 8 G a/(2 − ν), the curve of Mindlin and Deresiewicz at constant load.

    G [N/m²]; radius a of the contact circle [m]. Under a varying load `Iwan` keeps kt; the real a follows N.
    """
    positive("G", G)
    if not 0.0 <= nu <= 0.5:
        raise fault("nu", "must lie in [0, 0.5]", nu)
    kt = 8.0 * G * positive("radius", radius) / (2.0 - nu)
    return Iwan(kt, mu, kn, normal_load=normal_load, spectrum=Parabolic(0.0), count=count)
