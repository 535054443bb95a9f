"""The steady period of a law that has a step alone, with its derivatives: a march that Newton's method makes repeat.

x_n = f(x_{n−1}, ...) over the samples is a map of a period, x → Φ(x), with A = dΦ/dx the product of the derivatives of the steps.
Its fixed point is x + (I − A)⁻¹ (Φ(x) − x), again and again; and as a change of the motion moves the fixed point too, the
derivative at the last sample is (I − A)⁻¹ times that of a march from a fixed start.
"""

from typing import NamedTuple

import numpy as np

from stickslip.model.contact.law import Law
from stickslip.model.contact.protocol import (
    NOT_PERIODIC,
    OPEN,
    SLIP,
    SLIPPING,
    STICK,
    ContactData,
    PeriodForces,
    PeriodMotion,
    StepMotion,
    clear,
    kind_of,
    law_period,
    law_step,
    no_step,
    period_signature,
    traction_by_state,
)
from stickslip.support.checks import Array, InputError
from stickslip.support.kernels import inner, kernel, separate
from stickslip.support.kernels.decorators import hold
from stickslip.support.kernels.views import view

PERIODS = 200
"""Periods after which a contact that has not become periodic is given up."""

SETTLED = 1e-10
"""What Newton's method still changes of the states, relative to their size and that of the springs, at which a period repeats:
after that change its square remains."""

ROUNDING, STALLED = 1e-7, 3
"""Change of the states over a period at which it repeats too, where so many periods in turn have not halved it: of rounding."""

SINGULAR = 1e-14
"""Determinant of I − A, relative to its entries, below which a state stays where it is."""


def prepare(*laws: type[Law]) -> None:
    """Compile the kernels of laws, or take them from disk, for the kinds of their contacts; those of sliders are ready."""
    for law in laws:
        kernels = law.kernels()
        if len(kernels) == 1 and (law.sticks or law.remembers_start):
            raise InputError(
                f"{law.__name__} must bring a kernel for its period, or declare sticks = False and remembers_start = False: "
                "where friction sticks, a march from one start does not find the others."
            )
        if kernels:
            hold(law_step, kind_of(law), kernels[0])
            hold(law_period, kind_of(law), kernels[1] if len(kernels) > 1 else marched_period)


def steady_period(law: Law, data: ContactData, motion: PeriodMotion, forces: PeriodForces) -> int:
    """`law_period` for calls from Python, of a law with kernels of its own."""
    prepare(type(law))
    return _period(kind_of(type(law)), data, motion, forces)


@kernel
def _period(kind: int, data: ContactData, motion: PeriodMotion, forces: PeriodForces) -> int:
    return law_period(kind, data, motion, forces)


class Trace(NamedTuple):
    """The answers of the steps to all samples of a period, (Nt, ...) each, as in `StepForces`; tractions (Nt, d, k): derivatives
    of the tractions by the states; work [J]: of the states."""

    state: Array
    by_state: Array
    by_travel: Array
    by_limit0: Array
    by_limit: Array
    by_time: Array
    direct: Array
    tractions: Array
    by_u: Array
    by_velocity: Array
    by_direct_limit: Array
    work: Array


@inner
def _no_trace(samples: int, k: int, d: int) -> Trace:
    n = samples
    by_state, line = np.empty((n, k, k)), (np.empty((n, k)), np.empty((n, k)), np.empty((n, k)))
    by_motion = np.empty((n, d, d)), np.empty((n, d, d)), np.empty((n, d))
    return Trace(
        np.empty((n, k)), by_state, np.empty((n, k, d)), *line, np.empty((n, d)), np.empty((n, d, k)), *by_motion, np.empty(n)
    )


@separate(period_signature)
def marched_period(data: ContactData, motion: PeriodMotion, forces: PeriodForces) -> int:
    """The steady period, marched from rest; every harmonic is unknown at all times."""
    # Through views, since numba counts the references of every array of a tuple that it passes on or takes an array from.
    trace = _no_trace(motion.limit.size, data.spring.size, data.kt.size)
    settled = _fill(view(data), view(motion), view(trace), view(forces))
    return SLIPPING if settled and trace.work.size else NOT_PERIODIC


@inner
def _fill(data: ContactData, motion: PeriodMotion, trace: Trace, forces: PeriodForces) -> bool:
    """The answer of a period, or whether there is none."""
    change, states = np.zeros((data.spring.size, 1)), data.spring.size
    for n in range(motion.limit.size):
        forces.event[n] = STICK if states == 0 else SLIP if motion.limit[n] > 0.0 else OPEN
    if not _settle(data, motion, trace, change):
        return False
    _correct(data, trace, change)
    _fill_forces(data, motion, trace, forces)
    if motion.E.shape[1]:
        _fill_derivatives(data, motion, trace, forces)
    return True


@inner
def _settle(data: ContactData, motion: PeriodMotion, trace: Trace, change: Array) -> bool:
    """March until the states repeat, and fill what then is missing of them at the last sample, (k, 1); whether they do."""
    states, least, stalled, start = data.spring.size, np.inf, 0, np.zeros(data.spring.size)
    size = np.zeros(states)
    for _ in range(PERIODS):
        _march(data, motion, start, trace)
        size[:] = 0.0
        for i in range(states):
            change[i, 0] = trace.state[-1, i] - start[i]
            for n in range(motion.limit.size):
                size[i] = max(size[i], abs(trace.state[n, i]), data.spring[i] * abs(motion.u[data.direction[i], n]))
        left = _ratio(change, size)
        _solve(np.eye(states) - _map(trace), change)
        stalled = stalled + 1 if left >= 0.5 * least else 0
        if _ratio(change, size) <= SETTLED or (left <= ROUNDING and stalled >= STALLED):
            return True
        if left < least:
            start += change[:, 0]
        else:
            start[:] = trace.state[-1]
        least = min(least, left)
    return False


@inner
def _ratio(change: Array, size: Array) -> float:
    """The largest change (k, 1) relative to a size (k,)."""
    found = 0.0
    for i in range(size.size):
        if change[i, 0] != 0.0:
            found = max(found, abs(change[i, 0]) / size[i])
    return found


@inner
def _march(data: ContactData, motion: PeriodMotion, start: Array, trace: Trace) -> None:
    """One period of steps from the states at the last sample, (k,); a step in which the contact lands begins there, with states
    of 0."""
    k, directions, samples = data.spring.size, data.kt.size, motion.limit.size
    state, travel, u, velocity = start.copy(), np.empty(directions), np.empty(directions), np.empty(directions)
    answer, step = no_step(k, directions), _time_step(motion)
    found = view(answer)
    for n in range(samples):
        before = n - 1 if n else samples - 1
        rest = 1.0 - motion.landing[before]
        for d in range(directions):
            u[d], velocity[d] = motion.u[d, n], motion.velocity[d, n]
            travel[d] = rest * (motion.u[d, n] - motion.u[d, before])
        clear(found)
        moved = StepMotion(state, travel, u, velocity, motion.limit[before], motion.limit[n], rest * step)
        trace.work[n] = law_step(data.kind, data, view(moved), found)
        for i in range(k):
            state[i] = trace.state[n, i] = found.state[i]
            trace.by_limit0[n, i], trace.by_limit[n, i], trace.by_time[n, i] = (
                found.by_limit0[i],
                found.by_limit[i],
                found.by_time[i],
            )
            for j in range(k):
                trace.by_state[n, i, j] = found.by_state[i, j]
            for d in range(directions):
                trace.by_travel[n, i, d] = found.by_travel[i, d]
                trace.tractions[n, d, i] = traction_by_state(data, found, d, i)
        for d in range(directions):
            trace.direct[n, d], trace.by_direct_limit[n, d] = found.direct[d], found.direct_by_limit[d]
            for o in range(directions):
                trace.by_u[n, d, o], trace.by_velocity[n, d, o] = found.direct_by_u[d, o], found.direct_by_velocity[d, o]
    clear(answer)  # which lives until here, as do the arrays of `moved`
    state[:], travel[:], u[:], velocity[:] = 0.0, 0.0, 0.0, 0.0


@inner
def _time_step(motion: PeriodMotion) -> float:
    """Time from sample to sample, s; 0 where nothing says how fast they pass."""
    return float(2.0 * np.pi / (motion.omega * motion.limit.size)) if motion.omega > 0.0 else 0.0


@inner
def _map(trace: Trace) -> Array:
    """The map of the states over a period, (k, k)."""
    whole = np.eye(trace.state.shape[1])
    for n in range(trace.state.shape[0]):
        _carry(trace.by_state[n], whole)
    return whole


@inner
def _carry(matrix: Array, table: Array) -> None:
    """table (k, m) becomes matrix (k, k) times it."""
    k = matrix.shape[0]
    if k == 1:
        for j in range(table.shape[1]):
            table[0, j] *= matrix[0, 0]
        return
    column = np.empty(k)
    for j in range(table.shape[1]):
        for i in range(k):
            column[i] = 0.0
            for r in range(k):
                column[i] += matrix[i, r] * table[r, j]
        for i in range(k):
            table[i, j] = column[i]


@inner
def _solve(matrix: Array, right: Array) -> None:
    """matrix⁻¹ right, (k, k) and (k, m), in place by elimination; an unknown without a pivot stays 0, as a state that nothing
    moves does."""
    size, A = matrix.shape[0], matrix.copy()
    for i in range(size):
        best = i
        for r in range(i + 1, size):
            if abs(A[r, i]) > abs(A[best, i]):
                best = r
        for j in range(size):
            A[i, j], A[best, j] = A[best, j], A[i, j]
        for j in range(right.shape[1]):
            right[i, j], right[best, j] = right[best, j], right[i, j]
        if abs(A[i, i]) <= SINGULAR:
            continue
        for r in range(i + 1, size):
            factor = A[r, i] / A[i, i]
            for j in range(i, size):
                A[r, j] -= factor * A[i, j]
            for j in range(right.shape[1]):
                right[r, j] -= factor * right[i, j]
    for i in range(size - 1, -1, -1):
        for j in range(right.shape[1]):
            total = right[i, j]
            for r in range(i + 1, size):
                total -= A[i, r] * right[r, j]
            right[i, j] = total / A[i, i] if abs(A[i, i]) > SINGULAR else 0.0


@inner
def _correct(data: ContactData, trace: Trace, change: Array) -> None:
    """Add to the states, and to what follows from them, what a change (k, 1) at the last sample of the period before does."""
    for n in range(trace.state.shape[0]):
        _carry(trace.by_state[n], change)
        for i in range(change.shape[0]):
            trace.state[n, i] += change[i, 0]
            for d in range(data.kt.size):
                own = 1.0 if data.direction[i] == d and data.spring[i] > 0.0 else 0.0
                trace.direct[n, d] += (trace.tractions[n, d, i] - own) * change[i, 0]


@inner
def _fill_forces(data: ContactData, motion: PeriodMotion, trace: Trace, forces: PeriodForces) -> None:
    """Forces, intercepts and work of all samples; with friction, what no spring carries works by the trapezoidal rule."""
    samples = motion.limit.size
    for n in range(samples):
        forces.work[0] += trace.work[n]
        for d in range(data.kt.size):
            forces.y[d, n] = trace.direct[n, d] - data.kt[d] * motion.u[d, n]
            if data.spring.size:
                moved = motion.u[d, n] - motion.u[d, n - 1]
                forces.work[d] += 0.5 * (trace.direct[n, d] + trace.direct[n - 1, d]) * moved
        for i in range(data.spring.size):
            d = data.direction[i]
            forces.intercept[i, n] = trace.state[n, i] - data.spring[i] * motion.u[d, n]
            if data.spring[i] > 0.0:
                forces.y[d, n] += trace.state[n, i]


@inner
def _fill_derivatives(data: ContactData, motion: PeriodMotion, trace: Trace, forces: PeriodForces) -> None:
    """Derivatives of y by the motion and by ω: those of the states are carried round the period from nothing, which says what
    they are at the last sample, and once more from there."""
    k, columns, samples = data.spring.size, motion.E.shape[1], motion.limit.size
    change, by_omega = np.zeros((3, k, columns)), np.zeros((k, 1))
    if k:
        for n in range(samples):
            _carry_change(data, motion, trace, n, change, by_omega)
        matrix = np.eye(k) - _map(trace)
        for part in range(3):
            _solve(matrix, change[part])
        _solve(matrix, by_omega)
    for n in range(samples):
        if k:
            _carry_change(data, motion, trace, n, change, by_omega)
        for d in range(data.kt.size):
            _fill_tangent(data, motion, trace, n, d, change, by_omega, forces)


@inner
def _carry_change(data: ContactData, motion: PeriodMotion, trace: Trace, n: int, change: Array, by_omega: Array) -> None:
    """Derivatives of the states at sample n (3, k, 2H+1) and (k, 1) from those at the sample before. Where the contact lands,
    travel and time of the step begin at a share of it, which moves with z."""
    samples, directions, E = motion.limit.size, data.kt.size, motion.E
    before, step = n - 1 if n else samples - 1, _time_step(motion)
    share, matrix = motion.landing[before], trace.by_state[n]
    for part in range(3):
        if part == 2 or part < directions:
            _carry(matrix, change[part])
    _carry(matrix, by_omega)
    for i in range(data.spring.size):
        by_L0, by_L = trace.by_limit0[n, i] * motion.slope[before], trace.by_limit[n, i] * motion.slope[n]
        begins = 0.0
        if share > 0.0:
            passed = trace.by_time[n, i] * step
            for d in range(directions):
                passed += trace.by_travel[n, i, d] * (motion.u[d, n] - motion.u[d, before])
            begins = passed / (motion.z[n] - motion.z[before])
        for d in range(directions):
            slope = (1.0 - share) * trace.by_travel[n, i, d]
            for j in range(E.shape[1] if slope != 0.0 else 0):
                change[d, i, j] += slope * (E[n, j] - E[before, j])
        for j in range(E.shape[1] if motion.slope.size else 0):
            landed = begins * (E[before, j] + share * (E[n, j] - E[before, j]))
            change[2, i, j] += by_L0 * E[before, j] + by_L * E[n, j] + landed
        if motion.omega > 0.0:
            by_omega[i, 0] -= trace.by_time[n, i] * (1.0 - share) * step / motion.omega


@inner
def _fill_tangent(
    data: ContactData, motion: PeriodMotion, trace: Trace, n: int, d: int, change: Array, by_omega: Array, forces: PeriodForces
) -> None:
    """Derivatives of y of direction d at sample n, from those of the states."""
    E, D, columns = motion.E, motion.D, motion.E.shape[1]
    for i in range(data.spring.size):
        weight = trace.tractions[n, d, i]
        if weight != 0.0:
            forces.by_omega[d, n] += weight * by_omega[i, 0]
            for part in range(3):
                for j in range(columns):
                    forces.tangents[n, d, part, j] += weight * change[part, i, j]
    for o in range(data.kt.size):
        by_u = trace.by_u[n, d, o] - (data.kt[d] if o == d else 0.0)
        by_velocity = trace.by_velocity[n, d, o]
        if motion.omega > 0.0:
            forces.by_omega[d, n] += by_velocity * motion.velocity[o, n] / motion.omega
        for j in range(columns):
            forces.tangents[n, d, o, j] += by_u * E[n, j] + by_velocity * motion.omega * D[n, j]
    by_limit = trace.by_direct_limit[n, d] * motion.slope[n]
    for j in range(columns if by_limit != 0.0 else 0):
        forces.tangents[n, d, 2, j] += by_limit * E[n, j]
