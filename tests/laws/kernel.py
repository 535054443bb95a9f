"""The package's answer for one contact: forces, states and derivatives for a given motion, as the balance asks for them."""

from __future__ import annotations

from dataclasses import dataclass

import numba
import numpy as np
from laws.marching import Motion, sampled
from laws.samples import Sample

from stickslip.model.contact.point import Contact, Start, between, contact_table
from stickslip.solve.balance.contact_forces import compile_contact_forces, contact_forces
from stickslip.solve.balance.energy import ContactCycle, contact_cycle
from stickslip.solve.balance.fourier import fourier
from stickslip.support.kernels.views import view

DIRECTIONS = ("x", "y", "z")


@dataclass(frozen=True)
class Answer:
    """λ̂ (rows, 2H+1), state of each row, derivatives by own, normal and the other tangential motion (rows, 2H+1, 2H+1), by ω
    (rows, 2H+1)."""

    target: np.ndarray
    unknown: np.ndarray
    own: np.ndarray
    normal: np.ndarray
    cross: np.ndarray
    by_omega: np.ndarray


OMEGA = 0.8
"""Angular frequency of the tests, rad/s; to most laws it does not matter."""


def contact_of(sample: Sample, start: Start) -> Contact:
    """The sample between a node and ground."""
    tangential = tuple(between(f"1.{axis}", "ground") for axis in DIRECTIONS[: sample.tangential])
    normal = between("1.z", "ground") if sample.law.has_normal else None
    return Contact("contact", sample.law, tangential, normal, start)


def evaluated(contact: Contact, w: np.ndarray, samples: int, omega: float = OMEGA) -> Answer:
    """Forces and derivatives of a contact for motion w (rows, 2H+1): the only place of the tests that calls the kernel."""
    rows, columns = w.shape
    found = Answer(
        np.full((rows, columns), np.nan),
        np.zeros(rows, dtype=np.int64),
        np.full((rows, columns, columns), np.nan),
        np.zeros((rows, columns, columns)),
        np.zeros((rows, columns, columns)),
        np.zeros((rows, columns)),
    )
    tables, blocks = fourier((columns - 1) // 2, samples), (found.own, found.normal, found.cross, found.by_omega)
    table = contact_table([contact])
    compile_contact_forces(table)
    _fill(table, tables, w, omega, found.target, found.unknown, *blocks)
    return found


@numba.njit
def _fill(table, tables, w, omega, target, unknown, own, normal, cross, by_omega):
    contact_forces(view(table), view(tables), w, omega, target, unknown, own, normal, cross, by_omega)


def answer(sample: Sample, start: Start, w: np.ndarray, samples: int, omega: float = OMEGA) -> Answer:
    """Forces and derivatives of a sample."""
    return evaluated(contact_of(sample, start), w, samples, omega)


def carried(contact: Contact, w: np.ndarray, samples: int) -> np.ndarray:
    """F = λ̂ + K_c w (rows, 2H+1) of a contact."""
    elements = contact.elements
    stiffness = [float(friction.stiffness.sum()) for friction in elements.friction]
    stiffness += [] if elements.normal is None else [float(elements.normal.stiffness.sum())]
    return evaluated(contact, w, samples).target + np.array(stiffness)[:, None] * w


def forces(sample: Sample, start: Start, w: np.ndarray, samples: int, omega: float = OMEGA) -> np.ndarray:
    """F = λ̂ + K_c w (rows, 2H+1), K_c from the sample's own elements."""
    return answer(sample, start, w, samples, omega).target + np.array(sample.stiffness)[:, None] * w


def cycle(sample: Sample, start: Start, w: np.ndarray, samples: int) -> ContactCycle:
    """The period sample by sample."""
    return contact_cycle(contact_table([contact_of(sample, start)]), fourier((w.shape[1] - 1) // 2, samples), w, OMEGA)


def motion_of(sample: Sample, w: np.ndarray, samples: int) -> Motion:
    """Samples of motion w (rows, 2H+1)."""
    signals = sampled(w, samples)
    normal = signals[-1] if sample.law.has_normal else np.zeros(samples)
    return Motion(signals[: sample.tangential], normal)


def random_motion(sample: Sample, harmonics: int, rng: np.random.Generator, size: float = 1.0) -> np.ndarray:
    """Motion w (rows, 2H+1) with harmonics that decay, of about `size` m; normal means positive (closed) or near zero."""
    rows = len(sample.stiffness)
    decay = np.repeat(1.0 / np.arange(1, harmonics + 1) ** 1.5, 2)
    w = np.concatenate([0.5 * rng.standard_normal((rows, 1)), rng.standard_normal((rows, 2 * harmonics)) * decay], axis=1)
    w *= size
    if sample.law.has_normal:
        w[-1, 0] = rng.choice([0.0, 0.5, 2.0]) * size
    return w
