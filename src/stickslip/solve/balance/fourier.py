"""Fourier synthesis and analysis on Nt samples t_n = 2πn/(Nt ω), in real storage a0, a1, b1, a2, b2, ...

The harmonics of a balance are 0..H by the number H, or a list such as 0, 1, 3, 5. Storage is always that of 0..H, H the highest,
so that row h of an array is harmonic h whatever the list; motion and forces of a harmonic that the list leaves out are zero, and
no unknowns of Newton's method.

Running sums of cos(mθ_n) and sin(mθ_n) let a Jacobian gather a whole run of slipping samples as one difference.

Exact extremes in time of a truncated Fourier series.

Where in its period a contact is open, from the Fourier series of its normal motion, and the Fourier integrals over it.

A normal force max(0, k z + c) of a series z(θ) differs from that of a spring only while the contact is open, and both ends of an
opening are roots of k z + c. Integrals of cos mθ and sin mθ between them are known in closed form, so that the harmonics of the
force and their derivative are exact for this motion, whatever the number of samples, and the force does no net work.
Sampled, a force that bends between two samples is wrong by their distance squared, and the work of this error, which may have
either sign, outweighs light damping.
"""

from collections.abc import Iterable, Sequence, Set
from functools import lru_cache
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from stickslip.model.contact.point import TractionRatio
from stickslip.model.problem import Problem
from stickslip.support.checks import Array, Index, between, counted, fault, whole
from stickslip.support.kernels import boxed, inlined, inner, kernel

Harmonics = int | tuple[int, ...]
"""H for 0..H, or an ascending list that holds 1 and is not all of 0..H."""

MOST_HARMONICS, MOST_SAMPLES = 1000, 1_000_000


def checked_harmonics(value: Any, remedy: str = "") -> Harmonics:
    """The argument `harmonics` of an analysis: a number H from 1 on, or whole numbers from 0 on, ascending, among them 1."""
    if isinstance(value, Set):
        raise fault("harmonics", "must be a whole number or a list in ascending order", value, "Write a list: [0, 1, 3].")
    if isinstance(value, str) or not isinstance(value, Iterable) or np.ndim(value) == 0:  # type: ignore[arg-type]
        return between("harmonics", whole("harmonics", value, remedy), 1, MOST_HARMONICS)
    listed = tuple(between(f"harmonics[{k}]", h, 0, MOST_HARMONICS) for k, h in enumerate(value))
    if list(listed) != sorted(set(listed)):
        raise fault("harmonics", "must be a list in ascending order, each harmonic once", list(listed))
    if 1 not in listed:
        raise fault("harmonics", "must hold 1, the harmonic of the frequency itself", list(listed), "Put 1 into the list.")
    return listed[-1] if listed == tuple(range(listed[-1] + 1)) else listed


def fineness(harmonics: Any, samples: Any) -> tuple[Harmonics, int]:
    """Harmonics and Nt, checked; that they suit each other, `fourier` says."""
    return checked_harmonics(harmonics), between("samples", samples, 1, MOST_SAMPLES)


def harmonics_for(problem: Problem, value: Any, remedy: str = "") -> Harmonics:
    """`checked_harmonics`, refused where the problem has loads in harmonics that the list leaves out."""
    harmonics = checked_harmonics(value, remedy)
    held = orders(harmonics)
    loaded = sorted({harmonic for force in problem.forces for harmonic in force.factors})
    for harmonic in loaded:
        if harmonic not in held:
            rule = f"must {'reach' if harmonic > held[-1] else 'hold'} the load's harmonic {harmonic}"
            raise fault("harmonics", rule, harmonics if isinstance(harmonics, int) else list(harmonics))
    if held[0] != 0:
        reason = _why_the_mean_matters(problem)
        if reason:
            raise fault("harmonics", f"must hold 0, the mean, since {reason}", list(held), "Put 0 into the list.")
    return harmonics


def _why_the_mean_matters(problem: Problem) -> str:
    """What of a problem has a mean in general; empty where all of it is odd and may vibrate about zero."""
    if np.any(problem.static_powers):
        return "there are static loads"
    for contact in problem.contacts:
        if contact.normal is not None:
            return f"the normal load of contact {contact.name} varies"
        if any(start.code == TractionRatio.code or np.any(np.asarray(start.value)) for start in contact.starts):
            return f"contact {contact.name} starts off the middle"
    return ""


def orders(harmonics: Harmonics) -> tuple[int, ...]:
    """The harmonics in ascending order."""
    return tuple(range(harmonics + 1)) if isinstance(harmonics, int) else harmonics


def highest(harmonics: Harmonics) -> int:
    """H, by which arrays are sized."""
    return harmonics if isinstance(harmonics, int) else harmonics[-1]


def in_fractions(harmonics: Harmonics, periods: int) -> Harmonics:
    """Harmonics of the excitation as those of a motion expanded over several of its periods, 0, 1/p, ..., H as 0, 1, ..., p H."""
    if periods == 1:
        return harmonics
    if not isinstance(harmonics, int):
        remedy = "Which fractions a list leaves out, it does not say."
        raise fault("harmonics", "must be a number H where motions last several periods", list(harmonics), remedy)
    return between("harmonics times periods", periods * harmonics, 1, MOST_HARMONICS)


def columns_of(held: tuple[int, ...]) -> Index:
    """Where these harmonics stand in real storage a0, a1, b1, ..., ascending."""
    return np.array([column for h in held for column in ((2 * h - 1, 2 * h) if h else (0,))], dtype=np.int64)


def in_words(harmonics: Harmonics) -> str:
    """ "5 harmonics", or "harmonics 0, 1, 3, 5"."""
    return counted(harmonics, "harmonic") if isinstance(harmonics, int) else f"harmonics {attribute(harmonics)}"


def attribute(harmonics: int | Sequence[int]) -> int | str:
    """What a results file keeps: H, or the list in words."""
    return harmonics if isinstance(harmonics, int) else ", ".join(map(str, harmonics))


def of_attribute(value: Any) -> Harmonics:
    """The harmonics of a results file."""
    return checked_harmonics([int(h) for h in value.split(",")] if isinstance(value, str) else value)


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
    found = np.zeros((*real.shape[:-1], (real.shape[-1] + 1) // 2), dtype=complex)
    found.real[..., 0], found.real[..., 1:], found.imag[..., 1:] = real[..., 0], real[..., 1::2], -real[..., 2::2]
    return found


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


@inner
def swing(motion: Array) -> float:
    """Σ_h |X_h|: farther from its mean a motion (2H+1,) is at no time."""
    total = 0.0
    for h in range(1, (motion.size + 1) // 2):
        total += np.hypot(motion[2 * h - 1], motion[2 * h])
    return float(total)


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
    if motion[0] - swing(motion) > level:
        return found
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
