"""Contact stiffness from geometry and material: finite line contact and Mindlin's point contact.

Where rig measurements are missing, the stiffness of a contact comes from here; `Macroslip` takes the values. Symbols: N normal
load, L length, R radius, b half width of the contact, P = N/L. Both bodies are of one material: 1/E* = 2(1 − ν²)/E. SI
throughout: the formulas of Harris and of Brändlein, stated in N and mm, are converted inside.
"""

from collections.abc import Callable
from dataclasses import dataclass
from math import cos, pi, radians

import numpy as np
from numpy.typing import ArrayLike

from stickslip.support.checks import Array, fault, finite, not_negative, numbers, positive

MILLIMETRE = 1e-3
NODES = 400
"""Points of the quadrature over the load."""


@dataclass(frozen=True)
class LineContact:
    """A cylinder on a flat, or a flat punch with rounded edges, loaded along a line.

    length L, radius R of the cylinder or of the edges, flat: half length a of the flat part (0 for a cylinder) [m];
    young [Pa], poisson [-] of both bodies.
    """

    length: float
    radius: float
    flat: float = 0.0
    young: float = 210e9
    poisson: float = 0.3

    def __post_init__(self) -> None:
        for key in ("length", "radius", "young"):
            positive(f"LineContact.{key}", getattr(self, key))
        not_negative("LineContact.flat", self.flat)
        if not -1.0 < finite("LineContact.poisson", self.poisson) < 0.5:
            raise fault("LineContact.poisson", "must lie between -1 and 0.5", self.poisson)

    @property
    def plane_modulus(self) -> float:
        """E* = E/(2(1 − ν²)), Pa."""
        return self.young / (2.0 * (1.0 - self.poisson**2))

    @property
    def shear_modulus(self) -> float:
        """G = E/(2(1 + ν)), Pa."""
        return self.young / (2.0 * (1.0 + self.poisson))

    def half_width(self, load: ArrayLike) -> Array:
        """b(N) [m]: cylinder b² = 4 P R/(π E*) (Hertz); punch 4 P R/(E* b²) = π − 2φ₀ − sin 2φ₀, sin φ₀ = a/b."""
        size = 4.0 * _loads(load) / self.length * self.radius / self.plane_modulus
        if self.flat == 0.0:
            return np.asarray(np.sqrt(size / pi))
        return np.asarray(self.flat / np.sin(_edge_angle(size / self.flat**2)))

    def pressure(self, load: float, x: ArrayLike) -> Array:
        """p(x) [Pa] at x [m] from the middle, zero beyond the contact (Ciavarella, Hills and Monno 1998 for the punch)."""
        b = float(self.half_width(positive("load", load)))
        share = np.clip(np.asarray(x, dtype=float) / b, -1.0, 1.0)
        angle = np.arcsin(share)
        edge = float(np.arcsin(min(self.flat / b, 1.0)))
        scale = load / self.length / b * 2.0 / pi / (pi - 2.0 * edge - np.sin(2.0 * edge))
        return np.asarray(scale * ((pi - 2.0 * edge) * np.cos(angle) + _edges(angle, edge)))

    def peak_pressure(self, load: ArrayLike) -> Array:
        """p₀ = 2P/(π b) of a cylinder, Pa."""
        if self.flat > 0.0:
            raise fault("LineContact.flat for peak_pressure", "must be 0", self.flat, "Use `pressure` for a punch.")
        return np.asarray(2.0 * _pressed(load) / self.length / (pi * self.half_width(load)))

    def normal_stiffness(self, load: ArrayLike) -> Array:
        """k_n(N) = π E L/(4(1 − ν²) ln(2L/b)) [N/m]: dN/dδ of every profile whose contact has the half width b.

        For the cylinder this is Allara (JSV 320, 2009), k_n = π E L/(2(1 − ν²) ln (2L/b)²) with ln (·)² = 2 ln(·).
        """
        b = self.half_width(_pressed(load))
        if np.any(b >= 0.5 * self.length):  # the formulas hold for lines
            rule = f"must be small against the length of {self.length:g} m"
            raise fault("The half width of the contact", rule, float(np.max(b)), "Check the load and the units (N, m, Pa).")
        return np.asarray(0.5 * pi * self.plane_modulus * self.length / np.log(2.0 * self.length / b))

    def approach(self, load: ArrayLike) -> Array:
        """δ(N) = ∫ dN/k_n [m]; cylinder: δ = 2(1 − ν²)/(π E) P (1 + 2 ln(2L/b))."""
        given = _loads(load)
        nodes, weights = np.polynomial.legendre.leggauss(NODES)
        # N' = N s³ takes the root singularity of b(N) at N = 0 out of the integrand.
        s = 0.5 * (nodes + 1.0)
        integrand = 3.0 * s**2 / self.normal_stiffness(np.maximum(given[..., None] * s**3, 1e-300))
        return np.asarray(given * (integrand @ (0.5 * weights)))

    def tangential_stiffness(self, load: ArrayLike) -> tuple[Array, Array]:
        """Initial k_tx, across the line, and k_ty, along it: 1/k_tx = 1/k_n + c, 1/k_ty = 1/((1 − ν) k_n) − c [N/m].

        c = 2ν/(π G L) is what Cerruti's half-space adds where the line ends: k_tx = π G L/(2((1 − ν) ln(2L/b) + ν)) and
        k_ty = π G L/(2(ln(2L/b) − ν)), which is the softer one for every ν > 0 where L > 3.7 b. Two bodies of one material;
        measured contacts are softer, down to a thirtieth.
        """
        compliance = 1.0 / self.normal_stiffness(load)
        return 1.0 / (compliance + self._ends), 1.0 / (compliance / (1.0 - self.poisson) - self._ends)

    @property
    def _ends(self) -> float:
        """c = 2ν/(π G L), m/N: ∫ ν x²/r³ dy along the line, which is 0 on it and 2ν right beside it."""
        return 2.0 * self.poisson / (pi * self.shear_modulus * self.length)

    def tangential_displacement(self, traction: ArrayLike, load: float, mu: float) -> Array:
        """u(T) = μ[δ(N) − δ(N − T/μ)] + c T across the line on first loading, |T| ≤ μN, m; c = 2ν/(π G L).

        The bracket is the theorem of Jäger and Ciavarella (1998), c T the finite length, as in `tangential_stiffness`.
        Loops follow by Masing's rule, u(T) = u_a + 2 u₀((T − T_a)/2).
        """
        T = self._held(traction, load, mu)
        partial = np.sign(T) * mu * (self.approach(load) - self.approach(load - np.abs(T) / mu))
        return np.asarray(partial + self._ends * T)

    def stick_half_width(self, traction: ArrayLike, load: float, mu: float) -> Array:
        """c = b(N − |T|/μ): inside it the contact sticks; cylinder: c = b √(1 − |T|/(μN)) (Cattaneo 1938), m."""
        return self.half_width(load - abs(self._held(traction, load, mu)) / mu)

    def traction(self, x: ArrayLike, traction: float, load: float, mu: float) -> Array:
        """q(x) = μ[p(x; N) − p(x; N − |T|/μ)] under a first loading T [N], Pa (Cattaneo, Mindlin; Jäger, Ciavarella)."""
        T = float(self._held(traction, load, mu))
        rest = load - abs(T) / mu
        inner = self.pressure(rest, x) if rest > 1e-12 * load else np.zeros(np.shape(x))
        return np.asarray(np.sign(T) * mu * (self.pressure(load, x) - inner))

    def _held(self, traction: ArrayLike, load: float, mu: float) -> Array:
        """The traction, which friction holds up to μN; beyond it by rounding it is μN."""
        positive("load", load)
        positive("mu", mu)
        T = np.asarray(traction, dtype=float)
        if not np.all(np.abs(T) <= mu * load * (1.0 + 1e-12)):
            raise fault("traction", f"must not exceed mu N = {mu * load:g} N", float(np.max(np.abs(T))))
        return np.asarray(np.clip(T, -mu * load, mu * load))


def harris_approach(load: ArrayLike, length: float) -> Array:
    """δ = 3.84e-5 N^0.9/L^0.8 in N and mm (Harris and Kotzalas), steel cylinder on steel flat; here length and δ in m."""
    return _empirical(load, length, 3.84e-5, 0.9, 0.8)


def brandlein_approach(load: ArrayLike, length: float) -> Array:
    """δ = 4.05e-5 N^0.925/L^0.85 in N and mm (Brändlein and others 1999), steel on steel; here length and δ in m."""
    return _empirical(load, length, 4.05e-5, 0.925, 0.85)


NORMAL_STIFFNESS: dict[str, Callable[[LineContact, ArrayLike], Array]] = {
    "Harris": lambda contact, load: _pressed(load) / (0.9 * harris_approach(load, contact.length)),
    "Brändlein": lambda contact, load: _pressed(load) / (0.925 * brandlein_approach(load, contact.length)),
    "Allara": lambda contact, load: contact.normal_stiffness(load),
}
"""The three formulas for the normal stiffness of a cylinder, N/m. The first two know steel and the length only."""


def static_normal_load(pull: float, platform_angle: float) -> float:
    """N̄ = F_C/(2 cos α) of a symmetric damper [N]; pull F_C [N], platform_angle α [degrees]."""
    if not 0.0 <= platform_angle < 90.0:
        raise fault("platform_angle", "must lie in [0, 90) degrees", platform_angle)
    return not_negative("pull", pull) / (2.0 * cos(radians(platform_angle)))


@dataclass(frozen=True)
class SphereContact:
    """A sphere of radius [m] on a flat of the same material, Hertz and Mindlin; young [Pa], poisson [-].

    Displacements are those of the two bodies relative to each other; tables that count one body alone give half of them.
    """

    radius: float
    young: float = 210e9
    poisson: float = 0.3

    def __post_init__(self) -> None:
        positive("SphereContact.radius", self.radius)
        positive("SphereContact.young", self.young)
        if not -1.0 < finite("SphereContact.poisson", self.poisson) < 0.5:
            raise fault("SphereContact.poisson", "must lie between -1 and 0.5", self.poisson)

    @property
    def shear_modulus(self) -> float:
        return self.young / (2.0 * (1.0 + self.poisson))

    def half_width(self, load: float) -> float:
        """Contact radius a, a³ = 3 N R/(4 E*), E* = E/(2(1 − ν²)), m."""
        modulus = self.young / (2.0 * (1.0 - self.poisson**2))
        return float((0.75 * positive("load", load) * self.radius / modulus) ** (1.0 / 3.0))

    def normal_stiffness(self, load: float) -> float:
        """k_n = 2 E* a, N/m."""
        return float(self.young / (1.0 - self.poisson**2) * self.half_width(load))

    def tangential_stiffness(self, load: float) -> float:
        """Initial k_t = 4 G a/(2 − ν) (Mindlin 1949), N/m; k_t/k_n = 2(1 − ν)/(2 − ν)."""
        return float(4.0 * self.shear_modulus * self.half_width(load) / (2.0 - self.poisson))

    def tangential_displacement(self, traction: float, load: float, mu: float) -> float:
        """δ(T) = 3 μN/(2 k_t) (1 − (1 − T/(μN))^(2/3)) on first loading, 0 ≤ T ≤ μN, m."""
        limit = self._limit(traction, load, mu)
        return float(1.5 * limit / self.tangential_stiffness(load) * (1.0 - (1.0 - traction / limit) ** (2.0 / 3.0)))

    def loop_energy(self, traction: float, load: float, mu: float) -> float:
        """Energy of a cycle of ±T at constant load, J (Mindlin and Deresiewicz 1953)."""
        limit = self._limit(traction, load, mu)
        z = traction / limit
        shape = 1.0 - (1.0 - z) ** (5.0 / 3.0) - 5.0 * z / 6.0 * (1.0 + (1.0 - z) ** (2.0 / 3.0))
        return float(7.2 * limit**2 / self.tangential_stiffness(load) * shape)

    def _limit(self, traction: float, load: float, mu: float) -> float:
        """μN, which the traction must not exceed."""
        limit = positive("mu", mu) * positive("load", load)
        if not 0.0 <= traction <= limit:
            raise fault("traction", f"must lie between 0 and mu N = {limit:g} N", traction)
        return limit


def _loads(load: ArrayLike) -> Array:
    """Loads that do not pull."""
    loads = numbers("load", load)
    if not np.all(np.isfinite(loads)) or np.any(loads < 0.0):
        raise fault("load", "must be finite and not negative (N)", np.ravel(loads).tolist()[:4])
    return loads


def _pressed(load: ArrayLike) -> Array:
    """Loads that press: without one there is no contact, and no stiffness."""
    loads = _loads(load)
    if np.any(loads == 0.0):
        raise fault("load", "must be positive (N)", np.ravel(loads).tolist()[:4])
    return loads


def _empirical(load: ArrayLike, length: float, factor: float, exponent: float, root: float) -> Array:
    """factor N^exponent/L^root with L and the result in mm, taken and given in m."""
    L = positive("length", length) / MILLIMETRE
    return np.asarray(factor * _loads(load) ** exponent / L**root * MILLIMETRE)


def _edge_angle(size: Array) -> Array:
    """φ₀ in (0, π/2) with size sin²φ₀ = π − 2φ₀ − sin 2φ₀, size = 4 P R/(E* a²), by bisection."""
    low, high = np.full(np.shape(size), 1e-12), np.full(np.shape(size), 0.5 * pi)
    for _ in range(100):
        middle = 0.5 * (low + high)
        above = size * np.sin(middle) ** 2 > pi - 2.0 * middle - np.sin(2.0 * middle)
        low, high = np.where(above, low, middle), np.where(above, middle, high)
    return np.asarray(0.5 * (low + high))


def _edges(angle: Array, edge: float) -> Array:
    """sin φ ln|sin(φ + φ₀)/sin(φ − φ₀)| + sin φ₀ ln|tan((φ + φ₀)/2) tan((φ − φ₀)/2)|, finite at |φ| = φ₀."""
    if edge == 0.0:
        return np.zeros(np.shape(angle))
    apart = np.where(np.abs(np.abs(angle) - edge) < 1e-9, angle + 1e-9, angle)
    plus, minus = apart + edge, apart - edge
    logarithm = np.log(np.abs(np.sin(plus) / np.sin(minus)))
    return np.asarray(np.sin(apart) * logarithm + np.sin(edge) * np.log(np.abs(np.tan(0.5 * plus) * np.tan(0.5 * minus))))
