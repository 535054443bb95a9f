"""A damper between platforms by relaxation: a second scheme, which shares nothing with `platform_march` and is ten times faster.

At every position of the platform the damper moves by the stuck compliance times what is out of balance, again and again, until
nothing is. No derivatives and no Newton: where the damper snaps, it arrives as well. The scheme of identifications.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from stickslip.checks import Array, Index, fault
from stickslip.dampers.between_platforms import BetweenPlatforms
from stickslip.kernels import kernel

TOLERANCE = 1e-9
"""Force and moment out of balance, relative to the pull."""

SWEEPS = 2000

REPEATS = 1e-5
"""Change of the forces from cycle to cycle, relative to the pull, at which a cycle counts as steady."""

LEAD_IN = 30
"""Steps in which the platforms go from rest to the start of the cycle."""

ARM = 1e-2
"""Distance [m] over which moments are judged."""


class Elements(NamedTuple):
    """Lines of contact and their elements: arm, tangent, normal (lines, 2); side 1 for left (moving), 0 for right; for every
    element its line, kn, constant c (N = max(kn z + c, 0)), kt, and mu of its load or of the line's."""

    arm: Array
    tangent: Array
    normal: Array
    moving: Array
    line: Index
    kn: Array
    constant: Array
    kt: Array
    mu: Array


def elements_of(rig: BetweenPlatforms) -> Elements:
    """The elements of laws whose sliders each follow the load of one spring (macroslip, microslip array)."""
    rows: list[tuple[float, ...]] = []
    for index, (point, law) in enumerate(zip(rig.points, rig.laws, strict=True)):
        table = law.elements(1, True)
        friction, springs = table.friction[0], table.normal
        paired = springs is not None and np.all(friction.last - friction.first == 1) and not np.any(friction.constant_limit)
        if springs is None or not paired or friction.stiffness.size != springs.stiffness.size:
            raise fault(f"The law of {point.name}", "must pair each slider with a normal spring", type(law).__name__)
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


@kernel
def _forces(e: Elements, q: Array, x: float, y: float, anchor: Array, tension: Array, total: Array, on_right: Array) -> None:
    """Fill slider tensions (elements,), the sum on the damper (3,), and the force on the right platform (2,)."""
    total[:], on_right[:] = 0.0, 0.0
    for k in range(e.line.size):
        c = e.line[k]
        ax, ay = e.arm[c, 0], e.arm[c, 1]
        dx = e.moving[c] * x - q[0] + q[2] * ay
        dy = e.moving[c] * y - q[1] - q[2] * ax
        load = max(e.kn[k] * (e.normal[c, 0] * dx + e.normal[c, 1] * dy) + e.constant[k], 0.0)
        limit = e.mu[k] * load
        tension[k] = min(max(e.kt[k] * (e.tangent[c, 0] * dx + e.tangent[c, 1] * dy - anchor[k]), -limit), limit)
        fx = tension[k] * e.tangent[c, 0] + load * e.normal[c, 0]
        fy = tension[k] * e.tangent[c, 1] + load * e.normal[c, 1]
        total[0] += fx
        total[1] += fy
        total[2] += ax * fy - ay * fx
        if e.moving[c] == 0.0:
            on_right[0] -= fx
            on_right[1] -= fy


@kernel
def carry(e: Elements, compliance: Array, pull: float, path: Array, q: Array, anchor: Array, shown: Array) -> int:
    """Carry the damper along a path (steps, 2); fills (steps, 5): force on the right platform, x, y, rotation of the damper.
    q (3,) and the sliders' anchors are changed in place. Returns 1 where a step finds no balance."""
    total, on_right, tension = np.zeros(3), np.zeros(2), np.zeros(e.line.size)
    for n in range(path.shape[0]):
        x, y = path[n, 0], path[n, 1]
        balanced = False
        for _ in range(SWEEPS):
            _forces(e, q, x, y, anchor, tension, total, on_right)
            total[1] += pull
            if abs(total[0]) + abs(total[1]) + abs(total[2]) / ARM <= TOLERANCE * pull:
                balanced = True
                break
            for i in range(3):
                q[i] += compliance[i, 0] * total[0] + compliance[i, 1] * total[1] + compliance[i, 2] * total[2]
        if not balanced:
            return 1
        for k in range(e.line.size):
            c = e.line[k]
            dx = e.moving[c] * x - q[0] + q[2] * e.arm[c, 1]
            dy = e.moving[c] * y - q[1] - q[2] * e.arm[c, 0]
            anchor[k] = e.tangent[c, 0] * dx + e.tangent[c, 1] * dy - tension[k] / e.kt[k]
        shown[n, 0], shown[n, 1] = on_right[0], on_right[1]
        shown[n, 2], shown[n, 3], shown[n, 4] = q[0], q[1], q[2]
    return 0


def relaxed_cycle(e: Elements, pull: float, platform: Array, cycles: int = 8) -> Array | None:
    """The steady cycle under platform motion (steps, 2) [m] from virgin sliders, the pull [N] laid on first: (steps, 5) with the
    force on the right platform [N] and the damper's x, y [m] and rotation [rad]; None where a step finds no balance."""
    compliance, q, anchor = _stuck_compliance(e), np.zeros(3), np.zeros(e.line.size)
    lead = np.outer(np.linspace(0.0, 1.0, LEAD_IN), platform[0])
    path = np.ascontiguousarray(platform)
    shown, last = np.zeros((platform.shape[0], 5)), np.zeros((platform.shape[0], 5))
    if carry(e, compliance, pull, lead, q, anchor, np.zeros((LEAD_IN, 5))):
        return None
    for _ in range(cycles):
        if carry(e, compliance, pull, path, q, anchor, shown):
            return None
        if np.max(np.abs(shown[:, :2] - last[:, :2])) <= REPEATS * pull:
            break
        last[:] = shown
    return shown


def _stuck_compliance(e: Elements) -> Array:
    """(3, 3): motion of the damper per force and moment while everything sticks."""
    stiffness = np.zeros((3, 3))
    for k, c in enumerate(e.line):
        rigid = np.array([[1.0, 0.0, -e.arm[c, 1]], [0.0, 1.0, e.arm[c, 0]]])
        t, n = e.tangent[c] @ rigid, e.normal[c] @ rigid
        stiffness += e.kt[k] * np.outer(t, t) + e.kn[k] * np.outer(n, n)
    return np.asarray(np.linalg.inv(stiffness))
