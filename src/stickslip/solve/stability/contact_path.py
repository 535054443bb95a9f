"""What every contact does between the samples of a period: instants at which sliders yield, stick, lift off and land.

The samples say in which order; the instants follow from the motion between two samples, a cubic of both displacements and
velocities, so that their error is of fourth order and not of first, as that of the samples themselves.
"""

import numpy as np

from stickslip.model.contact.law import SLIDERS
from stickslip.model.contact.point import ContactTable, bent, contact_data
from stickslip.model.contact.protocol import (
    OPEN,
    SLIP,
    STICK,
    PeriodForces,
    PeriodMotion,
    friction_period,
    landing_shares,
    law_period,
    no_forces,
)
from stickslip.solve.time.contact_law import limit_line, slip_limit
from stickslip.support.checks import Array, Index
from stickslip.support.kernels import boxed, inner, kernel

BISECTIONS = 44
"""Halvings of the step between two samples."""

BESIDE = 1e-5
"""Share of a step between samples before and after an event of a law with kernels of its own, whose force may turn there."""


@inner
def at_instant(values: Array, rates: Array, t: float) -> tuple[float, float]:
    """A periodic signal and its rate at t (in samples), by the cubic through values and rates (per sample) of two samples."""
    size = values.size
    n = int(np.floor(t))
    x, a, b = t - n, n % size, (n + 1) % size
    u0, u1, v0, v1 = values[a], values[b], rates[a], rates[b]
    c2, c3 = 3.0 * (u1 - u0) - 2.0 * v0 - v1, 2.0 * (u0 - u1) + v0 + v1
    return u0 + x * (v0 + x * (c2 + x * c3)), v0 + x * (2.0 * c2 + 3.0 * x * c3)


@inner
def _gap(table: ContactTable, e: int, r: int, u: Array, v: Array, t: float, what: int, side: float, y: float) -> float:
    """A function of time that is positive after the event `what` of element e of row r, and negative before.

    0: lift-off, −L; 1: landing, L; 2: yielding to a side, side (y + kt u) − L; 3: sticking, side d(side L − kt u)/dt; 4: closing
    or opening of the normal element e, side (k z + c); 5: passing of a bend y, side (ℓ − y), ℓ the limit without bends.
    """
    if what == 4:
        return float(side * (table.normal_stiffness[e] * at_instant(u[r], v[r], t)[0] + table.normal_constant[e]))
    z, rate, row = 0.0, 0.0, table.loading_row[r]
    if row >= 0:
        z, rate = at_instant(u[row], v[row], t)
    if what == 5:
        return float(side * (limit_line(table, e, z)[0] - y))
    limit, slope = slip_limit(table, e, z)
    if what == 0:
        return float(-limit if limit > 0.0 else 1.0)
    if what == 1:
        return float(limit if limit > 0.0 else -1.0)
    moved, speed = at_instant(u[r], v[r], t)
    if what == 2:
        return float(side * (y + table.stiffness[e] * moved) - limit)
    return float(side * (side * slope * rate - table.stiffness[e] * speed))


@inner
def _instant(
    table: ContactTable, e: int, r: int, u: Array, v: Array, low: float, high: float, what: int, side: float, y: float
) -> float:
    """Where the function of an event changes sign between two instants."""
    if _gap(table, e, r, u, v, low, what, side, y) > 0.0:
        return low
    if _gap(table, e, r, u, v, high, what, side, y) <= 0.0:
        return high
    for _ in range(BISECTIONS):
        middle = 0.5 * (low + high)
        if _gap(table, e, r, u, v, middle, what, side, y) > 0.0:
            high = middle
        else:
            low = middle
    return high


@inner
def _slip_line(table: ContactTable, e: int, r: int, u: Array, v: Array, t: float, side: float) -> float:
    """y = side L − kt u of a slipping slider at an instant."""
    z = 0.0
    if table.loading_row[r] >= 0:
        z = at_instant(u[table.loading_row[r]], v[table.loading_row[r]], t)[0]
    return float(side * slip_limit(table, e, z)[0] - table.stiffness[e] * at_instant(u[r], v[r], t)[0])


@inner
def _slider_changes(
    table: ContactTable, e: int, r: int, u: Array, v: Array, event: Index, held: float, instants: Array, states: Index
) -> tuple[int, float]:
    """Instants (in samples) and new states of slider e over a period, from the y that it holds if it sticks at its beginning.

    Returns how many, and the y that it held last: that of the turning point between the samples, where it began to stick.
    """
    count, last = 0, -np.inf
    for n in range(event.size):
        before, after = event[n - 1], event[n]
        if before == after:
            continue
        low, high = n - 1.0, float(n)
        if before == OPEN or after == OPEN:
            t = max(_instant(table, e, r, u, v, low, high, 1 if before == OPEN else 0, 0.0, 0.0), last)
            instants[count], states[count] = t, after
            last, count = t, count + 1
            if after == STICK:
                held = -table.stiffness[e] * at_instant(u[r], v[r], t)[0]
            continue
        if before != STICK:
            # The last sample in slip is the turning point of the samples: the true one lies before or after it.
            side = float(before)
            back = 1.0 if _gap(table, e, r, u, v, low, 3, side, 0.0) > 0.0 else 0.0
            t = max(_instant(table, e, r, u, v, low - back, high - back, 3, side, 0.0), last)
            instants[count], states[count] = t, STICK
            last, count, held = t, count + 1, _slip_line(table, e, r, u, v, t, side)
        if after != STICK:
            t = max(_instant(table, e, r, u, v, max(low, last), high, 2, float(after), held), last)
            instants[count], states[count] = t, after
            last, count = t, count + 1
    return count, held


@kernel
def contact_path(
    table: ContactTable,
    u: Array,
    v: Array,
    mean: Array,
    omega: float,
    instants: Array,
    elements: Index,
    states: Index,
    start: Array,
) -> tuple[int, Array, Index]:
    """Fill the changes of state of a period, in any order, and `start` (elements, Nt): intercepts of laws with own kernels.

    u, v (rows, Nt): motion and its rate per sample. instants: in samples. elements: which friction element changes, −1 for a
    normal element or a law; −2 − c where contact c, of a law with own kernels, has the intercepts of the sample that stands
    in place of a state. Returns how many changes; still (elements,): 1.0 where a slider, or a law with own kernels, sticks all
    the time; last (elements,): states of sliders at sample Nt − 1.
    """
    samples, count = u.shape[1], 0
    still, last = np.zeros(table.stiffness.size), np.zeros(table.stiffness.size, dtype=np.int64)
    y, event, limit = np.empty(samples), np.empty(samples, dtype=np.int64), np.empty(samples)
    slope, landing, none = np.zeros(samples), np.zeros(samples), np.empty((samples, 0))
    for c in range(table.normal_row.size):
        row = table.normal_row[c]
        z = u[row] if row >= 0 else np.zeros(samples)
        for k in range(table.normal_first[c], table.normal_first[c + 1]):
            count = _passes(table, k, row, u, v, 4, 0.0, instants, elements, states, count)
        for r in range(table.first_row[c], table.first_row[c + 1]):
            if r == row:
                continue
            for e in range(table.friction_first[r], table.friction_first[r + 1]):
                for n in range(samples):
                    limit[n], slope[n] = limit_line(table, e, z[n])
                landing_shares(z, limit, slope, landing)
                for k in range(table.bend_first[e], table.bend_first[e + 1] if row >= 0 else 0):
                    count = _passes(table, e, r, u, v, 5, table.bend[k], instants, elements, states, count)
                for n in range(samples):
                    limit[n], factor = bent(table, e, limit[n])
                    slope[n] *= factor
                if table.kind[c] != SLIDERS:
                    continue
                kt = table.stiffness[e]
                kind, value = table.start_kind[e], table.start_value[e]
                friction_period(kind, value, kt, kt * u[r], limit, landing, kt * mean[r], y, event)
                last[e] = event[-1]
                found, held = _slider_changes(table, e, r, u, v, event, y[-1], instants[count:], states[count:])
                if found > 0 and event[-1] == STICK:
                    found, held = _slider_changes(table, e, r, u, v, event, held, instants[count:], states[count:])
                elements[count : count + found] = e
                count += found
                if found == 0 and event[0] == STICK:
                    still[e] = 1.0
        if table.kind[c] == SLIDERS:
            continue
        data, a = contact_data(table, c), table.first_row[c]
        b = a + data.kt.size
        forces = no_forces(data, samples, 0)
        rate = omega * samples / (2.0 * np.pi)
        if table.friction_first[a + 1] == table.friction_first[a]:
            limit[:], landing[:] = 0.0, 0.0
        motion = PeriodMotion(u[a:b], rate * v[a:b], z, limit, slope, landing, omega, none, none)
        law_period(table.kind[c], data, motion, forces)
        start[table.friction_first[a] : table.friction_first[b]] = forces.intercept
        if table.friction_first[b] > table.friction_first[a]:
            if np.all(forces.event == STICK):
                still[table.friction_first[a] : table.friction_first[b]] = 1.0
            if table.stiffness[table.friction_first[a]] > 0.0:
                count = _law_changes(table, c, forces, u, v, instants, elements, states, count)
    return boxed((count, still, last))


@inner
def _passes(
    table: ContactTable,
    e: int,
    r: int,
    u: Array,
    v: Array,
    what: int,
    y: float,
    instants: Array,
    elements: Index,
    states: Index,
    count: int,
) -> int:
    """The instants of the event 4 or 5 of element e of row r, either way."""
    before = _gap(table, e, r, u, v, -1.0, what, 1.0, y) > 0.0
    for n in range(u.shape[1]):
        after = _gap(table, e, r, u, v, float(n), what, 1.0, y) > 0.0
        if before != after:
            instants[count] = _instant(table, e, r, u, v, n - 1.0, float(n), what, 1.0 if after else -1.0, y)
            elements[count], states[count] = -1, 0
            count += 1
        before = after
    return count


@inner
def _law_changes(
    table: ContactTable,
    c: int,
    forces: PeriodForces,
    u: Array,
    v: Array,
    instants: Array,
    elements: Index,
    states: Index,
    count: int,
) -> int:
    """Instants at which a law with kernels of its own changes its state, or its motion (rows, Nt) turns round.

    Those at which it begins to slip come twice, just before and just after, since its force turns there at once.
    """
    a, event = table.first_row[c], forces.event
    coupled = table.partner_row[a] >= 0
    for n in range(event.size):
        if coupled and event[n - 1] == STICK and event[n] == SLIP:
            t = _disc_instant(table, a, forces.y, u, v, n - 1.0, float(n), n, True)
            instants[count], elements[count], states[count] = t - BESIDE, -2 - c, (n - 1) % event.size
            instants[count + 1], elements[count + 1], states[count + 1] = t + BESIDE, -1, 0
            count += 2
        elif coupled and event[n - 1] == SLIP and event[n] == STICK:
            passed = _disc_gap(table, a, forces.y, u, v, n - 1.0, n, False) > 0.0
            low, high = (n - 2.0, n - 1.0) if passed else (n - 1.0, float(n))
            instants[count], elements[count], states[count] = _disc_instant(table, a, forces.y, u, v, low, high, n, False), -1, 0
            count += 1
        elif not coupled:
            for r in range(a, a + forces.y.shape[0]):
                if v[r, n - 1] * v[r, n] < 0.0:
                    t = n - 1.0 + v[r, n - 1] / (v[r, n - 1] - v[r, n])
                    instants[count], elements[count], states[count] = t, -1, 0
                    count += 1
    return count


@inner
def _disc_gap(table: ContactTable, a: int, y: Array, u: Array, v: Array, t: float, n: int, yields: bool) -> float:
    """Positive after the first row a of a friction disc yields, |T| − L, or after it sticks, dL/dt − kt e·du/dt, e = T/|T| as the
    two samples before n have it."""
    e, z, rate, row = table.friction_first[a], 0.0, 0.0, table.loading_row[a]
    if row >= 0:
        z, rate = at_instant(u[row], v[row], t)
    limit, slope = slip_limit(table, e, z)
    kt = table.stiffness[e]
    if yields:
        first = y[0, n - 1] + kt * at_instant(u[a], v[a], t)[0]
        return float(np.hypot(first, y[1, n - 1] + kt * at_instant(u[a + 1], v[a + 1], t)[0]) - limit)
    earlier = np.arctan2(y[1, n - 2] + kt * u[a + 1, n - 2], y[0, n - 2] + kt * u[a, n - 2])
    later = np.arctan2(y[1, n - 1] + kt * u[a + 1, n - 1], y[0, n - 1] + kt * u[a, n - 1])
    turn = (later - earlier + np.pi) % (2.0 * np.pi) - np.pi
    angle = later + (t - (n - 1.0)) * turn
    along = np.cos(angle) * at_instant(u[a], v[a], t)[1] + np.sin(angle) * at_instant(u[a + 1], v[a + 1], t)[1]
    return float(slope * rate - kt * along)


@inner
def _disc_instant(
    table: ContactTable, a: int, y: Array, u: Array, v: Array, low: float, high: float, n: int, yields: bool
) -> float:
    """Where a friction disc begins to slip or to stick between two instants."""
    if _disc_gap(table, a, y, u, v, low, n, yields) > 0.0:
        return low
    for _ in range(BISECTIONS):
        middle = 0.5 * (low + high)
        if _disc_gap(table, a, y, u, v, middle, n, yields) > 0.0:
            high = middle
        else:
            low = middle
    return high
