"""One contact in prescribed harmonic motion against closed forms."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from stickslip.model.contact.law import Law
from stickslip.model.contact.macroslip import Macroslip
from stickslip.model.contact.microslip import MicroslipArray
from stickslip.model.contact.point import Contact, between, contact_table
from stickslip.solve.balance.energy import contact_cycle, cycle_work
from stickslip.solve.balance.fourier import fourier
from verify.row import CLOSED, INDEPENDENT, Row, absolute, relative

TITLE = "One contact in harmonic motion"
ABOUT = (
    "Griffin's equivalent stiffness and damping of a Jenkins element (kd = 2, μN = 3), energy per cycle with a normal "
    "load in phase with the motion, arrays that sample the half-ellipse of a Hertz contact; order of convergence in "
    "the samples per period."
)
SAMPLES = 4096


def force(law: Law, w: np.ndarray, samples: int) -> np.ndarray:
    """Contact force harmonics (rows, 2H+1) for motion w of one tangential direction and, if the law has one, the normal."""
    contact = Contact("c", law, (between("1.x", "ground"),), between("1.y", "ground") if law.has_normal else None)
    from laws.kernel import carried

    return carried(contact, w, samples)


def equivalent(amplitude: float, samples: int) -> np.ndarray:
    """k_eq and h of the Jenkins element kd 2, μN 3."""
    found = force(Macroslip(2.0, 1.0, normal_load=3.0), np.array([[0.0, amplitude, 0.0]]), samples)[0]
    return np.array([found[1], -found[2]]) / amplitude


def griffin(amplitude: float) -> np.ndarray:
    """k_eq = (kd/π)(t* − ½ sin 2t*), h = (4 Fc/(πA))(1 − Ac/A), t* = arccos(1 − 2 Ac/A)."""
    critical = 1.5
    angle = np.arccos(1.0 - 2.0 * critical / amplitude)
    stiffness = 2.0 / np.pi * (angle - 0.5 * np.sin(2.0 * angle))
    return np.array([stiffness, 12.0 / (np.pi * amplitude) * (1.0 - critical / amplitude)])


def order(samples: tuple[int, int]) -> float:
    """Observed order of the root mean square error over forty amplitudes: where a slip falls between two samples is chance."""
    amplitudes = np.geomspace(1.6, 10.0, 40)
    sizes = []
    for n in samples:
        errors = [equivalent(a, n) / griffin(a) - 1.0 for a in amplitudes]
        sizes.append(float(np.sqrt(np.mean(np.square(errors)))))
    return float(np.log(sizes[0] / sizes[1]) / np.log(samples[1] / samples[0]))


def half_ellipse(elements: int) -> tuple[MicroslipArray, float]:
    """Array that samples T' = kt √(1 − (x/x_s)²), F = 1.3, kt = 2.1; and x_s."""
    largest = 4.0 * 1.3 / (np.pi * 2.1)
    edges = np.linspace(0.0, 1.0, elements + 1)
    stiffness = -np.diff(2.1 * np.sqrt(1.0 - edges**2))
    middles = 0.5 * largest * (edges[1:] + edges[:-1])
    return MicroslipArray(tuple(stiffness), 1.0, normal_load=tuple(stiffness * middles)), largest


def in_phase(samples: int) -> float:
    """Energy per cycle, kd 2, μ 0.5, n0 1, κ 0.3, u = 2 sin θ."""
    w = np.array([[0.0, 0.0, 2.0]] * 2)
    return float(cycle_work(force(Macroslip(2.0, 0.5, 0.3, 1.0), w, samples), w)[0])


def rows() -> Iterator[Row]:
    values = {1.6: (1.9479544512562, 0.1492077591486), 3.0: (1.0, 0.6366197723676), 10.0: (0.1881204043742, 0.3246760839075)}
    for amplitude, (stiffness, damping) in values.items():
        found = equivalent(amplitude, SAMPLES)
        yield relative(f"Jenkins, A = {amplitude:g}: k_eq, {SAMPLES} samples", found[0], stiffness, 1e-6, INDEPENDENT)
        yield relative(f"Jenkins, A = {amplitude:g}: h, {SAMPLES} samples", found[1], damping, 1e-6, INDEPENDENT)
    yield absolute("Jenkins: order in the samples, 256 to 4096", order((256, 4096)), 2.0, 0.15, "second order")
    law = Macroslip(2.0, 1.0, normal_load=3.0)
    cycle = contact_cycle(
        contact_table([Contact("c", law, (between("1.x", "ground"),))]), fourier(1, 16384), np.array([[0.0, 4, 0.0]]), 1.0
    )
    yield relative("Jenkins, A = 4: slip work, 16384 samples", cycle.slip_work[0], 30.0, 1e-6, f"{CLOSED} 4 μN (A − μN/kd)")
    yield relative("Normal load in phase: energy per cycle, 4096 samples", in_phase(4096), 3.36140792, 1e-6, INDEPENDENT)
    yield relative("Normal load in phase: energy per cycle, 16384 samples", in_phase(16384), 3.36140792, 1e-7, INDEPENDENT)
    law, largest = half_ellipse(20000)
    for ratio, energy in ((0.5, 2.86961625e-2), (0.9, 0.359961965), (1.5, 2.668912461)):
        name = f"Half-ellipse, 20000 elements, A/x_s = {ratio}: energy per cycle"
        yield relative(name, law.loop_energy(ratio * largest), energy, 1e-6, INDEPENDENT)
    law, largest = half_ellipse(400)
    w = np.array([[0.0, 0.9 * largest, 0.0]])
    sampled = float(cycle_work(force(law, w, 4096), w)[0])
    yield relative("Half-ellipse, 400 elements, A/x_s = 0.9: energy from sampled forces", sampled, 0.359961965, 1e-4, INDEPENDENT)
