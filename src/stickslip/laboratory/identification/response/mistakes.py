"""Mistakes that make a fit poor in a way of their own: a unit, RMS against amplitude, the phase of something else.

The amplitudes alone are fitted with a free gain of each test. That gain, and the measured phases beside those of this fit, show
what is wrong with forces, amplitudes and phases.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from stickslip.laboratory.identification.response.enclosed import EnclosedTest
from stickslip.laboratory.identification.response.fit import GAIN, ResponseFit
from stickslip.laboratory.identification.response.model import FittedTest
from stickslip.laboratory.measurement.measured_response import THOUSAND, MeasuredResponse
from stickslip.support.checks import Array, first_of

POOR = 0.1
"""Misfit of a test from which mistakes are looked for."""

NEAR = 0.06
"""Relative distance of a gain from a factor that is named; the factor of 1000 is taken within `THOUSAND`, since without the right
force friction is wrong as well."""

ALIKE, BETTER = 0.25, 3.0
"""Distance of measured phases from computed ones [rad, root mean square] up to which they are the same, and how many times
farther they must be without the mistake."""

STARTS = 3
"""Starts from which the amplitudes are fitted, at most."""

FROM_ONE = 1.25
"""Factor from which on a gain, or its inverse, that is no known mistake is named: a wrong law may be made up for by less."""

LISTED = 4
"""Tests that a sentence names."""

OR_ALONE = "without /N where the file holds amplitudes beside forces"

GAINS = (
    (np.sqrt(2.0), "as where the force is an RMS value and the response an amplitude. Give amplitudes of both"),
    (np.sqrt(0.5), "as where the response is an RMS value and the force an amplitude. Give amplitudes of both"),
    (2.0, "as where the response is a peak-to-peak value and the force an amplitude. Give amplitudes of both"),
    (0.5, "as where the force is a peak-to-peak value and the response an amplitude. Give amplitudes of both"),
    (
        9.80665,
        "as where an acceleration in m/s2 is given as in g. State the unit of the response, units={'amplitude': '(m/s2)/N'} "
        f"(--unit 'amplitude=(m/s2)/N'), {OR_ALONE}",
    ),
    (
        1.0 / 9.80665,
        "as where an acceleration in g is given as in m/s2. State the unit of the response, units={'amplitude': 'g/N'} "
        f"(--unit amplitude=g/N), {OR_ALONE}",
    ),
)
LARGE = (
    "as where the force is in kN but taken for N, or the response in mm or mm/s2 but taken for m or m/s2. State the unit of the "
    "force, such as units={'force': 'kN'} (--unit force=kN), or that of the response, such as units={'amplitude': '(mm/s2)/N'} "
    f"(--unit 'amplitude=(mm/s2)/N'), {OR_ALONE}"
)
SMALL = (
    "as where the force is in N but taken for kN, or in mN but taken for N. State the unit of the force, such as "
    "units={'force': 'N'} (--unit force=N), or that of the response, such as units={'amplitude': '(m/s2)/N'} "
    f"(--unit 'amplitude=(m/s2)/N'), {OR_ALONE}"
)

CALIBRATION = "check the calibration and the mass of the model, or free the gain, free_gain=True (--free-gain)"

SWAPPED = (
    "the columns of force and response seem to be swapped: so exchanged, the model fits. Say which they are, "
    "columns={'force': ..., 'amplitude': ...} (--column force=... --column amplitude=...)."
)

Phases = Callable[[Array], Array]
PHASES: tuple[tuple[Phases, str], ...] = (
    (
        lambda phase: -phase,
        "have the opposite sign: the displacement leads the force, as where motions go by exp(-iωt). Turn the sign, or title the "
        "column phase lag",
    ),
    (
        lambda phase: phase + np.pi,
        "are 180° from those of the displacement: they are the acceleration's, phase_of='quantity' (--phase-of quantity), or a "
        "sensor or the force points the other way than in the model, where a direction of -1.0 turns an output or a force",
    ),
    (
        lambda phase: np.pi - phase,
        "are those of the acceleration with the opposite sign. Turn the sign and say phase_of='quantity' (--phase-of quantity)",
    ),
    (lambda phase: phase + 0.5 * np.pi, "are 90° ahead of those of the displacement, as a velocity's are. Take off 90°"),
    (lambda phase: phase - 0.5 * np.pi, "are 90° behind those of the displacement, as against a cosine for a sine. Add 90°"),
    (lambda phase: 0.5 * np.pi - phase, "are those of swapped real and imaginary parts. Swap them"),
    (lambda phase: -0.5 * np.pi - phase, "are those of swapped real and imaginary parts. Swap them"),
    (
        lambda phase: phase * np.pi / 180.0,
        "seem to be radians that are given as degrees. State the unit, units={'phase': 'rad'} (--unit phase=rad)",
    ),
    (
        lambda phase: phase * 180.0 / np.pi,
        "seem to be degrees that are given as radians. State the unit, units={'phase': 'deg'} (--unit phase=deg)",
    ),
)
"""What the measured phase would be [rad] with a mistake, from the right one; and the mistake."""


def amplitudes_alone(fit: ResponseFit, search: tuple[int, int, int]) -> dict[str, Array]:
    """What the amplitudes alone show: plain_gain and plain_misfit (tests,), the latter relative to the largest response;
    plain_phase of all points in turn; swapped_misfit (tests,), with force and response swapped where they are missed as well.

    Contacts are virgin. search: tries, seed and evaluations.
    """
    gains, misfits, phases = _fitted(ResponseFit([_amplitudes(one) for one in fit.tests], fit.free), search)
    swapped = np.full(len(fit.tests), np.inf)
    if np.any(misfits > POOR) and not any(named_gain(float(gain))[1] for gain in gains):
        swapped = _fitted(ResponseFit([_amplitudes(one, swap=True) for one in fit.tests], fit.free), search)[1]
    return {"plain_gain": gains, "plain_misfit": misfits, "plain_phase": phases, "swapped_misfit": swapped}


def _fitted(plain: ResponseFit, search: tuple[int, int, int]) -> tuple[Array, Array, Array]:
    """Gains and misfits of the tests of a fit, and the phases of all points in turn."""
    x = plain.best(*search, STARTS, lambda start: _with_gains(plain, start))
    plain.residuals(x)
    count = range(len(plain.tests))
    gains = np.array([abs(plain.chain(x, t)) for t in count])
    return (
        gains,
        np.array([plain.misfit(x, t) for t in count]),
        np.concatenate([np.angle(plain.computed[t].per_force) for t in count]),
    )


def _with_gains(plain: ResponseFit, start: Array) -> Array:
    """A start with the gains that make the computed peaks as large as the measured ones."""
    plain.residuals(start)
    found = start.copy()
    for t, model in enumerate(plain.tests):
        largest = float(np.max(np.abs(plain.computed[t].per_force)))
        if largest > 0.0:
            found[plain.places[t][GAIN]] = np.log(np.max(np.abs(model.test.per_force)) / largest)
    return found


def _amplitudes(one: FittedTest | EnclosedTest, swap: bool = False) -> FittedTest:
    """The amplitudes of a test with a free gain, before their first evaluation; swap: its force and response exchanged."""
    model = one.model if isinstance(one, EnclosedTest) else one
    test = replace(model.test, phase=None, free_phase=False, free_gain=True, of_largest=False)
    test = replace(test, amplitude=test.force, force=test.amplitude) if swap else test
    return FittedTest.of(test, model.problem_of, model.harmonics, model.samples)


def notes_on_mistakes(tests: Sequence[MeasuredResponse], misfits: Array, solution: Any) -> list[str]:
    """A sentence for each mistake that explains why tests of a poor fit are missed."""
    ends = np.cumsum([np.size(test.frequency) for test in tests])[:-1]
    phases = np.split(np.asarray(solution["plain_phase"]), ends)
    said: dict[str, list[tuple[str, float]]] = {}
    # Columns of one layout are swapped in all files: one curve of several that fits so by chance is no such mistake.
    missed, exchanged = np.asarray(solution["plain_misfit"]), np.asarray(solution["swapped_misfit"])
    swapped = exchanged < np.minimum(POOR, 0.5 * missed)
    swapped &= np.all(swapped[missed > POOR])
    for t, test in enumerate(tests):
        gain, left = float(solution["plain_gain"][t]), float(missed[t])
        if swapped[t]:
            said.setdefault(SWAPPED, []).append((test.name, gain))
            continue
        words, sure = named_gain(gain)
        if words and (sure or left < min(POOR, 0.5 * misfits[t])):
            said.setdefault(words, []).append((test.name, gain))
        unknown = not words and not test.free_gain and max(gain, 1.0 / gain) > FROM_ONE
        if unknown and left < min(POOR, 0.5 * misfits[t]):
            said.setdefault(CALIBRATION, []).append((test.name, gain))
        if left < POOR and (words := _named_phase(test, phases[t])):
            said.setdefault(f"Phases {words}", []).append((test.name, gain))
    return [_sentence(words, found) for words, found in said.items()]


def _sentence(words: str, found: Sequence[tuple[str, float]]) -> str:
    """What is wrong with which tests."""
    names, gains = first_of([name for name, _ in found], LISTED), [gain for _, gain in found]
    if words == SWAPPED:
        return f"{names}: {SWAPPED}"
    if words.startswith("Phases "):
        return f"{names}: the measured phases {words.removeprefix('Phases ')}."
    size = " to ".join(dict.fromkeys(f"{gain:.3g}" for gain in (min(gains), max(gains))))
    if words == CALIBRATION:
        return f"{names}: the amplitudes fit with a gain of {size}: {CALIBRATION}."
    return f"{names}: the measured responses per force are {size} times those of the model that fits else, {words}."


def named_gain(gain: float) -> tuple[str, bool]:
    """The mistake that a gain shows, empty for none; and whether it shows it in a poor fit too."""
    low, high = THOUSAND
    if low <= gain <= high or low <= 1.0 / gain <= high:
        return (LARGE if gain > 1.0 else SMALL), True
    near = min(GAINS, key=lambda one: abs(np.log(gain / one[0])))
    return (near[1] if abs(gain / near[0] - 1.0) < NEAR else ""), False


def _named_phase(test: MeasuredResponse, computed: Array) -> str:
    """The mistake that measured phases show beside computed ones of the right amplitudes, empty for none."""
    if test.phase is None:
        return ""
    measured = np.asarray(test.phase)
    apart = [_apart(measured - of(computed)) for of, _ in PHASES]
    best = int(np.argmin(apart))
    return PHASES[best][1] if apart[best] < min(ALIKE, _apart(measured - computed) / BETTER) else ""


def _apart(difference: Array) -> float:
    """Root mean square of angles, each between −π and π [rad]."""
    return float(np.sqrt(np.mean(np.angle(np.exp(1j * difference)) ** 2)))
