"""Contact forces in the frequency domain: from motion w to λ̂(w) = F(w) − K_c w and its exact derivative.

Only what slips, opens, or is tied to the normal load at one sample differs from a linear spring, so λ̂ of a held row is a
constant, and the derivative E = dλ̂/dw is zero there. Sums over samples of element laws go through running sums.
"""

from __future__ import annotations

import numpy as np

from stickslip.checks import Array, Index
from stickslip.contact.dispatch import law_period
from stickslip.contact.law import SLIDERS
from stickslip.contact.period import HELD, OPEN, SLIPPING, STATIC, STICK, friction_period, landing_shares
from stickslip.contact.protocol import NOT_PERIODIC, PeriodMotion, contact_data, no_forces
from stickslip.contact.table import ContactTable
from stickslip.harmonic.fourier import Fourier, add_product_sums, add_run
from stickslip.kernels import inlined, kernel


@kernel
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
    loads, slopes, z = np.zeros((most, samples)), np.zeros((most, samples)), np.zeros(samples)
    for c in range(table.normal_row.size):
        row = table.normal_row[c]
        if row >= 0:
            z = E @ w[row]
            unknown[row] = _normal_forces(table, c, z, tables, target[row], own[row], loads, slopes)
        if table.kind[c] != SLIDERS:
            _law_forces(table, c, w, omega, tables, z, loads, slopes, target, unknown, own, normal, cross, by_omega)
            continue
        for r in range(table.first_row[c], table.first_row[c + 1]):
            if r != row:
                unknown[r] = _friction_forces(
                    table, r, w[r], tables, table.normal_first[c], z, loads, slopes, target[r], own[r], normal[r]
                )


@kernel
def _normal_forces(
    table: ContactTable, c: int, z: Array, tables: Fourier, target: Array, own: Array, loads: Array, slopes: Array
) -> int:
    """Loads N_e and slopes dN_e/dz of contact c at the samples; λ̂ = P Σ_e max(c_e, −k_e z) and its derivative."""
    first, last = table.normal_first[c], table.normal_first[c + 1]
    samples = z.size
    lifted = np.zeros(samples)
    constant = 0.0
    opened = False
    sums = np.zeros((2, tables.cosines.shape[0]))
    for e in range(first, last):
        k, preload = table.normal_stiffness[e], table.normal_constant[e]
        constant += preload
        begin = -1
        for n in range(samples):
            force = k * z[n] + preload
            closed = force > 0.0
            loads[e - first, n] = force if closed else 0.0
            slopes[e - first, n] = k if closed else 0.0
            if not closed:
                lifted[n] -= force
                if begin < 0:
                    begin = n
            elif begin >= 0:
                add_run(sums, -k, begin, n, tables.cosines, tables.sines)
                begin = -1
                opened = True
        if begin >= 0:
            add_run(sums, -k, begin, samples, tables.cosines, tables.sines)
            opened = True
    target[:] = 0.0
    own[:, :] = 0.0
    if opened:
        target[:] = tables.P @ lifted
        add_product_sums(own, sums, samples)
    target[0] += constant
    return SLIPPING if opened else HELD


@kernel
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
    u = tables.E @ motion
    samples = u.size
    total, y = np.zeros(samples), np.empty(samples)
    limit, slope, landing = np.empty(samples), np.empty(samples), np.empty(samples)
    event = np.empty(samples, dtype=np.int64)
    own_sums, normal_sums = np.zeros((2, tables.cosines.shape[0])), np.zeros((2, tables.cosines.shape[0]))
    own[:, :] = 0.0
    normal[:, :] = 0.0
    target[:] = 0.0
    unknown = HELD
    constant = 0.0
    for e in range(table.friction_first[r], table.friction_first[r + 1]):
        kt = table.stiffness[e]
        element_limits(table, e, normal_first, loads, slopes, limit, slope)
        landing_shares(z, limit, slope, landing)
        ku = kt * u
        mean = kt * motion[0]
        start, value = table.start_kind[e], table.start_value[e]
        state, sample, factor = friction_period(start, value, kt, ku, limit, landing, mean, y, event)
        unknown = max(unknown, state)
        if state == SLIPPING:
            total += y
            _add_events(kt, event, slope, ku, z, landing, tables, own_sums, normal_sums, own, normal)
        else:
            constant += y[0]
            if state == STATIC:
                _add_static(kt, sample, factor, slope, tables.E, own, normal)
    if unknown == SLIPPING:
        target[:] = tables.P @ total
        add_product_sums(own, own_sums, samples)
        add_product_sums(normal, normal_sums, samples)
    target[0] += constant
    return unknown


@inlined
def _law_forces(
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
        element_limits(table, table.friction_first[first], table.normal_first[c], loads, slopes, limit, slope)
        landing_shares(z, limit, slope, landing)
    found = no_forces(directions, samples, columns)
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
    table: ContactTable, e: int, normal_first: int, loads: Array, slopes: Array, limit: Array, slope: Array
) -> None:
    """Limit L = μ Σ N + L0 of friction element e at every sample, and its slope dL/dz."""
    limit[:] = table.constant_limit[e]
    slope[:] = 0.0
    mu = table.friction[e]
    for k in range(table.load_first[e] - normal_first, table.load_last[e] - normal_first):
        for n in range(limit.size):
            limit[n] += mu * loads[k, n]
            slope[n] += mu * slopes[k, n]


@kernel
def _add_static(kt: float, sample: int, factor: float, slope: Array, E: Array, own: Array, normal: Array) -> None:
    """Derivative of a constant y = factor L_k − kt u_k (k = sample; −1: y = value − kt ū): harmonic 0 alone."""
    if sample < 0:
        own[0, 0] -= kt
        return
    for j in range(E.shape[1]):
        own[0, j] -= kt * E[sample, j]
        normal[0, j] += factor * slope[sample] * E[sample, j]


@kernel
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


@kernel
def _event_slope(event: Index, slope: Array, k: int) -> float:
    """d(s L)/dz at an event sample."""
    return 0.0 if event[k] == OPEN else event[k] * slope[k]


@kernel
def _add_cyclic(sums: Array, weight: float, first: int, last: int, samples: int, tables: Fourier) -> None:
    """`add_run` over samples first..last−1 counted on past the end of the period."""
    if last <= samples:
        add_run(sums, weight, first, last, tables.cosines, tables.sines)
    elif first >= samples:
        add_run(sums, weight, first - samples, last - samples, tables.cosines, tables.sines)
    else:
        add_run(sums, weight, first, samples, tables.cosines, tables.sines)
        add_run(sums, weight, 0, last - samples, tables.cosines, tables.sines)


@kernel
def _add_stick(
    kt: float, weight: float, k: int, share: float, first: int, last: int, tables: Fourier, own: Array, normal: Array
) -> None:
    """Rank-one part of a stick interval first..last−1 of dy = weight dz − kt du, u and z a share of the step after sample k."""
    samples, size = tables.E.shape
    harmonics = (size - 1) // 2
    sums = np.zeros((2, harmonics + 1))
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
