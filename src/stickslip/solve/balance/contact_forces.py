"""Contact forces in the frequency domain: from motion w to λ̂(w) = F(w) − K_c w and its exact derivative.

Only what slips, opens, or is tied to the normal load at one sample differs from a linear spring, so λ̂ of a held row is a
constant, and the derivative E = dλ̂/dw is zero there. Sums over samples of element laws go through running sums.
"""

from typing import Any

import numpy as np
from numba import float64, int64, void

from stickslip.model.contact.law import SLIDERS
from stickslip.model.contact.point import ContactTable, bent, contact_data, contact_table
from stickslip.model.contact.protocol import (
    HELD,
    MEAN,
    NOT_PERIODIC,
    OFFSET,
    OPEN,
    RATIO,
    SLIPPING,
    STATIC,
    STICK,
    PeriodMotion,
    friction_period,
    landing_shares,
    law_period,
    no_forces,
)
from stickslip.solve.balance.fourier import Fourier, add_openings, add_product_sums, add_run, fourier, swing
from stickslip.support.checks import Array, Index
from stickslip.support.kernels import boxed, compiled, inlined, inner, kernel, separate
from stickslip.support.kernels.arrays import empty_blocks, empty_line, empty_table, fill, zero_line, zero_numbers, zero_table
from stickslip.support.kernels.views import view, view_of

_LINE, _SQUARE, _BLOCKS, _PLACES = float64[::1], float64[:, ::1], float64[:, :, ::1], int64[::1]


def contact_forces_signature() -> Any:
    """Types of `contact_forces`."""
    tables, blocks = (view_of(contact_table(())), view_of(fourier(1, 6))), (_BLOCKS,) * 3
    return void(*tables, _SQUARE, float64, _SQUARE, _PLACES, *blocks, _SQUARE)


def law_forces_signature() -> Any:
    """Types of `law_forces`."""
    tables, blocks = (view_of(contact_table(())), view_of(fourier(1, 6))), (_BLOCKS,) * 3
    return void(tables[0], int64, _SQUARE, float64, tables[1], _LINE, _SQUARE, _SQUARE, _SQUARE, _PLACES, *blocks, _SQUARE)


def compile_contact_forces(table: ContactTable) -> None:
    """Compile what `contact_forces` needs for some contacts, or take it from disk."""
    compiled(contact_forces, *([law_forces] if np.any(table.kind != SLIDERS) else []))


@separate(contact_forces_signature)
def contact_forces(
    table: ContactTable,
    tables: Fourier,
    w: Array,
    omega: float,
    target: Array,
    unknown: Index,
    own: Array,
    normal: Array,
    cross: Array,
    by_omega: Array,
) -> None:
    """Fill, for motion w (rows, 2H+1) at omega [rad/s]: target λ̂ (rows, 2H+1), unknown (rows,) as HELD, STATIC or SLIPPING, and
    the derivatives own[r] = ∂λ̂_r/∂w_r, normal[r] = ∂λ̂_r/∂z, and where a law couples both tangential directions cross[r] =
    ∂λ̂_r/∂w of the other one, each (rows, 2H+1, 2H+1); cross may be empty where none does. by_omega (rows, 2H+1), zeros before:
    ∂λ̂/∂ω at fixed w, of laws that depend on the velocity."""
    E = tables.E
    samples = E.shape[0]
    most = 1
    for c in range(table.normal_row.size):
        most = max(most, table.normal_first[c + 1] - table.normal_first[c])
    loads, slopes, z = zero_table(most, samples), zero_table(most, samples), zero_line(samples)
    for c in range(table.normal_row.size):
        row = table.normal_row[c]
        if row >= 0:
            z = synthesis(tables, w[row])
            unknown[row] = _normal_forces(table, c, w[row], z, tables, target[row], own[row], loads, slopes)
        if table.kind[c] != SLIDERS:
            law_forces(table, c, w, omega, tables, z, loads, slopes, target, unknown, own, normal, cross, by_omega)
            continue
        lowest = w[row, 0] - swing(w[row]) if row >= 0 else 0.0
        for r in range(table.first_row[c], table.first_row[c + 1]):
            if r == row:
                continue
            if _sticks(table, r, lowest, w[r]):
                unknown[r] = _stuck_forces(table, r, w[r], target[r], own[r], normal[r])
            else:
                unknown[r] = _friction_forces(
                    table, r, w[r], tables, table.normal_first[c], z, loads, slopes, target[r], own[r], normal[r]
                )


@kernel
def contact_answer(
    given: ContactTable, tables: Fourier, w: Array, omega: float
) -> tuple[Array, Index, Array, Array, Array, Array]:
    """λ̂ of contacts, their states and derivatives, as `contact_forces` fills them, for balances that stand in Python."""
    table, forms, rows, columns = view(given), view(tables), w.shape[0], w.shape[1]
    coupled = 0
    for partner in table.partner_row:
        if partner >= 0:
            coupled = rows
    target, unknown = empty_table(rows, columns), zero_numbers(rows)
    own, coupling = empty_blocks(rows, columns, columns), empty_blocks(rows, columns, columns)
    cross, by_omega = empty_blocks(coupled, columns, columns), zero_table(rows, columns)
    coupling[:], cross[:] = 0.0, 0.0  # of normal rows, and of rows whose law couples nothing, it says nothing
    contact_forces(table, forms, w, omega, target, unknown, own, coupling, cross, by_omega)
    return boxed((target, unknown, own, coupling, cross, by_omega))


@inner
def _asked(table: ContactTable, e: int, mean: float) -> float:
    """The intercept y that the start of friction element e asks for, one whose rule reads no samples; mean: of kt u."""
    if table.start_kind[e] == OFFSET:
        return float(-table.stiffness[e] * table.start_value[e])
    return float(table.start_value[e] - mean)


@inner
def _sticks(table: ContactTable, r: int, lowest: float, motion: Array) -> bool:
    """Whether tangential row r certainly sticks, by the swing of its motion about its mean and the lowest normal motion.

    The intercept y that its start asks for then stays inside the limits of each of its elements. False: it may slip.
    """
    for e in range(table.friction_first[r], table.friction_first[r + 1]):
        if table.start_kind[e] == RATIO or table.bend_first[e] < table.bend_first[e + 1]:
            return False
        limit, kt = table.constant_limit[e], table.stiffness[e]
        for k in range(table.load_first[e], table.load_last[e]):
            limit += table.friction[e] * max(table.normal_stiffness[k] * lowest + table.normal_constant[k], 0.0)
        mean = kt * motion[0]
        if not abs(_asked(table, e, mean) + mean) + kt * swing(motion) < limit:
            return False
    return True


@inner
def _stuck_forces(table: ContactTable, r: int, motion: Array, target: Array, own: Array, normal: Array) -> int:
    """λ̂ of a tangential row that sticks: what its starts ask for."""
    fill(own, 0.0)
    fill(normal, 0.0)
    unknown = HELD
    for i in range(target.size):
        target[i] = 0.0
    for e in range(table.friction_first[r], table.friction_first[r + 1]):
        kt = table.stiffness[e]
        target[0] += _asked(table, e, kt * motion[0])
        if table.start_kind[e] == MEAN:
            unknown = STATIC
            own[0, 0] -= kt
    return unknown


@inlined
def _normal_forces(
    table: ContactTable, c: int, motion: Array, z: Array, tables: Fourier, target: Array, own: Array, loads: Array, slopes: Array
) -> int:
    """Loads N_e and slopes dN_e/dz of contact c at the samples; the harmonics λ̂ of Σ_e max(c_e, −k_e z) and their derivative,
    by integration over the openings: λ̂ = Σ_e c_e + Σ_e ∫ −(k_e z + c_e), the part in z being the derivative times the motion."""
    first, last = table.normal_first[c], table.normal_first[c + 1]
    samples = z.size
    constant = 0.0
    opened = False
    openings, sums, preloads = empty_sums(tables), empty_sums(tables), empty_sums(tables)
    for e in range(first, last):
        k, preload = table.normal_stiffness[e], table.normal_constant[e]
        constant += preload
        for n in range(samples):
            force = k * z[n] + preload
            closed = force > 0.0
            loads[e - first, n] = force if closed else 0.0
            slopes[e - first, n] = k if closed else 0.0
        fill(openings, 0.0)
        if add_openings(motion, z, -preload / k, openings):
            opened = True
            for i in range(2):
                for m in range(sums.shape[1]):
                    sums[i, m] -= k * openings[i, m]
                    preloads[i, m] -= preload * openings[i, m]
    fill(own, 0.0)
    for i in range(target.size):
        target[i] = 0.0
    if opened:
        add_product_sums(own, sums, samples)
        np.dot(own, motion, target)
        constant += preloads[0, 0] / samples
        for h in range(1, (target.size + 1) // 2):
            target[2 * h - 1] += 2.0 * preloads[0, h] / samples
            target[2 * h] += 2.0 * preloads[1, h] / samples
    target[0] += constant
    return SLIPPING if opened else HELD


@inner
def synthesis(tables: Fourier, harmonics: Array) -> Array:
    """Samples (Nt,) of a motion (2H+1,)."""
    found = empty_line(tables.E.shape[0])
    np.dot(tables.E, harmonics, found)
    return found


@inner
def empty_sums(tables: Fourier) -> Array:
    """Zeros for the running sums of `add_run`."""
    return zero_table(tables.E.shape[0] - tables.E.shape[0] + 2, tables.cosines.shape[0])


@inlined
def _friction_forces(
    table: ContactTable,
    r: int,
    motion: Array,
    tables: Fourier,
    normal_first: int,
    z: Array,
    loads: Array,
    slopes: Array,
    target: Array,
    own: Array,
    normal: Array,
) -> int:
    """λ̂ of a tangential row, the sum of the intercepts y of its elements, and its derivatives by u and by z."""
    u = synthesis(tables, motion)
    samples = u.size
    total, y = zero_line(samples), empty_line(samples)
    limit, slope, landing = empty_line(samples), empty_line(samples), empty_line(samples)
    event, ku = zero_numbers(samples), empty_line(samples)
    own_sums, normal_sums = empty_sums(tables), empty_sums(tables)
    fill(own, 0.0)
    fill(normal, 0.0)
    for i in range(target.size):
        target[i] = 0.0
    unknown = HELD
    constant = 0.0
    for e in range(table.friction_first[r], table.friction_first[r + 1]):
        kt = table.stiffness[e]
        element_limits(table, e, normal_first, z, loads, slopes, limit, slope, landing)
        for n in range(samples):
            ku[n] = kt * u[n]
        mean = kt * motion[0]
        start, value = table.start_kind[e], table.start_value[e]
        state, sample, factor = friction_period(start, value, kt, ku, limit, landing, mean, y, event)
        unknown = max(unknown, state)
        if state == SLIPPING:
            for n in range(samples):
                total[n] += y[n]
            _add_events(kt, event, slope, ku, z, landing, tables, own_sums, normal_sums, own, normal)
        else:
            constant += y[0]
            if state == STATIC:
                _add_static(kt, sample, factor, slope, tables.E, own, normal)
    if unknown == SLIPPING:
        np.dot(tables.P, total, target)
        add_product_sums(own, own_sums, samples)
        add_product_sums(normal, normal_sums, samples)
    target[0] += constant
    return unknown


@separate(law_forces_signature)
def law_forces(
    table: ContactTable,
    c: int,
    w: Array,
    omega: float,
    tables: Fourier,
    z: Array,
    loads: Array,
    slopes: Array,
    target: Array,
    unknown: Index,
    own: Array,
    normal: Array,
    cross: Array,
    by_omega: Array,
) -> None:
    """λ̂ of the tangential rows of contact c by the kernel of its law, and its derivatives; NaN where it is not periodic."""
    first, data = table.first_row[c], contact_data(table, c)
    directions, (samples, columns) = data.kt.size, tables.E.shape
    motion = np.ascontiguousarray(w[first : first + directions].T)
    u, velocity = np.ascontiguousarray((tables.E @ motion).T), np.ascontiguousarray((tables.D @ motion).T)
    for d in range(directions):
        for n in range(samples):
            velocity[d, n] *= omega
    limit, slope, landing = np.zeros(samples), np.zeros(samples), np.zeros(samples)
    if table.friction_first[first + 1] > table.friction_first[first]:
        element_limits(table, table.friction_first[first], table.normal_first[c], z, loads, slopes, limit, slope, landing)
    found = no_forces(data, samples, columns)
    whole = PeriodMotion(u, velocity, z, limit, slope, landing, omega, tables.E, tables.D)
    state = law_period(table.kind[c], data, whole, found)
    for d in range(directions):
        row = first + d
        normal[row] = 0.0
        unknown[row] = SLIPPING if state == NOT_PERIODIC else state
        if unknown[row] == SLIPPING:
            target[row] = tables.P @ found.y[d]
            by_omega[row] = tables.P @ found.by_omega[d]
        else:
            target[row] = 0.0
            target[row, 0] = found.y[d, 0]
        if state == NOT_PERIODIC:
            target[row] = np.nan
        for part in range(3):
            if part == d:
                block = own[row]
            elif part == 2 and table.loading_row[row] >= 0:
                block = normal[row]
            elif part < 2 and table.partner_row[row] >= 0:
                block = cross[row]
            else:
                continue
            if unknown[row] == SLIPPING:
                block[:, :] = tables.P @ np.ascontiguousarray(found.tangents[:, d, part])
            else:
                block[:, :] = 0.0
                block[0] = found.tangents[0, d, part]


@kernel
def element_limits(
    table: ContactTable,
    e: int,
    normal_first: int,
    z: Array,
    loads: Array,
    slopes: Array,
    limit: Array,
    slope: Array,
    landing: Array,
) -> None:
    """Limit L of friction element e at every sample, its slope dL/dz, and `landing_shares` for the normal motion z: it lands
    where μ Σ N + L0 does, which is straight in z also where the limit bends within the step."""
    mu, constant = table.friction[e], table.constant_limit[e]
    for n in range(limit.size):
        limit[n], slope[n] = constant, 0.0
    for k in range(table.load_first[e] - normal_first, table.load_last[e] - normal_first):
        for n in range(limit.size):
            limit[n] += mu * loads[k, n]
            slope[n] += mu * slopes[k, n]
    landing_shares(z, limit, slope, landing)
    if table.bend_first[e] < table.bend_first[e + 1]:
        for n in range(limit.size):
            limit[n], factor = bent(table, e, limit[n])
            slope[n] *= factor


@inlined
def _add_static(kt: float, sample: int, factor: float, slope: Array, E: Array, own: Array, normal: Array) -> None:
    """Derivative of a constant y = factor L_k − kt u_k (k = sample; −1: y = value − kt ū): harmonic 0 alone."""
    if sample < 0:
        own[0, 0] -= kt
        return
    for j in range(E.shape[1]):
        own[0, j] -= kt * E[sample, j]
        normal[0, j] += factor * slope[sample] * E[sample, j]


@inlined
def _add_events(
    kt: float,
    event: Index,
    slope: Array,
    ku: Array,
    z: Array,
    landing: Array,
    tables: Fourier,
    own_sums: Array,
    normal_sums: Array,
    own: Array,
    normal: Array,
) -> None:
    """Derivative of y_n = s_k L_k − kt u_k, k the last event before n: runs of events into the sums, sticks as rank one.

    A stick that begins at a landing follows the motion there, θ of the way from sample k to the next; θ itself moves with z:
    dy = −kt (du − Δu/Δz dz), du and dz the changes at the landing.
    """
    samples = event.size
    first = 0
    while event[first] == STICK:
        first += 1
    n = first
    while n < first + samples:
        k = n % samples
        if event[k] == STICK:
            end = n + 1
            while end < first + samples and event[end % samples] == STICK:
                end += 1
            before = (n - 1) % samples
            weight = _event_slope(event, slope, before)
            if landing[before] > 0.0:
                weight = (ku[k] - ku[before]) / (z[k] - z[before])
            _add_stick(kt, weight, before, landing[before], n, end, tables, own, normal)
        else:
            weight = _event_slope(event, slope, k)
            end = n + 1
            while end < first + samples and event[end % samples] != STICK and _event_slope(event, slope, end % samples) == weight:
                end += 1
            _add_cyclic(own_sums, -kt, n, end, samples, tables)
            if weight != 0.0:
                _add_cyclic(normal_sums, weight, n, end, samples, tables)
        n = end


@inner
def _event_slope(event: Index, slope: Array, k: int) -> float:
    """d(s L)/dz at an event sample."""
    return 0.0 if event[k] == OPEN else event[k] * slope[k]


@inner
def _add_cyclic(sums: Array, weight: float, first: int, last: int, samples: int, tables: Fourier) -> None:
    """`add_run` over samples first..last−1 counted on past the end of the period."""
    if last <= samples:
        add_run(sums, weight, first, last, tables.cosines, tables.sines)
    elif first >= samples:
        add_run(sums, weight, first - samples, last - samples, tables.cosines, tables.sines)
    else:
        add_run(sums, weight, first, samples, tables.cosines, tables.sines)
        add_run(sums, weight, 0, last - samples, tables.cosines, tables.sines)


@inlined
def _add_stick(
    kt: float, weight: float, k: int, share: float, first: int, last: int, tables: Fourier, own: Array, normal: Array
) -> None:
    """Rank-one part of a stick interval first..last−1 of dy = weight dz − kt du, u and z a share of the step after sample k."""
    samples, size = tables.E.shape
    harmonics = (size - 1) // 2
    sums = zero_table(size - size + 2, harmonics + 1)
    _add_cyclic(sums, 1.0 / samples, first, last, samples, tables)
    E, following = tables.E, (k + 1) % samples
    for i in range(size):
        h = (i + 1) // 2
        analysis = sums[0, 0] if i == 0 else 2.0 * sums[1 - i % 2, h]
        for j in range(size):
            product = analysis * (E[k, j] + share * (E[following, j] - E[k, j]))
            own[i, j] -= kt * product
            if weight != 0.0:
                normal[i, j] += weight * product
