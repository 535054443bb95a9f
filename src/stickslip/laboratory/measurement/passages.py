"""Where the cycles of a record begin and end: reversals of the displacement, and its passages through the middle between them."""

from __future__ import annotations

from itertools import pairwise

import numpy as np

from stickslip.laboratory.measurement.contact_record import ContactRecord
from stickslip.support.checks import Array, counted, fault

TURN = 0.2
"""Part of the displacement's range by which it must turn back for a reversal: smaller motions are noise, or are dropped."""

CLOSED = 0.1
"""Largest distance of the last sample of a single cycle from its first, relative to the range of the displacement."""

FEW_CYCLES = 3
"""Up to so many whole cycles, strokes that the record begins or ends with are used if they pass the middle at all."""

WHOLE_STROKE = 0.9
"""Part of a stroke that the record must begin or end with for its passage to count: a virgin contact may begin there."""

ABOUT, FEWEST_ON_LINE = 0.2, 4
"""Part of a stroke on either side of its middle through which a line gives the passage, and fewest samples of it."""


QUIET = 8.0
"""Standard deviations of noise that a reversal must exceed: where noise is larger, neighbouring samples are averaged first."""

LONGEST_MEAN = 101
"""Samples that are averaged at most."""


def cycle_ends(record: ContactRecord) -> Array:
    """Where cycles begin and end, (cycles + 1,) in samples: upward passages through the middle between two reversals, or
    downward ones where these give more cycles; a single closed cycle begins with its first sample and ends where that
    would come again."""
    u = _quiet(record.displacement)
    turns = reversals(u, TURN * float(np.ptp(u)))
    for part, fewest in ((WHOLE_STROKE, FEW_CYCLES), (0.0, 1)):
        passages = max((_passages(sign * u, turns, part) for sign in (1.0, -1.0)), key=len)
        if len(passages) > fewest:
            return np.array(passages)
    apart = abs(u[-1] - u[0])
    if 1 <= len(turns) <= 2 and apart <= CLOSED * np.ptp(u):
        same = abs(record.force[-1] - record.force[0]) < 0.01 * np.ptp(record.force)
        repeated = same and apart < 0.1 * np.median(np.abs(np.diff(u)))
        return np.array([0.0, float(u.size - 1 if repeated else u.size)])
    if not turns:
        shown = f"rising or falling throughout, from {u[0]:.4g} m to {u[-1]:.4g} m"
        remedy = "Is it the right column? A cycle needs motion in both directions."
        raise fault(f"Displacement of {record.name}", "must reverse", shown, remedy)
    shown = f"{counted(len(turns), 'reversal')}, ends {apart / np.ptp(u):.0%} of the range apart"
    raise fault(record.name, "must hold at least one whole cycle", shown, "Record more cycles, or cut one out that is closed.")


def _quiet(u: Array) -> Array:
    """A displacement (n,) as mean over so many neighbours that noise alone makes no reversal; unchanged where it is low.

    Third differences show the noise: those of white noise are √20 times as large, those of a finely sampled motion vanish.
    """
    noise = float(np.median(np.abs(np.diff(u, 3)))) / (0.6745 * np.sqrt(20.0))
    width = 1
    mean = u
    while TURN * float(np.ptp(mean)) < QUIET * noise / np.sqrt(width) and width < min(LONGEST_MEAN, u.size // 8):
        width += 2
        mean = np.convolve(np.pad(u, width // 2, mode="edge"), np.full(width, 1.0 / width), mode="valid")
    return mean


def reversals(values: Array, least: float) -> list[int]:
    """Places of the highest and lowest samples between which a signal turns back by at least `least`, in turn.

    The first and the last sample are none, nor is noise near them: a signal must come to a reversal from `least` away.
    """
    found: list[int] = []
    high = low = 0
    rising = 0
    for n in range(values.size):
        if values[n] > values[high]:
            high = n
        if values[n] < values[low]:
            low = n
        if rising >= 0 and values[high] - values[n] >= least:
            if rising or values[high] - values[0] >= least:
                found.append(high)
            rising, low = -1, n
        elif rising <= 0 and values[n] - values[low] >= least:
            if rising or values[0] - values[low] >= least:
                found.append(low)
            rising, high = 1, n
    return found


def _passages(u: Array, turns: list[int], part: float) -> list[float]:
    """Where the displacement passes upwards through the middle between two reversals, in samples.

    part: of a stroke that must lie before the first reversal, or after the last one, for the passage there to count.
    """
    if len(turns) < 2:
        return []
    strokes = [(a, b, 0.5 * (u[a] + u[b]), 0.0) for a, b in pairwise(turns)]
    ends = [(0, turns[0], 0), (turns[-1], u.size - 1, -1)]
    first, last = ((a, b, strokes[k][2], part * abs(u[turns[k]] - u[turns[1 if k == 0 else -2]])) for a, b, k in ends)
    return [
        _passage(u, a, b, middle)
        for a, b, middle, least in (first, *strokes, last)
        if u[a] < middle <= u[b] and u[b] - u[a] >= least
    ]


def _passage(u: Array, start: int, end: int, middle: float) -> float:
    """Where the displacement passes a value upwards between two samples, in samples: by a straight line through the samples about
    it, since noise would shift a single sample."""
    part = u[start : end + 1]
    n = int(np.argmax(part >= middle))
    half = ABOUT * float(part.max() - part.min())
    below, above = np.flatnonzero(part[:n] < middle - half), np.flatnonzero(part[n:] > middle + half)
    first, last = (int(below[-1]) + 1 if below.size else 0), (n + int(above[0]) if above.size else part.size)
    if last - first < FEWEST_ON_LINE:
        return start + n - 1 + float((middle - part[n - 1]) / (part[n] - part[n - 1]))
    places = np.arange(first, last) - n
    slope, value = np.polyfit(places, part[first:last] - middle, 1)
    found = -value / slope if slope > 0.0 else 0.0
    return start + n + float(np.clip(found, places[0], places[-1]))
