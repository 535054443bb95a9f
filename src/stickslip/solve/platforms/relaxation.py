"""A damper between platforms by relaxation: a second method independent of `platform_march` and about ten times faster.

At every position of the platform the damper moves by the stuck compliance times what is out of balance, again and again, until
nothing is. Where the damper snaps, it arrives as well. The scheme of identifications.

The sweeps decide who sticks, slips and is open. Where that stays and the imbalance falls, the rest is linear and is solved at
once: a foot that carries next to nothing would take ten thousands of sweeps. Where it stays and the imbalance does not fall, no
balance exists in these states; the damper is on its way to others (it rolls on two slipping lines), and goes there in one leap.
"""

from typing import NamedTuple

import numpy as np

from stickslip.model.contact.law import SLIDERS
from stickslip.model.contact.point import ContactTable
from stickslip.model.dampers.between_platforms import BetweenPlatforms
from stickslip.solve.platforms.cycle import CycleModel, CycleOutcome, Marching, steady_cycle
from stickslip.solve.time.contact_law import solve_in_place
from stickslip.support.checks import Array, Index, fault
from stickslip.support.kernels import inner, kernel

TOLERANCE = 1e-9
"""Force and moment out of balance, relative to the pull."""

SWEEPS = 2000
"""Over all contacts in one step before Newton's method takes over."""

LOOK = 4
"""Sweeps after which the states of the elements are looked at: whether all are the same as so many sweeps before."""

SLOW = 1e-3
"""Share by which the imbalance falls in so many sweeps below which it does not fall."""

OPEN, STUCK, UP, DOWN = 0, 1, 2, 3
"""States of an element; slipping at its upper or its lower limit."""

REPEATS = 1e-5
"""Change of the forces from cycle to cycle, relative to the pull, at which a cycle counts as steady."""

CYCLES = 40
"""The most cycles until one repeats; of contact parameters in the whole range of a search one in a hundred take more than ten."""

LEAD_IN = 30
"""Steps in which the platforms go from rest to the start of the cycle."""

ARM = 1e-2
"""Distance [m] over which moments are judged."""


class Elements(NamedTuple):
    """Lines of contact and their elements: arm, tangent, normal (lines, 2); side 1 for left (moving), 0 for right; for every
    element its line, kn, constant c (N = max(kn z + c, 0)), kt, and mu of its load. The slip limit is mu (N + Σ change max(N −
    bend, 0)), with the same bends [N] (bends,) for all elements; none where the coefficient of friction is constant."""

    arm: Array
    tangent: Array
    normal: Array
    moving: Array
    line: Index
    kn: Array
    constant: Array
    kt: Array
    mu: Array
    bend: Array = np.zeros(0)
    change: Array = np.zeros(0)


def elements_of(rig: BetweenPlatforms) -> Elements:
    """The elements of laws whose sliders each follow the load of one spring (macroslip, microslip array)."""
    rows: list[tuple[float, ...]] = []
    for index, (point, law) in enumerate(zip(rig.points, rig.laws, strict=True)):
        table = law.elements(1, True)
        friction, springs = table.friction[0], table.normal
        paired = (
            not law.kernels()
            and springs is not None
            and np.all(friction.last - friction.first == 1)
            and not np.any(friction.constant_limit)
        )
        if springs is None or not paired or friction.stiffness.size != springs.stiffness.size:
            raise fault(f"The law of {point.name}", "must pair each slider with a normal spring", type(law).__name__)
        if friction.bend.size:
            rule, given = "must be a number, the coefficient at the mean load", "a table over the normal load"
            remedy = "Add `tenfold` to `unknown` to identify how the coefficients change with the load."
            raise fault(f"mu of {point.name}", rule, given, remedy)
        columns = (springs.stiffness, springs.constant, friction.stiffness, friction.friction)
        rows += [(index, *values) for values in zip(*columns, strict=True)]
    values, points = np.array(rows, dtype=float), rig.points
    return Elements(
        np.array([p.arm for p in points]),
        np.array([p.tangent for p in points]),
        np.array([p.normal for p in points]),
        np.array([1.0 if p.side == "left" else 0.0 for p in points]),
        np.asarray(values[:, 0], dtype=np.int64),
        *(np.ascontiguousarray(values[:, k]) for k in range(1, 5)),
    )


class Balance(NamedTuple):
    """Of one position: slider tensions, their change by the load where they slip, and states (elements,); the sum on the damper
    (3,), force on the right platform (2,)."""

    tension: Array
    slope: Array
    state: Index
    total: Array
    on_right: Array


@inner
def _out_of_balance(e: Elements, pull: float, q: Array, x: float, y: float, anchor: Array, now: Balance) -> float:
    """Fill the balance at the damper's position q (3,); returns force and moment out of balance [N]."""
    now.total[:], now.on_right[:] = 0.0, 0.0
    for k in range(e.line.size):
        c = e.line[k]
        ax, ay = e.arm[c, 0], e.arm[c, 1]
        dx = e.moving[c] * x - q[0] + q[2] * ay
        dy = e.moving[c] * y - q[1] - q[2] * ax
        load = max(e.kn[k] * (e.normal[c, 0] * dx + e.normal[c, 1] * dy) + e.constant[k], 0.0)
        line, slope = load, 1.0
        for b in range(e.bend.size):
            if load <= e.bend[b]:
                break
            line += e.change[b] * (load - e.bend[b])
            slope += e.change[b]
        limit, now.slope[k] = e.mu[k] * line, e.mu[k] * slope
        trial = e.kt[k] * (e.tangent[c, 0] * dx + e.tangent[c, 1] * dy - anchor[k])
        now.state[k] = OPEN if load == 0.0 else (UP if trial > limit else (DOWN if trial < -limit else STUCK))
        now.tension[k] = min(max(trial, -limit), limit)
        fx = now.tension[k] * e.tangent[c, 0] + load * e.normal[c, 0]
        fy = now.tension[k] * e.tangent[c, 1] + load * e.normal[c, 1]
        now.total[0] += fx
        now.total[1] += fy
        now.total[2] += ax * fy - ay * fx
        if e.moving[c] == 0.0:
            now.on_right[0] -= fx
            now.on_right[1] -= fy
    now.total[1] += pull
    return float(abs(now.total[0]) + abs(now.total[1]) + abs(now.total[2]) / ARM)


@inner
def _rest(e: Elements, now: Balance, matrix: Array, change: Array) -> bool:
    """The change of the damper's position (3,) that balances it while every element stays in its state; False without one."""
    matrix[:], change[:] = 0.0, now.total
    change[2] /= ARM
    t, n = np.empty(3), np.empty(3)
    for k in range(e.line.size):
        if now.state[k] == OPEN:
            continue
        c = e.line[k]
        t[:2], n[:2] = e.tangent[c], e.normal[c]
        t[2] = (e.arm[c, 0] * t[1] - e.arm[c, 1] * t[0]) / ARM
        n[2] = (e.arm[c, 0] * n[1] - e.arm[c, 1] * n[0]) / ARM
        slip = 0.0 if now.state[k] == STUCK else (now.slope[k] if now.state[k] == UP else -now.slope[k])
        hold = e.kt[k] if now.state[k] == STUCK else 0.0
        for i in range(3):
            for j in range(3):
                matrix[i, j] += hold * t[i] * t[j] + e.kn[k] * (n[i] + slip * t[i]) * n[j]
    largest = np.abs(matrix).max()
    if largest == 0.0:
        return False
    matrix /= largest
    change /= largest
    if not solve_in_place(matrix, change):
        return False
    change[2] /= ARM
    return True


@inner
def _leap(
    e: Elements, pull: float, q: Array, x: float, y: float, anchor: Array, step: Array, states: Index, now: Balance
) -> None:
    """Move the damper (q) on along a sweep's step as far as every element stays in its state, to within the step."""
    length, growing = 1.0, True
    for _ in range(100):
        q += length * step
        _out_of_balance(e, pull, q, x, y, anchor, now)
        if not np.all(states == now.state):
            q -= length * step
            growing = False
        length *= 2.0 if growing else 0.5
        if length < 1.0:
            break


@kernel
def carry(e: Elements, compliance: Array, pull: float, path: Array, q: Array, anchor: Array, shown: Array) -> int:
    """Carry the damper along a path (steps, 2); fills (steps, 5): force on the right platform, x, y, rotation of the damper.
    q (3,) and the sliders' anchors are changed in place. Returns 1 where a step finds no balance."""
    size = e.line.size
    now = Balance(np.zeros(size), np.zeros(size), np.zeros(size, dtype=np.int64), np.zeros(3), np.zeros(2))
    states, matrix, change, kept = np.zeros(size, dtype=np.int64), np.zeros((3, 3)), np.zeros(3), np.zeros(3)
    for n in range(path.shape[0]):
        x, y = path[n, 0], path[n, 1]
        balanced, seen = False, np.inf
        for sweep in range(SWEEPS):
            left = _out_of_balance(e, pull, q, x, y, anchor, now)
            if left <= TOLERANCE * pull:
                balanced = True
                break
            if sweep % LOOK == LOOK - 1:
                same = np.all(states == now.state)
                if same and left < seen and _rest(e, now, matrix, change):
                    kept[:] = q
                    q += change
                    if _out_of_balance(e, pull, q, x, y, anchor, now) <= TOLERANCE * pull:
                        balanced = True
                        break
                    q[:] = kept
                    left = _out_of_balance(e, pull, q, x, y, anchor, now)
                if same and left > (1.0 - SLOW) * seen:
                    change[:] = compliance @ now.total
                    _leap(e, pull, q, x, y, anchor, change, states, now)
                    left = _out_of_balance(e, pull, q, x, y, anchor, now)
                states[:], seen = now.state, left
            for i in range(3):
                q[i] += compliance[i, 0] * now.total[0] + compliance[i, 1] * now.total[1] + compliance[i, 2] * now.total[2]
        if not balanced:
            return 1
        for k in range(size):
            c = e.line[k]
            dx = e.moving[c] * x - q[0] + q[2] * e.arm[c, 1]
            dy = e.moving[c] * y - q[1] - q[2] * e.arm[c, 0]
            anchor[k] = e.tangent[c, 0] * dx + e.tangent[c, 1] * dy - now.tension[k] / e.kt[k]
        shown[n, 0], shown[n, 1] = now.on_right[0], now.on_right[1]
        shown[n, 2], shown[n, 3], shown[n, 4] = q[0], q[1], q[2]
    return 0


@kernel
def _settle(e: Elements, compliance: Array, pull: float, lead: Array, path: Array, cycles: int, shown: Array) -> int:
    """Lead in, then cycles until the forces repeat: 0 where they do, 1 where a step finds no balance, 2 where they never do."""
    q, anchor, before = np.zeros(3), np.zeros(e.line.size), np.zeros((path.shape[0], 2))
    if carry(e, compliance, pull, lead, q, anchor, np.zeros((lead.shape[0], 5))):
        return 1
    for _ in range(cycles):
        if carry(e, compliance, pull, path, q, anchor, shown):
            return 1
        if np.abs(shown[:, :2] - before).max() <= REPEATS * pull:
            return 0
        before[:] = shown[:, :2]
    return 2


def relaxed_cycle(e: Elements, pull: float, platform: Array, cycles: int = CYCLES) -> Array | None:
    """The steady cycle under platform motion (steps, 2) [m] from virgin sliders, the pull [N] laid on first: (steps, 5) with the
    force on the right platform [N] and the damper's x, y [m] and rotation [rad].

    Where a step finds no balance (a foot that just lifts off), Newton's march takes over. None where no cycle repeats.
    """
    lead = np.outer(np.linspace(0.0, 1.0, LEAD_IN), platform[0])
    path, shown = np.ascontiguousarray(platform), np.zeros((platform.shape[0], 5))
    ended = _settle(e, np.asarray(np.linalg.inv(stuck_stiffness(e))), pull, lead, path, cycles, shown)
    if ended == 1:
        return marched_cycle(e, pull, path, cycles)
    return shown if ended == 0 else None


def marched_cycle(e: Elements, pull: float, platform: Array, cycles: int = CYCLES) -> Array | None:
    """The same cycle by Newton's march (`platform_march`): slower near lift-off, and it arrives."""
    model = _as_model(e, pull)
    march = steady_cycle(model, platform, Marching(REPEATS, cycles))
    if march.outcome != CycleOutcome.STEADY:
        return None
    return np.concatenate([-march.record.force @ model.right, march.record.motion], axis=1)


def _rigid(e: Elements) -> Array:
    """(lines, 2, 3): motion along tangent and normal of each line as the damper moves by x, y and turns."""
    turn = np.stack([-e.arm[:, 1], e.arm[:, 0]], axis=1)
    directions = np.stack([e.tangent, e.normal], axis=1)
    return np.concatenate([directions, np.einsum("cdi,ci->cd", directions, turn)[..., None]], axis=2)


def stuck_stiffness(e: Elements) -> Array:
    """(3, 3): force and moment per motion of the damper while everything sticks."""
    stiffness = np.stack([np.bincount(e.line, k, e.moving.size) for k in (e.kt, e.kn)], axis=1)
    rigid = _rigid(e)
    return np.asarray(np.einsum("cd,cdi,cdj->ij", stiffness, rigid, rigid))


def _as_model(e: Elements, pull: float) -> CycleModel:
    """The damper as `steady_cycle` takes it: rows t, n of every line; each slider is loaded by the normal spring beside it."""
    lines, first = e.moving.size, np.searchsorted(e.line, np.arange(e.moving.size + 1))
    ends = np.repeat(first, 2)
    number, zero = np.arange(e.line.size), np.zeros(e.line.size)
    table = ContactTable(
        first_row=2 * np.arange(lines + 1),
        normal_row=2 * np.arange(lines) + 1,
        normal_first=first,
        normal_stiffness=e.kn,
        normal_constant=e.constant,
        friction_first=ends[1:],
        stiffness=e.kt,
        friction=e.mu,
        constant_limit=zero,
        load_first=number,
        load_last=number + 1,
        bend_first=e.bend.size * np.arange(number.size + 1),
        bend=np.outer(e.mu, e.bend).ravel(),
        change=np.tile(e.change, number.size),
        start_kind=0 * number,
        start_value=zero,
        kind=np.full(lines, SLIDERS),
        parameter_first=np.zeros(lines + 1, dtype=np.int64),
        parameter=np.zeros(0),
        loading_row=np.stack([2 * np.arange(lines) + 1, np.full(lines, -1)], axis=1).ravel(),
        partner_row=np.full(2 * lines, -1),
    )
    length = float(np.mean(np.hypot(e.arm[:, 0], e.arm[:, 1])))
    B, sides = -_rigid(e).reshape(-1, 3) / np.array([1.0, 1.0, length]), np.repeat(e.moving, 2)[:, None]
    platforms = np.stack([e.tangent, e.normal], axis=1).reshape(-1, 2)
    none = np.zeros((3, 3))
    load = np.array([0.0, pull, 0.0])
    return CycleModel(table, B, sides * platforms, (1.0 - sides) * platforms, (none, none, none), load, length)
