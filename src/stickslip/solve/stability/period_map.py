"""A perturbation of a periodic motion over one period: the matrix whose eigenvalues are Floquet's multipliers.

Between two instants δλ, the change of what contacts carry beyond their stuck springs, is taken as linear in time, and the modes
of the stuck structure are exact. A stuck slider keeps its intercept, δy = const; a slipping one follows its limit,
δy = s δL − kt δu; an open one has δy = −kt δu. So what a slider remembers ends where it slips, without any further rule at the
changes of state: the forces are continuous there. At a landing they are too, but not their rate: δy of a slider that lands and
sticks depends on when.

The stuck structure stands as blocks of two states, exact over a step of any size, and high modes as static compliance:
ẋ = A x − J δλ, δw = R x − S δλ, with A of 2 x 2 blocks, one for each mode or pair of complex poles that is kept.

How the friction of a contact whose law has a step of its own answers a perturbation in one step.

States x = f(x before, travel, limits, time) and tractions by what is there after the step: the chain rule, by the derivatives
that the step of the law gives. What is remembered is the intercept of each state, x − kt u.
"""

from typing import NamedTuple

import numpy as np

from stickslip.model.contact.law import SLIDERS
from stickslip.model.contact.point import ContactTable, contact_data
from stickslip.model.contact.protocol import OPEN, STICK, StepMotion, no_step, take_step, traction, traction_by_state
from stickslip.solve.balance.linear_part import FIRSTS, States
from stickslip.solve.balance.receptance import PAIR_FIRST, REAL_MODE, REAL_POLE
from stickslip.solve.time.contact_law import slip_limit
from stickslip.support.checks import Array, Index
from stickslip.support.kernels import boxed, inner, kernel
from stickslip.support.kernels.arrays import rows_of

FAST = 50.0
"""How many times faster the unused second state of a single real pole decays than the pole itself."""


class BlockModes(NamedTuple):
    """blocks (b, 2, 2): A [1/s]; force (2b, rows): J; motion, velocity (rows, 2b): δw and δẇ of the states; static (rows, rows):
    S [m/N], of the modes that follow at once; real: the states that are there, without the second one of a single real pole;
    dropped: how many modes of `static` would move by themselves; lowest_dropped: the natural frequency of the slowest, rad/s."""

    blocks: Array
    force: Array
    motion: Array
    velocity: Array
    static: Array
    real: Index
    dropped: int
    lowest_dropped: float


def block_modes(states: States, rows: int, highest: float) -> BlockModes | None:
    """Blocks of the states of a real structure (`balance.decoupling`) with natural frequencies up to `highest` [rad/s].

    None for states that drive each other: two critically damped motions of one frequency.
    """
    if states.above.size or not np.all(np.isin(states.kind, (REAL_MODE, PAIR_FIRST, PAIR_FIRST + 1, REAL_POLE))):
        return None
    shape, receiver = states.shape[:rows], states.receiver
    # B K'⁻¹ Bᵀ: every gain at s = 0, that of a pair once for its real and once, with the other sign, for its imaginary part.
    gain = np.ones(states.kind.size)
    gain[states.kind == PAIR_FIRST], gain[states.kind == PAIR_FIRST + 1] = 2.0, -2.0
    compliance = (shape * gain) @ receiver.T
    found, single, dropped = [], [], list[float]()
    for j in np.flatnonzero(~np.isin(states.kind, [kind + 1 for kind in FIRSTS])):
        frequency = _frequency(states, int(j))
        if np.isfinite(frequency) and frequency <= highest:
            found.append(_block(states, int(j), shape, receiver))
            single.append(states.kind[j] == REAL_POLE or (states.kind[j] == REAL_MODE and states.q[j] <= 0.0))
        elif np.isfinite(frequency):
            dropped.append(frequency)
    blocks = np.array([block for block, *_ in found]).reshape(-1, 2, 2)
    force, motion, velocity = (
        np.ascontiguousarray(np.concatenate([each[k] for each in found], axis=axis) if found else np.zeros(empty))
        for k, axis, empty in ((1, 0, (0, rows)), (2, 1, (rows, 0)), (3, 1, (rows, 0)))
    )
    kept = np.zeros((rows, rows))
    for b, block in enumerate(blocks):
        kept -= motion[:, 2 * b : 2 * b + 2] @ np.linalg.solve(block, force[2 * b : 2 * b + 2])
    static = compliance - kept
    static[np.abs(static) <= 1e-12 * np.abs(compliance).max(initial=0.0)] = 0.0
    real = np.flatnonzero([one for alone in single for one in (True, not alone)])
    return BlockModes(
        blocks, force, motion, velocity, np.ascontiguousarray(static), real, len(dropped), min(dropped, default=np.inf)
    )


def _frequency(states: States, j: int) -> float:
    """How fast a state moves by itself, rad/s; infinite for a massless motion without damping."""
    p, q = float(states.p[j]), float(states.q[j])
    if states.kind[j] == REAL_MODE:
        slow = max(np.sqrt(max(q, 0.0)), abs(p) if q <= 0.0 else 0.0)
    else:
        slow = float(np.hypot(p, q)) if states.kind[j] == PAIR_FIRST else abs(p)
    return 1.0 / slow if slow > 0.0 else np.inf


def _block(states: States, j: int, shape: Array, receiver: Array) -> tuple[Array, Array, Array, Array]:
    """A, J, and the rows of δw and δẇ of one mode, pair or pole."""
    p, q, nothing = float(states.p[j]), float(states.q[j]), np.zeros(shape.shape[0])
    if states.kind[j] == REAL_MODE and q > 0.0:
        # The states are η and η̇/ω: q η̈ + p η̇ + η = f, q = 1/ω².
        omega = 1.0 / np.sqrt(q)
        block = np.array([[0.0, omega], [-omega, -p * omega**2]])
        return (
            block,
            np.stack([nothing, omega * receiver[:, j]]),
            np.stack([shape[:, j], nothing], 1),
            np.stack([nothing, omega * shape[:, j]], 1),
        )
    if states.kind[j] == PAIR_FIRST:
        # ξ̇ = σ (ξ − d f), σ = 1/(p + i q), motion 2 Re(o ξ).
        sigma = 1.0 / complex(p, q)
        drive, out = -sigma * (receiver[:, j] + 1j * receiver[:, j + 1]), 2.0 * (shape[:, j] + 1j * shape[:, j + 1])
        block = np.array([[sigma.real, -sigma.imag], [sigma.imag, sigma.real]])
        fast = sigma * out
        return (
            block,
            np.stack([drive.real, drive.imag]),
            np.stack([out.real, -out.imag], 1),
            np.stack([fast.real, -fast.imag], 1),
        )
    sigma = 1.0 / p if states.kind[j] == REAL_POLE else -1.0 / p
    block = np.diag([sigma, -FAST * abs(sigma)])
    return (
        block,
        np.stack([-sigma * receiver[:, j], nothing]),
        np.stack([shape[:, j], nothing], 1),
        np.stack([sigma * shape[:, j], nothing], 1),
    )


SOON = 1e-3
"""Share of a step over which the rate of friction after a landing is taken."""


class Tangent(NamedTuple):
    """δy of each row after a step by the motion after it: own, normal, cross (of the row, of its normal load, of its partner);
    own_rate, cross_rate by the velocity, all (rows,). state_own, state_normal, state_cross: δ of the intercept of each friction
    element of a law with a step of its own, by the same, (elements,)."""

    own: Array
    normal: Array
    cross: Array
    own_rate: Array
    cross_rate: Array
    state_own: Array
    state_normal: Array
    state_cross: Array


@inner
def law_tangent(
    table: ContactTable,
    c: int,
    u: Array,
    v: Array,
    time: float,
    inside: float,
    intercept: Array,
    w: Array,
    memory: Array,
    kept: Array,
    tangent: Tangent,
) -> None:
    """Fill the tangent of the rows and elements of contact c for a step with motion u and velocity v (rows, 2) before and after
    it, and move intercept (elements,).

    time: of the step [s]; inside: normal motion within it, at whose ends the contact may land or lift off. w (rows, columns):
    perturbations of the motion before it; memory (elements, columns): of the intercepts, before it and, but for what the motion
    after the step adds, after it; kept (rows, columns): what these leave of δy.
    """
    a, data, row, e = table.first_row[c], contact_data(table, c), table.normal_row[c], table.friction_first[table.first_row[c]]
    size, states, columns = data.kt.size, data.spring.size, w.shape[1]
    L0, L1, slope = 0.0, 0.0, 0.0
    if states:
        L0 = slip_limit(table, e, u[row, 0] if row >= 0 else 0.0)[0]
        L1 = slip_limit(table, e, u[row, 1] if row >= 0 else 0.0)[0]
        slope = slip_limit(table, e, inside)[1]
    b, state, before = a + size, np.empty(states), np.empty((states, columns))
    for i in range(states):
        r = a + data.direction[i]
        state[i] = intercept[e + i] + data.spring[i] * u[r, 0]
        before[i] = memory[e + i] + data.spring[i] * w[r]
    found = no_step(states, size)
    motion = StepMotion(state, u[a:b, 1] - u[a:b, 0], u[a:b, 1].copy(), v[a:b, 1].copy(), L0, L1, time)
    take_step(data, motion, found)
    for i in range(states):
        r, after = a + data.direction[i], memory[e + i]
        intercept[e + i] = found.state[i] - data.spring[i] * u[r, 1]
        after[:] = 0.0
        for j in range(states):
            after += found.by_state[i, j] * before[j]
        for d in range(size):
            after -= found.by_travel[i, d] * w[a + d]
        if row >= 0:
            after += found.by_limit0[i] * slope * w[row]
        tangent.state_own[e + i] = found.by_travel[i, data.direction[i]] - data.spring[i]
        tangent.state_cross[e + i] = found.by_travel[i, size - 1 - data.direction[i]]
        tangent.state_normal[e + i] = found.by_limit[i] * slope
    for d in range(size):
        r, o = a + d, size - 1 - d
        own, cross, by_limit = found.direct_by_u[d, d] - data.kt[d], found.direct_by_u[d, o], found.direct_by_limit[d]
        kept[r] = 0.0
        for i in range(states):
            weight = traction_by_state(data, found, d, i)
            own += weight * found.by_travel[i, d]
            cross += weight * found.by_travel[i, o]
            by_limit += weight * found.by_limit[i]
            kept[r] += weight * memory[e + i]
        tangent.own[r], tangent.own_rate[r], tangent.normal[r] = own, found.direct_by_velocity[d, d], by_limit * slope
        if table.partner_row[r] >= 0:
            tangent.cross[r], tangent.cross_rate[r] = cross, found.direct_by_velocity[d, o]


@inner
def remember_states(table: ContactTable, c: int, w: Array, memory: Array, tangent: Tangent) -> None:
    """Add to the intercepts (elements, columns) of contact c what the motion after a step (rows, columns) does."""
    for r in range(table.first_row[c], table.first_row[c + 1]):
        for e in range(table.friction_first[r], table.friction_first[r + 1]):
            memory[e] += tangent.state_own[e] * w[r]
            if table.partner_row[r] >= 0:
                memory[e] += tangent.state_cross[e] * w[table.partner_row[r]]
            if table.loading_row[r] >= 0:
                memory[e] += tangent.state_normal[e] * w[table.loading_row[r]]


@inner
def landing_rates(table: ContactTable, c: int, u: Array, v: Array, h: float, rates: Array, state_rates: Array) -> None:
    """dT/dt (rows,) and the rates of the states (elements,) of contact c just after it lands with motion u and velocity v
    (rows,); h: a short time [s]."""
    a, data, row = table.first_row[c], contact_data(table, c), table.normal_row[c]
    size, states, e, now = data.kt.size, data.spring.size, table.friction_first[a], h * SOON
    limit, found, b = slip_limit(table, e, u[row] + now * v[row])[0], no_step(states, size), a + size
    motion = StepMotion(np.zeros(states), now * v[a:b], u[a:b] + now * v[a:b], v[a:b].copy(), 0.0, limit, now)
    take_step(data, motion, found)
    for d in range(size):
        rates[a + d] = traction(data, found, d) / now
    for i in range(states):
        state_rates[e + i] = found.state[i] / now


SERIES = 0.3
"""Norm of A h below which its exponential is summed as a series: the closed form would cancel."""

TERMS = 9


class Path(NamedTuple):
    """The contacts along a period, on instants t_0 .. t_K = t_0 + T, s.

    u, v (rows, K+1): motion and velocity [m/s]; state (K, elements): of every slider in each interval; moving (elements,): which
    of them ever leave the stuck state; intercept (K, elements): of laws with kernels of their own at t_0 and where else it is
    known, or NaN. used: the rows whose δλ is ever other than zero.
    """

    instants: Array
    u: Array
    v: Array
    state: Index
    moving: Index
    intercept: Array
    used: Index


@inner
def _block_step(A: Array, h: float, out: Array) -> None:
    """out (3, 2, 2): φ0 = exp(A h), h φ1, h φ2; φ1 = ∫ exp(A h (1 − s)) ds, φ2 = ∫ exp(A h (1 − s)) s ds over 0..1."""
    a, b, c, d = A[0, 0] * h, A[0, 1] * h, A[1, 0] * h, A[1, 1] * h
    if abs(a) + abs(b) + abs(c) + abs(d) < SERIES:
        # φ2 = Σ Z^k / (k + 2)!
        p, q, r, s, factor = 0.5, 0.0, 0.0, 0.5, 0.5
        za, zb, zc, zd = 1.0, 0.0, 0.0, 1.0
        for k in range(1, TERMS):
            factor /= k + 2.0
            za, zb, zc, zd = za * a + zb * c, za * b + zb * d, zc * a + zd * c, zc * b + zd * d
            p, q, r, s = p + factor * za, q + factor * zb, r + factor * zc, s + factor * zd
        p1, q1, r1, s1 = 1.0 + p * a + q * c, p * b + q * d, r * a + s * c, 1.0 + r * b + s * d
        out[0, 0, 0], out[0, 0, 1] = 1.0 + p1 * a + q1 * c, p1 * b + q1 * d
        out[0, 1, 0], out[0, 1, 1] = r1 * a + s1 * c, 1.0 + r1 * b + s1 * d
    else:
        half, gap = 0.5 * (a + d), 0.5 * (a - d)
        square = gap * gap + b * c
        root = np.sqrt(abs(square))
        if square < 0.0:
            even, odd = np.exp(half) * np.cos(root), np.exp(half) * np.sin(root) / root
        else:
            up, down = np.exp(half + root), np.exp(half - root)
            even, odd = 0.5 * (up + down), (0.5 * (up - down) / root if root > 1e-9 else np.exp(half))
        out[0, 0, 0], out[0, 0, 1] = even + odd * gap, odd * b
        out[0, 1, 0], out[0, 1, 1] = odd * c, even - odd * gap
        det = a * d - b * c
        ia, ib, ic, id_ = d / det, -b / det, -c / det, a / det
        e, f, g, k0 = out[0, 0, 0] - 1.0, out[0, 0, 1], out[0, 1, 0], out[0, 1, 1] - 1.0
        p1, q1, r1, s1 = ia * e + ib * g, ia * f + ib * k0, ic * e + id_ * g, ic * f + id_ * k0
        e, k0 = p1 - 1.0, s1 - 1.0
        p, q, r, s = ia * e + ib * r1, ia * q1 + ib * k0, ic * e + id_ * r1, ic * q1 + id_ * k0
    out[1, 0, 0], out[1, 0, 1], out[1, 1, 0], out[1, 1, 1] = h * p1, h * q1, h * r1, h * s1
    out[2, 0, 0], out[2, 0, 1], out[2, 1, 0], out[2, 1, 1] = h * p, h * q, h * r, h * s


@inner
def _advance(blocks: Array, force: Array, h: float, x: Array, begin: Array, end: Array) -> None:
    """Move the states x over a step without δλ; fill what δλ at its beginning and at its end takes from them (2b, used rows)."""
    step = np.empty((3, 2, 2))
    for b in range(blocks.shape[0]):
        _block_step(blocks[b], h, step)
        i, j = 2 * b, 2 * b + 1
        for r in range(begin.shape[1]):
            one, two = force[i, r], force[j, r]
            end[i, r], end[j, r] = step[2, 0, 0] * one + step[2, 0, 1] * two, step[2, 1, 0] * one + step[2, 1, 1] * two
            begin[i, r] = step[1, 0, 0] * one + step[1, 0, 1] * two - end[i, r]
            begin[j, r] = step[1, 1, 0] * one + step[1, 1, 1] * two - end[j, r]
        p, q, r_, s = step[0, 0, 0], step[0, 0, 1], step[0, 1, 0], step[0, 1, 1]
        for column in range(x.shape[1]):
            one, two = x[i, column], x[j, column]
            x[i, column], x[j, column] = p * one + q * two, r_ * one + s * two


@inner
def _slider_tangent(table: ContactTable, c: int, z: float, state: Index, tangent: Tangent) -> None:
    """δy by the motion of the rows of contact c, sliders and normal springs, in an interval; z: normal motion inside it."""
    row = table.normal_row[c]
    if row >= 0:
        tangent.own[row] = 0.0
        for k in range(table.normal_first[c], table.normal_first[c + 1]):
            if table.normal_stiffness[k] * z + table.normal_constant[k] <= 0.0:
                tangent.own[row] -= table.normal_stiffness[k]
    if table.kind[c] != SLIDERS:
        return
    for r in range(table.first_row[c], table.first_row[c + 1]):
        if r != row:
            tangent.own[r], tangent.normal[r] = 0.0, 0.0
            for e in range(table.friction_first[r], table.friction_first[r + 1]):
                if state[e] != STICK:
                    tangent.own[r] -= table.stiffness[e]
                if state[e] != STICK and state[e] != OPEN:
                    tangent.normal[r] += state[e] * slip_limit(table, e, z)[1]


@inner
def _add_row(total: Array, factor: float, values: Array) -> None:
    """total += factor values."""
    if factor != 0.0:
        for k in range(total.size):
            total[k] += factor * values[k]


@inner
def _balance(
    table: ContactTable,
    tangent: Tangent,
    compliance: Array,
    rate: Array,
    free: Array,
    free_rate: Array,
    kept: Array,
    forces: Array,
) -> None:
    """δλ = D δw + kept with δw = free − compliance δλ and δẇ = free_rate − rate δλ: fills forces (rows, columns)."""
    rows, columns = kept.shape
    # Whole tuples of arrays passed for every number would cost more than all else.
    own, normal, cross, own_rate, cross_rate = tangent.own, tangent.normal, tangent.cross, tangent.own_rate, tangent.cross_rate
    loading, partner = table.loading_row, table.partner_row
    active, count = np.zeros(rows, dtype=np.int64), 0
    for r in range(rows):
        if own[r] != 0.0 or normal[r] != 0.0 or cross[r] != 0.0 or own_rate[r] != 0.0 or cross_rate[r] != 0.0:
            active[count] = r
            count += 1
        forces[r] = kept[r]
    if count == 0:
        return
    matrix, right, whole = np.zeros((count, count)), np.empty((count, columns)), np.empty(rows)
    for i in range(count):
        r = active[i]
        whole[:] = 0.0
        right[i] = kept[r]
        for onto, motion, velocity in ((whole, compliance, rate), (right[i], free, free_rate)):
            _add_row(onto, own[r], motion[r])
            _add_row(onto, own_rate[r], velocity[r])
            if loading[r] >= 0:
                _add_row(onto, normal[r], motion[loading[r]])
            if partner[r] >= 0:
                _add_row(onto, cross[r], motion[partner[r]])
                _add_row(onto, cross_rate[r], velocity[partner[r]])
        for j in range(count):
            matrix[i, j] = whole[active[j]]
            whole[active[j]] = 0.0
        matrix[i, i] += 1.0
        for s in range(rows):
            _add_row(right[i], -whole[s], kept[s])
    solution = np.linalg.solve(matrix, right)
    for i in range(count):
        forces[active[i]] = solution[i]


@kernel
def period_map(table: ContactTable, modes: BlockModes, path: Path, columns: Index) -> Array:
    """The map of a perturbation over one period, square.

    Its states are those of the modes, then what `columns` name: δ of the intercept of friction element e, or, from the number of
    elements on, δy of the rows of laws with kernels of their own.
    """
    elements, rows, size = table.stiffness.size, modes.motion.shape[0], modes.force.shape[0]
    width = size + columns.size
    x, memory = np.zeros((size, width)), np.zeros((elements + rows, width))
    for i in range(size):
        x[i, i] = 1.0
    for i in range(columns.size):
        memory[columns[i], size + i] = 1.0
    kept, forces = np.zeros((rows, width)), np.zeros((rows, width))
    used, whole = path.used, np.zeros((rows, rows))
    begin, end, pushed = np.zeros((size, used.size)), np.zeros((size, used.size)), np.zeros((size, used.size))
    for i in range(used.size):
        pushed[:, i] = modes.force[:, used[i]]
    by_rate, free_rate, rated = np.zeros((rows, rows)), np.zeros((rows, width)), np.any(table.kind != SLIDERS)
    w, nothing = np.dot(modes.motion, x), np.zeros((rows, rows))
    of_rows = (np.zeros(rows), np.zeros(rows), np.zeros(rows), np.zeros(rows), np.zeros(rows))
    tangent = Tangent(*of_rows, np.zeros(elements), np.zeros(elements), np.zeros(elements))
    intercept = path.intercept[0].copy()
    for k in range(path.instants.size - 1):
        h = path.instants[k + 1] - path.instants[k]
        if k == 0 or _changed(table, path, k):
            _enter(table, path, k, w, memory, tangent, kept)
            _balance(table, tangent, modes.static, nothing, np.dot(modes.motion, x), free_rate, kept, forces)
            w = np.dot(modes.motion, x) - np.dot(modes.static, forces)
            _remember(table, path, k, w, memory)
        for c in range(table.kind.size):
            if table.kind[c] != SLIDERS:
                first, last = _elements_of(table, c)
                for e in range(first, last):
                    if path.intercept[k, e] == path.intercept[k, e]:
                        intercept[e] = path.intercept[k, e]
                inside = _inside(path, table.normal_row[c], k) if table.normal_row[c] >= 0 else 0.0
                u, v = path.u[:, k : k + 2], path.v[:, k : k + 2]
                law_tangent(table, c, u, v, h, inside, intercept, w, memory, kept, tangent)
        _advance(modes.blocks, pushed, h, x, begin, end)
        x -= np.dot(begin, rows_of(forces, used))
        free, part = np.dot(modes.motion, x), np.dot(modes.motion, end)
        whole[:] = modes.static
        for i in range(used.size):
            whole[:, used[i]] += part[:, i]
        if rated:
            free_rate, part = np.dot(modes.velocity, x), np.dot(modes.velocity, end)
            for i in range(used.size):
                by_rate[:, used[i]] = part[:, i]
        _balance(table, tangent, whole, by_rate, free, free_rate, kept, forces)
        x -= np.dot(end, rows_of(forces, used))
        w = free - np.dot(whole, forces)
        _remember(table, path, k, w, memory)
        for c in range(table.kind.size):
            if table.kind[c] != SLIDERS:
                remember_states(table, c, w, memory, tangent)
                for r in range(table.first_row[c], table.first_row[c + 1]):
                    if r != table.normal_row[c]:
                        memory[elements + r] = forces[r]
    result = np.empty((width, width))
    result[:size] = x
    for i in range(columns.size):
        result[size + i] = memory[columns[i]]
    return boxed(result)


@inner
def _elements_of(table: ContactTable, c: int) -> tuple[int, int]:
    """The first friction element of contact c, and that after its last."""
    return table.friction_first[table.first_row[c]], table.friction_first[table.first_row[c + 1]]


@inner
def _changed(table: ContactTable, path: Path, k: int) -> bool:
    """Whether any contact does in interval k what it did not in the one before."""
    for e in range(path.state.shape[1]):
        if path.state[k, e] != path.state[k - 1, e]:
            return True
    for c in range(table.normal_row.size):
        row = table.normal_row[c]
        if row >= 0:
            before, after = _inside(path, row, k - 1), _inside(path, row, k)
            for i in range(table.normal_first[c], table.normal_first[c + 1]):
                stiffness, constant = table.normal_stiffness[i], table.normal_constant[i]
                if (stiffness * before + constant > 0.0) != (stiffness * after + constant > 0.0):
                    return True
            for e in range(*_elements_of(table, c)):
                bends = table.bend_first[e] < table.bend_first[e + 1]
                if bends and slip_limit(table, e, before)[1] != slip_limit(table, e, after)[1]:
                    return True
    return False


@inner
def _inside(path: Path, row: int, k: int) -> float:
    """Normal motion in the middle of interval k, by the cubic through its ends."""
    h = path.instants[k + 1] - path.instants[k]
    return float(0.5 * (path.u[row, k] + path.u[row, k + 1]) + 0.125 * h * (path.v[row, k] - path.v[row, k + 1]))


@inner
def _enter(table: ContactTable, path: Path, k: int, w: Array, memory: Array, tangent: Tangent, kept: Array) -> None:
    """At the beginning of interval k: its tangent, and what stuck sliders and laws keep; of one that lands and sticks, when."""
    elements = table.stiffness.size
    for c in range(table.kind.size):
        row = table.normal_row[c]
        z = _inside(path, row, k) if row >= 0 else 0.0
        _slider_tangent(table, c, z, path.state[k], tangent)
        if table.kind[c] != SLIDERS and row >= 0 and k > 0:
            _meet(table, path, c, k, w, memory)
        for r in range(table.first_row[c], table.first_row[c + 1]):
            if r == row:
                continue
            kept[r] = memory[elements + r]
            if table.kind[c] != SLIDERS:
                tangent.own[r] = tangent.normal[r] = tangent.cross[r] = tangent.own_rate[r] = tangent.cross_rate[r] = 0.0
                continue
            for e in range(table.friction_first[r], table.friction_first[r + 1]):
                if path.state[k, e] == STICK and path.moving[e] == 1:
                    if path.state[k - 1, e] == OPEN:
                        speed = path.v[row, k]
                        if speed != 0.0:
                            memory[e] += table.stiffness[e] * path.v[r, k] / speed * w[row]
                    kept[r] += memory[e]


@inner
def _meet(table: ContactTable, path: Path, c: int, k: int, w: Array, memory: Array) -> None:
    """δy and intercepts of contact c, of a law with its own kernels, where it lands or lifts off at the beginning of interval k.

    Open, T = 0 and δy = −kt δu. Landing, T = s (t − t*) with δt* = −δz/ż, so that δy = s δz/ż − kt δu. States likewise.
    """
    row, a, elements = table.normal_row[c], table.first_row[c], table.stiffness.size
    e = table.friction_first[a]
    if table.friction_first[row] == e:
        return
    before, after = slip_limit(table, e, _inside(path, row, k - 1))[0], slip_limit(table, e, _inside(path, row, k))[0]
    if (before > 0.0) == (after > 0.0):
        return
    rates, state_rates, speed = np.zeros(path.u.shape[0]), np.zeros(elements), path.v[row, k]
    if after > 0.0 and speed != 0.0:
        h = path.instants[k + 1] - path.instants[k]
        landing_rates(table, c, path.u[:, k], path.v[:, k], h, rates, state_rates)
    for r in range(a, row):
        memory[elements + r] = rates[r] / speed * w[row] if rates[r] != 0.0 else 0.0 * w[row]
        for e in range(table.friction_first[r], table.friction_first[r + 1]):
            memory[e] = -table.stiffness[e] * w[r]
            memory[elements + r] -= table.stiffness[e] * w[r]
            if state_rates[e] != 0.0:
                memory[e] += state_rates[e] / speed * w[row]


@inner
def _remember(table: ContactTable, path: Path, k: int, w: Array, memory: Array) -> None:
    """δy of the sliders that slip or are open in interval k."""
    for c in range(table.kind.size):
        if table.kind[c] != SLIDERS:
            continue
        row = table.normal_row[c]
        z = _inside(path, row, k) if row >= 0 else 0.0
        for r in range(table.first_row[c], table.first_row[c + 1]):
            if r == row:
                continue
            for e in range(table.friction_first[r], table.friction_first[r + 1]):
                state = path.state[k, e]
                if state == STICK:
                    continue
                memory[e] = -table.stiffness[e] * w[r]
                if state != OPEN and row >= 0:
                    memory[e] += state * slip_limit(table, e, z)[1] * w[row]
