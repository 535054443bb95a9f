"""Measured frequency responses: stepped sines of one output under a measured force, with amplitude and, if known, phase.

What they say by themselves: units that were assumed, flat tops of clipped sensors.

The peak of a response curve, computed or measured: frequency, size, and damping ratio from the width at half power.
"""

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any, Literal

import numpy as np
from numpy.typing import ArrayLike

from stickslip.laboratory.measurement.number_table import FileUnit
from stickslip.laboratory.measurement.records import longest_run
from stickslip.support.checks import Array, among, fault, first_of, listed, of_kind, positive, storable, truth, vector, whole

Held = Literal["force", "response"]

LARGEST_PHASE = 20.0
"""rad; a curve turns by π at each resonance, and in degrees the first one already goes beyond."""

THOUSAND = (300.0, 3000.0)
"""Ratio of two responses per force that a unit a thousand times another explains: friction moves them by less than three, but for
the resonance."""


@dataclass(frozen=True, eq=False)
class MeasuredResponse:
    """A test: at each frequency [Hz] the amplitude of the first harmonic of an output and the force; (n,) each.

    amplitude: in m, m/s or m/s² by `quantity`, a number for all or (n,). force: the force level, factor on the harmonic forces of
    the problem (N where these are 1 N), a number or (n,): shakers drop out at resonance, so that it varies. phase: of the
    displacement against the force in rad (n,), or None where only amplitudes are known.
    held: what each computed point takes as measured, its "force", or its "response" amplitude, the force then being computed.
    output: number of the output. settings: keywords of the problem for this test, say its preload or mounting.
    error: standard error of a measured response per force, relative to it, or where `of_largest` to the largest of the curve.
    free_gain, free_phase: a constant factor and a constant phase of the measuring chain are free variables of this test.
    joint: the specimen or assembly that was measured, where tests of several go into one identification.
    notes: what was assumed in reading, one sentence each. units: of the columns of its file, by what they hold.
    """

    frequency: ArrayLike
    amplitude: ArrayLike
    force: ArrayLike
    phase: ArrayLike | None = None
    quantity: str = "acceleration"
    output: int = 0
    name: str = ""
    held: Held = "force"
    settings: Mapping[str, Any] = field(default_factory=dict)
    error: float = 0.01
    of_largest: bool = False
    free_gain: bool = False
    free_phase: bool = False
    joint: str = ""
    notes: tuple[str, ...] = ()
    units: Mapping[str, FileUnit] = field(default_factory=dict)

    def __post_init__(self) -> None:
        what = f"test {storable('The name of a test', self.name)!r}" if self.name else "A test"
        frequency = vector(f"{what}, frequency", self.frequency)
        if frequency.size < 3:
            raise fault(f"{what}, frequency", "must hold at least three values", frequency.size)
        object.__setattr__(self, "frequency", frequency)
        for key in ("amplitude", "force"):
            object.__setattr__(self, key, vector(f"{what}, {key}", getattr(self, key), frequency.size))
        for key in ("frequency", "amplitude", "force"):
            if np.any(getattr(self, key) <= 0.0):
                raise fault(f"{what}, {key}", "must be positive", float(np.min(getattr(self, key))))
        if self.phase is not None:
            object.__setattr__(self, "phase", vector(f"{what}, phase", self.phase, frequency.size))
            largest = float(np.max(np.abs(np.asarray(self.phase))))
            if largest > LARGEST_PHASE:
                raise fault(f"{what}, phase", "must be in rad", largest, "Are these degrees?")
        elif self.free_phase:
            raise fault(f"{what}, free_phase", "must go with measured phases", True)
        if not all(isinstance(key, str) for key in of_kind(f"{what}, settings", self.settings, Mapping)):  # type: ignore[type-abstract]
            raise fault(f"{what}, settings", "must be {argument of the problem: value}", self.settings)
        for key in ("of_largest", "free_gain", "free_phase"):
            truth(f"{what}, {key}", getattr(self, key))
        whole(f"{what}, output", self.output)
        among(f"{what}, held", self.held, ("force", "response"))
        among(f"{what}, quantity", self.quantity, ("displacement", "velocity", "acceleration"))
        positive(f"{what}, error", self.error)
        storable(f"{what}, joint", self.joint)

    @property
    def per_force(self) -> Array:
        """Response per force level (n,): complex with the phase of the displacement where that is known, else its size."""
        size = np.asarray(self.amplitude, dtype=float) / np.asarray(self.force, dtype=float)
        return size if self.phase is None else np.asarray(size * np.exp(1j * np.asarray(self.phase, dtype=float)))

    @property
    def deviation(self) -> Array:
        """Standard error of `per_force` (n,)."""
        size = np.abs(self.per_force)
        return np.asarray(self.error * (np.full(size.shape, size.max()) if self.of_largest else size))


def by_joint(tests: Sequence[MeasuredResponse]) -> list[tuple[str, list[int]]]:
    """The numbers of the tests of each joint, with its name; each test by itself where no joints are named."""
    if not any(test.joint for test in tests):
        return [(test.name, [k]) for k, test in enumerate(tests)]
    return [
        (joint, [k for k, test in enumerate(tests) if test.joint == joint]) for joint in dict.fromkeys(one.joint for one in tests)
    ]


def flat_top(test: MeasuredResponse) -> list[str]:
    """A sentence where neighbouring points have the largest amplitude of a test to the last digit, as a clipped sensor shows it,
    while other neighbours differ, and where all are equal; none where the response is held."""
    amplitude = np.asarray(test.amplitude)[np.argsort(np.asarray(test.frequency), kind="stable")]
    top = amplitude == amplitude.max()
    longest, others = longest_run(top), longest_run((np.diff(amplitude) == 0.0) & ~top[1:])
    if test.held == "response" or longest <= max(1, others + 1):
        return []
    if longest == amplitude.size and np.ptp(np.asarray(test.force)) > 0.0:
        return [
            f"The {test.quantity} of {test.name} is the same at all points, while the force varies. Was it held "
            "(held='response', --held response), or are the columns of force and response swapped?"
        ]
    limited = "" if np.ptp(np.asarray(test.force)) == 0.0 else ", and a response that the controller limits"
    unit = test.units.get(test.quantity, FileUnit("", 1.0))
    factor, text = (1.0, "") if "/N" in unit.text else (unit.factor, f" {unit.text}".rstrip())
    return [
        f"{longest} points of {test.name} in a row have the largest {test.quantity}, {amplitude.max() / factor:.6g}{text}, "
        "to the last digit: "
        f"a clipped sensor looks so{limited}. Clipped points make the damping too high: leave them out."
    ]


def assumed_units(tests: Sequence[MeasuredResponse]) -> list[str]:
    """For each set of units that files do not state: the files, the columns and what was assumed."""
    sets: dict[tuple[tuple[str, str], ...], list[str]] = {}
    for test in tests:
        lacking = tuple((key, unit.text) for key, unit in test.units.items() if unit.assumed)
        if lacking:
            sets.setdefault(lacking, []).append(test.name)
    return [
        f"No unit is stated of {listed([key for key, _ in lacking])} in {first_of(names)}: "
        f"{listed([unit for _, unit in lacking])} {'is' if len(lacking) == 1 else 'are'} assumed."
        for lacking, names in sets.items()
    ]


def joined(notes: Sequence[tuple[str, str]]) -> list[str]:
    """Sentences on tests, (name, sentence) each: those that differ in the name alone as one, and each once."""
    alike: dict[tuple[str, str], dict[str, None]] = {}
    for name, note in notes:
        places = list(re.finditer(rf"\b{re.escape(name)}(\.[A-Za-z]\w*)?(?!\w)", note))  # the test, or its file
        if len(places) == 1:
            (place,) = places
            alike.setdefault((note[: place.start()], note[place.end() :]), {})[place.group()] = None
        else:
            alike.setdefault((note, ""), {})
    return [f"{start}{first_of(list(names))}{end}" for (start, end), names in alike.items()]


def at_frequencies(wanted: Array, frequency: Array, size: Array) -> Array:
    """The size at wanted frequencies (n,) by straight lines along a curve, the largest where it is folded; NaN beside it."""
    found = np.full(wanted.shape, np.nan)
    if frequency.size < 2:
        return found
    for a, b, x, y in zip(frequency[:-1], frequency[1:], size[:-1], size[1:], strict=True):
        here = np.flatnonzero((wanted >= min(a, b)) & (wanted <= max(a, b)))
        if here.size:
            share = (wanted[here] - a) / (b - a) if a != b else np.zeros(here.size)
            found[here] = np.fmax(found[here], (1.0 - share) * x + share * y)
    return found


def curve_peak(frequency: Array, size: Array, peak: tuple[float, float] | None) -> Array:
    """Frequency, size and damping ratio (3,) of a computed curve with a known peak, in the order of travel; NaN without one.

    Outside the band sizes are NaN, so that no width is read there.
    """
    if peak is None:
        return np.full(3, np.nan)
    at = int(np.nanargmin(np.abs(frequency / peak[0] - 1.0) + np.abs(size / peak[1] - 1.0)))
    return np.array([*peak, half_power(frequency, size, at, *peak)])


def measured_peak(frequency: Array, size: Array) -> Array:
    """Frequency, size and damping ratio (3,) of a measured curve, ascending: by the parabola through its largest point and both
    neighbours; NaN where the largest is an end. Points without a size are left out."""
    there = np.isfinite(size)
    frequency, size = frequency[there], size[there]
    if size.size < 3:
        return np.full(3, np.nan)
    at = int(np.argmax(size))
    if at in (0, size.size - 1):
        return np.full(3, np.nan)
    f, s = frequency[at - 1 : at + 2], size[at - 1 : at + 2]
    bend, slope, _ = np.polyfit(f - f[1], s, 2)
    away = float(np.clip(-0.5 * slope / bend, f[0] - f[1], f[2] - f[1])) if bend < 0.0 else 0.0
    top = float(s[1] + (slope + bend * away) * away)
    return np.array([f[1] + away, top, half_power(frequency, size, at, f[1] + away, top)])


def half_power(frequency: Array, size: Array, at: int, peak_frequency: float, peak_size: float) -> float:
    """Damping ratio Δf/(2 f) between the points on both sides where a curve has fallen to 1/√2 of its peak, point `at`; NaN where
    it does not fall so far."""
    wanted, ends = peak_size / np.sqrt(2.0), []
    for step in (-1, 1):
        k = at
        while 0 <= k + step < size.size and size[k] > wanted:
            k += step
        if size[k] > wanted:
            return float("nan")
        before = k - step
        share = (size[before] - wanted) / (size[before] - size[k])
        ends.append(float(frequency[before] + share * (frequency[k] - frequency[before])))
    return abs(ends[1] - ends[0]) / (2.0 * peak_frequency)
