"""The band around a peak in which the amplitude stays within a share of it: how well the frequency of a peak is known.

The curvature at the summit does not tell: samples make facets of a flat top, and a summit stands on the corner of two. The ends
of the band are solved, beyond the facets.
"""

from __future__ import annotations

from contextlib import suppress
from dataclasses import dataclass
from math import sqrt

import numpy as np

from stickslip.solve.summit import Ascent, NoSummitError, Summit

SHARE = 1e-3
"""Share of the peak by which the amplitude falls to the ends of the band."""

CLOSE = 1.4
"""An end is foretold from a place that has fallen by between 1/1.4 and 1.4 times the share."""

ROUNDS, LEAP = 4, 5e-3
"""How often a higher corner of the same top is looked for, and how much higher one may be."""

FLAT = 1e-4
"""Half-way to its ends a smooth top has fallen by a quarter of `SHARE`; where by less than this, there may be a higher corner."""

SOLVES = 8
WIDEN = 2.5
FARTHEST = 0.3
"""Arc length beyond which the middle of a band is not sought for a summit."""


@dataclass(frozen=True)
class Crest:
    """The band in rad/s in which the amplitude of a peak stays within `SHARE` of it."""

    low: float
    high: float

    @property
    def omega(self) -> float:
        """The middle of the band, rad/s: the frequency of the peak without the corners that samples make."""
        return 0.5 * (self.low + self.high)

    @property
    def width(self) -> float:
        """Half the band, rad/s."""
        return 0.5 * (self.high - self.low)


def settled(ascent: Ascent, summit: Summit) -> tuple[Summit, Crest]:
    """The highest summit that is climbed to from inside the band, as corners of samples are, and the band around it."""
    crest = crest_of(ascent, summit)
    for _ in range(ROUNDS):
        other = _higher(ascent, summit, crest)
        if other is None:
            break
        gained = other.amplitude / summit.amplitude - 1.0
        summit = other
        if gained < 0.1 * SHARE:
            break
        crest = crest_of(ascent, summit)
    return summit, crest


def _higher(ascent: Ascent, summit: Summit, crest: Crest) -> Summit | None:
    """A higher summit from the middle of the band, or from where the band is flatter than a parabola would be, if any."""
    for share in (0.0, -0.5, 0.5):
        away = crest.omega + share * crest.width - summit.omega
        s = away / summit.plane.omega if summit.plane.omega else 0.0
        evaluation = ascent.beside(summit, float(np.clip(s, -FARTHEST, FARTHEST)))
        if evaluation is None or (share and ascent.amplitude(evaluation) < (1.0 - FLAT) * summit.amplitude):
            continue
        with suppress(NoSummitError):
            other = ascent.from_solved(evaluation)
            if 0.0 < other.amplitude / summit.amplitude - 1.0 <= LEAP:
                return other
    return None


def crest_of(ascent: Ascent, summit: Summit) -> Crest:
    """The band around a summit, about two solutions for each end."""
    ends = [summit.omega, *(_end(ascent, summit, side) for side in (-1.0, 1.0))]
    return Crest(min(ends), max(ends))


def _end(ascent: Ascent, summit: Summit, side: float) -> float:
    """The frequency at which the amplitude has fallen by the share; where Newton's method fails before, the last one solved."""
    inner, outer, s, omega = 0.0, 0.0, summit.reach, summit.omega
    for _ in range(SOLVES):
        evaluation = ascent.beside(summit, side * s)
        if evaluation is None:
            outer, s = s, 0.5 * (inner + s)
            continue
        here = evaluation.point.omega
        fallen = max(1.0 - ascent.amplitude(evaluation) / summit.amplitude, 1e-12)
        stretch = sqrt(SHARE / fallen)
        if 1.0 / CLOSE <= fallen / SHARE <= CLOSE:
            return summit.omega + stretch * (here - summit.omega)
        if fallen < SHARE:
            inner, omega = s, here
        else:
            outer = s
        s *= min(max(stretch, 1.0 / WIDEN), WIDEN)
        if outer and not inner < s < outer:
            s = 0.5 * (inner + outer)
    return omega
