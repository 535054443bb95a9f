"""Mistakes that make a fit poor in a way of their own: a unit, RMS against amplitude, the phase of something else.

The amplitudes alone are fitted with a free gain of each test. That gain, and the measured phases beside those of this fit, show
what is wrong with forces, amplitudes and phases.

Outliers: points of measured responses far from the fit, such as those of a clipped sensor; and the fit without them.

One of them moves parameters by more than intervals hold, since these take the residuals for noise.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from stickslip.laboratory.identification.response.fit import GAIN, FittedTest, ResponseFit
from stickslip.laboratory.identification.response.intervals import statistics
from stickslip.laboratory.measurement.measured_response import THOUSAND, MeasuredResponse
from stickslip.support.checks import Array, counted, first_of, rounded

POOR = 0.1
"""Misfit of a test from which mistakes are looked for, and from which without its outliers the model is at fault."""

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

OR_ALONE = "without /N if the file contains amplitudes and forces"

GAINS = (
    (np.sqrt(2.0), "as if the force were an RMS value and the response an amplitude. Give amplitudes of both"),
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
    "the columns of force and response seem to be exchanged: the model fits if they are swapped. State them, "
    "columns={'force': ..., 'amplitude': ...} (--column force=... --column amplitude=...)."
)

Phases = Callable[[Array], Array]
PHASES: tuple[tuple[Phases, str], ...] = (
    (
        lambda phase: -phase,
        "have the opposite sign: the displacement leads the force, as with exp(-iωt). Change the sign, or title the column "
        "phase lag",
    ),
    (
        lambda phase: phase + np.pi,
        "are 180° from those of the displacement: they belong to the acceleration, phase_of='quantity' (--phase-of quantity), "
        "or a sensor or the force has the opposite direction, which -1.0 in an output or a force of the model corrects",
    ),
    (
        lambda phase: np.pi - phase,
        "are those of the acceleration with opposite sign. Change the sign and give phase_of='quantity' (--phase-of quantity)",
    ),
    (lambda phase: phase + 0.5 * np.pi, "are 90° ahead of those of the displacement, as for a velocity. Subtract 90°"),
    (lambda phase: phase - 0.5 * np.pi, "are 90° behind those of the displacement, as a cosine relative to a sine. Add 90°"),
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


def _amplitudes(model: FittedTest, swap: bool = False) -> FittedTest:
    """The amplitudes of a test with a free gain, before their first evaluation; swap: its force and response exchanged."""
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
    names, gains = first_of([name for name, _ in found]), [gain for _, gain in found]
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


OUTLIER = 5.0
"""Standard errors from which a point is an outlier: noise exceeds them once in two million."""

NORMAL = 0.6745
"""Median of the size of noise of standard deviation 1."""

KNOWN, FLAT = 1e-8, 1e-6
"""Share of the largest singular value below which a direction is unknown; least variance of a residual, relative."""

MOST = 0.1
"""Share of the points that may be outliers, one in any case: of more the model is at fault."""

SURE = 2.0
"""Residuals in stated errors, root mean square, from which the model is at fault where they go together along the curves."""

ROUNDS = 5
"""Fits without outliers, at most: each may show others."""

LISTED_POINTS = 3
"""Points that a sentence names."""

Marks = NDArray[np.bool_]


@dataclass(frozen=True, eq=False)
class Outliers:
    """Of all points in turn: errors: residuals of outliers in standard errors, 0 of the other points; deviation: relative to the
    computed response per force, below 0 where the measured one is smaller; x: the variables without the outliers."""

    errors: Array
    deviation: Array
    x: Array


def fitted_without(fit: ResponseFit, x: Array, evaluations: int) -> Outliers:
    """The outliers of a fit, which are those of the fit without them."""
    marks = [np.zeros(np.size(model.test.frequency), dtype=bool) for model in fit.tests]
    whole, errors = x, _errors(fit, x, marks)
    for _ in range(ROUNDS):
        before, marks = marks, [one > OUTLIER for one in errors]
        if sum(map(np.count_nonzero, marks)) > max(MOST * sum(one.size for one in marks), 1.0):
            marks = [np.zeros_like(one) for one in marks]
        if all(map(np.array_equal, marks, before)):
            break
        x = fit.without(marks).solved(x, evaluations=evaluations).x
        errors = _errors(fit, x, marks)
    found = np.concatenate(marks) & (np.concatenate(errors) > OUTLIER)
    found &= not np.any(found) or _good(fit, x, marks)
    x = x if np.any(found) else whole
    # Distance of the measured from the computed response per force, relative to the latter, below 0 where it is smaller.
    fit.residuals(x)
    deviations = []
    for t, model in enumerate(fit.tests):
        measured, shown = model.test.per_force, fit.shown(x, t)
        size = np.maximum(np.abs(shown), 1e-300)
        away = np.abs(measured - (shown if model.test.phase is not None else size)) / size
        deviations.append(np.where(np.abs(measured) < size, -away, away))
    return Outliers(np.where(found, np.concatenate(errors), 0.0), np.where(found, np.concatenate(deviations), 0.0), x)


def _good(fit: ResponseFit, x: Array, marks: Sequence[Marks]) -> bool:
    """Whether the fit explains the points that are not marked; what a bound or a wrong law misses is no outlier."""
    parts = zip(fit.parted(fit.residuals(x)), marks, strict=True)
    sizes = np.array([float(np.sqrt(np.mean(residuals[:, ~mark] ** 2))) if np.any(~mark) else 0.0 for residuals, mark in parts])
    errors = sizes * np.array([model.test.error for model in fit.tests])
    if float(errors.max()) > POOR:
        return False
    return float(np.median(sizes)) < SURE or statistics(fit.without(marks), x).one_in == 1.0


def _errors(fit: ResponseFit, x: Array, marks: Sequence[Marks]) -> list[Array]:
    """By how many standard errors the points of each test miss the fit to the others: by the stated errors, or those of the usual
    residuals of the test or of all where these are larger. 0 of points without a solution. Marked points are those that the fit
    at x does not know.

    With the covariance H of its computed rows, the residual r of a point has the covariance 1 − H in the fit, and 1 + H where the
    fit does not know it. Usual residuals are those by their median, which few outliers do not move, or those that are left
    without the point, r (1 − H)⁻¹ r less, if these are smaller: one alone at a resonance bends the fit to itself.
    """
    residuals, J = fit.residuals(x), fit.jacobian(x)
    priors = np.ones(sum(variable.deviation is not None for variable in fit.variables), dtype=bool)
    kept = np.concatenate([*(np.tile(~mark, rows) for mark, rows in zip(marks, fit.rows, strict=True)), priors])
    J = J / np.maximum(np.linalg.norm(J, axis=0), 1e-300)
    _, values, directions = np.linalg.svd(J[kept], full_matrices=False)
    known = values > KNOWN * np.max(values, initial=1e-300)
    ways = J @ directions[known].T / values[known]
    blind = np.sum(J**2, axis=1) - np.sum((J @ directions[known].T) ** 2, axis=1) > KNOWN
    count, lost = int(np.count_nonzero(kept)), int(np.count_nonzero(known))
    square, usual = float(np.sum(residuals[kept] ** 2)), _usual(residuals[: residuals.size - priors.size])
    found = []
    by_test = (fit.parted(residuals), fit.parted(ways), fit.parted(blind), fit.computed, marks)
    for parts, way, lost_ones, computed, mark in zip(*by_test, strict=True):
        miss = _misses(parts, np.moveaxis(way, 0, 1), mark)
        gone, share = np.where(mark, 0.0, miss), parts[:, ~mark].size / max(count, 1)
        left = [
            np.sqrt(np.maximum(whole - gone, 0.0) / max(freedom - len(parts), 1.0))
            for whole, freedom in ((square, count - lost), (float(np.sum(parts[:, ~mark] ** 2)), share * (count - lost)))
        ]
        scale = np.maximum(1.0, np.maximum(np.minimum(usual, left[0]), np.minimum(_usual(parts), left[1])))
        unknown = mark & np.any(lost_ones, axis=0)
        found.append(np.where(computed.solved & ~unknown, np.sqrt(miss) / scale, 0.0))
    return found


def _misses(parts: Array, ways: Array, mark: Marks) -> Array:
    """r (1 ∓ H)⁻¹ r of each point (points,), from its residuals (rows, points): what the sum of squares loses with it."""
    signs = np.where(mark, 1.0, -1.0)[:, None, None]
    values, directions = np.linalg.eigh(np.eye(len(parts)) + signs * ways @ np.moveaxis(ways, 1, 2))
    along = np.einsum("pki,kp->pi", directions, parts)
    return np.asarray(np.sum(along**2 / np.maximum(values, FLAT), axis=1))


def _usual(residuals: Array) -> float:
    """Standard deviation of residuals by their median size, which a few outliers do not move."""
    return float(np.median(np.abs(residuals))) / NORMAL


def notes_on_outliers(tests: Sequence[MeasuredResponse], errors: Sequence[Array], deviations: Sequence[Array]) -> list[str]:
    """The outliers of each test."""
    found = []
    for test, error, share in zip(tests, errors, deviations, strict=True):
        at = np.argsort(-error, kind="stable")[: np.count_nonzero(error)]
        if not at.size:
            continue
        places = [
            f"{np.asarray(test.frequency)[k]:.5g} Hz by {rounded(100.0 * abs(share[k]), 2)} %, {error[k]:.0f} standard errors"
            for k in at
        ]
        listed = "; ".join(places[:LISTED_POINTS]) + (f"; and {at.size - LISTED_POINTS} more" if at.size > LISTED_POINTS else "")
        why = "Is the sensor clipped there?" if np.all(share[at] < 0.0) else "Are these rows right?"
        verb = "misses" if at.size == 1 else "miss"
        found.append(f"{counted(at.size, 'point')} of {test.name} {verb} the fit to the others: at {listed}. {why}")
    return found


def moved(names: Sequence[str], values: Array, ends: tuple[Array, Array], without: Array) -> str:
    """How far the parameters move without the outliers; ends: of their 95 % intervals."""
    words = []
    for name, value, low, high, other in zip(names, values, *ends, without, strict=True):
        change = f"{100.0 * (other - value) / abs(value):+.2g} %" if value else f"{other - value:+.2g}"
        words.append(f"{name} {other:.5g} ({change}{'' if low <= other <= high else ', outside the interval'})")
    return f"Without such points: {', '.join(words)}. Leave these points out if they are wrong."
