"""The true periodic motion beside a solution of the harmonic balance, by Newton's method on the exact march, and its multipliers.

Of few harmonics, or where contacts are stiff or lift off, a solution of the balance is not quite a motion, and its own contact
events may say more or less than those of the motion. So stability is read from the motion itself, and only where it is near.
"""

from __future__ import annotations

from contextlib import suppress
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from stickslip.solve.balance.balance import Evaluation, HarmonicBalance
from stickslip.solve.stability.event_march import EventMarch, LostMotionError, Passage, State
from stickslip.solve.time.start import TimeStart, from_harmonics
from stickslip.support.checks import Array

CORRECTIONS = 12

CLOSED = 1e-6
"""Change over a period, relative to the vibration, at which a motion is periodic."""

SHORTEST = 1.0 / 16.0
"""Share of a correction below which none helps."""

DIFFERENCE, PUSH = 1e-5, 1e-3
"""Sizes of disturbances relative to the vibration: of a one-sided derivative, and of one that is followed."""

PERIODS = 30
"""That a disturbed motion is followed for."""

SAMPLES = 64
"""Of a period, at which the motion is compared with the solution."""


@dataclass(frozen=True, eq=False)
class Orbit:
    """begin: state at t = 0; defect: what a period changes of it, relative to the vibration; distance: from the solution, root
    mean square over the period, weighted with the masses, relative to that of the vibration.

    multipliers: largest first, without those of exactly 1 of the `exact_ones` sliders that never slip; vector (states,): a
    disturbance in the space of the largest, and adjoint (states,), which measures how much of a disturbance is, in units of
    `scale`.
    """

    begin: State
    defect: float
    distance: float
    multipliers: NDArray[np.complex128]
    exact_ones: int
    vector: Array
    adjoint: NDArray[np.complex128]
    scale: Array

    @property
    def closed(self) -> bool:
        return self.defect <= CLOSED

    @property
    def leading(self) -> complex:
        """The largest multiplier, with positive imaginary part of a pair; 0 without one."""
        values = self.multipliers
        return complex(values[0].real, abs(values[0].imag)) if values.size else 0j


class OrbitSearch:
    """Orbits beside solutions of one balance."""

    def __init__(self, march: EventMarch, balance: HarmonicBalance) -> None:
        self.march, self.balance = march, balance

    def beside(self, evaluation: Evaluation) -> Orbit | None:
        """The periodic motion beside a solution; None where a period cannot be followed."""
        point, coordinates = evaluation.point, self.march.coordinates
        rows = np.abs(evaluation.w[: self.balance.rows, 1:]).sum(axis=1)
        motions = np.abs(evaluation.w[: self.balance.rows, 0]) + rows
        self.march.at(point.omega, point.level, motions)
        start = from_harmonics(self.balance, point.forces, point.omega, point.level)
        motion = coordinates.weight @ self.balance.linear.whole_motion(point.forces, point.omega, point.level)
        size = float(np.linalg.norm(motion[:, 1:]))
        k, kt = coordinates.size, self.march.table.stiffness
        scale = np.concatenate(
            [np.full(k, size), np.full(k, size * point.omega), kt * max(float(rows.max(initial=0.0)), np.finfo(float).tiny)]
        )
        sizes = scale, motion
        found: Orbit | None = None
        for settled in (True, False):
            with suppress(LostMotionError):
                found = self._closed(self._state(start), *sizes, settled=settled)
                if found.closed:
                    break
        return found

    def _state(self, start: TimeStart) -> State:
        weight = self.march.coordinates.weight
        return State(np.concatenate([weight @ start.motion, weight @ start.velocity]), start.intercepts)

    def _closed(self, first: State, scale: Array, motion: Array, settled: bool) -> Orbit:
        """Newton's method on P(x) − x = 0 from a state on, or from that after a period in which sliders find their places."""
        x = _packed(self.march.travel(first).end if settled else first)
        passage = self._passage(x)
        left = self._defect(x, passage, scale)
        for _ in range(CORRECTIONS):
            if np.linalg.norm(left) <= 1e-3 * CLOSED:
                break
            own = self._free(passage)
            assert passage.derivative is not None
            matrix = (np.eye(x.size) - passage.derivative * scale / scale[:, None])[np.ix_(own, own)]
            change = np.zeros(x.size)
            change[own] = np.linalg.lstsq(matrix, left[own], rcond=1e-10)[0] * scale[own]
            length, better = 1.0, None
            while length >= SHORTEST:
                trial = x + length * change
                passage_there = self._passage(trial)
                there = self._defect(trial, passage_there, scale)
                if np.linalg.norm(there) < (1.0 - 0.1 * length) * np.linalg.norm(left):
                    better = trial, passage_there, there
                    break
                length *= 0.5
            if better is None:
                if np.linalg.norm(left) <= CLOSED:
                    break
                x = _packed(passage.end)
                passage = self._passage(x)
                better = x, passage, self._defect(x, passage, scale)
            x, passage, left = better
        return self._orbit(motion, x, passage, left, scale)

    def _passage(self, x: Array) -> Passage:
        return self.march.travel(self._unpacked(x), derivative=True)

    def _unpacked(self, x: Array) -> State:
        size = 2 * self.march.coordinates.size
        return State(x[:size], x[size:])

    def _free(self, passage: Passage) -> NDArray[np.bool_]:
        """The states that a period moves: not the sliders that stick all the time."""
        return np.concatenate([np.ones(2 * self.march.coordinates.size, dtype=bool), passage.moved])

    def _defect(self, x: Array, passage: Passage, scale: Array) -> Array:
        """What a period changes, in units of the vibration."""
        return np.where(self._free(passage), (_packed(passage.end) - x) / scale, 0.0)

    def _orbit(self, motion: Array, x: Array, passage: Passage, left: Array, scale: Array) -> Orbit:
        own = self._free(passage)
        assert passage.derivative is not None
        matrix = (passage.derivative * scale / scale[:, None])[np.ix_(own, own)]
        values, vectors = np.linalg.eig(matrix)
        order = np.argsort(-np.abs(values), kind="stable")
        vector, adjoint = np.zeros(x.size), np.zeros(x.size, dtype=complex)
        if order.size:
            one = vectors[:, order[0]]
            # Of a pair, the phase in which the real part is largest.
            one = one * np.exp(-0.5j * np.angle(np.sum(one * one)))
            vector[own] = one.real / np.linalg.norm(one.real)
            adjoint[own] = np.linalg.pinv(vectors)[order[0]]
            adjoint /= max(abs(adjoint @ vector), np.finfo(float).tiny)
        away = self._distance(x, motion)
        defect, ones = float(np.linalg.norm(left)), int(np.count_nonzero(~passage.moved))
        return Orbit(self._unpacked(x), defect, away, values[order].astype(complex), ones, vector, adjoint, scale)

    def _distance(self, x: Array, motion: Array) -> float:
        """Of the motion that begins at x from that of the solution, (k, 2H+1)."""
        path = self.march.travel(self._unpacked(x), samples=SAMPLES).path
        order, phase = np.arange(1, (motion.shape[1] + 1) // 2), 2.0 * np.pi * np.arange(1, SAMPLES + 1) / SAMPLES
        angles = np.outer(phase, order)
        vibration = np.cos(angles) @ motion[:, 1::2].T + np.sin(angles) @ motion[:, 2::2].T
        away = path - motion[:, 0] - vibration
        return float(np.linalg.norm(away) / max(float(np.linalg.norm(vibration)), np.finfo(float).tiny))

    def sides(self, orbit: Orbit) -> tuple[float, float]:
        """By how much a period multiplies a small disturbance along the vector of the largest multiplier, to either side.

        Where the motion has a derivative, both are the size of the multiplier; where a contact only touches, they need not be.
        """
        one, other = (self._after(orbit, side * DIFFERENCE * orbit.vector) for side in (1.0, -1.0))
        return self._share(orbit, one) / DIFFERENCE, self._share(orbit, other) / DIFFERENCE

    def periods_to_leave(self, orbit: Orbit, grown: float) -> int | None:
        """Periods after which a motion pushed along that vector is so many times as far away; None where it is not within
        `PERIODS`."""
        away = PUSH * orbit.vector
        for period in range(1, PERIODS + 1):
            away = self._after(orbit, away)
            if self._share(orbit, away) >= grown * PUSH:
                return period
        return None

    def _after(self, orbit: Orbit, away: Array) -> Array:
        """The disturbance a period later."""
        centre = _packed(orbit.begin)
        return np.asarray((_packed(self.march.travel(self._unpacked(centre + away * orbit.scale)).end) - centre) / orbit.scale)

    def _share(self, orbit: Orbit, away: Array) -> float:
        return float(abs(orbit.adjoint @ away))


def _packed(state: State) -> Array:
    return np.concatenate([state.motion, state.intercept])
