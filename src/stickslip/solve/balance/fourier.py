"""Fourier synthesis and analysis on Nt samples t_n = 2πn/(Nt ω), in real storage a0, a1, b1, a2, b2, ...

Running sums of cos(mθ_n) and sin(mθ_n) let a Jacobian gather a whole run of slipping samples as one difference.

Exact extremes in time of a truncated Fourier series.

Where in its period a contact is open, from the Fourier series of its normal motion, and the Fourier integrals over it.

A normal force max(0, k z + c) of a series z(θ) differs from that of a spring only while the contact is open, and both ends of an
opening are roots of k z + c. Integrals of cos mθ and sin mθ between them are known in closed form, so that the harmonics of the
force and their derivative are exact for this motion, whatever the number of samples, and the force does no net work.
Sampled, a force that bends between two samples is wrong by their distance squared, and the work of this error, which may have
either sign, outweighs light damping.
"""

from __future__ import annotations

from functools import lru_cache
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from stickslip.support.checks import Array, fault
from stickslip.support.kernels import boxed, inlined, inner, kernel


class Fourier(NamedTuple):
    """E, D (Nt, 2H+1): x = E X, dx/dt = ω D X. P (2H+1, Nt): X = P x. cosines, sines (2H+1, Nt+1): Σ_{k<n} cos mθ_k, sin mθ_k
    for m = 0..2H."""

    E: Array
    D: Array
    P: Array
    cosines: Array
    sines: Array


@lru_cache(maxsize=64)
def fourier(harmonics: int, samples: int) -> Fourier:
    """Tables for harmonics 0..H and Nt samples."""
    if harmonics < 1:
        raise fault("harmonics", "must be at least 1", harmonics)
    if samples < 4 * harmonics + 2:
        raise fault("samples", f"must be at least 4 H + 2 = {4 * harmonics + 2}", samples, "Use more samples.")
    # Angles through exact multiples of 1/Nt, so that symmetric samples give symmetric values.
    turns = (np.arange(2 * harmonics + 1)[:, None] * np.arange(samples)[None, :]) % samples
    angles = 2.0 * np.pi * np.arange(samples) / samples
    cosine, sine = np.cos(angles)[turns], np.sin(angles)[turns]
    E = np.empty((samples, 2 * harmonics + 1))
    E[:, 0] = 1.0
    E[:, 1::2] = cosine[1 : harmonics + 1].T
    E[:, 2::2] = sine[1 : harmonics + 1].T
    D, order = np.zeros_like(E), np.arange(1.0, harmonics + 1)
    D[:, 1::2], D[:, 2::2] = -order * E[:, 2::2], order * E[:, 1::2]
    P = (2.0 / samples) * E.T.copy()
    P[0] = 1.0 / samples
    cosines, sines = np.zeros((2, 2 * harmonics + 1, samples + 1))
    np.cumsum(cosine, axis=1, out=cosines[:, 1:])
    np.cumsum(sine, axis=1, out=sines[:, 1:])
    return Fourier(E, D, P, cosines, sines)


@kernel
def add_run(sums: Array, weight: float, first: int, last: int, cosines: Array, sines: Array) -> None:
    """sums[0] += weight Σ cos mθ_n, sums[1] += weight Σ sin mθ_n over samples first..last−1."""
    for m in range(sums.shape[1]):
        sums[0, m] += weight * (cosines[m, last] - cosines[m, first])
        sums[1, m] += weight * (sines[m, last] - sines[m, first])


@kernel
def add_product_sums(matrix: Array, sums: Array, samples: int) -> None:
    """matrix += Σ_n g_n P_n E_nᵀ from the sums of g_n cos mθ_n and g_n sin mθ_n: a Toeplitz and a Hankel part."""
    harmonics = (matrix.shape[0] - 1) // 2
    c, s = sums[0], sums[1]
    matrix[0, 0] += c[0] / samples
    for i in range(1, harmonics + 1):
        matrix[0, 2 * i - 1] += c[i] / samples
        matrix[0, 2 * i] += s[i] / samples
        matrix[2 * i - 1, 0] += 2.0 * c[i] / samples
        matrix[2 * i, 0] += 2.0 * s[i] / samples
        for j in range(1, harmonics + 1):
            difference, total = abs(i - j), i + j
            sine = s[difference] if i >= j else -s[difference]
            matrix[2 * i - 1, 2 * j - 1] += (c[difference] + c[total]) / samples
            matrix[2 * i - 1, 2 * j] += (s[total] - sine) / samples
            matrix[2 * i, 2 * j - 1] += (s[total] + sine) / samples
            matrix[2 * i, 2 * j] += (c[difference] - c[total]) / samples


def complex_harmonics(real: Array) -> np.ndarray:
    """X_h = a_h − i b_h, (..., H+1) complex, from real storage (..., 2H+1); X_0 = a0."""
    zero = np.zeros((*real.shape[:-1], 1))
    a = np.concatenate([real[..., :1], real[..., 1::2]], axis=-1)
    b = np.concatenate([zero, real[..., 2::2]], axis=-1)
    return np.asarray(a - 1j * b)


def real_harmonics(values: NDArray[np.complex128]) -> Array:
    """Real storage (..., 2H+1) of X_h (..., H+1): a_h = Re X_h, b_h = −Im X_h."""
    real = np.empty((*values.shape[:-1], 2 * values.shape[-1] - 1))
    real[..., 0] = values[..., 0].real
    real[..., 1::2] = values[..., 1:].real
    real[..., 2::2] = -values[..., 1:].imag
    return real


CANDIDATES = 4
"""How many of the best samples are refined."""


@inner
def series(motion: Array, angle: float) -> tuple[float, float, float]:
    """x, x' and x'' by angle, for real storage (2H+1,)."""
    value, first, second = motion[0], 0.0, 0.0
    one, other, cosine, sine = np.cos(angle), np.sin(angle), 1.0, 0.0
    for h in range(1, (motion.size + 1) // 2):
        cosine, sine = cosine * one - sine * other, sine * one + cosine * other
        a, b = motion[2 * h - 1], motion[2 * h]
        value += a * cosine + b * sine
        first += h * (b * cosine - a * sine)
        second -= h * h * (a * cosine + b * sine)
    return value, first, second


@kernel
def largest_absolute(motion: Array) -> tuple[float, Array]:
    """max over time of |x(t)| for real storage (2H+1,), and its gradient by the storage.

    The best samples of a fine grid, refined by Newton's method on x'.
    """
    size = 8 * motion.size
    step = 2.0 * np.pi / size
    values = np.empty(size)
    for n in range(size):
        values[n] = -abs(series(motion, n * step)[0])
    largest, place = -1.0, 0.0
    for n in np.argsort(values)[:CANDIDATES]:
        angle = n * step
        for _ in range(6):
            _, first, second = series(motion, angle)
            if second != 0.0:
                angle = min(max(angle - first / second, (n - 1) * step), (n + 1) * step)
        for candidate in (n * step, angle):
            value = abs(series(motion, candidate)[0])
            if value > largest:
                largest, place = value, candidate
    gradient = np.empty(motion.size)
    gradient[0] = 1.0
    for h in range(1, (motion.size + 1) // 2):
        gradient[2 * h - 1], gradient[2 * h] = np.cos(h * place), np.sin(h * place)
    if series(motion, place)[0] < 0.0:
        gradient = -gradient
    return boxed((largest, gradient))


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
