"""Loads: forces along a direction, harmonic and static."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

from stickslip.checks import fault, finite, positive, storable

Amplitudes = complex | Mapping[int, complex]


@dataclass(frozen=True)
class Force:
    """p(t) = static + Re Σ_h amplitude_h exp(i h ω t) along `at`.

    at: "NODE.DIRECTION", or coefficients {"NODE.DIRECTION": c} for an inclined direction; amplitude [N]: of the first
    harmonic, or {harmonic: amplitude}. A real amplitude F is F cos ωt; −i F is F sin ωt. Force levels multiply the harmonic
    part and leave the static one.
    """

    at: str | Mapping[str, float]
    amplitude: Amplitudes = 0.0
    static: float = 0.0
    name: str = ""

    def __post_init__(self) -> None:
        finite("Force.static", self.static)
        for harmonic, amplitude in self.amplitudes.items():
            if harmonic < 1:
                raise fault("Force.amplitude", "must have harmonics from 1 on", harmonic, "Use static for a constant.")
            if amplitude:
                positive(f"Size of Force.amplitude of harmonic {harmonic}", abs(amplitude))

    @property
    def direction(self) -> Mapping[str, float]:
        """The direction as coefficients of degrees of freedom."""
        return {self.at: 1.0} if isinstance(self.at, str) else self.at

    @property
    def amplitudes(self) -> dict[int, complex]:
        """{harmonic: complex amplitude}, N."""
        if isinstance(self.amplitude, Mapping):
            return {int(h): complex(a) for h, a in self.amplitude.items()}
        return {1: complex(self.amplitude)}


@dataclass(frozen=True)
class BaseMotion(Force):
    """A moving base: all that is grounded, contacts and springs, moves by x_b along a direction, and is at rest in the equations.

    at: how each degree of freedom moves when the base moves by 1 m as a rigid whole, {"1.x": 1, "2.x": 1}; amplitude and static:
    of the acceleration ẍ_b, m/s². The degrees of freedom then are motions relative to the base, and the load is −M r ẍ_b, r the
    row of `at`. A base displacement X_b at ω is the acceleration −ω² X_b. `ForcedResponse.absolute` adds the motion of the base.
    """


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
    def of(cls, at: str | Output) -> Output:
        """The output of one degree of freedom "NODE.DIRECTION"."""
        return at if isinstance(at, Output) else cls(at, {at: 1.0})
