"""Measured quantities: the size of an output's displacement, velocity or acceleration, with derivatives.

At a fixed motion the k-th time derivative goes by ω^k, and so does each of its sizes: ∂s/∂ω = k s/ω. Along a curve both count,
ds = ∂s/∂X dX + k s/ω dω; that second term is why the acceleration of a resonance peaks at another frequency than its
displacement.
"""

from dataclasses import dataclass, replace
from typing import Literal, Self, get_args

import numpy as np

from stickslip.solve.balance.fourier import largest_absolute
from stickslip.support.checks import Array, among, fault, of_kind, similar

Kind = Literal["amplitude", "rms", "max_abs"]
"""Amplitude of the first harmonic; root mean square over the period; largest absolute value over the period. The last two count
all harmonics, and of a displacement its mean.
"""


@dataclass(frozen=True)
class Quantity:
    """The k-th time derivative of the displacement; `units` and `name_per_force`: of it and of it per newton."""

    name: str
    order: int
    units: str
    name_per_force: str
    units_per_force: str


QUANTITIES = {
    quantity.name: quantity
    for quantity in (
        Quantity("displacement", 0, "m", "receptance", "m/N"),
        Quantity("velocity", 1, "m/s", "mobility", "m/(s N)"),
        Quantity("acceleration", 2, "m/s2", "inertance", "m/(s2 N)"),
    )
}


PER_FORCE = {quantity.name_per_force: quantity for quantity in QUANTITIES.values()} | {
    "compliance": QUANTITIES["displacement"],
    "accelerance": QUANTITIES["acceleration"],
}
"""By the names of what they are per force."""


def quantity_named(name: str, per_force: bool = False) -> tuple[Quantity, bool]:
    """The quantity of a name and whether it is wanted per force: by the name of its own (mobility) it is."""
    if name in PER_FORCE:
        return PER_FORCE[name], True
    if name not in QUANTITIES:
        rule = f"must be {', '.join(QUANTITIES)}, or per force {', '.join(PER_FORCE)}"
        raise fault("quantity", rule, name, similar(str(name), [*QUANTITIES, *PER_FORCE]))
    return QUANTITIES[name], per_force


_TINY = float(np.finfo(float).tiny)


@dataclass(frozen=True)
class Measure:
    """A size of a quantity of one row of motion; per_force: reported per force level (receptance, mobility, inertance), which
    at a given level peaks where the quantity does. periods: of the excitation, over which the row of motion is expanded: its
    harmonic `periods` is the first one of the excitation.
    """

    quantity: Quantity = QUANTITIES["displacement"]
    kind: Kind = "amplitude"
    per_force: bool = False
    periods: int = 1

    @property
    def order(self) -> int:
        """k, of the time derivative."""
        return self.quantity.order

    @property
    def name(self) -> str:
        """Displacement, ..., or receptance, ..."""
        return self.quantity.name_per_force if self.per_force else self.quantity.name

    @property
    def units(self) -> str:
        """Of a size: m, m/s or m/s2."""
        return self.quantity.units

    @property
    def symbol(self) -> str:
        """For the axis of a figure: |X₁|, ω²|X₁|, "rms velocity", "largest acceleration"."""
        if self.kind == "amplitude":
            return ("|X₁|", "ω|X₁|", "ω²|X₁|")[self.order]
        return f"{'rms' if self.kind == 'rms' else 'largest'} {self.quantity.name}"

    def reported_units(self, newtons: bool) -> str:
        """Of what is reported: per force too; newtons: whether force levels are forces in N."""
        if not self.per_force:
            return self.units
        return self.quantity.units_per_force if newtons else f"{self.units} per unit level"

    def per(self, level: float) -> float:
        """What a size at a force level is divided by where it is reported."""
        return level if self.per_force else 1.0

    @property
    def words(self) -> str:
        """What is measured: "amplitude of the first harmonic of the acceleration"; of the displacement it goes without saying."""
        if self.kind == "max_abs":
            return f"largest {self.quantity.name} in time"
        if self.kind == "amplitude" and self.order == 0:
            return KIND_WORDS[self.kind]
        return f"{KIND_WORDS[self.kind]} of the {self.quantity.name}"

    @property
    def attributes(self) -> dict[str, str]:
        """What a results file keeps, for `measure_of`."""
        return {"quantity": self.name, "measure": self.kind}

    def with_kind(self, kind: Kind) -> Self:
        """Another size of the same quantity."""
        return replace(self, kind=kind)

    def over(self, periods: int) -> Self:
        """The same measure of motions expanded over several periods of the excitation."""
        return replace(self, periods=periods)

    def size(self, motion: Array, omega: float) -> float:
        """The size of a row of motion (2H+1,), m, whose harmonic 1 has ω in rad/s: in m, m/s or m/s²."""
        return self.gradient(motion, omega)[0]

    def gradient(self, motion: Array, omega: float) -> tuple[float, Array, float]:
        """The size, its gradient by the row of motion (2H+1,), and its derivative by ω at that motion."""
        size, gradient = _SIZES[self.kind](motion, self.order, self.periods)
        if self.order == 0:
            return size, gradient, 0.0
        factor = float(omega) ** self.order
        return factor * size, factor * gradient, self.order * factor * size / omega

    def slope(self, motion: Array, omega: float, change: Array, rate: float = 0.0) -> tuple[float, Array]:
        """The size, and its slope where the motion changes by `change` (..., 2H+1) and ω by `rate`: (...)."""
        if self.kind == "amplitude" and self.order == 0:
            cosine, sine = 2 * self.periods - 1, 2 * self.periods
            a, b = motion[cosine], motion[sine]
            size = float(np.hypot(a, b))
            return size, (a * change[..., cosine] + b * change[..., sine]) / max(size, _TINY)
        size, gradient, by_omega = self.gradient(motion, omega)
        return size, np.asarray(change @ gradient + by_omega * rate)

    def of_harmonic(self, amplitude: Array, omega: Array) -> Array:
        """The size of a harmonic motion of this displacement amplitude."""
        share = np.sqrt(0.5) if self.kind == "rms" else 1.0
        return np.asarray(share * np.asarray(omega, dtype=float) ** self.order * amplitude)


DISPLACEMENT_AMPLITUDE = Measure()
"""The measure of peaks unless another one is given."""

KIND_WORDS = {"amplitude": "amplitude of the first harmonic", "rms": "root mean square", "max_abs": "largest value"}


def measure_of(quantity: str, measure: str) -> Measure:
    """The measure of the arguments `quantity` and `measure` of an analysis, checked."""
    derived, per_force = quantity_named(of_kind("quantity", quantity, str))
    among("measure", of_kind("measure", measure, str), get_args(Kind))
    return Measure(derived, measure, per_force)  # type: ignore[arg-type]


def _first_harmonic(motion: Array, order: int, periods: int) -> tuple[float, Array]:
    """h^k √(a_h² + b_h²), h = 1 unless the motion is expanded over several periods."""
    pair = slice(2 * periods - 1, 2 * periods + 1)
    amplitude, factor = float(np.hypot(*motion[pair])), float(periods) ** order
    gradient = np.zeros_like(motion)
    gradient[pair] = factor * motion[pair] / max(amplitude, _TINY)
    return factor * amplitude, gradient


def _rms(motion: Array, order: int, periods: int) -> tuple[float, Array]:
    """√(a0² + ½ Σ h^2k (a_h² + b_h²)), the mean for k = 0 alone."""
    powers = _powers(motion.size, order) ** 2
    weight = np.concatenate([[1.0 if order == 0 else 0.0], 0.5 * powers])
    size = float(np.sqrt(np.sum(weight * motion**2)))
    return size, weight * motion / max(size, _TINY)


def _max_abs(motion: Array, order: int, periods: int) -> tuple[float, Array]:
    """max over time of |dᵏx/dτᵏ|, τ = ωt, true also between samples."""
    if order == 0:
        size, gradient = largest_absolute(motion)
        return float(size), gradient
    powers = _powers(motion.size, order)
    derived = np.zeros_like(motion)
    derived[1:] = powers * (_turned(motion[1:]) if order % 2 else motion[1:])
    size, by_derived = largest_absolute(derived)
    gradient = np.zeros_like(motion)
    gradient[1:] = -_turned(powers * by_derived[1:]) if order % 2 else powers * by_derived[1:]
    return float(size), gradient


_SIZES = {"amplitude": _first_harmonic, "rms": _rms, "max_abs": _max_abs}


def _powers(columns: int, order: int) -> Array:
    """h^k of a1, b1, a2, b2, ..."""
    return np.repeat(np.arange(1.0, (columns + 1) // 2), 2) ** order


def _turned(pairs: Array) -> Array:
    """(b, −a) of pairs (a, b): d/dτ (a cos hτ + b sin hτ) = h (b cos hτ − a sin hτ)."""
    turned = np.empty_like(pairs)
    turned[::2], turned[1::2] = pairs[1::2], -pairs[::2]
    return turned
