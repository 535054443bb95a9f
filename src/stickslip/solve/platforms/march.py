"""Compiled march of a damper through cycles of platform motion, in quasi-static or dynamic steps.

Quasi-static steps start from the extrapolated motion; where Newton fails, from the last one; where it fails again, the states of
a few contacts are enumerated, and with more of them the step is taken in ever smaller parts.

One step of bodies with contacts whose other side moves as prescribed, by Newton's method on the motion of the bodies.

A q + φ Bᵀ f(B q + d) = g with w = B q + d, d the prescribed part. Quasi-static: A = K, φ = 1, g = load. In time: A is the
effective matrix of the step and φ = 1 − αf (`solve/time/period.py`). Where a nearly open contact leaves the matrix singular,
the direction comes from the matrix plus a part of the stuck one: still downhill, and of the size of the stuck motion.

Equilibrium of a few macroslip contacts by enumeration of all contact states, a safe fallback for Newton's method.

With each contact stuck, slipping either way or open, the step is a linear system; of the solutions that agree with their own
states the one nearest to the last motion counts. 4 to the power of the contacts combinations, so for a few contacts only.
"""

from typing import NamedTuple

import numpy as np

from stickslip.model.contact.law import SLIDERS
from stickslip.model.contact.point import ContactTable
from stickslip.solve.time.contact_law import Earlier, Slopes, contact_law, no_slopes, solve_in_place
from stickslip.solve.time.period import Coefficients
from stickslip.support.checks import Array, Index
from stickslip.support.kernels import inlined, inner, kernel

TOLERANCE = 1e-12
"""Residual of a step relative to load and contact forces."""

FLOOR = 1e-9
"""Residual that is still accepted where rounding lets no step reduce it further."""

ITERATIONS = 40
PATIENCE = 6
"""How many times Newton takes its whole step although no part of it reduces the residual: on the way over a kink."""

UNIT = 1e4
"""The matrix is divided by this times its largest stuck entry: a pivot below 1e-9 of that entry then counts as singular."""


class Bodies(NamedTuple):
    """B (rows, n), stuck stiffness K_c (rows,), the row of the normal direction of each row's contact (rows,), A (n, n), its
    stuck matrix A + φ BᵀK_cB, and φ. Rotations are scaled so that all unknowns are metres of one size."""

    B: Array
    stiffness: Array
    normal: Index
    A: Array
    stuck: Array
    share: float


class Workspace(NamedTuple):
    """Arrays that a step fills: w, f (rows,), intercept, limit (elements,), slopes; residual, change, trial (n,); matrix."""

    w: Array
    force: Array
    intercept: Array
    limit: Array
    slopes: Slopes
    residual: Array
    change: Array
    trial: Array
    matrix: Array


@inner
def workspace(rows: int, elements: int, size: int) -> Workspace:
    """Fresh arrays."""
    return Workspace(
        np.zeros(rows),
        np.zeros(rows),
        np.zeros(elements),
        np.zeros(elements),
        no_slopes(rows),
        np.zeros(size),
        np.zeros(size),
        np.zeros(size),
        np.zeros((size, size)),
    )


@inner
def residual_of(
    bodies: Bodies, table: ContactTable, q: Array, drive: Array, right: Array, before: Earlier, work: Workspace
) -> float:
    """Fill w, forces, intercepts, limits, slopes and A q + φ Bᵀf − g; returns its norm."""
    rows, size = bodies.B.shape
    for r in range(rows):
        total = drive[r]
        for i in range(size):
            total += bodies.B[r, i] * q[i]
        work.w[r] = total
    contact_law(table, work.w, before, work.intercept, work.limit, work.slopes)
    for r in range(rows):
        work.force[r] = work.slopes.target[r] + bodies.stiffness[r] * work.w[r]
    square = 0.0
    for i in range(size):
        total = -right[i]
        for j in range(size):
            total += bodies.A[i, j] * q[j]
        for r in range(rows):
            total += bodies.share * bodies.B[r, i] * work.force[r]
        work.residual[i] = total
        square += total * total
    return float(np.sqrt(square))


@inner
def _scale(bodies: Bodies, right: Array, work: Workspace) -> float:
    total = 0.0
    for i in range(right.size):
        total += right[i] * right[i]
    for r in range(work.force.size):
        total += work.force[r] * work.force[r] + (1e-3 * bodies.stiffness[r] * work.w[r]) ** 2
    return float(np.sqrt(total) + 1e-300)


@inner
def _direction(bodies: Bodies, work: Workspace) -> None:
    """Newton's change of q; with a growing part of the stuck matrix where the tangent one is singular."""
    rows, size = bodies.B.shape
    largest = 0.0
    for i in range(size):
        largest = max(largest, UNIT * bodies.stuck[i, i])
    added = 0.0
    for _ in range(12):
        for i in range(size):
            for j in range(size):
                work.matrix[i, j] = (bodies.A[i, j] + added * bodies.stuck[i, j]) / largest
        for r in range(rows):
            own, coupling, n = bodies.stiffness[r] + work.slopes.own[r], work.slopes.coupling[r], bodies.normal[r]
            for i in range(size):
                left = bodies.share * bodies.B[r, i] / largest
                for j in range(size):
                    value = own * bodies.B[r, j]
                    if n >= 0 and n != r:
                        value += coupling * bodies.B[n, j]
                    work.matrix[i, j] += left * value
        for i in range(size):
            work.change[i] = -work.residual[i] / largest
        if solve_in_place(work.matrix, work.change):
            return
        added = max(1e-6, 8.0 * added)
    for i in range(size):
        work.change[i] = 0.0


@inner
def solve_step(
    bodies: Bodies, table: ContactTable, drive: Array, right: Array, before: Earlier, q: Array, work: Workspace
) -> int:
    """Solve one step from the start in q (n,), which becomes the solution. Returns the iterations, −1 where Newton fails."""
    size = residual_of(bodies, table, q, drive, right, before, work)
    patience = PATIENCE
    for iteration in range(ITERATIONS):
        if size <= TOLERANCE * _scale(bodies, right, work):
            return iteration
        _direction(bodies, work)
        length, found, reduced = 1.0, size, False
        work.trial[:] = q
        for _ in range(12):
            q[:] = work.trial + length * work.change
            found = residual_of(bodies, table, q, drive, right, before, work)
            if found < (1.0 - 1e-4 * length) * size:
                reduced = True
                break
            length *= 0.5
        if not reduced:
            q[:] = work.trial
            found = residual_of(bodies, table, q, drive, right, before, work)
            if size <= FLOOR * _scale(bodies, right, work):
                return iteration
            patience -= 1
            if patience < 0:
                return -1
            _direction(bodies, work)
            q[:] = work.trial + work.change
            found = residual_of(bodies, table, q, drive, right, before, work)
        if not np.isfinite(found):
            return -1
        size = found
    return -1


MOST_CONTACTS = 6
"""Of which every combination of states is tried."""

SLACK = 1e-9
"""How far a force may lie beyond its limit, relative to the load: rounding."""


def enumerable(table: ContactTable) -> bool:
    """Whether every contact is one Jenkins element over one normal spring, with a constant coefficient, and there are few."""
    contacts = table.normal_row.size
    plain = np.all(np.diff(table.first_row) == 2) and np.all(table.normal_row == table.first_row[:-1] + 1)
    single = table.stiffness.size == contacts and table.normal_stiffness.size == contacts
    return bool(
        contacts <= MOST_CONTACTS
        and plain
        and single
        and not np.any(table.constant_limit)
        and not table.bend.size
        and np.all(table.kind == SLIDERS)
    )


@inner
def find_states(bodies: Bodies, table: ContactTable, drive: Array, right: Array, before: Array, near: Array, q: Array) -> bool:
    """The equilibrium nearest to the motion `near` goes into q; False where no combination of states has one."""
    contacts, size = table.normal_row.size, q.size
    rows = np.zeros((2 * contacts, size + 1))
    matrix, trial = np.empty((size, size)), np.empty(size)
    unit, best = UNIT * np.diag(bodies.stuck).max(), np.inf
    slack = SLACK * np.sqrt(np.sum(right * right))
    for code in range(4**contacts):
        _force_rows(bodies, table, drive, before, code, rows)
        for i in range(size):
            trial[i] = right[i] / unit
            for j in range(size):
                matrix[i, j] = bodies.A[i, j] / unit
            for r in range(2 * contacts):
                part = bodies.share * bodies.B[r, i] / unit
                trial[i] -= part * rows[r, size]
                for j in range(size):
                    matrix[i, j] += part * rows[r, j]
        if not solve_in_place(matrix, trial):
            continue
        distance = np.sum((trial - near) ** 2)
        if distance < best and _agrees(bodies, table, drive, before, code, trial, slack):
            best = distance
            q[:] = trial
    return best < np.inf


@inner
def _force_rows(bodies: Bodies, table: ContactTable, drive: Array, before: Array, code: int, rows: Array) -> None:
    """Forces as rows · (q, 1), in the states of the code: digits to base 4 are stick, slip up, slip down, open."""
    size = rows.shape[1] - 1
    for c in range(table.normal_row.size):
        state, code = code % 4, code // 4
        t, n = 2 * c, 2 * c + 1
        kn, kt = table.normal_stiffness[c], table.stiffness[c]
        closed = 0.0 if state == 3 else 1.0
        sense = 1.0 if state == 1 else (-1.0 if state == 2 else 0.0)
        for j in range(size):
            rows[n, j] = closed * kn * bodies.B[n, j]
            rows[t, j] = kt * bodies.B[t, j] if state == 0 else sense * table.friction[c] * rows[n, j]
        rows[n, size] = closed * (kn * drive[n] + table.normal_constant[c])
        rows[t, size] = kt * drive[t] + before[c] if state == 0 else sense * table.friction[c] * rows[n, size]


@inner
def _agrees(bodies: Bodies, table: ContactTable, drive: Array, before: Array, code: int, q: Array, slack: float) -> bool:
    """Whether the motion q leads to the states of the code."""
    for c in range(table.normal_row.size):
        state, code = code % 4, code // 4
        u, z = drive[2 * c] + np.sum(bodies.B[2 * c] * q), drive[2 * c + 1] + np.sum(bodies.B[2 * c + 1] * q)
        force = table.normal_stiffness[c] * z + table.normal_constant[c]
        trial, limit = before[c] + table.stiffness[c] * u, table.friction[c] * force
        if state == 3:
            if force > slack:
                return False
            continue
        if force < -slack:
            return False
        if (
            (state == 0 and abs(trial) > limit + slack)
            or (state == 1 and trial < limit - slack)
            or (state == 2 and trial > slack - limit)
        ):
            return False
    return True


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
