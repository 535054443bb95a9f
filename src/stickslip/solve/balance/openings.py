"""Where in its period a contact is open, from the Fourier series of its normal motion, and the Fourier integrals over it.

A normal force max(0, k z + c) of a series z(θ) differs from that of a spring only while the contact is open, and both ends of an
opening are roots of k z + c. Integrals of cos mθ and sin mθ between them are known in closed form, so that the harmonics of the
force and their derivative are exact for this motion, whatever the number of samples, and the force does no net work.
Sampled, a force that bends between two samples is wrong by their distance squared, and the work of this error, which may have
either sign, outweighs light damping.
"""

from __future__ import annotations

import numpy as np

from stickslip.solve.balance.trigonometric import series
from stickslip.support.checks import Array
from stickslip.support.kernels import inlined, inner

ROOT = 1e-11
"""Accuracy of the ends of an opening [rad]."""

STEPS = 80
"""Most steps to a root; Newton's method takes three, halving the interval in the worst case forty."""

SHARE = 0.25
"""Between two samples a smooth motion goes beyond the lower one by an eighth of its second difference; up to twice that is looked
at."""


@inlined
def add_openings(motion: Array, z: Array, level: float, sums: Array) -> bool:
    """Add the integrals of cos mθ and sin mθ over the part of the period where z < level; whether there is one.

    motion (2H+1,): the harmonics of z; z (Nt,): its samples, between which its passages through the level are bracketed; sums
    (2, M): as `stickslip.solve.balance.fourier.add_run` fills them, Nt/2π times the integrals for m = 0..M−1.
    """
    samples = z.size
    step = 2.0 * np.pi / samples
    scale = 1.0 / step
    found = False
    if z[0] < level:
        sums[0, 0] += samples
        found = True
    for n in range(samples):
        following = z[n + 1 if n + 1 < samples else 0]
        here, there = z[n] < level, following < level
        if here != there:
            root = _passage(motion, level, n * step, (n + 1) * step, here)
            _add_end(sums, root, scale if here else -scale)
            found = True
        elif _turns(z[n - 1], z[n], following, level):
            turn = _turn(motion, n * step, step)
            if (series(motion, turn)[0] < level) != here:
                first = _passage(motion, level, (n - 1) * step, turn, here)
                last = _passage(motion, level, turn, (n + 1) * step, not here)
                _add_end(sums, first, scale if here else -scale)
                _add_end(sums, last, -scale if here else scale)
                found = True
    return found


@inner
def _turns(before: float, here: float, after: float, level: float) -> bool:
    """Whether a motion may reach a level between this sample, its nearest, and one of the two beside it, on the same side."""
    distance, first, last = here - level, before - level, after - level
    if distance < 0.0:
        distance, first, last = -distance, -first, -last
    return distance < first and distance <= last and distance < SHARE * (first - 2.0 * distance + last)


@inlined
def _turn(motion: Array, angle: float, step: float) -> float:
    """The angle at which a motion is extreme, within a step of a sample."""
    found = angle
    for _ in range(8):
        _, slope, bend = series(motion, found)
        if bend == 0.0:
            break
        found = min(max(found - slope / bend, angle - step), angle + step)
    return found


@inner
def _passage(motion: Array, level: float, low: float, high: float, below: bool) -> float:
    """The angle between low and high at which a motion passes a level, which it is below at low, or above.

    Newton's method from the middle, halving the interval where it leaves it.
    """
    root = 0.5 * (low + high)
    for _ in range(STEPS):
        value, slope, _ = series(motion, root)
        if (value < level) == below:
            low = root
        else:
            high = root
        step = (level - value) / slope if slope != 0.0 else np.inf
        if not low <= root + step <= high:
            step = 0.5 * (low + high) - root
        root += step
        if abs(step) <= ROOT:
            break
    return root


@inner
def _add_end(sums: Array, angle: float, scale: float) -> None:
    """Add scale times the primitives of cos mθ and sin mθ at an angle."""
    sums[0, 0] += scale * angle
    for m in range(1, sums.shape[1]):
        sums[0, m] += scale * np.sin(m * angle) / m
        sums[1, m] -= scale * np.cos(m * angle) / m
