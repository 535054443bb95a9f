"""A forced response in closed form: one mass on a spring and two Jenkins elements, one harmonic (equivalent linearisation).

At amplitude A an element of stiffness kt and limit L (A_c = L/kt, cos θ = 1 − 2 A_c/A) acts as the stiffness
kt (θ − ½ sin 2θ)/π and dissipates 4 L (A − A_c) per cycle, so each amplitude gives its two frequencies.
"""

import numpy as np

from stickslip.results.files import SCHEMA, labelled
from stickslip.support.outcome import Outcome

STIFFNESS = (2 * np.pi * 410.0) ** 2  # of a mass of 1 kg
DAMPING = 2 * 0.002 * 2 * np.pi * 410.0
KT = np.array([0.6, 0.4]) * ((2 * np.pi * 561.0) ** 2 - STIFFNESS)
LIMIT = np.array([20.0, 50.0])
LOW, HIGH = 380.0, 620.0
POINTS, LINEAR, SAMPLES = 240, 400, 128
DIRECTIONS = ["t1", "t2", "n"]


def jenkins(amplitude):
    """Stiffness, energy per cycle and stick share of each contact, (contact, n)."""
    critical = LIMIT[:, None] / KT[:, None]
    angle = np.arccos(np.clip(1 - 2 * critical / amplitude, -1, 1))
    stiffness = KT[:, None] / np.pi * (angle - 0.5 * np.sin(2 * angle))
    return stiffness, 4 * LIMIT[:, None] * np.maximum(amplitude - critical, 0), angle / np.pi


def curve(force):
    """Frequencies, amplitudes and the index of the peak along the curve, points dense where it bends."""
    amplitude = force / STIFFNESS * np.geomspace(0.3, 400, 100_000)
    stiffness, energy, _ = jenkins(amplitude)
    k = STIFFNESS + stiffness.sum(0)
    loss = energy.sum(0) / (np.pi * amplitude**2) + DAMPING * np.sqrt(k)
    rest = (force / amplitude) ** 2 - loss**2
    real = rest >= 0
    below, above = (np.sqrt(np.maximum(k[real] + side * np.sqrt(rest[real]), 0)) / (2 * np.pi) for side in (-1, 1))
    frequency = np.concatenate([below, above[::-1]])
    amplitude = np.concatenate([amplitude[real], amplitude[real][::-1]])
    inside = (frequency > LOW) & (frequency < HIGH)
    frequency, amplitude = frequency[inside], amplitude[inside]
    length = np.cumsum(np.hypot(np.gradient(frequency) / (HIGH - LOW), np.gradient(np.log(amplitude)) / 4))
    top = int(np.argmax(amplitude))
    kept = np.searchsorted(length, np.linspace(length[0], length[-1], POINTS)).clip(0, length.size - 1)
    kept = np.unique(np.append(kept, top))
    return frequency[kept], amplitude[kept], int(np.searchsorted(kept, top))


def linear(force, stiffness):
    """Amplitude of the linear oscillator over the band."""
    w = 2 * np.pi * np.linspace(LOW, HIGH, LINEAR)
    return np.abs(force / (stiffness - w**2 + 1j * w * DAMPING))


def loop(contact, amplitude):
    """Motion and force over the third period from rest."""
    u = amplitude * np.cos(2 * np.pi * np.arange(3 * SAMPLES) / SAMPLES)
    force = np.zeros(u.size)
    for i in range(1, u.size):
        force[i] = np.clip(force[i - 1] + KT[contact] * (u[i] - u[i - 1]), -LIMIT[contact], LIMIT[contact])
    return u[-SAMPLES:], force[-SAMPLES:]


def empty(levels, outputs, contacts=2):
    """Every variable of the schema, padded."""
    sizes = {"case": len(levels), "point": POINTS + 1, "output": len(outputs), "harmonic": 4, "part": 2, "contact": contacts}
    sizes |= {"direction": 3, "peak": 2, "linear_point": LINEAR, "sample": SAMPLES, "mode": 1}
    kinds = {"float": (np.nan, float), "int8": (0, np.int8), "str": ("", object)}
    return {v.name: np.full([sizes[dim] for dim in v.dims], *kinds[v.kind]) for v in SCHEMA}


def fill_case(v, case, level, share):
    """One curve with its contacts, its peak and its loops."""
    f, a, top = curve(level)
    n = f.size
    _, energy, stick = jenkins(a)
    v["frequency"][case, :n], v["outcome"][case, :n], v["residual"][case, :n] = f, Outcome.CONVERGED, 1e-12
    v["iterations"][case, :n], v["active_rows"][case, :n] = 4, 8
    v["energy_residual"][case, :n], v["slip_work_error"][case, :n] = 2e-12, 3e-4
    v["loss_factor"][case, :n] = energy.sum(0) / (np.pi * (STIFFNESS + KT.sum()) * a**2) + 0.004
    v["response"][case, :n] = 0.0
    v["response"][case, :n, :, 1, 0] = v["amplitude"][case, :n] = a[:, None] * share
    v["rms"][case, :n], v["max_abs"][case, :n] = a[:, None] * share / np.sqrt(2), 1.02 * a[:, None] * share
    v["dissipated"][case, :n] = energy.T
    lifted = 0.5 * np.clip(a / a.max() - 0.8, 0, 1)
    v["share_open"][case, :n, :, 0] = np.column_stack([lifted, 0 * lifted])
    v["share_stick"][case, :n, :, 0] = stick.T * (1 - v["share_open"][case, :n, :, 0])
    v["share_slip"][case, :n, :, 0] = 1 - v["share_stick"][case, :n, :, 0] - v["share_open"][case, :n, :, 0]
    v["share_open"][case, :n, 0, 2], v["share_stick"][case, :n, 0, 2], v["share_slip"][case, :n, 0, 2] = lifted, 1 - lifted, 0
    v["peak_frequency"][case, 0], v["peak_amplitude"][case, 0] = f[top], a[top] * share
    v["peak_max_abs"][case, 0], v["peak_loss_factor"][case, 0] = 1.02 * a[top] * share, v["loss_factor"][case, top]
    v["free_amplitude"][case] = linear(level, STIFFNESS)[:, None] * share
    v["stuck_amplitude"][case] = linear(level, STIFFNESS + KT.sum())[:, None] * share
    v["loop_frequency"][case] = f[top]
    for contact in (0, 1):
        v["loop_motion"][case, contact, 0], v["loop_force"][case, contact, 0] = loop(contact, a[top])


def synthetic(levels=(1.0, 5.0, 20.0, 80.0), failed=(), outputs=("tip.x", "root.x"), contacts=("cylinder", "flat"), **attrs):
    """The dataset; `failed` marks (case, point, outcome)."""
    v = empty(levels, outputs)
    v["linear_frequency"][:] = np.linspace(LOW, HIGH, LINEAR)
    v["natural_frequency_free"][:], v["natural_frequency_stuck"][:] = 410.0, 561.0
    v["case_outcome"][:], v["case_message"][:] = Outcome.CONVERGED, "The curve reached the end of the band."
    for case, level in enumerate(levels):
        fill_case(v, case, level, np.array([1.0, 0.3])[: len(outputs)])
    for case, point, outcome in failed:
        v["outcome"][case, point] = outcome
        for name in ("amplitude", "rms", "max_abs", "response", "dissipated", "loss_factor", "energy_residual"):
            v[name][case, point] = np.nan
    coords = {"force_level": levels, "output": list(outputs), "contact": list(contacts), "direction": DIRECTIONS}
    standard = {"title": "One mass", "study": "[study]\n", "harmonics": 3, "samples": 256, "cpu_seconds": 12.5}
    return labelled(v, coords, {**standard, **attrs})


def poor(kind):
    """Datasets at the edge: nothing converged, one point, no peak, names that are formulas, folded, no contact moves."""
    dataset = synthetic((5.0,))
    if kind == "names":
        dataset = synthetic((1.0, 5.0), outputs=("$\\frac{1}{$",), contacts=("$x", "b$"))
        dataset.force_level[0] = 0.0
    if kind == "nothing converged":
        dataset.outcome[:] = np.where(dataset.outcome == 1, 2, 0)
    if kind == "empty":
        dataset.outcome[:] = 0
    if kind == "one point":
        dataset.outcome[:, 1:] = 0
    if kind == "no peak":
        dataset.peak_amplitude[:] = np.nan
    if kind == "folded":
        dataset.frequency[:, 50:60] = dataset.frequency[:, 50:60].values[:, ::-1]
    if kind == "no contacts":
        dataset = dataset.isel(contact=slice(0, 0))
    if kind == "loops missing":
        dataset.loop_motion[:] = np.nan
        dataset.loop_force[:] = np.nan
    return dataset


KINDS = ["nothing converged", "empty", "one point", "no peak", "names", "folded", "no contacts", "loops missing"]
