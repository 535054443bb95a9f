"""Brute force: Jenkins elements by predictor and corrector, sample by sample, period after period, in plain Python.

Nothing here is shared with the package: it referees the compiled kernels.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from laws.samples import Element, Sample

from stickslip.model.contact.point import Start


@dataclass(frozen=True)
class Motion:
    """Displacements over one period: by tangential direction (directions, Nt) and normal (Nt,), m."""

    tangential: np.ndarray
    normal: np.ndarray


def marched(
    kt: float, u: np.ndarray, limit: np.ndarray, traction: float, periods: int = 1, landings: np.ndarray | float = 0.0
) -> np.ndarray:
    """Tractions (Nt,) of the last of several periods, from the traction at sample −1 (that is Nt−1); a step in which the element
    lands begins there, at a share of it."""
    moved = (1.0 - np.broadcast_to(landings, u.shape)) * (u - np.roll(u, 1))
    result = np.empty(u.size)
    for _ in range(periods):
        for n in range(u.size):
            predicted = traction + kt * moved[n]
            traction = min(max(predicted, -limit[n]), limit[n])
            result[n] = traction
    return result


def marched_by(
    step: Callable[[float, float, float, float], float], element: Element, motion: Motion, periods: int, settled: float
) -> np.ndarray:
    """Tractions (directions, Nt) of a law by its step(traction, du, limit before, limit after), from rest, period after period
    until the last one changes by less than `settled`."""
    limit, landings = element.limit(motion.normal), element.landings(motion.normal)
    rows = []
    for u in motion.tangential:
        traction, row = 0.0, np.empty(u.size)
        for _ in range(periods):
            last = traction
            for n in range(u.size):
                moved = (1.0 - landings[n]) * (u[n] - u[n - 1])
                traction = step(traction, moved, limit[n - 1], limit[n])
                row[n] = traction
            if abs(traction - last) < settled:
                break
        rows.append(row)
    return np.array(rows)


def reachable(kt: float, u: np.ndarray, limit: np.ndarray, landings: np.ndarray | float = 0.0) -> tuple[float, float]:
    """Lowest and highest steady traction at the last sample, from the two extreme starts."""
    return tuple(marched(kt, u, limit, sign * limit[-1], periods=3, landings=landings)[-1] for sign in (-1.0, 1.0))


def wanted_traction(start: Start, kt: float, u: np.ndarray, limit: np.ndarray, element: int, size: int) -> float:
    """Traction at the last sample that a start rule asks for."""
    value = start.values(size)[element]
    return {
        "slider_offset": kt * (u[-1] - value),
        "traction_ratio": value * limit[-1],
        "mean_traction": value - kt * (np.mean(u) - u[-1]),
    }[start.key]


def steady_traction(element: Element, u: np.ndarray, z: np.ndarray, start: Start, index: int, size: int) -> np.ndarray:
    """Steady tractions of one element over the period, (Nt,)."""
    limit = element.limit(z)
    landings = element.landings(z)
    low, high = reachable(element.kt, u, limit, landings)
    wanted = wanted_traction(start, element.kt, u, limit, index, size)
    return marched(element.kt, u, limit, min(max(wanted, low), high), periods=2, landings=landings)


def steady_forces(sample: Sample, motion: Motion, start: Start) -> np.ndarray:
    """Forces of every row t1, t2, n over the period, (rows, Nt)."""
    size = len(sample.elements)
    rows = []
    for u in motion.tangential:
        shares = [steady_traction(e, u, motion.normal, start, k, size) for k, e in enumerate(sample.elements)]
        rows.append(np.sum(shares, axis=0))
    if sample.law.has_normal:
        rows.append(np.sum([e.normal(motion.normal) for e in sample.elements], axis=0))
    return np.array(rows)


def harmonics_of(signal: np.ndarray, harmonics: int) -> np.ndarray:
    """a0, a1, b1, ... of signals (..., Nt) by complex FFT: (..., 2H+1)."""
    spectrum = np.fft.rfft(signal, axis=-1)[..., : harmonics + 1] / signal.shape[-1]
    real = np.empty((*signal.shape[:-1], 2 * harmonics + 1))
    real[..., 0] = spectrum[..., 0].real
    real[..., 1::2] = 2.0 * spectrum[..., 1:].real
    real[..., 2::2] = -2.0 * spectrum[..., 1:].imag
    return real


def sampled(real: np.ndarray, samples: int) -> np.ndarray:
    """Samples (..., Nt) of real storage (..., 2H+1)."""
    time = 2.0 * np.pi * np.arange(samples) / samples
    order = np.arange(1, (real.shape[-1] + 1) // 2)
    cosine, sine = np.cos(np.outer(order, time)), np.sin(np.outer(order, time))
    return real[..., :1] + real[..., 1::2] @ cosine + real[..., 2::2] @ sine
