"""Linear limits of a response curve: contacts absent and contacts stuck."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from stickslip.solve.balance.balance import HarmonicBalance
from stickslip.support.checks import Array

Complex = NDArray[np.complex128]

POINTS = 400
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
    rows, outputs = balance.rows, balance.problem.output_rows.shape[0]
    free, stuck = np.empty((frequencies.size, outputs)), np.empty((frequencies.size, outputs))
    released = _on_coordinates(balance) if rows > balance.problem.systems.coordinates else _on_contact_rows(balance)
    none = np.zeros((rows, balance.columns))
    for k, frequency in enumerate(frequencies):
        omega = 2.0 * np.pi * frequency
        by_level = balance.linear.slope(none, omega, 0.0, by_level=True)
        motion = by_level[:, 1] - 1j * by_level[:, 2]
        stuck[k] = np.abs(motion[rows:])
        try:
            free[k] = np.abs(released(omega, motion))
        except np.linalg.LinAlgError:
            free[k] = np.nan
    return free, stuck


def _on_contact_rows(balance: HarmonicBalance) -> Callable[[float, Complex], Complex]:
    """Outputs (outputs,) without contacts at ω, from the motion of the stuck structure, by the contact rows."""
    rows = balance.rows
    everything, contacts = np.arange(rows + balance.problem.output_rows.shape[0]), np.arange(rows)

    def released(omega: float, motion: Complex) -> Complex:
        real, imaginary = balance.linear.receptance(omega, 1, everything, contacts)[:, 1]
        softened = (real + 1j * imaginary) * balance.stiffness
        moving = np.linalg.solve(np.eye(rows) - softened[:rows], motion[:rows])
        return np.asarray(motion[rows:] + softened[rows:] @ moving)

    return released


def _on_coordinates(balance: HarmonicBalance) -> Callable[[float, Complex], Complex]:
    """The same by the coordinates of the structure."""
    outputs, motion_at = balance.problem.systems.at(1).outputs, without_contacts(balance)
    return lambda omega, motion: np.asarray(outputs @ motion_at(omega))


def without_contacts(balance: HarmonicBalance) -> Callable[[float], Complex]:
    """The first harmonic of the motion of the structure (n,) at ω per unit force level, without contacts, m."""
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
        return np.asarray(shapes @ np.linalg.solve(K + 1j * omega * C - omega**2 * M, load))

    return motion_at
