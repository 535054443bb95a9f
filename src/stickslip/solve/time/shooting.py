"""The periodic motion of the time steps by shooting, and its largest Floquet multiplier, by differences of marched periods.

Nothing but marches of one period is used, no harmonics and no linearised contact: an independent check of stability. States
are x = (η, √m η̇, y/√kt), so that ‖x‖² is twice an energy.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy import linalg

from stickslip.model.problem import Problem
from stickslip.solve.time.march import March, TimeStart, loads_of_steps, no_history, state_at
from stickslip.solve.time.model import time_model
from stickslip.solve.time.period import march_period, settle
from stickslip.support.checks import Array
from stickslip.support.machine import one_blas_thread

DISTURBANCE = 1e-5
"""Size of a disturbance relative to the vibration; the solution of a step leaves 1e-11 of the forces."""

CLOSED = 1e-7
"""Defect of a period, relative to the vibration, at which a motion is periodic."""

CORRECTIONS = 12

SMALLEST_STEP = 1.0 / 64.0

MOST_VECTORS = 80
"""Size of the Krylov spaces."""

FEWEST_VECTORS = 12

EXHAUSTED = 1e-5
"""Part of a new vector outside the space, relative, below which the space holds all that the map makes of it."""

SETTLED = 1e-4
"""Residual of the largest multiplier, relative to it, at which the space is large enough; twice in succession."""

KINK = 0.03
"""Difference of the one-sided derivatives beyond which there is none: a contact just touches, or a slider just slips."""

SOLVED = 1e-2
"""Residual of the linear system of a correction, relative."""


@dataclass(frozen=True, eq=False)
class Shooting:
    """start: a state of the periodic motion, at t = 0; defect: what a period changes of it, relative to the vibration; outputs
    (outputs, N): over the period; multipliers: those found, largest first, without those of exactly 1 of sliders that never
    slip. closed: whether the motion was found; without it there are no multipliers, nor where the period has no derivative."""

    start: TimeStart
    defect: float
    outputs: Array
    multipliers: NDArray[np.complex128]
    closed: bool

    @property
    def leading(self) -> complex:
        """The largest multiplier; NaN where no periodic motion was found."""
        return complex(self.multipliers[0]) if self.multipliers.size else complex(np.nan)


def shoot(problem: Problem, omega: float, level: float, start: TimeStart, motion: Array, settings: March) -> Shooting:
    """The periodic motion near a state at t = 0, and its multipliers. motion q (n, 2H+1) [m]: of the harmonic balance, for scale.

    Newton's method: (1 − Φ) δx = P(x) − x by GMRES, Φ by differences of the map P of a period.
    """
    with one_blas_thread():
        march = PeriodMarch(problem, omega, level, settings)
        vibration = float(np.linalg.norm(march.model.weight @ motion[:, 1:])) / np.sqrt(2.0)
        x, defect = _closed(march, march.packed(start), vibration)
        closed = bool(vibration > 0.0 and np.linalg.norm(defect) <= CLOSED * vibration)
        values = _multipliers(march, x, x + defect, vibration) if closed else np.empty(0, dtype=complex)
        march(x)
        return Shooting(march.start(x), float(np.linalg.norm(defect)) / vibration, march.history.outputs.copy(), values, closed)


class PeriodMarch:
    """The map of a period of N steps, from a state x (k,) at t = 0 to the one a period later; NaN where a step fails."""

    def __init__(self, problem: Problem, omega: float, level: float, settings: March) -> None:
        self.model, steps = time_model(problem), settings.steps_per_period
        self.matrices = self.model.step_matrices(settings.method.coefficients, 2.0 * np.pi / omega / steps)
        self.loads = loads_of_steps(self.model, omega, level, steps)
        self.history = no_history(self.model, steps)
        # Massless modes have a velocity too; its scale only has to be a number.
        inertia = np.maximum(np.sqrt(self.model.mass), self.matrices.step)
        stiffness = np.sqrt(self.model.table.stiffness)
        self.scale = np.concatenate([np.ones(inertia.size), inertia, 1.0 / np.where(stiffness > 0.0, stiffness, np.inf)])

    def __call__(self, x: Array) -> Array:
        state = state_at(self.model, self.start(x))
        settle(self.model.table, self.matrices, self.loads, state)
        if march_period(self.model.table, self.matrices, self.loads, state, self.history).failed >= 0:
            return np.full(x.size, np.nan)
        return np.asarray(self.scale * np.concatenate([state.motion, state.velocity, state.contacts.intercept]))

    def packed(self, start: TimeStart) -> Array:
        """x of a state."""
        weight = self.model.weight
        return np.asarray(self.scale * np.concatenate([weight @ start.motion, weight @ start.velocity, start.intercepts]))

    def start(self, x: Array) -> TimeStart:
        """The state of x."""
        parts, modes = x / np.where(self.scale > 0.0, self.scale, 1.0), self.model.mass.size
        shapes = self.model.shapes
        return TimeStart(shapes @ parts[:modes], shapes @ parts[modes : 2 * modes], parts[2 * modes :])


class Differences:
    """Φ v ≈ (P(x + ε v) − P(x − ε v))/2ε for unit vectors v; kink: the largest difference of the two one-sided ones."""

    def __init__(self, march: PeriodMarch, x: Array, after: Array, vibration: float) -> None:
        self.march, self.x, self.after, self.size, self.kink = march, x, after, DISTURBANCE * vibration, 0.0

    def __call__(self, v: Array) -> Array:
        up, down = (self.march(self.x + sign * self.size * v) for sign in (1.0, -1.0))
        self.kink = max(self.kink, float(np.linalg.norm(up + down - 2.0 * self.after)) / self.size)
        return np.asarray((up - down) / (2.0 * self.size))


class Krylov:
    """Arnoldi's vectors of a map, orthonormal (k, j+1), and its projection (j+1, j)."""

    def __init__(self, derivative: Differences, first: Array) -> None:
        self.derivative = derivative
        self.vectors = [first / np.linalg.norm(first)]
        self.columns: list[Array] = []
        self.exhausted = False

    def grow(self) -> None:
        """One vector more."""
        new = self.derivative(self.vectors[-1])
        size, column = float(np.linalg.norm(new)), np.zeros(len(self.vectors) + 1)
        for _ in range(2):
            for k, vector in enumerate(self.vectors):
                part = float(vector @ new)
                column[k] += part
                new = new - part * vector
        column[-1] = np.linalg.norm(new)
        self.columns.append(column)
        self.exhausted = not column[-1] > EXHAUSTED * max(size, 1.0)
        self.vectors.append(new / column[-1] if column[-1] > 0.0 else new)

    @property
    def matrix(self) -> Array:
        """The projection (j+1, j)."""
        found = np.zeros((len(self.columns) + 1, len(self.columns)))
        for j, column in enumerate(self.columns):
            found[: column.size, j] = column
        return found


def _closed(march: PeriodMarch, x: Array, vibration: float) -> tuple[Array, Array]:
    """x and P(x) − x of the periodic motion, or as near to it as Newton's method comes."""
    defect = march(x) - x
    for _ in range(CORRECTIONS):
        if not np.linalg.norm(defect) > CLOSED * vibration:
            break
        change = _correction(Differences(march, x, x + defect, vibration), defect)
        length = 1.0
        while length >= SMALLEST_STEP:
            trial = x + length * change
            left = march(trial) - trial
            if np.linalg.norm(left) < (1.0 - 0.1 * length) * np.linalg.norm(defect):
                break
            length *= 0.5
        else:
            break
        x, defect = trial, left
    return x, defect


def _correction(derivative: Differences, defect: Array) -> Array:
    """δx of (1 − Φ) δx = defect by GMRES."""
    krylov, size = Krylov(derivative, defect), float(np.linalg.norm(defect))
    while True:
        krylov.grow()
        H = krylov.matrix
        right = size * np.eye(H.shape[0])[0]
        matrix = np.eye(*H.shape) - H
        if not np.all(np.isfinite(H)):
            return np.full(defect.size, np.nan)
        found = linalg.lstsq(matrix, right)[0]
        left = float(np.linalg.norm(right - matrix @ found))
        if left <= SOLVED * size or krylov.exhausted or H.shape[1] >= min(MOST_VECTORS, defect.size):
            return np.asarray(np.array(krylov.vectors[: found.size]).T @ found)


def _multipliers(march: PeriodMarch, x: Array, after: Array, vibration: float) -> NDArray[np.complex128]:
    """Eigenvalues of Φ in the Krylov space of a random disturbance of motion and velocity, which leaves stuck sliders alone."""
    modes = march.model.mass.size
    first = np.concatenate([np.random.default_rng(0).normal(size=2 * modes), np.zeros(x.size - 2 * modes)])
    derivative, settled = Differences(march, x, after, vibration), 0
    krylov = Krylov(derivative, first)
    while True:
        krylov.grow()
        H = krylov.matrix
        if not np.all(np.isfinite(H)) or derivative.kink > KINK:
            return np.empty(0, dtype=complex)
        values, vectors = np.linalg.eig(H[:-1])
        order = np.argsort(-np.abs(values))
        leading = order[0]
        residual = H[-1, -1] * abs(vectors[-1, leading]) / np.linalg.norm(vectors[:, leading])
        settled = settled + 1 if residual <= SETTLED * max(abs(values[leading]), 1.0) else 0
        size = H.shape[1]
        if krylov.exhausted or size >= min(MOST_VECTORS, x.size) or (size >= FEWEST_VECTORS and settled >= 2):
            return np.asarray(values[order], dtype=complex)
