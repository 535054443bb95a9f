"""The balance without elimination: every λ unknown, J = I + E G' assembled densely; and the states found by marching."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from balance.compiled_parts import receptance_of
from laws.marching import Motion, harmonics_of, sampled, steady_traction
from laws.quadrature import normal_harmonics
from laws.samples import Element

from stickslip.model.contact.point import Contact
from stickslip.model.problem import Problem
from stickslip.solve.balance.balance import Evaluation, HarmonicBalance, Point
from stickslip.solve.balance.fourier import complex_harmonics


def real_block(G: np.ndarray) -> np.ndarray:
    """Real form (2H+1, 2H+1) of the complex gains G_h (H+1,), x_h = G_h f_h, in storage a0, a1, b1, ..."""
    size = 2 * G.size - 1
    block = np.zeros((size, size))
    block[0, 0] = G[0].real
    for h in range(1, G.size):
        i = 2 * h - 1
        block[i : i + 2, i : i + 2] = [[G[h].real, G[h].imag], [-G[h].imag, G[h].real]]
    return block


def full_matrix(balance: HarmonicBalance, evaluation: Evaluation) -> np.ndarray:
    """J = I + E G' on all rows and harmonics, (rows (2H+1), rows (2H+1))."""
    rows, size = balance.rows, balance.columns
    everything = np.arange(rows)
    parts = receptance_of(balance.linear, evaluation.point.omega, balance.highest, everything, everything)
    G = np.block([[real_block((parts[0] + 1j * parts[1])[:, r, c]) for c in everything] for r in everything])
    E = np.zeros((rows * size, rows * size))
    for r in everything:
        here = slice(r * size, (r + 1) * size)
        E[here, here] = evaluation.state.own[r]
        n = balance.table.loading_row[r]
        if n >= 0:
            E[here, n * size : (n + 1) * size] += evaluation.state.coupling[r]
    return np.eye(rows * size) + E @ G


def full_newton_step(balance: HarmonicBalance, evaluation: Evaluation) -> np.ndarray:
    """Newton's change of λ at fixed ω and level, (rows, 2H+1)."""
    change = np.linalg.solve(full_matrix(balance, evaluation), -evaluation.residual.ravel())
    return change.reshape(balance.rows, balance.columns)


def differenced_matrix(balance: HarmonicBalance, point: Point, step: float) -> np.ndarray:
    """J by differences of the residual."""
    columns = []
    for k in range(point.forces.size):
        change = np.zeros(point.forces.size)
        change[k] = step
        ends = [balance.evaluate(point.moved(s * change.reshape(point.forces.shape), "omega", 0.0)) for s in (1.0, -1.0)]
        columns.append((ends[0].residual - ends[1].residual).ravel() / (2.0 * step))
    return np.array(columns).T


def elements_of(contact: Contact) -> list[Element]:
    """Elements of a contact in the form of the law harness, from the law's own parameters."""
    law = contact.law
    names = {"kt": "kt", "kn": "kn", "gaps": "gap", "gap": "gap", "preload": "preload", "normal_load": "load"}
    size = len(law.kt) if np.ndim(getattr(law, "kt", 0.0)) else 1
    columns = {}
    for name, own in names.items():
        if getattr(law, name, None) is not None:
            columns[own] = np.broadcast_to(np.asarray(getattr(law, name), dtype=float), size)
    return [
        Element(mu=getattr(law, "mu", 0.0), **{key: float(values[e]) for key, values in columns.items()}) for e in range(size)
    ]


def marched_forces(problem: Problem, w: np.ndarray, samples: int) -> np.ndarray:
    """Contact forces (rows, 2H+1) for motion w (rows, 2H+1): friction by marching every element in plain Python, normal forces by
    quadrature."""
    forces, harmonics = [], (w.shape[1] - 1) // 2
    for contact, signals in _signals(problem, sampled(w, samples)):
        elements = elements_of(contact)
        for u, start in zip(signals.tangential, contact.starts, strict=True):
            shares = [steady_traction(e, u, signals.normal, start, k, len(elements)) for k, e in enumerate(elements)]
            forces.append(harmonics_of(np.sum(shares, axis=0), harmonics))
        if contact.normal is not None:
            forces.append(sum(normal_harmonics(e, w[len(forces)]) for e in elements))
    return np.array(forces)


def _signals(problem: Problem, signals: np.ndarray) -> list[tuple[Contact, Motion]]:
    found, row = [], 0
    for contact in problem.contacts:
        count = len(contact.directions)
        rows = signals[row : row + count]
        normal = rows[-1] if contact.normal is not None else np.zeros(signals.shape[1])
        found.append((contact, Motion(rows[: len(contact.tangential)], normal)))
        row += count
    return found


def unknowns_by_theory(problem: Problem, w: np.ndarray, samples: int) -> int:
    """2H+1 for each row with an element that slips or opens, 1 for each other row with an element not held at its offset."""
    total, columns = 0, w.shape[1]
    for contact, signals in _signals(problem, sampled(w, samples)):
        elements = elements_of(contact)
        normal = [e.normal(signals.normal) for e in elements]
        if contact.normal is not None:
            total += columns if any(np.any(n <= 0.0) for n in normal) else 0
        for u, start in zip(signals.tangential, contact.starts, strict=True):
            offsets = []
            for k, e in enumerate(elements):
                traction = steady_traction(e, u, signals.normal, start, k, len(elements))
                offsets.append(u - traction / e.kt)
            moving = any(np.ptp(s) > 1e-9 * np.abs(u).max() for s in offsets) or any(np.any(n <= 0.0) for n in normal)
            held = start.key == "slider_offset" and all(
                np.allclose(s, value, rtol=0.0, atol=1e-9 * np.abs(u).max())
                for s, value in zip(offsets, start.values(len(elements)), strict=True)
            )
            total += columns if moving else (0 if held else 1)
    return total


def balance_residual(balance: HarmonicBalance, point: Point, held: Sequence[int] = ()) -> float:
    """Largest |M q̈ + C q̇ + K q + Bᵀ F(B q) − p| per harmonic relative to the load, F in plain Python; of all
    harmonics, or of those given."""
    problem, omega = balance.problem, point.omega
    samples = balance.tables.E.shape[0]
    q = balance.linear.whole_motion(point.forces, omega, point.level)
    forces = marched_forces(problem, problem.B @ q, samples)
    load = problem.load(balance.highest, point.level, omega)
    right = complex_harmonics(load - problem.B.T @ forces)
    gaps = []
    for h, (q_h, r_h) in enumerate(zip(complex_harmonics(q).T, right.T, strict=True)):
        if held and h not in held:
            continue
        dynamic = problem.structure.K + 1j * h * omega * problem.C - (h * omega) ** 2 * problem.structure.M
        gaps.append(np.abs(dynamic @ q_h - r_h).max())
    return float(max(gaps) / np.abs(load).max())
