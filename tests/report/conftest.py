"""A forced response in closed form: one mass between two Jenkins elements, one harmonic (equivalent linearisation)."""

import numpy as np
import pytest

from stickslip.outcome import Outcome
from stickslip.results import SCHEMA, labelled

MASS, STIFFNESS, DAMPING = 1.0, (2 * np.pi * 410.0) ** 2, 2 * 0.002 * 2 * np.pi * 410.0
KT = np.array([0.6, 0.4]) * ((2 * np.pi * 561.0) ** 2 - STIFFNESS)
LIMIT = np.array([20.0, 50.0])
POINTS, LINEAR, SAMPLES = 240, 400, 128


def jenkins(amplitude):
    """Real stiffness, energy per cycle and stick share of each contact, (contact, n)."""
    critical = LIMIT[:, None] / KT[:, None]
    angle = np.arccos(np.clip(1 - 2 * critical / amplitude, -1, 1))
    stiffness = KT[:, None] / np.pi * (angle - 0.5 * np.sin(2 * angle))
    energy = 4 * LIMIT[:, None] * np.maximum(amplitude - critical, 0)
    return stiffness, energy, angle / np.pi


def curve(force, low=380.0, high=620.0):
    """Frequencies and amplitudes along the whole curve: for each amplitude the two frequencies that give it."""
    static = force / STIFFNESS
    amplitude = static * np.geomspace(0.3, 400, 200000)
    stiffness, energy, _ = jenkins(amplitude)
    loss = energy.sum(0) / (np.pi * amplitude**2)
    k, wanted = STIFFNESS + stiffness.sum(0), (force / amplitude) ** 2
    # (k - w2)^2 + (loss + c w)^2 = wanted, viscous part taken at w = sqrt(k)
    rest = wanted - (loss + DAMPING * np.sqrt(k)) ** 2
    real = rest >= 0
    sides = [np.sqrt(np.maximum(k + s * np.sqrt(np.maximum(rest, 0)), 0)) / (2 * np.pi) for s in (-1, 1)]
    frequency = np.concatenate([sides[0][real], sides[1][real][::-1]])
    amplitude = np.concatenate([amplitude[real], amplitude[real][::-1]])
    inside = (frequency > low) & (frequency < high)
    frequency, amplitude = frequency[inside], amplitude[inside]
    length = np.cumsum(np.hypot(np.gradient(frequency) / (high - low), np.gradient(np.log(amplitude)) / 4))
    kept = np.unique(np.searchsorted(length, np.linspace(length[0], length[-1], POINTS)).clip(0, length.size - 1))
    top = int(np.argmax(amplitude))
    kept = np.unique(np.append(kept, top))
    return frequency[kept], amplitude[kept], int(np.searchsorted(kept, top))


def linear(force, stiffness):
    frequency = np.linspace(380.0, 620.0, LINEAR)
    w = 2 * np.pi * frequency
    return np.abs(force / (stiffness - w**2 + 1j * w * DAMPING))


def synthetic(levels=(1.0, 5.0, 20.0, 80.0), failed=(), title="One mass, two contacts", outputs=("tip.x", "root.x")):
    sizes = dict(case=len(levels), point=POINTS + 1, output=len(outputs), harmonic=4, part=2, contact=2, direction=3, peak=2)
    sizes |= dict(linear_point=LINEAR, sample=SAMPLES, mode=1)
    start = {"float": np.nan, "int8": 0, "str": ""}
    types = {"float": float, "int8": np.int8, "str": object}
    v = {s.name: np.full([sizes[d] for d in s.dims], start[s.kind], dtype=types[s.kind]) for s in SCHEMA}
    v["linear_frequency"][:] = np.linspace(380.0, 620.0, LINEAR)
    v["natural_frequency_free"][:], v["natural_frequency_stuck"][:] = 410.0, 561.0
    v["case_outcome"][:] = Outcome.CONVERGED
    v["case_message"][:] = "The curve reached the end of the band."
    share = np.array([1.0, 0.3])[: len(outputs)]
    for case, level in enumerate(levels):
        f, a, top = curve(level)
        n = f.size
        stiffness, energy, stick = jenkins(a)
        v["frequency"][case, :n], v["outcome"][case, :n] = f, Outcome.CONVERGED
        v["residual"][case, :n], v["iterations"][case, :n], v["active_rows"][case, :n] = 1e-12, 4, 2
        v["energy_residual"][case, :n], v["slip_work_error"][case, :n] = 2e-12, 3e-4
        v["loss_factor"][case, :n] = energy.sum(0) / (np.pi * (STIFFNESS + KT.sum()) * a**2) + 0.004
        v["response"][case, :n] = 0.0
        v["response"][case, :n, :, 1, 0] = a[:, None] * share
        v["amplitude"][case, :n] = a[:, None] * share
        v["rms"][case, :n], v["max_abs"][case, :n] = a[:, None] * share / np.sqrt(2), 1.02 * a[:, None] * share
        v["dissipated"][case, :n] = energy.T
        away = np.clip(a / a.max() - 0.8, 0, 1)[:, None] * 0.5
        v["share_open"][case, :n, 0, :], v["share_open"][case, :n, 1, 0] = away * [1, 0, 1], 0
        v["share_stick"][case, :n, 0, 0], v["share_stick"][case, :n, 1, 0] = stick[0] * (1 - away[:, 0]), stick[1]
        v["share_stick"][case, :n, 0, 2], v["share_slip"][case, :n, 0, 2] = 1 - away[:, 0], 0
        for c in (0, 1):
            v["share_slip"][case, :n, c, 0] = 1 - v["share_stick"][case, :n, c, 0] - v["share_open"][case, :n, c, 0]
        for name in ("contact_motion", "contact_force"):
            v[name][case, :n, 0][:, [0, 2]], v[name][case, :n, 1, 0] = 0.0, 0.0
        v["peak_frequency"][case, 0], v["peak_amplitude"][case, 0] = f[top], a[top] * share
        v["peak_max_abs"][case, 0], v["peak_loss_factor"][case, 0] = 1.02 * a[top] * share, v["loss_factor"][case, top]
        for name, k in (("free_amplitude", STIFFNESS), ("stuck_amplitude", STIFFNESS + KT.sum())):
            v[name][case] = linear(level, k)[:, None] * share
        angle = 2 * np.pi * np.arange(3 * SAMPLES) / SAMPLES
        u = a[top] * np.cos(angle)
        for c in (0, 1):
            force = np.zeros(u.size)
            for i in range(1, u.size):
                force[i] = np.clip(force[i - 1] + KT[c] * (u[i] - u[i - 1]), -LIMIT[c], LIMIT[c])
            v["loop_motion"][case, c, 0], v["loop_force"][case, c, 0] = u[-SAMPLES:], force[-SAMPLES:]
        v["loop_frequency"][case] = f[top]
    for case, point, outcome in failed:
        v["outcome"][case, point] = outcome
        for name in ("amplitude", "rms", "max_abs", "response", "dissipated", "loss_factor", "energy_residual"):
            v[name][case, point] = np.nan
    coords = dict(force_level=levels, output=list(outputs), contact=["cylinder", "flat"], direction=["t1", "t2", "n"])
    return labelled(v, coords, dict(title=title, study="[study]\n", harmonics=3, samples=256, cpu_seconds=12.5))


@pytest.fixture
def dataset():
    return synthetic()


@pytest.fixture
def dataset_with_failures():
    return synthetic(failed=[(1, 40, 2), (1, 41, 2), (3, 100, 2), (3, 101, 3)])


@pytest.fixture
def make():
    return synthetic
