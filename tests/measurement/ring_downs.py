"""Ring-downs of known damping with all that disturbs those of a laboratory: twelve kinds, any number of seeds."""

from typing import NamedTuple

import numpy as np
from scipy.signal import lfilter

RATE, LARGEST = 3000.0, 1e-3

KINDS = (
    "white noise",
    "suspension",
    "hum of 50 Hz",
    "hum of 150 Hz",
    "drift",
    "other modes",
    "close mode",
    "coloured noise",
    "quantised",
    "trigger delay",
    "friction",
    "friction, hum and coloured noise",
)


class RingDown(NamedTuple):
    """Samples of a displacement [m] over time [s], the frequency [Hz], the damping ratio at each sample, and a band [Hz]."""

    time: np.ndarray
    signal: np.ndarray
    frequency: float
    ratio: np.ndarray
    band: tuple[float, float]


def ring_down(kind: str, seed: int) -> RingDown:
    """A mode of 70 to 130 Hz with 0.1 to 1.2 % of damping, 1 mm at first, in 0.5 to 5 µm of noise."""
    rng = np.random.default_rng([KINDS.index(kind), seed])
    time = np.arange(int(RATE * rng.uniform(0.8, 2.5))) / RATE
    frequency, ratio = rng.uniform(70.0, 130.0), 10.0 ** rng.uniform(-3.0, -1.92)
    omega, noise = 2.0 * np.pi * frequency, 10.0 ** rng.uniform(-6.3, -5.3)
    delta = np.full(time.size, ratio * omega / np.sqrt(1.0 - ratio**2))
    size = LARGEST * np.exp(-delta * time)
    if kind.startswith("friction"):  # which takes 2 F/k in each half cycle, beside 0.1 % of viscous damping
        slope, viscous = 2.0 * 10.0 ** rng.uniform(-6.0, -5.2) * omega / np.pi, 1e-3 * omega
        size = np.maximum((LARGEST + slope / viscous) * np.exp(-viscous * time) - slope / viscous, 0.0)
        delta = viscous + slope / np.maximum(size, 1e-12)
    phase = 0.0 if kind == "trigger delay" else 2.0 * np.pi * rng.random()
    signal = size * np.cos(omega * time + phase)

    def ringing(hertz: float, damping: float, share: float) -> np.ndarray:
        fall = np.exp(-damping * 2.0 * np.pi * hertz * time)
        return share * LARGEST * fall * np.cos(2.0 * np.pi * (hertz * time + rng.random()))

    def hum(hertz: float, size: float) -> np.ndarray:
        return size * np.sin(2.0 * np.pi * (hertz * time + rng.random()))

    def coloured(size: float) -> np.ndarray:
        return size * np.sqrt(1.0 - 0.9**2) * lfilter([1.0], [1.0, -0.9], rng.normal(size=time.size + 500))[500:]

    if kind == "suspension":
        signal = signal + ringing(rng.uniform(5.0, 15.0), 0.01, rng.uniform(0.03, 0.2))
    elif kind.startswith("hum"):
        signal = signal + hum(float(kind.split()[2]), rng.uniform(2e-6, 1e-5))
    elif kind == "drift":
        signal = signal + LARGEST * rng.uniform(0.02, 0.2) * np.exp(-time / rng.uniform(0.2, 1.0)) + 1e-4 * rng.normal() * time
    elif kind == "other modes":
        signal = signal + ringing(3.1 * frequency, 0.003, 0.3) + ringing(rng.uniform(5.0, 7.0) * frequency, 0.004, 0.1)
    elif kind == "close mode":
        beside = frequency * (1.0 + rng.choice([-0.12, 0.12]))
        signal = signal + ringing(beside, ratio * rng.uniform(0.7, 1.4), rng.uniform(0.1, 0.4))
    elif kind == "trigger delay":
        before = int(RATE * rng.uniform(0.05, 0.2))
        signal = np.concatenate([np.zeros(before), signal])
        delta = np.concatenate([np.full(before, delta[0]), delta])
        time = np.arange(signal.size) / RATE
    if kind == "coloured noise":
        signal = signal + coloured(2.0 * noise)
    elif kind == "friction, hum and coloured noise":
        signal = signal + coloured(noise) + hum(50.0, 3e-6)
    elif kind == "quantised":
        step = 2.2 * LARGEST / 2.0 ** rng.integers(8, 11)
        signal = step * np.round((signal + 0.2 * noise * rng.normal(size=time.size)) / step)
    else:
        signal = signal + noise * rng.normal(size=time.size)
    return RingDown(time, signal, frequency, delta / np.hypot(delta, omega), (0.7 * frequency, 1.4 * frequency))
