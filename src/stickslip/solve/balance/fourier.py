"""Fourier synthesis and analysis on Nt samples t_n = 2πn/(Nt ω), in real storage a0, a1, b1, a2, b2, ...

Running sums of cos(mθ_n) and sin(mθ_n) let a Jacobian gather a whole run of slipping samples as one difference.
"""

from __future__ import annotations

from functools import lru_cache
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from stickslip.support.checks import Array, fault
from stickslip.support.kernels import kernel


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
