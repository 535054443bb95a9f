"""Linear limits of a response curve: contacts absent and contacts stuck."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
from numpy.typing import NDArray

from stickslip.solve.balance.balance import HarmonicBalance
from stickslip.support.checks import Array

Complex = NDArray[np.complex128]

POINTS = 400
TOGETHER = 100_000
"""Entries of matrices that are solved together."""
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

    Free means F = λ + K_c w = 0, so w = e' + G'K_c w. Where contact rows are more than coordinates of the structure, its own
    equation without contacts is solved in place of that. NaN at an undamped resonance met exactly.
    """
    rows, omegas = balance.rows, 2.0 * np.pi * frequencies
    on_coordinates = rows > balance.problem.systems.coordinates
    contacts = np.arange(0 if on_coordinates else rows)
    stuck, free = [], []
    for some in np.array_split(omegas, 1 + omegas.size * contacts.size**2 // TOGETHER):
        motion, softened = balance.linear.first_harmonics(some, contacts)
        stuck.append(motion[:, rows:])
        if not on_coordinates:
            softened *= balance.stiffness
            moving = _solutions(np.eye(rows) - softened[:, :rows], motion[:, :rows])
            free.append(motion[:, rows:] + (softened[:, rows:] @ moving[..., None])[..., 0])
    if on_coordinates:
        motion_at, outputs = without_contacts(balance), balance.problem.systems.at(1).outputs
        free = [np.array([outputs @ motion_at(omega) for omega in omegas])]
    return np.abs(np.concatenate(free)), np.abs(np.concatenate(stuck))


def _solutions(matrices: NDArray[Any], right: NDArray[Any]) -> NDArray[Any]:
    """Solutions (k, n) of systems (k, n, n) with right-hand sides (k, n); NaN of those that are singular."""
    try:
        return np.asarray(np.linalg.solve(matrices, right[..., None])[..., 0])
    except np.linalg.LinAlgError:
        if len(matrices) == 1:
            return np.full_like(right, np.nan)
        return np.concatenate([_solutions(matrices[k : k + 1], right[k : k + 1]) for k in range(len(matrices))])


def without_contacts(balance: HarmonicBalance) -> Callable[[float], Complex]:
    """The first harmonic of the motion of the structure (n,) at ω per unit force level, without contacts, m; NaN at an undamped
    resonance."""
    system = balance.problem.systems.at(1)
    M, C, K = system.M, system.C, system.without_contacts(balance.stiffness)
    powers = balance.problem.load_powers(balance.highest)
    loads = powers[:, :, 1] - 1j * powers[:, :, 2]
    kept = balance.problem.systems.kept(1)
    shapes = np.eye(len(M)) if kept is None else kept[0]
    if kept is not None:
        M, C, K = (shapes.conj().T @ matrix @ shapes for matrix in (M, C, K))
        loads = loads @ shapes.conj()

    def motion_at(omega: float) -> Complex:
        load = omega ** np.arange(len(loads)) @ loads
        return np.asarray(shapes @ _solutions((K + 1j * omega * C - omega**2 * M)[None], load[None])[0])

    return motion_at
