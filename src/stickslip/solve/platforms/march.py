"""Compiled march of a damper through cycles of platform motion, in quasi-static or dynamic steps.

Quasi-static steps start from the extrapolated motion; where Newton fails, from the last one; where it fails again, the states of
a few contacts are enumerated, and with more of them the step is taken in ever smaller parts.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from stickslip.model.contact.table import ContactTable
from stickslip.solve.platforms.step import Bodies, Workspace, find_states, solve_step, workspace
from stickslip.solve.time.contact_law import Earlier
from stickslip.solve.time.model import Coefficients
from stickslip.support.checks import Array, Index
from stickslip.support.kernels import inlined, kernel

FINEST = 1e-3
"""The smallest part of a step that is tried."""

JUMPS = 400
"""Starts from which an equilibrium is looked for when none lies near the last one."""


class PlatformState(NamedTuple):
    """Between two steps, changed in place: motion, velocity, acceleration (n,), force Bᵀf on the bodies (n,), intercepts
    T − kt u (elements,), platform part d (rows,), motion of the step before (n,); w (rows,) and limits (elements,) reached."""

    motion: Array
    velocity: Array
    acceleration: Array
    force: Array
    intercept: Array
    drive: Array
    before: Array
    w: Array
    limit: Array


class Path(NamedTuple):
    """What happens over some steps: d and its speed, which counts in time alone (steps, rows), the load's factor (steps,)."""

    drive: Array
    speed: Array
    load: Array


class Record(NamedTuple):
    """What is kept of every step: motion (steps, n), w and f (steps, rows), intercept and limit (steps, elements), and Newton's
    iterations (steps,), −1 where it failed."""

    motion: Array
    w: Array
    force: Array
    intercept: Array
    limit: Array
    iterations: Index


class Inertia(NamedTuple):
    """M, C, K (n, n), the coefficients of the method and the step h [s]; without inertia h = 0."""

    M: Array
    C: Array
    K: Array
    method: Coefficients
    step: float


def new_record(steps: int, rows: int, elements: int, size: int) -> Record:
    """A record to be filled."""
    motion, w, force = (np.zeros((steps, count)) for count in (size, rows, rows))
    intercept, limit = (np.zeros((steps, elements)) for _ in range(2))
    return Record(motion, w, force, intercept, limit, np.zeros(steps, dtype=np.int64))


@kernel
def carry_quasi_static(
    bodies: Bodies, table: ContactTable, load: Array, path: Path, state: PlatformState, record: Record, few: bool
) -> int:
    """Carry the bodies along a path without inertia; returns the number of steps in which Newton failed, and stops there.

    A state without motion carries no load yet. few: contacts of which `find_states` can take over from Newton.
    """
    work = workspace(bodies.B.shape[0], state.intercept.size, load.size)
    last = path.load[0] if np.any(state.motion) else 0.0
    for k in range(path.drive.shape[0]):
        iterations = _quasi_static_step(bodies, table, load, last, path.load[k], path.drive[k], state, work, few)
        record.iterations[k] = iterations
        if iterations < 0:
            return 1
        last = path.load[k]
        _keep(record, k, state, work, iterations)
    return 0


@inlined
def _quasi_static_step(
    bodies: Bodies,
    table: ContactTable,
    load: Array,
    last: float,
    level: float,
    goal: Array,
    state: PlatformState,
    work: Workspace,
    few: bool,
) -> int:
    """One step to platform part `goal` and load factor `level`, whole or in parts; Newton's iterations, −1 when it fails."""
    q, start = np.empty_like(load), state.drive.copy()
    total, done, part = 0, 0.0, 1.0
    before = Earlier(state.intercept, state.w, state.limit, np.zeros(state.w.size), 0.0, False, 0.0)
    while done < 1.0:
        target = min(done + part, 1.0)
        drive = start + target * (goal - start)
        right = (last + target * (level - last)) * load
        iterations = -1
        for attempt in range(0 if part == 1.0 else 1, 3 if few else 2):
            if attempt == 0:
                q[:] = 2.0 * state.motion - state.before
            elif attempt == 1:
                q[:] = state.motion
            elif not find_states(bodies, table, drive, right, state.intercept, state.motion, q):
                break
            iterations = solve_step(bodies, table, drive, right, before, q, work)
            if iterations >= 0:
                break
        if iterations < 0 and not few:
            if part > FINEST:
                part *= 0.5
                continue
            iterations = _jump(bodies, table, drive, right, state, before, q, work)
        if iterations < 0:
            return -1
        total, done, part = total + iterations, target, 2.0 * part
        state.before[:], state.motion[:] = state.motion, q
        _remember(state, work)
    state.drive[:] = goal
    return total


@inlined
def _jump(
    bodies: Bodies,
    table: ContactTable,
    drive: Array,
    right: Array,
    state: PlatformState,
    before: Earlier,
    q: Array,
    work: Workspace,
) -> int:
    """Where no equilibrium lies near the last one, the damper snaps to another: look from starts that fill a box of the size of
    its motion under the load (a lattice of the generalised golden ratio). Returns Newton's iterations, −1 when none is found."""
    size = q.size
    reach = np.abs(np.linalg.solve(bodies.stuck, right)) + np.abs(state.motion)
    ratio = 2.0
    for _ in range(40):
        ratio = (1.0 + ratio) ** (1.0 / (size + 1))
    for attempt in range(JUMPS):
        for i in range(size):
            share = (0.5 + (attempt + 1) * ratio ** -(i + 1)) % 1.0
            q[i] = state.motion[i] + (4.0 * share - 2.0) * reach.max()
        iterations = solve_step(bodies, table, drive, right, before, q, work)
        if iterations >= 0:
            return iterations
    return -1


@inlined
def _remember(state: PlatformState, work: Workspace) -> None:
    """What the contacts remember of a step."""
    state.intercept[:], state.w[:], state.limit[:] = work.intercept, work.w, work.limit


@inlined
def _keep(record: Record, k: int, state: PlatformState, work: Workspace, iterations: int) -> None:
    record.motion[k], record.w[k], record.force[k] = state.motion, work.w, work.force
    record.intercept[k], record.limit[k], record.iterations[k] = work.intercept, work.limit, iterations


@kernel
def carry_in_time(
    bodies: Bodies, table: ContactTable, load: Array, path: Path, inertia: Inertia, state: PlatformState, record: Record
) -> int:
    """Carry the bodies along a path in equal time steps; returns the number of failed steps, and stops there."""
    work = workspace(bodies.B.shape[0], state.intercept.size, load.size)
    q, drift = np.empty_like(load), np.empty_like(state.w)
    h, (am, af, beta, gamma) = inertia.step, inertia.method
    before = Earlier(state.intercept, state.w, state.limit, drift, gamma / (beta * h), False, h)
    for k in range(path.drive.shape[0]):
        a = -(state.motion + h * state.velocity) / (beta * h * h) - (0.5 / beta - 1.0) * state.acceleration
        v = state.velocity + h * ((1.0 - gamma) * state.acceleration + gamma * a)
        right = path.load[k] * load - af * state.force - af * (inertia.K @ state.motion)
        right -= inertia.M @ ((1.0 - am) * a + am * state.acceleration)
        right -= inertia.C @ ((1.0 - af) * v + af * state.velocity)
        # w = B q + d moves at B q' + d', and q' = v + γ/(βh) q.
        drift[:] = bodies.B @ v + path.speed[k] - before.rate * path.drive[k]
        iterations = -1
        for attempt in range(2):
            q[:] = state.motion + (0.0 if attempt else h) * state.velocity
            iterations = solve_step(bodies, table, path.drive[k], right, before, q, work)
            if iterations >= 0:
                break
        if iterations < 0:
            record.iterations[k] = -1
            return 1
        acceleration = q / (beta * h * h) + a
        state.velocity[:] += h * ((1.0 - gamma) * state.acceleration + gamma * acceleration)
        state.acceleration[:] = acceleration
        state.before[:], state.motion[:] = state.motion, q
        state.force[:] = bodies.B.T @ work.force
        state.drive[:] = path.drive[k]
        _remember(state, work)
        _keep(record, k, state, work, iterations)
    return 0
