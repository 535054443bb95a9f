"""Whether the samples of a period resolve contacts whose force changes within a small share of it."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from stickslip.analyses.truncation import ALLOWED, sampling_error
from stickslip.model.contact.point import Contact
from stickslip.model.problem.contraction import contracts
from stickslip.solve.balance.balance import HarmonicBalance
from stickslip.solve.continuation.curve_points import CurvePoint
from stickslip.solve.curves.curve import Curve
from stickslip.support.checks import Array
from stickslip.support.outcome import Outcome

FEWEST = 1.0
"""Samples that a change of the force must spread over: peaks of one mass are off by 2e-7 at 3, 2.4e-4 at 1.2, 1.4e-3 at 0.6."""

RIPPLE, DEEPEST = 3.0, 0.2
"""Dips between maxima that samples make, as a multiple of what more samples change of their height, and the deepest that are
looked at: of two masses with ζ = 1e-4 and 256 samples, 15 maxima dip by up to 1.7 times that, and 1024 samples leave one."""

ENOUGH = 2.0
"""Samples that the advice makes of it."""


def sampling_warning(balance: HarmonicBalance, curve: Curve) -> str:
    """The contact whose force changes fastest at the highest peaks, or points, if samples are too few for it; else empty."""
    table, count = balance.table, balance.tables.E.shape[0]
    fewest, name = np.inf, ""
    for output in range(len(balance.problem.outputs)):
        points = curve.tops(output)
        if not points:
            continue
        highest = max(points, key=lambda point: float(np.hypot(*point.evaluation.w[balance.rows + output, balance.first])))
        velocity = highest.point.omega * np.hypot(*highest.evaluation.w[: balance.rows, 1:3].T)
        for number, contact in enumerate(balance.problem.contacts):
            own = velocity[table.first_row[number] : table.first_row[number] + len(contact.tangential)]
            spread = count * contact.law.passage(float(own.max(initial=0.0)))
            if spread < fewest:
                fewest, name = spread, contact.name
    if not fewest < FEWEST:
        return ""
    enough = 2 ** int(np.ceil(np.log2(count * ENOUGH / fewest)))
    return (
        f"The friction of {name} changes its sign within {fewest:.2g} of a sample: heights of peaks may be wrong, and peaks of "
        f"ripples appear. Take {enough} samples, or a law that changes more slowly."
    )


def fold_warning(balance: HarmonicBalance, curve: Curve) -> str:
    """What to say of a curve that turns back in frequency although there is one motion at each; else empty."""
    omegas = np.array([point.point.omega for point in curve.points])
    turns = np.flatnonzero(np.diff(np.sign(np.diff(omegas))) != 0.0) + 1
    if not turns.size or not contracts(balance.problem):
        return ""
    samples, hertz = balance.tables.E.shape[0], balance.hertz(float(omegas[turns[0]]))
    return (
        f"The curve turns back in frequency near {hertz:.6g} Hz, but friction under constant loads has one motion at each "
        f"frequency: {samples} samples are too few there. Take {2 * samples}."
    )


def without_ripples(balance: HarmonicBalance, curve: Curve) -> Curve:
    """The curve without the maxima that its samples make: of those between which it dips by less than a few times what more
    samples change of their height, only the highest is a peak. All stay points of the curve.

    Where friction is sampled and damping is light, a curve folds at each sample that an event passes, once on either side.
    """
    places = {id(point): k for k, point in enumerate(curve.points)}
    peaks = []
    for output, found in enumerate(curve.peaks):
        row = balance.rows + output
        sizes = np.array([curve.measure.size(point.evaluation.w[row], point.point.omega) for point in curve.points])
        kept: list[CurvePoint] = []
        for hill in _hills([places[id(peak)] for peak in found], sizes, DEEPEST):
            error = 0.0
            if len(hill) > 1:
                highest = max(hill, key=lambda k: sizes[k])
                error = sampling_error(balance, curve.points[highest], output, curve.measure)
            dip = RIPPLE * error if np.isfinite(error) else 0.0
            kept += [curve.points[max(part, key=lambda k: sizes[k])] for part in _hills(hill, sizes, dip)]
        peaks.append(tuple(kept))
    return replace(curve, peaks=tuple(peaks))


def _hills(places: Sequence[int], sizes: Array, dip: float) -> list[list[int]]:
    """Maxima, by their places along the curve in order, in groups within which it dips by no more than a share of the lower."""
    groups: list[list[int]] = []
    for k in sorted(places):
        if groups and _on_one_hill(sizes[groups[-1][-1] : k + 1], dip):
            groups[-1].append(k)
        else:
            groups.append([k])
    return groups


def _on_one_hill(sizes: Array, dip: float) -> bool:
    """Whether a curve dips by no more than a share between two maxima, its ends. A shoulder of a hill that is much higher is a
    peak of its own: no point between the two is lower, and only the search has seen the dip."""
    low, high = sorted((sizes[0], sizes[-1]))
    shoulder = sizes.min() >= low and low < (1.0 - DEEPEST) * high
    return bool(sizes.min() >= (1.0 - dip) * low and not shoulder)


def broken_warning(contacts: Sequence[Contact], samples: int, curve: Curve, open_share: Array) -> str:
    """The advice for a curve that broke off where contacts with friction, which is sampled, open and close; open_share (point,
    ...): of the period, at each."""
    if not any(contact.law.rubs for contact in contacts):
        return ""
    solved = open_share[np.isfinite(open_share).any(axis=tuple(range(1, open_share.ndim)))]
    if curve.outcome == Outcome.CONVERGED or not np.any((solved[-1:] > 0.0) & (solved[-1:] < 1.0)):
        return ""
    return (
        f"Contacts open and close where it ended: where damping is light, {samples} samples may be too few for them. Try "
        f"{4 * samples}."
    )


def samples_warning(samples: int, outputs: tuple[str, ...], errors: Array) -> str:
    """What to say where the change by more samples is not small; empty where it is."""
    if not np.any(errors > ALLOWED):
        return ""
    worst = int(np.nanargmax(errors))
    enough = 2 ** int(np.ceil(np.log2(samples * np.sqrt(errors[worst] / ALLOWED)))) if errors[worst] < 1.0 else 8 * samples
    return (
        f"More than {samples} samples would change {outputs[worst]} at its highest peak by about "
        f"{100.0 * errors[worst]:.1f} %: take {max(enough, 2 * samples)}."
    )
