"""Steady cycles of a damper between platforms: repeated passes of the prescribed motion until the forces repeat.

First the pull is laid on, with the platforms at rest; then a lead-in takes them to the start of the cycle; then cycles follow.
Rotations are scaled inside by the distance of the contacts from the mass centre.
"""

from dataclasses import dataclass, replace
from enum import IntEnum
from functools import cached_property

import numpy as np

from stickslip.model.contact.law import SLIDERS
from stickslip.model.contact.point import ContactTable
from stickslip.model.dampers.between_platforms import LEFT, RIGHT, BetweenPlatforms
from stickslip.solve.platforms import march
from stickslip.solve.time.period import Method
from stickslip.support.checks import Array, fault

LEAD_IN = 50
"""Steps in which the platforms go from rest to the start of the cycle where it does not start at rest."""


class CycleOutcome(IntEnum):
    """How a search for a steady cycle ended."""

    STEADY = 0
    NOT_STEADY = 1
    JAMMED = 2
    NOT_CONVERGED = 3


@dataclass(frozen=True, eq=False)
class SteadyCycle:
    """The last cycle: record from the state before its first step on (rotations in rad), platform motion d (steps, rows), state
    at its end, cycles marched, outcome, and the change of the forces from the cycle before, relative to the largest force."""

    record: march.Record
    drive: Array
    state: march.PlatformState
    cycles: int
    outcome: CycleOutcome
    change: float

    def path(self, model: "CycleModel") -> march.Record:
        """The record with the state at the end, (steps + 1, ...): along it work is done, whether the cycle closes or not."""
        end, of_own_step = _in_radians(model, standing(model, self.state)), model.table.kind != SLIDERS
        own = np.repeat(of_own_step, np.diff(model.table.first_row))
        end.force[0, own] = self.record.force[0, own]
        return _joined(self.record, end)


@dataclass(frozen=True, eq=False)
class CycleModel:
    """A damper between platforms as arrays: contact table, B of the unknowns and of the left and right platform (rows, ...),
    M, C, K, static load, and the length that rotations are scaled by; names of the contacts whose law depends on the velocity.
    `with_parameters` changes the contacts for a fit."""

    table: ContactTable
    B: Array
    left: Array
    right: Array
    matrices: tuple[Array, Array, Array]
    load: Array
    length: float
    rate_dependent: tuple[str, ...] = ()

    @classmethod
    def of(cls, rig: BetweenPlatforms) -> "CycleModel":
        """The arrays of a rig."""
        length = float(np.mean([np.hypot(*point.arm) for point in rig.points]))
        size = np.ones(len(rig.free))
        size[2] = 1.0 / length
        M, C, K = (size[:, None] * matrix * size for matrix in rig.matrices)
        dependent = tuple(p.name for p, law in zip(rig.points, rig.laws, strict=True) if not law.rate_independent)
        B, sides = rig.rows(rig.free) * size, (rig.rows(LEFT), rig.rows(RIGHT))
        return cls(rig.table, B, *sides, (M, C, K), rig.pull * size, length, dependent)

    def with_parameters(self, kt: Array, kn: Array, mu: Array) -> "CycleModel":
        """A copy with other kt, kn [N/m] and mu of macroslip contacts, (contacts,) each: a microsecond's work, for fits."""
        table = self.table._replace(
            stiffness=np.asarray(kt, dtype=float),
            normal_stiffness=np.asarray(kn, dtype=float),
            friction=np.asarray(mu, dtype=float),
        )
        return replace(self, table=table)

    @cached_property
    def stiffness(self) -> Array:
        """K_c: kt and kn of each row with every element closed and stuck, (rows,)."""
        table, found = self.table, np.zeros(self.B.shape[0])
        for c, row in enumerate(table.normal_row):
            found[row] = table.normal_stiffness[table.normal_first[c] : table.normal_first[c + 1]].sum()
            for r in range(table.first_row[c], table.first_row[c + 1]):
                if r != row:
                    found[r] = table.stiffness[table.friction_first[r] : table.friction_first[r + 1]].sum()
        return found

    def bodies(self, A: Array, share: float = 1.0) -> march.Bodies:
        """The bodies with the matrix A of a step."""
        normal = np.repeat(self.table.normal_row, np.diff(self.table.first_row))
        contacts = self.B.T @ (self.stiffness[:, None] * self.B)
        B = np.ascontiguousarray(self.B)
        return march.Bodies(B, self.stiffness, normal.astype(np.int64), np.ascontiguousarray(A), A + share * contacts, share)

    def stuck_stiffness(self) -> Array:
        """(2, 2) [N/m]: H and V on the right platform per relative motion of the platforms while every contact sticks."""
        K = self.matrices[2]
        inner = K + self.B.T @ (self.stiffness[:, None] * self.B)
        coupling = self.B.T @ (self.stiffness[:, None] * self.left)
        own = self.left.T @ (self.stiffness[:, None] * self.left)
        return np.asarray(own - coupling.T @ np.linalg.solve(inner, coupling))

    def virgin(self, offsets: Array | float = 0.0) -> march.PlatformState:
        """Platforms at rest, no pull; sliders of all elements at `offsets` [m]."""
        size, elements, w = self.load.size, self.table.stiffness.size, np.zeros(self.B.shape[0])
        intercept = -self.table.stiffness * np.broadcast_to(np.asarray(offsets, float), elements)
        zero = [np.zeros(size) for _ in range(5)]
        limit = slip_limits(self.table, normal_forces(self.table, w))
        return march.PlatformState(zero[0], zero[1], zero[2], zero[3], intercept, w.copy(), zero[4], w, limit)


@dataclass(frozen=True)
class Marching:
    """How to look for a steady cycle: tolerance of the change of forces from cycle to cycle, relative to the largest; the most
    cycles; the method in time with its frequency [Hz], or None for quasi-static."""

    tolerance: float = 1e-9
    cycles: int = 100
    method: Method | None = None
    frequency: float = 0.0


QUASI_STATIC = Marching()


def steady_cycle(
    model: CycleModel, platform: Array, marching: Marching = QUASI_STATIC, start: march.PlatformState | None = None
) -> SteadyCycle:
    """The steady cycle under platform motion (steps, 2) [m], from virgin sliders unless a state is given (it is not changed)."""
    if marching.method is None and model.rate_dependent:
        raise fault(
            "frequency",
            f"must be given with a method in time, since the law of {model.rate_dependent[0]} depends on the velocity",
            None,
            "A quasi-static cycle has no velocity: give method=GeneralisedAlpha() and a frequency.",
        )
    drive = np.ascontiguousarray(np.asarray(platform, dtype=float) @ model.left.T)
    state = model.virgin() if start is None else march.PlatformState(*(part.copy() for part in start))
    steps = drive.shape[0]
    shape = (model.B.shape[0], state.intercept.size, model.load.size)
    carry = _carrier(model, marching, steps)
    if _settle(model, drive, state) > 0:
        unsolved = march.new_record(steps, *shape)
        unsolved.iterations[:] = -1
        return SteadyCycle(unsolved, drive, state, 0, CycleOutcome.NOT_CONVERGED, np.inf)
    spectrum = np.fft.rfft(drive, axis=0)
    rates = 2.0j * np.pi * marching.frequency * np.arange(spectrum.shape[0])[:, None]
    speed = np.fft.irfft(rates * spectrum, steps, axis=0)  # of the platforms, m/s
    path = march.Path(np.roll(drive, -1, axis=0), np.roll(speed, -1, axis=0), np.ones(steps))
    previous, record, change = march.new_record(steps, *shape), march.new_record(steps, *shape), np.inf
    for cycle in range(1, marching.cycles + 1):
        before = standing(model, state)
        if cycle > 1:
            before.force[0] = record.force[-1]
        previous, record = record, previous
        if carry(path, state, record) > 0:
            return SteadyCycle(_shown(model, before, record), drive, state, cycle, CycleOutcome.NOT_CONVERGED, change)
        change = float(np.max(np.abs(record.force - previous.force)) / (np.max(np.abs(record.force)) + 1e-300))
        if cycle > 1 and change <= marching.tolerance:
            return SteadyCycle(_shown(model, before, record), drive, state, cycle, CycleOutcome.STEADY, change)
    return SteadyCycle(_shown(model, before, record), drive, state, marching.cycles, CycleOutcome.NOT_STEADY, change)


def _carrier(model: CycleModel, marching: Marching, steps: int):  # type: ignore[no-untyped-def]
    """The compiled loop for the method."""
    M, C, K = model.matrices
    if marching.method is None:
        bodies, few = model.bodies(K), march.enumerable(model.table)
        return lambda path, state, record: march.carry_quasi_static(bodies, model.table, model.load, path, state, record, few)
    method = marching.method.coefficients
    step = 1.0 / (marching.frequency * steps)
    share = 1.0 - method.force_weight
    A = (1.0 - method.mass_weight) / (method.beta * step**2) * M + share * (method.gamma / (method.beta * step) * C + K)
    bodies, inertia = model.bodies(A, share), march.Inertia(M, C, K, method, step)
    return lambda path, state, record: march.carry_in_time(bodies, model.table, model.load, path, inertia, state, record)


def _settle(model: CycleModel, drive: Array, state: march.PlatformState) -> int:
    """Lay the pull on at rest, unless the state carries it already, then lead the platforms to the start of the cycle."""
    waypoints, loads = [], []
    if not np.any(state.motion):
        state.motion[:] = 1e-3 * np.linalg.solve(model.bodies(model.matrices[2]).stuck, model.load)
        state.before[:] = state.motion
        waypoints.append(state.drive[None])
        loads.append(np.ones(1))
    if np.any(drive[0] != state.drive):
        share = np.arange(1, LEAD_IN + 1)[:, None] / LEAD_IN
        waypoints.append(state.drive + share * (drive[0] - state.drive))
        loads.append(np.ones(LEAD_IN))
    if not waypoints:
        return 0
    drives = np.concatenate(waypoints)
    path = march.Path(drives, np.zeros_like(drives), np.concatenate(loads))
    record = march.new_record(path.load.size, model.B.shape[0], state.intercept.size, model.load.size)
    bodies, few = model.bodies(model.matrices[2]), march.enumerable(model.table)
    failed = march.carry_quasi_static(bodies, model.table, model.load, path, state, record, few)
    state.force[:] = model.B.T @ record.force[-1]
    return failed


def normal_forces(table: ContactTable, w: Array) -> Array:
    """N_e of every normal element at motion w (rows,), N."""
    press = np.repeat(w[table.normal_row], np.diff(table.normal_first))
    return np.maximum(table.normal_stiffness * press + table.normal_constant, 0.0)


def slip_limits(table: ContactTable, normal: Array) -> Array:
    """L of every friction element for normal element forces, N."""
    loads = np.append(0.0, np.cumsum(normal))
    line = table.friction * (loads[table.load_last] - loads[table.load_first]) + table.constant_limit
    element = np.repeat(np.arange(line.size), np.diff(table.bend_first))
    beyond = table.change * np.maximum(line[element] - table.bend, 0.0)
    return np.asarray(line + np.bincount(element, beyond, line.size))


def standing(model: CycleModel, state: march.PlatformState) -> march.Record:
    """A state as a record of one sample; nothing is solved: friction is what the springs hold."""
    table = model.table
    w = model.B @ state.motion + state.drive
    normal = normal_forces(table, w)
    stretched = table.stiffness * np.repeat(w, np.diff(table.friction_first))
    traction = np.where(table.stiffness > 0.0, state.intercept + stretched, 0.0)
    force = np.add.reduceat(np.append(traction, 0.0), table.friction_first[:-1])
    force[table.normal_row] = np.add.reduceat(normal, table.normal_first[:-1])
    limit = slip_limits(table, normal)
    iterations = np.zeros(1, dtype=np.int64)
    return march.Record(state.motion[None].copy(), w[None], force[None], state.intercept[None].copy(), limit[None], iterations)


def _shown(model: CycleModel, before: march.Record, record: march.Record) -> march.Record:
    """The record from sample 0 on, with rotations in rad: it was filled from sample 1 to sample 0 of the next cycle. Sample 0 is
    the state before the first step, which a cycle that does not close has left for good; its iterations are the last step's."""
    shown = march.Record._make(part[:-1] for part in _joined(before, record))
    return _in_radians(model, shown._replace(iterations=np.roll(record.iterations, 1)))


def _joined(first: march.Record, then: march.Record) -> march.Record:
    return march.Record._make(np.concatenate(parts) for parts in zip(first, then, strict=True))


def _in_radians(model: CycleModel, record: march.Record) -> march.Record:
    motion = record.motion.copy()
    motion[:, 2] /= model.length
    return record._replace(motion=motion)
