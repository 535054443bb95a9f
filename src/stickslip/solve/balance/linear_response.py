"""Linear limits of a response curve: contacts absent and contacts stuck."""

from __future__ import annotations

import numpy as np

from stickslip.solve.balance.balance import HarmonicBalance
from stickslip.solve.balance.without_contacts import WithoutContacts, solutions
from stickslip.support.checks import Array

POINTS = 400
TOGETHER = 100_000
"""Entries of matrices that are solved together."""
BY_ROWS = 100
"""Contact rows up to which every frequency is solved on them; with more, exact solutions at few frequencies give all others."""
RESOLUTION = np.concatenate([-np.geomspace(30.0, 0.05, 20), [0.0], np.geomspace(0.05, 30.0, 20)])
"""Extra frequencies around each resonance, in half widths ζ f."""


def linear_frequencies(balance: HarmonicBalance, low: float, high: float) -> Array:
    """Frequencies in Hz between low and high, denser around the resonances of the free and of the stuck structure."""
    problem = balance.problem
    natural = np.concatenate([problem.frequencies(stuck=False), problem.frequencies(stuck=True)])
    inside = natural[(natural >= low) & (natural <= high)]
    width = (high - low) / (50.0 * POINTS)
    extra = [f + RESOLUTION * max(5e-4 * f, width) for f in inside]
    grid = np.unique(np.concatenate([np.linspace(low, high, POINTS), *extra]))
    return np.asarray(grid[(grid >= low) & (grid <= high)])


def linear_amplitudes(balance: HarmonicBalance, frequencies: Array) -> tuple[Array, Array]:
    """|X_1| per unit force level of every output, free and stuck: two arrays (frequencies, outputs), m.

    Free means F = λ + K_c w = 0, so w = e' + G'K_c w. With many contact rows the structure's own equation without contacts is
    solved in place of that. NaN at an undamped resonance met exactly.
    """
    rows, omegas = balance.rows, 2.0 * np.pi * frequencies
    by_rows = rows <= BY_ROWS
    contacts = np.arange(rows if by_rows else 0)
    stuck, free = [], []
    for some in np.array_split(omegas, 1 + omegas.size * contacts.size**2 // TOGETHER):
        motion, softened = balance.linear.first_harmonics(some, contacts)
        stuck.append(motion[:, rows:])
        if by_rows:
            softened *= balance.stiffness
            moving = solutions(np.eye(rows) - softened[:, :rows], motion[:, :rows])
            free.append(motion[:, rows:] + (softened[:, rows:] @ moving[..., None])[..., 0])
    if not by_rows:
        free = [WithoutContacts.of(balance).outputs_at(omegas)]
    return np.abs(np.concatenate(free)), np.abs(np.concatenate(stuck))
