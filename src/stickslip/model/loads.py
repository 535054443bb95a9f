"""Loads: harmonic and static forces along a direction, and base motion; amplitudes may scale with a power of frequency."""

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from typing import Any, Literal

from stickslip.support.checks import fault, finite, finite_complex, nearest, positive, storable, whole

Amplitudes = complex | Mapping[int, complex]
HIGHEST_POWER = 4
"""Of the frequency in a load."""
Motion = Literal["acceleration", "velocity", "displacement"]
DERIVATIVES: dict[Motion, int] = {"acceleration": 0, "velocity": 1, "displacement": 2}
"""How many times in time each motion of a base is differentiated for its acceleration."""


@dataclass(frozen=True)
class Force:
    """p(t) = static + Re Σ_h amplitude_h ω^k exp(i h ω t) along `direction`, k = omega_power, ω in rad/s.

    direction: "NODE.DIRECTION", or coefficients {"NODE.DIRECTION": c} for an inclined direction; amplitude [N]: of the first
    harmonic, or {harmonic: amplitude}. A real amplitude F is F cos ωt; −i F is F sin ωt. Force levels multiply the harmonic
    part and leave the static one.
    omega_power: 0 for a given force; 2 for an unbalance, whose amplitude then is m e in kg m. Several forces make a polynomial.
    """

    direction: str | Mapping[str, float]
    amplitude: Amplitudes = 0.0
    static: float = 0.0
    name: str = ""
    omega_power: int = field(default=0, kw_only=True)

    def __post_init__(self) -> None:
        what = type(self).__name__
        finite(f"{what}.static", self.static)
        if not isinstance(self.direction, str | Mapping):
            raise fault(f"{what}.direction", 'must be "NODE.DIRECTION" or {"NODE.DIRECTION": coefficient}', self.direction)
        if self.omega_power not in range(HIGHEST_POWER + 1):
            raise fault(f"{what}.omega_power", f"must be a whole number from 0 to {HIGHEST_POWER}", self.omega_power)
        object.__setattr__(self, "omega_power", int(self.omega_power))
        for harmonic, amplitude in self.amplitudes.items():
            if harmonic < 1:
                raise fault(f"{what}.amplitude", "must have harmonics from 1 on", harmonic, "Use static for a constant.")
            if amplitude:
                positive(f"Size of {what}.amplitude of harmonic {harmonic}", abs(amplitude))

    @property
    def coefficients(self) -> Mapping[str, float]:
        """The direction as coefficients of degrees of freedom."""
        return {self.direction: 1.0} if isinstance(self.direction, str) else self.direction

    @property
    def amplitudes(self) -> dict[int, complex]:
        """{harmonic: complex amplitude}, as given."""
        what = f"{type(self).__name__}.amplitude"
        if isinstance(self.amplitude, Mapping):
            return {whole(f"Harmonic of {what}", h): _complex(what, a) for h, a in self.amplitude.items()}
        return {1: _complex(what, self.amplitude)}

    @property
    def power(self) -> int:
        """By which power of ω the load goes."""
        return self.omega_power

    @property
    def factors(self) -> dict[int, complex]:
        """{harmonic: what ω^power is multiplied by}: N (s/rad)^power of a force, m/s² (s/rad)^power of a base's acceleration."""
        return self.amplitudes


def excited_harmonics(forces: Iterable[Force]) -> set[int]:
    """The harmonics that loads act in."""
    return {harmonic for force in forces for harmonic, amplitude in force.amplitudes.items() if amplitude}


def _complex(what: str, value: Any) -> complex:
    return finite_complex(what, value, "must be a number, or {harmonic: number}")


@dataclass(frozen=True)
class BaseMotion(Force):
    """A moving base: all that is grounded, contacts and springs, moves by x_b along a direction, and is at rest in the equations.

    direction: how each degree of freedom moves when the base moves by 1 m as a whole, {"1.x": 1, "2.x": 1}; amplitude: of its
    acceleration ẍ_b [m/s²], or `of` its "velocity" [m/s] or "displacement" [m]: A_h = (i h ω)^k amplitude_h, k = 0, 1, 2; static:
    a constant acceleration, m/s². The degrees of freedom then are motions relative to the base, and the load is −M r ẍ_b, r the
    row of `direction`. `ForcedResponse.absolute` adds the motion of the base.
    """

    of: Motion = field(default="acceleration", kw_only=True)

    def __post_init__(self) -> None:
        super().__post_init__()
        if self.of not in DERIVATIVES:
            raise fault("BaseMotion.of", "must be a known motion", self.of, nearest(str(self.of), DERIVATIVES))
        if not self.static and not any(self.amplitudes.values()):
            raise fault(f"The {self.of} of the base", "must not be zero", 0, "Leave the base out if it rests.")

    @property
    def power(self) -> int:
        """By which power of ω the acceleration goes."""
        return self.omega_power + DERIVATIVES[self.of]

    @property
    def factors(self) -> dict[int, complex]:
        """{harmonic: what ω^power is multiplied by in the acceleration of the base}."""
        return {h: (1j * h) ** DERIVATIVES[self.of] * amplitude for h, amplitude in self.amplitudes.items()}


@dataclass(frozen=True)
class Output:
    """A displacement to report: a name and its direction as coefficients of degrees of freedom."""

    name: str
    direction: Mapping[str, float] = field(default_factory=dict)

    def __post_init__(self) -> None:
        storable("The name of an output", self.name)
        for dof, coefficient in self.direction.items():
            finite(f"Output {self.name!r}, coefficient of {dof}", coefficient)
        if not any(self.direction.values()):
            raise fault(f"Output {self.name!r}", "must have a direction", dict(self.direction))

    @classmethod
    def of(cls, at: "str | Output") -> "Output":
        """The output of one degree of freedom "NODE.DIRECTION"."""
        if not isinstance(at, str | Output):
            raise fault("An output", 'must be "NODE.DIRECTION" or an Output', at)
        return at if isinstance(at, Output) else cls(at, {at: 1.0})
